//! Starts at high densities, and very small and very large numbers of spheres.

use crate::column::{self, Length, run};
use crate::map::{Findings, Map, Trial};
use crate::said;
use crate::verdict::Quantity;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::observers::CenterOfMass;
use gradient_mc::start::{ClosePacked, RandomInsertion, Start, Theory};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Scene, Simulation, Slab};
use paper::Failure;
use paper::clock::cpu_seconds;

/// Density of a start by random insertion, and how full a box may be for the others.
pub(crate) fn starts() -> Map {
    const DENSITIES: [f64; 7] = [0.1, 0.3, 0.5, 0.65, 0.75, 0.9, 1.2];
    let mut map =
        Map::new("start", "Starts: spheres placed, in a box of the same density", "number density n d³");
    for density in DENSITIES {
        map.add("random insertion", density, move |trial| {
            start(RandomInsertion::new(density)?, density, trial)
        });
        map.add("theory", density, move |trial| start(Theory, density, trial));
        map.add("compact", density, move |trial| start(ClosePacked, density, trial));
    }
    map
}

/// A start must place all spheres without overlaps.
fn start(start: impl Start + 'static, density: f64, trial: Trial) -> Result<Findings, Failure> {
    let (height, width) = (12.0, 6.0);
    let particles = paper::study::count(density * height * width * width);
    let scene = Scene::new(
        Slab::new(height, width, width)?,
        particles,
        UniformField::default(),
        Isothermal::new(10.0)?,
    )?;
    let simulation = Simulation::builder(scene).start(start).seed(trial.seed).build()?;
    let missing =
        (particles - simulation.positions().len()) as f64 + overlaps(&simulation.positions(), width).0;
    let quantity = Quantity::absolute("spheres missing or overlapping", Estimate::exact(missing));
    Ok(Findings { quantities: vec![quantity.tolerating(0.5, 0.5)], ..Findings::default() })
}

/// Pairs closer than one diameter, and how deep the deepest overlap is; by all pairs.
pub(crate) fn overlaps(positions: &[gradient_mc::Vector3<f64>], width: f64) -> (f64, f64) {
    let (mut pairs, mut deepest) = (0.0, 0.0_f64);
    for (index, a) in positions.iter().enumerate() {
        for b in &positions[..index] {
            let across = |from: f64, to: f64| {
                let distance = (from - to).abs();
                distance.min(width - distance)
            };
            let (x, y, z) = (a.x - b.x, across(a.y, b.y), across(a.z, b.z));
            let square = x * x + y * y + z * z;
            if square < 1.0 {
                pairs += 1.0;
                deepest = deepest.max(1.0 - square.sqrt());
            }
        }
    }
    (pairs, deepest)
}

/// One to three spheres.
pub(crate) fn few() -> Map {
    let mut map =
        Map::new("few_spheres", "Few spheres over a base 3 x 3, T = 1: exact results", "number of spheres");
    let moves = |name: &str| -> Result<Moves, gradient_mc::Error> {
        Ok(match name {
            "local, S = 0.75" => LocalMoves::new(0.75)?.into(),
            "tuned" => LocalMoves::tuned().into(),
            "chains" => EventChains::default().into(),
            _ => EventChains::default().local_moves(None).into(),
        })
    };
    for name in ["local, S = 0.75", "tuned", "chains", "chains alone"] {
        for spheres in [1_u32, 2, 3] {
            map.add(name, spheres.into(), move |trial| {
                let scene = column::scene(
                    60.0,
                    3.0,
                    f64::from(spheres) / 9.0,
                    UniformField::default(),
                    Isothermal::new(1.0)?,
                )?;
                let moves = moves(name)?;
                let simulation = Simulation::builder(scene).moves(moves).seed(trial.seed).build()?;
                let sweeps = 400_000;
                let run = run(simulation, Length { equilibration: sweeps / 10, sweeps }, trial)?;
                // One: ½ + T. Two: quadrature of exp(−Δ/T)[9 − π(1 − Δ²)₊] over the height difference. Three:
                // the contact theorem alone.
                let exact = [1.5, 1.567_105_973_366_81];
                let contact = run.contact(scene.column_density())?;
                let index = usize::try_from(spheres)? - 1;
                let center = exact.get(index).map(|&exact| run.center_of_mass(exact, 0.0)).transpose()?;
                Ok(run.with(center.into_iter().chain([contact])))
            });
        }
    }
    map
}

/// Many spheres: time and memory per sphere, and what some sweeps are good for.
pub(crate) fn many() -> Map {
    let mut map = Map::new("many_spheres", "Many spheres: some sweeps, from far above", "number of spheres");
    map.alone = true;
    for spheres in [1e3, 1e4, 1e5, 1e6] {
        for (name, chains) in [("local, S = 0.5", false), ("chains", true)] {
            map.add(name, spheres, move |trial| crowd(spheres, chains, trial));
        }
    }
    map
}

/// Resident memory of this process in bytes, if the system reports it.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024.0 * kibibytes)
}

fn crowd(spheres: f64, chains: bool, trial: Trial) -> Result<Findings, Failure> {
    let spheres = if trial.short { spheres.min(1e4) } else { spheres };
    let before = memory();
    let scene =
        column::scene(200.0, (spheres / 40.0).sqrt(), 40.0, UniformField::default(), Isothermal::new(20.0)?)?;
    let moves: Moves =
        if chains { EventChains::default().local_moves(None).into() } else { LocalMoves::new(0.5)?.into() };
    let mut simulation =
        Simulation::builder(scene).start(RandomInsertion::new(0.2)?).moves(moves).seed(trial.seed).build()?;
    let first = simulation.frame().heights().sum::<f64>() / scene.particles() as f64;
    simulation.equilibrate(2, &mut ())?;
    let (start, move_counts) = (cpu_seconds(), *simulation.move_counts());
    let mut center_of_mass = CenterOfMass::new();
    simulation.run(40, &mut center_of_mass)?;
    let seconds = cpu_seconds() - start;
    let made = simulation.move_counts().since(&move_counts);
    let bytes = before.zip(memory()).map(|(before, after)| ((after - before) / spheres).max(0.0));
    let truth = column::theory(&scene)?.center_of_mass();
    let mut quantity = Quantity::relative("center of mass", center_of_mass.estimate()?, truth);
    quantity.start = Some(first / truth - 1.0);
    let drift = center_of_mass.drift()?;
    quantity.drift = Some(drift / truth);
    let remark = format!(
        "{:.0} ns per move, {} bytes more per sphere",
        1e9 * seconds / (made.trials + made.events).max(1) as f64,
        bytes.map_or("?".into(), |bytes| format!("{bytes:.0}")),
    );
    Ok(Findings { quantities: vec![quantity], said: said::by(&simulation), remark, foreign: false })
}
