//! Plain text progress, one line a finished frame, for logs and pipes.

use std::sync::{Mutex, PoisonError};

use rayframe::count_text::plural;
use rayframe::sequence::{FrameReport, SequenceEvent, Summary};

use super::eta::{Eta, duration_text};
use super::reported::ReportedSequence;
use super::{Verbosity, print_error, print_note, print_warning};

/// Plain lines on the standard error stream.
#[derive(Debug)]
pub(super) struct PlainLines {
    verbosity: Verbosity,
    sequence: ReportedSequence,
    eta: Mutex<Eta>,
}

impl PlainLines {
    pub(super) fn new(verbosity: Verbosity, sequence: &ReportedSequence) -> Self {
        Self { verbosity, sequence: sequence.clone(), eta: Mutex::default() }
    }

    pub(super) fn print(&self, event: SequenceEvent<'_>) {
        let mut eta = self.eta.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            SequenceEvent::Started { to_render, kept } => {
                (eta.done, eta.total) = self.sequence.done_and_total(to_render, kept);
                if let Some(text) = kept_text(kept, to_render) {
                    print_note(&text);
                }
            }
            SequenceEvent::ExposureFound { ev, is_automatic: true } => print_note(&exposure_text(ev)),
            SequenceEvent::FrameKept(frame) => {
                eta.frame_kept(frame);
                if self.verbosity.is_verbose {
                    print_note(&format!("frame {} kept {}", frame.frame, frame.path.display()));
                }
            }
            SequenceEvent::FrameWritten(report) => {
                eta.frame_done(report.seconds.period);
                print_note(&written_text(report, &eta));
                if self.verbosity.is_verbose {
                    print_note(&phases_text(report));
                }
            }
            SequenceEvent::FrameFailed(frame, error) => {
                eta.done += 1;
                if self.verbosity.names_failures {
                    print_error(&self.sequence.failure_text(frame, error));
                }
            }
            SequenceEvent::Warned(warning) => print_warning(&warning.to_string()),
            SequenceEvent::Finished(summary) if self.sequence.part().is_none() => {
                print_note(&summary_text(summary, eta.total, &self.sequence));
            }
            _ => {}
        }
    }
}

/// Number of kept frames, printed before the others are rendered.
pub(super) fn kept_text(kept: usize, to_render: usize) -> Option<String> {
    match (kept, to_render) {
        (0, _) | (_, 0) => None,
        (1, _) => Some("1 frame is there already and is kept".to_owned()),
        _ => Some(format!("{kept} frames are there already and are kept")),
    }
}

/// Note of an automatic exposure: `exposure 0.3 stops, chosen automatically (…)`.
pub(super) fn exposure_text(ev: f32) -> String {
    format!("exposure {ev} stops, chosen automatically (--exposure {ev} keeps it)")
}

/// Line of a written frame: `frame 12 (3/240) written out/f.0012.exr 3.2 s, eta 12 min 40 s`.
pub(super) fn written_text(report: &FrameReport, eta: &Eta) -> String {
    let rest = match eta.remaining_seconds() {
        Some(seconds) if eta.done < eta.total => format!(", eta {}", duration_text(seconds)),
        _ => String::new(),
    };
    format!(
        "frame {} ({}/{}) written {} {}{rest}",
        report.frame,
        eta.done,
        eta.total,
        report.path.display(),
        duration_text(report.seconds.period),
    )
}

/// Durations of the phases of a frame, and statistics of its BVH and rays.
pub(super) fn phases_text(report: &FrameReport) -> String {
    let seconds = &report.seconds;
    let milliseconds = [
        ("pose", seconds.pose),
        ("refit", seconds.refit),
        ("bounds", seconds.bounds),
        ("split", seconds.split),
        ("sort", seconds.sort),
        ("tree", seconds.tree),
        ("collapse", seconds.collapse),
        ("wait", seconds.wait),
        ("trace", seconds.trace),
        ("write", seconds.write),
    ]
    .map(|(name, value)| format!("{name} {:.1} ms", value * 1e3))
    .join(", ");
    format!(
        "  {milliseconds}; {} {}: {} triangles, {} references, depth {}; {:.2} million rays/s, {:.1} nodes and {:.1} triangles a ray",
        report.tree.builder,
        report.tree.made,
        report.tree.triangles,
        report.tree.references,
        report.tree.depth,
        report.rays.per_second / 1e6,
        report.rays.nodes_per_ray,
        report.rays.triangles_per_ray,
    )
}

