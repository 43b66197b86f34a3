//! Running a study as a process of its own.

use super::gather::REPORT;
use paper::Failure;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How a process came to its end.
#[derive(Debug, Clone)]
pub(crate) struct Launched {
    /// As the shell would show it; none if a signal ended it.
    pub(crate) code: Option<i32>,
    pub(crate) duration: Duration,
}

/// Runs the study with these arguments and output in `directory`, and keeps what it prints there.
///
/// Cargo builds it first if it has to: `cargo run -p paper --bin all_figures` builds no other study. Where there is no cargo the
/// executable beside this one is taken.
pub(crate) fn launch(study: &str, arguments: &[OsString], directory: &Path) -> Result<Launched, Failure> {
    std::fs::create_dir_all(directory)?;
    // What an earlier run has left must not pass for this one's.
    for file in ["verdicts.csv", "captions.csv", REPORT] {
        match std::fs::remove_file(directory.join(file)) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error.into()),
            _ => {}
        }
    }
    let started = Instant::now();
    let output = match by_cargo(study, arguments, directory).output() {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            beside_this_one(study, arguments, directory)?.output()
        }
        output => output,
    };
    let output = output.map_err(|error| format!("cannot start {study}: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    println!("{text}");
    std::fs::write(directory.join(REPORT), text.as_bytes())?;
    Ok(Launched { code: output.status.code(), duration: started.elapsed() })
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
