//! Maximum displacements that are tuned in equilibration.

use super::LocalMoves;
use super::domains::Domains;
use crate::configuration::{Grid, Layer, NOBODY};
use crate::frame::Phase;
use crate::observer::AcceptedMove;
use crate::random::{Generator, index, unit};

/// Number of short candidates.
const SHORT: usize = 8;
/// Largest number of candidates. A low box has fewer long ones.
const MOST: usize = 16;

/// Trials with one candidate that start in one band.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "checkpoint", derive(serde::Serialize, serde::Deserialize))]
struct Count {
    trials: f64,
    /// Squares of accepted displacements along x.
    far: Sums,
    /// The same squares, each at most [`RENEWED`](Self::RENEWED).
    near: Sums,
}

/// Sums of values and of their squares.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "checkpoint", derive(serde::Serialize, serde::Deserialize))]
struct Sums {
    values: f64,
    squares: f64,
}

impl Sums {
    fn add(&mut self, value: f64) {
        self.values += value;
        self.squares += value * value;
    }

    /// Mean over `trials` minus its standard error, so that a single long jump does not count.
    fn cautious_mean(&self, trials: f64) -> f64 {
        if trials > 0.0 { (self.values - self.squares.sqrt()).max(0.0) / trials } else { 0.0 }
    }

    fn fade(&mut self) {
        self.values *= TunedDisplacements::MEMORY;
        self.squares *= TunedDisplacements::MEMORY;
    }
}

impl Count {
    /// The square of half a diameter. A longer displacement does not renew the local structure
    /// more.
    const RENEWED: f64 = 0.25;

    fn add(&mut self, displacement: f64) {
        let square = displacement * displacement;
        self.far.add(square);
        self.near.add(square.min(Self::RENEWED));
    }

    fn fade(&mut self) {
        self.trials *= TunedDisplacements::MEMORY;
        self.far.fade();
        self.near.fade();
    }
}

/// The best candidates so far.
#[derive(Debug, Clone, Default)]
struct Plan {
    /// By band, the short candidate for slabs whose middle is in it.
    short: Vec<Option<usize>>,
    long: Option<usize>,
    share_of_long: f64,
}

/// The maximum displacements of [`LocalMoves::tuned`], as tuned so far.
///
/// ```
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, moves::LocalMoves};
/// use gradient_mc::temperature::Isothermal;
/// let slab = Slab::new(80.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 500, UniformField::default(), Isothermal::new(2.0)?)?;
/// let mut simulation = Simulation::builder(scene).moves(LocalMoves::tuned()).seed(1).build()?;
/// simulation.equilibrate(2000, &mut ())?;
/// let tuned = simulation.tuned_displacements().ok_or("not tuned")?;
/// for height in [2.0, 20.0, 40.0] {
///     println!("S = {:?} at {height}", tuned.short(height));
/// }
/// println!("S = {:?} in {} of the sweeps", tuned.long(), tuned.share_of_long());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct TunedDisplacements {
    /// The candidates, one S each in ascending order, the short ones first.
    ladder: Vec<LocalMoves>,
    /// Layers in each of the bands that divide the box.
    layers_per_band: usize,
    layer_side: f64,
    /// By band and candidate.
    counts: Vec<[Count; MOST]>,
    plan: Plan,
    /// Bands that a slab covers below the band of its middle, and above it.
    reach: usize,
    /// Band, candidate and number of trials in the current sweep.
    trials: Vec<(usize, usize, f64)>,
    /// Candidates of the slabs in the current sweep.
    candidates: Vec<usize>,
    adapting: bool,
    sweeps: u64,
    next_update: u64,
}

impl TunedDisplacements {
    /// Smallest S.
    const SMALLEST: f64 = 0.05;
    /// Largest short S, and largest S along y and z, if the slab is wide enough.
    pub(super) const LARGEST_SHORT: f64 = 3.0;
    /// Layers of a band, unless this gives more than [`MOST_BANDS`](Self::MOST_BANDS).
    const LAYERS: usize = 3;
    const MOST_BANDS: usize = 512;
    /// In equilibration one choice in this number is random.
    const EXPLORE: usize = 4;
    /// Factor on all counts at an update, so that the relaxation of the start is forgotten.
    const MEMORY: f64 = 0.75;
    const FIRST_UPDATE: u64 = 16;
    /// Trials of each short candidate that a choice needs.
    const ENOUGH: f64 = 50.0;

    /// S in diameters of slabs whose middle is near `height`, in sweeps that are not
    /// [long](Self::long). `None` where there were too few trials to choose.
    #[must_use]
    pub fn short(&self, height: f64) -> Option<f64> {
        if self.plan.short.is_empty() || height.is_nan() {
            return None;
        }
        self.plan.short[self.band(height)].map(|candidate| self.size(candidate))
    }

    /// S along x, in diameters, of the sweeps with long displacements, the same at every height.
    /// `None` if the slab is too low for such sweeps, and before the first choice.
    #[must_use]
    pub fn long(&self) -> Option<f64> {
        self.plan.long.map(|candidate| self.size(candidate))
    }

