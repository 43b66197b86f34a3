//! Engines that take turns, and what comes of it.

use crate::Failure;
use cpu_time::{ProcessTime, ThreadTime};
use std::time::Instant;

/// Trials and acceptances of one turn.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Count {
    pub(crate) trials: u64,
    pub(crate) accepted: u64,
    /// Rejected because they would leave the domain of a sweep, which only one of the engines has.
    pub(crate) left_domain: u64,
}

/// Something that sweeps.
pub(crate) trait Engine {
    fn label(&self) -> String;
    fn run(&mut self, sweeps: u64) -> Result<Count, Failure>;
}

/// What a turn costs.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Clock {
    /// CPU time of this thread: hardly disturbed by others on the machine.
    Cpu,
    /// Time on the wall, the only one that tells what a second thread gains.
    Wall,
}

impl Clock {
    /// Seconds that some work takes, and what it gives.
    fn time<Output>(self, work: impl FnOnce() -> Output) -> (Output, f64) {
        let (cpu, wall) = (ThreadTime::now(), Instant::now());
        let output = work();
        let elapsed = match self {
            Self::Cpu => cpu.elapsed(),
            Self::Wall => wall.elapsed(),
        };
        (output, elapsed.as_secs_f64())
    }
}

/// All turns of one engine.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) label: String,
    /// Million trials per second, one of each turn.
    pub(crate) rates: Vec<f64>,
    pub(crate) count: Count,
    cpu: f64,
    wall: f64,
}

impl Outcome {
    /// Cores that it had on average. Below the number of its threads, others used the machine.
    pub(crate) fn cores(&self) -> f64 {
        self.cpu / self.wall
    }

    pub(crate) fn rate(&self) -> f64 {
        median(self.rates.clone())
    }

    pub(crate) fn acceptance(&self) -> f64 {
        self.count.accepted as f64 / self.count.trials as f64
    }

    /// Acceptance of the trials that stay in the domain of their sweep.
    pub(crate) fn acceptance_inside(&self) -> f64 {
        self.count.accepted as f64 / (self.count.trials - self.count.left_domain) as f64
    }

    /// Median over turns of the ratio of the rates.
    pub(crate) fn over(&self, other: &Self) -> f64 {
        median(self.rates.iter().zip(&other.rates).map(|(mine, theirs)| mine / theirs).collect())
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    if values.len() % 2 == 1 { values[half] } else { 0.5 * (values[half - 1] + values[half]) }
}

/// Lets the engines take turns of about `seconds` each; who begins changes.
pub(crate) fn contest(
    engines: &mut [Box<dyn Engine>],
    clock: Clock,
    turns: usize,
    seconds: f64,
) -> Result<Vec<Outcome>, Failure> {
    let mut sweeps = Vec::new();
    let mut outcomes = Vec::new();
    for engine in engines.iter_mut() {
        // The turn that warms the caches also tells how many sweeps one takes.
        let (mut done, mut spent) = (0_u32, 0.0);
        while spent < 0.2 * seconds {
            let (count, elapsed) = clock.time(|| engine.run(1));
            count?;
            done += 1;
            spent += elapsed;
        }
        let wanted = seconds * f64::from(done) / spent;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        sweeps.push(wanted.ceil() as u64);
        let (label, rates, count) = (engine.label(), Vec::new(), Count::default());
        outcomes.push(Outcome { label, rates, count, cpu: 0.0, wall: 0.0 });
    }
    let contestants = engines.len();
    for turn in 0..turns {
        for place in 0..contestants {
            let index = (place + turn) % contestants;
            let (cpu, wall) = (ProcessTime::now(), Instant::now());
            let (count, elapsed) = clock.time(|| engines[index].run(sweeps[index]));
            let count = count?;
            let outcome = &mut outcomes[index];
            outcome.cpu += cpu.elapsed().as_secs_f64();
            outcome.wall += wall.elapsed().as_secs_f64();
            outcome.rates.push(1e-6 * count.trials as f64 / elapsed);
            outcome.count.trials += count.trials;
            outcome.count.accepted += count.accepted;
            outcome.count.left_domain += count.left_domain;
        }
    }
    Ok(outcomes)
}
