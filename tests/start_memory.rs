//! What a start takes: memory in proportion to the number of spheres, not to the volume of the slab.

#![allow(clippy::unwrap_used)]

use gradient_mc::field::UniformField;
use gradient_mc::start::{ClosePacked, Start, Theory};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Generator, Scene, Slab};
use rand::SeedableRng;

#[test]
fn few_spheres_in_a_wide_slab_take_little_memory() {
    let slab = Slab::new(2.0, 1e4, 1e4).unwrap();
    for spheres in [1, 1000] {
        let scene = Scene::new(slab, spheres, UniformField::default(), Isothermal::new(1.0).unwrap());
        let scene = scene.unwrap();
        let mut generator = Generator::seed_from_u64(1);
        let counted = [
            allocation_counter::measure(|| {
                assert_eq!(ClosePacked.place(&scene, &mut generator).unwrap().len(), spheres);
            }),
            allocation_counter::measure(|| {
                let generator = &mut Generator::seed_from_u64(1);
                assert_eq!(Theory.place(&scene, generator).unwrap().len(), spheres);
            }),
        ];
        for counted in counted {
            assert!(counted.bytes_max < 4_000_000, "{} bytes for {spheres} spheres", counted.bytes_max);
        }
    }
}
