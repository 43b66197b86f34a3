//! The pressure from event chains, compared with the weight of the column, which is independent of
//! it, and with the equation of state.

use crate::common::exact::meet;
use gradient_mc::drive::{Automatic, EquationOfStateClosure, Scheme};
use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa, number_density};
use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{Bins, ChainPressureProfile, DensityProfile, PressureProfile};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Every, Field, Scene, Simulation, Slab, TemperatureProfile};

/// Normal and lateral pressure from chains, and the weight of the column.
fn column<T, S>(temperature: T, scheme: S) -> (Vec<[Estimate; 2]>, Vec<Estimate>)
where
    T: TemperatureProfile,
    S: Scheme<UniformField, T>,
{
    let slab = Slab::new(70.0, 6.0, 6.0).unwrap();
    let scene = Scene::new(slab, 360, UniformField::default(), temperature).unwrap();
    let builder = Simulation::builder(scene).scheme(scheme).moves(EventChains::default()).seed(17);
    let mut simulation = builder.build().unwrap();
    simulation.equilibrate(5_000, &mut ()).unwrap();
    // The first bins resolve the layers at the base.
    let mut chains = ChainPressureProfile::new(&slab, Bins::count(20).from(0.5).to(10.5)).unwrap();
    let mut weight = Every::new(5, PressureProfile::new(&slab, Bins::count(20).from(0.5).to(10.5)).unwrap());
    simulation.run(20_000, &mut (&mut chains, &mut weight)).unwrap();
    let weight = weight.observer.points().unwrap().iter().map(|point| point.pressure).collect();
    (chains.points().unwrap().iter().map(|point| [point.normal, point.lateral]).collect(), weight)
}

#[test]
fn normal_pressure_carries_the_weight_layers_included() {
    let (chains, weights) = column(Isothermal::new(5.0).unwrap(), Automatic);
    for (bin, ([normal, _], weight)) in chains.iter().zip(&weights).enumerate() {
        meet(&format!("bin {bin}"), *normal, *weight, 0.01).unwrap();
    }
    // The lateral pressure does not, where the spheres are layered: the check would notice.
    let lateral = chains.iter().zip(&weights);
    let lateral: Vec<f64> = lateral
        .map(|([_, lateral], weight)| {
            let difference = lateral.minus_independent(*weight);
            assert!(difference.standard_error < 0.03 * weight.mean, "{difference} at {weight}");
            difference.deviation_from(0.0)
        })
        .collect();
    println!("{lateral:.1?}");
    assert!(lateral[0] > 4.0 && lateral[1] < -4.0 && lateral[2] > 4.0, "{lateral:.1?}");
}

#[test]
fn normal_pressure_of_a_column_in_a_temperature_gradient() {
    // Here P/T is the pressure of the isothermal system in the effective field. The closure's field is
    // not exactly the one of its own weight, by what the equation of state misses at the base.
    let temperature = ExponentialTemperature::new(6.0, 0.03).unwrap();
    let (chains, weights) = column(temperature, EquationOfStateClosure::default());
    for (bin, ([normal, _], weight)) in chains.iter().zip(&weights).enumerate().skip(8) {
        let slack = Estimate::new(weight.mean, weight.standard_error.hypot(0.005 * weight.mean));
        meet(&format!("bin {bin}"), *normal, slack, 0.015).unwrap();
    }
}

#[test]
fn pressure_of_a_homogeneous_fluid_is_that_of_its_equation_of_state() {
    let (packing_fraction, temperature, width) = (0.35, 2.0, 8.0);
    let height = 40.0;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let particles = (number_density(packing_fraction) * width * width * height) as usize;
    let slab = Slab::new(height, width, width).unwrap();
    let weightless = UniformField::new(0.0).unwrap();
    assert!(weightless.acceleration(1.0).abs() < 1e-300);
    let scene = Scene::new(slab, particles, weightless, Isothermal::new(temperature).unwrap()).unwrap();
    let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(4).build().unwrap();
    simulation.equilibrate(1_000, &mut ()).unwrap();
    let mut chains = ChainPressureProfile::new(&slab, Bins::count(1).from(8.0).to(32.0)).unwrap();
    let mut density = DensityProfile::new(&slab, Bins::count(1).from(8.0).to(32.0)).unwrap();
    simulation.run(5_000, &mut (&mut chains, &mut density)).unwrap();
    let [point] = chains.points().unwrap()[..] else { panic!("one bin") };
    let density = density.points().unwrap()[0];
    let eta = density.packing_fraction.mean;
    let expected = temperature * density.number_density.mean * ModifiedKolafa.compressibility_factor(eta);
    // What the error of the density does to the expected pressure.
    let factor = ModifiedKolafa.compressibility_factor(eta);
    let slope = 1.0 + ModifiedKolafa.compressibility_derivative(eta) / factor;
    let error = expected * slope * density.number_density.standard_error / density.number_density.mean;
    let expected = Estimate::new(expected, error);
    meet("normal", point.normal, expected, 0.008).unwrap();
    meet("lateral", point.lateral, expected, 0.008).unwrap();
}
