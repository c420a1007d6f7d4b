//! Lengths of the source files themselves: no file over 400 lines, no function over 70.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::path::{Path, PathBuf};

const MAX_FILE_LINES: usize = 400;
const MAX_FUNCTION_LINES: usize = 70;
const FOLDERS: [&str; 4] = ["src", "tests", "examples", "benches"];

/// The Rust files below `folder`, sorted.
pub(crate) fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// Whether a line begins a function: `fn` behind nothing but qualifiers.
fn begins_function(line: &str) -> bool {
    let is_qualifier = |word: &str| {
        matches!(word, "pub" | "const" | "async" | "unsafe" | "extern" | "\"C\"")
            || (word.starts_with("pub(") && word.ends_with(')'))
    };
    line.split_whitespace().find(|word| !is_qualifier(word)) == Some("fn")
}

/// First line and number of lines of each function in formatted code, where a function ends with the first brace at its own indent.
fn functions(text: &str) -> Vec<(&str, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let indent = |line: &str| line.len() - line.trim_start().len();
    let length = |start: usize| {
        let is_end = |line: &&str| line.trim_end() == "}" || line.trim_end() == "},";
        let own = indent(lines[start]);
        // A declaration, or a body in one line.
        if lines[start].trim_end().ends_with([';', '}']) {
            return 1;
        }
        let end = lines[start..].iter().position(|line| is_end(&line.trim_start()) && indent(line) == own);
        end.map_or(1, |end| end + 1)
    };
    let starts = (0..lines.len()).filter(|&index| begins_function(lines[index]));
    starts.map(|start| (lines[start].trim(), length(start))).collect()
}

#[test]
fn functions_are_measured_from_signature_to_brace() {
    let text = "impl A {\n    pub(crate) fn one(&self) -> u8 { 1 }\n\n    fn three() {\n        f(|x| {\n        });\n    }\n}\nfn two() {\n}\n// fn none\n";
    let lengths: Vec<usize> = functions(text).into_iter().map(|(_, lines)| lines).collect();
    assert_eq!(lengths, [1, 4, 2]);
}

#[test]
fn files_and_functions_are_short() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut too_long = Vec::new();
    for file in FOLDERS.iter().flat_map(|folder| rust_files(&root.join(folder))) {
        let name = file.strip_prefix(root).unwrap().display();
        let text = std::fs::read_to_string(&file).unwrap();
        let lines = text.lines().count();
        if lines > MAX_FILE_LINES {
            too_long.push(format!("{name}: {lines} lines"));
        }
        let long = functions(&text).into_iter().filter(|(_, lines)| *lines > MAX_FUNCTION_LINES);
        too_long.extend(long.map(|(function, lines)| format!("{name}: {function} has {lines} lines")));
    }
    assert!(
        too_long.is_empty(),
        "over {MAX_FILE_LINES} lines a file or {MAX_FUNCTION_LINES} a function:\n{}",
        too_long.join("\n")
    );
}
