//! Detailed balance of every drive and of the moves: computed, not sampled, wherever it can be.

use crate::common::balance::{
    TrialRecorder, Violation, check_cycles, check_detailed_balance, check_frequencies,
};
use crate::common::scenes::{
    FieldCase, NoInteraction, Rebuilt, ScaledParticle, TemperatureCase, exponential_integral, field_case,
    integrate, pairs_in, temperature_case, triples_in,
};
use crate::common::wrong_rules::{
    EquationThirtyOneAsPrinted, TemperatureInMetropolis, sign_of_displacement, temperature_where_it_starts,
};
use gradient_mc::drive::{
    Adaptation, Automatic, Drive, EquationOfStateClosure, Instantaneous, MeasuredShare, Scheme,
    SelfConsistent, log_acceptance,
};
use gradient_mc::equation_of_state::{EquationOfState, FluidSolid};
use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::start::{Positions, RandomInsertion};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{
    AcceptedMove, Error, Field, Frame, Observer, ObserverError, Recorder, Scene, Simulation, Slab,
    TemperatureProfile, Vector3, Wall,
};
use proptest::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// The accuracy to which detailed balance must hold.
const EXACT: f64 = 1e-12;
/// Bins of a rebuilt table; the drives' default bins are 0.1 wide.
const BINS: usize = 590;

fn slab() -> Slab {
    Slab::new(60.0, 5.0, 5.0).unwrap()
}

fn reference() -> f64 {
    slab().lowest_center()
}

/// ln p of the acceptance rule that all moves read.
fn rule<'a, F, T, D: Drive<F, T>>(drive: &'a D, scene: &'a Scene<F, T>) -> impl Fn(f64, f64) -> f64 + 'a {
    move |from, to| log_acceptance(drive, scene, from, to)
}

/// A random scene of 100 spheres whose temperature may vary.
type AnyScene = Scene<Box<dyn Field>, Box<dyn TemperatureProfile>>;
type AnySimulation<S> = Simulation<Box<dyn Field>, Box<dyn TemperatureProfile>, S>;

fn any_scene(field: FieldCase, temperature: TemperatureCase) -> AnyScene {
    Scene::new(slab(), 100, field.make(&slab()), temperature.make(slab().height())).unwrap()
}

fn width() -> f64 {
    (slab().height() - 1.0) / BINS as f64
}

/// Middle of a bin of a rebuilt table.
fn middle(bin: usize) -> f64 {
    slab().lowest_center() + (bin as f64 + 0.5) * width()
}

/// P/n = T Z at the middle of a bin of the theory profile.
fn theory_ratio<'a, E: EquationOfState>(
    scene: &'a AnyScene,
    equation_of_state: &'a E,
) -> impl Fn(usize) -> f64 + 'a {
    let profile = scene.hydrostatics(equation_of_state).unwrap();
    move |bin| {
        let height = middle(bin);
        let factor = equation_of_state.compressibility_factor(profile.packing_fraction(height));
        scene.temperature().temperature(height) * factor
    }
}

/// Counted spheres per diameter of height that the theory stands for.
const PRIOR_SPHERES: f64 = 3000.0;

