//! One event chain.

use super::FieldEvent;
use super::constraints::Links;
use super::stall_guard::StallGuard;
use super::visit::{Common, Frozen, Outcome, Tile};
use crate::drive::Drive;
use crate::observer::ChainPiece;
use crate::random::{Generator, exponential, index, unit};
use crate::{Error, Field, TemperatureProfile};

/// What ends a straight piece of a chain.
enum Stop {
    /// The chain has used up its length.
    End,
    Contact {
        sphere: usize,
        reach: f64,
    },
    Wall,
    /// A thinning event. It is a field event if the true force confirms it.
    Field {
        bound: f64,
    },
}

impl Tile {
    /// Runs a chain. `left` is the length still to go: at the end zero, unless the chain is given
    /// up or fails. `forward` is the direction along the axis: at the end, that of the last piece.
    pub(super) fn chain<
        F: Field,
        T: TemperatureProfile,
        D: Drive<F, T>,
        const VERTICAL: bool,
        const RECORD: bool,
    >(
        &mut self,
        common: &Common<'_, F, T, D>,
        left: &mut f64,
        forward: &mut bool,
        generator: &mut Generator,
        outcome: &mut Outcome,
    ) -> Result<(), Error> {
        let slab = common.scene.slab();
        let (lowest, highest) = (slab.lowest_center(), slab.highest_center());
        let mut sphere = index(generator, self.mobile);
        let mut stall_guard = StallGuard::new(*left, common.phase);
        // The integral of the bound of the force along the path up to the next thinning event.
        let mut until_event = if VERTICAL { exponential(generator) } else { f64::INFINITY };
        loop {
            let from = self.along[sphere];
            let sign = if *forward { 1.0 } else { -1.0 };
            let (mut distance, mut stop) = (*left, Stop::End);
            if VERTICAL {
                let to_wall = if *forward { highest - from } else { from - lowest };
                if to_wall < distance {
                    (distance, stop) = (to_wall, Stop::Wall);
                }
            }
            let (mut nearest, mut touched, mut touch) = (distance, u32::MAX, 0.0);
            let mut links = Some(self.constraints.links(sphere, *forward));
            while let Some(row) = links {
                for slot in 0..Links::SLOTS {
                    let (other, reach) = (row.other[slot], row.reach[slot]);
                    let gap = sign * (self.along[other as usize] - from) - reach;
                    if gap < nearest {
                        (nearest, touched, touch) = (gap, other, reach);
                    }
                }
                links = self.constraints.more(row);
            }
            if touched != u32::MAX {
                // A pair that overlaps by rounding collides at once.
                distance = nearest.max(0.0);
                stop = Stop::Contact { sphere: touched as usize, reach: touch };
            }
            if VERTICAL
                && let Some((event, bound)) =
                    common.bounds.thinning_event(&mut until_event, from, *forward, distance)
            {
                (distance, stop) = (event, Stop::Field { bound });
            }
            let signed = sign * distance;
            let to = if VERTICAL { (from + signed).clamp(lowest, highest) } else { from + signed };
            self.along[sphere] = to;
            *left -= distance;
            if RECORD {
                let from_height = if VERTICAL { from } else { self.heights[sphere] };
                outcome.pieces.push(ChainPiece::free(from_height, signed));
            }
            if !stall_guard.lasts(*left)? {
                return Ok(());
            }
            match stop {
                Stop::End => return Ok(()),
                Stop::Wall => {
                    outcome.events += 1;
                    *forward = !*forward;
                }
                Stop::Contact { sphere: other, reach } => {
                    outcome.events += 1;
                    if RECORD && let Some(piece) = outcome.pieces.last_mut() {
                        let heights = if VERTICAL { &self.along } else { &self.heights };
                        let period = if VERTICAL { 0.0 } else { common.grid.widths[common.axis - 1] };
                        // Spheres in contact are at most one diameter apart, and a period is at
                        // least three.
                        let separation = if reach < -0.5 { reach + period } else { reach };
                        piece.collide(heights[other], separation);
                    }
                    if other < self.mobile {
                        sphere = other;
                    } else {
                        match common.frozen {
                            Frozen::Turns => *forward = !*forward,
                            #[cfg(test)]
                            Frozen::Ends => return Ok(()),
                        }
                    }
                }
                Stop::Field { bound } => {
                    until_event = exponential(generator);
                    let force = common.drive.reduced_force(common.scene, to);
                    let uphill = sign * force;
                    if uphill.is_nan() || uphill > bound {
                        return Err(Error::InvalidForce { height: to, force, bound });
                    }
                    if unit(generator) * bound < uphill {
                        outcome.events += 1;
                        outcome.field_events += 1;
                        stall_guard.field_event();
                        let force_of = |other: usize| {
                            (self.along[other], common.drive.reduced_force(common.scene, self.along[other]))
                        };
                        (sphere, *forward) =
                            field_event(common.rule, generator, self.mobile, sphere, force, force_of)?;
                    }
                }
            }
        }
    }
}

/// The sphere that moves on after a field event at `sphere`, and whether it moves up. `force` is
/// the reduced force at `sphere`; `force_of` gives height and force of each mobile sphere.
fn field_event(
    rule: FieldEvent,
    generator: &mut Generator,
    spheres: usize,
    sphere: usize,
    force: f64,
    force_of: impl Fn(usize) -> (f64, f64),
) -> Result<(usize, bool), Error> {
    /// Steps of the random walk over spheres. Balance holds for any number. With more steps, fewer
    /// chains reverse where forces differ much.
    const STEPS: u32 = 4;
    let (mut chosen, mut chosen_force) = (sphere, force);
    if rule != FieldEvent::Reverse {
        for _ in 0..STEPS {
            let other = index(generator, spheres);
            let (height, other_force) = force_of(other);
            if other_force.is_nan() {
                return Err(Error::InvalidForce { height, force: other_force, bound: f64::MAX });
            }
            #[cfg(test)]
            if rule == FieldEvent::Unweighted {
                (chosen, chosen_force) = (other, other_force);
                continue;
            }
            // Metropolis rule for the distribution |u'|.
            if other_force.abs() >= chosen_force.abs() * unit(generator) && other_force != 0.0 {
                (chosen, chosen_force) = (other, other_force);
            }
        }
    }
    #[cfg(test)]
    if rule == FieldEvent::Uphill {
        return Ok((chosen, chosen_force > 0.0));
    }
    Ok((chosen, chosen_force < 0.0))
}
