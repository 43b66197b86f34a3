//! A temperature profile of one's own: a granular flow down a rough chute.
//!
//! In such a flow the packing fraction hardly depends on height, while the granular temperature falls
//! towards the free surface. Which temperature does that? With n = n₀ up to the surface at x = h, the
//! pressure is P = Pₛ + a n₀ (h − x), with a = cos θ the component of gravity normal to the incline, and
//! P = n₀ T Z(η₀) asks for
//!
//! T(x) = Tₛ + (a/Z(η₀)) (h − x) below the surface, Tₛ above it,
//!
//! where Pₛ = n₀ Tₛ Z(η₀) is the weight of the dilute atmosphere above. The kink is rounded over a
//! diameter. The profile below is the whole extension: one method of one trait.
//!
//! Nothing tells the spheres to be uniform: half of the replicas start as a dilute gas that fills the
//! box, the other half as a crystal on the base, and the effective field is measured from the density
//! of the run itself.

use clap::Parser;
use gradient_mc::drive::SelfConsistent;
use gradient_mc::equation_of_state::{ModifiedKolafa, number_density};
use gradient_mc::field::UniformField;
use gradient_mc::hydrostatics::{HydrostaticProfile, Hydrostatics};
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{CenterOfMass, EquationOfStatePoint, EquationOfStateProfile};
use gradient_mc::start::Start;
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{
    EquationOfState, Error, Every, Scene, Simulation, Slab, TemperatureProfile, Warning, start,
};
use paper::arguments::SharedArguments;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::interrupt::Interrupt;
use paper::progress::Progress;
use paper::{Ending, Failure, conclude, output, replicas, warnings};
use std::fmt;
use std::path::Path;
use std::process::ExitCode;

/// Finds the temperature under which a granular chute flow is equally dense at all heights, and
/// simulates whether it is.
#[derive(Parser, Debug)]
#[command(name = "custom_profile")]
struct Arguments {
    #[command(flatten)]
    shared: SharedArguments,
    /// Packing fraction wanted
    #[arg(long, default_value_t = 0.40)]
    packing_fraction: f64,
    /// Depth of the flow, in diameters
    #[arg(long, default_value_t = 24.0)]
    depth: f64,
    /// Inclination of the chute, in degrees
    #[arg(long, default_value_t = 24.0)]
    angle: f64,
    /// Temperature at the surface, in m g d
    #[arg(long, default_value_t = 1.0)]
    surface_temperature: f64,
    /// Width of the square base, in diameters
    #[arg(long, default_value_t = 10.0)]
    width: f64,
    /// Sweeps measured in each of four replicas
    #[arg(long, default_value_t = 6_000, value_parser = clap::value_parser!(u64).range(80..=MOST_SWEEPS))]
    sweeps: u64,
    /// Sweeps before the measurement
    #[arg(long, default_value_t = 6_000, value_parser = clap::value_parser!(u64).range(0..=MOST_SWEEPS))]
    equilibration: u64,
}

const REPLICAS: u64 = 4;
const MOST_SWEEPS: u64 = 1_000_000_000_000;
/// The wall orders the layers next to it, and the surface is smeared by a few diameters.
const MARGIN: f64 = 6.0;
/// "Nearly uniform": the packing fraction stays within this fraction of the one that was wanted.
const UNIFORMITY: f64 = 0.03;
/// Standard errors that count as a contradiction.
const TOLERANCE: f64 = 4.0;
/// The starts have met if they differ by no more than this part of their first distance. Standard errors
/// alone would not do: every replica freezes a field of its own, whose noise they do not see.
const REMEMBERED: f64 = 0.01;
/// Height of a bin: one layer of spheres, more or less.
const BIN_WIDTH: f64 = 0.5;

/// Temperature that keeps the packing fraction the same at all heights of a chute flow.
#[derive(Debug, Clone, Copy)]
struct ChuteFlow {
    surface_height: f64,
    surface_temperature: f64,
    /// −dT/dx below the surface.
    slope: f64,
}

