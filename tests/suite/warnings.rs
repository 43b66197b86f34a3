//! Warnings are given in scenes with a problem, besides those of `stability.rs`, and none in good
//! runs.

use gradient_mc::drive::{
    Automatic, Convergence, EquationOfStateClosure, Instantaneous, Scheme, SelfConsistent, Suggestion,
};
use gradient_mc::equation_of_state::{
    CarnahanStarling, EquationOfState, FluidSolid, IdealGas, VirialSeries, packing_fraction,
};
use gradient_mc::field::{ExponentialField, UniformField};
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::observers::{Bins, DensityProfile, EquationOfStateProfile};
use gradient_mc::start::{ClosePacked, RandomInsertion, Start, Theory};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal, TemperatureFn};
use gradient_mc::{
    Field, Hydrostatics, MixingEvidence, Observer, Scene, Simulation, Slab, TemperatureProfile, Warning,
};

/// The paper's columns at a quarter of their height: ten spheres per area and a quarter of the
/// temperature.
const SPHERES_PER_AREA: f64 = 10.0;
const TEMPERATURE: f64 = 3.75;

fn scene<F: Field, T: TemperatureProfile>(height: f64, width: f64, field: F, temperature: T) -> Scene<F, T> {
    let slab = Slab::new(height, width, width).unwrap();
    Scene::with_column_density(slab, SPHERES_PER_AREA, field, temperature).unwrap()
}

fn isothermal(height: f64, temperature: f64) -> Scene<UniformField, Isothermal> {
    scene(height, 6.0, UniformField::default(), Isothermal::new(temperature).unwrap())
}

/// Case (a).
fn column() -> Scene<UniformField, Isothermal> {
    isothermal(100.0, TEMPERATURE)
}

/// Case (c), a little milder, so that its top is not too steep for a local theory.
fn cooler_above() -> Scene<UniformField, ExponentialTemperature> {
    scene(50.0, 5.0, UniformField::default(), ExponentialTemperature::new(5.0, 0.04).unwrap())
}

/// How a run is made.
struct Run<S, P> {
    scheme: S,
    start: P,
    moves: Moves,
    sweeps: [u64; 2],
    seed: u64,
}

impl<S, P: Start + 'static> Run<S, P> {
    fn of<F, T, O: Observer>(self, scene: Scene<F, T>, observer: &mut O) -> Vec<Warning>
    where
        F: Field,
        T: TemperatureProfile,
        S: Scheme<F, T>,
    {
        let builder = Simulation::builder(scene).scheme(self.scheme).start(self.start).moves(self.moves);
        let mut simulation = builder.seed(self.seed).build().unwrap();
        let [equilibration, production] = self.sweeps;
        simulation.equilibrate(equilibration, &mut ()).unwrap();
        simulation.run(production, observer).unwrap();
        simulation.warnings()
    }
}

/// As one should: event chains from the theory profile, long enough.
fn healthy<S>(scheme: S, sweeps: [u64; 2], seed: u64) -> Run<S, Theory> {
    Run { scheme, start: Theory, moves: EventChains::default().into(), sweeps, seed }
}

/// The library's local moves of one size.
fn local<P>(start: P, displacement: f64, sweeps: [u64; 2]) -> Run<Automatic, P> {
    let moves = LocalMoves::new(displacement).unwrap().into();
    Run { scheme: Automatic, start, moves, sweeps, seed: 1 }
}

macro_rules! assert_warned {
    ($warnings:expr, $pattern:pat $(if $guard:expr)?) => {
        let warnings: &[Warning] = &$warnings;
        assert!(warnings.iter().any(|warning| matches!(warning, $pattern $(if $guard)?)), "{warnings:#?}");
    };
}

fn assert_none(warnings: &[Warning], label: &str) {
    let lines: Vec<String> = warnings.iter().map(Warning::to_string).collect();
    assert!(warnings.is_empty(), "{label}: {lines:#?}");
}

