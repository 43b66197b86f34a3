//! Progress with the remaining time: a bar on a terminal, plain lines otherwise.

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Progress of a known amount of work, shared by all threads.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    total: u64,
    done: AtomicU64,
    /// Units done by an earlier process.
    before: AtomicU64,
    started: Instant,
    /// Next tenth to be printed where there is no terminal.
    next_tenth: Option<Mutex<u64>>,
}

impl Progress {
    /// Progress towards `total` units of work.
    pub fn new(total: u64, what: &'static str) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let target = if terminal { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(total), target).with_message(what);
        if let Ok(style) =
            ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} %  {elapsed}, {eta} left")
        {
            bar.set_style(style);
        }
        Self {
            bar,
            total,
            done: AtomicU64::new(0),
            before: AtomicU64::new(0),
            started: Instant::now(),
            next_tenth: (!terminal).then(|| Mutex::new(1)),
        }
    }

    /// Progress without output.
    pub fn hidden() -> Self {
        Self {
            bar: ProgressBar::hidden(),
            total: 0,
            done: AtomicU64::new(0),
            before: AtomicU64::new(0),
            started: Instant::now(),
            next_tenth: None,
        }
    }

    /// Reports that an earlier process has done `units`.
    pub fn resume(&self, units: u64) {
        self.before.fetch_add(units, Ordering::Relaxed);
        self.done.fetch_add(units, Ordering::Relaxed);
        self.bar.inc(units);
        self.bar.reset_eta();
    }

    /// Reports that `units` more are done.
    pub fn advance(&self, units: u64) {
        self.bar.inc(units);
        let done = self.done.fetch_add(units, Ordering::Relaxed) + units;
        let Some(next) = &self.next_tenth else { return };
        let Ok(mut next) = next.lock() else { return };
        let tenth = done * 10 / self.total.max(1);
        if tenth >= *next && tenth <= 10 {
            *next = tenth + 1;
            let elapsed = self.started.elapsed();
            let now = done.saturating_sub(self.before.load(Ordering::Relaxed));
            let left = elapsed.mul_f64(self.total.saturating_sub(done) as f64 / now.max(1) as f64);
            eprintln!("{:>4} %  {:.0} s, about {:.0} s left", tenth * 10, seconds(elapsed), seconds(left));
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

fn seconds(duration: Duration) -> f64 {
    duration.as_secs_f64()
}

/// A duration in words, such as "3 hours".
pub fn in_words(duration: Duration) -> String {
    HumanDuration(duration).to_string()
}