impl ChuteFlow {
    /// Height over which the kink at the surface is rounded.
    const ROUNDING: f64 = 1.0;
}

impl TemperatureProfile for ChuteFlow {
    fn temperature(&self, height: f64) -> f64 {
        let depth = (self.surface_height - height) / Self::ROUNDING;
        // ln(1 + eᵈ), which is d far below and 0 far above; written so that nothing overflows.
        let rounded = depth.max(0.0) + libm::log1p(libm::exp(-depth.abs()));
        self.surface_temperature + self.slope * Self::ROUNDING * rounded
    }
}

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let eta = arguments.packing_fraction;
    if !(0.05..=0.48).contains(&eta) {
        return Err(format!("--packing-fraction {eta}: take 0.05 to 0.48, a fluid").into());
    }
    if !(arguments.depth >= 2.0 * MARGIN + 4.0 && arguments.depth <= 200.0) {
        return Err(format!("--depth {}: take {} to 200", arguments.depth, 2.0 * MARGIN + 4.0).into());
    }
    let directory = arguments.shared.directory("custom_profile");
    output::create_directory(&directory)?;

    let acceleration = libm::cos(arguments.angle.to_radians());
    let compressibility_factor = ModifiedKolafa.compressibility_factor(eta);
    let temperature = ChuteFlow {
        surface_height: arguments.depth,
        surface_temperature: arguments.surface_temperature,
        slope: acceleration / compressibility_factor,
    };
    // The flow itself, and the atmosphere that it carries: its weight is the pressure at the surface.
    let density = number_density(eta);
    let atmosphere = density * compressibility_factor * arguments.surface_temperature / acceleration;
    let column_density = density * arguments.depth + atmosphere;
    let atmosphere_height = 3.0 * compressibility_factor * arguments.surface_temperature / acceleration;
    let slab = Slab::new((arguments.depth + atmosphere_height).ceil(), arguments.width, arguments.width)?;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let particles = (column_density * slab.base_area()).round() as usize;
    let field = UniformField::new(acceleration)?;
    let scene = Scene::new(slab, particles, field, temperature)?;
    println!(
        "{particles} spheres, {:.2} per area, on a chute inclined by {}°; T falls from {:.3} to {:.3}",
        scene.column_density(),
        arguments.angle,
        temperature.temperature(0.0),
        temperature.temperature(slab.height()),
    );

    let interrupt = Interrupt::listen()?;
    let progress = Progress::new(REPLICAS * (arguments.equilibration + arguments.sweeps), "chute flow");
    let gas = start::RandomInsertion::new(scene.column_density() / (slab.height() - 1.0))?;
    let measured = replicas::in_parallel(arguments.shared.threads, (0..REPLICAS).collect(), |replica| {
        let start: Box<dyn Start> =
            if replica % 2 == 0 { Box::new(gas) } else { Box::new(start::ClosePacked) };
        let mut simulation = Simulation::builder(scene)
            .scheme(SelfConsistent::default())
            .start(start)
            .moves(EventChains::default())
            .seed(arguments.shared.seed.wrapping_add(replica))
            .build()?;
        let heights = simulation.frame().heights();
        let first_center = heights.sum::<f64>() / particles as f64;
        replicas::in_chunks(arguments.equilibration, &interrupt, &progress, |sweeps| {
            simulation.equilibrate(sweeps, &mut ())
        })?;
        let mut observers =
            Every::new(5, (EquationOfStateProfile::new(&slab, bins(&slab))?, CenterOfMass::new()));
        replicas::in_chunks(arguments.sweeps, &interrupt, &progress, |sweeps| {
            simulation.run(sweeps, &mut observers)
        })?;
        let (profile, center_of_mass) = observers.observer;
        Ok(Replica { profile, center_of_mass, first_center, warnings: simulation.warnings() })
    })?;
    progress.finish();

    let theory = Hydrostatics::new(&field, &temperature, &ModifiedKolafa)
        .lid(slab.height())
        .column_density(scene.column_density())?;
    let mean_temperature = mean_temperature(&theory, &temperature, &slab);
    let isothermal = Hydrostatics::new(&field, &Isothermal::new(mean_temperature)?, &ModifiedKolafa)
        .lid(slab.height())
        .column_density(scene.column_density())?;
    let flow = Flow { wanted: eta, depth: arguments.depth, temperature, theory, isothermal };
    let mut pooled = EquationOfStateProfile::new(&slab, bins(&slab))?;
    for replica in &measured {
        pooled.merge(&replica.profile)?;
    }
    let points = pooled.points()?;
    let verdict = Verdict::new(&flow, &points, &measured)?;
    println!("{verdict}");
    warnings::print(measured.iter().map(|replica| &replica.warnings[..]));
    write(&flow, &points, &directory)?;
    println!("written to {}", directory.display());
    Ok(if interrupt.pressed() {
        Ending::Interrupted
    } else if verdict.holds() {
        Ending::Finished
    } else {
        Ending::ClaimFailed
    })
}

