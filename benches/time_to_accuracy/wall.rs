//! Seconds of the clock until P(x) is known.

use crate::column::{self, Errors, Profile};
use crate::methods::{Engine, Method};
use crate::{Arguments, Checkpoint, crossing};
use paper::Failure;
use paper::table::Table;
use rayon::prelude::*;
use std::time::Instant;

/// Replicas that run at the same time, one on each thread, and whose profiles are averaged.
struct Team {
    replicas: Vec<Box<dyn Engine>>,
    seconds: f64,
    cpu_seconds: f64,
}

impl Team {
    fn new(method: Method, members: u64, width: f64, number: u64) -> Result<Self, Failure> {
        let seeds = members * number..members * (number + 1);
        let replicas = seeds.map(|seed| method.engine(width, seed)).collect::<Result<_, _>>()?;
        Ok(Self { replicas, seconds: 0.0, cpu_seconds: 0.0 })
    }

    fn observe(&mut self, width: f64, sweeps: u64) -> Result<Profile, Failure> {
        let start = Instant::now();
        let members: Vec<(Profile, f64)> = self
            .replicas
            .par_iter_mut()
            .with_max_len(1)
            .map(|engine| {
                let start = paper::clock::cpu_seconds();
                let profile = column::observe(&mut **engine, width, sweeps)?;
                Ok((profile, paper::clock::cpu_seconds() - start))
            })
            .collect::<Result<_, Failure>>()?;
        self.seconds += start.elapsed().as_secs_f64();
        let (profiles, cpu_seconds): (Vec<Profile>, Vec<f64>) = members.into_iter().unzip();
        self.cpu_seconds += cpu_seconds.iter().sum::<f64>();
        Ok(Profile::mean(&profiles))
    }
}

/// What a method took.
struct Run {
    label: String,
    checkpoints: Vec<Checkpoint>,
    /// Cores that were at work, on average.
    cores: f64,
}

/// Follows several teams, one after the other, until their error of P(x) is below the target.
fn measure(method: Method, members: u64, arguments: &Arguments, reference: &Profile) -> Result<Run, Failure> {
    let mut teams = (0..arguments.replicas)
        .map(|number| Team::new(method, members, arguments.width, number))
        .collect::<Result<Vec<_>, _>>()?;
    let (mut checkpoints, mut sweeps, mut stretch) = (Vec::new(), 0, 64);
    loop {
        let profiles = teams
            .iter_mut()
            .map(|team| team.observe(arguments.width, stretch))
            .collect::<Result<Vec<_>, _>>()?;
        sweeps += stretch;
        stretch = sweeps;
        let total = |of: fn(&Team) -> f64| teams.iter().map(of).sum::<f64>();
        let (clock, cpu) = (total(|team| team.seconds), total(|team| team.cpu_seconds));
        let seconds = clock / teams.len() as f64;
        let errors = Errors::of(&profiles, reference);
        checkpoints.push(Checkpoint { seconds, sweeps, errors });
        if errors.pressure < arguments.target || seconds > arguments.patience {
            let threads = if members == 1 { "one core".into() } else { format!("{members} threads") };
            let label = format!("{}, {threads}", method.label());
            println!("{label:<52} {sweeps} sweeps, {seconds:.1} s: {errors}");
            return Ok(Run { label, checkpoints, cores: cpu / clock });
        }
    }
}

/// Prints the table: the paper's algorithm on one core, last, against pairs of replicas.
pub(crate) fn compare(arguments: &Arguments, reference: &Profile) -> Result<(), Failure> {
    let mut runs = Vec::new();
    for (method, members) in [
        (Method::TunedFromUniform, 2),
        (Method::ChainsFromUniform, 2),
        (Method::LocalFromUniform, 2),
        (Method::Plain, 1),
    ] {
        runs.push(measure(method, members, arguments, reference)?);
    }
    let head =
        [format!("P(x) to {} %", 100.0 * arguments.target), "seconds".into(), "gain".into(), "cores".into()];
    let mut table = Table::new(head.to_vec());
    let seconds = |run: &Run| crossing(&run.checkpoints, arguments.target, |errors| errors.pressure);
    let baseline = runs.last().and_then(seconds);
    for run in &runs {
        let Some((own, other)) = seconds(run).zip(baseline) else { continue };
        let about = |extrapolated: bool| if extrapolated { "≥ " } else { "" };
        let gain =
            format!("{}{:.1}", about(other.extrapolated && !own.extrapolated), other.seconds / own.seconds);
        let time = format!("{}{:.2}", about(own.extrapolated), own.seconds);
        table.row(&run.label, vec![time, gain, format!("{:.2}", run.cores)]);
    }
    println!("\n{table}");
    println!(
        "seconds of wall time; cores: CPU time over wall time, below the number of threads if the machine was not idle."
    );
    println!(
        "≥: not reached; extrapolated with an error proportional to 1/sqrt(time) from the last checkpoint on."
    );
    Ok(())
}
