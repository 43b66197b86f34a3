use super::grid::Grid;
use super::moments::Moments;
use super::*;
use crate::equation_of_state::{CarnahanStarling, EquationOfState, PercusYevickCompressibility};
use crate::legendre::Legendre;

/// A functional, and its uniform fluid if that has a name.
type Known = (Box<dyn Functional>, Option<Box<dyn EquationOfState>>);

fn all() -> Vec<Known> {
    vec![
        (Box::new(Rosenfeld), Some(Box::new(PercusYevickCompressibility))),
        (Box::new(WhiteBear), Some(Box::new(CarnahanStarling))),
        (Box::new(WhiteBear2), Some(Box::new(CarnahanStarling))),
        (Box::new(Lutsko::TARAZONA), Some(Box::new(PercusYevickCompressibility))),
        (Box::new(Lutsko::STABLE), None),
        (Box::new(Lutsko::new(1.2, -0.7).unwrap()), None),
    ]
}

#[test]
fn derivatives_are_those_of_the_free_energy() {
    for (functional, _) in all() {
        // On both sides of where the power series end.
        for packing in [0.01, 0.049, 0.051, 0.2, 0.45, 0.7] {
            let weighted = WeightedDensities { packing, surface: 1.3, vector: -0.6, tensor: 0.9 };
            let energy = functional.free_energy(&weighted);
            let slope = |change: &dyn Fn(&mut WeightedDensities, f64)| {
                let at = |step: f64| {
                    let mut changed = weighted;
                    change(&mut changed, step);
                    functional.free_energy(&changed).density
                };
                (8.0 * (at(1e-3) - at(-1e-3)) - (at(2e-3) - at(-2e-3))) / 12e-3
            };
            for (value, found) in [
                (energy.by_packing, slope(&|n, step| n.packing += step)),
                (energy.by_surface, slope(&|n, step| n.surface += step)),
                (energy.by_vector, slope(&|n, step| n.vector += step)),
                (energy.by_tensor, slope(&|n, step| n.tensor += step)),
            ] {
                approx::assert_relative_eq!(value, found, max_relative = 1e-7, epsilon = 1e-7);
            }
        }
    }
}

#[test]
fn uniform_fluids_are_the_known_ones() {
    for (functional, known) in all() {
        let Some(known) = known else { continue };
        let bulk = Bulk(functional);
        for eta in [1e-6, 0.01, 0.0499, 0.0501, 0.2, 0.45, 0.6] {
            let (own, there) = (bulk.compressibility_factor(eta), known.compressibility_factor(eta));
            approx::assert_relative_eq!(own, there, max_relative = 1e-12);
            let (own, there) = (bulk.excess_chemical_potential(eta), known.excess_chemical_potential(eta));
            approx::assert_relative_eq!(own, there, max_relative = 1e-12);
        }
    }
    // 8A + 2B = 9 makes the third virial coefficient 10; it is 3(8A + 2B)/9 + 7.
    let eta = 1e-4;
    let third = (Bulk(Lutsko::STABLE).compressibility_factor(eta) - 1.0 - 4.0 * eta) / (eta * eta);
    approx::assert_relative_eq!(third, 7.0 + 8.0 / 3.0, max_relative = 1e-3);
}

/// The averages of polynomials, also where panels end within a sphere, and of a fluid that ends.
#[test]
fn moments_are_exact() {
    let rule = Legendre::new();
    let grid = Grid::with_edges(&rule, vec![0.0, 0.3, 0.5, 1.7, 4.0]);
    let values: Vec<f64> = grid.nodes.iter().map(|x| 1.0 + x * (0.5 - 0.1 * x)).collect();
    let heights = [-0.4, 0.0, 0.2, 0.5, 1.1, 2.0, 3.5, 4.2];
    let moments = Moments::new(&rule, &grid, &heights);
    for (height, moments) in heights.into_iter().zip(moments.of(&values)) {
        // By Simpson's rule with Richardson extrapolation, which is exact up to fourth order.
        let exact = |power: u32| {
            let (low, high) = ((height - RADIUS).max(0.0), (height + RADIUS).min(4.0));
            crate::numerics::integrate_panel(
                |x| (0..power).fold(1.0 + x * (0.5 - 0.1 * x), |product, _| product * (x - height)),
                low,
                high,
            )
        };
        for (power, moment) in (0..3).zip(moments) {
            approx::assert_relative_eq!(moment, exact(power), epsilon = 1e-14, max_relative = 1e-13);
        }
    }
}

