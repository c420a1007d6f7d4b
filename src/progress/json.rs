//! JSON lines on the standard output, one object an event, for render farms and scripts.
//!
//! Every object has `schema` (raised when a field changes its meaning) and `event`. Paths that are not Unicode are also
//! given percent-encoded, without loss, as `path_percent`. `schema/progress.schema.json` describes all lines.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use rayframe::render::PathProgress;
use rayframe::sequence::{FrameProgress, PlannedFrame, SequenceEvent, Summary};

use super::option_names::option_names;
use super::percent_path::add_percent_path;
use super::print::escaped_json;
use super::reported::ReportedSequence;
use super::standard_output::write_lines;

const SCHEMA: u32 = 1;
/// Shortest time between two progress lines of a frame.
const INTERVAL: Duration = Duration::from_millis(500);

/// JSON lines on the standard output.
#[derive(Debug)]
pub(super) struct JsonLines {
    sequence: ReportedSequence,
    last_progress: Mutex<Option<Instant>>,
}

impl JsonLines {
    pub(super) fn new(sequence: &ReportedSequence) -> Self {
        Self { sequence: sequence.clone(), last_progress: Mutex::default() }
    }

    pub(super) fn print(&self, event: SequenceEvent<'_>) {
        if let SequenceEvent::FrameProgress(..) = event
            && !self.is_time_for_progress()
        {
            return;
        }
        if let SequenceEvent::FrameImage(_) = event {
            return;
        }
        let mut line = json_line(event);
        self.sequence.add_to(&mut line);
        print_json(&line);
    }

    fn is_time_for_progress(&self) -> bool {
        // Skipped where it would wait for a lock.
        let Ok(mut last) = self.last_progress.try_lock() else {
            return false;
        };
        let is_time = last.is_none_or(|last| last.elapsed() >= INTERVAL);
        if is_time {
            *last = Some(Instant::now());
        }
        is_time
    }
}

/// Prints an object as a line of the standard output.
pub(super) fn print_json(line: &Value) {
    write_lines(&escaped_json(&line.to_string()));
}

fn json_line(event: SequenceEvent<'_>) -> Value {
    let (name, mut line) = match event {
        SequenceEvent::Started { to_render, kept } => {
            ("start", json!({"to_render": to_render, "kept": kept}))
        }
        SequenceEvent::ExposureFound { ev, is_automatic } => {
            ("exposure", json!({"ev": ev, "automatic": is_automatic}))
        }
        SequenceEvent::FrameKept(frame) => ("frame_skipped", frame_json(frame)),
        SequenceEvent::FrameStarted(frame) => ("frame_start", frame_json(frame)),
        SequenceEvent::FrameProgress(frame, FrameProgress { share, path }) => {
            let mut line = json!({"frame": frame.frame, "share": share});
            if let Some(PathProgress { samples, most_samples, finished_share, noise }) = path {
                line["samples"] = json!(samples);
                line["most_samples"] = json!(most_samples);
                line["finished_share"] = json!(finished_share);
                line["noise"] = json!(noise);
            }
            ("progress", line)
        }
        SequenceEvent::FrameWritten(report) => {
            let mut line = serde_json::to_value(report).unwrap_or_default();
            add_percent_path(&mut line, "path_percent", &report.path);
            ("frame_done", line)
        }
        SequenceEvent::FrameFailed(frame, error) => {
            let mut line = frame_json(frame);
            line["code"] = json!(error.exit_code());
            line["message"] = json!(option_names(&error.to_string()));
            ("frame_failed", line)
        }
        SequenceEvent::Warned(warning) => {
            ("warning", json!({"pointer": warning.pointer, "message": option_names(&warning.message)}))
        }
        SequenceEvent::Finished(summary) => ("summary", summary_json(summary)),
        _ => ("other", json!({})),
    };
    line["schema"] = json!(SCHEMA);
    line["event"] = json!(name);
    line
}

fn frame_json(frame: &PlannedFrame) -> Value {
    let mut line = json!({
        "frame": frame.frame,
        "time_seconds": frame.time_seconds,
        "path": frame.path.to_string_lossy(),
    });
    add_percent_path(&mut line, "path_percent", &frame.path);
    line
}

fn summary_json(summary: &Summary) -> Value {
    let failed: Vec<_> = summary
        .failed
        .iter()
        .map(|failed| json!({"frame": failed.frame, "code": failed.error.exit_code()}))
        .collect();
    json!({
        "written": summary.written.iter().map(|report| report.frame).collect::<Vec<_>>(),
        "kept": summary.kept,
        "failed": failed,
        "interrupted": summary.is_interrupted,
        "seconds": summary.seconds,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayframe::error::{Error, Warning};
    use rayframe::shot::SequenceNames;
    use std::path::PathBuf;

    fn planned(path: PathBuf) -> PlannedFrame {
        PlannedFrame {
            frame: 7,
            time_seconds: 0.0,
            path,
            aov_paths: Vec::new(),
            preview_path: None,
            render_hash: String::new(),
            is_done: false,
        }
    }

    #[test]
    fn every_line_names_schema_and_event() {
        let line = json_line(SequenceEvent::Started { to_render: 3, kept: 1 });
        assert_eq!(line.to_string(), r#"{"event":"start","kept":1,"schema":1,"to_render":3}"#);
        let line = json_line(SequenceEvent::Finished(&Summary::default()));
        assert_eq!(line["event"], "summary");
        assert_eq!(line["interrupted"], false);
    }

    #[test]
    fn progress_names_its_frame() {
        let frame = planned("a.exr".into());
        let line = json_line(SequenceEvent::FrameProgress(&frame, FrameProgress { share: 0.5, path: None }));
        assert_eq!(line.to_string(), r#"{"event":"progress","frame":7,"schema":1,"share":0.5}"#);
    }

    #[test]
    fn every_line_names_its_sequence() {
        let sequence = ReportedSequence {
            scene: "a.glb".into(),
            names: SequenceNames { clip: Some("walk".to_owned()), ..SequenceNames::default() },
            ..ReportedSequence::default()
        };
        let mut line = json_line(SequenceEvent::Finished(&Summary::default()));
        sequence.add_to(&mut line);
        assert_eq!(
            (&line["scene"], &line["clip"], &line["camera"]),
            (&json!("a.glb"), &json!("walk"), &Value::Null)
        );
    }

    #[test]
    fn messages_name_options() {
        let warning = Warning::of_file("raise `depth`");
        assert_eq!(json_line(SequenceEvent::Warned(&warning))["message"], "raise --depth");
        let error = Error::Temporary { message: "lower `threads`".to_owned() };
        let line = json_line(SequenceEvent::FrameFailed(&planned("a.exr".into()), &error));
        assert_eq!(line["message"], "lower --threads");
    }

    #[cfg(unix)]
    #[test]
    fn paths_that_are_not_unicode_are_percent_encoded() {
        use std::os::unix::ffi::OsStrExt as _;
        let frame = planned(std::ffi::OsStr::from_bytes(b"a\xff").into());
        assert_eq!(json_line(SequenceEvent::FrameStarted(&frame))["path_percent"], "a%FF");
    }
}
