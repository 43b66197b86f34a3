//! Moves per CPU second of the homogeneous program and of the library, measured alternately, to
//! check that the comparison is fair.

use gradient_mc::equation_of_state::number_density;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Scene, Simulation, Slab};
use paper::Failure;
use paper::clock::cpu_seconds;
use paper::homogeneous::{Homogeneous, Technique};
use paper::table::Table;

const TURNS: usize = 5;

/// Million trials and million events per CPU second: of both at each packing fraction, homogeneous
/// before the library's.
#[derive(Debug)]
pub(crate) struct Pace(Vec<(f64, [f64; 4])>);

impl Pace {
    /// Events of the library over those of homogeneous chains, the geometric mean over packing
    /// fractions.
    pub(crate) fn chains(&self) -> f64 {
        let logarithms: f64 = self.0.iter().map(|(_, [.., own, library])| libm::log(library / own)).sum();
        libm::exp(logarithms / self.0.len() as f64)
    }

    pub(crate) fn table(&self) -> Table {
        let mut table = Table::new([
            "million per CPU second",
            "trials, homogeneous",
            "trials, library",
            "events, homogeneous",
            "events, library",
        ]);
        for (eta, rates) in &self.0 {
            table.row(&format!("packing fraction {eta}"), rates.map(|rate| format!("{rate:.1}")));
        }
        table
    }
}

/// Medians of turns.
pub(crate) fn measure(seed: u64) -> Result<Pace, Failure> {
    let mut all = Vec::new();
    for eta in [0.1, 0.25, 0.45] {
        let mut rates: [Vec<f64>; 4] = Default::default();
        let mut local = Homogeneous::new(4, eta, Technique::Local, seed);
        let mut chains = Homogeneous::new(4, eta, Technique::Chains, seed);
        local.equilibrate(200);
        chains.equilibrate(200);
        // The same density between walls, without weight, some 1000 spheres.
        let slab = Slab::new(20.0, 8.0, 8.0)?;
        let (field, temperature) = (UniformField::new(0.0)?, Isothermal::new(1.0)?);
        let scene = Scene::with_column_density(slab, 19.0 * number_density(eta), field, temperature)?;
        let displacement = local.displacement();
        let builder = || Simulation::builder(scene).seed(seed);
        let mut trials = builder().moves(LocalMoves::new(displacement)?).build()?;
        let mut events = builder().moves(EventChains::default().local_moves(None)).build()?;
        trials.equilibrate(200, &mut ())?;
        events.equilibrate(200, &mut ())?;
        for _ in 0..TURNS {
            rates[0].push(rate(|| Ok(local.moves(100)))?);
            rates[1].push(rate(|| {
                let before = trials.move_counts().trials;
                trials.run(40, &mut ())?;
                Ok(trials.move_counts().trials - before)
            })?);
            rates[2].push(rate(|| Ok(chains.moves(100)))?);
            rates[3].push(rate(|| {
                let before = events.move_counts().events;
                events.run(40, &mut ())?;
                Ok(events.move_counts().events - before)
            })?);
        }
        let medians = rates.map(|mut rates| {
            rates.sort_by(f64::total_cmp);
            rates[TURNS / 2]
        });
        all.push((eta, medians));
    }
    Ok(Pace(all))
}

/// Millions per CPU second.
fn rate(work: impl FnOnce() -> Result<u64, Failure>) -> Result<f64, Failure> {
    let start = cpu_seconds();
    let done = work()?;
    Ok(1e-6 * done as f64 / (cpu_seconds() - start))
}
