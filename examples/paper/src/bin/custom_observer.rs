//! An observer of one's own: the density of spheres that touch the base.
//!
//! The contact theorem is exact: whatever the layers above do, the base carries the whole column, so
//! n(0.5⁺) T = N/A in a uniform field. The observer here counts spheres in thin layers above the base
//! and extrapolates to contact; it brings its own error type, and merges replicas.

use clap::Parser;
use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::statistics::{BlockAverages, Estimate};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Frame, Observer, ObserverError, Scene, Simulation, Slab, start};
use paper::arguments::SharedArguments;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::interrupt::Interrupt;
use paper::progress::Progress;
use paper::{Ending, Failure, conclude, output, replicas, warnings};
use std::process::ExitCode;

/// Measures the contact density at the base with an observer of one's own, against the exact theorem.
#[derive(Parser, Debug)]
#[command(name = "custom_observer")]
struct Arguments {
    #[command(flatten)]
    shared: SharedArguments,
    /// Temperature, in m g d; up to 10, so that nothing reaches the lid
    #[arg(long, default_value_t = 5.0)]
    temperature: f64,
    /// Spheres, on a base of 6 x 6
    #[arg(long, default_value_t = 360)]
    particles: usize,
    /// Sweeps measured in each of four replicas
    #[arg(long, default_value_t = 200_000, value_parser = clap::value_parser!(u64).range(16..=MOST_SWEEPS))]
    sweeps: u64,
    /// Sweeps before the measurement
    #[arg(long, default_value_t = 4000, value_parser = clap::value_parser!(u64).range(0..=MOST_SWEEPS))]
    equilibration: u64,
}

const REPLICAS: u64 = 4;
const MOST_SWEEPS: u64 = 1_000_000_000_000;
/// Above this temperature the lid would carry a part of the weight.
const HOTTEST: f64 = 10.0;
/// Above this contact density the layers are too thick to extrapolate from.
const DENSEST_CONTACT: f64 = 4.0;
/// Height of the box: the lid is far above the column.
const HEIGHT: f64 = 150.0;
const BASE_WIDTH: f64 = 6.0;
/// Thickness of a layer in diameters: thin against the decay of the density at the wall.
const LAYER: f64 = 0.05;
const LAYERS: usize = 20;
/// A result this many standard errors off is a contradiction and not bad luck (1 in 16 000).
const TOLERANCE: f64 = 4.0;

/// Counts the spheres whose centers lie in thin layers above contact with the base.
struct LayersAtBase {
    base_area: f64,
    density: BlockAverages,
}

/// What this observer can object to: an error type of its own.
#[derive(Debug, thiserror::Error)]
enum LayerError {
    #[error("the observer was made for a base of {expected} square diameters, and was shown one of {found}")]
    AnotherSlab { expected: f64, found: f64 },
}

impl LayersAtBase {
    fn new(slab: &Slab) -> Result<Self, Error> {
        Ok(Self { base_area: slab.base_area(), density: BlockAverages::new(LAYERS)? })
    }

    /// Pools the observations of an independent replica.
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.density.merge(&other.density)
    }

    /// The density at contact: the parabola with the mean densities of the three lowest layers, at the
    /// wall (0.3 % low for a density that falls by e in a quarter of a diameter, as by default); its error
    /// by the jackknife, since layers are correlated.
    fn contact(&self) -> Result<Estimate, Error> {
        let at_wall = |mean: &[f64]| [(11.0 * mean[0] - 7.0 * mean[1] + 2.0 * mean[2]) / 6.0];
        Ok(self.density.jackknife(at_wall)?[0])
    }
}