/// `, 3 kept`; nothing without any.
pub(super) fn and_count(count: usize, what: &str) -> String {
    if count == 0 { String::new() } else { format!(", {count} {what}") }
}

/// Last line of a run of `total` frames of `sequence`: `8 frames written to out/demo.####.exr in 24.7 s`.
pub(super) fn summary_text(summary: &Summary, total: usize, sequence: &ReportedSequence) -> String {
    let output = &sequence.output;
    let frames = |count: usize| plural(count as u64, "frame");
    let previews = match summary.previews {
        0 => String::new(),
        1 => ", 1 preview written beside what was kept".to_owned(),
        count => format!(", {count} previews written beside what was kept"),
    };
    if total == 0 && summary.failed.is_empty() && !summary.is_interrupted {
        let kept = match summary.kept.len() {
            1 => "the frame was there already".to_owned(),
            kept => format!("all {kept} frames were there already"),
        };
        return kept + &previews;
    }
    if summary.is_movie && (summary.is_interrupted || !summary.failed.is_empty()) {
        let rendered = summary.written.len();
        let seconds = duration_text(summary.seconds);
        return format!(
            "{rendered} of {total} {} rendered in {seconds}; {output} was not made",
            frames(total)
        );
    }
    let written = match summary.written.len() {
        count if count == total => format!("{count} {}", frames(count)),
        count => format!("{count} of {total} {}", frames(total)),
    };
    let place = match summary.written.as_slice() {
        [] => String::new(),
        [report] => format!(" to {}", report.path.display()),
        _ => format!(" to {output}"),
    };
    let stopped =
        if summary.is_interrupted { format!("; {}", sequence.interruption_text()) } else { String::new() };
    format!(
        "{written} written{place} in {}{}{previews}{}{stopped}",
        duration_text(summary.seconds),
        and_count(summary.kept.len(), "kept"),
        and_count(summary.failed.len(), "failed"),
    )
}

#[cfg(test)]
mod tests {
    use super::super::reported::RunKind;
    use super::*;
    use rayframe::cancel::CancelFlag;

    #[test]
    fn the_last_line_counts_written_kept_and_failed_frames() {
        let text = |summary: &Summary, total, output: &str| {
            let sequence = ReportedSequence { output: output.to_owned(), ..ReportedSequence::default() };
            summary_text(summary, total, &sequence)
        };
        let kept = |kept: &[i64]| Summary { kept: kept.to_vec(), ..Summary::default() };
        assert_eq!(text(&kept(&[1, 2, 3, 4]), 0, "a.#.exr"), "all 4 frames were there already");
        assert_eq!(text(&kept(&[1]), 0, "a.exr"), "the frame was there already");
        let anew = Summary { previews: 2, ..kept(&[1, 2]) };
        let anew = text(&anew, 0, "a.#.exr");
        assert_eq!(anew, "all 2 frames were there already, 2 previews written beside what was kept");
        let stopped = Summary { is_interrupted: true, seconds: 2.0, ..kept(&[1]) };
        let resumable = text(&stopped, 3, "a.#.exr");
        assert!(resumable.starts_with("0 of 3 frames written in 2.0 s, 1 kept; stopped"), "{resumable}");
        let movie = Summary { is_movie: true, ..stopped };
        assert_eq!(text(&movie, 3, "a.mp4"), "0 of 3 frames rendered in 2.0 s; a.mp4 was not made");
    }

    #[test]
    fn a_watch_says_why_an_image_is_unfinished() {
        let end = CancelFlag::new();
        let sequence = ReportedSequence { run: RunKind::Watch(end.clone()), ..ReportedSequence::default() };
        let summary = Summary { is_interrupted: true, seconds: 2.0, ..Summary::default() };
        let text = || summary_text(&summary, 1, &sequence);
        assert_eq!(text(), "0 of 1 frame written in 2.0 s; an input has changed, rendering begins again");
        end.raise();
        assert_eq!(text(), "0 of 1 frame written in 2.0 s; stopped before the end");
    }
}
