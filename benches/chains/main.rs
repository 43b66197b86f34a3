//! Relaxation times of a column by event chains: `cargo bench --bench chains [SECONDS [WIDTH]] [ROW]`.
//!
//! SECONDS of CPU time are spent on each half of a row (default 2, in all about 100 s); WIDTH is
//! that of the square base (default 5, for 1000 spheres); only rows whose names contain ROW are
//! measured. The paper's column at temperature 20, N/A = 40. All times are CPU time of this thread.
//!
//! - `h_c`: two columns, equilibrated at a higher and a lower temperature, relax at T = 20. The
//!   relaxation time is the area under the difference of their centers of mass, divided by its
//!   initial value. In linear response this is the integrated autocorrelation time of `h_c`, at a
//!   fraction of the cost of measuring it in equilibrium. Beyond the last sweep the difference is
//!   extrapolated as an exponential.
//! - layer, bulk: integrated autocorrelation time of the number of spheres between 0.5 and 1, where
//!   structure is strongest, and between 20 and 20.5. The automatic window loses slow modes of
//!   small amplitude, so these are lower limits where `h_c` is slow.
//!
//! First the Newtonian chains, which are not in the library, are checked against exact results.

#![allow(clippy::print_stdout, clippy::needless_range_loop)]

mod newtonian;

use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, FieldEvent, LocalMoves, Moves};
use gradient_mc::start::Positions;
use gradient_mc::statistics::{Estimate, autocorrelation, blocking};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Scene, Simulation, Slab, Vector3};
use newtonian::{NewtonianColumn, Rule};
use paper::clock::cpu_seconds;

const TEMPERATURE: f64 = 20.0;
/// Where the columns come from.
const SIDES: [f64; 2] = [26.0, 15.0];
const COLUMN_DENSITY: f64 = 40.0;
const HEIGHT: f64 = 400.0;
/// Slope of the center of mass against T at T = 20, by Carnahan and Starling; T²/N times it is the
/// variance.
const SLOPE: f64 = 1.2434;
const LAYER: f64 = 1.0;
const BULK: f64 = 20.0;

type State = Vec<Vector3<f64>>;

/// A column that can be moved and looked at.
trait Column {
    /// One sweep, as its kind of moves has it.
    fn sweep(&mut self) -> Result<(), Error>;
    /// Mean height, and number of spheres in the lowest layer.
    fn look(&self) -> [f64; 3];
    /// Straight pieces, or trials, so far.
    fn events(&self) -> u64;
}

fn look(heights: impl ExactSizeIterator<Item = f64>) -> [f64; 3] {
    let count = heights.len() as f64;
    let (mut sum, mut layer, mut bulk) = (0.0, 0.0, 0.0);
    for height in heights {
        sum += height;
        layer += f64::from(u8::from(height < LAYER));
        bulk += f64::from(u8::from((BULK..BULK + 0.5).contains(&height)));
    }
    [sum / count, layer, bulk]
}

impl Column for Simulation<UniformField, Isothermal> {
    fn sweep(&mut self) -> Result<(), Error> {
        self.run(1, &mut ())
    }
    fn look(&self) -> [f64; 3] {
        look(self.frame().heights())
    }
    fn events(&self) -> u64 {
        self.move_counts().trials + self.move_counts().events
    }
}

impl Column for NewtonianColumn {
    fn sweep(&mut self) -> Result<(), Error> {
        self.run(EventChains::PATH_PER_SPHERE * self.len() as f64);
        Ok(())
    }
    fn look(&self) -> [f64; 3] {
        look((0..self.len()).map(|sphere| self.position(sphere)[0]))
    }
    fn events(&self) -> u64 {
        self.events
    }
}

/// What a row of the table is about.
#[derive(Debug, Clone, Copy)]
enum Method {
    Library(Moves),
    Newtonian { duration: f64, rule: Rule },
}

impl Method {
    fn column(
        self,
        scene: Scene<UniformField, Isothermal>,
        state: &State,
        seed: u64,
    ) -> Result<Box<dyn Column>, Error> {
        match self {
            Self::Library(moves) => {
                let builder = Simulation::builder(scene).start(Positions(state.clone()));
                let mut simulation = builder.moves(moves).seed(seed).build()?;
                // Tunes the length, if there is anything to tune.
                if !matches!(moves, Moves::Local(_)) {
                    simulation.equilibrate(4, &mut ())?;
                }
                Ok(Box::new(simulation))
            }
            Self::Newtonian { duration, rule } => {
                let [width_y, width_z] = scene.slab().widths();
                let extents = [scene.slab().height(), width_y, width_z];
                let temperature = scene.temperature();
                let temperature = gradient_mc::TemperatureProfile::temperature(temperature, 0.0);
                Ok(Box::new(NewtonianColumn::new(extents, temperature, duration, rule, state, seed)))
            }
        }
    }
}

