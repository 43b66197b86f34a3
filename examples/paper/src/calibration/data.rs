//! The rows of the calibration files.

/// Defines a row of numbers with its header.
macro_rules! row {
    ($(#[$documentation:meta])* $name:ident: $($field:ident),+) => {
        $(#[$documentation])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name {
            $(pub $field: f64),+
        }

        impl $name {
            pub const HEADER: [&'static str; [$(stringify!($field)),+].len()] = [$(stringify!($field)),+];

            pub fn values(&self) -> [f64; Self::HEADER.len()] {
                [$(self.$field),+]
            }

            pub fn of(values: &[f64]) -> Option<Self> {
                let [$($field),+] = *values else { return None };
                Some(Self { $($field),+ })
            }

            /// The rows of a file of this kind.
            pub fn read(path: &std::path::Path) -> Result<Vec<Self>, Box<dyn std::error::Error + Send + Sync>> {
                let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path)?;
                let mut rows = Vec::new();
                for record in reader.records() {
                    let values = record?.iter().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
                    rows.push(Self::of(&values).ok_or("a row has the wrong number of fields")?);
                }
                Ok(rows)
            }
        }
    };
}

row! {
    /// A column, and what ideal gas and theory between walls make of it; total variation distances, `layers` in spheres per area.
    ColumnRow: temperature, field_rate, decay_rate, column_density, height, packing_fraction, excluded_volume,
    ideal_error, theory_error, noise, layers, layers_error, bulk, bulk_noise, ideal_seconds, theory_seconds,
    start_seconds, reference_seconds
}

row! {
    /// A plan: root mean square of the total variation distance over seeds, the noise of what it was compared with, and what the error depends on.
    Plan: column, family, particles, sweeps, error, noise, spread, densest, extent, seconds
}

row! {
    /// A small base against a wide one.
    Base: column, side, particles, error, noise, excluded_volume
}

row! {
    /// How far the errors of single seeds of a long plan are apart: their standard deviation in units of their root mean square.
    Seeds: column, family, sweeps, error, scatter
}