/// P/n of counted configurations with a pressure on the lid. If `prior` is given, it stands in for
/// spheres of its own in every bin, and 1 + Var(k)/k² is divided out to first order, with the
/// variance from odd and even intervals; successive configurations are in intervals 2, 3, 3, 4, 4
/// and so on.
fn counted_ratios(
    scene: &AnyScene,
    acceleration: impl Fn(f64) -> f64,
    configurations: &[Vec<f64>],
    end: f64,
    prior: Option<&dyn Fn(usize) -> f64>,
) -> Vec<f64> {
    let (mut counts, mut weights) = (vec![0.0; BINS], vec![0.0; BINS]);
    let (mut of_parity, mut configurations_of) = (vec![[0.0; 2]; BINS], [0.0; 2]);
    for (number, heights) in configurations.iter().enumerate() {
        let parity = number.div_ceil(2) % 2;
        configurations_of[parity] += 1.0;
        for &height in heights {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let bin = (((height - slab().lowest_center()) / width()) as usize).min(BINS - 1);
            counts[bin] += 1.0;
            of_parity[bin][parity] += 1.0;
            weights[bin] += acceleration(height);
        }
    }
    (0..BINS)
        .map(|bin| {
            let at_end = end * slab().base_area() * configurations.len() as f64;
            let between = match scene.open_end() {
                Wall::Lid => weights[bin] / 2.0 + weights[bin + 1..].iter().sum::<f64>(),
                Wall::Base => -weights[bin] / 2.0 - weights[..bin].iter().sum::<f64>(),
            };
            let pressure = width() * (between + at_end);
            match prior {
                Some(prior) => {
                    let from_wall = middle(bin).min(slab().height() - middle(bin));
                    let imagined = PRIOR_SPHERES * width() * if from_wall < 4.0 { 0.03 } else { 1.0 };
                    let total = counts[bin] + imagined;
                    let [even, odd] = configurations_of;
                    let difference = of_parity[bin][0] / even - of_parity[bin][1] / odd;
                    let noise = even * odd * difference * difference / (total * total);
                    (pressure + imagined * prior(bin)) / total * (1.0 - noise).max(0.0)
                }
                None if counts[bin] > 0.0 => pressure / counts[bin],
                None => scene.temperature().temperature(middle(bin)),
            }
        })
        .collect()
}

/// u = φ/T₀ + C, with φ in closed form.
fn potential_with(field: FieldCase, rebuilt: &Rebuilt) -> impl Fn(f64) -> f64 {
    move |height| field.potential(height) / rebuilt.reference + rebuilt.correction(height)
}

/// Keeps the heights of every configuration.
#[derive(Default)]
struct Heights(Vec<Vec<f64>>);

impl Observer for Heights {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.0.push(frame.heights().collect());
        Ok(())
    }
}

