//! Unusual or wrong inputs: the result is right, or an error tells the reason.

use crate::common::exact::agrees;
use gradient_mc::drive::SelfConsistent;
use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{
    Bins, CenterOfMass, ChainPressureProfile, DensityProfile, DisplacementProfile, EquationOfStateProfile,
    HexaticOrder, NeighborAngles, PressureProfile, RadialDistribution, StructureProfile,
};
use gradient_mc::start::Positions;
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::{ExponentialTemperature, Isothermal, LinearTemperature};
use gradient_mc::{Error, Merge, Scene, Simulation, Slab};

/// A run that goes on from positions counts its sweeps anew, and takes observers of its own.
#[test]
fn a_restart_takes_observers_of_its_own() {
    let slab = Slab::new(20.0, 6.0, 6.0).unwrap();
    let scene = Scene::new(slab, 60, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
    let mut simulation = Simulation::builder(scene).seed(1).build().unwrap();
    let mut center = CenterOfMass::new();
    simulation.run(300, &mut center).unwrap();
    let start = Positions(simulation.positions());
    let mut restarted = Simulation::builder(scene).start(start).seed(2).build().unwrap();
    let refused = restarted.run(400, &mut center).unwrap_err();
    let Error::Observer { source, .. } = refused else { panic!("{refused}") };
    assert!(
        matches!(source.downcast_ref(), Some(Error::AnotherRun { what: "number of the sweep", .. })),
        "{source}"
    );
    let mut second = CenterOfMass::new();
    restarted.run(399, &mut second).unwrap();
    center.merge(&second).unwrap();
    // Of the first run nothing is left, of the second what came after.
    let late = center.since(301);
    assert_eq!((late.heights(), late.sweeps()), (&[][..], &[][..]));
    let mut alone = CenterOfMass::new();
    alone.merge(&second.since(301)).unwrap();
    assert_eq!(late.estimate().unwrap(), alone.estimate().unwrap());
    assert_eq!(center.heights().len(), 300);
}

/// Whatever is asked of an observer that has seen no frame, or one, is an error and no panic.
#[test]
fn observers_without_frames_say_so() {
    let slab = Slab::new(20.0, 6.0, 6.0).unwrap();
    let scene = Scene::new(slab, 60, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
    let mut simulation = Simulation::builder(scene).moves(EventChains::default()).build().unwrap();
    let mut center = CenterOfMass::new();
    let mut density = DensityProfile::new(&slab, Bins::count(20)).unwrap();
    let mut pressure = PressureProfile::new(&slab, Bins::count(20)).unwrap();
    let mut state = EquationOfStateProfile::new(&slab, Bins::count(20)).unwrap();
    let mut chains = ChainPressureProfile::new(&slab, Bins::count(20)).unwrap();
    let mut displacement = DisplacementProfile::new(&slab, Bins::count(20)).unwrap();
    let mut structure = StructureProfile::new(&slab, Bins::count(20)).unwrap();
    let mut pairs = RadialDistribution::new(&slab, 0.5, 0.6, 10).unwrap();
    let mut angles = NeighborAngles::new(&slab, 0.5, 0.6, 10).unwrap();
    let mut hexatic = HexaticOrder::new(&slab, 0.5, 0.6, 1.5).unwrap();
    for frames in 0..2 {
        let answers = [
            ("mean height", center.estimate().err()),
            ("drift", center.drift().err()),
            ("variance", center.variance().err()),
            ("autocorrelation", center.autocorrelation().err()),
            ("equilibration", center.equilibration().err()),
            ("density", density.points().err()),
            ("function of the density", density.jackknife(|bins| [bins[3] / bins[4]]).err()),
            ("layers", density.layers(0.1).err()),
            ("pressure", pressure.points().err()),
            ("equation of state", state.points().err()),
            ("deviations", state.deviations_from(&gradient_mc::equation_of_state::IdealGas).err()),
            (
                "deviations over ranges",
                state.deviations_over(&[[1.0, 3.0]], &gradient_mc::equation_of_state::IdealGas).err(),
            ),
            ("function of the states", state.jackknife(|bins| [bins[3].pressure]).err()),
            ("pressure of chains", chains.points().err()),
            ("function of the pressures", chains.jackknife(|bins| [bins[3].normal]).err()),
            ("displacements", displacement.points().err()),
            ("structure", structure.points().err()),
            ("structure over a range", structure.over(1.0, 3.0).err()),
            ("front", structure.front().err()),
            ("pairs", pairs.points().err()),
            ("lateral density", pairs.lateral_density().err()),
            ("angles", angles.points().err()),
            ("neighbors", angles.neighbors_per_sphere().err()),
            ("local order", hexatic.local().err()),
            ("global order", hexatic.global().err()),
        ];
        for (what, answer) in answers {
            assert!(
                matches!(answer, Some(Error::TooFewObservations { .. })),
                "{what} after {frames} frames: {answer:?}"
            );
            // It says who asks.
            let answer = answer.unwrap().to_string();
            assert!(answer.contains(" for ") && !answer.contains("for a standard error"), "{what}: {answer}");
        }
        assert!(density.warnings().len() < 2 && state.warnings().len() < 2);
        let profiles = (&mut density, &mut pressure, &mut state, &mut chains);
        let order = (&mut structure, &mut pairs, &mut angles, &mut hexatic);
        simulation.run(1, &mut (&mut center, &mut displacement, profiles, order)).unwrap();
    }
}

/// Normal pressure from chains in the bins of the whole slab, and the exact means of the weight
/// over them.
fn chain_pressures(bins: usize) -> Vec<(Estimate, f64)> {
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(slab, 250, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
    let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(3).build().unwrap();
    simulation.equilibrate(1000, &mut ()).unwrap();
    let mut chains = ChainPressureProfile::new(&slab, Bins::count(bins)).unwrap();
    // Means of the weight over the part of the bin in which centers can be.
    let mut weight = PressureProfile::new(&slab, Bins::count(1).from(0.5).to(1.0)).unwrap();
    simulation.run(6000, &mut (&mut chains, &mut weight)).unwrap();
    let weight = weight.points().unwrap()[0].pressure.mean;
    chains.points().unwrap().iter().map(|point| (point.normal, weight)).collect()
}

/// No center lies within half a diameter of a wall: the pressure there is that of the rest of the
/// bin.
#[test]
fn chain_pressure_at_a_wall_is_the_weight() {
    let (pressure, weight) = chain_pressures(60)[0];
    agrees("pressure at the wall", pressure, weight, 0.02 * weight).unwrap();
    let halves = chain_pressures(120);
    assert!(halves[0].0.mean.is_nan(), "{}", halves[0].0);
    let (pressure, weight) = halves[1];
    agrees("pressure at the wall", pressure, weight, 0.02 * weight).unwrap();
}

/// One bin has what many narrow ones have on average, however much the temperature changes within
/// it.
#[test]
fn chain_pressure_of_a_wide_bin_is_the_mean_of_narrow_ones() {
    use gradient_mc::drive::EquationOfStateClosure;
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let temperature = LinearTemperature::new(1.0, 1.0 / 30.0).unwrap();
    let scene = Scene::new(slab, 80, UniformField::default(), temperature).unwrap();
    let builder = Simulation::builder(scene).scheme(EquationOfStateClosure::default());
    let mut simulation = builder.moves(EventChains::default()).seed(3).build().unwrap();
    simulation.equilibrate(300, &mut ()).unwrap();
    let mut profiles = [1, 20, 400]
        .map(|bins| ChainPressureProfile::new(&slab, Bins::count(bins).from(1.0).to(21.0)).unwrap());
    let [one, some, many] = &mut profiles;
    simulation.run(2000, &mut (one, some, many)).unwrap();
    let [one, some, many] = profiles.map(|profile| {
        let mean = |bins: &[gradient_mc::observers::BinPressures]| {
            [
                bins.iter().map(|bin| bin.normal).sum::<f64>() / bins.len() as f64,
                bins.iter().map(|bin| bin.lateral).sum::<f64>() / bins.len() as f64,
            ]
        };
        profile.jackknife(mean).unwrap()
    });
    for axis in 0..2 {
        // The same collisions in the same frames: they differ only by where T is read within an eighth of a
        // diameter.
        for wide in [one[axis], some[axis]] {
            let relative = (wide.mean / many[axis].mean - 1.0).abs();
            assert!(relative < 5e-4, "{wide} in wide bins, {} in narrow ones", many[axis]);
        }
    }
}

/// What is asked of it outside the slab is an error of the library.
mod guarded {
    use gradient_mc::{Field, TemperatureProfile};

    /// Steep, weightless at the base, and with a derivative that is taken numerically.
    #[derive(Debug, Clone, Copy)]
    pub(super) struct Pull {
        pub(super) highest: f64,
    }

    fn inside(height: f64, highest: f64) -> f64 {
        assert!((0.0..=highest).contains(&height), "asked at {height:e} of a slab up to {highest}");
        height
    }

    impl Field for Pull {
        fn potential(&self, height: f64) -> f64 {
            0.1 * inside(height, self.highest).powf(1.5)
        }
    }

    /// Warmer in the middle; its derivative is taken numerically too.
    #[derive(Debug, Clone, Copy)]
    pub(super) struct Heat {
        pub(super) highest: f64,
        pub(super) swing: f64,
    }

    impl TemperatureProfile for Heat {
        fn temperature(&self, height: f64) -> f64 {
            let inside = inside(height, self.highest) / self.highest;
            2.0 + self.swing * inside * (1.0 - inside)
        }
    }
}

/// Every way to use a scene asks its field and its temperature between the walls only.
#[test]
fn nothing_is_asked_outside_the_slab() {
    use gradient_mc::drive::{
        AveragedThenFrozen, EquationOfStateClosure, Instantaneous, RunningAverage, SelfConsistent,
    };
    use gradient_mc::equation_of_state::{CarnahanStarling, FluidSolid, IdealGas};
    use gradient_mc::field::FieldFn;
    use gradient_mc::model::Accuracy;
    use gradient_mc::moves::LocalMoves;
    use gradient_mc::observers::BinPressures;
    use gradient_mc::start::{ClosePacked, RandomInsertion, Theory};
    use gradient_mc::{Field, Hydrostatics, TemperatureProfile};
    use guarded::{Heat, Pull};

    for highest in [30.0, 29.97] {
        let slab = Slab::new(highest, 5.0, 5.0).unwrap();
        let closure = move |height: f64| {
            assert!((0.0..=highest).contains(&height), "asked at {height:e}");
            (highest - height).sqrt()
        };
        let field = FieldFn::new(closure, &slab).unwrap();
        // ∫ √(H − x) dx is 2/3 [H^{3/2} − (H − x)^{3/2}].
        for height in [0.0, 1.0, 10.0, 29.95, highest] {
            let exact = (highest.powf(1.5) - (highest - height).powf(1.5)) / 1.5;
            assert!((field.potential(height) - exact).abs() < 1e-3, "{height}");
        }
        Scene::new(slab, 100, &field, Isothermal::new(40.0).unwrap()).unwrap();

        let pull = Pull { highest };
        for height in [0.0, 1e-3, 3e-3, 1.0, highest - 0.01] {
            let exact = 0.15 * height.sqrt();
            // Where the third derivative is infinite a difference is off by of the order of itself.
            let tolerance = if height < 0.01 { 0.15 * 4e-3_f64.sqrt() } else { 1e-8 };
            assert!((pull.acceleration(height) - exact).abs() < tolerance, "{height}");
        }
        let heat = Heat { highest, swing: 4.0 };
        for base in [0.0, 0.5] {
            let theory = Hydrostatics::new(pull, heat, CarnahanStarling).base(base).lid(highest);
            assert!(theory.column_density(4.0).unwrap().center_of_mass() > 1.0);
        }
        let theory = Hydrostatics::new(pull, heat, FluidSolid::default());
        theory.between_walls(&slab, 4.0).unwrap();

        let scene = Scene::new(slab, 100, pull, heat).unwrap();
        scene.model_for(Accuracy::density(0.05).unwrap()).unwrap().model().densities(&scene, 1).unwrap();
        scene.hydrostatics(&IdealGas).unwrap();
        macro_rules! simulate {
            ($scheme:expr, $moves:expr, $start:expr) => {{
                let builder = Simulation::builder(scene).scheme($scheme).moves($moves).start($start);
                let mut simulation = builder.build().unwrap();
                let mut state = EquationOfStateProfile::new(&slab, Bins::count(30)).unwrap();
                let mut chains = ChainPressureProfile::new(&slab, Bins::count(30)).unwrap();
                let mut center = CenterOfMass::new();
                simulation.equilibrate(50, &mut ()).unwrap();
                simulation.run(400, &mut (&mut state, &mut chains, &mut center)).unwrap();
                simulation.warnings();
                state.points().unwrap();
                chains.jackknife(|bins: &[BinPressures]| [bins[3].normal]).unwrap();
                let _ = simulation.certificate(0.05);
            }};
        }
        simulate!(SelfConsistent::default(), EventChains::default(), Theory);
        simulate!(SelfConsistent::default(), LocalMoves::tuned(), RandomInsertion::default());
        simulate!(EquationOfStateClosure::default(), LocalMoves::tuned(), ClosePacked);
        simulate!(Instantaneous::default(), LocalMoves::new(0.5).unwrap(), Theory);
        simulate!(RunningAverage::default(), LocalMoves::tuned(), Theory);
        simulate!(AveragedThenFrozen::default(), EventChains::default(), Theory);
        // The same temperature everywhere, by a type of the user's.
        let flat = Scene::new(slab, 100, pull, Heat { highest, swing: 0.0 }).unwrap();
        flat.model_for(Accuracy::density(0.05).unwrap()).unwrap().model().densities(&flat, 1).unwrap();
        let isothermal = Scene::new(slab, 100, pull, Isothermal::new(3.0).unwrap()).unwrap();
        for moves in [EventChains::default().into(), gradient_mc::moves::Moves::from(LocalMoves::tuned())] {
            let mut simulation = Simulation::builder(isothermal).moves(moves).build().unwrap();
            simulation.equilibrate(50, &mut ()).unwrap();
            simulation.run(200, &mut ()).unwrap();
            simulation.warnings();
        }
        assert!(heat.logarithmic_gradient(0.0) > 0.0);
    }
}

/// Sweeps of chains, and the events of the last of them per sphere.
fn cold_chains(
    temperature: f64,
    spheres: usize,
    chains: EventChains,
    equilibrate: bool,
) -> Result<f64, Error> {
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(slab, spheres, UniformField::default(), Isothermal::new(temperature)?)?;
    let builder = Simulation::builder(scene).moves(chains).start(gradient_mc::start::ClosePacked);
    let mut simulation = builder.seed(5).build()?;
    if equilibrate {
        simulation.equilibrate(40, &mut ())?;
    }
    simulation.run(5, &mut ())?;
    let before = simulation.move_counts().events;
    simulation.run(20, &mut ())?;
    Ok((simulation.move_counts().events - before) as f64 / (20 * spheres) as f64)
}

/// A sweep takes a bounded time however steep the field is, tuned beforehand or not.
#[test]
fn chains_in_steep_fields_take_a_bounded_time() {
    for spheres in [1, 200] {
        for equilibrate in [true, false] {
            for temperature in [1e-2, 1e-4, 1e-5, 1e-7] {
                let events = cold_chains(temperature, spheres, EventChains::default(), equilibrate).unwrap();
                assert!(events < 400.0, "T = {temperature}, {spheres} spheres: {events} events");
            }
        }
    }
    // Chains whose length is the user's do not get ahead: it is the field, not the packing.
    let long = EventChains::with_length(100.0).unwrap();
    let error = cold_chains(1e-6, 1, long, false).unwrap_err();
    assert!(matches!(error, Error::ChainStuck { field_events: 1000.., .. }), "{error:?}");
    assert!(error.to_string().contains("the field stops it"), "{error}");
    assert!(!error.to_string().contains("spheres touch"), "{error}");
}

/// The barometric law of one cold sphere, by chains that are cut short.
#[test]
fn chains_in_steep_fields_are_right() {
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let temperature = 1e-4;
    let scene = Scene::new(slab, 1, UniformField::default(), Isothermal::new(temperature).unwrap()).unwrap();
    let chains = EventChains::default().local_moves(None);
    let mut simulation = Simulation::builder(scene).moves(chains).seed(5).build().unwrap();
    let mut center = CenterOfMass::new();
    simulation.equilibrate(1000, &mut ()).unwrap();
    simulation.run(10_000, &mut center).unwrap();
    let height = center.estimate().unwrap();
    let risen = height - 0.5;
    agrees("risen", risen, temperature, 0.05 * temperature).unwrap();
}

/// Lengths and radii so small that a sweep, or a search, would not end.
#[test]
fn the_smallest_lengths_end() {
    for length in [0.0, 1e-300, 1e-12, 0.999e-3, f64::NAN] {
        let error = EventChains::with_length(length).unwrap_err();
        assert!(matches!(error, Error::InvalidParameter { .. }), "{length}");
    }
    assert!(cold_chains(1.0, 20, EventChains::with_length(1e-3).unwrap(), true).unwrap() < 2000.0);
    let slab = Slab::new(20.0, 5.0, 5.0).unwrap();
    for radius in [5e-324, 1e-323, 1e-300, 1e-9] {
        let mut neighbors = gradient_mc::observers::Neighbors::new(&slab, radius).unwrap();
        neighbors.gather([[0.5, 1.0, 1.0], [10.0, 3.0, 3.0], [0.5, 1.0, 1.0]].map(Into::into));
        assert_eq!(neighbors.of(0).map(|other| other.index).collect::<Vec<_>>(), [2]);
        assert_eq!(neighbors.of(1).count(), 0);
    }
}

/// A scene that is beyond the solver is given up after so many evaluations, and says so; one that
/// oscillates is solved within them.
#[test]
fn hydrostatics_ends() {
    use gradient_mc::Hydrostatics;
    use gradient_mc::equation_of_state::{
        Coexistence, FluidSolid, ModifiedKolafa, PercusYevickVirial, SpeedySolid,
    };
    use gradient_mc::temperature::TemperatureFn;
    use std::sync::atomic::{AtomicU64, Ordering};

    let calls = AtomicU64::new(0);
    let counted = |temperature: f64| {
        calls.fetch_add(1, Ordering::Relaxed);
        temperature
    };
    let slab = Slab::new(60.0, 6.0, 6.0).unwrap();
    let jump = TemperatureFn(|height| counted(if height < 10.0 { 1.4e-34 } else { 2.8e-34 }));
    let cold = Hydrostatics::new(UniformField::default(), jump, PercusYevickVirial);
    let error = cold.between_walls(&slab, 10.0).unwrap_err();
    assert!(matches!(error, Error::HydrostaticsNotConverged { .. }), "{error:?}");
    assert!(calls.swap(0, Ordering::Relaxed) < 1_200_000);

    let waves = TemperatureFn(|height: f64| counted(20.7 * (1.0 + 0.82 * (3.35 * height).sin())));
    let upward = UniformField::new(-9.3).unwrap();
    let older = Coexistence { reduced_pressure: 11.56, ..Coexistence::default() };
    let spheres = FluidSolid::new(ModifiedKolafa, SpeedySolid, older).unwrap();
    let profile = Hydrostatics::new(upward, waves, spheres).between_walls(&slab, 10.0).unwrap();
    assert!((profile.center_of_mass() - 52.360_386_84).abs() < 1e-6, "{}", profile.center_of_mass());
    assert!(calls.load(Ordering::Relaxed) < 1_200_000, "{calls:?}");
}

/// A tolerance is a part of something.
#[test]
fn tolerances_lie_between_0_and_1() {
    let slab = Slab::new(30.0, 5.0, 5.0).unwrap();
    // Without a gradient, which turns out by probes, there is nothing to be off; with a minute one both
    // sides of the balance are the same sums but for rounding.
    for (rate, text) in [(0.0, "isothermal"), (1e-11, "P_iso T/W - 1 = 0 % at")] {
        let temperature = ExponentialTemperature::new(4.0, rate).unwrap();
        let scene = Scene::new(slab, 60, UniformField::default(), temperature).unwrap();
        certificate_of(scene, text);
    }
}

/// Tolerances and lengths that are refused, and what the certificate says of a scene without a
/// gradient.
fn certificate_of(scene: Scene<UniformField, ExponentialTemperature>, expected: &str) {
    let builder = Simulation::builder(scene).scheme(SelfConsistent::default());
    let mut simulation = builder.moves(EventChains::default()).seed(1).build().unwrap();
    // Who asks, and for what, in the numbers of the documentation.
    for sweeps in [0, 100, 215] {
        simulation.run(sweeps, &mut ()).unwrap();
        let error = simulation.certificate(0.05).unwrap_err();
        let done = usize::try_from(simulation.sweep()).unwrap();
        assert!(
            matches!(error, Error::TooFewObservations { available, needed: 320, .. } if available == done),
            "{error:?}"
        );
        let text = error.to_string();
        assert!(text.starts_with("sweeps of production for a certificate:"), "{text}");
    }
    simulation.run(5, &mut ()).unwrap();
    for tolerance in [0.0, -0.1, 1.0, 10.0, f64::INFINITY, f64::NAN] {
        let error = simulation.certificate(tolerance).unwrap_err();
        assert!(matches!(error, Error::InvalidParameter { .. }), "{tolerance}: {error:?}");
    }
    // So few sweeps may not have mixed.
    simulation.run(4000, &mut ()).unwrap();
    let text = simulation.certificate(0.05).unwrap().to_string();
    assert!(text.contains(expected), "{text}");
}

/// Constant series have no correlation time, whatever number they hold, and do not become longer by
/// running longer.
#[test]
fn series_that_never_change_are_no_series() {
    use gradient_mc::statistics::{autocorrelation, blocking, equilibration};
    for value in [12.7, 2.0, 0.1, -1e9 / 3.0] {
        let series = [value; 1000];
        assert!(matches!(autocorrelation(&series), Err(Error::InvalidParameter { .. })), "{value}");
        assert!(matches!(equilibration(&series), Err(Error::InvalidParameter { .. })), "{value}");
        assert_eq!(blocking(&series).unwrap(), Estimate::new(value, 0.0));
    }
    // AR(1) with φ = −0.5 has ½ (1 + φ)/(1 − φ) = 1/6; a series that only changes sign, 0.
    let to_and_fro: Vec<f64> = (0..1000).map(|i| f64::from(1 - 2 * (i % 2))).collect();
    assert!(autocorrelation(&to_and_fro).unwrap().time.mean.abs() < 0.01);
}

/// Nothing moves in a slab filled with touching spheres.
#[test]
fn a_run_in_which_nothing_moved_says_so() {
    use gradient_mc::start::ClosePacked;
    use gradient_mc::{Warning, moves::LocalMoves};
    // Five spheres in a row and five rows, with gaps of a thousandth of a diameter.
    let slab = Slab::new(10.0, 5.006, 5.006).unwrap();
    let scene =
        |spheres| Scene::new(slab, spheres, UniformField::default(), Isothermal::new(1.0).unwrap()).unwrap();
    let full = Simulation::builder(scene(353)).start(ClosePacked).build().unwrap_err();
    let Error::LatticeFull { sites, .. } = full else { panic!("{full:?}") };
    let scene = scene(sites);
    let builder = Simulation::builder(scene).start(ClosePacked);
    let builder = builder.moves(LocalMoves::new(2.5).unwrap()).seed(2);
    let mut simulation = builder.build().unwrap();
    simulation.run(256, &mut ()).unwrap();
    assert_eq!(simulation.move_counts().accepted, 0);
    let warnings = simulation.warnings();
    assert!(warnings.contains(&Warning::NothingMoved { sweeps: 256 }), "{warnings:?}");
    assert!(!warnings.iter().any(|warning| matches!(warning, Warning::NotMixed { .. })), "{warnings:?}");
}

/// The default start finds a configuration between freezing and melting, and says what does not
/// fit.
#[test]
fn the_default_start_knows_coexistence_and_full_slabs() {
    let slab = Slab::new(10.0, 5.0, 5.0).unwrap();
    for acceleration in [0.0, 1.0, -1.0] {
        let start = |spheres: usize| {
            let field = UniformField::new(acceleration).unwrap();
            let scene = Scene::new(slab, spheres, field, Isothermal::new(1.0).unwrap()).unwrap();
            Simulation::builder(scene).build()
        };
        for spheres in (200..=288).step_by(4).chain([225, 250]) {
            let positions = start(spheres).unwrap().positions();
            let height = positions.iter().map(|position| position[0]).sum::<f64>() / spheres as f64;
            assert!(acceleration != 0.0 || (height - 5.0).abs() < 0.5, "{spheres}: {height}");
        }
        for spheres in [289, 300, 353] {
            let error = start(spheres).unwrap_err();
            assert!(
                matches!(error, Error::LatticeFull { sites: 288, particles, .. } if particles == spheres)
            );
            assert!(error.to_string().contains("288 sites"), "{error}");
        }
    }
}

/// A crystal's equation has no state for the thin top of an open column, and no column is so steep
/// that nothing is left.
#[test]
fn theories_that_end_say_where() {
    use gradient_mc::Hydrostatics;
    use gradient_mc::equation_of_state::{CarnahanStarling, DomainSide, IdealGas, SpeedySolid};
    let warm = Isothermal::new(1.0).unwrap();
    let solid = Hydrostatics::new(UniformField::default(), warm, SpeedySolid);
    for error in [solid.column_density(20.0).unwrap_err(), solid.base_pressure(20.0).unwrap_err()] {
        assert!(
            matches!(error, Error::EquationOfStateExhausted { side: DomainSide::Below, .. }),
            "{error:?}"
        );
        assert!(error.to_string().contains("reaches lower"), "{error}");
    }
    assert!(solid.lid(20.0).column_density(25.0).unwrap().lid_pressure() > 11.0);
    for (pressure, acceleration) in [(158.0, 1e100), (1e-300, 1e100), (1e300, 1e300), (158.0, 1e17)] {
        let field = UniformField::new(acceleration).unwrap();
        let outcomes = [
            Hydrostatics::new(field, warm, CarnahanStarling).base_pressure(pressure),
            Hydrostatics::new(field, warm, IdealGas).base_pressure(pressure),
        ];
        for outcome in outcomes {
            match outcome {
                Ok(profile) => {
                    assert!(profile.center_of_mass().is_finite() && profile.column_density() > 0.0);
                }
                Err(error) => assert!(
                    matches!(
                        error,
                        Error::HydrostaticsNotConverged { .. } | Error::EquationOfStateExhausted { .. }
                    ),
                    "{error:?}"
                ),
            }
        }
    }
}
