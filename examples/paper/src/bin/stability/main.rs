//! Where methods fail, how, and whether the program warns: every method over a range of the
//! parameter at which it fails.
//!
//! Each point of a map is a run that is compared with an independent reference: an exact result,
//! the hydrostatic theory where it is accurate, or a simulation where the theory is tested. All
//! points are judged by the same rule ([`verdict`]).

#[macro_use]
extern crate paper;

mod bins;
mod boxes;
mod column;
mod feedback;
mod freezing;
mod map;
mod moves;
mod picture;
mod precision;
mod profiles;
mod said;
mod sizes;
mod summary;
mod theory;
mod verdict;

use gradient_mc::statistics::Estimate;
use map::{Map, Measured};
use paper::{Ending, Failure, Report, Session, study};
use std::process::ExitCode;

/// Runs each method over a range of the parameter at which it fails, and reports where and how it
/// fails and whether the program warns
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Only the map with this name
    #[arg(long)]
    only: Option<String>,

    /// Print all warnings and errors
    #[arg(long)]
    verbose: bool,
}

/// Maps that share a picture.
struct Family {
    name: &'static str,
    title: &'static str,
    maps: Vec<Map>,
}

fn families() -> Vec<Family> {
    let family = |name, title, maps| Family { name, title, maps };
    vec![
        family(
            "moves",
            "Moves: size, length, jammed starts",
            vec![moves::sizes(), moves::chain_lengths(), moves::jams()],
        ),
        family("boxes", "The box: width and height", vec![boxes::widths(), boxes::lids()]),
        family(
            "freezing",
            "Towards freezing and beyond: colder columns, steeper fields and temperatures",
            vec![freezing::cold(), freezing::fields(), freezing::temperatures()],
        ),
        family(
            "feedback",
            "The feedback if the temperature varies: bins, schemes, equilibration, spheres",
            vec![feedback::bins(), feedback::patience(), feedback::few()],
        ),
        family(
            "theory",
            "Theory beyond its domain, and measuring bins",
            vec![theory::equations(), theory::steep(), theory::steep_temperatures(), bins::widths()],
        ),
        family(
            "profiles",
            "Fields and temperatures with jumps",
            vec![profiles::fields(), profiles::temperatures()],
        ),
        family(
            "sizes",
            "Starts, numbers of spheres, and single precision",
            vec![sizes::starts(), sizes::few(), sizes::many(), precision::heights()],
        ),
    ]
}

fn main() -> ExitCode {
    study::main("stability", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    let mut report = Report::new(session);
    let mut families = families();
    let names: Vec<&str> = families.iter().flat_map(|family| &family.maps).map(|map| map.name).collect();
    if let Some(only) = arguments.only.as_deref() {
        if !names.contains(&only) {
            return Err(format!("--only {only} is invalid: use one of {}", names.join(", ")).into());
        }
        for family in &mut families {
            family.maps.retain(|map| map.name == only);
        }
    }
    let heads: Vec<(&str, &str, usize)> =
        families.iter().map(|family| (family.name, family.title, family.maps.len())).collect();
    let maps: Vec<Map> = families.into_iter().flat_map(|family| family.maps).collect();
    let measured = map::measure(maps, session)?;
    let mut rest = &measured[..];
    for (name, title, count) in heads {
        let (own, others) = rest.split_at(count);
        rest = others;
        if !own.is_empty() {
            let own: Vec<&Measured> = own.iter().collect();
            let caption = "Result of a method at each point, and whether the program warns.";
            report.picture(name, &picture::draw(title, &own), caption)?;
        }
    }
    for map in &measured {
        map.write(&report.directory)?;
    }
    if arguments.verbose {
        for map in &measured {
            for point in &map.points {
                for said in &point.said {
                    println!("{}, {}, {}: {}: {}", map.name, point.series, point.label, said.name, said.text);
                }
            }
        }
    }
    println!("\n{}", summary::table(&measured));
    let seconds: f64 = measured.iter().flat_map(|map| &map.points).map(|point| point.cpu_seconds).sum();
    println!("{seconds:.0} CPU seconds");
    let silent = summary::silent_failures(&measured);
    for failure in &silent {
        println!("SILENT FAILURE: {failure}");
    }
    let claim = "points at which a number is wrong by more than its error bar without a warning";
    report.verdicts.at_most("stability", claim, Estimate::new(silent.len() as f64, 0.0), 0.0);
    report.finish()
}
