//! Where methods fail, how, and whether the program says so: every method across the parameter that
//! breaks it.
//!
//! Each point of a map is a run of its own against an independent truth: an exact result, the
//! hydrostatic theory where that is good, or a simulation where the theory is what is tested. One
//! rule ([`verdict`]) judges all.

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

/// Drives each method across the parameter that breaks it: where it fails, how, and whether the
/// program says so
#[derive(clap::Args, Debug)]
struct Arguments {
    /// One map only, by its name
    #[arg(long)]
    only: Option<String>,

    /// Prints every line that the program said
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
            "Moves: how large, how long, how jammed",
            vec![moves::sizes(), moves::chain_lengths(), moves::jams()],
        ),
        family("boxes", "The box: how wide and how high", vec![boxes::widths(), boxes::lids()]),
        family(
            "freezing",
            "Towards freezing and beyond: colder columns, steeper fields and temperatures",
            vec![freezing::cold(), freezing::fields(), freezing::temperatures()],
        ),
        family(
            "feedback",
            "The feedback of temperatures that vary: bins, schemes, patience, spheres",
            vec![feedback::bins(), feedback::patience(), feedback::few()],
        ),
        family(
            "theory",
            "Theory beyond its domain, and measuring bins",
            vec![theory::equations(), theory::steep(), theory::steep_temperatures(), bins::widths()],
        ),
        family(
            "profiles",
            "Fields and temperatures of a user's own that jump",
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
            return Err(format!("--only {only}: take one of {}", names.join(", ")).into());
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
            let caption = "What becomes of a method at each point, and whether the program says so.";
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
    let claim = "points at which a number is off by more than its error bar and the program says nothing";
    report.verdicts.at_most("stability", claim, Estimate::new(silent.len() as f64, 0.0), 0.0);
    report.finish()
}