fn bins(slab: &Slab) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let bins = (slab.height() / BIN_WIDTH).round() as usize;
    bins
}

/// What one replica measured.
struct Replica {
    profile: EquationOfStateProfile,
    center_of_mass: CenterOfMass,
    /// Height of the center of mass before the first sweep.
    first_center: f64,
    /// What the run says against itself.
    warnings: Vec<Warning>,
}

/// Mean temperature of the spheres, by theory.
fn mean_temperature(theory: &HydrostaticProfile, temperature: &ChuteFlow, slab: &Slab) -> f64 {
    const STEPS: u32 = 2000;
    let (mut weighted, mut total) = (0.0, 0.0);
    for step in 0..STEPS {
        let height = slab.height() * (f64::from(step) + 0.5) / f64::from(STEPS);
        weighted += theory.number_density(height) * temperature.temperature(height);
        total += theory.number_density(height);
    }
    weighted / total
}

/// The flow in theory.
struct Flow {
    wanted: f64,
    depth: f64,
    temperature: ChuteFlow,
    theory: HydrostaticProfile,
    /// The same spheres at one temperature, for contrast.
    isothermal: HydrostaticProfile,
}

impl Flow {
    /// Whether wall and surface are far enough.
    fn is_bulk(&self, height: f64) -> bool {
        height > MARGIN && height < self.depth - MARGIN
    }

    fn bulk<'a>(
        &'a self,
        points: &'a [EquationOfStatePoint],
    ) -> impl Iterator<Item = &'a EquationOfStatePoint> + Clone {
        points.iter().filter(|point| self.is_bulk(point.height))
    }
}

/// What the simulation says about the claim, from its data alone.
struct Verdict {
    wanted: f64,
    /// Mean packing fraction of the bulk, over independent replicas.
    mean: Estimate,
    /// What it rises by from the bottom of the bulk to its top, by a straight line, over replicas.
    rise: Estimate,
    /// Largest departure of a bin from the packing fraction wanted, as a fraction, and its height.
    departure: Estimate,
    departure_height: f64,
    /// Center of mass: started as a gas, started as a crystal.
    center_of_mass: [Estimate; 2],
    /// How far apart the two were before the first sweep.
    first_distance: f64,
    /// Rise over the bulk if the same spheres were isothermal, in theory.
    isothermal_rise: f64,
}

