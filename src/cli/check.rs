//! `rayframe check`: verifies that rendered files are whole, and that a delivery has all of them.

mod checked_file;
mod delivered;
mod listed;
mod verdict;

use std::cell::LazyCell;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use crate::progress::{one_line, print_json, print_output};
use rayframe::error::{Error, Result};
use rayframe::sequence::{ListedFile, canonical};

use super::summary::counted;
use checked_file::{CheckedFile, FileStatus};
use delivered::{DeliveredFile, all_files, each_once, frames};
use listed::Listed;
use verdict::of_file;

/// Options of `rayframe check`.
#[derive(Clone, Debug, Args)]
pub(super) struct CheckArgs {
    /// Files, folders with those below them, or names with ####, %04d or {frame:04}; without any, those of the manifest
    #[arg(value_name = "FILES", required_unless_present = "manifest")]
    files: Vec<PathBuf>,
    /// The manifest of the run: all of its files must be there, with the same bytes, and no others
    #[arg(long, value_name = "FILE")]
    manifest: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Print failures only
    #[arg(short, long)]
    quiet: bool,
}

/// What `--json` prints: `schema/check.schema.json`.
#[derive(Clone, Debug, Serialize)]
struct Report {
    schema: u32,
    whole: usize,
    failed: usize,
    files: Vec<CheckedFile>,
}

/// Verifies and prints. Returns whether all is whole.
pub(super) fn run(args: &CheckArgs) -> Result<bool> {
    let files_of = if args.manifest.is_some() { all_files } else { frames };
    let mut given = Vec::new();
    let mut files = Vec::new();
    for path in &args.files {
        match files_of(path) {
            Ok((found, unreadable)) => {
                given.extend(found);
                for error in unreadable {
                    let folder = if let Error::Missing { path, .. } = &error { path } else { path };
                    let message = message_about(folder, &error);
                    files.push(CheckedFile::new(Some(folder), FileStatus::Missing, message));
                }
            }
            Err(error @ (Error::Missing { .. } | Error::NoImages { .. })) => {
                let message = message_about(path, &error);
                files.push(CheckedFile::new(Some(path), FileStatus::Missing, message));
            }
            Err(error) => return Err(error),
        }
    }
    match &args.manifest {
        None => files.par_extend(each_once(given).par_iter().map(|file| checked(&file.path, None))),
        Some(manifest) => {
            let matched = Listed::read(manifest)?.matched((!args.files.is_empty()).then_some(&*given));
            files.extend(matched.not_rendered);
            files.par_extend(
                matched.files.par_iter().map(|(file, path)| checked_listed(file, path.as_deref())),
            );
            // A file may be found twice: in a folder and by a link to it.
            let paths = matched.files.iter().filter_map(|(_, path)| path.as_deref());
            let paths = paths.chain([manifest.as_path()]);
            let known = LazyCell::new(|| paths.map(canonical).collect::<HashSet<_>>());
            let is_stray =
                |file: &&&DeliveredFile| !file.is_beside_frames() && !known.contains(&canonical(&file.path));
            files.extend(matched.unlisted.iter().filter(is_stray).map(|file| {
                CheckedFile::new(Some(&file.path), FileStatus::Unlisted, "is not in the manifest".to_owned())
            }));
        }
    }
    let failed = files.iter().filter(|file| file.status != FileStatus::Whole).count();
    let report = Report { schema: 1, whole: files.len() - failed, failed, files };
    if args.json {
        let json = serde_json::to_string_pretty(&report);
        print_json(&json.map_err(|error| Error::Internal { message: error.to_string() })?);
        return Ok(failed == 0);
    }
    let text = text(&report, args.quiet);
    if !text.is_empty() {
        print_output(&text);
    }
    Ok(failed == 0)
}

fn checked(path: &Path, listed: Option<&ListedFile>) -> CheckedFile {
    let (status, message) = of_file(path, listed);
    let frame = listed.and_then(|file| file.frame);
    CheckedFile { frame, ..CheckedFile::new(Some(path), status, message) }
}

fn checked_listed(file: &ListedFile, path: Option<&Path>) -> CheckedFile {
    if let Some(path) = path {
        return checked(path, Some(file));
    }
    // Of a delivery that was moved: the file is where the run wrote it.
    let place = if file.path.exists() { "among the named files" } else { "there" };
    let message = format!("is in the manifest and not {place}");
    let missing = CheckedFile::new(Some(&file.path), FileStatus::Missing, message);
    CheckedFile { frame: file.frame, ..missing }
}

/// The message of an error, without the path where it is `named`, which stands before.
fn message_about(named: &Path, error: &Error) -> String {
    match error {
        Error::NoImages { message, .. } => (*message).to_owned(),
        Error::Missing { path, source, .. } if path == named => format!("cannot be read: {source}"),
        other => other.to_string(),
    }
}

/// A line for each failure, and one for all.
fn text(report: &Report, is_quiet: bool) -> String {
    let failures = report.files.iter().filter(|file| file.status != FileStatus::Whole);
    let mut lines: Vec<String> = failures
        .map(|file| {
            let frame = || file.frame.map_or_else(String::new, |frame| format!("frame {frame}"));
            let name = file.path.as_deref().map_or_else(frame, one_line);
            format!("FAIL {name}: {}", one_line(&file.message))
        })
        .collect();
    if !is_quiet {
        let whole = counted(report.whole as u64, "whole file");
        let failed = if report.failed > 0 { format!(", {} failed", report.failed) } else { String::new() };
        lines.push(format!("{whole}{failed}"));
    }
    lines.join("\n")
}
