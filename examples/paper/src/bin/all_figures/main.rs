//! Every figure of doi:10.1103/PhysRevE.83.061306 on one page, with its claims and whether they
//! hold.
//!
//! Runs the four studies that draw figures 2 to 17, one after the other, each as its own process (a
//! failure does not stop the others), and writes `out/all_figures/index.html` from their pictures,
//! captions and verdicts in `out/<study>`. The exit code is 1 if a claim fails, and 2 if a study is
//! not complete. The same command then continues, and does not repeat complete studies.

#[macro_use]
extern crate paper;

mod gather;
mod launch;
mod page;

use gather::Gathered;
use launch::{Launched, launch};
use paper::unfinished::kept;
use paper::{Ending, Failure, Session, output, study};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draws every figure of the paper and puts them on one page.
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Use the full protocol of the paper in each study (many hours)
    #[arg(long)]
    paper: bool,

    /// Only make the page, from the results of earlier runs
    #[arg(long)]
    collect: bool,
}

/// Name, title and figures of the studies.
const STUDIES: [[&str; 3]; 4] = [
    ["isothermal_uniform_field", "Uniform temperature, uniform field", "2 to 6"],
    ["isothermal_varying_field", "Uniform temperature, varying field", "7 to 13"],
    ["nonisothermal", "Temperature gradient, uniform field", "14 to 16"],
    ["deviations", "Deviations from the equation of state", "17"],
];

/// A study, how its run ended, and its results.
#[derive(Debug)]
struct Part {
    study: &'static str,
    title: &'static str,
    figures: &'static str,
    directory: PathBuf,
    /// `None` if it was not run now.
    launched: Option<Result<Launched, Failure>>,
    gathered: Gathered,
}

impl Part {
    /// Whether it is complete, with all results.
    fn is_complete(&self) -> bool {
        // A study whose claims fail is complete too.
        !matches!(self.launched, Some(Err(_))) && self.gathered.missing.is_empty()
    }

    /// Whether it is complete and all claims hold.
    fn holds(&self) -> bool {
        self.is_complete() && self.gathered.holds()
    }
}

fn main() -> ExitCode {
    study::main("all_figures", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    // Beside the output of the studies.
    let out = session.out.clone().unwrap_or_else(|| PathBuf::from("out"));
    let directory = out.join("all_figures");
    output::create_directory(&directory)?;
    // A study is started from wherever cargo likes.
    let out = out.canonicalize()?;
    let mut parts = Vec::new();
    for (number, [study, title, figures]) in STUDIES.into_iter().enumerate() {
        let directory = out.join(study);
        let launched = (!arguments.collect && !session.interrupt.pressed()).then(|| {
            println!("{study}: figures {figures}");
            let launched = kept(&session.unfinished.of_task("studies", number), study, || {
                launch(study, &passed_on(arguments, session), &directory, &session.interrupt)
            });
            if let Err(failure) = &launched {
                eprintln!("{study}: {failure}");
            }
            launched
        });
        let gathered = Gathered::read(&directory);
        parts.push(Part { study, title, figures, directory, launched, gathered });
    }
    let path = directory.join("index.html");
    write_page(&parts, arguments, session, &path)?;
    for part in &parts {
        let Gathered { verdicts, missing, .. } = &part.gathered;
        let word = if part.holds() { "holds" } else { "FAILS" };
        println!("{word}: {}: {} of {} claims", part.study, part.gathered.held(), verdicts.len());
        for missing in missing {
            println!("  missing: {missing}");
        }
    }
    println!("written to {}", path.display());
    Ok(if session.interrupt.pressed() {
        Ending::Interrupted
    } else if let Some(part) = parts.iter().find(|part| matches!(part.launched, Some(Err(_)))) {
        return Err(format!("{} is not complete", part.study).into());
    } else if session.short && !parts.iter().all(Part::is_complete) {
        return Err("results are missing".into());
    } else if parts.iter().all(Part::holds) {
        Ending::Finished
    } else {
        Ending::ClaimFailed
    })
}

/// The arguments of each study.
fn passed_on(arguments: &Arguments, session: &Session) -> Vec<OsString> {
    let mut passed: Vec<OsString> = vec![
        "--seed".into(),
        session.seed.to_string().into(),
        "--threads".into(),
        session.threads.to_string().into(),
    ];
    passed.extend(arguments.paper.then(|| "--paper".into()));
    passed.extend(session.short.then(|| "--short".into()));
    passed.extend(session.fresh.then(|| "--fresh".into()));
    passed
}

fn write_page(parts: &[Part], arguments: &Arguments, session: &Session, path: &Path) -> Result<(), Failure> {
    let mut command = format!("cargo run --release -p paper --bin all_figures -- --seed {}", session.seed);
    let Arguments { paper, collect } = arguments;
    for (given, option) in [(paper, " --paper"), (collect, " --collect"), (&session.short, " --short")] {
        if *given {
            command += option;
        }
    }
    output::write(path, page::page(parts, &command))
}
