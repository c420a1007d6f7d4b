//! The text that `rayframe test` prints: one line a folder, one line a changed image, the failures, the counts, and the commands that
//! follow.

use std::fmt::Write as _;
use std::path::Path;

use crate::progress::one_line;
use rayframe::regression::suite::{folders, is_ci, refers_to_another_image};
use rayframe::regression::{
    FailOn, FolderSummary, FrameResult, FrameStatus, ShotResult, SuiteResult, Verdict, VerdictCounts,
};

use super::super::summary::counted;

/// Number of failures of one shot that are printed. The report has all.
const MAX_FAILURES: usize = 3;

/// What the text shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct TextStyle {
    /// Failures only.
    pub(super) is_quiet: bool,
    /// Verdicts that make the command fail.
    pub(super) fail_on: FailOn,
    /// Number of slowest shots that are listed.
    pub(super) slowest: usize,
}

/// The whole text. `suite` are the options that name the suite, as typed.
pub(super) fn text(result: &SuiteResult, page: &Path, suite: &str, style: TextStyle) -> String {
    let mut text = String::new();
    if !style.is_quiet {
        before_failures(&mut text, result);
        slowest_shots(&mut text, result, style.slowest);
    }
    for shot in &result.shots {
        failed_shot(&mut text, shot, style.fail_on);
    }
    for frame in &result.orphaned {
        failed_frame(&mut text, frame, "");
    }
    let fails = result.fails(style.fail_on);
    if style.is_quiet && !fails {
        return String::new();
    }
    let counts = result.counts();
    let _ = write!(
        text,
        "{} identical, {} changed within limits, {} failed, {:.1} s",
        counted(counts.identical as u64, "image"),
        counts.changed,
        counts.failed,
        result.seconds
    );
    let cached = result.shots.iter().filter(|shot| shot.is_cached).count();
    if cached > 0 {
        let _ = write!(text, "; {} not rendered, as nothing changed", counted(cached as u64, "shot"));
    }
    if !result.not_tested.is_empty() {
        let shots = counted(result.not_tested.len() as u64, "shot");
        let _ = write!(text, "; {shots} not tested, as none of their files changed");
    }
    if counts.worst() != Verdict::Identical {
        let _ = write!(text, "; report: {}", one_line(&page.display().to_string()));
        next_steps(&mut text, result, suite);
    }
    text
}

/// The folders, warnings, and images that changed within the limits.
fn before_failures(text: &mut String, result: &SuiteResult) {
    folder_lines(text, &folders(result));
    for shot in result.shots.iter().filter(|shot| !shot.warnings.is_empty()) {
        let _ = writeln!(text, "warning: {}: {}", one_line(&shot.name), one_line(&shot.warnings.join("; ")));
    }
    for shot in &result.shots {
        for frame in shot.frames.iter().filter(|frame| frame.verdict() == Verdict::Changed) {
            let measure = frame.messages.first().map(String::as_str).unwrap_or_default();
            let _ = writeln!(
                text,
                "changed {} (preset {}): {}",
                one_line(&frame.name),
                shot.preset,
                one_line(measure)
            );
        }
    }
}

fn slowest_shots(text: &mut String, result: &SuiteResult, count: usize) {
    let mut shots: Vec<&ShotResult> = result.shots.iter().collect();
    shots.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    for shot in shots.into_iter().take(count) {
        let _ = writeln!(text, "{:>7.2} s  {}", shot.seconds, one_line(&shot.name));
    }
}

/// The commands that accept or reject what was found.
fn next_steps(text: &mut String, result: &SuiteResult, suite: &str) {
    let can_accept = |frame: &FrameResult| {
        matches!(frame.status, FrameStatus::Missing | FrameStatus::Different | FrameStatus::Orphaned)
    };
    if is_ci() {
        let _ = write!(
            text,
            "\nCI is set: no pending images are stored; keep the folder of the report, then: rayframe accept --from DIR{suite}"
        );
    } else if result.frames().any(can_accept) {
        let _ = write!(
            text,
            "\nlook at the report, then: rayframe review{suite}, or rayframe accept|reject [NAME]{suite}"
        );
    } else if result.counts().changed > 0 {
        let _ = write!(
            text,
            "\nlook at the report, then: rayframe review{suite}, or rayframe accept --changed{suite}"
        );
    }
}

fn folder_lines(text: &mut String, folders: &[FolderSummary]) {
    let width = folders.iter().map(|folder| shown(folder).chars().count()).max().unwrap_or(0);
    for folder in folders {
        let VerdictCounts { changed, failed, .. } = folder.counts;
        let parts = [(failed, "failed"), (changed, "changed")].into_iter().filter(|(count, _)| *count > 0);
        let parts: Vec<String> = parts.map(|(count, word)| format!("{count} {word}")).collect();
        let outcome = if parts.is_empty() { "ok".to_owned() } else { parts.join(", ") };
        let (name, count) = (shown(folder), folder.counts.total());
        let _ = writeln!(text, "{name:width$}  {count:>4}  {:>6.1} s  {outcome}", folder.seconds);
    }
}

fn shown(folder: &FolderSummary) -> String {
    if folder.name.is_empty() { ".".to_owned() } else { one_line(&folder.name) }
}

fn failed_shot(text: &mut String, shot: &ShotResult, fail_on: FailOn) {
    let mut failed: Vec<_> = shot.frames.iter().filter(|frame| fail_on.fails(frame.verdict())).collect();
    // Those that were compared tell more, and those that refer to another image tell least.
    failed.sort_by_key(|frame| {
        (refers_to_another_image(&frame.messages), frame.status == FrameStatus::Missing)
    });
    let preset = format!(" (preset {})", shot.preset);
    for frame in failed.iter().take(MAX_FAILURES) {
        failed_frame(text, frame, &preset);
    }
    if failed.len() > MAX_FAILURES {
        let _ = writeln!(text, "     {}: {} more", one_line(&shot.name), failed.len() - MAX_FAILURES);
    }
}

fn failed_frame(text: &mut String, frame: &FrameResult, preset: &str) {
    let preset = if frame.comparison.is_some() { preset } else { "" };
    let _ = writeln!(text, "FAIL {}{preset}", one_line(&frame.name));
    for message in &frame.messages {
        let _ = writeln!(text, "     {}", one_line(message));
    }
    if let Some(cause) = frame.likely_cause() {
        let _ = writeln!(text, "     likely {}", one_line(&cause));
    }
}
