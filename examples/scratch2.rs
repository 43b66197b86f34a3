use gradient_mc::{equation_of_state::*, field::*, moves::*, observers::*, temperature::*, *};
fn main() -> Result<(), Error> {
    let args: Vec<String> = std::env::args().collect();
    let length: f64 = args[1].parse().unwrap();
    let vf: f64 = args[2].parse().unwrap();
    for seed in 0..4 {
        let (packing_fraction, temperature, width) = (0.35, 2.0, 8.0);
        let height = 40.0;
        let particles = (number_density(packing_fraction) * width * width * height) as usize;
        let slab = Slab::new(height, width, width).unwrap();
        let scene =
            Scene::new(slab, particles, UniformField::new(0.0)?, Isothermal::new(temperature).unwrap())
                .unwrap();
        let c = if length > 0.0 { EventChains::with_length(length)? } else { EventChains::default() };
        let mut simulation =
            Simulation::builder(scene).moves(c.vertical_fraction(vf)?).seed(seed).build().unwrap();
        simulation.equilibrate(400, &mut ()).unwrap();
        let mut chains = ChainPressureProfile::with_range(&slab, 8.0, 32.0, 1).unwrap();
        let mut density = DensityProfile::with_range(&slab, 8.0, 32.0, 1).unwrap();
        simulation.run(4_000, &mut (&mut chains, &mut density)).unwrap();
        let p = chains.points()?[0];
        let d = density.points()?[0];
        let eta = d.packing_fraction.mean;
        println!(
            "{} {}  expected {}",
            p.normal,
            p.lateral,
            temperature * d.number_density.mean * ModifiedKolafa.compressibility_factor(eta)
        );
    }
    Ok(())
}