/// Simulations of the random scene, started low enough to keep away from the lid.
fn simulation<S>(scene: AnyScene, scheme: S) -> Result<AnySimulation<S>, Error>
where
    S: Scheme<Box<dyn Field>, Box<dyn TemperatureProfile>>,
{
    Simulation::builder(scene)
        .scheme(scheme)
        .start(RandomInsertion::new(0.15).unwrap())
        .moves(LocalMoves::new(0.5).unwrap())
        .seed(7)
        .build()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn isothermal(
        field in field_case(),
        temperature in 0.5..50.0_f64,
        pairs in pairs_in(slab()),
        triples in triples_in(slab()),
    ) {
        let scene = Scene::new(slab(), 100, field.make(&slab()), Isothermal::new(temperature).unwrap()).unwrap();
        let drive = Automatic.drive(&scene).unwrap().0;
        let potential = |height: f64| field.potential(height) / temperature;
        check_detailed_balance(rule(&drive, &scene), potential, &pairs, EXACT + field.accuracy()).unwrap();
        check_cycles(rule(&drive, &scene), &triples, reference(), EXACT).unwrap();
    }

    /// The table against one built anew, with quadrature of its own, and the ratios of the theory.
    #[test]
    fn equation_of_state_closure(
        field in field_case(),
        temperature in temperature_case(),
        interacting in any::<bool>(),
        pairs in pairs_in(slab()),
        triples in triples_in(slab()),
    ) {
        let scene = any_scene(field, temperature);
        let acceleration = |height| field.acceleration(height);
        let (drive, rebuilt) = if interacting {
            let ratio = theory_ratio(&scene, &ScaledParticle);
            let rebuilt = Rebuilt::new(BINS, &slab(), acceleration, scene.temperature(), ratio);
            (EquationOfStateClosure::new(ScaledParticle).drive(&scene).unwrap().0, rebuilt)
        } else {
            let ratio = theory_ratio(&scene, &NoInteraction);
            let rebuilt = Rebuilt::new(BINS, &slab(), acceleration, scene.temperature(), ratio);
            (EquationOfStateClosure::new(NoInteraction).drive(&scene).unwrap().0, rebuilt)
        };
        let potential = potential_with(field, &rebuilt);
        // The quadratures differ by more than rounding, by 1e-10 at most.
        check_detailed_balance(rule(&drive, &scene), potential, &pairs, 1e-10 + field.accuracy()).unwrap();
        let own = |height| drive.reduced_potential(&scene, height);
        check_detailed_balance(rule(&drive, &scene), own, &pairs, EXACT).unwrap();
        check_cycles(rule(&drive, &scene), &triples, reference(), EXACT).unwrap();
    }

    /// An ideal gas in exponential profiles has a closed form, which the table approaches as the square
    /// of the bin width.
    #[test]
    fn ideal_gas_closure_in_exponential_profiles(
        field_rate in -0.04..0.04_f64,
        decay_rate in -0.04..0.05_f64,
        base in 3.0..40.0_f64,
        pairs in pairs_in(slab()),
        triples in triples_in(slab()),
    ) {
        let field = FieldCase::Exponential(field_rate);
        let scene = any_scene(field, TemperatureCase::Exponential(base, decay_rate));
        // -∫ T d(1/T) over a bin of width w, T from its middle: -2 sinh(βw/2) in place of -βw.
        let closed_form = |width: f64| {
            let half = 0.5 * decay_rate * width;
            let slope = if half == 0.0 { 0.0 } else { 2.0 * half.sinh() / width };
            move |height: f64| exponential_integral(field_rate + decay_rate, height) / base - slope * height
        };
        for bins in [590, 2360] {
            let width = (slab().height() - 1.0) / f64::from(bins);
            let drive = EquationOfStateClosure::new(NoInteraction).bin_width(width).unwrap().drive(&scene).unwrap().0;
            let nearest_edge = |height: f64| {
                let edge = 0.5 + ((height - 0.5) / width).round() * width;
                edge.clamp(slab().lowest_center(), slab().highest_center())
            };
            // At edges of bins: exact.
            let edges: Vec<[f64; 2]> = pairs.iter().map(|pair| pair.map(nearest_edge)).collect();
            check_detailed_balance(rule(&drive, &scene), closed_form(width), &edges, EXACT).unwrap();
            // Between them: off by w²/8 times the curvature, and the gradient term by (βw)²/24 of itself.
            let exact = |height: f64| {
                exponential_integral(field_rate + decay_rate, height) / base - decay_rate * height
            };
            let steepest = (2.0 * 60.0 * 0.04_f64).exp().max((60.0 * 0.09_f64).exp());
            let curvature = 0.09 * steepest / base;
            let bound = width * width * (curvature / 4.0 + 60.0 * decay_rate.abs().powi(3) / 24.0) + 1e-12;
            for &[from, to] in &pairs {
                let found = log_acceptance(&drive, &scene, from, to) - log_acceptance(&drive, &scene, to, from);
                let expected = exact(from) - exact(to);
                prop_assert!((found - expected).abs() <= bound + EXACT * (exact(from).abs() + exact(to).abs()));
            }
            check_cycles(rule(&drive, &scene), &triples, reference(), EXACT).unwrap();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// The field frozen at the start of production is the one measured in the last three quarters of the step that ended
    /// then, or the theory's where the column was not at rest, and does not change any more.
    #[test]
    fn self_consistent_once_frozen(
        field in field_case(),
        temperature in temperature_case(),
        pairs in pairs_in(slab()),
        triples in triples_in(slab()),
    ) {
        // The first step.
        let sweeps = 64;
        let scene = any_scene(field, temperature);
        let mut simulation = simulation(scene, SelfConsistent::default().closure_weight(PRIOR_SPHERES).unwrap()).unwrap();
        let mut heights = Heights::default();
        simulation.equilibrate(sweeps, &mut heights).unwrap();
        simulation.run(1, &mut ()).unwrap();
        let frozen = simulation.drive().clone();
        prop_assert_eq!(simulation.adaptation().steps(), 1);
        let looked_at: Vec<Vec<f64>> =
            (1..).zip(heights.0).filter(|(sweep, _)| *sweep > 16 && sweep % 4 == 0).map(|(_, heights)| heights).collect();
        let scene = any_scene(field, temperature);
        let equation_of_state = FluidSolid::default();
        let prior = theory_ratio(&scene, &equation_of_state);
        let acceleration = |height| field.acceleration(height);
        let end = simulation.open_end_pressure();
        let follows_measurement = simulation.adaptation().measured_share() != Some(MeasuredShare::NONE);
        let ratios = counted_ratios(&scene, acceleration, &looked_at, end, Some(&prior));
        let ratio = |bin| if follows_measurement { ratios[bin] } else { prior(bin) };
        let rebuilt = Rebuilt::new(BINS, &slab(), acceleration, scene.temperature(), ratio);
        let potential = potential_with(field, &rebuilt);
        check_detailed_balance(rule(&frozen, &scene), potential, &pairs, 1e-9 + field.accuracy()).unwrap();
        check_cycles(rule(&frozen, &scene), &triples, reference(), EXACT).unwrap();
        simulation.run(5, &mut ()).unwrap();
        for &[from, to] in &pairs {
            prop_assert_eq!(
                log_acceptance(&frozen, &scene, from, to).to_bits(),
                log_acceptance(simulation.drive(), simulation.scene(), from, to).to_bits()
            );
        }
    }

    /// Between two updates the paper's scheme holds detailed balance too, in the field of the
    /// configuration it was made from.
    #[test]
    fn instantaneous_between_updates(
        field in field_case(),
        temperature in temperature_case(),
        sweeps in 1_u64..6,
        pairs in pairs_in(slab()),
        triples in triples_in(slab()),
    ) {
        let scene = any_scene(field, temperature);
        let mut simulation = simulation(scene, Instantaneous::default()).unwrap();
        simulation.equilibrate(sweeps, &mut ()).unwrap();
        let (drive, scene) = (simulation.drive(), simulation.scene());
        let heights: Vec<f64> = simulation.positions().iter().map(|position| position.x).collect();
        let acceleration = |height| field.acceleration(height);
        let ratios = counted_ratios(scene, acceleration, &[heights], 0.0, None);
        let rebuilt = Rebuilt::new(BINS, &slab(), acceleration, scene.temperature(), |bin| ratios[bin]);
        let potential = potential_with(field, &rebuilt);
        check_detailed_balance(rule(drive, scene), potential, &pairs, 1e-9 + field.accuracy()).unwrap();
        check_cycles(rule(drive, scene), &triples, reference(), EXACT).unwrap();
    }
}

/// The paper's hottest case, thinned until the gas is ideal: below 27.7 diameters the effective
/// field points up.
fn steep_scene() -> Scene<UniformField, ExponentialTemperature> {
    let temperature = ExponentialTemperature::new(80.0, 0.05).unwrap();
    Scene::new(slab(), 100, UniformField::default(), temperature).unwrap()
}

fn ideal_potential(height: f64) -> f64 {
    exponential_integral(0.05, height) / 80.0 - 0.05 * height
}

/// Pairs at edges of the drives' bins, where tables are exact, on both sides of the maximum.
fn steep_pairs() -> Vec<[f64; 2]> {
    (5..55).flat_map(|low| [1, 7].map(|step| [f64::from(low), f64::from((low + step).min(59))])).collect()
}

fn steep_triples() -> Vec<[f64; 3]> {
    (5..50).map(|low| [f64::from(low), f64::from(low) + 0.5, f64::from(low) + 3.0]).collect()
}

/// The tolerance that tells the crate's rule from the wrong ones: the table's (βw)²/24, with room.
const TABULATED: f64 = 1e-5;

#[test]
fn the_right_rule_passes_what_the_wrong_ones_fail() {
    let scene = steep_scene();
    let drive = EquationOfStateClosure::new(NoInteraction).drive(&scene).unwrap().0;
    check_detailed_balance(rule(&drive, &scene), ideal_potential, &steep_pairs(), TABULATED).unwrap();
    check_cycles(rule(&drive, &scene), &steep_triples(), reference(), EXACT).unwrap();
}

#[test]
fn deciding_by_the_sign_of_the_displacement_is_noticed() {
    let outcome = check_detailed_balance(
        sign_of_displacement(ideal_potential),
        ideal_potential,
        &steep_pairs(),
        TABULATED,
    );
    assert!(matches!(outcome, Err(Violation::WrongRatio { .. })), "{outcome:?}");
    // Where the potential rises everywhere the two rules are the same, which is how it goes unnoticed.
    check_detailed_balance(sign_of_displacement(|x| x / 5.0), |x| x / 5.0, &steep_pairs(), EXACT).unwrap();
}

#[test]
fn temperature_of_the_starting_point_is_noticed() {
    let scene = steep_scene();
    let outcome = check_cycles(temperature_where_it_starts(&scene), &steep_triples(), reference(), TABULATED);
    assert!(matches!(outcome, Err(Violation::Cycle { .. })), "{outcome:?}");
    let outcome = check_detailed_balance(
        temperature_where_it_starts(&scene),
        ideal_potential,
        &steep_pairs(),
        TABULATED,
    );
    assert!(matches!(outcome, Err(Violation::WrongRatio { .. })), "{outcome:?}");
}

#[test]
fn temperature_put_into_the_boltzmann_factor_is_noticed() {
    let scene = steep_scene();
    let drive = TemperatureInMetropolis.drive(&scene).unwrap().0;
    // It is a potential, so cycles say nothing; it is not the right one.
    check_cycles(rule(&drive, &scene), &steep_triples(), reference(), EXACT).unwrap();
    let outcome = check_detailed_balance(rule(&drive, &scene), ideal_potential, &steep_pairs(), TABULATED);
    assert!(matches!(outcome, Err(Violation::WrongRatio { .. })), "{outcome:?}");
}

#[test]
fn equation_thirty_one_as_printed_is_noticed() {
    let scene = steep_scene();
    let drive = EquationThirtyOneAsPrinted.drive(&scene).unwrap().0;
    check_cycles(rule(&drive, &scene), &steep_triples(), reference(), EXACT).unwrap();
    let outcome = check_detailed_balance(rule(&drive, &scene), ideal_potential, &steep_pairs(), TABULATED);
    assert!(matches!(outcome, Err(Violation::WrongRatio { .. })), "{outcome:?}");
}

#[test]
fn quadrature_of_these_tests_is_right() {
    let field = FieldCase::Sum(0.03, 0.4, -0.01);
    let integral = integrate(|height| field.acceleration(height), 0.0, 47.0, 200);
    approx::assert_relative_eq!(integral, field.potential(47.0), max_relative = 1e-12);
}

/// Displacements accepted where nothing can reject them.
#[derive(Default)]
struct Displacements {
    range: [f64; 2],
    seen: Vec<[f64; 3]>,
}

impl Observer for Displacements {
    fn observe(&mut self, _: &Frame<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for Displacements {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        let [lowest, highest] = self.range;
        if accepted.from_height >= lowest && accepted.from_height <= highest {
            self.seen.push(accepted.displacement.into());
        }
    }
}

/// Probability of a chi-squared statistic as large as that of `counts`, all equally likely.
fn probability_of(counts: &[u64]) -> f64 {
    let expected = counts.iter().sum::<u64>() as f64 / counts.len() as f64;
    let statistic: f64 = counts.iter().map(|&count| (count as f64 - expected).powi(2) / expected).sum();
    1.0 - ChiSquared::new(counts.len() as f64 - 1.0).unwrap().cdf(statistic)
}

#[test]
fn trial_displacements_are_symmetric_and_uniform_in_the_cube() {
    const LARGEST: f64 = 1.25;
    const PARTS: usize = 8;
    let slab = Slab::new(40.0, 4.0, 3.0).unwrap();
    let scene = Scene::new(slab, 1, UniformField::new(0.0).unwrap(), Isothermal::new(1.0).unwrap()).unwrap();
    let start = Positions(vec![Vector3::new(20.0, 1.0, 1.0)]);
    let mut simulation = Simulation::builder(scene)
        .start(start)
        .moves(LocalMoves::new(LARGEST).unwrap())
        .seed(3)
        .build()
        .unwrap();
    let range = [slab.lowest_center() + LARGEST, slab.highest_center() - LARGEST];
    let mut observer = Displacements { range, ..Displacements::default() };
    simulation.run(200_000, &mut observer).unwrap();
    assert!(observer.seen.len() > 150_000);
    let part = |value: f64| {
        assert!(value.abs() < LARGEST);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let part = ((value / LARGEST + 1.0) * 0.5 * PARTS as f64) as usize;
        part
    };
    // All cells of the cube, which any correlation between the axes would disturb as well.
    let mut cube = vec![0; PARTS.pow(3)];
    for displacement in &observer.seen {
        let [x, y, z] = displacement.map(part);
        cube[(x * PARTS + y) * PARTS + z] += 1;
    }
    let probability = probability_of(&cube);
    assert!(probability > 1e-4, "uniform in the cube with probability {probability}");
    // Up and down by any length, to a resolution at which only symmetry matters.
    for axis in 0..3 {
        let mut signs = [0_u64; 2];
        let mut shorter_than_tenth = [0_u64; 2];
        for displacement in &observer.seen {
            let up = usize::from(displacement[axis] > 0.0);
            signs[up] += 1;
            if displacement[axis].abs() < 0.1 {
                shorter_than_tenth[up] += 1;
            }
        }
        assert!(probability_of(&signs) > 1e-4, "{signs:?} along axis {axis}");
        assert!(probability_of(&shorter_than_tenth) > 1e-4, "{shorter_than_tenth:?} along axis {axis}");
    }
}

/// A hundred thousand trials of one sphere.
fn trials_of<F, T, S>(scene: Scene<F, T>, scheme: S, displacement: f64) -> TrialRecorder
where
    F: Field,
    T: TemperatureProfile,
    S: Scheme<F, T>,
{
    let start = Positions(vec![Vector3::new(3.0, 1.0, 1.0)]);
    let mut simulation = Simulation::builder(scene)
        .scheme(scheme)
        .start(start)
        .moves(LocalMoves::new(displacement).unwrap())
        .seed(11)
        .build()
        .unwrap();
    let mut recorder = TrialRecorder::default();
    simulation.run(100_000, &mut recorder).unwrap();
    recorder
}

#[test]
fn moves_are_accepted_as_often_as_the_potential_says() {
    let slab = Slab::new(8.0, 3.0, 3.0).unwrap();
    let range = [slab.lowest_center(), slab.highest_center()];
    for (field, displacement) in [
        (FieldCase::Uniform(1.0), 1.5),
        (FieldCase::Uniform(-0.7), 0.75),
        (FieldCase::Linear(-1.5, 0.4), 1.0),
        (FieldCase::Exponential(0.2), 0.3),
    ] {
        let scene = Scene::new(slab, 1, field.make(&slab), Isothermal::new(1.7).unwrap()).unwrap();
        let recorder = trials_of(scene, Automatic, displacement);
        let check = |potential: &dyn Fn(f64) -> f64| {
            check_frequencies(&recorder.trials, potential, displacement, range)
        };
        check(&|height| field.potential(height) / 1.7).unwrap();
        // And tells a temperature wrong by half, or a sign.
        for wrong in [1.7 * 1.5, -1.7] {
            let outcome = check(&|height| field.potential(height) / wrong);
            assert!(matches!(outcome, Err(Violation::WrongFrequency { .. })), "{field:?} {outcome:?}");
        }
    }
}

#[test]
fn moves_follow_the_effective_potential_where_it_points_up() {
    let slab = Slab::new(8.0, 3.0, 3.0).unwrap();
    let range = [slab.lowest_center(), slab.highest_center()];
    // u' changes sign at x = ln(4)/0.4 = 3.5.
    let (base, decay_rate) = (10.0, 0.4);
    let scene = || {
        let temperature = ExponentialTemperature::new(base, decay_rate).unwrap();
        Scene::new(slab, 1, UniformField::default(), temperature).unwrap()
    };
    let right = |height: f64| exponential_integral(decay_rate, height) / base - decay_rate * height;
    let closure = EquationOfStateClosure::new(NoInteraction).bin_width(0.01).unwrap();
    let recorder = trials_of(scene(), closure, 1.5);
    check_frequencies(&recorder.trials, right, 1.5, range).unwrap();
    // Near the base both of these press down where the right one lifts: too few moves up.
    let outcomes = [
        trials_of(scene(), TemperatureInMetropolis, 1.5),
        trials_of(scene(), EquationThirtyOneAsPrinted, 1.5),
    ]
    .map(|wrong| check_frequencies(&wrong.trials, right, 1.5, range));
    for outcome in outcomes {
        let Err(Violation::WrongFrequency { class: 0 | 1, accepted, expected, .. }) = outcome else {
            panic!("{outcome:?}");
        };
        assert!((accepted as f64) < expected, "{accepted} for {expected}");
    }
}