/// The derivative of ∫Φ dx by n against differences of it, for a layered profile that ends at
/// walls.
#[test]
fn the_functional_derivative_is_that_of_the_free_energy() {
    const STEP: f64 = 1e-4;
    let rule = Legendre::new();
    let grid = Grid::new(&rule, [0.5, 4.2], [true, true]);
    let extended = grid.extended(&rule);
    let (to, from) =
        (Moments::new(&rule, &grid, &extended.nodes), Moments::new(&rule, &extended, &grid.nodes));
    let densities: Vec<f64> =
        grid.nodes.iter().map(|&x| 0.5 + 0.3 * libm::cos(6.0 * x) * libm::exp(0.5 - x)).collect();
    // A bump of the density, wide enough for the polynomials.
    let bump: Vec<f64> = grid.nodes.iter().map(|&x| libm::exp(-2.0 * (x - 1.4) * (x - 1.4))).collect();
    for (functional, _) in all() {
        let energies = |densities: &[f64]| -> Vec<FreeEnergy> {
            to.of(densities)
                .map(|moments| functional.free_energy(&WeightedDensities::from_moments(moments)))
                .collect()
        };
        let total = |step: f64| {
            let changed: Vec<f64> = densities.iter().zip(&bump).map(|(n, bump)| n + step * bump).collect();
            extended.integrate(energies(&changed).iter().map(|energy| energy.density))
        };
        let found =
            (8.0 * (total(STEP) - total(-STEP)) - (total(2.0 * STEP) - total(-2.0 * STEP))) / (12.0 * STEP);
        let forces: Vec<[f64; 3]> = energies(&densities).iter().map(FreeEnergy::for_moments).collect();
        let expected =
            grid.integrate(from.sums(&forces).zip(&bump).map(|(derivative, bump)| derivative * bump));
        approx::assert_relative_eq!(found, expected, max_relative = 1e-9);
    }
}

/// The profile on panels half as wide is the same.
#[test]
fn the_grid_does_not_matter() {
    use super::potential::Potential;
    use super::solution::{Given, Problem};
    use crate::Wall;
    use crate::field::UniformField;
    use crate::temperature::Isothermal;
    let rule = Legendre::new();
    let (field, temperature) = (UniformField::default(), Isothermal::new(1.5).unwrap());
    let ends = [0.5, 20.0];
    let solved = |grid: Grid| {
        let potential = Potential::new(&field, &temperature, Some(1.5), &grid, Wall::Lid, 1.5).unwrap();
        let start = grid.nodes.iter().map(|height| -height / 4.0).collect();
        let problem = Problem::new(&rule, &WhiteBear2, grid, potential, Given::ColumnDensity(8.0));
        let solution = problem.solve(start).unwrap();
        let heights = [0.5, 0.6, 0.9, 1.3, 1.499, 1.501, 2.2, 3.7, 8.0, 15.0, 20.0];
        heights.map(|height| problem.grid.interpolate(&rule, &solution.logarithms, height))
    };
    let usual = Grid::new(&rule, ends, [true, true]);
    let fine = usual.halved(&rule, &(0..usual.panels().len()).collect::<Vec<_>>());
    for (usual, fine) in solved(usual).into_iter().zip(solved(fine)) {
        assert!((usual - fine).abs() < 1e-7, "{:e}", usual - fine);
    }
}
