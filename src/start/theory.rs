//! The hydrostatic profile as a start.

use super::Start;
use super::close_packed::Lattice;
use crate::equation_of_state::{FluidSolid, ModifiedKolafa};
use crate::{AnyScene, Error, Generator};
use nalgebra::Vector3;

/// Spheres on random sites of a close-packed lattice, with as many in each layer as the hydrostatic
/// profile of the scene has there. The profile is that of the modified Kolafa-Labík-Malijevský
/// fluid and the Speedy solid, or of the fluid alone in a partly frozen box without a field, where
/// the solid can be anywhere.
///
/// The lattice allows any packing. Its vacancies let it melt within about five hundred sweeps
/// wherever the fluid is stable. The column as a whole starts close to its steady state, which
/// saves the slowest part of the equilibration. This start alone does **not** show that a run has
/// reached the steady state: compare runs from [`RandomInsertion`](super::RandomInsertion) and
/// [`ClosePacked`](super::ClosePacked).
///
/// ```
/// use gradient_mc::equation_of_state::ModifiedKolafa;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, start::Theory, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// // The default: `.start(Theory)` may be left out.
/// let simulation = Simulation::builder(scene).start(Theory).build()?;
/// let center_of_mass = simulation.frame().heights().sum::<f64>() / 360.0;
/// assert!((center_of_mass - scene.hydrostatics(&ModifiedKolafa)?.center_of_mass()).abs() < 0.5);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Theory;

impl Start for Theory {
    /// # Errors
    /// What [`Scene::hydrostatics`](crate::Scene::hydrostatics) returns, and
    /// [`Error::LatticeFull`] when the lattice that fits the slab
    /// has too few sites.
    fn place(&self, scene: &AnyScene<'_>, generator: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
        by_quantiles(scene, generator, || {
            let equation_of_state = FluidSolid::default();
            let profile = scene.hydrostatics(&equation_of_state).or_else(|error| match error {
                Error::HydrostaticsNotConverged { .. } => scene.hydrostatics(&ModifiedKolafa),
                error => Err(error),
            })?;
            let (_, densest) = profile.density_maximum();
            Ok((densest, move |fraction| profile.height_of_fraction(fraction)))
        })
    }
}

/// Places spheres on sites of a lattice by a profile, which is given as its largest density and the
/// height below which a fraction of the spheres lies.
pub(super) fn by_quantiles<Q: Fn(f64) -> f64>(
    scene: &AnyScene<'_>,
    generator: &mut Generator,
    profile: impl FnOnce() -> Result<(f64, Q), Error>,
) -> Result<Vec<Vector3<f64>>, Error> {
    // Sites per sphere where the profile is densest, for enough vacancies.
    const ROOM: f64 = 1.15;
    let slab = scene.slab();
    let mut lattice = Lattice::densest(slab);
    // Checked before the profile, which also fails for too many spheres, with a less clear error.
    if scene.particles() > lattice.capacity() {
        return Err(Error::LatticeFull { sites: lattice.capacity(), particles: scene.particles() });
    }
    let (densest, height_of_fraction) = profile()?;
    lattice.stretch((lattice.number_density(slab) / (ROOM * densest)).clamp(1.0, 1.5), slab);
    let particles = scene.particles() as f64;
    // Heights of the spheres are quantiles of the profile; each sphere goes to the nearest layer.
    let mut counts = vec![0; lattice.layers()];
    for sphere in 0..scene.particles() {
        let height = height_of_fraction((sphere as f64 + 0.5) / particles);
        let layer = ((height - slab.lowest_center()) / lattice.spacing() + 0.5).max(0.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let layer = (layer as usize).min(lattice.layers() - 1);
        counts[layer] += 1;
    }
    lattice.fill(scene, generator, |layer| counts[layer])
}

#[cfg(test)]
mod tests {
    use crate::equation_of_state::number_density;
    use crate::field::UniformField;
    use crate::temperature::Isothermal;
    use crate::{Scene, Simulation, Slab};

    /// Between freezing and melting, where fluid and solid can be anywhere without a field.
    #[test]
    fn a_half_frozen_box_without_weight_starts() {
        for packing_fraction in [0.49, 0.5, 0.53] {
            let height = 1000.0 / (100.0 * number_density(packing_fraction));
            let slab = Slab::new(height, 10.0, 10.0).unwrap();
            let field = UniformField::new(0.0).unwrap();
            let scene = Scene::new(slab, 1000, field, Isothermal::new(20.0).unwrap()).unwrap();
            Simulation::builder(scene).seed(1).build().unwrap();
        }
    }
}
