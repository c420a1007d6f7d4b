//! The text that `rayframe test` prints: one line a folder, then the failures, then the commands that follow.

use std::fmt::Write as _;
use std::path::Path;

use crate::progress::one_line;
use rayframe::regression::suite::{folders, is_ci};
use rayframe::regression::{FolderSummary, FrameResult, FrameStatus, ShotResult, SuiteResult};

use super::super::summary::counted;

/// Number of failures of one shot that are printed. The report has all.
const MAX_FAILURES: usize = 3;

/// The whole text. `suite` is the option `--suite` as typed.
pub(super) fn text(result: &SuiteResult, page: &Path, suite: &str, is_quiet: bool) -> String {
    let mut text = String::new();
    if !is_quiet {
        folder_lines(&mut text, &folders(result));
    }
    for shot in result.shots.iter().filter(|shot| !is_quiet && !shot.warnings.is_empty()) {
        let _ = writeln!(text, "warning: {}: {}", one_line(&shot.name), one_line(&shot.warnings.join("; ")));
    }
    for shot in result.shots.iter().filter(|shot| !shot.passes()) {
        failed_shot(&mut text, shot);
    }
    for frame in &result.orphaned {
        failed_frame(&mut text, frame, "");
    }
    let (passed, failed) = result.counts();
    let images = counted((passed + failed) as u64, "image");
    if failed == 0 {
        let outcome = if passed == 1 { "matches its reference" } else { "match their references" };
        let _ = write!(text, "{images} {outcome}, {:.1} s", result.seconds);
        return if is_quiet { String::new() } else { text };
    }
    let _ = writeln!(
        text,
        "{failed} of {images} failed, {:.1} s; report: {}",
        result.seconds,
        one_line(&page.display().to_string())
    );
    let can_accept = |frame: &FrameResult| {
        matches!(frame.status, FrameStatus::Missing | FrameStatus::Different | FrameStatus::Orphaned)
    };
    if is_ci() {
        text.push_str("CI is set: no pending images are stored");
    } else if result.frames().any(can_accept) {
        let _ = write!(
            text,
            "look at the report, then: rayframe review{suite}, or rayframe accept|reject [NAME]{suite}"
        );
    }
    text
}

fn folder_lines(text: &mut String, folders: &[FolderSummary]) {
    let width = folders.iter().map(|folder| shown(folder).chars().count()).max().unwrap_or(0);
    for folder in folders {
        let count = folder.passed + folder.failed;
        let outcome = match folder.failed {
            0 => "ok".to_owned(),
            failed => format!("{failed} failed"),
        };
        let name = shown(folder);
        let _ = writeln!(text, "{name:width$}  {count:>4}  {:>6.1} s  {outcome}", folder.seconds);
    }
}

fn shown(folder: &FolderSummary) -> String {
    if folder.name.is_empty() { ".".to_owned() } else { one_line(&folder.name) }
}

fn failed_shot(text: &mut String, shot: &ShotResult) {
    let failed: Vec<_> = shot.frames.iter().filter(|frame| !frame.passes()).collect();
    let preset = format!(" (preset {})", shot.preset);
    for frame in failed.iter().take(MAX_FAILURES) {
        failed_frame(text, frame, &preset);
    }
    if failed.len() > MAX_FAILURES {
        let _ = writeln!(text, "     {}: {} more", one_line(&shot.name), failed.len() - MAX_FAILURES);
    }
}

fn failed_frame(text: &mut String, frame: &FrameResult, preset: &str) {
    let kind = match frame.status {
        FrameStatus::Passed => return,
        FrameStatus::Different => preset,
        FrameStatus::Missing | FrameStatus::Orphaned | FrameStatus::Broken => "",
    };
    let _ = writeln!(text, "FAIL {}{kind}", one_line(&frame.name));
    for message in &frame.messages {
        let _ = writeln!(text, "     {}", one_line(message));
    }
    if let Some(cause) = frame.likely_cause() {
        let _ = writeln!(text, "     likely {}", one_line(&cause));
    }
}
