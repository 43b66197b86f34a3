//! Messages between ranks, and the interface that transmits them.

/// A message between ranks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// From rank 0, the first message: the text of the table.
    Table(String),
    /// To rank 0: this number of tasks can be started.
    Ready(u64),
    /// From rank 0: start the task of this number.
    Task(u64),
    /// To rank 0: this task is finished.
    Finished(u64),
    /// To rank 0: this task was stopped.
    Stopped(u64),
    /// To rank 0: this task failed, with its error.
    Failed(u64, String),
    /// To rank 0, every second: total work done, and the part of earlier processes. From rank 0:
    /// the answer.
    Alive([u64; 2]),
    /// To rank 0: a signal was received. From rank 0: write checkpoints and stop.
    Stop,
    /// From rank 0: end.
    End,
}

impl Message {
    /// The message as a kind, used as MPI tag, and a content.
    #[must_use]
    pub fn encode(&self) -> (i32, Vec<u8>) {
        let number = |number: &u64| number.to_le_bytes().to_vec();
        match self {
            Self::Table(text) => (0, text.clone().into_bytes()),
            Self::Ready(count) => (1, number(count)),
            Self::Task(task) => (2, number(task)),
            Self::Finished(task) => (3, number(task)),
            Self::Stopped(task) => (4, number(task)),
            Self::Failed(task, why) => (5, [&number(task), why.as_bytes()].concat()),
            Self::Alive(work) => (6, work.iter().flat_map(number).collect()),
            Self::Stop => (7, Vec::new()),
            Self::End => (8, Vec::new()),
        }
    }

    /// Decodes a message; `None` if it is invalid.
    #[must_use]
    pub fn decode(kind: i32, content: &[u8]) -> Option<Self> {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let first = || content.split_first_chunk().map(|(number, rest)| (u64::from_le_bytes(*number), rest));
        Some(match kind {
            0 => Self::Table(text(content)),
            1 => Self::Ready(first()?.0),
            2 => Self::Task(first()?.0),
            3 => Self::Finished(first()?.0),
            4 => Self::Stopped(first()?.0),
            5 => first().map(|(task, why)| Self::Failed(task, text(why)))?,
            6 => {
                let (done, rest) = first()?;
                Self::Alive([done, u64::from_le_bytes(*rest.first_chunk()?)])
            }
            7 => Self::Stop,
            8 => Self::End,
            _ => return None,
        })
    }
}

/// Connection of one rank to the others of a job. Only the thread that made it may use it.
pub trait Link {
    /// Number of this rank, from 0.
    fn rank(&self) -> usize;
    /// Number of ranks.
    fn ranks(&self) -> usize;
    /// Sends a message. Messages to a rank arrive in the order of the calls.
    fn send(&mut self, rank: usize, message: &Message);
    /// The next received message and the rank that sent it; `None` if there is none.
    fn receive(&mut self) -> Option<(usize, Message)>;
    /// Ends all ranks at once, if some do not answer.
    fn abort(&mut self, code: u8) -> !;
}

/// A single process without other ranks.
#[derive(Debug, Clone, Copy)]
pub struct Alone;

impl Link for Alone {
    fn rank(&self) -> usize {
        0
    }
    fn ranks(&self) -> usize {
        1
    }
    fn send(&mut self, _: usize, _: &Message) {}
    fn receive(&mut self) -> Option<(usize, Message)> {
        None
    }
    fn abort(&mut self, code: u8) -> ! {
        std::process::exit(code.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_as_they_were_sent_and_others_are_none() {
        let all = [
            Message::Table("height = 3\n".into()),
            Message::Ready(2),
            Message::Task(7),
            Message::Finished(u64::MAX),
            Message::Stopped(0),
            Message::Failed(3, "at 10⁻⁶ of contact".into()),
            Message::Alive([5, 3]),
            Message::Stop,
            Message::End,
        ];
        for message in all {
            let (kind, content) = message.encode();
            assert_eq!(Message::decode(kind, &content), Some(message));
        }
        for (kind, length) in [(1, 7), (5, 0), (6, 15), (9, 0), (-1, 8)] {
            assert_eq!(Message::decode(kind, &vec![0; length]), None, "{kind}");
        }
    }
}
