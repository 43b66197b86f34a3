//! Ranks that are threads of one process.

use gradient_mc_sweep::crew::{self, Ended};
use gradient_mc_sweep::link::{Link, Message};
use gradient_mc_sweep::{Folder, Job, Table};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Duration;

/// From whom, and the kind and content of a message, as MPI carries them.
type Letter = (usize, (i32, Vec<u8>));

pub(crate) struct Channels {
    rank: usize,
    to: Vec<Sender<Letter>>,
    inbox: Receiver<Letter>,
}

impl Link for Channels {
    fn rank(&self) -> usize {
        self.rank
    }
    fn ranks(&self) -> usize {
        self.to.len()
    }
    fn send(&mut self, rank: usize, message: &Message) {
        self.to[rank].send((self.rank, message.encode())).ok();
    }
    fn receive(&mut self) -> Option<(usize, Message)> {
        let (from, (kind, content)) = self.inbox.try_recv().ok()?;
        Some((from, Message::decode(kind, &content).unwrap()))
    }
    fn abort(&mut self, code: u8) -> ! {
        panic!("aborted with {code}")
    }
}

pub(crate) fn channels(ranks: usize) -> Vec<Channels> {
    let (to, inboxes): (Vec<_>, Vec<_>) = (0..ranks).map(|_| channel()).unzip();
    let link = |(rank, inbox)| Channels { rank, to: to.clone(), inbox };
    inboxes.into_iter().enumerate().map(link).collect()
}

pub(crate) fn job(table: &str, folder: &Path) -> Job {
    Job {
        table: Table::read(table).unwrap(),
        folder: Folder::new(folder).unwrap(),
        checkpoint_every: Duration::from_secs(60),
        patience: Duration::from_secs(60),
        stop: AtomicBool::new(false),
    }
}

/// Does all that is not finished, on so many ranks with so many threads each.
pub(crate) fn sweep(
    table: &str,
    folder: &Path,
    [ranks, threads]: [usize; 2],
    signaled: &(dyn Fn() -> bool + Sync),
) -> Ended {
    let mut links = channels(ranks).into_iter();
    let mut first = links.next().unwrap();
    thread::scope(|scope| {
        for mut link in links {
            scope.spawn(move || assert!(crew::follow(&job(table, folder), &mut link, threads, &|| false)));
        }
        let job = job(table, folder);
        let tasks = job.table.tasks();
        let queue = (0..tasks.len()).filter(|&task| !job.is_finished(tasks[task])).collect();
        let ended = crew::lead(&job, &mut first, threads, queue, signaled);
        job.write_results(|task| ended.states[task].clone()).unwrap();
        ended
    })
}
