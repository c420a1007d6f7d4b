//! Rules about the source files themselves: no import cycles, no file over 400 lines, no function over 70.

#![expect(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

mod imports;
mod sizes;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Path of a module from the crate's root: `["render", "tile"]`.
type ModulePath = Vec<String>;

/// The Rust files below `folder`, sorted.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
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

fn parsed(file: &Path) -> syn::File {
    let text = std::fs::read_to_string(file).unwrap();
    syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// The modules of the crate whose root file is `root`, without test modules.
fn modules(folder: &Path, root: &str) -> BTreeMap<ModulePath, PathBuf> {
    let mut modules = BTreeMap::new();
    for file in rust_files(folder) {
        let relative = file.strip_prefix(folder).unwrap().with_extension("");
        let mut path: ModulePath = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        if path.iter().any(|part| part == "tests") {
            continue;
        }
        match path.last().map(String::as_str) {
            Some("mod") => drop(path.pop()),
            Some("lib" | "main") if path.len() == 1 => {
                if relative != Path::new(root) {
                    continue;
                }
                path.clear();
            }
            _ => {}
        }
        modules.insert(path, file);
    }
    modules
}
