//! The rows of the calibration files.

use crate::{Failure, output};
use std::path::Path;

/// Defines a row of numbers with its header.
macro_rules! row {
    ($(#[$documentation:meta])* $name:ident: $($field:ident),+) => {
        $(#[$documentation])*
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $name {
            $(pub $field: f64),+
        }

        impl $name {
            const HEADER: [&'static str; [$(stringify!($field)),+].len()] = [$(stringify!($field)),+];

            fn values(&self) -> [f64; Self::HEADER.len()] {
                [$(self.$field),+]
            }

            fn of(values: &[f64]) -> Option<Self> {
                let [$($field),+] = *values else { return None };
                Some(Self { $($field),+ })
            }

            fn read(path: &Path) -> Result<Vec<Self>, Failure> {
                let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path)?;
                let mut rows = Vec::new();
                for record in reader.records() {
                    let values = record?.iter().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
                    rows.push(Self::of(&values).ok_or("a row has the wrong number of fields")?);
                }
                Ok(rows)
            }

            fn write(path: &Path, units: &str, rows: &[Self]) -> Result<(), Failure> {
                let units = format!("cargo run --release -p paper --bin calibrate_models; {units}");
                output::write_csv(path, &units, &Self::HEADER.join(","), rows.iter().map(Self::values))
            }
        }
    };
}

row! {
    /// A column, and what ideal gas and theory between walls make of it; total variation distances, `layers` in spheres per area.
    ColumnRow: temperature, field_rate, decay_rate, column_density, height, packing_fraction, excluded_volume,
    ideal_error, theory_error, noise, layers, layers_error, bulk, bulk_noise
}

row! {
    /// A bin near the base: what the theory has too much of, and its error.
    LayerRow: column, bin, difference, error
}

row! {
    /// A plan in n, P or Z (0, 1, 2): root mean square of the error over seeds, the noise of what it was compared with, what the error depends
    /// on, and the standard deviation of single seeds in units of the root mean square, 0 if it was not measured.
    Plan: column, family, quantity, particles, sweeps, error, noise, spread, densest, extent, scatter
}

row! {
    /// Trials and events per sphere and sweep.
    Moves: column, family, densest, moves
}

row! {
    /// A small base against a wide one.
    Base: column, side, particles, error, noise, excluded_volume
}

row! {
    /// A formula (0 ideal gas, 1 theory between walls, 2 density functional) against a column, in n, P or Z (0, 1, 2): the error, and the noise of the column.
    Formula: column, quantity, formula, error, noise
}

/// Everything that was measured; columns count from 0.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub struct Data {
    pub columns: Vec<ColumnRow>,
    pub layers: Vec<LayerRow>,
    pub formulas: Vec<Formula>,
    pub plans: Vec<Plan>,
    pub moves: Vec<Moves>,
    pub bases: Vec<Base>,
}

impl Data {
    /// The files of a directory.
    pub fn read(directory: &Path) -> Result<Self, Failure> {
        Ok(Self {
            columns: ColumnRow::read(&directory.join("columns.csv"))?,
            layers: LayerRow::read(&directory.join("layers.csv"))?,
            formulas: Formula::read(&directory.join("formulas.csv"))?,
            plans: Plan::read(&directory.join("plans.csv"))?,
            moves: Moves::read(&directory.join("moves.csv"))?,
            bases: Base::read(&directory.join("bases.csv"))?,
        })
    }

    /// Writes them.
    pub fn write(&self, directory: &Path) -> Result<(), Failure> {
        let units = "m g d, per diameter, per square diameter, diameters; total variation distances; layers in spheres per square diameter";
        ColumnRow::write(&directory.join("columns.csv"), units, &self.columns)?;
        let units = "column: row of columns.csv from 0; diameters from the base; per cubic diameter";
        LayerRow::write(&directory.join("layers.csv"), units, &self.layers)?;
        let units = "column: row of columns.csv from 0; quantity: 0 n, 1 P, 2 Z; formula: 0 ideal gas, 1 theory between walls, 2 density functional";
        Formula::write(&directory.join("formulas.csv"), units, &self.formulas)?;
        let units = "column: row of columns.csv from 0; family: 0 tuned local moves, 1 event chains with them; quantity: 0 n, 1 P, 2 Z; diameters";
        Plan::write(&directory.join("plans.csv"), units, &self.plans)?;
        let units = "column: row of columns.csv from 0; family: 0 tuned local moves, 1 event chains with them; per sphere and sweep";
        Moves::write(&directory.join("moves.csv"), units, &self.moves)?;
        let units = "column: row of columns.csv from 0; diameters; total variation distances";
        Base::write(&directory.join("bases.csv"), units, &self.bases)
    }
}
