//! Compile errors show the hints of the library.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

/// What the compiler says to a file of `tests/compile_fail`, which it must refuse. It is given the
/// library that this test was built with: the newest beside it.
fn refusal(name: &str) -> String {
    let test = std::env::current_exe().unwrap();
    let dependencies = test.parent().unwrap();
    let library = std::fs::read_dir(dependencies)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            file.starts_with("libgradient_mc-") && file.ends_with(".rlib")
        })
        .max_by_key(|path| path.metadata().unwrap().modified().unwrap())
        .unwrap();
    let output = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .args(["--edition", "2024", "--emit", "metadata", "--color", "never", "-o"])
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join(name))
        .arg("-L")
        .arg(format!("dependency={}", dependencies.display()))
        .arg("--extern")
        .arg(format!("gradient_mc={}", library.display()))
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/compile_fail").join(name))
        .output()
        .unwrap();
    assert!(!output.status.success(), "{name} compiles");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn what_is_no_scheme_is_refused_with_a_hint() {
    let said = refusal("not_a_scheme.rs");
    for part in
        ["`MyScheme` is not a scheme for a field `UniformField`", "leave `.scheme()` out", "SelfConsistent"]
    {
        assert!(said.contains(part), "{said}");
    }
    assert!(!said.contains("trait bounds were not satisfied"), "{said}");
}
