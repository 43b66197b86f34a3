//! Observers of structure in fluids and crystals of known structure.

use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::{
    Bins, BondOrder, CenterOfMass, DensityProfile, HexaticOrder, Layer, NeighborAngles, RadialDistribution,
    Structure, StructureProfile,
};
use gradient_mc::start::{Positions, RandomInsertion, Theory};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Every, Scene, Simulation, Slab, Vector3};

fn column(
    slab: Slab,
    particles: usize,
    acceleration: f64,
    temperature: f64,
) -> Scene<UniformField, Isothermal> {
    let field = UniformField::new(acceleration).unwrap();
    Scene::new(slab, particles, field, Isothermal::new(temperature).unwrap()).unwrap()
}

/// The paper's column at T = 5: layers at the base, of which the first that is a liquid, and no
/// crystal.
#[test]
fn layers_at_the_base_of_a_fluid() {
    let slab = Slab::new(100.0, 8.0, 8.0).unwrap();
    let scene = column(slab, 2560, 1.0, 5.0);
    let builder = Simulation::builder(scene).start(Theory).moves(EventChains::default());
    let mut simulation = builder.seed(2).build().unwrap();
    simulation.equilibrate(500, &mut ()).unwrap();
    let mut density = Every::new(2, DensityProfile::new(&slab, Bins::count(100).from(0.5).to(10.5)).unwrap());
    let mut distribution = RadialDistribution::new(&slab, 0.5, 0.6, 80).unwrap();
    let mut angles = NeighborAngles::new(&slab, 0.5, 0.6, 72).unwrap();
    let mut hexatic = HexaticOrder::new(&slab, 0.5, 1.0, 1.4).unwrap();
    let mut structure = StructureProfile::new(&slab, Bins::count(12).from(1.0).to(13.0)).unwrap();
    let in_plane = Every::new(10, (&mut distribution, &mut angles, &mut hexatic));
    simulation.run(5500, &mut (&mut density, in_plane, Every::new(100, &mut structure))).unwrap();

    // White Bear II (fmt_WBII_T5_bins_extrapolated.csv) has 4.755 in the first bin and 0.771 spheres
    // per area from 0.5 to
    // 1. The other layers are sharper here than there, with local moves as with chains: the second has
    //    1.75(2) at 1.45, where
    // the functional has 1.35 (and 1.57 at 1.55); so positions are asked for, and not its extrema.
    let layers = density.observer.layers(Layer::CLEAR).unwrap();
    assert!(layers.len() >= 4, "{layers:?}");
    let contact = layers[0].maximum_density;
    assert!((contact.mean - 4.755).abs() < 0.05 + 4.0 * contact.standard_error, "{contact}");
    assert!(contact.standard_error < 0.1, "{contact}");
    let first = layers[0].lateral_density;
    assert!((first.mean - 0.771).abs() < 0.02 + 4.0 * first.standard_error, "{first}");
    assert!(first.standard_error < 0.01, "{first}");
    assert_eq!(layers[0].position, Estimate::exact(0.5));
    for (layer, low, high) in [(&layers[1], 1.44, 1.56), (&layers[2], 2.34, 2.5), (&layers[3], 3.2, 3.5)] {
        let position = layer.position;
        assert!(position.mean > low && position.mean < high && position.standard_error < 0.08, "{position}");
    }
    // Less and less clear upwards.
    let visibility = layers[..3].iter().map(|layer| layer.visibility.mean).collect::<Vec<f64>>();
    assert!(visibility.is_sorted_by(|lower, upper| lower > upper) && visibility[0] > 0.85, "{visibility:?}");

    // The first layer is a liquid: peaks at contact and about two diameters, and nothing far away.
    let points = distribution.points().unwrap();
    let mean = |low: f64, high: f64| {
        let inside = points.iter().filter(|point| (low..high).contains(&point.distance));
        inside.clone().map(|point| point.radial_distribution.mean).sum::<f64>() / inside.count() as f64
    };
    assert!(mean(0.0, 0.95) < 0.01 && mean(1.0, 1.05) > 2.5, "{} {}", mean(0.0, 0.95), mean(1.0, 1.05));
    assert!(mean(1.4, 1.7) < 0.9 && mean(1.95, 2.2) > 1.05, "{} {}", mean(1.4, 1.7), mean(1.95, 2.2));
    assert!((mean(3.2, 4.0) - 1.0).abs() < 0.03, "{}", mean(3.2, 4.0));
    // Bonds of spheres that do not overlap are at least 49 degrees apart; beyond, no angle is missing.
    for point in angles.points().unwrap() {
        let (apart, value) = (point.degrees.min(360.0 - point.degrees), point.angular_distribution.mean);
        let fits = if apart < 45.0 { value < 0.01 } else { apart < 55.0 || value > 0.4 };
        assert!(fits, "{value} at {}", point.degrees);
    }
    let (local, global) = (hexatic.local().unwrap(), hexatic.global().unwrap());
    assert!(local.mean < 0.7 && global.mean < 0.25, "{local} {global}");
    let all = structure.over(1.0, 13.0).unwrap();
    assert!(all.fluid.mean > 0.99 && all.fluid.standard_error < 0.01, "{}", all.fluid);
    assert_eq!(structure.front().unwrap(), None);
}

