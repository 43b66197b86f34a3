//! The density functionals that studies compare, and a simulation of the layers.

use crate::Failure;
use gradient_mc::functional::{Functional, LayeredProfile, Lutsko, Rosenfeld, WhiteBear, WhiteBear2};
use gradient_mc::statistics::Estimate;

/// A functional with its names.
pub struct Named {
    pub name: &'static str,
    /// Name of its files.
    pub file: &'static str,
    pub functional: Box<dyn Functional>,
}

impl std::fmt::Debug for Named {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name)
    }
}

/// Index of White Bear II in [`all`].
pub const WHITE_BEAR_2: usize = 2;

/// All functionals.
pub fn all() -> Vec<Named> {
    vec![
        Named { name: "Rosenfeld", file: "rosenfeld", functional: Box::new(Rosenfeld) },
        Named { name: "White Bear", file: "white_bear", functional: Box::new(WhiteBear) },
        Named { name: "White Bear II", file: "white_bear_2", functional: Box::new(WhiteBear2) },
        Named { name: "Tarazona", file: "tarazona", functional: Box::new(Lutsko::TARAZONA) },
        Named { name: "Lutsko, stable", file: "lutsko_stable", functional: Box::new(Lutsko::STABLE) },
    ]
}

/// Bins of 0.1 d from 0.5 to 8 d.
pub const BASE_BINS: u32 = 75;

/// Middles of the bins at the base, and the mean density in each.
pub fn base_bins(profile: &LayeredProfile) -> impl Iterator<Item = (f64, f64)> + '_ {
    (0..BASE_BINS).map(|bin| {
        let [low, middle, high] = [0.0, 0.5, 1.0].map(|part| (5.0 + f64::from(bin) + part) / 10.0);
        (middle, profile.mean_density(low, high))
    })
}

/// n(x) at the base at T₀ = 5 by an independent Monte Carlo program (`tests/reference/README.md`),
/// in the lowest of these bins.
pub fn independent_base() -> Result<Vec<Estimate>, Failure> {
    let text = include_str!("../../../tests/reference/layers_T5_monte_carlo.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let mut bins = Vec::new();
    for record in reader.records() {
        let record = record?;
        let number = |column: usize| -> Result<f64, Failure> {
            Ok(record.get(column).ok_or("the reference has a short line")?.parse()?)
        };
        bins.push(Estimate::new(number(2)?, number(3)?));
    }
    Ok(bins)
}
