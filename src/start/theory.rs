//! The hydrostatic profile as a start.

use super::Start;
use super::close_packed::Lattice;
use crate::equation_of_state::{EquationOfState, FluidSolid, ModifiedKolafa};
use crate::hydrostatics::Hydrostatics;
use crate::{Error, Field, Generator, Scene, TemperatureProfile};
use nalgebra::Vector3;

/// Spheres on random sites of a close-packed lattice, as many in each layer as the hydrostatic
/// profile of the scene has there (modified Kolafa-Labík-Malijevský fluid, Speedy solid). Without weight and between
/// freezing and melting no such profile is the only one; then the fluid alone is taken, which is as dense everywhere.
///
/// The lattice makes any packing possible; its vacancies let it melt within some five hundred sweeps
/// wherever the fluid is stable. The column as a whole starts close to its steady state, which saves
/// the slowest part of the equilibration and **proves nothing by itself**: start from
/// [`RandomInsertion`](super::RandomInsertion) and [`ClosePacked`](super::ClosePacked) to see that they meet.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Theory;

impl Start for Theory {
    /// # Errors
    /// What [`Hydrostatics`] returns, and [`Error::LatticeFull`] when the lattice that fits the slab
    /// has too few sites.
    fn place<F: Field, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
        generator: &mut Generator,
    ) -> Result<Vec<Vector3<f64>>, Error> {
        // Sites per sphere where the profile is densest: enough vacancies to move.
        const ROOM: f64 = 1.15;
        let slab = scene.slab();
        let mut lattice = Lattice::densest(slab);
        if scene.particles() > lattice.capacity() {
            return Err(Error::LatticeFull { sites: lattice.capacity(), particles: scene.particles() });
        }
        let between_walls = |equation: &dyn EquationOfState| {
            Hydrostatics::new(scene.field(), scene.temperature(), equation)
                .between_walls(slab, scene.column_density())
        };
        // Where fluid and solid coexist at one pressure all the way up, each can be anywhere: a fluid that has not frozen
        // is everywhere alike.
        let profile = match between_walls(&FluidSolid::default()) {
            Err(error @ Error::HydrostaticsNotConverged { .. }) => {
                between_walls(&ModifiedKolafa).map_err(|_| error)?
            }
            other => other?,
        };
        let (_, densest) = profile.density_maximum();
        lattice.stretch((lattice.number_density(slab) / (ROOM * densest)).clamp(1.0, 1.5), slab);
        let particles = scene.particles() as f64;
        // Heights of the spheres are the quantiles of the profile; each goes to the layer it is in.
        let mut counts = vec![0; lattice.layers()];
        for sphere in 0..scene.particles() {
            let height = profile.height_of_fraction((sphere as f64 + 0.5) / particles);
            let layer = ((height - slab.lowest_center()) / lattice.spacing() + 0.5).max(0.0);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let layer = (layer as usize).min(lattice.layers() - 1);
            counts[layer] += 1;
        }
        lattice.fill(scene, generator, |layer| counts[layer])
    }
}
