//! The table of faults, `docs/reliability.md`: every test and script that it names exists, and every row names one.

use std::collections::BTreeSet;
use std::path::Path;

use crate::source_lengths::rust_files;

/// Words in backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// Names of the functions behind an attribute `#[test]`.
fn tests_of(text: &str) -> impl Iterator<Item = &str> {
    text.split("#[test]").skip(1).filter_map(|rest| {
        let name = rest.split_once("fn ")?.1;
        Some(name.split_once('(')?.0)
    })
}

#[test]
fn every_fault_has_a_test_that_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut tests = BTreeSet::new();
    for file in ["src", "tests"].iter().flat_map(|folder| rust_files(&root.join(folder))) {
        let text = std::fs::read_to_string(file).unwrap();
        tests.extend(tests_of(&text).map(str::to_owned));
    }
    let table = std::fs::read_to_string(root.join("docs/reliability.md")).unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| fault "));
    let mut count = 0;
    for row in rows {
        let (_, named) = row.trim_end_matches(" |").rsplit_once(" | ").unwrap();
        assert!(quoted(named).next().is_some(), "no test: {row}");
        for name in quoted(named) {
            let is_there = match name.split_whitespace().next() {
                Some(script) if script.contains('/') => root.join(script).is_file(),
                _ => tests.contains(name),
            };
            assert!(is_there, "no test or script `{name}`: {row}");
        }
        count += 1;
    }
    assert!(count > 50, "{count} rows were read");
}