fn scene(width: f64, temperature: f64) -> Result<Scene<UniformField, Isothermal>, Error> {
    let slab = Slab::new(HEIGHT, width, width)?;
    Scene::with_column_density(slab, COLUMN_DENSITY, UniformField::default(), Isothermal::new(temperature)?)
}

/// Independent states at a temperature.
fn prepare(width: f64, temperature: f64, count: usize, seed: u64) -> Result<Vec<State>, Error> {
    let builder = Simulation::builder(scene(width, temperature)?).moves(EventChains::default());
    let mut simulation = builder.seed(seed).build()?;
    simulation.equilibrate(1500, &mut ())?;
    (0..count)
        .map(|_| {
            simulation.run(700, &mut ())?;
            Ok(simulation.positions())
        })
        .collect()
}

/// Relaxation time and autocorrelation time, in CPU seconds, and million events per CPU second.
struct Row {
    relaxation: Estimate,
    layer: Option<Estimate>,
    bulk: Option<Estimate>,
    rate: f64,
}

/// Sweeps that take about `seconds`.
fn sweeps_in(column: &mut dyn Column, seconds: f64) -> Result<u64, Error> {
    let (start, mut sweeps) = (cpu_seconds(), 0_u32);
    while cpu_seconds() - start < 0.02 {
        column.sweep()?;
        sweeps += 1;
    }
    let each = (cpu_seconds() - start) / f64::from(sweeps);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    Ok((seconds / each).round().max(1.0) as u64)
}

/// The time τ of an exponential whose area up to `end` is `area`, both in units of one interval.
fn complete(area: f64, end: f64) -> f64 {
    let mut time = area;
    for _ in 0..200 {
        time = area / -libm::expm1(-end / time.max(1e-9));
        if time > 1e6 {
            return f64::INFINITY;
        }
    }
    time
}

fn measure(method: Method, width: f64, states: &[Vec<State>; 3], seconds: f64) -> Result<Row, Error> {
    let scene_here = scene(width, TEMPERATURE)?;
    let spread = TEMPERATURE * (SLOPE / scene_here.particles() as f64).sqrt();
    let mut trial = method.column(scene_here, &states[2][0], 1)?;
    let slice = sweeps_in(trial.as_mut(), 0.004)?;
    let (mut used, mut counted) = (0.0, 0);
    // Sums over replicas of the difference at every time.
    let (mut areas, mut firsts, mut lengths, mut replicas) = (0.0, 0.0, 0.0, 0_u32);
    'replicas: for (high, low) in states[0].iter().zip(&states[1]) {
        let seed = u64::from(replicas) + 10;
        let mut columns =
            [method.column(scene_here, high, seed)?, method.column(scene_here, low, seed + 1000)?];
        let difference = |columns: &[Box<dyn Column>; 2]| columns[0].look()[0] - columns[1].look()[0];
        let first = difference(&columns);
        let (mut area, mut before, mut length) = (0.0, first, 0.0);
        let events = columns[0].events() + columns[1].events();
        let start = cpu_seconds();
        loop {
            for column in &mut columns {
                for _ in 0..slice {
                    column.sweep()?;
                }
            }
            let now = difference(&columns);
            area += 0.5 * (before + now);
            before = now;
            length += 1.0;
            if length > 20.0 && length * first > 4.0 * area || cpu_seconds() - start > 4.0 * seconds {
                break;
            }
        }
        let spent = cpu_seconds() - start;
        used += spent;
        counted += columns[0].events() + columns[1].events() - events;
        (areas, firsts, lengths, replicas) = (areas + area, firsts + first, lengths + length, replicas + 1);
        if used > seconds {
            break 'replicas;
        }
    }
    let each = used / (2.0 * lengths);
    let end = lengths / f64::from(replicas);
    let time = complete(areas / firsts, end) * each;
    // Fluctuations of both columns, integrated over four times the relaxation time.
    let first = firsts / f64::from(replicas);
    let error = 4.0 * spread / first / f64::from(replicas).sqrt() * time;

    let mut column = method.column(scene_here, &states[2][0], 77)?;
    let fine = sweeps_in(column.as_mut(), 2e-4)?;
    let (start, mut series) = (cpu_seconds(), [Vec::new(), Vec::new()]);
    while cpu_seconds() - start < seconds {
        for _ in 0..fine {
            column.sweep()?;
        }
        let [_, layer, bulk] = column.look();
        series[0].push(layer);
        series[1].push(bulk);
    }
    let interval = (cpu_seconds() - start) / series[0].len() as f64;
    let [layer, bulk] = series.map(|series| {
        let found = autocorrelation(&series).ok()?;
        Some(Estimate::new(found.time.mean * interval, found.time.standard_error * interval))
    });
    Ok(Row { relaxation: Estimate::new(time, error), layer, bulk, rate: 1e-6 * counted as f64 / used })
}

