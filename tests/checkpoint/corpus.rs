//! Fuzzing inputs as ordinary tests: the files of `tests/corpus`, and random bytes.

use crate::driver::drive;
use crate::reader::{read, small};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::fs;
use std::path::{Path, PathBuf};

/// The files of a folder, and their bytes.
fn corpus(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name);
    let files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(!files.is_empty());
    files.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

#[test]
fn checkpoints_of_the_corpus() {
    let taken: usize = corpus("checkpoint").iter().map(|(_, bytes)| read(bytes)).sum();
    // The run that all others are made of, as it is and sealed anew.
    assert!(taken >= 2, "{taken}");
}

#[test]
fn programs_of_the_corpus() {
    for (path, bytes) in corpus("api") {
        println!("{}", path.display());
        drive(&bytes);
    }
}

/// So many programs that nobody wrote; how many came to their end.
fn programs(count: u64) -> u64 {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut ended = 0;
    for _ in 0..count {
        let mut bytes = [0; 96];
        random.fill(&mut bytes[..]);
        // Odd numbers are rare, or nearly none is built.
        for byte in &mut bytes {
            if *byte >= 248 && random.random_range(0..8) > 0 {
                *byte -= 128;
            }
        }
        ended += u64::from(drive(&bytes).starts_with('['));
    }
    ended
}

#[test]
fn programs_at_random() {
    let ended = programs(200);
    assert!(ended > 20, "{ended}");
}

#[test]
#[ignore = "an hour"]
fn many_programs_at_random() {
    println!("{} came to their end", programs(100_000));
}

#[test]
#[ignore = "writes the checkpoint of the corpus"]
fn write_corpus() {
    let (builder, mut observer) = small();
    let mut simulation = builder.build().unwrap();
    simulation.equilibrate(20, &mut ()).unwrap();
    simulation.run(41, &mut observer).unwrap();
    let bytes = simulation.snapshot(&mut observer).unwrap().to_bytes();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/checkpoint");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("small"), bytes).unwrap();
}
