//! What `rayframe test` prints for people: a line a folder, then what is wrong, then what to do about it.

use std::fmt::Write as _;
use std::path::Path;

use crate::progress::one_line;
use crate::regression::suite::{ShotResult, SuiteResult, folders, is_ci};
use crate::regression::{FolderSummary, FrameStatus, ReportedFrame};

use super::super::understood::counted;

/// Failures of one shot that are printed; the report has all.
const MOST_FRAMES: usize = 3;

/// The whole text. `suite` is the option that names it, as typed.
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
    for picture in &result.orphaned {
        failed_frame(&mut text, picture, "");
    }
    let (passed, failed) = result.counts();
    let pictures = counted((passed + failed) as u64, "picture");
    if failed == 0 {
        let _ = write!(text, "{pictures} as their references, {:.1} s", result.seconds);
        return if is_quiet { String::new() } else { text };
    }
    let _ = writeln!(
        text,
        "{failed} of {pictures} failed, {:.1} s; report: {}",
        result.seconds,
        one_line(&page.display().to_string())
    );
    let can_accept = |picture: &ReportedFrame| {
        matches!(picture.status, FrameStatus::Missing | FrameStatus::Different | FrameStatus::Orphaned)
    };
    if is_ci() {
        text.push_str("CI is set: nothing is kept to be accepted here");
    } else if result.pictures().any(can_accept) {
        let _ = write!(text, "look, then: rayframe review{suite}, or rayframe accept|reject [NAME]{suite}");
    }
    text
}

fn folder_lines(text: &mut String, folders: &[FolderSummary]) {
    let width = folders.iter().map(|folder| shown(folder).chars().count()).max().unwrap_or(0);
    for folder in folders {
        let count = folder.passed + folder.failed;
        let verdict = match folder.failed {
            0 => "ok".to_owned(),
            failed => format!("{failed} failed"),
        };
        let name = shown(folder);
        let _ = writeln!(text, "{name:width$}  {count:>4}  {:>6.1} s  {verdict}", folder.seconds);
    }
}

fn shown(folder: &FolderSummary) -> String {
    if folder.name.is_empty() { ".".to_owned() } else { one_line(&folder.name) }
}

fn failed_shot(text: &mut String, shot: &ShotResult) {
    let failed: Vec<_> =
        shot.pictures.iter().filter(|picture| picture.status != FrameStatus::Passed).collect();
    let preset = format!(" (preset {})", shot.preset);
    for picture in failed.iter().take(MOST_FRAMES) {
        failed_frame(text, picture, &preset);
    }
    if failed.len() > MOST_FRAMES {
        let _ = writeln!(text, "     {}: {} more", one_line(&shot.name), failed.len() - MOST_FRAMES);
    }
}

fn failed_frame(text: &mut String, picture: &ReportedFrame, preset: &str) {
    let kind = match picture.status {
        FrameStatus::Passed => return,
        FrameStatus::Different => preset,
        FrameStatus::Missing | FrameStatus::Orphaned | FrameStatus::Broken => "",
    };
    let _ = writeln!(text, "FAIL {}{kind}", one_line(&picture.name));
    for message in &picture.messages {
        let _ = writeln!(text, "     {}", one_line(message));
    }
    if let Some(cause) = picture.comparison.as_ref().and_then(|comparison| comparison.cause.as_ref()) {
        let _ = writeln!(text, "     likely {}", one_line(&cause.to_string()));
    }
}
