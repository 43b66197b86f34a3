//! Measuring bins: empty ones, thin ones, wide ones.

use crate::column::{self, theory};
use crate::map::{Findings, Map, Trial};
use crate::said::{self, Said};
use crate::verdict::Quantity;
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{Bins, DensityProfile, EquationOfStateProfile};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Every, Simulation};
use paper::Failure;

/// Above the layers.
const LOWEST: f64 = 6.5;
const TEMPERATURE: f64 = 5.0;

/// The width of measuring bins.
pub(crate) fn widths() -> Map {
    const WIDTHS: [f64; 7] = [0.003, 0.01, 0.03, 0.1, 0.5, 2.0, 10.0];
    let mut map =
        Map::new("measuring_bins", "Measuring bins: share of bins with a wrong error bar", "bin width / d");
    for width in WIDTHS {
        map.add("density", width, move |trial| density(width, trial));
        map.add("P/(nTZ)", width, move |trial| equation_of_state(width, trial));
    }
    map
}

fn observe<O: gradient_mc::Observer>(
    observer: impl FnOnce(&gradient_mc::Slab) -> Result<O, gradient_mc::Error>,
    trial: Trial,
) -> Result<(O, gradient_mc::HydrostaticProfile, Vec<Said>), Failure> {
    let temperature = Isothermal::new(TEMPERATURE)?;
    let scene = column::scene(120.0, 5.0, 40.0, UniformField::default(), temperature)?;
    let mut observer = Every::new(5, observer(scene.slab())?);
    let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(trial.seed).build()?;
    simulation.equilibrate(trial.sweeps(1500), &mut ())?;
    simulation.run(trial.sweeps(1500), &mut observer)?;
    Ok((observer.observer, theory(&scene)?, said::by(&simulation)))
}

/// Bins from the base to where a sphere in a thousand is above.
fn count(theory: f64, width: f64) -> (f64, usize) {
    let bins = ((theory - LOWEST) / width).floor().max(1.0);
    (LOWEST + bins * width, paper::study::count(bins))
}

/// Height above which there is a sphere in a hundred thousand.
const TOP: f64 = 86.5;

/// Of the bins that should agree with the theory, the share that disagrees or has no error bar.
fn share(deviations: impl ExactSizeIterator<Item = Estimate>) -> Quantity {
    let count = deviations.len() as f64;
    let bad = deviations.filter(|deviation| {
        // The uncertainty of the theory.
        let allowed = (4.0 * deviation.standard_error).max(0.01);
        // A bin without an error bar, or with too small a one.
        deviation.mean.is_nan() || deviation.standard_error.is_nan() || deviation.mean.abs() > allowed
    });
    let share = bad.count() as f64 / count;
    Quantity::absolute("share of wrong bins", Estimate::exact(share)).tolerating(0.03, 0.2)
}

fn density(width: f64, trial: Trial) -> Result<Findings, Failure> {
    let (top, bins) = count(TOP, width);
    let (profile, theory, mut said) =
        observe(|slab| DensityProfile::new(slab, Bins::count(bins).from(LOWEST).to(top)), trial)?;
    said.extend(Said::warnings(&profile.warnings()));
    let points = profile.points()?;
    let deviations = points.iter().map(|point| {
        let expected = theory.number_density(point.height);
        point.number_density / expected - 1.0
    });
    Ok(Findings { quantities: vec![share(deviations)], said, ..Findings::default() })
}

fn equation_of_state(width: f64, trial: Trial) -> Result<Findings, Failure> {
    let (top, bins) = count(TOP, width);
    let (profile, _, mut said) =
        observe(|slab| EquationOfStateProfile::new(slab, Bins::count(bins).from(LOWEST).to(top)), trial)?;
    said.extend(Said::warnings(&profile.warnings()));
    let points = profile.deviations_from(&ModifiedKolafa)?;
    let deviations = points.iter().map(|point| point.deviation);
    Ok(Findings { quantities: vec![share(deviations)], said, ..Findings::default() })
}
