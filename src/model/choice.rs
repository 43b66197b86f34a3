//! The candidates of the ladder for one scene, and the one that is enough.

use super::ideal_column::IdealColumn;
use super::outlook::Outlook;
use super::plan::{MonteCarloPlan, MoveFamily};
use super::reason::{Percent, Reason, Wall};
use super::total_variation;
use crate::{Error, Field, HydrostaticProfile, Scene, Slab, TemperatureProfile};
use std::fmt;

/// A way to the profile of a scene, from cheap to dear.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Model {
    /// Points, without a solver.
    IdealGas(IdealColumn),
    /// Hydrostatic balance between walls: the fluid of [`ModifiedKolafa`](crate::equation_of_state::ModifiedKolafa), or
    /// [`FluidSolid`](crate::equation_of_state::FluidSolid) where that freezes.
    Hydrostatics(HydrostaticProfile),
    /// A simulation, to be run.
    MonteCarlo(MonteCarloPlan),
}

impl Model {
    /// Number densities in bins one diameter high ([`densities`](super::densities)): at once for a formula, after the run for a plan.
    ///
    /// # Errors
    /// As [`MonteCarloPlan::densities`]; none for a formula.
    pub fn densities<F: Field, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
        seed: u64,
    ) -> Result<Vec<f64>, Error> {
        match self {
            Self::IdealGas(column) => {
                Ok(total_variation::densities(scene.slab(), |height| column.column_below(height)))
            }
            Self::Hydrostatics(profile) => {
                Ok(total_variation::densities(scene.slab(), |height| profile.column_below(height)))
            }
            Self::MonteCarlo(plan) => plan.densities(scene, seed),
        }
    }
}

impl fmt::Display for Model {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IdealGas(_) => formatter.write_str("ideal gas"),
            Self::Hydrostatics(_) => formatter.write_str("hydrostatic theory between walls"),
            Self::MonteCarlo(plan) => write!(formatter, "Monte Carlo of {plan}"),
        }
    }
}

/// A model with what is expected of it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Assessment {
    /// The model.
    pub model: Model,
    /// Total variation distance that is expected; of a plan, root mean square over seeds.
    pub expected_error: f64,
    /// CPU seconds that are expected, on one core of a machine of the 2020s: good to a factor of two or three.
    pub expected_seconds: f64,
    /// Whether the error stays below the tolerance, with an allowance for what the estimate does not know.
    pub is_adequate: bool,
    /// What the error consists of.
    pub reasons: Vec<Reason>,
}

/// The answer of [`Scene::model_for`]: the cheapest adequate model, and why not a cheaper one.
///
/// `Display` gives it in words.
#[derive(Debug, Clone)]
pub struct ModelChoice {
    tolerance: f64,
    candidates: Vec<Assessment>,
    chosen: usize,
}

impl ModelChoice {
    /// Part of the tolerance that a finite base may take; in quadrature it leaves nearly all to noise.
    const BASE_SHARE: f64 = 0.2;
    /// Smallest side of the base of a plan.
    const SMALLEST_SIDE: f64 = 5.0;
    /// Fewest spheres of a plan.
    const FEWEST_PARTICLES: f64 = 40.0;
    /// Fewest sweeps of a plan, and of one whose column freezes.
    const FEWEST_SWEEPS: [f64; 2] = [64.0, 1e5];
    /// More sweeps than this are only written down.
    const MOST_SWEEPS: f64 = 1e12;

    pub(super) fn new<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        tolerance: f64,
    ) -> Result<Self, Error> {
        let tolerance = Error::require_positive("tolerance", tolerance)?;
        let outlook = Outlook::new(scene)?;
        let frozen = outlook.freezing.is_some();
        let adequate = |error: f64| !frozen && error * Outlook::allowance() <= tolerance;
        let [base, lid] = outlook.layers();
        let freezing = outlook.freezing.map(|exit| Reason::Freezing {
            lowest_height: exit.lowest_height,
            highest_height: exit.highest_height,
            packing_fraction: exit.packing_fraction,
        });
        let ideal = Assessment {
            model: Model::IdealGas(outlook.ideal.clone()),
            expected_error: outlook.ideal_error(),
            expected_seconds: outlook.ideal_cost(),
            is_adequate: adequate(outlook.ideal_error()),
            reasons: vec![Reason::ExcludedVolume { fraction: outlook.excluded_volume }],
        };
        let layers = |wall, packing_fraction, fraction| Reason::Layers { wall, packing_fraction, fraction };
        let mut reasons = vec![layers(Wall::Base, outlook.walls[0], base)];
        if lid > 0.01 * base {
            reasons.push(layers(Wall::Lid, outlook.walls[1], lid));
        }
        reasons.push(Reason::Bulk {
            logarithmic_gradient: outlook.steepest.0,
            height: outlook.steepest.1,
            fraction: outlook.bulk(),
        });
        reasons.extend(freezing);
        let theory = Assessment {
            model: Model::Hydrostatics(outlook.theory.clone()),
            expected_error: outlook.theory_error(),
            expected_seconds: outlook.theory_cost(),
            is_adequate: adequate(outlook.theory_error()),
            reasons,
        };
        let mut plan = best_plan(scene, &outlook, tolerance)?;
        plan.is_adequate &= !frozen;
        plan.reasons.extend(freezing);
        let candidates = vec![ideal, theory, plan];
        // Where nothing is known to be adequate, the one that leaves out least.
        let chosen =
            candidates.iter().position(|candidate| candidate.is_adequate).unwrap_or(candidates.len() - 1);
        Ok(Self { tolerance, candidates, chosen })
    }

    /// The cheapest adequate model, or the best there is.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.best().model
    }

    /// The same with what is expected of it.
    #[must_use]
    pub fn best(&self) -> &Assessment {
        &self.candidates[self.chosen]
    }

    /// All models that were considered, from cheap to dear.
    #[must_use]
    pub fn candidates(&self) -> &[Assessment] {
        &self.candidates
    }

    /// The tolerance that was asked for.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Whether the model is expected to keep the tolerance. It is not where the column freezes.
    #[must_use]
    pub fn is_adequate(&self) -> bool {
        self.best().is_adequate
    }
}

