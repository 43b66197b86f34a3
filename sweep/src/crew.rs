//! The work of a rank: its first thread exchanges messages with other ranks, its other threads run
//! tasks. Rank 0 also distributes the tasks.

use crate::dispatch::{Dispatch, State};
use crate::link::{Link, Message};
use crate::progress::Progress;
use crate::run::Job;
use crate::table::Task;
use std::cell::Cell;
use std::collections::VecDeque;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two checks for messages. Waiting inside MPI would occupy a core.
const PAUSE: Duration = Duration::from_millis(20);
/// Time between two messages `Alive`.
const BEAT: Duration = Duration::from_secs(1);

/// The threads of this rank that run tasks.
struct Hands<'a> {
    tasks: Sender<usize>,
    events: Receiver<Message>,
    work: &'a Work,
}

/// Work done by these threads, in spheres times sweeps.
#[derive(Debug, Default)]
struct Work {
    /// Work so far, including that of earlier processes.
    done: AtomicU64,
    /// Work of earlier processes.
    before: AtomicU64,
}

impl Work {
    fn both(&self) -> [u64; 2] {
        [&self.done, &self.before].map(|work| work.load(Ordering::Relaxed))
    }
}

impl Hands<'_> {
    /// Calls `talk` while `threads` threads run tasks. Running tasks have ended when it returns.
    fn employ<R>(job: &Job, threads: usize, talk: impl FnOnce(&Hands<'_>) -> R) -> R {
        let (tasks, to_do) = mpsc::channel();
        let (done, events) = mpsc::channel();
        let (to_do, work) = (&Mutex::new(to_do), &Work::default());
        let all = job.table.tasks();
        thread::scope(|scope| {
            for _ in 0..threads {
                let (done, all) = (done.clone(), &all);
                scope.spawn(move || {
                    loop {
                        let Ok(to_do) = to_do.lock() else { break };
                        let Ok(number) = to_do.recv() else { break };
                        drop(to_do);
                        let Some(&task) = all.get(number) else { continue };
                        if done.send(outcome(job, number, task, work)).is_err() {
                            break;
                        }
                    }
                });
            }
            // The channel of tasks is closed here, which ends the threads.
            talk(&Hands { tasks, events, work })
        })
    }

    /// Starts a task as soon as a thread is free.
    fn begin(&self, task: usize) {
        self.tasks.send(task).ok();
    }

    /// Messages of the threads; waits a short time if there are none.
    fn heard(&self) -> Vec<Message> {
        match self.events.recv_timeout(PAUSE) {
            Ok(first) => std::iter::once(first).chain(self.events.try_iter()).collect(),
            Err(RecvTimeoutError::Timeout) => Vec::new(),
            // No thread is left. This does not happen, but must not become a busy loop.
            Err(RecvTimeoutError::Disconnected) => {
                thread::sleep(PAUSE);
                Vec::new()
            }
        }
    }
}

/// Runs a task and returns the message about its result.
fn outcome(job: &Job, number: usize, task: Task, work: &Work) -> Message {
    let last = Cell::new(None);
    let ran = job.run(task, |[began, now]| {
        let from = last.replace(Some(now)).unwrap_or_else(|| {
            work.before.fetch_add(began, Ordering::Relaxed);
            0
        });
        work.done.fetch_add(now.saturating_sub(from), Ordering::Relaxed);
    });
    let number = number as u64;
    match ran {
        Ok(true) => {
            // A target may end a task before all sweeps are done.
            let all = job.table.cases[task.case].work();
            work.done.fetch_add(all.saturating_sub(last.get().unwrap_or(0)), Ordering::Relaxed);
            Message::Finished(number)
        }
        Ok(false) => Message::Stopped(number),
        Err(failure) => Message::Failed(number, failure.explained()),
    }
}

/// The result of a parameter sweep.
#[derive(Debug, Clone)]
pub struct Ended {
    /// State of every task of the table.
    pub states: Vec<State>,
    /// Number of ranks that do not answer.
    pub lost_ranks: usize,
}

/// Rank 0: distributes the tasks of `queue`, runs tasks too, and returns when all have ended. It
/// then ends the other ranks.
pub fn lead(
    job: &Job,
    link: &mut dyn Link,
    threads: usize,
    queue: Vec<usize>,
    signaled: &dyn Fn() -> bool,
) -> Ended {
    let all = job.table.tasks();
    let total = queue.iter().map(|&task| job.table.cases[all[task].case].work()).sum();
    let progress = Progress::new(total, queue.len());
    Hands::employ(job, threads, |hands| {
        let mut leader = Leader {
            dispatch: Dispatch::new(all.len(), queue),
            ranks: vec![Rank { heard: Instant::now(), is_lost: false, work: [0, 0] }; link.ranks()],
            has_told: false,
            job,
            link,
            hands,
            progress,
        };
        leader.run(threads, signaled);
        for rank in (1..leader.ranks.len()).filter(|&rank| !leader.ranks[rank].is_lost) {
            leader.link.send(rank, &Message::End);
        }
        Ended {
            states: leader.dispatch.states().to_vec(),
            lost_ranks: leader.ranks.iter().filter(|rank| rank.is_lost).count(),
        }
    })
}

/// Data of rank 0 about a rank.
#[derive(Debug, Clone)]
struct Rank {
    heard: Instant,
    is_lost: bool,
    work: [u64; 2],
}

struct Leader<'a> {
    dispatch: Dispatch,
    ranks: Vec<Rank>,
    /// Whether the other ranks have been told to stop.
    has_told: bool,
    job: &'a Job,
    link: &'a mut dyn Link,
    hands: &'a Hands<'a>,
    progress: Progress,
}

