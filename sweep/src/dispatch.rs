//! Distribution of tasks to ranks, on rank 0.

use std::collections::VecDeque;
use std::fmt;

/// State of a task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum State {
    /// It has not been started.
    Waiting,
    /// A rank works on it.
    Running {
        /// Number of the rank.
        rank: usize,
    },
    /// It is complete.
    Finished,
    /// It was stopped; the same command continues it.
    Stopped,
    /// It failed, with this error.
    Failed(String),
    /// The rank that ran it does not answer.
    Lost {
        /// Which.
        rank: usize,
    },
}

impl fmt::Display for State {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting => formatter.write_str("not started"),
            Self::Running { rank } => write!(formatter, "running on rank {rank}"),
            Self::Finished => formatter.write_str("finished"),
            Self::Stopped => formatter.write_str("stopped"),
            Self::Failed(why) => write!(formatter, "failed: {why}"),
            Self::Lost { rank } => write!(formatter, "lost with rank {rank}"),
        }
    }
}

/// Distributes tasks to free ranks and keeps their states.
#[derive(Debug, Clone)]
pub struct Dispatch {
    states: Vec<State>,
    queue: VecDeque<usize>,
}

impl Dispatch {
    /// Makes a dispatch of `tasks` tasks, of which those in `queue` are run in this order.
    #[must_use]
    pub fn new(tasks: usize, queue: impl IntoIterator<Item = usize>) -> Self {
        Self { states: vec![State::Waiting; tasks], queue: queue.into_iter().collect() }
    }

    /// The next task for a free rank.
    pub fn next(&mut self, rank: usize) -> Option<usize> {
        let task = self.queue.pop_front()?;
        self.states[task] = State::Running { rank };
        Some(task)
    }

    /// Records the final state of a task.
    pub fn ended(&mut self, task: usize, state: State) {
        if let Some(of_task) = self.states.get_mut(task) {
            *of_task = state;
        }
    }

    /// Marks the tasks of a rank that does not answer as lost, and returns them. They are not given
    /// to another rank, because this rank may still run them.
    pub fn lost(&mut self, rank: usize) -> Vec<usize> {
        let running = State::Running { rank };
        let tasks: Vec<usize> = (0..self.states.len()).filter(|&task| self.states[task] == running).collect();
        for &task in &tasks {
            self.states[task] = State::Lost { rank };
        }
        tasks
    }

    /// Stops the distribution of tasks.
    pub fn stop(&mut self) {
        self.queue.clear();
    }

    /// Whether no task is waiting or running.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.queue.is_empty() && !self.states.iter().any(|state| matches!(state, State::Running { .. }))
    }

    /// State of every task.
    #[must_use]
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// Number of tasks in a state.
    #[must_use]
    pub fn count(&self, is: impl Fn(&State) -> bool) -> usize {
        self.states.iter().filter(|state| is(state)).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_are_handed_out_once_and_in_order_and_accounted_for() {
        let mut dispatch = Dispatch::new(5, [3, 0, 4]);
        assert_eq!([dispatch.next(1), dispatch.next(2)], [Some(3), Some(0)]);
        dispatch.ended(3, State::Finished);
        assert_eq!([dispatch.next(1), dispatch.next(1)], [Some(4), None]);
        assert!(!dispatch.is_over());
        dispatch.ended(0, State::Failed("no room".into()));
        assert_eq!(dispatch.lost(1), [4]);
        assert!(dispatch.is_over());
        let states = dispatch.states().iter().map(State::to_string).collect::<Vec<_>>();
        assert_eq!(states, ["failed: no room", "not started", "not started", "finished", "lost with rank 1"]);
        // One that answers late is believed.
        dispatch.ended(4, State::Finished);
        assert_eq!(dispatch.count(|state| *state == State::Finished), 2);
    }

    #[test]
    fn once_stopped_nothing_is_handed_out_and_what_runs_is_waited_for() {
        let mut dispatch = Dispatch::new(2, [0, 1]);
        dispatch.next(0);
        dispatch.stop();
        assert_eq!(dispatch.next(1), None);
        assert!(!dispatch.is_over());
        dispatch.ended(0, State::Stopped);
        assert!(dispatch.is_over());
    }
}
