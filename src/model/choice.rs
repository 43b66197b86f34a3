//! The candidates for one scene, and the one that is enough.

use super::accuracy::{Accuracy, Percent, densities};
use super::corrected_layers::CorrectedLayers;
use super::outlook::Outlook;
use super::plan::{MonteCarloPlan, MoveFamily};
use crate::hydrostatics::DomainExit;
use crate::{Error, Field, HydrostaticProfile, Scene, Slab, TemperatureProfile};
use std::fmt;

/// A model of the profile of a scene, in order of cost.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Model {
    /// Points: [`IdealGas`](crate::equation_of_state::IdealGas), with centers half a diameter off
    /// the walls.
    IdealGas(HydrostaticProfile),
    /// Hydrostatic balance between walls: the fluid of
    /// [`ModifiedKolafa`](crate::equation_of_state::ModifiedKolafa), or
    /// [`FluidSolid`](crate::equation_of_state::FluidSolid) where that freezes.
    Hydrostatics(HydrostaticProfile),
    /// The White Bear II functional, which has the layers, on the bulk of
    /// [`Hydrostatics`](Self::Hydrostatics).
    DensityFunctional(CorrectedLayers),
    /// A simulation, to be run.
    MonteCarlo(MonteCarloPlan),
}

impl Model {
    /// Number densities in bins one diameter high ([`densities`]): at once for a formula, after the
    /// run for a plan.
    ///
    /// # Errors
    /// As [`MonteCarloPlan::densities`]; none for a formula.
    pub fn densities<F: Field, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
        seed: u64,
    ) -> Result<Vec<f64>, Error> {
        match self {
            Self::IdealGas(profile) | Self::Hydrostatics(profile) => Ok(densities(scene, profile)),
            Self::DensityFunctional(layers) => Ok(layers.densities(scene)),
            Self::MonteCarlo(plan) => plan.densities(scene, seed),
        }
    }
}

impl fmt::Display for Model {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IdealGas(_) => formatter.write_str("ideal gas"),
            Self::Hydrostatics(_) => formatter.write_str("hydrostatic theory between walls"),
            Self::DensityFunctional(_) => formatter.write_str("density functional White Bear II"),
            Self::MonteCarlo(plan) => write!(formatter, "Monte Carlo of {plan}"),
        }
    }
}

/// What makes the error of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cause {
    /// Points take up no room.
    ExcludedVolume,
    /// A local theory has no layers at a wall, and those of a functional are not quite right.
    Layers,
    /// The layers at a wall hold too many spheres or too few, so that the column above them is too
    /// low or too high.
    Adsorption,
    /// Equation of state, and density taken to be locally uniform.
    LocalTheory,
    /// A finite number of configurations, from a start that was not yet the steady state.
    Noise,
    /// A base with few spheres.
    FiniteBase,
}

impl fmt::Display for Cause {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::ExcludedVolume => "excluded volume",
            Self::Layers => "layers at the walls",
            Self::Adsorption => "adsorption at the walls",
            Self::LocalTheory => "equation of state and local density",
            Self::Noise => "counting noise",
            Self::FiniteBase => "finite base",
        })
    }
}

/// A model with what is expected of it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Assessment {
    /// The model.
    pub model: Model,
    /// Error that is expected, of what [`Accuracy`] asks for; of a plan, root mean square over
    /// seeds.
    pub expected_error: f64,
    /// Local trials and events of event chains that are expected; 0 for a formula, which takes
    /// milliseconds, or tenths of a second. A core makes some 5 to 20 million of either per
    /// second: `cargo bench --bench throughput -- packing` says what yours does.
    pub expected_moves: f64,
    /// Whether the error stays below the tolerance, with an allowance for what the estimate does
    /// not know.
    pub is_adequate: bool,
    /// What the error consists of, in quadrature.
    pub causes: Vec<(Cause, f64)>,
}

/// The answer of [`Scene::model_for`]: the cheapest adequate model, and why not a cheaper one.
///
/// `Display` gives it in words.
#[derive(Debug, Clone)]
pub struct ModelChoice {
    accuracy: Accuracy,
    candidates: Vec<Assessment>,
    chosen: usize,
    freezing: Option<DomainExit>,
    open_end: f64,
}

impl ModelChoice {
    /// Part of the tolerance that a finite base may take; in quadrature it leaves nearly all to
    /// noise.
    const BASE_SHARE: f64 = 0.2;
    /// Smallest side of the base of a plan.
    const SMALLEST_SIDE: f64 = 5.0;
    /// Fewest spheres of a plan.
    const FEWEST_PARTICLES: f64 = 40.0;
    /// Fewest sweeps of a plan, and of one whose column freezes.
    const FEWEST_SWEEPS: [f64; 2] = [64.0, 1e5];
    /// More sweeps than this are only written down.
    const MOST_SWEEPS: f64 = 1e12;
    /// Part of the tolerance that the wall at the open end may carry of the pressure.
    const OPEN_END_SHARE: f64 = 0.1;

