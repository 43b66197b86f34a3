//! Every figure of doi:10.1103/PhysRevE.83.061306 on one page, with what each claims and whether it holds.
//!
//! Runs the four examples that draw figures 2 to 17, one after the other, each as a process of its own (one that fails stops none
//! of the others), and writes `out/all_figures/index.html` from the pictures, captions and verdicts that they leave in
//! `out/<example>`. The exit code is 1 if a claim of any of them fails, or if one has not come to its end.

mod gather;
mod launch;
mod page;

use clap::Parser;
use gather::Gathered;
use launch::{Launched, launch};
use paper::interrupt::Interrupt;
use paper::{Ending, Failure, conclude, output};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draws every figure of the paper, and puts them on one page.
#[derive(Parser, Debug)]
#[command(name = "all_figures")]
struct Arguments {
    /// Seed of the random numbers, for each example
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Threads of each example; 0 takes all cores. The results do not depend on it
    #[arg(long, default_value_t = 0)]
    threads: usize,

    /// Directory for the output of all examples and, in `all_figures`, for the page
    #[arg(long, default_value = "out")]
    out: PathBuf,

    /// The paper's full protocol in each example: many hours
    #[arg(long)]
    paper: bool,

    /// Only makes the page, from what earlier runs have left
    #[arg(long)]
    collect: bool,
}

/// Name, title and figures of the examples.
const EXAMPLES: [[&str; 3]; 4] = [
    ["isothermal_uniform_field", "Uniform temperature, uniform field", "2 to 6"],
    ["isothermal_varying_field", "Uniform temperature, varying field", "7 to 13"],
    ["nonisothermal", "Temperature gradient, uniform field", "14 to 16"],
    ["deviations", "Deviations from the equation of state", "17"],
];

/// An example, how its run ended, and what it has left.
#[derive(Debug)]
struct Part {
    example: &'static str,
    title: &'static str,
    figures: &'static str,
    directory: PathBuf,
    /// None if it was not run now.
    launched: Option<Result<Launched, Failure>>,
    gathered: Gathered,
}

impl Part {
    /// Whether it came to its end, everything is there, and every claim holds.
    fn holds(&self) -> bool {
        let finished = match &self.launched {
            None => true,
            Some(Ok(launched)) => launched.code == Some(0),
            Some(Err(_)) => false,
        };
        finished && self.gathered.holds()
    }
}

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let directory = arguments.out.join("all_figures");
    output::create_directory(&directory)?;
    // An example is started from wherever cargo likes.
    let out = arguments.out.canonicalize()?;
    let interrupt = Interrupt::listen()?;
    let mut parts = Vec::new();
    for [example, title, figures] in EXAMPLES {
        let directory = out.join(example);
        let launched = (!arguments.collect && !interrupt.pressed()).then(|| {
            println!("{example}: figures {figures}");
            let launched = launch(example, &passed_on(arguments), &directory);
            if let Err(failure) = &launched {
                eprintln!("{example}: {failure}");
            }
            launched
        });
        let gathered = Gathered::read(&directory);
        parts.push(Part { example, title, figures, directory, launched, gathered });
    }
    let path = directory.join("index.html");
    write_page(&parts, arguments, &path)?;
    for part in &parts {
        let Gathered { verdicts, missing, .. } = &part.gathered;
        let word = if part.holds() { "holds" } else { "FAILS" };
        println!("{word}: {}: {} of {} claims", part.example, part.gathered.held(), verdicts.len());
        for missing in missing {
            println!("  missing: {missing}");
        }
    }
    println!("written to {}", path.display());
    Ok(if interrupt.pressed() {
        Ending::Interrupted
    } else if parts.iter().all(Part::holds) {
        Ending::Finished
    } else {
        Ending::ClaimFailed
    })
}

/// The arguments of each example.
fn passed_on(arguments: &Arguments) -> Vec<OsString> {
    let mut passed: Vec<OsString> = vec![
        "--seed".into(),
        arguments.seed.to_string().into(),
        "--threads".into(),
        arguments.threads.to_string().into(),
    ];
    if arguments.paper {
        passed.push("--paper".into());
    }
    passed
}

fn write_page(parts: &[Part], arguments: &Arguments, path: &Path) -> Result<(), Failure> {
    let Arguments { seed, paper, collect, .. } = arguments;
    let mut command = format!("cargo run --release -p paper --bin all_figures -- --seed {seed}");
    for (given, option) in [(paper, " --paper"), (collect, " --collect")] {
        if *given {
            command += option;
        }
    }
    std::fs::write(path, page::page(parts, &command))
        .map_err(|error| format!("cannot write {}: {error}", path.display()).into())
}