/// The cheaper of the two families, each over the smallest base that will do.
fn best_plan<F: Field, T: TemperatureProfile>(
    scene: &Scene<F, T>,
    outlook: &Outlook,
    tolerance: f64,
) -> Result<Assessment, Error> {
    let base_target = ModelChoice::BASE_SHARE * tolerance;
    let smallest_area = ModelChoice::SMALLEST_SIDE * ModelChoice::SMALLEST_SIDE;
    // A crystal does not fit into a small box: where it freezes, the box of the scene is as good as any.
    let least =
        if outlook.freezing.is_some() { scene.particles() as f64 } else { ModelChoice::FEWEST_PARTICLES };
    let particles =
        outlook.particles_for(base_target).max(outlook.column_density * smallest_area).max(least).ceil();
    let volume = particles / outlook.column_density * scene.slab().height();
    if volume > Slab::MAXIMUM_VOLUME {
        return Err(Error::SlabTooLarge { volume, limit: Slab::MAXIMUM_VOLUME });
    }
    // At most the volume times close packing.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let particles = particles as usize;
    let base = outlook.finite_base(particles);
    let noise_target = (tolerance * tolerance - base * base).sqrt();
    let fewest = ModelChoice::FEWEST_SWEEPS[usize::from(outlook.freezing.is_some())];
    let mut best: Option<Assessment> = None;
    for family in MoveFamily::ALL {
        let sweeps = outlook
            .sweeps_for(particles, family, noise_target / Outlook::plan_allowance(family))
            .clamp(fewest, ModelChoice::MOST_SWEEPS)
            .ceil();
        let noise = outlook.noise(particles, family, sweeps);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let plan = MonteCarloPlan::new(scene, particles, family, sweeps as u64)?;
        let expected_error = noise.hypot(base);
        let assessment = Assessment {
            model: Model::MonteCarlo(plan),
            expected_error,
            expected_seconds: outlook.plan_cost(particles, family, sweeps),
            is_adequate: expected_error <= tolerance,
            reasons: vec![
                Reason::Noise { fraction: noise },
                Reason::FiniteBase { particles, fraction: base },
            ],
        };
        if best.as_ref().is_none_or(|best| assessment.expected_seconds < best.expected_seconds) {
            best = Some(assessment);
        }
    }
    // There are two families.
    best.ok_or(Error::InvalidParameter {
        name: "tolerance",
        value: tolerance,
        requirement: "no plan was found",
    })
}

impl fmt::Display for ModelChoice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let best = self.best();
        let verdict =
            if best.is_adequate { "take" } else { "nothing is known to be adequate; the best guess:" };
        writeln!(
            formatter,
            "to place all but {} of the spheres, {verdict} {}",
            Percent(self.tolerance),
            best.model
        )?;
        for candidate in &self.candidates {
            let name = match candidate.model {
                Model::IdealGas(_) => "ideal gas",
                Model::Hydrostatics(_) => "hydrostatic theory",
                Model::MonteCarlo(_) => "Monte Carlo",
            };
            let word = if candidate.is_adequate { "enough" } else { "not enough" };
            writeln!(
                formatter,
                "  {name}: {} expected, {word}, some {} CPU s",
                Percent(candidate.expected_error),
                Seconds(candidate.expected_seconds)
            )?;
            for reason in &candidate.reasons {
                writeln!(formatter, "    {reason}")?;
            }
        }
        Ok(())
    }
}

/// Seconds with one figure.
struct Seconds(f64);

impl fmt::Display for Seconds {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 < 0.01 || self.0 >= 1e4 {
            write!(formatter, "{:.0e}", self.0)
        } else {
            write!(formatter, "{:.2}", self.0)
        }
    }
}
