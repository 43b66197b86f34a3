//! The candidates for one scene, and the cheapest adequate one.

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
    /// [`IdealGas`](crate::equation_of_state::IdealGas): points, whose centers stay half a diameter
    /// from the walls.
    IdealGas(HydrostaticProfile),
    /// Hydrostatic balance between walls:
    /// [`ModifiedKolafa`](crate::equation_of_state::ModifiedKolafa), or
    /// [`FluidSolid`](crate::equation_of_state::FluidSolid) where this fluid freezes.
    Hydrostatics(HydrostaticProfile),
    /// The White Bear II functional, which describes the layers at walls, with the bulk of
    /// [`Hydrostatics`](Self::Hydrostatics).
    DensityFunctional(CorrectedLayers),
    /// A simulation that is still to be run.
    MonteCarlo(MonteCarloPlan),
}

impl Model {
    /// Number densities in bins one diameter high ([`densities`]). A plan is run for this.
    ///
    /// # Errors
    /// As [`MonteCarloPlan::densities`]; none for the other models.
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

/// A cause of the error of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cause {
    /// The ideal gas neglects the volume of the spheres.
    ExcludedVolume,
    /// A local theory has no layers at a wall, and the layers of a functional are not exact.
    Layers,
    /// The layers at a wall hold too many spheres or too few, so that the column above them is too
    /// low or too high.
    Adsorption,
    /// Errors of the equation of state, and of the assumption that the density is locally uniform.
    LocalTheory,
    /// A finite number of configurations, and the relaxation of the start.
    Noise,
    /// A narrow base with few spheres.
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

/// A model with its expected error and cost.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Assessment {
    /// The model.
    pub model: Model,
    /// Expected error as defined by [`Accuracy`]; for a plan, the root mean square over seeds.
    pub expected_error: f64,
    /// Expected number of local trials and chain events; 0 for theories, which take milliseconds or
    /// tenths of a second. A core makes about 5 to 20 million per second; `cargo bench --bench
    /// throughput -- packing` measures yours.
    pub expected_moves: f64,
    /// Whether the error stays below the tolerance, with an allowance for errors of the estimate.
    pub is_adequate: bool,
    /// The contributions to the error, which add in quadrature.
    pub causes: Vec<(Cause, f64)>,
}

/// The answer of [`Scene::model_for`]: the cheapest adequate model, and the errors of the cheaper
/// ones. `Display` prints it as a report.
///
///
/// ```
/// use gradient_mc::model::Accuracy;
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(30.0, 20.0, 20.0)?, 400, UniformField::default(), Isothermal::new(2.0)?)?;
/// let choice = scene.model_for(Accuracy::density(0.05)?)?;
/// assert!(choice.is_adequate() && choice.best().expected_error < 0.05);
/// for candidate in choice.candidates() {
///     println!("{}: {:.4}", candidate.model, candidate.expected_error);
/// }
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ModelChoice {
    accuracy: Accuracy,
    candidates: Vec<Assessment>,
    chosen: usize,
    freezing: Option<DomainExit>,
    open_end: f64,
}

impl ModelChoice {
    /// Share of the tolerance for the finite base. In quadrature it leaves nearly all to noise.
    const BASE_SHARE: f64 = 0.2;
    /// Smallest side of the base of a plan.
    const SMALLEST_SIDE: f64 = 5.0;
    /// Fewest spheres of a plan.
    const FEWEST_PARTICLES: f64 = 40.0;
    /// Fewest sweeps of a plan, and of one whose column freezes.
    const FEWEST_SWEEPS: [f64; 2] = [64.0, 1e5];
    /// Largest number of sweeps of a plan.
    const MOST_SWEEPS: f64 = 1e12;
    /// Largest share of the pressure on the wall at the open end, over the tolerance.
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
        // The third applies to P and Z only.
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
        // The functional takes longer, and fails for scenes that freeze or have jumps.
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
        // Without an adequate model, the simulation.
        let chosen =
            candidates.iter().position(|candidate| candidate.is_adequate).unwrap_or(candidates.len() - 1);
        Ok(Self { accuracy, candidates, chosen, freezing: outlook.freezing, open_end: outlook.open_end })
    }

    /// The cheapest adequate model, or else the simulation.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.best().model
    }

    /// The chosen model with its expected error and cost.
    #[must_use]
    pub fn best(&self) -> &Assessment {
        &self.candidates[self.chosen]
    }

    /// All models that were considered, in order of cost.
    #[must_use]
    pub fn candidates(&self) -> &[Assessment] {
        &self.candidates
    }

    /// Whether the model is expected to reach the accuracy. It is `false` if the column freezes,
    /// and for P and Z if the wall at the [open end](Scene::open_end) carries part of the pressure,
    /// which then is not the weight alone.
    #[must_use]
    pub fn is_adequate(&self) -> bool {
        self.best().is_adequate
    }

    /// The part of the column that freezes, if any. No model is then known to be adequate.
    #[must_use]
    pub fn freezing(&self) -> Option<DomainExit> {
        self.freezing
    }
}

/// The cheaper plan of the two families, over the smallest base that is wide enough.
fn best_plan<F: Field, T: TemperatureProfile>(
    scene: &Scene<F, T>,
    outlook: &Outlook,
    tolerance: f64,
) -> Result<Assessment, Error> {
    let base_target = ModelChoice::BASE_SHARE * tolerance;
    let smallest_area = ModelChoice::SMALLEST_SIDE * ModelChoice::SMALLEST_SIDE;
    // A crystal does not fit into every small box, so a column that freezes keeps the number of
    // spheres of the scene.
    let least =
        if outlook.freezing.is_some() { scene.particles() as f64 } else { ModelChoice::FEWEST_PARTICLES };
    let particles =
        outlook.particles_for(base_target).max(outlook.column_density * smallest_area).max(least).ceil();
    let volume = particles / outlook.column_density * scene.slab().height();
    if volume > Slab::MAXIMUM_VOLUME {
        return Err(Error::SlabTooLarge { volume, limit: Slab::MAXIMUM_VOLUME });
    }
    // Limited by the volume.
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
            if best.is_adequate { "take" } else { "no model is known to be adequate; the best guess is" };
        writeln!(formatter, "for {}, {verdict} {}", self.accuracy, best.model)?;
        if let Some(DomainExit { lowest_height, highest_height, packing_fraction, .. }) = self.freezing {
            writeln!(
                formatter,
                "  the column freezes between x = {lowest_height:.1} and {highest_height:.1} (packing fraction up to \
                 {packing_fraction:.3}): a crystal needs a wide, commensurate base and runs from two opposite starts"
            )?;
        }
        if self.open_end > Self::OPEN_END_SHARE * self.accuracy.tolerance() {
            writeln!(
                formatter,
                "  the wall at the open end carries {} of the pressure, so P is not the weight alone",
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
                write!(formatter, "; about {:.0e} moves", candidate.expected_moves)?;
            }
            writeln!(formatter)?;
        }
        Ok(())
    }
}