/// Close-packed layers on the base, stacked as the letters say.
struct Stacked {
    letters: &'static str,
    spacing: f64,
    layer_distance: f64,
    columns: u32,
    rows: u32,
}

impl Stacked {
    fn widths(&self) -> [f64; 2] {
        [f64::from(self.columns) * self.spacing, f64::from(self.rows) * self.spacing * 3.0_f64.sqrt()]
    }

    fn positions(&self) -> Vec<Vector3<f64>> {
        let (row, widths) = (self.spacing * 3.0_f64.sqrt(), self.widths());
        let mut positions = Vec::new();
        for (layer, letter) in self.letters.bytes().enumerate() {
            for site in 0..2 * self.columns * self.rows {
                let (half, column, line) = (site % 2, site / 2 % self.columns, site / 2 / self.columns);
                let y = (f64::from(column) + 0.5 * f64::from(half)) * self.spacing;
                let z = (f64::from(line) + 0.5 * f64::from(half) + f64::from(letter - b'A') / 3.0) * row;
                positions.push(Vector3::new(0.5 + layer as f64 * self.layer_distance, y, z % widths[1]));
            }
        }
        positions
    }
}

/// Fraction of the spheres of a crystal between two walls that are recognized layer by layer, with
/// the thermal noise of hard spheres at this packing fraction.
fn recognized(packing_fraction: f64) -> f64 {
    let density = packing_fraction * 6.0 / std::f64::consts::PI;
    let spacing = (2.0_f64.sqrt() / density).cbrt();
    let layer_distance = spacing * (2.0_f64 / 3.0).sqrt();
    let crystal = Stacked { letters: "ABCBABACBCACBC", spacing, layer_distance, columns: 8, rows: 5 };
    let [width_y, width_z] = crystal.widths();
    let slab = Slab::new(1.0 + 13.0 * layer_distance + 0.8 * (spacing - 1.0), width_y, width_z).unwrap();
    let positions = crystal.positions();
    let scene = column(slab, positions.len(), 0.0, 1.0);
    let builder =
        Simulation::builder(scene).start(Positions(positions)).moves(LocalMoves::new(0.12).unwrap());
    let mut simulation = builder.seed(3).build().unwrap();
    let letters = crystal.letters.as_bytes();
    let mut order = BondOrder::new(&slab);
    let (mut right, mut all) = (0, 0);
    for _ in 0..10 {
        simulation.equilibrate(200, &mut ()).unwrap();
        order.gather(simulation.positions());
        for sphere in 0..order.count() {
            let layer = sphere / 80;
            let Some(structure) = order.structure(sphere) else {
                assert!(layer == 0 || layer == 13);
                continue;
            };
            let hexagonal = letters[layer - 1] == letters[layer + 1];
            let expected =
                if hexagonal { Structure::HexagonalClosePacked } else { Structure::FaceCenteredCubic };
            right += i32::from(structure == expected);
            all += 1;
        }
    }
    assert_eq!(all, 10 * 80 * 12);
    f64::from(right) / f64::from(all)
}

#[test]
fn stackings_are_recognized_under_thermal_noise() {
    let (melting, denser) = (recognized(0.545), recognized(0.58));

    assert!(melting > 0.96 && denser > 0.985, "{melting} {denser}");
}