#[test]
fn isothermal_columns_that_are_as_they_should_be_are_not_warned_of() {
    for seed in 1..=3 {
        let slab = *column().slab();
        let mut profiles = (
            DensityProfile::new(&slab, Bins::count(200)).unwrap(),
            EquationOfStateProfile::new(&slab, Bins::count(100).from(0.0).to(50.0)).unwrap(),
        );
        let warnings = healthy(Automatic, [800, 4000], seed).of(column(), &mut profiles);
        assert_none(&warnings, "case (a), chains");
        assert_none(&profiles.0.warnings(), "density of case (a)");
        assert_none(&profiles.1.warnings(), "equation of state of case (a)");
        let tuned = Run { moves: LocalMoves::tuned().into(), ..healthy(Automatic, [1500, 8000], seed) };
        assert_none(&tuned.of(column(), &mut ()), "case (a), tuned local moves");
    }
}

#[test]
fn columns_in_a_varying_field_that_are_as_they_should_be_are_not_warned_of() {
    for seed in 1..=3 {
        let field = ExponentialField::new(0.08).unwrap();
        let scene = scene(40.0, 5.0, field, Isothermal::new(5.0).unwrap());
        assert_none(&healthy(Automatic, [800, 4000], seed).of(scene, &mut ()), "case (b)");
    }
}

#[test]
fn columns_at_a_varying_temperature_that_are_as_they_should_be_are_not_warned_of() {
    for seed in 1..=3 {
        let run = healthy(SelfConsistent::default(), [3000, 12_000], seed);
        assert_none(&run.of(cooler_above(), &mut ()), "case (c)");
    }
}

#[test]
fn a_run_that_is_too_short_says_so_once() {
    let short = healthy(Automatic, [100, 100], 1).of(column(), &mut ());
    assert!(matches!(short[..], [Warning::TooShort { sweeps: 100, needed: 256, .. }]), "{short:?}");
    // The certificate needs more; of the two demands the larger is made.
    let run = healthy(SelfConsistent::default(), [100, 100], 1);
    let short = run.of(cooler_above(), &mut ());
    assert!(
        matches!(
            short[..],
            [Warning::FieldOfTheory { .. }, Warning::TooShort { sweeps: 100, needed: 320, .. }]
        ),
        "{short:?}"
    );
    // Nothing was measured at all.
    let none = healthy(Automatic, [100, 0], 1).of(column(), &mut ());
    assert!(matches!(none[..], [Warning::TooShort { sweeps: 0, needed: 256, .. }]), "{none:?}");
    // A later production is judged by itself.
    let mut simulation = Simulation::builder(column()).moves(EventChains::default()).build().unwrap();
    simulation.run(3000, &mut ()).unwrap();
    simulation.equilibrate(1, &mut ()).unwrap();
    simulation.run(5, &mut ()).unwrap();
    let again = simulation.warnings();
    assert!(matches!(again[..], [Warning::TooShort { sweeps: 5, needed: 256, .. }]), "{again:?}");
}

#[test]
fn a_column_that_hardly_moves_is_warned_of() {
    let crawling = || local(Theory, 0.005, [0, 1000]).of(column(), &mut ());
    assert_warned!(
        crawling(),
        Warning::NotMixed { evidence: MixingEvidence::TooQuiet { variance, required, .. }, .. }
            if *variance < 0.05 * required
    );
    assert_warned!(
        crawling(),
        Warning::NotMixed { evidence: MixingEvidence::FewIndependent { effective_sample_size, .. }, .. }
            if *effective_sample_size < 20.0
    );
    let moves = LocalMoves::new(0.005).unwrap();
    let mut simulation = Simulation::builder(column()).moves(moves).seed(1).build().unwrap();
    simulation.run(1000, &mut ()).unwrap();
    let certificate = simulation.certificate(0.05).unwrap();
    let Convergence::NotConverged { suggestion: Suggestion::MixLonger, .. } = certificate.convergence else {
        panic!("{certificate}");
    };
    // From far above.
    let builder = Simulation::builder(column()).moves(LocalMoves::new(0.75).unwrap());
    let mut simulation = builder.start(RandomInsertion::default()).seed(1).build().unwrap();
    simulation.run(600, &mut ()).unwrap();
    let certificate = simulation.certificate(0.05).unwrap();
    let Convergence::NotConverged { suggestion: Suggestion::EquilibrateLonger, .. } = certificate.convergence
    else {
        panic!("{certificate}");
    };
}

