//! The text that `rayframe diff` prints.

use std::fmt::Write as _;

use super::super::summary::counted;
use super::args::{DiffArgs, shown};
use super::report::{FrameReport, Report};
use crate::progress::one_line;
use rayframe::regression::{Comparison, FilePair, Mismatch, Verdict, VerdictCounts};

/// Columns of a graph, from low to high.
const COLUMNS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// The whole report, without a line end.
pub(super) fn text(args: &DiffArgs, report: &Report<'_>, is_sequence: bool) -> String {
    let mut text = String::new();
    if is_sequence {
        let _ = writeln!(text, "{}", names(&shown(&args.actual), &shown(&args.reference)));
        table(&mut text, report);
    } else {
        for frame in &report.frames {
            image(&mut text, frame, &report.preset_name);
        }
    }
    text.trim_end().to_owned()
}

/// The outcome, and every measure with its limit.
fn image(text: &mut String, frame: &FrameReport, preset: &str) {
    let names = names(&frame.actual, &frame.reference);
    let outcome = frame.verdict.words();
    if frame.verdict == Verdict::Identical {
        let _ = writeln!(text, "{outcome}: {names}");
        return;
    }
    let _ = writeln!(text, "{outcome} (preset {preset}): {names}");
    details(text, frame);
}

/// Which file is compared with which as the reference.
pub(super) fn names(actual: &str, reference: &str) -> String {
    format!("{} against the reference {}", one_line(actual), one_line(reference))
}

/// Why `--heat-map` and `--flip-map` write nothing for two images.
pub(super) fn no_map(pair: &FilePair, comparison: &Comparison) -> String {
    let is_size = |mismatch: &Mismatch| matches!(mismatch, Mismatch::Size { .. });
    let why = if comparison.mismatches.iter().any(is_size) {
        "their sizes differ"
    } else {
        "they have no colours to compare"
    };
    format!("{} and {}: no map, because {why}", pair.actual.display(), pair.reference.display())
}

pub(super) fn details(text: &mut String, frame: &FrameReport) {
    for (_, channels) in missing_channels([frame]) {
        let _ = writeln!(text, "  FAIL {channels}");
    }
    details_but_channels(text, frame);
}

/// The same without missing channels.
fn details_but_channels(text: &mut String, frame: &FrameReport) {
    for mismatch in frame.comparison.mismatches.iter().filter(|mismatch| !is_channel(mismatch)) {
        let _ = writeln!(text, "  FAIL {}", one_line(&mismatch.to_string()));
    }
    for check in &frame.comparison.checks {
        let mark = if check.passes { "ok  " } else { "FAIL" };
        let _ = writeln!(text, "  {mark} {}", one_line(&check.to_string()));
    }
    if let Some(found) = frame.comparison.root_mean_square {
        let _ = writeln!(text, "       RMSE {:.3e}, PSNR {:.1} dB", found.error, found.peak_ratio_decibels);
    }
    for line in frame.comparison.scene_changes.iter().chain(&frame.comparison.new_content) {
        let _ = writeln!(text, "       {}", one_line(line));
    }
    if let Some(cause) = &frame.comparison.cause {
        let _ = writeln!(text, "  likely {}", one_line(&cause.to_string()));
    }
}

fn is_channel(mismatch: &Mismatch) -> bool {
    matches!(mismatch, Mismatch::Channel { .. })
}

/// Numbers of frames, and the channels that one side lacks in as many frames.
fn missing_channels<'a>(frames: impl IntoIterator<Item = &'a FrameReport>) -> Vec<(usize, String)> {
    let mut channels = Vec::<(&str, bool, usize)>::new();
    for mismatch in frames.into_iter().flat_map(|frame| &frame.comparison.mismatches) {
        let Mismatch::Channel { channel, missing_in_reference } = mismatch else { continue };
        let is_same =
            |(name, side, _): &&mut (&str, bool, usize)| name == channel && side == missing_in_reference;
        match channels.iter_mut().find(is_same) {
            Some((_, _, frames)) => *frames += 1,
            None => channels.push((channel, *missing_in_reference, 1)),
        }
    }
    let mut lines = Vec::<(bool, usize, Vec<&str>)>::new();
    for (name, side, frames) in channels {
        match lines.iter_mut().find(|line| (line.0, line.1) == (side, frames)) {
            Some((_, _, names)) => names.push(name),
            None => lines.push((side, frames, vec![name])),
        }
    }
    let text = |(missing_in_reference, frames, names): (bool, usize, Vec<&str>)| {
        let noun = if names.len() == 1 { "channel" } else { "channels" };
        let names = one_line(&names.join(", "));
        let text = if missing_in_reference {
            format!("has the {noun} {names}, which the reference lacks")
        } else {
            format!("lacks the {noun} {names} of the reference")
        };
        (frames, text)
    };
    lines.into_iter().map(text).collect()
}