/// A crystal that stands on the base under its own weight stays what it was, melts at the top where
/// the pressure is below that of coexistence, P/T = 11.57, and shows its layers.
#[test]
fn crystals_under_their_weight_keep_their_stacking() {
    let temperature = 0.5;
    for (letters, cubic) in [("ABCABCABCABCABCA", true), ("ABABABABABABABAB", false)] {
        let crystal = Stacked { letters, spacing: 1.06, layer_distance: 0.9, columns: 8, rows: 4 };
        let [width_y, width_z] = crystal.widths();
        let slab = Slab::new(30.0, width_y, width_z).unwrap();
        let positions = crystal.positions();
        let scene = column(slab, positions.len(), 1.0, temperature);
        let builder =
            Simulation::builder(scene).start(Positions(positions)).moves(LocalMoves::new(0.15).unwrap());
        let mut simulation = builder.seed(4).build().unwrap();
        simulation.equilibrate(6000, &mut ()).unwrap();
        let mut density = DensityProfile::new(&slab, Bins::count(800).from(0.5).to(20.5)).unwrap();
        let mut structure = StructureProfile::new(&slab, Bins::count(30)).unwrap();
        let mut distribution = RadialDistribution::new(&slab, 0.5, 0.6, 100).unwrap();
        let mut angles = NeighborAngles::new(&slab, 0.5, 0.6, 72).unwrap();
        let mut hexatic = HexaticOrder::new(&slab, 0.5, 0.9, 1.4).unwrap();
        let in_plane = Every::new(10, (&mut distribution, &mut angles, &mut hexatic));
        let profiles = (Every::new(4, &mut density), Every::new(60, &mut structure));
        simulation.run(40_000, &mut (profiles, in_plane)).unwrap();

        let below = structure.over(1.0, 7.0).unwrap();
        let right = if cubic { below.face_centered_cubic } else { below.hexagonal_close_packed };
        assert!(right.mean > 0.98 && right.standard_error < 0.01, "{letters}: {right}");
        let above = structure.over(12.0, 20.0).unwrap();
        assert!(above.fluid.mean > 0.99, "{}", above.fluid);
        // The fluid weighs what coexistence can bear, within one layer: the crystal is strained, and melts
        // layer by layer.
        let front = structure.front().unwrap().unwrap();
        let fluid = |densities: &[f64]| {
            let above =
                densities.iter().enumerate().filter(|(bin, _)| 0.5 + 0.025 * *bin as f64 > front.mean);
            [0.025 * above.map(|(_, density)| density).sum::<f64>()]
        };
        let fluid = density.jackknife(fluid).unwrap()[0];
        println!("{letters}: front {front}, fluid {fluid}");
        assert!(front.standard_error < 0.3, "{front}");
        assert!((fluid.mean - 11.57 * temperature).abs() < 1.0, "{fluid} above {front}");

        // Layers come farther apart upwards, each of as many spheres as a lattice plane has.
        let layers = density.layers(0.5).unwrap();
        assert!(layers.len() >= 8, "{}", layers.len());
        for layer in &layers[2..8] {
            let (spacing, spheres) = (layer.spacing, layer.lateral_density);
            assert!(spacing.mean > 0.84 && spacing.mean < 0.91 && spacing.standard_error < 0.01, "{spacing}");
            assert!((spheres.mean - 64.0 / slab.base_area()).abs() < 0.01, "{spheres}");
        }
        let rise = layers[7].spacing.minus_independent(layers[2].spacing);
        assert!(rise.deviation_from(0.0) > 4.0, "{rise}");

        // The first layer is a hexagonal lattice.
        let points = distribution.points().unwrap();
        let width = 2.0 * points[0].distance;
        let near = |distance: f64| {
            let inside = points.iter().filter(|point| (point.distance - distance).abs() < 1.01 * width);
            inside.map(|point| point.radial_distribution.mean).fold(0.0, f64::max)
        };
        for squared in [1.0_f64, 3.0, 4.0, 7.0] {
            let peak = near(1.06 * squared.sqrt());
            assert!(peak > 2.0, "{peak} at the root of {squared}");
        }
        assert!(near(1.45) < 0.01, "{}", near(1.45));
        for point in angles.points().unwrap() {
            let value = point.angular_distribution.mean;
            let from_peak = ((point.degrees + 30.0).rem_euclid(60.0) - 30.0).abs();
            let fits = if from_peak < 1.0 && point.degrees > 1.0 {
                value > 5.0
            } else {
                from_peak < 24.0 || value < 0.05
            };
            assert!(fits, "{value} at {}", point.degrees);
        }
        assert!(hexatic.local().unwrap().mean > 0.9 && hexatic.global().unwrap().mean > 0.9);
    }
}

/// A column that starts far too high: where it becomes steady is found, what follows agrees with a
/// run that starts near the steady state, and the whole series does not.
#[test]
fn relaxation_of_a_column_is_found() {
    let slab = Slab::new(120.0, 6.0, 6.0).unwrap();
    let heights = |start_high: bool| {
        let scene = column(slab, 360, 1.0, 5.0);
        let mut center = CenterOfMass::new();
        let builder = Simulation::builder(scene).moves(LocalMoves::new(3.0).unwrap()).seed(5);
        if start_high {
            builder.start(RandomInsertion::default()).build().unwrap().run(20_000, &mut center).unwrap();
        } else {
            builder.start(Theory).build().unwrap().run(20_000, &mut center).unwrap();
        }
        center
    };
    let (high, near) = (heights(true), heights(false));
    let reference = near.equilibrated().unwrap().estimate().unwrap();
    let differs = |estimate: Estimate| estimate.minus_independent(reference).deviation_from(0.0);
    let found = high.equilibration().unwrap();
    println!("{found:?}");
    assert!(found.start > 30 && found.start < 6000, "{found:?}");
    let estimate = high.equilibrated().unwrap().estimate().unwrap();
    assert!(differs(estimate).abs() < 4.0 && estimate.standard_error < 0.2, "{estimate} {reference}");
    // No trimming fails: the relaxation is in the mean, and no error of the steady state covers it.
    let whole = Estimate::new(high.estimate().unwrap().mean, estimate.standard_error);
    assert!(differs(whole) > 4.0, "{whole} {reference}");
}