    /// Share of the sweeps that are long.
    #[must_use]
    pub fn share_of_long(&self) -> f64 {
        self.plan.share_of_long
    }

    fn size(&self, candidate: usize) -> f64 {
        self.ladder[candidate].maximum_displacement()
    }

    fn prepare(&mut self, grid: &Grid, domains: &Domains) {
        let height = grid.sides[0] * grid.cells[0] as f64;
        let largest = (0.5 * height.min(grid.widths[0]).min(grid.widths[1])).min(Self::LARGEST_SHORT);
        let ratio = libm::pow(largest / Self::SMALLEST, 1.0 / (SHORT - 1) as f64);
        let mut size = largest;
        self.ladder = vec![LocalMoves::capped(largest, largest); SHORT];
        for candidate in self.ladder.iter_mut().rev().skip(1) {
            size /= ratio;
            *candidate = LocalMoves::capped(size, largest);
        }
        size = 2.0 * largest;
        while size <= 0.5 * height && self.ladder.len() < MOST {
            self.ladder.push(LocalMoves::capped(size, largest));
            size *= 2.0;
        }
        let layers = grid.cells[0];
        self.layers_per_band = layers.div_ceil(Self::MOST_BANDS).max(Self::LAYERS);
        self.layer_side = grid.sides[0];
        let bands = layers.div_ceil(self.layers_per_band);
        self.counts = vec![[Count::default(); MOST]; bands];
        let share_of_long = if self.ladder.len() > SHORT { 0.5 } else { 0.0 };
        self.plan = Plan { short: vec![None; bands], long: None, share_of_long };
        let thickness = domains.thinnest(grid, largest) / self.layers_per_band as f64;
        // A dozen diameters at most.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let reach = (0.5 * thickness).round() as usize;
        self.reach = reach;
        self.next_update = Self::FIRST_UPDATE;
    }

    /// Cuts the box for a sweep, and chooses the candidates of its slabs. In production neither
    /// depends on the configuration.
    pub(super) fn cut(
        &mut self,
        domains: &mut Domains,
        grid: &Grid,
        layers: &[Layer],
        particles: usize,
        phase: Phase,
        generator: &mut Generator,
    ) {
        if self.ladder.is_empty() {
            self.prepare(grid, domains);
        }
        let adapts = phase == Phase::Equilibration;
        if self.adapting && !adapts {
            self.update();
        }
        self.adapting = adapts;
        let long = self.long_candidate(generator);
        let moves = &self.ladder[long.unwrap_or(SHORT - 1)];
        domains.cut(grid, particles, [moves.maximum_displacement(), moves.largest_across()], generator);
        self.candidates.clear();
        self.trials.clear();
        // Room for one more, since their number varies.
        self.candidates.reserve(domains.slabs() + 1);
        for slab in 0..domains.slabs() {
            let [first, end] = domains.slab(slab);
            let candidate = long.unwrap_or_else(|| {
                let best = self.plan.short[usize::midpoint(first, end) / self.layers_per_band];
                best.filter(|_| !self.explores(generator)).unwrap_or_else(|| index(generator, SHORT))
            });
            self.candidates.push(candidate);
            if adapts {
                for layer in first..end {
                    let spheres = &layers[layer + 1].spheres;
                    let count = spheres.iter().filter(|sphere| sphere.number != NOBODY).count();
                    self.trials.push((layer / self.layers_per_band, candidate, count as f64));
                }
            }
        }
    }

    /// The candidate of all slabs if the sweep, by a random draw, is long.
    fn long_candidate(&self, generator: &mut Generator) -> Option<usize> {
        let candidates = self.ladder.len() - SHORT;
        if candidates == 0 {
            return None;
        }
        let explores = self.explores(generator);
        let share = if explores { 0.5 } else { self.plan.share_of_long };
        (unit(generator) < share).then(|| {
            self.plan.long.filter(|_| !explores).unwrap_or_else(|| SHORT + index(generator, candidates))
        })
    }

    fn explores(&self, generator: &mut Generator) -> bool {
        self.adapting && index(generator, Self::EXPLORE) == 0
    }

    /// Whether accepted moves are to be passed to [`learn`](Self::learn).
    pub(super) fn adapting(&self) -> bool {
        self.adapting
    }

    /// The moves of a slab in this sweep.
    pub(super) fn moves_of(&self, slab: usize) -> &LocalMoves {
        &self.ladder[self.candidates[slab]]
    }

    /// Records the accepted moves of a slab.
    pub(super) fn learn(&mut self, slab: usize, moves: &[AcceptedMove]) {
        let candidate = self.candidates[slab];
        for accepted in moves {
            let band = self.band(accepted.from_height);
            self.counts[band][candidate].add(accepted.displacement.x);
        }
    }