impl Leader<'_> {
    fn run(&mut self, threads: usize, signaled: &dyn Fn() -> bool) {
        let mut inbox = VecDeque::from([(0, Message::Ready(threads as u64))]);
        let mut beat = Instant::now();
        loop {
            inbox.extend(std::iter::from_fn(|| self.link.receive()));
            while let Some((from, message)) = inbox.pop_front() {
                self.heed(from, message);
            }
            if signaled() {
                self.job.stop.store(true, Ordering::SeqCst);
            }
            if self.job.is_stopping() && !self.has_told {
                self.has_told = true;
                self.dispatch.stop();
                for rank in (1..self.ranks.len()).filter(|&rank| !self.ranks[rank].is_lost) {
                    self.link.send(rank, &Message::Stop);
                }
            }
            if beat.elapsed() >= BEAT {
                beat = Instant::now();
                self.give_up_the_silent();
                self.ranks[0].work = self.hands.work.both();
                self.show();
            }
            if self.dispatch.is_over() {
                self.ranks[0].work = self.hands.work.both();
                break;
            }
            inbox.extend(self.hands.heard().into_iter().map(|message| (0, message)));
        }
    }

    fn heed(&mut self, from: usize, message: Message) {
        if let Some(rank) = self.ranks.get_mut(from) {
            rank.heard = Instant::now();
        }
        match message {
            Message::Ready(count) => (0..count).for_each(|_| self.hand_to(from)),
            Message::Finished(task) => self.ended(from, task, State::Finished),
            Message::Stopped(task) => {
                self.job.stop.store(true, Ordering::SeqCst);
                self.ended(from, task, State::Stopped);
            }
            Message::Failed(task, why) => self.ended(from, task, State::Failed(why)),
            Message::Alive(work) => {
                if let Some(rank) = self.ranks.get_mut(from) {
                    rank.work = work;
                }
                // Sent only as an answer, so nothing is sent to ranks that have ended.
                if from > 0 {
                    self.link.send(from, &Message::Alive([0, 0]));
                }
            }
            Message::Stop => self.job.stop.store(true, Ordering::SeqCst),
            Message::Table(_) | Message::Task(_) | Message::End => {}
        }
    }

    fn hand_to(&mut self, rank: usize) {
        if self.ranks.get(rank).is_none_or(|rank| rank.is_lost) || self.job.is_stopping() {
            return;
        }
        match self.dispatch.next(rank) {
            Some(task) if rank == 0 => self.hands.begin(task),
            Some(task) => self.link.send(rank, &Message::Task(task as u64)),
            None => {}
        }
    }

    fn ended(&mut self, from: usize, task: u64, state: State) {
        let Ok(number) = usize::try_from(task) else { return };
        if let (State::Failed(why), Some(&task)) = (&state, self.job.table.tasks().get(number)) {
            self.progress.say(&format!("{} on rank {from} failed: {why}", self.job.describe(task)));
        }
        self.dispatch.ended(number, state);
        self.hand_to(from);
    }

    fn give_up_the_silent(&mut self) {
        for rank in 1..self.ranks.len() {
            let of_rank = &mut self.ranks[rank];
            if of_rank.is_lost || of_rank.heard.elapsed() <= self.job.patience {
                continue;
            }
            of_rank.is_lost = true;
            let silence = of_rank.heard.elapsed().as_secs();
            self.progress.say(&format!(
                "rank {rank} has been silent for {silence} s: its runs are left for the next command"
            ));
            let tasks = self.job.table.tasks();
            for task in self.dispatch.lost(rank) {
                self.progress.say(&format!("  with it: {}", self.job.describe(tasks[task])));
            }
        }
    }

    fn show(&mut self) {
        let work = self
            .ranks
            .iter()
            .fold([0, 0], |[done, before], Rank { work, .. }| [done + work[0], before + work[1]]);
        let finished = self.dispatch.count(|state| *state == State::Finished);
        let running = self.dispatch.count(|state| matches!(state, State::Running { .. }));
        self.progress.show(work, finished, running);
    }
}

/// A rank other than 0: runs the tasks of rank 0 until it is told to end. Returns false if rank 0
/// does not answer.
pub fn follow(job: &Job, link: &mut dyn Link, threads: usize, signaled: &dyn Fn() -> bool) -> bool {
    Hands::employ(job, threads, |hands| {
        link.send(0, &Message::Ready(threads as u64));
        let (mut beat, mut heard, mut has_told) = (Instant::now(), Instant::now(), false);
        let is_over = loop {
            for message in hands.heard() {
                link.send(0, &message);
            }
            let mut is_over = false;
            while let Some((_, message)) = link.receive() {
                heard = Instant::now();
                match message {
                    Message::Task(task) => hands.begin(usize::try_from(task).unwrap_or(usize::MAX)),
                    Message::Stop => job.stop.store(true, Ordering::SeqCst),
                    Message::End => is_over = true,
                    _ => {}
                }
            }
            if is_over || heard.elapsed() > job.patience {
                break is_over;
            }
            if signaled() && !has_told {
                has_told = true;
                job.stop.store(true, Ordering::SeqCst);
                link.send(0, &Message::Stop);
            }
            if beat.elapsed() >= BEAT {
                beat = Instant::now();
                link.send(0, &Message::Alive(hands.work.both()));
            }
        };
        // The event of a task that rank 0 no longer waits for.
        job.stop.store(true, Ordering::SeqCst);
        is_over
    })
}

/// Waits for the table, the first message to a rank other than 0. `None` if there is nothing to do.
pub fn await_table(link: &mut dyn Link, patience: Duration) -> Option<String> {
    let start = Instant::now();
    while start.elapsed() < patience {
        match link.receive() {
            Some((_, Message::Table(text))) => return Some(text),
            Some((_, Message::End)) => return None,
            _ => thread::sleep(PAUSE),
        }
    }
    None
}