impl Observer for LayersAtBase {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        let (expected, found) = (self.base_area, frame.slab().base_area());
        if (found - expected).abs() > 0.0 {
            return Err(LayerError::AnotherSlab { expected, found }.into());
        }
        let weight = 1.0 / (self.base_area * LAYER);
        let mut density = [0.0; LAYERS];
        for height in frame.heights() {
            let layer = (height - frame.slab().lowest_center()) / LAYER;
            if layer < LAYERS as f64 {
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let layer = layer as usize;
                density[layer] += weight;
            }
        }
        Ok(self.density.push(&density)?)
    }
}

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let directory = arguments.shared.directory("custom_observer");
    output::create_directory(&directory)?;
    let slab = Slab::new(HEIGHT, BASE_WIDTH, BASE_WIDTH)?;
    let temperature = Isothermal::new(arguments.temperature)?;
    let scene = Scene::new(slab, arguments.particles, UniformField::default(), temperature)?;
    let exact = scene.column_density() / arguments.temperature;
    if arguments.temperature > HOTTEST {
        return Err(format!("--temperature {}: take at most {HOTTEST}", arguments.temperature).into());
    }
    if exact > DENSEST_CONTACT {
        let remedy = "take a higher temperature or fewer particles";
        return Err(format!("the contact density {exact} is above {DENSEST_CONTACT}: {remedy}").into());
    }

    let interrupt = Interrupt::listen()?;
    let progress = Progress::new(REPLICAS * (arguments.equilibration + arguments.sweeps), "contact density");
    let seeds = (0..REPLICAS).map(|replica| arguments.shared.seed.wrapping_add(replica)).collect();
    let measured = replicas::in_parallel(arguments.shared.threads, seeds, |seed| {
        let mut simulation = Simulation::builder(scene)
            .start(start::Theory)
            // Shorter trial moves than usual: the layers at the base are dense.
            .moves(LocalMoves::new(0.3)?)
            .seed(seed)
            .build()?;
        let mut layers = LayersAtBase::new(&slab)?;
        replicas::in_chunks(arguments.equilibration, &interrupt, &progress, |sweeps| {
            simulation.equilibrate(sweeps, &mut ())
        })?;
        replicas::in_chunks(arguments.sweeps, &interrupt, &progress, |sweeps| {
            simulation.run(sweeps, &mut layers)
        })?;
        Ok((layers, simulation.warnings()))
    })?;
    progress.finish();

    let mut layers = LayersAtBase::new(&slab)?;
    for (replica, _) in &measured {
        layers.merge(replica)?;
    }
    let contact = layers.contact()?;
    let sigmas = contact.deviation_from(exact);
    println!("density at contact, measured   n(0.5+)   = {contact}");
    println!("density at contact, exact      N/(A T)   = {exact:.6}");
    println!("difference                               = {sigmas:+.1} standard errors");
    warnings::print(measured.iter().map(|(_, warnings)| &warnings[..]));
    write(arguments, &layers, contact, exact, &directory)?;
    println!("written to {}", directory.display());
    if interrupt.pressed() {
        return Ok(Ending::Interrupted);
    }
    if sigmas.abs() < TOLERANCE {
        println!("the contact theorem holds in this run");
        Ok(Ending::Finished)
    } else {
        println!("the contact theorem FAILS in this run: more than {TOLERANCE} standard errors");
        Ok(Ending::ClaimFailed)
    }
}

/// Writes the layers as a table and a picture.
fn write(
    arguments: &Arguments,
    layers: &LayersAtBase,
    contact: Estimate,
    exact: f64,
    directory: &std::path::Path,
) -> Result<(), Failure> {
    let density = layers.density.estimates()?;
    let middle = |layer: usize| 0.5 + (layer as f64 + 0.5) * LAYER;
    let rows = density.iter().enumerate().map(|(layer, n)| [middle(layer), n.mean, n.standard_error]);
    output::write_csv(
        &directory.join("layers.csv"),
        "height in d, number density in 1/d^3",
        ["height", "number_density", "number_density_error"],
        rows.clone(),
    )?;
    let place = Place { left: 0.0, top: 0.07, width: 1.0, height: 0.93 };
    // Room for the legend above the theorem.
    let top = 1.4 * f64::max(exact, contact.mean);
    let panel = Panel::new(
        place,
        Axis::new("height of the center x / d", 0.4, 1.5).with_numbers(11),
        Axis::new("number density n d³", 0.0, top),
    )
    .with_legend(Corner::TopRight)
    .line("contact theorem, N/(AT)", colors::VERMILION, Mark::Dashed, [(0.4, exact), (1.5, exact)])
    .points(
        &format!("simulation, layers of {LAYER} d (errors within the symbols)"),
        colors::INK,
        Mark::Points,
        rows.map(|[x, y, error]| Point { x, y, error }),
    )
    .points(
        "simulation, extrapolated to contact",
        colors::BLUE,
        Mark::Points,
        [Point { x: 0.5, y: contact.mean, error: contact.standard_error }],
    );
    let title = format!(
        "Spheres that touch the base carry the whole column   (T = {} mgd, N/A = {:.4})",
        arguments.temperature,
        exact * arguments.temperature
    );
    Figure::new(&title).panel(panel).save(&directory.join("layers"))
}
