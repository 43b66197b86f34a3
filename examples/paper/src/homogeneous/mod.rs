//! Ordinary Monte Carlo of one density in a periodic cube, by local moves or event chains, with
//! which the gradient is compared.
//!
//! | moves | Z = P/(nT) from |
//! |---|---|
//! | local | 1 + 4η g(1⁺), the contact value extrapolated (`contact`) |
//! | straight event chains | 1 + Σs/ℓ: s are the separations along the chain in all collisions, ℓ the length of all chains (Michel, Kapfer and Krauth, doi:10.1063/1.4863991) |
//!
//! Centers are stored by cell, relative to the corner of the cell, so that distances need no
//! periodic wrapping.

mod cells;
mod chain;
mod contact;
mod local;

use cells::Cells;
use contact::Contact;
use gradient_mc::Error;
use gradient_mc::equation_of_state::{CarnahanStarling, EquationOfState, number_density};
use gradient_mc::statistics::{BlockAverages, Estimate};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::FRAC_1_SQRT_2;

/// The moves of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Technique {
    /// As many trials as spheres.
    Local,
    /// About as many collisions as spheres.
    Chains,
}

/// Spheres at one packing fraction in a periodic cube.
#[derive(Debug, Clone)]
pub struct Homogeneous {
    cells: Cells,
    packing_fraction: f64,
    technique: Technique,
    maximum_displacement: f64,
    /// Chains of a sweep; their mean length is the side of the cube.
    chains: u64,
    contact: Contact,
    generator: Pcg64Mcg,
}

impl Homogeneous {
    /// Largest displacement that local moves may have.
    const LARGEST_DISPLACEMENT: f64 = 1.5;
    /// Acceptance to which displacements are tuned.
    const ACCEPTANCE: f64 = 0.35;
    /// Sweeps of local moves between two samples of the pairs near contact.
    const SWEEPS_BETWEEN_LOOKS: u64 = 2;

    /// 4k³ spheres on an fcc lattice, from which they melt.
    pub fn new(lattice: usize, packing_fraction: f64, technique: Technique, seed: u64) -> Self {
        let particles = 4 * lattice * lattice * lattice;
        let side = libm::cbrt(particles as f64 / number_density(packing_fraction));
        let mut cells = Cells::new(side);
        let spacing = side / lattice as f64;
        // In a perfect lattice chains make rings of touching spheres around the cube, and then never end.
        let jitter = 0.25 * (spacing * FRAC_1_SQRT_2 - 1.0).min(0.2);
        let mut generator = Pcg64Mcg::seed_from_u64(seed);
        for index in 0..particles {
            let (site, part) = (index / 4, index % 4);
            let corner = [site / (lattice * lattice), site / lattice % lattice, site % lattice];
            // Three of the four are shifted by half a cube along two axes.
            let shift = [[0.0, 0.0, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0]][part];
            let center = [0, 1, 2].map(|axis| {
                (corner[axis] as f64 + shift[axis] + 0.25) * spacing
                    + jitter * (2.0 * generator.random::<f64>() - 1.0)
            });
            cells.insert(center);
        }
        Self {
            cells,
            packing_fraction,
            technique,
            maximum_displacement: 0.2,
            chains: particles as u64 / 16,
            contact: Contact::new(),
            generator,
        }
    }

    /// Number of spheres.
    pub fn particles(&self) -> usize {
        self.cells.particles()
    }

    /// Smallest distance of two spheres; slow, for tests.
    #[allow(dead_code, reason = "for tests only")]
    pub fn smallest_distance(&self) -> f64 {
        self.cells.smallest_distance()
    }

    /// The largest displacement of local moves along each axis.
    #[allow(dead_code, reason = "not used by tests")]
    pub fn displacement(&self) -> f64 {
        self.maximum_displacement
    }

    /// Makes `sweeps` sweeps without sampling; returns the number of trials or collisions.
    #[allow(dead_code, reason = "not used by tests")]
    pub fn moves(&mut self, sweeps: u64) -> u64 {
        (0..sweeps)
            .map(|_| match self.technique {
                Technique::Local => {
                    self.local_sweep();
                    self.particles() as u64
                }
                Technique::Chains => self.chain_sweep().2,
            })
            .sum()
    }

    /// Equilibrates: melts the lattice, and tunes the moves.
    pub fn equilibrate(&mut self, sweeps: u64) {
        for _ in 0..sweeps {
            match self.technique {
                Technique::Local => {
                    let accepted = self.local_sweep();
                    let acceptance = accepted as f64 / self.particles() as f64;
                    let factor = if acceptance > Self::ACCEPTANCE { 1.02 } else { 1.0 / 1.02 };
                    self.maximum_displacement =
                        (self.maximum_displacement * factor).min(Self::LARGEST_DISPLACEMENT);
                }
                Technique::Chains => {
                    let chains = self.chains;
                    let (_, _, events) = self.chain_sweep();
                    let wanted = (chains * self.particles() as u64).div_ceil(events.max(1));
                    // Half way each time: the number of collisions fluctuates.
                    self.chains = chains.midpoint(wanted).max(1);
                }
            }
        }
    }

    /// Z for this number of spheres, from `sweeps` more sweeps; see [`finite_size`].
    pub fn measure(&mut self, sweeps: u64) -> Result<Estimate, Error> {
        match self.technique {
            Technique::Local => {
                let mut averages = BlockAverages::new(1)?;
                for sweep in 0..sweeps {
                    self.local_sweep();
                    if sweep.is_multiple_of(Self::SWEEPS_BETWEEN_LOOKS) {
                        averages.push(&[self.contact.value(&self.cells, self.packing_fraction)])?;
                    }
                }
                let contact = averages.estimates()?[0];
                let slope = 4.0 * self.packing_fraction;
                Ok(Estimate::new(1.0 + slope * contact.mean, slope * contact.standard_error))
            }
            Technique::Chains => {
                let mut averages = BlockAverages::new(2)?;
                for _ in 0..sweeps {
                    let (transferred, path, _) = self.chain_sweep();
                    averages.push(&[transferred, path])?;
                }
                Ok(averages.jackknife(|means| [1.0 + means[0] / means[1]])?[0])
            }
        }
    }

    fn local_sweep(&mut self) -> u64 {
        local::sweep(&mut self.cells, self.maximum_displacement, &mut self.generator)
    }

    /// Separations in all collisions, path and number of collisions.
    fn chain_sweep(&mut self) -> (f64, f64, u64) {
        chain::sweep(&mut self.cells, self.chains, &mut self.generator)
    }
}

/// Finite-size correction of Z for N spheres in a periodic cube, to order 1/N.
///
/// The canonical partition function is the grand one over √(2πNχ), χ = 1/(Z + dZ/d ln η) the
/// reduced compressibility; so `Z_N` = Z + (1/2N) d ln χ/d ln n (to lowest order in η it is the
/// factor 1 − 1/N of the second virial coefficient). χ after Carnahan and Starling is good to some
/// per cent of this correction.
pub fn finite_size(particles: usize, packing_fraction: f64) -> f64 {
    const STEP: f64 = 1e-3;
    let stiffness = |factor: f64| {
        let eta = packing_fraction * factor;
        let equation = CarnahanStarling;
        libm::log(equation.compressibility_factor(eta) + equation.compressibility_derivative(eta))
    };
    let slope = (stiffness(1.0 + STEP) - stiffness(1.0 - STEP)) / (2.0 * STEP);
    slope / (2.0 * particles as f64)
}