/// One line a frame, graphs, missing frames, and the details of failures.
fn table(text: &mut String, report: &Report<'_>) {
    let _ = writeln!(text, " frame  mean FLIP  worst tile  RMSE       result");
    for frame in &report.frames {
        let number = frame.frame.map_or_else(|| "-".to_owned(), |frame| frame.to_string());
        let flip = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.4}"));
        let error = frame
            .comparison
            .root_mean_square
            .map_or_else(|| "-".to_owned(), |found| format!("{:.2e}", found.error));
        let _ = writeln!(
            text,
            "{number:>6}  {:>9}  {:>10}  {error:<9}  {}",
            flip(frame.comparison.flip.map(|flip| flip.mean)),
            flip(frame.comparison.flip.map(|flip| flip.tile)),
            outcome(frame)
        );
    }
    let series = &report.series;
    for line in [graph_line("mean FLIP ", &series.mean_flip), graph_line("worst tile", &series.tile_flip)] {
        let _ = line.map(|line| writeln!(text, "{line}"));
    }
    for (where_not, files) in [
        ("missing in the first", &report.missing_in_actual),
        ("missing in the second", &report.missing_in_reference),
    ] {
        for file in files {
            let _ = writeln!(text, "{where_not}: the frame of {}", one_line(file));
        }
    }
    for (frames, channels) in missing_channels(&report.frames) {
        let _ = writeln!(text, "FAIL {}: {channels}", counted(frames as u64, "frame"));
    }
    // Missing channels are told above.
    let has_more = |frame: &&FrameReport| {
        let comparison = &frame.comparison;
        !comparison.mismatches.iter().all(is_channel) || comparison.checks.iter().any(|check| !check.passes)
    };
    for frame in report.frames.iter().filter(has_more) {
        let _ = writeln!(text, "{}:", names(&frame.actual, &frame.reference));
        details_but_channels(text, frame);
    }
    let lost = report.missing_in_actual.len() + report.missing_in_reference.len();
    let _ = writeln!(text, "{}, {lost} missing", verdicts(report, "frame"));
}

/// The verdict, and how many images have which.
pub(super) fn verdicts(report: &Report<'_>, noun: &str) -> String {
    let counts: VerdictCounts = report.frames.iter().map(|frame| frame.verdict).collect();
    format!(
        "{} (preset {}): {} identical, {} changed within limits, {} failed",
        report.verdict.words(),
        report.preset_name,
        counted(counts.identical as u64, noun),
        counts.changed,
        counts.failed
    )
}

pub(super) fn outcome(frame: &FrameReport) -> String {
    match frame.failures.as_slice() {
        [] => {
            let words = std::iter::once(frame.verdict.words());
            let changes = frame.comparison.scene_changes.iter().map(String::as_str);
            one_line(&words.chain(changes).collect::<Vec<_>>().join("; "))
        }
        [only] => one_line(only),
        [first, rest @ ..] => format!("{} (and {} more)", one_line(first), rest.len()),
    }
}

/// A graph with its name and range; `None` where no frame has a number.
fn graph_line(name: &str, series: &[Option<f64>]) -> Option<String> {
    let largest = series.iter().flatten().copied().reduce(|a, b| if b > a { b } else { a })?;
    Some(format!("{name}  {}  0 to {largest:.4}", graph(series, largest)))
}

/// One column a frame, from 0 to `largest`. A frame without a number is blank.
fn graph(series: &[Option<f64>], largest: f64) -> String {
    let column = |value: &Option<f64>| match value {
        None => ' ',
        Some(value) if largest > 0.0 => {
            let height = (value / largest * (COLUMNS.len() - 1) as f64 + 0.5) as usize;
            COLUMNS[height.min(COLUMNS.len() - 1)]
        }
        Some(_) => COLUMNS[0],
    };
    series.iter().map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_that_is_not_written_has_one_reason() {
        let pair = FilePair { frame: None, actual: "a.exr".into(), reference: "b.exr".into() };
        let mut comparison = Comparison::default();
        let colours = "a.exr and b.exr: no map, because they have no colours to compare";
        assert_eq!(no_map(&pair, &comparison), colours);
        let (actual, reference) = ([(4, 2), (0, 0), (4, 2)], [(2, 2), (0, 0), (2, 2)]);
        comparison.mismatches.push(Mismatch::Size { actual, reference });
        assert_eq!(no_map(&pair, &comparison), "a.exr and b.exr: no map, because their sizes differ");
    }

    #[test]
    fn graphs_reach_from_the_lowest_to_the_highest_column() {
        assert_eq!(graph(&[Some(0.0), Some(0.07), None, Some(0.035)], 0.07), "▁█ ▅");
        assert_eq!(graph(&[Some(0.0)], 0.0), "▁");
    }

    #[test]
    fn frames_that_cannot_be_compared_have_no_graph() {
        assert_eq!(graph_line("mean", &[None, None]), None);
        assert_eq!(graph_line("mean", &[None, Some(0.5)]), Some("mean   █  0 to 0.5000".to_owned()));
        assert_eq!(graph_line("mean", &[Some(0.0)]), Some("mean  ▁  0 to 0.0000".to_owned()));
    }
}
