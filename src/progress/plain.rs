//! One line a finished frame, for logs and pipes.

use std::sync::{Mutex, PoisonError};

use crate::sequence::{FrameReport, SequenceEvent, Summary};

use super::eta::{Eta, duration_text};
use super::{Verbosity, print_error, print_note, print_warning};

/// Plain lines on the standard error stream.
#[derive(Debug)]
pub(super) struct PlainLines {
    verbosity: Verbosity,
    eta: Mutex<Eta>,
}

impl PlainLines {
    pub(super) fn new(verbosity: Verbosity) -> Self {
        Self { verbosity, eta: Mutex::default() }
    }

    pub(super) fn tell(&self, event: SequenceEvent<'_>) {
        let mut eta = self.eta.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            SequenceEvent::Started { to_render, kept } => {
                eta.total = to_render;
                if kept > 0 {
                    print_note(&kept_text(kept));
                }
            }
            SequenceEvent::ExposureFound(ev) => print_note(&exposure_text(ev)),
            SequenceEvent::FrameKept(frame) if self.verbosity.is_verbose => {
                print_note(&format!("frame {} kept {}", frame.frame, frame.path.display()));
            }
            SequenceEvent::FrameWritten(report) => {
                eta.frame_done(report.seconds.total);
                print_note(&written_text(report, &eta));
                if self.verbosity.is_verbose {
                    print_note(&phases_text(report));
                }
            }
            SequenceEvent::FrameFailed(frame, error) => {
                eta.done += 1;
                if self.verbosity.names_failures {
                    print_error(&format!("frame {}: {error}", frame.frame));
                }
            }
            SequenceEvent::Warned(warning) => print_warning(&warning.to_string()),
            SequenceEvent::Finished(summary) => print_note(&summary_text(summary, eta.total)),
            SequenceEvent::FrameKept(_)
            | SequenceEvent::FrameStarted(_)
            | SequenceEvent::FrameProgress(..) => {}
        }
    }
}

pub(super) fn kept_text(kept: usize) -> String {
    match kept {
        1 => "1 frame is there already and is kept".to_owned(),
        _ => format!("{kept} frames are there already and are kept"),
    }
}

pub(super) fn exposure_text(ev: f32) -> String {
    format!("previews: --exposure {ev}")
}

/// `frame 12 (3/240) written out/f.0012.exr 3.2 s, eta 12 min 40 s`.
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
        duration_text(report.seconds.total),
    )
}

/// Where the time of one frame went.
pub(super) fn phases_text(report: &FrameReport) -> String {
    let seconds = &report.seconds;
    let milliseconds = [
        ("pose", seconds.pose),
        ("split", seconds.split),
        ("sort", seconds.sort),
        ("link", seconds.link),
        ("fit", seconds.fit),
        ("widen", seconds.widen),
        ("trace", seconds.trace),
        ("write", seconds.write),
    ]
    .map(|(name, value)| format!("{name} {:.1} ms", value * 1e3))
    .join(", ");
    format!(
        "  {milliseconds}; {} triangles, {} references, depth {}; {:.2} million rays/s, {:.1} nodes and {:.1} triangles a ray",
        report.tree.triangles,
        report.tree.references,
        report.tree.depth,
        report.rays.per_second / 1e6,
        report.rays.nodes_per_ray,
        report.rays.triangles_per_ray,
    )
}

/// The last line of a run.
pub(super) fn summary_text(summary: &Summary, total: usize) -> String {
    let written = summary.written.len();
    let counted = |count: usize, what: &str| match count {
        0 => String::new(),
        _ => format!(", {count} {what}"),
    };
    let stopped = if summary.is_interrupted {
        "; stopped before the end, the same command with --resume goes on from here"
    } else {
        ""
    };
    format!(
        "{written} of {total} frames written in {}{}{}{stopped}",
        duration_text(summary.seconds),
        counted(summary.kept.len(), "kept"),
        counted(summary.failed.len(), "failed"),
    )
}
