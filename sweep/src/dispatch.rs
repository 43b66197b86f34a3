//! Which task goes where: what rank 0 knows.

use std::collections::VecDeque;
use std::fmt;

/// What became of a task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum State {
    /// Nobody has begun it.
    Waiting,
    /// A rank works on it.
    Running {
        /// Which.
        rank: usize,
    },
    /// It is done.
    Finished,
    /// It goes on when the same command is given again.
    Stopped,
    /// It could not be done.
    Failed(String),
    /// The rank that worked on it does not answer.
    Lost {
        /// Which.
        rank: usize,
    },
}

impl fmt::Display for State {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting => formatter.write_str("not begun"),
            Self::Running { rank } => write!(formatter, "running on rank {rank}"),
            Self::Finished => formatter.write_str("finished"),
            Self::Stopped => formatter.write_str("stopped"),
            Self::Failed(why) => write!(formatter, "failed: {why}"),
            Self::Lost { rank } => write!(formatter, "lost with rank {rank}"),
        }
    }
}

/// Hands out tasks as ranks become free, and keeps account of them.
#[derive(Debug, Clone)]
pub struct Dispatch {
    states: Vec<State>,
    queue: VecDeque<usize>,
}

impl Dispatch {
    /// So many tasks, of which those in `queue` are to be done, in this order.
    #[must_use]
    pub fn new(tasks: usize, queue: impl IntoIterator<Item = usize>) -> Self {
        Self { states: vec![State::Waiting; tasks], queue: queue.into_iter().collect() }
    }

    /// The next task, for a rank that is free.
    pub fn next(&mut self, rank: usize) -> Option<usize> {
        let task = self.queue.pop_front()?;
        self.states[task] = State::Running { rank };
        Some(task)
    }

    /// What became of a task that was handed out.
    pub fn ended(&mut self, task: usize, state: State) {
        if let Some(of_task) = self.states.get_mut(task) {
            *of_task = state;
        }
    }

    /// The tasks of a rank that does not answer: they are given up, since nobody knows whether it
    /// still works on them.
    pub fn lost(&mut self, rank: usize) -> Vec<usize> {
        let running = State::Running { rank };
        let tasks: Vec<usize> = (0..self.states.len()).filter(|&task| self.states[task] == running).collect();
        for &task in &tasks {
            self.states[task] = State::Lost { rank };
        }
        tasks
    }

    /// Hands out nothing more.
    pub fn stop(&mut self) {
        self.queue.clear();
    }

    /// Whether nothing is left to be handed out or to be waited for.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.queue.is_empty() && !self.states.iter().any(|state| matches!(state, State::Running { .. }))
    }

    /// What became of every task.
    #[must_use]
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// So many tasks are in a state.
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
        assert_eq!(states, ["failed: no room", "not begun", "not begun", "finished", "lost with rank 1"]);
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
