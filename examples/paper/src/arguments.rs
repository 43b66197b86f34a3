//! The part of the command line that every example has.

use std::path::PathBuf;

/// Arguments of every example.
#[derive(clap::Args, Debug, Clone)]
pub struct SharedArguments {
    /// Seed of the random numbers; replica k takes the stream that belongs to seed and k
    #[arg(long, default_value_t = 1)]
    pub seed: u64,

    /// Threads, up to 1024; 0 takes all cores. The results do not depend on it
    #[arg(long, default_value_t = 0, value_parser = thread_count)]
    pub threads: usize,

    /// Directory for the CSV files and pictures [default: out/<example>]
    #[arg(long)]
    pub out: Option<PathBuf>,
}

impl SharedArguments {
    /// The directory for output of the example of this name.
    pub fn directory(&self, example: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(example))
    }
}

/// A number of threads that a machine can be asked for without standing still.
fn thread_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(threads) if threads <= 1024 => Ok(threads),
        Ok(_) => Err("take at most 1024".into()),
        Err(error) => Err(format!("{error}")),
    }
}