impl Verdict {
    fn new(flow: &Flow, pooled: &[EquationOfStatePoint], replicas: &[Replica]) -> Result<Self, Failure> {
        let (mut means, mut rises) = (Vec::new(), Vec::new());
        for replica in replicas {
            let points = replica.profile.points()?;
            let (mean, rise) =
                straight_line(flow.bulk(&points).map(|point| (point.height, point.packing_fraction.mean)));
            means.push(mean);
            rises.push(rise);
        }
        let mut departure = Estimate::new(0.0, 0.0);
        let mut departure_height = f64::NAN;
        for point in flow.bulk(pooled) {
            let relative = Estimate::new(
                point.packing_fraction.mean / flow.wanted - 1.0,
                point.packing_fraction.standard_error / flow.wanted,
            );
            if relative.mean.abs() > departure.mean.abs() {
                (departure, departure_height) = (relative, point.height);
            }
        }
        let bottom_to_top =
            [MARGIN, flow.depth - MARGIN].map(|height| flow.isothermal.packing_fraction(height));
        Ok(Self {
            wanted: flow.wanted,
            mean: over_replicas(&means),
            rise: over_replicas(&rises),
            departure,
            departure_height,
            center_of_mass: [pooled_center(replicas, 0)?, pooled_center(replicas, 1)?],
            first_distance: replicas[0].first_center - replicas[1].first_center,
            isothermal_rise: bottom_to_top[1] - bottom_to_top[0],
        })
    }

    /// What is left of the distance between the starts.
    fn distance(&self) -> Estimate {
        let [gas, crystal] = self.center_of_mass;
        Estimate::new(gas.mean - crystal.mean, gas.standard_error.hypot(crystal.standard_error))
    }

    fn starts_meet(&self) -> bool {
        let Estimate { mean, standard_error, .. } = self.distance();
        mean.abs() < f64::max(TOLERANCE * standard_error, REMEMBERED * self.first_distance)
    }

    fn is_uniform(&self) -> bool {
        self.departure.mean.abs() < UNIFORMITY
    }

    fn holds(&self) -> bool {
        self.starts_meet() && self.is_uniform()
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { wanted, mean, rise, departure, departure_height, center_of_mass: [gas, crystal], .. } =
            self;
        let percent = Estimate::new(100.0 * departure.mean, 100.0 * departure.standard_error);
        writeln!(formatter, "packing fraction wanted                    {wanted}")?;
        writeln!(formatter, "mean over the bulk, simulation             {mean}")?;
        writeln!(formatter, "rise from bottom to top of the bulk        {rise}")?;
        writeln!(formatter, "  the same spheres isothermal, theory      {:+.4}", self.isothermal_rise)?;
        writeln!(
            formatter,
            "largest departure of any bin               {percent} % at height {departure_height}"
        )?;
        writeln!(formatter, "center of mass, started as a dilute gas    {gas}")?;
        writeln!(formatter, "center of mass, started as a crystal       {crystal}")?;
        let (left, first) = (self.distance(), self.first_distance);
        writeln!(formatter, "  distance between the two                 {left}, at first {first:.2}")?;
        let limit = 100.0 * UNIFORMITY;
        let uniform = if self.is_uniform() { "stays within" } else { "DOES NOT stay within" };
        let meet = if self.starts_meet() { "meet" } else { "DO NOT meet: run longer" };
        write!(
            formatter,
            "verdict: the packing fraction {uniform} {limit} % of the one wanted in all bins of the bulk; the two \
             starts {meet}"
        )
    }
}

/// Mean of y, and what y rises by over the range of x, by least squares.
fn straight_line(points: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, f64) {
    let count = points.clone().count() as f64;
    let mean_x = points.clone().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = points.clone().map(|(_, y)| y).sum::<f64>() / count;
    let (mut products, mut squares, mut low, mut high) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
    for (x, y) in points {
        products += (x - mean_x) * (y - mean_y);
        squares += (x - mean_x) * (x - mean_x);
        low = low.min(x);
        high = high.max(x);
    }
    (mean_y, products / squares * (high - low))
}

/// Mean of independent replicas, with the error that their scatter gives.
fn over_replicas(values: &[f64]) -> Estimate {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    Estimate::new(mean, (squares / (count * (count - 1.0))).sqrt())
}

/// Center of mass of the replicas whose number leaves this remainder, that is, of one start.
fn pooled_center(replicas: &[Replica], remainder: usize) -> Result<Estimate, Error> {
    let mut pooled = CenterOfMass::new();
    for replica in replicas.iter().skip(remainder).step_by(2) {
        pooled.merge(&replica.center_of_mass)?;
    }
    pooled.estimate()
}