#[test]
fn a_field_that_is_not_that_of_its_density_is_warned_of() {
    // An ideal gas imposed on spheres at packing fraction 0.3.
    let run = healthy(EquationOfStateClosure::new(IdealGas), [500, 4000], 1);
    assert_warned!(run.of(cooler_above(), &mut ()), Warning::FeedbackNotConverged { certificate, .. } if certificate.residual().mean.abs() > 0.02);
}

#[test]
fn a_lid_that_carries_pressure_is_warned_of() {
    let scene = isothermal(16.0, TEMPERATURE);
    let mut top = DensityProfile::new(scene.slab(), Bins::count(1).from(13.5).to(14.5)).unwrap();
    let warnings = healthy(Automatic, [500, 3000], 1).of(scene, &mut top);
    // By the density two diameters below the lid, where the layers are faint, and an equation of state.
    let density = top.means()[0];
    let factor = CarnahanStarling.compressibility_factor(packing_fraction(density));
    let expected = density * TEMPERATURE * factor / (density * TEMPERATURE * factor + SPHERES_PER_AREA);
    assert!(
        matches!(warnings[..], [Warning::LidTooLow { lid: 16.0, pressure_ratio, .. }] if (pressure_ratio / expected - 1.0).abs() < 0.25),
        "{expected} {warnings:#?}"
    );
}

#[test]
fn a_column_that_freezes_is_warned_of_and_so_is_a_box_that_does_not_fit() {
    let temperature = 0.6;
    let cold = |width_y: f64, width_z: f64| {
        let slab = Slab::new(30.0, width_y, width_z).unwrap();
        let isothermal = Isothermal::new(temperature).unwrap();
        let scene =
            Scene::with_column_density(slab, SPHERES_PER_AREA, UniformField::default(), isothermal).unwrap();
        local(ClosePacked, 0.1, [0, 200]).of(scene, &mut ())
    };
    let warnings = cold(6.0, 6.0);
    // P/T falls from 16.7 to 11.57 where 3.1 of the ten spheres per area are below: some 2.8 diameters
    // up.
    assert_warned!(
        warnings,
        Warning::Metastable { lowest_height, highest_height, packing_fraction, .. }
            if *lowest_height < 0.1 && (1.5..8.0).contains(highest_height) && *packing_fraction > 0.5
    );
    assert_warned!(
        warnings,
        Warning::BoxIncommensurate { strain, .. } if (0.02..0.1).contains(strain)
    );
    let Some(Warning::BoxIncommensurate { lattice_constant, .. }) =
        warnings.iter().find(|warning| matches!(warning, Warning::BoxIncommensurate { .. }))
    else {
        unreachable!();
    };
    // Six spheres along, six rows across: the crystal fits, but the column freezes all the same.
    let fitting = cold(6.0 * lattice_constant, 6.0 * 0.75_f64.sqrt() * lattice_constant);
    assert_warned!(fitting, Warning::Metastable { .. });
    assert!(
        !fitting.iter().any(|warning| matches!(warning, Warning::BoxIncommensurate { .. })),
        "{fitting:#?}"
    );
}

