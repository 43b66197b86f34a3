//! Progress of a parameter sweep: one line on a terminal, occasional lines otherwise.

use std::io::{IsTerminal as _, Write as _, stderr};
use std::time::{Duration, Instant};

/// Progress of a known amount of work.
#[derive(Debug)]
pub(crate) struct Progress {
    total: u64,
    tasks: usize,
    started: Instant,
    shown: Option<Instant>,
    on_terminal: bool,
}

impl Progress {
    /// Progress towards `total` work in `tasks` tasks.
    pub(crate) fn new(total: u64, tasks: usize) -> Self {
        Self { total, tasks, started: Instant::now(), shown: None, on_terminal: stderr().is_terminal() }
    }

    /// Prints the work done, the part of earlier processes, and the numbers of finished and running
    /// tasks.
    pub(crate) fn show(&mut self, [done, before]: [u64; 2], finished: usize, running: usize) {
        let elapsed = self.started.elapsed();
        // With increasing pauses: about a hundred lines in a day.
        let pause =
            if self.on_terminal { Duration::ZERO } else { (elapsed / 20).max(Duration::from_secs(10)) };
        if self.shown.unwrap_or(self.started).elapsed() < pause {
            return;
        }
        self.shown = Some(Instant::now());
        let share = done as f64 / self.total.max(1) as f64;
        let left = self.total.saturating_sub(done) as f64 / done.saturating_sub(before).max(1) as f64;
        let left =
            if done > before { in_words(elapsed.as_secs_f64() * left) } else { "an unknown time".into() };
        let line = format!(
            "{:>4.0} %  {finished} of {} runs finished, {running} running; {} elapsed, about {left} left",
            100.0 * share,
            self.tasks,
            in_words(elapsed.as_secs_f64()),
        );
        // Errors are ignored: a run continues when its terminal is closed.
        if self.on_terminal {
            write!(stderr(), "\r\x1b[K{line}").ok();
        } else {
            writeln!(stderr(), "{line}").ok();
        }
    }

    /// Prints a permanent line.
    pub(crate) fn say(&self, line: &str) {
        let clear = if self.on_terminal { "\r\x1b[K" } else { "" };
        writeln!(stderr(), "{clear}{line}").ok();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.on_terminal {
            write!(stderr(), "\r\x1b[K").ok();
        }
    }
}

fn in_words(seconds: f64) -> String {
    match seconds {
        0.0..180.0 => format!("{seconds:.0} s"),
        180.0..7200.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}