/// One and two spheres, whose mean heights are known exactly.
fn check_newtonian() -> Result<(), Error> {
    for rule in [Rule::Relocate, Rule::Reflect] {
        for (spheres, temperature, exact) in [(1, 2.0, 2.5), (2, 1.0, 1.567_105_973_366_81)] {
            let state: State =
                (0..spheres).map(|i| Vector3::new(1.0 + 2.0 * f64::from(i), 1.0, 1.0)).collect();
            let mut column = NewtonianColumn::new([40.0, 3.0, 3.0], temperature, 3.0, rule, &state, 9);
            let mut heights = Vec::new();
            for _ in 0..400_000 {
                column.run(2.0);
                heights.push(column.look()[0]);
            }
            let found = blocking(&heights)?;
            let sigmas = found.deviation_from(exact);
            println!(
                "Newtonian {rule:?}, {spheres} sphere(s): <x> = {found}, exactly {exact:.4}: {sigmas:+.1} sigma"
            );
            assert!(sigmas.abs() < 4.0 && found.standard_error < 0.02);
        }
    }
    Ok(())
}

fn rows() -> Result<Vec<(String, Method)>, Error> {
    let mut rows =
        vec![("local moves, S = 0.75".to_string(), Method::Library(LocalMoves::new(0.75)?.into()))];
    for length in [10.0, 50.0, 200.0, 1000.0, 5000.0] {
        let moves = EventChains::with_length(length)?.field_event(FieldEvent::Relocate).local_moves(None);
        rows.push((format!("relocate, length {length}"), Method::Library(moves.into())));
    }
    for length in [10.0, 50.0, 200.0] {
        let moves = EventChains::with_length(length)?.field_event(FieldEvent::Reverse).local_moves(None);
        rows.push((format!("reverse, length {length}"), Method::Library(moves.into())));
    }
    for fraction in [0.5, 0.7, 0.8, 0.9] {
        let moves = EventChains::default().local_moves(None).vertical_fraction(fraction)?;
        rows.push((format!("relocate, tuned, vertical {fraction}"), Method::Library(moves.into())));
    }
    for displacement in [0.2, 0.5] {
        let local = LocalMoves::new(displacement)?;
        let moves = EventChains::default().local_moves(Some(local));
        rows.push((format!("relocate, tuned, and local, S = {displacement}"), Method::Library(moves.into())));
    }
    for (duration, rule) in [(100.0, Rule::Relocate), (1000.0, Rule::Relocate), (100.0, Rule::Reflect)] {
        rows.push((format!("Newtonian {rule:?}, duration {duration}"), Method::Newtonian { duration, rule }));
    }
    Ok(rows)
}

fn main() -> Result<(), Error> {
    // Cargo adds an option of its own.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|it| !it.starts_with('-')).collect();
    let numbers: Vec<f64> = arguments.iter().filter_map(|it| it.parse().ok()).collect();
    let only = arguments.iter().find(|it| it.parse::<f64>().is_err());
    let seconds = numbers.first().copied().unwrap_or(2.0);
    let width = numbers.get(1).copied().unwrap_or(5.0);
    check_newtonian()?;
    let start = cpu_seconds();
    let states = [
        prepare(width, SIDES[0], 24, 1)?,
        prepare(width, SIDES[1], 24, 2)?,
        prepare(width, TEMPERATURE, 1, 3)?,
    ];
    println!(
        "{} spheres, T = {TEMPERATURE}, N/A = {COLUMN_DENSITY}; prepared in {:.1} s",
        states[0][0].len(),
        cpu_seconds() - start
    );
    println!("{:<38} {:>14} {:>14} {:>14} {:>12}", "", "h_c, ms", "layer, ms", "bulk, ms", "M events/s");
    for (name, method) in rows()? {
        if only.as_ref().is_some_and(|only| !name.contains(only.as_str())) {
            continue;
        }
        let row = measure(method, width, &states, seconds)?;
        let text = |estimate: Estimate| (1e3 * estimate).to_string();
        let [layer, bulk] = [row.layer, row.bulk].map(|found| found.map_or("?".to_string(), text));
        println!("{name:<38} {:>14} {layer:>14} {bulk:>14} {:>12.2}", text(row.relaxation), row.rate);
    }
    Ok(())
}