/// Few cold spheres lie on the wall as a gas, though their weight per area is many times that of
/// freezing over T.
#[test]
fn a_thin_cold_layer_does_not_freeze_and_a_dense_one_does() {
    let frozen = |spheres_per_area: f64, acceleration: f64| {
        let slab = Slab::new(12.0, 6.0, 6.0).unwrap();
        let (field, cold) = (UniformField::new(acceleration).unwrap(), Isothermal::new(0.005).unwrap());
        let scene = Scene::with_column_density(slab, spheres_per_area, field, cold).unwrap();
        let warnings = local(RandomInsertion::default(), 0.3, [500, 300]).of(scene, &mut ());
        warnings.into_iter().find(|warning| matches!(warning, Warning::Metastable { .. }))
    };
    for acceleration in [1.0, -1.0] {
        for spheres_per_area in [0.1, 0.4, 0.6] {
            let said = frozen(spheres_per_area, acceleration);
            assert!(said.is_none(), "{spheres_per_area} {acceleration}: {said:?}");
        }
        let said = frozen(2.0, acceleration);
        assert!(
            matches!(said, Some(Warning::Metastable { lowest_height, highest_height, .. })
                if if acceleration > 0.0 { lowest_height < 0.1 } else { highest_height > 11.9 }),
            "{said:?}"
        );
    }
}

#[test]
fn a_scene_without_theory_is_warned_of() {
    // A temperature with 50 000 waves: more than the solver has panels for.
    let comb = TemperatureFn(|height: f64| TEMPERATURE * (1.0 + 0.5 * libm::sin(3000.0 * height)));
    let comb = scene(100.0, 6.0, UniformField::default(), comb);
    let moves = LocalMoves::new(0.3).unwrap().into();
    let run = Run { scheme: Instantaneous::default(), start: ClosePacked, moves, sweeps: [0, 10], seed: 1 };
    assert_warned!(run.of(comb, &mut ()), Warning::NoTheory { height, .. } if *height > 0.0);
}

#[test]
fn theory_profiles_say_where_they_are_wrong() {
    let uniform = UniformField::default();
    let theory = |temperature: f64| {
        Hydrostatics::new(uniform, Isothermal::new(temperature).unwrap(), CarnahanStarling)
    };
    assert_none(&theory(15.0).column_density(40.0).unwrap().warnings(), "the paper's case (a)");
    let cold = theory(3.0).column_density(40.0).unwrap().warnings();
    assert!(
        matches!(cold[..], [Warning::OutsideDomain { exit, .. }] if exit.lowest_height < 1e-9 && exit.packing_fraction > 0.5),
        "{cold:#?}"
    );
    let lid = theory(15.0).lid(60.0).column_density(40.0).unwrap().warnings();
    assert!(
        matches!(lid[..], [Warning::LidTooLow { lid: 60.0, pressure_ratio, .. }] if pressure_ratio > 0.05),
        "{lid:#?}"
    );
    // A temperature that halves at x = 20, and a front between fluid and solid.
    let jump = TemperatureFn(|height: f64| if height < 20.0 { 15.0 } else { 7.5 });
    let jump = Hydrostatics::new(uniform, jump, CarnahanStarling).column_density(40.0).unwrap().warnings();
    assert_warned!(jump, Warning::DensityJump { height, below, above, .. } if (height - 20.0).abs() < 1e-9 && above > below);
    let front = Hydrostatics::new(uniform, Isothermal::new(3.0).unwrap(), FluidSolid::default());
    let front = front.column_density(40.0).unwrap().warnings();
    assert_warned!(front, Warning::DensityJump { below, above, .. } if below > above);
    assert!(!front.iter().any(|warning| matches!(warning, Warning::OutsideDomain { .. })), "{front:#?}");
    // An equation of state for less dense fluids.
    let virial = Hydrostatics::new(uniform, Isothermal::new(5.0).unwrap(), VirialSeries::default());
    assert_warned!(virial.column_density(40.0).unwrap().warnings(), Warning::OutsideDomain { exit, .. } if (exit.limit - 0.4).abs() < 1e-9);
}