/// Writes the profile as a table and a picture.
fn write(flow: &Flow, points: &[EquationOfStatePoint], directory: &Path) -> Result<(), Failure> {
    output::write_csv(
        &directory.join("chute_flow.csv"),
        "height in d; pressure in m g/d^2; temperature in m g d; errors are one standard error; theory is \
         hydrostatics with the modified Kolafa-Labik-Malijevsky equation of state",
        [
            "height",
            "packing_fraction",
            "packing_fraction_error",
            "pressure",
            "pressure_error",
            "temperature",
            "packing_fraction_theory",
            "packing_fraction_isothermal_theory",
        ],
        points.iter().map(|point| {
            [
                point.height,
                point.packing_fraction.mean,
                point.packing_fraction.standard_error,
                point.pressure.mean,
                point.pressure.standard_error,
                point.temperature,
                flow.theory.packing_fraction(point.height),
                flow.isothermal.packing_fraction(point.height),
            ]
        }),
    )?;
    let top = (flow.depth * 1.5 / 5.0).ceil() * 5.0;
    let heights = || (0..=1000).map(move |step| f64::from(step) / 1000.0 * top);
    let height_axis = || Axis::new("height above the chute x / d", 0.0, top).with_numbers(8);
    let densest = points.iter().map(|point| point.packing_fraction.mean).fold(1.4 * flow.wanted, f64::max);
    let packing = Panel::new(
        Place { left: 0.0, top: 0.07, width: 0.5, height: 0.93 },
        height_axis(),
        Axis::new("packing fraction η", 0.0, (densest * 10.5).ceil() / 10.0),
    )
    .with_legend(Corner::TopRight)
    .line(
        "one temperature, theory",
        colors::BLUE,
        Mark::Dashed,
        heights().map(|x| (x, flow.isothermal.packing_fraction(x))),
    )
    .points(
        "chute flow, simulation",
        colors::INK,
        Mark::Points,
        // The bin below contact holds no center.
        points.iter().filter(|point| point.height > 0.5).map(|point| Point {
            x: point.height,
            y: point.packing_fraction.mean,
            error: point.packing_fraction.standard_error,
        }),
    )
    .line(
        "chute flow, theory",
        colors::VERMILION,
        Mark::Line,
        heights().map(|x| (x, flow.theory.packing_fraction(x))),
    );
    let hottest = flow.temperature.temperature(0.0);
    let temperature = Panel::new(
        Place { left: 0.5, top: 0.07, width: 0.5, height: 0.43 },
        height_axis(),
        Axis::new("T / mgd", 0.0, (hottest * 1.05).ceil()).with_numbers(5),
    )
    .without_x_labels()
    .with_legend(Corner::TopRight)
    .line(
        "temperature, imposed",
        colors::PURPLE,
        Mark::Line,
        heights().map(|x| (x, flow.temperature.temperature(x))),
    );
    let highest = flow.theory.pressure(0.0);
    let pressure = Panel::new(
        Place { left: 0.5, top: 0.5, width: 0.5, height: 0.5 },
        height_axis(),
        Axis::new("P d² / mg", 0.0, (highest * 0.105).ceil() * 10.0).with_numbers(5),
    )
    .with_legend(Corner::TopRight)
    .points(
        "simulation",
        colors::INK,
        Mark::Points,
        points.iter().map(|point| Point {
            x: point.height,
            y: point.pressure.mean,
            error: point.pressure.standard_error,
        }),
    )
    .line("theory", colors::VERMILION, Mark::Line, heights().map(|x| (x, flow.theory.pressure(x))));
    let title = format!(
        "Granular chute flow: the temperature that keeps the packing fraction uniform   (depth {} d, η = {})",
        flow.depth, flow.wanted
    );
    Figure::new(&title).panel(packing).panel(temperature).panel(pressure).save(&directory.join("chute_flow"))
}
