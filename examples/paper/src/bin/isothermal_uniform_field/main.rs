//! Figures 2 to 6 of Mehrotra, Puri and Khakhar (doi:10.1103/PhysRevE.83.061306): an isothermal
//! column in a uniform field, 40 spheres per area of the base, in a box 400 high, at T₀ = 5, 15, 20
//! and 30.
//!
//! | figure | content |
//! |---|---|
//! | 2 | height of the center of mass against sweeps, with the moves of the paper and with event chains; inset: plateau against T₀ |
//! | 3a, 3b | density against height with theory; on a logarithmic scale with the ideal gas |
//! | 4 | layers at the base; inset: lateral radial distribution function of the first layer |
//! | 5 | mean accepted displacement against height |
//! | 6 | equation of state |
//! | layered base | not in the paper: comparison with density functional theory and the contact theorem |
//!
//! Columns with two bases relax to the steady state from far above and from far below. Each figure
//! is a CSV file, a PNG and an SVG, and has claims that are tested with the data: the exit code is
//! 1 if one fails.

// Temperatures and widths are copied and never computed.
#![allow(clippy::float_cmp)]

#[macro_use]
extern crate paper;

mod column;
mod figure_02;
mod figure_03;
mod figure_04;
mod figure_05;
mod figure_06;
mod layered_base;
mod layers;
mod log_polynomial;
mod protocol;
mod state;
mod steadiness;
mod style;
mod theory;

use column::Column;
use paper::{Ending, Failure, Report, Session, replicas, study};
use protocol::{Arguments, Protocol, Task};
use state::State;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    study::main("isothermal_uniform_field", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    let protocol = Protocol::new(arguments, session);
    println!("{protocol}");
    let started = Instant::now();
    let tasks: Vec<Task> = protocol.tasks().copied().collect();
    let mut steady: Vec<Column> =
        session.run_all("columns", tasks, Task::name, Task::cost, column::simulate)?;
    let falling = steady.split_off(protocol.steady.len());

    let mut report = Report::new(session);
    let states = arguments
        .temperatures()
        .map(|temperature| State::new(temperature, &steady))
        .collect::<Result<Vec<_>, _>>()?;
    figure_02::report(&states, &steady, &falling, &mut report)?;
    figure_03::report(&states, &mut report)?;
    figure_04::report(&states, &mut report)?;
    figure_05::report(&states, &mut report)?;
    figure_06::report(&states, &mut report)?;
    layered_base::report(&states, &mut report)?;
    let busy: f64 = states.iter().map(State::busy).sum();
    let fell: f64 = falling.iter().map(|column| column.busy).sum();
    println!(
        "{busy:.0} CPU s for the measured columns{}; {:.0} s on {} threads. Errors are one standard error.",
        if fell > 0.0 {
            format!(", {fell:.0} for the relaxation by the moves of the paper")
        } else {
            String::new()
        },
        started.elapsed().as_secs_f64(),
        replicas::thread_count(session.threads)
    );
    report.finish()
}