    pub(super) fn new<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        accuracy: Accuracy,
    ) -> Result<Self, Error> {
        let outlook = Outlook::new(scene, &accuracy)?;
        let tolerance = accuracy.tolerance();
        let knowable = outlook.freezing.is_none() && outlook.open_end <= Self::OPEN_END_SHARE * tolerance;
        let formula = |model, expected_error: f64, allowance: f64, causes| Assessment {
            model,
            expected_error,
            expected_moves: 0.0,
            is_adequate: knowable && expected_error * allowance <= tolerance,
            causes,
        };
        let mut plan = best_plan(scene, &outlook, tolerance)?;
        plan.is_adequate &= knowable;
        // P and Z alone know of the third.
        let causes = |layers, adsorption: f64| {
            let all = [
                (Cause::Layers, layers),
                (Cause::LocalTheory, outlook.bulk),
                (Cause::Adsorption, adsorption),
            ];
            all.into_iter().filter(|(cause, error)| *cause != Cause::Adsorption || *error > 0.0).collect()
        };
        let mut candidates = vec![
            formula(
                Model::IdealGas(outlook.ideal.clone()),
                outlook.ideal_error(),
                outlook.allowance(),
                vec![(Cause::ExcludedVolume, outlook.excluded_volume)],
            ),
            formula(
                Model::Hydrostatics(outlook.theory.clone()),
                outlook.theory_error(),
                outlook.allowance(),
                causes(outlook.layers, outlook.adsorption[0]),
            ),
        ];
        // It takes longer, and is not for every scene: one that freezes, or has jumps.
        if !candidates.iter().any(|candidate| candidate.is_adequate)
            && let Ok(layers) = CorrectedLayers::new(scene, &outlook.theory)
        {
            candidates.push(formula(
                Model::DensityFunctional(layers),
                outlook.functional_error(),
                outlook.functional_allowance(),
                causes(outlook.functional_layers, outlook.adsorption[1]),
            ));
        }
        candidates.push(plan);
        // Where nothing is known to be adequate, the one that leaves out least.
        let chosen =
            candidates.iter().position(|candidate| candidate.is_adequate).unwrap_or(candidates.len() - 1);
        Ok(Self { accuracy, candidates, chosen, freezing: outlook.freezing, open_end: outlook.open_end })
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

    /// All models that were considered, in order of cost.
    #[must_use]
    pub fn candidates(&self) -> &[Assessment] {
        &self.candidates
    }

    /// Whether the model is expected to be as accurate as was asked for. It is not where the column
    /// freezes, nor for P and Z where the wall at the [open end](Scene::open_end) carries part
    /// of the pressure, which then is no weight.
    #[must_use]
    pub fn is_adequate(&self) -> bool {
        self.best().is_adequate
    }

    /// Where the column freezes: no model here is known to be adequate without care.
    #[must_use]
    pub fn freezing(&self) -> Option<DomainExit> {
        self.freezing
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
    // A crystal does not fit into a small box: where it freezes, the box of the scene is as good as
    // any.
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
    let [tuned, chains] = MoveFamily::ALL.map(|family| -> Result<Assessment, Error> {
        let sweeps = outlook
            .sweeps_for(particles, family, noise_target / outlook.plan_allowance(family))
            .clamp(fewest, ModelChoice::MOST_SWEEPS)
            .ceil();
        let noise = outlook.noise(particles, family, sweeps);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let plan = MonteCarloPlan::new(scene, particles, family, sweeps as u64)?;
        let expected_error = noise.hypot(base);
        Ok(Assessment {
            model: Model::MonteCarlo(plan),
            expected_error,
            expected_moves: outlook.moves(particles, family, sweeps),
            is_adequate: expected_error <= tolerance,
            causes: vec![(Cause::Noise, noise), (Cause::FiniteBase, base)],
        })
    });
    let (tuned, chains) = (tuned?, chains?);
    Ok(if tuned.expected_moves <= chains.expected_moves { tuned } else { chains })
}

impl fmt::Display for ModelChoice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let best = self.best();
        let verdict =
            if best.is_adequate { "take" } else { "nothing is known to be adequate; the best guess:" };
        writeln!(formatter, "for {}, {verdict} {}", self.accuracy, best.model)?;
        if let Some(DomainExit { lowest_height, highest_height, packing_fraction, .. }) = self.freezing {
            writeln!(
                formatter,
                "  the column freezes between x = {lowest_height:.1} and {highest_height:.1} (packing fraction up to \
                 {packing_fraction:.3}): a crystal needs a wide base whose widths suit it, and starts on both sides"
            )?;
        }
        if self.open_end > Self::OPEN_END_SHARE * self.accuracy.tolerance() {
            writeln!(
                formatter,
                "  the wall at the open end carries {} of the pressure, which is no weight",
                Percent(self.open_end)
            )?;
        }
        for candidate in &self.candidates {
            let name = match candidate.model {
                Model::IdealGas(_) => "ideal gas",
                Model::Hydrostatics(_) => "hydrostatic theory",
                Model::DensityFunctional(_) => "density functional",
                Model::MonteCarlo(_) => "Monte Carlo",
            };
            let word = if candidate.is_adequate { "enough" } else { "not enough" };
            write!(formatter, "  {name}: {} expected, {word}", Percent(candidate.expected_error))?;
            for (index, (cause, error)) in candidate.causes.iter().enumerate() {
                write!(formatter, "{} {cause} {}", if index == 0 { ";" } else { "," }, Percent(*error))?;
            }
            if candidate.expected_moves > 0.0 {
                write!(formatter, "; some {:.0e} moves", candidate.expected_moves)?;
            }
            writeln!(formatter)?;
        }
        Ok(())
    }
}
