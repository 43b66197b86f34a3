//! Inputs that are lawful and unusual, or wrong: the answer is right, or an error that says why not.

#![allow(clippy::unwrap_used, clippy::panic)]

use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{
    CenterOfMass, ChainPressureProfile, DensityProfile, DisplacementProfile, EquationOfStateProfile,
    HexaticOrder, NeighborAngles, PressureProfile, RadialDistribution, StructureProfile,
};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::{Isothermal, LinearTemperature};
use gradient_mc::{Error, Scene, Simulation, Slab};

fn agrees(measured: Estimate, expected: f64, cap: f64) -> bool {
    measured.standard_error > 0.0
        && measured.standard_error < cap * expected
        && (measured.mean - expected).abs() < 4.0 * measured.standard_error
}

/// Whatever is asked of an observer that has seen no frame, or one, is an error and no panic.
#[test]
fn observers_without_frames_say_so() {
    let slab = Slab::new(20.0, 6.0, 6.0).unwrap();
    let scene = Scene::new(slab, 60, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
    let mut simulation = Simulation::builder(scene).moves(EventChains::default()).build().unwrap();
    let mut center = CenterOfMass::new();
    let mut density = DensityProfile::new(&slab, 20).unwrap();
    let mut pressure = PressureProfile::new(&slab, 20).unwrap();
    let mut state = EquationOfStateProfile::new(&slab, 20).unwrap();
    let mut chains = ChainPressureProfile::new(&slab, 20).unwrap();
    let mut displacement = DisplacementProfile::new(&slab, 20).unwrap();
    let mut structure = StructureProfile::new(&slab, 20).unwrap();
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
            ("deviations", state.deviations_from(|_| 1.0).err()),
            ("deviations over ranges", state.deviations_over(&[[1.0, 3.0]], |_| 1.0).err()),
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
        }
        assert!(density.warnings().len() < 2 && state.warnings().len() < 2);
        let profiles = (&mut density, &mut pressure, &mut state, &mut chains);
        let order = (&mut structure, &mut pairs, &mut angles, &mut hexatic);
        simulation.run(1, &mut (&mut center, &mut displacement, profiles, order)).unwrap();
    }
}

/// Normal pressure from chains in the bins of the whole slab, and the exact means of the weight over them.
fn chain_pressures(bins: usize) -> Vec<(Estimate, f64)> {
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(slab, 250, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
    let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(3).build().unwrap();
    simulation.equilibrate(1000, &mut ()).unwrap();
    let mut chains = ChainPressureProfile::new(&slab, bins).unwrap();
    // Means of the weight over the part of the bin in which centers can be.
    let mut weight = PressureProfile::with_range(&slab, 0.5, 1.0, 1).unwrap();
    simulation.run(6000, &mut (&mut chains, &mut weight)).unwrap();
    let weight = weight.points().unwrap()[0].pressure.mean;
    chains.points().unwrap().iter().map(|point| (point.normal, weight)).collect()
}

/// No center lies within half a diameter of a wall: the pressure there is that of the rest of the bin.
#[test]
fn chain_pressure_at_a_wall_is_the_weight() {
    let (pressure, weight) = chain_pressures(60)[0];
    assert!(agrees(pressure, weight, 0.02), "{pressure} where the weight is {weight}");
    let halves = chain_pressures(120);
    assert!(halves[0].0.mean.is_nan(), "{}", halves[0].0);
    let (pressure, weight) = halves[1];
    assert!(agrees(pressure, weight, 0.02), "{pressure} where the weight is {weight}");
}

/// One bin has what many narrow ones have on average, however much the temperature changes within it.
#[test]
fn chain_pressure_of_a_wide_bin_is_the_mean_of_narrow_ones() {
    use gradient_mc::drive::EquationOfStateClosure;
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let temperature = LinearTemperature::new(1.0, 1.0 / 30.0).unwrap();
    let scene = Scene::new(slab, 80, UniformField::default(), temperature).unwrap();
    let builder = Simulation::builder(scene).scheme(EquationOfStateClosure::default());
    let mut simulation = builder.moves(EventChains::default()).seed(3).build().unwrap();
    simulation.equilibrate(300, &mut ()).unwrap();
    let mut profiles =
        [1, 20, 400].map(|bins| ChainPressureProfile::with_range(&slab, 1.0, 21.0, bins).unwrap());
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
        // The same collisions in the same frames: they differ only by where T is read within an eighth of a diameter.
        for wide in [one[axis], some[axis]] {
            let relative = (wide.mean / many[axis].mean - 1.0).abs();
            assert!(relative < 5e-4, "{wide} in wide bins, {} in narrow ones", many[axis]);
        }
    }
}
