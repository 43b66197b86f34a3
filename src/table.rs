//! Profiles as CSV tables.

use crate::Error;
use crate::drive::{ForceBalance, ForceBalancePoint};
use crate::observers::{
    ChainPressurePoint, ChainPressureProfile, DensityPoint, DensityProfile, DeviationPoint,
    DisplacementPoint, DisplacementProfile, EquationOfStatePoint, EquationOfStateProfile, Layer,
    NeighborAnglePoint, NeighborAngles, PressurePoint, PressureProfile, RadialDistribution,
    RadialDistributionPoint, StructurePoint, StructureProfile,
};
use std::io::{self, Write};

/// A point of a profile as a row of a table. Needs the feature `csv`.
///
/// ```
/// use gradient_mc::{Row, WriteCsv};
/// struct Response { temperature: f64, height: f64 }
/// impl Row for Response {
///     const COLUMNS: &'static [[&'static str; 2]] = &[["temperature", "m g d"], ["height", "d"]];
///     fn cells(&self) -> Vec<f64> {
///         vec![self.temperature, self.height]
///     }
/// }
/// let mut table = Vec::new();
/// [Response { temperature: 5.0, height: 12.25 }].write_csv(&mut table)?;
/// assert_eq!(
///     String::from_utf8(table).unwrap(),
///     "# units: temperature in m g d, height in d\ntemperature,height\n5.0,12.25\n"
/// );
/// # Ok::<(), gradient_mc::Error>(())
/// ```
pub trait Row {
    /// Name and unit of every column. The name of a standard error ends in `_error`.
    const COLUMNS: &'static [[&'static str; 2]];

    /// The numbers of the row, one for each column.
    fn cells(&self) -> Vec<f64>;
}

/// Writes a profile as a CSV table. Needs the feature `csv`.
///
/// The first line begins with `#` and names the units. Then come the header and a row for each
/// point. Numbers read back as the same bits; missing values are `NaN`. Implemented by all
/// profiles, by slices of their points, and by slices of [`Layer`]s and [`DeviationPoint`]s.
///
/// ```
/// use gradient_mc::equation_of_state::ModifiedKolafa;
/// use gradient_mc::observers::{Bins, EquationOfStateProfile};
/// use gradient_mc::{Scene, Simulation, Slab, WriteCsv, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 72, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut profile = EquationOfStateProfile::new(&slab, Bins::of_width(1.0))?;
/// Simulation::builder(scene).build()?.run(64, &mut profile)?;
/// // Usually `File::create("profile.csv")?`; a vector of bytes here.
/// let mut table = Vec::new();
/// profile.write_csv(&mut table)?;
/// assert_eq!(String::from_utf8(table).unwrap().lines().count(), 2 + 60);
/// profile.deviations_from(&ModifiedKolafa)?.write_csv(std::io::sink())?;
/// # Ok::<(), gradient_mc::Error>(())
/// ```
pub trait WriteCsv {
    /// Writes the table to `writer`.
    ///
    /// # Errors
    /// [`Error::Write`] if the writer fails; [`Error::TooFewObservations`] for a profile with too
    /// few frames for standard errors.
    fn write_csv(&self, writer: impl Write) -> Result<(), Error>;
}

impl<R: Row> WriteCsv for [R] {
    fn write_csv(&self, writer: impl Write) -> Result<(), Error> {
        write_rows(self, writer).map_err(|source| Error::Write { source })
    }
}

fn write_rows<R: Row>(rows: &[R], mut writer: impl Write) -> io::Result<()> {
    let is_error = |name: &str| name.ends_with("_error");
    let units: Vec<String> = R::COLUMNS
        .iter()
        .filter(|[name, _]| !is_error(name))
        .map(|[name, unit]| format!("{name} in {unit}"))
        .collect();
    let errors = R::COLUMNS.iter().any(|[name, _]| is_error(name));
    let remark = if errors { "; errors are one standard error" } else { "" };
    writeln!(writer, "# units: {}{remark}", units.join(", "))?;
    let mut table = csv::Writer::from_writer(writer);
    table.write_record(R::COLUMNS.iter().map(|[name, _]| name))?;
    for row in rows {
        // The shortest text that reads back as the same number.
        table.write_record(row.cells().iter().map(|cell| format!("{cell:?}")))?;
    }
    table.flush()
}