    /// Ends a recorded sweep.
    pub(super) fn finish(&mut self) {
        for &(band, candidate, trials) in &self.trials {
            self.counts[band][candidate].trials += trials;
        }
        self.sweeps += 1;
        if self.sweeps >= self.next_update {
            self.update();
            self.next_update = self.sweeps + (self.sweeps / 8).max(Self::FIRST_UPDATE);
            self.counts.iter_mut().flatten().for_each(Count::fade);
        }
    }

    fn band(&self, height: f64) -> usize {
        // Heights below the base are in the first band, those above the lid in the last.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let layer = (height / self.layer_side) as usize;
        (layer / self.layers_per_band).min(self.counts.len() - 1)
    }

    /// Chooses the best candidates: short ones that renew the structure around spheres the fastest,
    /// and the long one and its share that let the whole column relax the fastest. Both minimize a
    /// resistance: the sum over spheres of 1/transport, which is the friction that each adds. So
    /// the spheres that hardly move count most.
    fn update(&mut self) {
        let kinds: [fn(&Count) -> &Sums; 2] = [|count| &count.near, |count| &count.far];
        let [near, bands] =
            kinds.map(|of| self.counts.iter().map(|counts| Band::new(counts, of)).collect::<Vec<_>>());
        let last = bands.len() - 1;
        for (band, best) in self.plan.short.iter_mut().enumerate() {
            let around = &near[band.saturating_sub(self.reach)..=(band + self.reach).min(last)];
            let tried = |candidate: usize| around.iter().map(|band| band.trials[candidate]).sum::<f64>();
            if (0..SHORT).all(|candidate| tried(candidate) >= Self::ENOUGH) {
                *best = least((0..SHORT).map(|candidate| {
                    (candidate, around.iter().map(|band| band.resistance(band.transports[candidate])).sum())
                }));
            }
        }
        let known = || bands.iter().zip(&self.plan.short).filter_map(|(band, best)| Some((band, (*best)?)));
        if self.ladder.len() > SHORT && known().next().is_some() {
            // Long sweeps have a share between 1/8 and 7/8.
            let mixtures = (SHORT..self.ladder.len())
                .flat_map(|long| (1..8).map(move |eighths| (long, f64::from(eighths) / 8.0)));
            let best = least(mixtures.map(|(long, share)| {
                let mixed = |band: &Band, short: usize| {
                    (1.0 - share) * band.transports[short] + share * band.transports[long]
                };
                ((long, share), known().map(|(band, short)| band.resistance(mixed(band, short))).sum())
            }));
            if let Some((long, share)) = best {
                (self.plan.long, self.plan.share_of_long) = (Some(long), share);
            }
        }
    }
}

#[cfg(feature = "checkpoint")]
impl TunedDisplacements {
    /// See [`Persist`](crate::checkpoint::Persist). What follows from the `grid` is made anew.
    pub(super) fn persist(
        &mut self,
        archive: &mut crate::checkpoint::Archive<'_>,
        grid: &Grid,
        domains: &Domains,
    ) -> Result<(), crate::Error> {
        let mut begun = !self.ladder.is_empty();
        archive.value("begun", &mut begun)?;
        if !begun {
            return Ok(());
        }
        if archive.is_reading() {
            self.prepare(grid, domains);
        }
        archive.slice("counts", self.counts.as_flattened_mut())?;
        archive.slice("short", &mut self.plan.short)?;
        archive.value("long", &mut self.plan.long)?;
        archive.value("share of long", &mut self.plan.share_of_long)?;
        archive.value("adapting", &mut self.adapting)?;
        archive.count("sweeps", &mut self.sweeps)?;
        archive.count("next update", &mut self.next_update)?;
        let candidates = self.ladder.len();
        archive.check(self.plan.short.iter().flatten().all(|&candidate| candidate < SHORT))?;
        archive.check(self.plan.long.is_none_or(|candidate| (SHORT..candidates).contains(&candidate)))
    }
}

/// Trials and transports of a band.
struct Band {
    trials: [f64; MOST],
    /// All trials: proportional to the number of spheres.
    spheres: f64,
    transports: [f64; MOST],
    /// The largest transport.
    most: f64,
}

impl Band {
    fn new(counts: &[Count; MOST], of: impl Fn(&Count) -> &Sums) -> Self {
        let transports = counts.map(|count| of(&count).cautious_mean(count.trials));
        let trials = counts.map(|count| count.trials);
        Self {
            trials,
            spheres: trials.into_iter().sum(),
            transports,
            most: transports.into_iter().fold(0.0, f64::max),
        }
    }

    /// Resistance of its spheres at this transport.
    fn resistance(&self, transport: f64) -> f64 {
        // A candidate without accepted moves gets a small transport.
        if self.most > 0.0 { self.spheres / transport.max(1e-3 * self.most) } else { 0.0 }
    }
}

/// The choice with the smallest value.
fn least<C>(choices: impl Iterator<Item = (C, f64)>) -> Option<C> {
    choices.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(choice, _)| choice)
}

#[cfg(test)]
mod tests;
