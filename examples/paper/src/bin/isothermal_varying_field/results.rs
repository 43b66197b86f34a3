//! The results of all runs, from which the figures are made.

use super::column::{Column, Run, plateau, pooled};
use super::crystal::Crystal;
use super::protocol::Protocol;
use gradient_mc::equation_of_state::{FluidSolid, ModifiedKolafa};
use gradient_mc::hydrostatics::HydrostaticProfile;
use gradient_mc::observers::{DisplacementProfile, EquationOfStateProfile};
use gradient_mc::statistics::Estimate;
use paper::Failure;
use paper::figure::RGBColor;
use paper::figure::colors;

/// A column that stays fluid.
#[derive(Debug, Clone)]
pub(crate) struct Fluid {
    pub(crate) column: Column,
    /// By the paper's moves, on a base of their own unless with --paper.
    pub(crate) relaxation: Run,
    /// By our moves, from the same start.
    pub(crate) runs: Vec<Run>,
    pub(crate) profile: EquationOfStateProfile,
    /// Of `h_c`, after the equilibration that the data show.
    pub(crate) plateau: Estimate,
    /// The sweeps at which that was over, of each run, where the data show it.
    pub(crate) beginnings: Vec<Option<u64>>,
    pub(crate) mobility: DisplacementProfile,
    pub(crate) theory: HydrostaticProfile,
}

impl Fluid {
    pub(crate) fn new(
        column: Column,
        relaxation: Run,
        runs: Vec<Run>,
        equilibration: u64,
        seed: u64,
    ) -> Result<Self, Failure> {
        let profile = pooled(runs.iter().flat_map(|run| &run.profiles))?;
        let (steady, beginnings) = plateau(&runs, equilibration)?;
        let plateau = steady.estimate()?;
        let positions = &runs.first().ok_or("no run")?.positions;
        Ok(Self {
            column,
            profile,
            plateau,
            beginnings,
            mobility: column.mobility(positions, seed)?,
            theory: column.theory(ModifiedKolafa)?,
            relaxation,
            runs,
        })
    }

    /// α as it stands in legends.
    pub(crate) fn label(&self) -> String {
        format!("α = {}", self.column.rate)
    }
}

/// Everything.
#[derive(Debug, Clone)]
pub(crate) struct Results {
    pub(crate) fluids: Vec<Fluid>,
    pub(crate) crystals: Vec<Crystal>,
    pub(crate) paper: bool,
}

impl Results {
    /// The crystal that the figures show.
    pub(crate) fn shown(&self) -> Result<&Crystal, Failure> {
        self.crystals.first().ok_or_else(|| "no crystal was grown".into())
    }
}

/// The theory of the column that freezes: fluid above, crystal below.
pub(crate) fn frozen_theory(column: Column) -> Result<HydrostaticProfile, Failure> {
    column.theory(FluidSolid::default())
}

/// Where that theory has its front: the height of the pressure of coexistence, which the jump of n
/// makes plain.
pub(crate) fn front_of(theory: &HydrostaticProfile) -> f64 {
    let level = FluidSolid::default().coexistence().reduced_pressure * Protocol::TEMPERATURE;
    let (mut low, mut high) = (theory.base(), 60.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if theory.pressure(middle) > level {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// Colors of the four α, from the least to the largest.
pub(crate) const COLORS: [RGBColor; 4] = [colors::BLUE, colors::GREEN, colors::PURPLE, colors::VERMILION];

/// The color of the α nearest to this one.
pub(crate) fn color_of(rate: f64) -> RGBColor {
    let rates = Protocol::FLUID_RATES.into_iter().chain([Protocol::CRYSTAL_RATE]);
    let nearest =
        rates.zip(COLORS).min_by(|first, second| (first.0 - rate).abs().total_cmp(&(second.0 - rate).abs()));
    nearest.map_or(colors::INK, |(_, color)| color)
}