/// Rows of the fields given: numbers, then estimates, each with its unit.
macro_rules! row {
    ($point:ty: $($number:ident $unit:literal),*; $($estimate:ident $estimate_unit:literal),*) => {
        impl Row for $point {
            const COLUMNS: &'static [[&'static str; 2]] = &[
                $([stringify!($number), $unit],)*
                $(
                    [stringify!($estimate), $estimate_unit],
                    [concat!(stringify!($estimate), "_error"), $estimate_unit],
                )*
            ];
            fn cells(&self) -> Vec<f64> {
                vec![$(self.$number,)* $(self.$estimate.mean, self.$estimate.standard_error),*]
            }
        }
    };
}
row!(DensityPoint: height "d"; number_density "1/d^3", packing_fraction "1");
row!(PressurePoint: height "d"; pressure "m g/d^2");
row!(EquationOfStatePoint: height "d", temperature "m g d"; number_density "1/d^3", packing_fraction "1",
    pressure "m g/d^2", compressibility_factor "1");
row!(DeviationPoint: height "d"; packing_fraction "1", deviation "1");
row!(ChainPressurePoint: height "d"; normal "m g/d^2", lateral "m g/d^2");
row!(DisplacementPoint: height "d"; mean_displacement "d", path_per_sweep "d", accepted_per_sweep "1");
row!(StructurePoint: height "d"; face_centered_cubic "1", hexagonal_close_packed "1", fluid "1", bond_order "1");
row!(RadialDistributionPoint: distance "d"; radial_distribution "1");
row!(NeighborAnglePoint: degrees "degrees"; angular_distribution "1");
row!(ForceBalancePoint: height "d", pressure "m g/d^2", load "1"; ratio "1");
row!(Layer: ; position "d", spacing "d", mean_height "d", width "d", lateral_density "1/d^2",
    maximum_density "1/d^3", minimum_density "1/d^3", visibility "1");

macro_rules! table {
    ($($profile:ty: $points:ident),+ $(,)?) => {$(
        impl WriteCsv for $profile {
            fn write_csv(&self, writer: impl Write) -> Result<(), Error> {
                self.$points()?.write_csv(writer)
            }
        }
    )+};
}
table! {
    DensityProfile: points,
    PressureProfile: points,
    EquationOfStateProfile: points,
    ChainPressureProfile: points,
    DisplacementProfile: points,
    StructureProfile: points,
    RadialDistribution: points,
    NeighborAngles: points,
    ForceBalance: ratios,
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Numbers([f64; 3]);
    impl Row for Numbers {
        const COLUMNS: &'static [[&'static str; 2]] =
            &[["height", "d"], ["density", "1/d^3"], ["density_error", "1/d^3"]];
        fn cells(&self) -> Vec<f64> {
            self.0.to_vec()
        }
    }

    #[test]
    fn numbers_read_back_as_the_same_bits() {
        let rows = [
            [1.0 / 3.0, 0.1 + 0.2, 5e-324],
            [-0.0, f64::MAX, f64::NAN],
            [1e-300, -1.234_567_890_123_456_7e15, f64::INFINITY],
        ];
        let mut bytes = Vec::new();
        rows.map(Numbers).write_csv(&mut bytes).unwrap();
        let text = std::str::from_utf8(&bytes).unwrap();
        let mut lines = text.lines();
        assert_eq!(
            lines.next(),
            Some("# units: height in d, density in 1/d^3; errors are one standard error")
        );
        assert_eq!(lines.next(), Some("height,density,density_error"));
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(&bytes[..]);
        let read: Vec<Vec<f64>> = reader
            .records()
            .map(|record| record.unwrap().iter().map(|cell| cell.parse().unwrap()).collect())
            .collect();
        assert_eq!(read.len(), rows.len());
        for (read, row) in read.iter().flatten().zip(rows.iter().flatten()) {
            assert!(read.to_bits() == row.to_bits() || (read.is_nan() && row.is_nan()), "{read} {row}");
        }
    }

    #[test]
    fn profiles_have_columns_with_errors_and_failures_are_typed() {
        let names: Vec<&str> = EquationOfStatePoint::COLUMNS.iter().map(|[name, _]| *name).collect();
        assert_eq!(names[..4], ["height", "temperature", "number_density", "number_density_error"]);
        assert_eq!((names.len(), Layer::COLUMNS.len()), (10, 16));
        let slab = crate::Slab::new(10.0, 5.0, 5.0).unwrap();
        let profile = DensityProfile::new(&slab, crate::observers::Bins::count(4)).unwrap();
        assert!(matches!(profile.write_csv(io::sink()), Err(Error::TooFewObservations { .. })));
        let mut full: [u8; 8] = [0; 8];
        let refused = [Numbers([0.0; 3])].write_csv(&mut full[..]);
        assert!(matches!(refused, Err(Error::Write { .. })), "{refused:?}");
    }
}
