//! The table of scenes: its format, and errors with line and column.

use crate::case::{Case, FieldChoice, TemperatureChoice};
use gradient_mc::Error;
use serde::Deserialize;
use serde::de::{self, Deserializer, SeqAccess, Visitor};
use std::collections::HashMap;
use std::fmt;
use std::ops::Range;
use toml::Spanned;

/// A valid table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Packing fractions at which Z is written.
    pub packing_fractions: Vec<f64>,
    /// The scenes, including every scene of a grid.
    pub cases: Vec<Case>,
}

/// One replica of one scene: the unit of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Task {
    /// Index of the scene in [`Table::cases`].
    pub case: usize,
    /// Number of the replica.
    pub replica: usize,
}

/// An error in a table, with its position.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {message}")]
pub struct BadTable {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Description of the error.
    pub message: String,
}

/// Largest number of tasks of a table.
const MOST_TASKS: usize = 1_000_000;
/// Largest number of sweeps of a replica.
const MOST_SWEEPS: u64 = 1_000_000_000_000;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(default)]
    packing_fractions: Vec<Spanned<f64>>,
    scene: Spanned<Vec<Spanned<Row>>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    name: Spanned<String>,
    height: Spanned<Finite>,
    base: Spanned<[Finite; 2]>,
    spheres: Spanned<usize>,
    field: Spanned<FieldRow>,
    temperature: Spanned<TemperatureRow>,
    seed: Spanned<u64>,
    replicas: Spanned<usize>,
    equilibration: Spanned<u64>,
    sweeps: Spanned<u64>,
    target_error: Option<Spanned<Finite>>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum FieldRow {
    Uniform(Values),
    Exponential(Values),
    Linear { base: Values, slope: Values },
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum TemperatureRow {
    Isothermal(Values),
    Exponential { base: Values, decay_rate: Values },
    Linear { base: Values, slope: Values },
}

impl FieldRow {
    fn choices(&self) -> Result<Vec<FieldChoice>, Wrong> {
        Ok(match self {
            Self::Uniform(values) => values.each(FieldChoice::Uniform)?,
            Self::Exponential(rates) => rates.each(FieldChoice::Exponential)?,
            Self::Linear { base, slope } => {
                base.by(slope, |base, slope| FieldChoice::Linear { base, slope })?
            }
        })
    }
}

impl TemperatureRow {
    fn choices(&self) -> Result<Vec<TemperatureChoice>, Wrong> {
        Ok(match self {
            Self::Isothermal(values) => values.each(TemperatureChoice::Isothermal)?,
            Self::Exponential { base, decay_rate } => {
                base.by(decay_rate, |base, decay_rate| TemperatureChoice::Exponential { base, decay_rate })?
            }
            Self::Linear { base, slope } => {
                base.by(slope, |base, slope| TemperatureChoice::Linear { base, slope })?
            }
        })
    }
}

/// A finite number.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "f64")]
struct Finite(f64);

impl TryFrom<f64> for Finite {
    type Error = String;
    fn try_from(value: f64) -> Result<Self, String> {
        if value.is_finite() { Ok(Self(value)) } else { Err(format!("{value} is not a finite number")) }
    }
}

/// A number, or a list of numbers for a grid of scenes.
#[derive(Debug)]
enum Values {
    One(f64),
    List(Vec<Spanned<f64>>),
}

impl Values {
    fn each<T>(&self, of: impl Fn(f64) -> T) -> Result<Vec<T>, Wrong> {
        match self {
            Self::One(value) => Ok(vec![of(*value)]),
            Self::List(values) => values.iter().map(|value| Ok(of(finite(value)?))).collect(),
        }
    }

    /// All pairs with the values of `other`, which change fastest.
    fn by<T>(&self, other: &Self, of: impl Fn(f64, f64) -> T) -> Result<Vec<T>, Wrong> {
        let pairs = self.each(|first| other.each(|second| of(first, second)))?;
        Ok(pairs.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
    }
}

fn finite(value: &Spanned<f64>) -> Result<f64, Wrong> {
    Finite::try_from(*value.get_ref()).map(|Finite(value)| value).map_err(|message| (value.span(), message))
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrMore;
        impl<'de> Visitor<'de> for OneOrMore {
            type Value = Values;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a number or a list of numbers")
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Values, E> {
                Finite::try_from(value).map(|Finite(value)| Values::One(value)).map_err(E::custom)
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Values, E> {
                self.visit_f64(value as f64)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Values, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                if values.is_empty() {
                    return Err(de::Error::custom("an empty list gives no scene"));
                }
                Ok(Values::List(values))
            }
        }
        deserializer.deserialize_any(OneOrMore)
    }
}

/// Position in the text, in bytes, and description of an error.
type Wrong = (Range<usize>, String);

impl Table {
    /// Reads a table and checks that every scene can be simulated.
    ///
    /// # Errors
    /// [`BadTable`] with the first error.
    pub fn read(text: &str) -> Result<Self, BadTable> {
        let read = toml::from_str::<Document>(text)
            .map_err(|error| (error.span().unwrap_or(0..0), error.message().to_owned()));
        read.and_then(Self::of).map_err(|(span, message)| {
            let before = &text[..span.start.min(text.len())];
            let (lines, last) = before.rsplit_once('\n').unwrap_or(("", before));
            let line = if before.contains('\n') { lines.matches('\n').count() + 2 } else { 1 };
            BadTable { line, column: last.chars().count() + 1, message }
        })
    }

    fn of(document: Document) -> Result<Self, Wrong> {
        let mut packing_fractions = Vec::new();
        for fraction in document.packing_fractions {
            let (span, value) = (fraction.span(), fraction.into_inner());
            if !(value > 0.0 && value < 1.0) {
                return Err((
                    span,
                    format!("a packing fraction of {value} is invalid: use one between 0 and 1"),
                ));
            }
            packing_fractions.push(value);
        }
        let (span, rows) = (document.scene.span(), document.scene.into_inner());
        if rows.is_empty() {
            return Err((span, "there is no scene".into()));
        }
        let (mut names, mut seeds) = (HashMap::new(), HashMap::new());
        let (mut cases, mut tasks) = (Vec::new(), 0_usize);
        for row in rows {
            let (span, row) = (row.span(), row.into_inner());
            if let Some(other) = names.insert(row.name.get_ref().clone(), row.name.get_ref().clone()) {
                return Err((row.name.span(), format!("the name {other:?} is used twice")));
            }
            let name = row.name.get_ref().clone();
            if let Some(other) = seeds.insert(*row.seed.get_ref(), name) {
                let seed = row.seed.get_ref();
                return Err((row.seed.span(), format!("the seed {seed} is that of scene {other:?}")));
            }
            let of_row = row.cases()?;
            tasks = of_row.iter().fold(tasks, |tasks, case| tasks.saturating_add(case.replicas));
            if tasks > MOST_TASKS {
                return Err((
                    span,
                    format!(
                        "there are more than {MOST_TASKS} runs up to this scene: use fewer replicas or smaller grids"
                    ),
                ));
            }
            cases.extend(of_row);
        }
        Ok(Self { packing_fractions, cases })
    }

    /// All tasks, ordered by scene.
    #[must_use]
    pub fn tasks(&self) -> Vec<Task> {
        let replicas =
            |(case, scene): (usize, &Case)| (0..scene.replicas).map(move |replica| Task { case, replica });
        self.cases.iter().enumerate().flat_map(replicas).collect()
    }
}

/// Fails if a number is not in a range.
fn require<T: PartialOrd + Copy + fmt::Display>(
    value: &Spanned<T>,
    [least, most]: [T; 2],
) -> Result<T, Wrong> {
    let number = *value.get_ref();
    if number >= least && number <= most {
        return Ok(number);
    }
    Err((value.span(), format!("{number} is invalid: use {least} to {most}")))
}

impl Row {
    /// The scenes of this entry.
    fn cases(&self) -> Result<Vec<Case>, Wrong> {
        let name = self.name.get_ref();
        let usable = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
        if name.is_empty() || name.len() > 100 || !name.chars().all(usable) {
            let message =
                format!("the name {name:?} is used in file names: use only letters, digits, - and _");
            return Err((self.name.span(), message));
        }
        let replicas = require(&self.replicas, [1, MOST_TASKS])?;
        let equilibration = require(&self.equilibration, [0, MOST_SWEEPS])?;
        let sweeps = require(&self.sweeps, [1, MOST_SWEEPS])?;
        let target_error = match &self.target_error {
            Some(target) if target.get_ref().0 <= 0.0 => {
                return Err((target.span(), "a target error must be positive".into()));
            }
            target => target.as_ref().map(|target| target.get_ref().0),
        };
        let [Finite(width), Finite(depth)] = *self.base.get_ref();
        let (fields, temperatures) = (self.field.get_ref().choices()?, self.temperature.get_ref().choices()?);
        let count = fields.len() * temperatures.len();
        let mut cases = Vec::new();
        for (parameter, (field, temperature)) in fields
            .iter()
            .flat_map(|field| temperatures.iter().map(move |temperature| (field, temperature)))
            .enumerate()
        {
            let case = Case {
                name: if count == 1 { name.clone() } else { format!("{name}.{parameter}") },
                height: self.height.get_ref().0,
                base: [width, depth],
                spheres: *self.spheres.get_ref(),
                field: *field,
                temperature: *temperature,
                seed: *self.seed.get_ref(),
                parameter,
                replicas,
                equilibration,
                sweeps,
                target_error,
            };
            case.scene().and_then(|scene| case.observers(&scene)).map_err(|error| {
                let message = if count == 1 { error.to_string() } else { format!("{}: {error}", case.name) };
                (self.span_of(&error), message)
            })?;
            cases.push(case);
        }
        Ok(cases)
    }

    /// Position in the text of the cause of an error of the library.
    fn span_of(&self, error: &Error) -> Range<usize> {
        match error {
            Error::SlabTooSmall { direction: 'y' | 'z', .. } => self.base.span(),
            Error::TooManyParticles { .. } => self.spheres.span(),
            Error::InvalidField { .. } | Error::InconsistentField { .. } => self.field.span(),
            Error::InvalidTemperature { .. } => self.temperature.span(),
            Error::InvalidParameter { name, .. } if name.contains("temperature") => self.temperature.span(),
            Error::InvalidParameter { name, .. } if name.contains("width") => self.base.span(),
            Error::InvalidParameter { name, .. } if name.contains("spheres") => self.spheres.span(),
            Error::InvalidParameter { name, .. } if name.contains("field") => self.field.span(),
            _ => self.height.span(),
        }
    }
}
