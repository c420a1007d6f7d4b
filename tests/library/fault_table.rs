//! The tables of `docs/faults.md`: every row names a test or a script, and all of them exist.

use std::collections::BTreeSet;
use std::path::Path;

use crate::source_lengths::rust_files;

/// Names of the functions with the attribute `#[test]` in `text`.
fn test_names(text: &str) -> impl Iterator<Item = &str> {
    let functions = text.split("#[test]").skip(1).filter_map(|rest| rest.split_once("fn "));
    functions.filter_map(|(_, function)| Some(function.split_once('(')?.0))
}

/// What is in backticks in the last column of each row of the tables in `text`, with the row.
fn named_by_rows(text: &str) -> impl Iterator<Item = (&str, Vec<&str>)> {
    let rows = text.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| fault |"));
    rows.filter_map(|row| {
        let (_, last) = row.strip_suffix(" |")?.rsplit_once(" | ")?;
        Some((row, last.split('`').skip(1).step_by(2).collect()))
    })
}

#[test]
fn every_row_names_tests_and_scripts_that_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut tests = BTreeSet::new();
    for file in ["src", "tests"].iter().flat_map(|folder| rust_files(&root.join(folder))) {
        let text = std::fs::read_to_string(file).unwrap();
        tests.extend(test_names(&text).map(str::to_owned));
    }
    let page = std::fs::read_to_string(root.join("docs/faults.md")).unwrap();
    let mut rows = 0;
    for (row, names) in named_by_rows(&page) {
        assert!(!names.is_empty(), "no test: {row}");
        for name in names {
            let exists = if name.contains('/') { root.join(name).is_file() } else { tests.contains(name) };
            assert!(exists, "{name} does not exist: {row}");
        }
        rows += 1;
    }
    assert!(rows > 50, "{rows} rows were read");
}

#[test]
fn names_are_those_of_the_last_column() {
    let table = "| fault | test |\n|---|---|\n| a `b` | `c`, `d/e` (prints `f`) |\n\n- `g`\n\n| fault | test |\n|---|---|\n| h | `i` |\n";
    let rows: Vec<_> = named_by_rows(table).map(|(_, names)| names).collect();
    assert_eq!(rows, [vec!["c", "d/e", "f"], vec!["i"]]);
    let source = "#[test]\nfn a() {}\nfn b() {}\n#[test]\n#[cfg(unix)]\nfn c() {}\n";
    assert_eq!(test_names(source).collect::<Vec<_>>(), ["a", "c"]);
}
