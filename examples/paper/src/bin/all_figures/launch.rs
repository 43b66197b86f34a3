//! Running a study as a process of its own.

use super::gather::REPORT;
use paper::interrupt::Interrupt;
use paper::progress::in_words;
use paper::{Failure, output};
use std::ffi::OsString;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// A study that has come to its end.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Launched {
    /// Whether all its claims hold.
    pub(crate) holds: bool,
    pub(crate) duration: Duration,
}

/// Runs the study with these arguments and output in `directory`, and stores its printed output
/// there. Fails if it does not come to its end.
///
/// Cargo builds it first if it has to: `cargo run -p paper --bin all_figures` builds no other
/// study. Where there is no cargo the executable beside this one is taken. It is told to stop when
/// this process is.
pub(crate) fn launch(
    study: &str,
    arguments: &[OsString],
    directory: &Path,
    interrupt: &Interrupt,
) -> Result<Launched, Failure> {
    output::create_directory(directory)?;
    // What an earlier run has left must not pass for this one's.
    for file in ["verdicts.csv", "captions.csv", REPORT] {
        let path = directory.join(file);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(format!("cannot remove {}: {error}", path.display()).into());
            }
            _ => {}
        }
    }
    let started = Instant::now();
    let ended = match run(by_cargo(study, arguments, directory), interrupt) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            run(beside_this_one(study, arguments, directory)?, interrupt)
        }
        ended => ended,
    };
    let ended = ended.map_err(|error| format!("cannot run {study}: {error}"))?;
    let text = String::from_utf8_lossy(&ended.stdout);
    println!("{text}");
    output::write(&directory.join(REPORT), text.as_bytes())?;
    let duration = started.elapsed();
    match ended.status.code() {
        Some(code @ (0 | 1)) => Ok(Launched { holds: code == 0, duration }),
        Some(130) => Err("interrupted".into()),
        Some(code) => Err(format!("failed with exit code {code} after {}", in_words(duration)).into()),
        None => Err(format!("ended by a signal after {}", in_words(duration)).into()),
    }
}

/// Runs a command to its end, and stops it if this process is stopped.
fn run(mut command: Command, interrupt: &Interrupt) -> std::io::Result<Output> {
    let mut child = command.stdout(Stdio::piped()).spawn()?;
    let pipe = child.stdout.take();
    let reader = thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.map_or(Ok(0), |mut pipe| pipe.read_to_end(&mut bytes)).map(|_| bytes)
    });
    let mut told = false;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if interrupt.pressed() && !told {
            told = true;
            stop(child.id());
        }
        thread::sleep(Duration::from_millis(50));
    };
    let stdout = reader.join().map_err(|_| std::io::Error::other("its output is lost"))??;
    Ok(Output { status, stdout, stderr: Vec::new() })
}

/// Sends SIGTERM. A terminal sends its signals to the whole group by itself; a second one does no
/// harm. Elsewhere the study runs to its end.
fn stop(process: u32) {
    if cfg!(unix) {
        Command::new("kill").args(["-TERM", &process.to_string()]).status().ok();
    }
}

fn by_cargo(study: &str, arguments: &[OsString], directory: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.arg("run").arg("--manifest-path").arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"));
    // As this program was built.
    if !cfg!(debug_assertions) {
        command.arg("--release");
    }
    command.args(["--bin", study, "--"]);
    complete(command, arguments, directory)
}

fn beside_this_one(study: &str, arguments: &[OsString], directory: &Path) -> Result<Command, Failure> {
    let this = std::env::current_exe()?;
    let name = format!("{study}{}", std::env::consts::EXE_SUFFIX);
    Ok(complete(Command::new(this.with_file_name(name)), arguments, directory))
}

fn complete(mut command: Command, arguments: &[OsString], directory: &Path) -> Command {
    command.args(arguments).arg("--out").arg(directory);
    command.stdin(Stdio::null()).stderr(Stdio::inherit());
    command
}
