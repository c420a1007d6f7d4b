//! Replays every input that fuzzing found, and the seeds of some targets. docs/fuzzing.md tells how inputs get here.

use std::path::Path;
use std::time::{Duration, Instant};

use fuzz_targets::{PanicWatch, TARGETS};

/// Longest time of one input. Fuzzing allows 5 seconds; tests share the machine with each other.
const MAX_TIME: Duration = Duration::from_secs(20);

#[test]
fn stored_finds_pass() {
    let finds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../finds");
    let mut count = 0;
    for folder in std::fs::read_dir(&finds).unwrap().map(|entry| entry.unwrap().path()) {
        let name = folder.file_name().unwrap().to_str().unwrap();
        let target = TARGETS.iter().find(|target| target.name == name);
        let target = target.unwrap_or_else(|| panic!("{name} is no target"));
        for find in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let started = Instant::now();
            let found = PanicWatch::chained().run(target.run, &std::fs::read(&find).unwrap());
            assert_eq!(found, None, "{}", find.display());
            assert!(started.elapsed() < MAX_TIME, "{} took {:?}", find.display(), started.elapsed());
            count += 1;
        }
    }
    assert!(count > 0, "no find is stored");
}

/// The first two seeds of every target, so that targets work before anyone fuzzes.
#[test]
fn seeds_pass() {
    for target in &TARGETS {
        let seeds = (target.seeds)();
        assert!(!seeds.is_empty(), "{} has no seeds", target.name);
        for seed in seeds.iter().take(2) {
            let found = PanicWatch::chained().run(target.run, &seed.bytes);
            assert_eq!(found, None, "{} {}", target.name, seed.name);
        }
    }
}
