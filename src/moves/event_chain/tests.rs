//! Rules for field events, right and wrong, against the exact mean height of two spheres.

use super::stall_guard::StallGuard;
use super::*;
use crate::Field;
use crate::field::{ExponentialField, LinearField, UniformField};
use crate::frame::Phase;
use crate::observer::AcceptedMove;
use crate::observers::CenterOfMass;
use crate::start::RandomInsertion;
use crate::temperature::Isothermal;
use crate::{Every, Frame, Observer, ObserverError, Recorder, Scene, Simulation, Slab};

pub(super) const SIDE: f64 = 3.0;

/// Two spheres closer than this are near contact.
pub(super) const NEAR: f64 = 1.03;

/// Mean height of two spheres over a base 3 x 3, their mean difference in height, and how often
/// they are near contact, by Simpson's rule in both heights: weight exp(-u(x) - u(x')) [A - π(1 - Δ²)₊].
pub(super) fn exact_moments(height: f64, potential: impl Fn(f64) -> f64) -> [f64; 3] {
    const PANELS: usize = 1500;
    let width = (height - 1.0) / (2 * PANELS) as f64;
    let nodes: Vec<(f64, f64)> = (0..=2 * PANELS)
        .map(|node| {
            let x = 0.5 + node as f64 * width;
            let weight = if node == 0 || node == 2 * PANELS { 1.0 } else { (2 + 2 * (node % 2)) as f64 };
            (x, weight * libm::exp(-potential(x)))
        })
        .collect();
    let mut sums = [0.0; 4];
    for &(x, a) in &nodes {
        for &(y, b) in &nodes {
            let within =
                |distance: f64| std::f64::consts::PI * (distance * distance - (x - y) * (x - y)).max(0.0);
            let free = SIDE * SIDE - within(1.0);
            let near = within(NEAR) - within(1.0);
            for (sum, value) in sums.iter_mut().zip([free, 0.5 * (x + y) * free, (x - y).abs() * free, near])
            {
                *sum += a * b * value;
            }
        }
    }
    [sums[1] / sums[0], sums[2] / sums[0], sums[3] / sums[0]]
}

/// Deviation of the mean height from the exact one, in standard errors. A standard error is at most
/// 0.012, for a wrong rule 0.03.
fn deviation<F: Field>(rule: FieldEvent, height: f64, field: F, temperature: f64) -> f64 {
    let [exact, ..] = exact_moments(height, |x| field.potential(x) / temperature);
    let slab = Slab::new(height, SIDE, SIDE).unwrap();
    let scene = Scene::new(slab, 2, field, Isothermal::new(temperature).unwrap()).unwrap();
    let chains = EventChains::with_length(3.0).unwrap().field_event(rule).local_moves(None);
    let mut simulation = Simulation::builder(scene).moves(chains).seed(8).build().unwrap();
    let mut heights = Every::new(10, CenterOfMass::new());
    simulation.equilibrate(20_000, &mut ()).unwrap();
    simulation.run(600_000, &mut heights).unwrap();
    let estimate = heights.observer.estimate().unwrap();
    let deviation = estimate.deviation_from(exact);
    println!("{rule:?}: {estimate} against {exact:.4}, {deviation:.1} sigma");
    let right = matches!(rule, FieldEvent::Relocate | FieldEvent::Reverse);
    assert!(estimate.standard_error < if right { 0.012 } else { 0.03 }, "{rule:?}: {estimate}");
    deviation
}

#[test]
fn two_spheres_tell_right_rules_from_wrong_ones() {
    // A force that grows e-fold in three diameters.
    let exponential = |rule| deviation(rule, 12.0, ExponentialField::new(0.3).unwrap(), 4.0);
    // One that changes sign half way up.
    let valley = |rule| deviation(rule, 9.0, LinearField::new(-2.0, 0.5).unwrap(), 2.0);
    let lopsided = |rule| deviation(rule, 9.0, LinearField::new(-1.0, 0.5).unwrap(), 2.0);
    for rule in [FieldEvent::Relocate, FieldEvent::Reverse] {
        assert!(exponential(rule).abs() < 4.0);
        assert!(valley(rule).abs() < 4.0);
    }
    assert!(lopsided(FieldEvent::Relocate).abs() < 4.0);
    assert!(exponential(FieldEvent::Unweighted) > 4.0);
    assert!(exponential(FieldEvent::Uphill) > 4.0);
    assert!(lopsided(FieldEvent::Unweighted) > 4.0);
    assert!(lopsided(FieldEvent::Uphill) > 4.0);
}

#[test]
fn a_chain_that_does_not_advance_is_given_up() {
    for (phase, least, most) in [
        (Phase::Equilibration, StallGuard::PIECES_IN_EQUILIBRATION, StallGuard::PIECES_IN_EQUILIBRATION),
        (Phase::Production, StallGuard::PIECES, StallGuard::PIECES),
    ] {
        let mut stall_guard = StallGuard::new(2.0, phase);
        let mut pieces = 1;
        // The chain stops after half a diameter.
        while matches!(stall_guard.lasts(1.5), Ok(true)) {
            pieces += 1;
        }
        assert!(pieces >= least && pieces <= most);
        // One diameter in 5000 pieces is enough.
        let mut stall_guard = StallGuard::new(1000.0, phase);
        for piece in 0..4_000_000 {
            assert!(stall_guard.lasts(1000.0 - f64::from(piece) / 5000.0).unwrap());
        }
    }
    // A diameter in 100 000 pieces is not, for a long chain.
    let mut stall_guard = StallGuard::new(1000.0, Phase::Production);
    let stuck = (1..=2 * StallGuard::PIECES_OF_A_CHAIN)
        .find(|&piece| stall_guard.lasts(1000.0 - f64::from(piece) / 100_000.0).is_err());
    assert_eq!(stuck, Some(StallGuard::PIECES_OF_A_CHAIN));
}

/// Paths of chains, and of the moves that they consist of.
#[derive(Debug, Default)]
struct Paths {
    chains: f64,
    moves: f64,
    /// Lengths of the vertical chains.
    vertical: Vec<f64>,
}

impl Observer for Paths {
    fn observe(&mut self, _: &Frame<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for Paths {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        self.moves += accepted.displacement.norm();
    }
    fn record_chain(&mut self, axis: usize, length: f64) {
        self.chains += length;
        if axis == 0 {
            self.vertical.push(length);
        }
    }
}

/// In a force of 10⁵ a chain has so many field events that it is given up, after a path of about a
/// tenth of a diameter.
#[test]
fn chains_that_are_given_up_are_as_long_as_their_path() {
    let slab = Slab::new(6.0, 4.0, 4.0).unwrap();
    let scene = Scene::new(slab, 8, UniformField::default(), Isothermal::new(1e-5).unwrap()).unwrap();
    let chains = EventChains::with_length(0.5).unwrap().local_moves(None);
    let mut simulation =
        Simulation::builder(scene).moves(chains).start(RandomInsertion::default()).seed(3).build().unwrap();
    let mut paths = Paths::default();
    simulation.equilibrate(12_000, &mut paths).unwrap();
    // The mean length would be 0.5 if none were given up.
    let mean = paths.vertical.iter().sum::<f64>() / paths.vertical.len() as f64;
    assert!(paths.vertical.len() > 20 && mean < 0.25, "{mean} of {}", paths.vertical.len());
    approx::assert_relative_eq!(paths.chains, paths.moves, max_relative = 1e-9);
}
