//! The output of a dry run: the settings as a shot file and the frames, or both as JSON.

use serde_json::{Value, json};

use crate::progress::one_line;
use rayframe::output::SOFTWARE;
use rayframe::regression::suite::shell_quoted;
use rayframe::sequence::{Plan, PlannedFrame};
use rayframe::settings::Settings;
use rayframe::shot::{RenderJob, SequenceOutline};

/// Raised when a field changes its meaning.
const SCHEMA: u32 = 1;

/// A shot file that makes the same frames from any folder. The frames of each sequence follow as comments. Shot files name no programs, so
/// that `oidn` is left out with a comment.
pub(super) fn plan_text(settings: &Settings, sequences: &[(&RenderJob, &Plan)]) -> String {
    let mut file_settings = settings.clone();
    file_settings.clear("oidn");
    let mut lines = vec![format!("# {SOFTWARE}"), file_settings.to_toml()];
    lines.extend(settings.values().oidn.map(|program| {
        let option = shell_quoted(&program.to_string_lossy());
        format!("\n# Shot files name no programs: render this one with --oidn {}", one_line(&option))
    }));
    lines.push("\n# Frames and their present state".to_owned());
    for (job, plan) in sequences {
        let label = Some(job.outline.label()).filter(|label| !label.is_empty());
        lines.extend(label.map(|label| format!("# {}", one_line(&label))));
        let bands = |rows: u32| format!(" in bands of {rows} rows");
        lines.extend(plan.frames.iter().map(|frame| {
            let bands = band_rows(plan, frame).map(bands).unwrap_or_default();
            format!("# {}{bands}", one_line(&frame_text(frame)))
        }));
    }
    lines.join("\n")
}

/// The same as one JSON object.
pub(super) fn plan_json(settings: &Settings, sequences: &[(&RenderJob, &Plan)]) -> String {
    let mut frames = Vec::new();
    for (job, plan) in sequences {
        frames.extend(plan.frames.iter().map(|frame| frame_json(&job.outline, plan, frame)));
    }
    let scene = sequences.first().map(|(job, _)| job.sequence.scene.path.to_string_lossy());
    json!({
        "schema": SCHEMA,
        "event": "plan",
        "scene": scene,
        "settings": settings.to_json(),
        "frames": frames,
    })
    .to_string()
}

fn frame_json(outline: &SequenceOutline, plan: &Plan, frame: &PlannedFrame) -> Value {
    let mut line = json!({
        "frame": frame.frame,
        "time_seconds": frame.time_seconds,
        "action": action(frame),
        "path": frame.path.to_string_lossy(),
        "render_hash": frame.render_hash,
    });
    for (what, name) in outline.names.entries() {
        line[what.key()] = json!(name);
    }
    if let Some(rows) = band_rows(plan, frame) {
        line["band_rows"] = json!(rows);
    }
    line
}

/// Rows of the bands of a frame that is rendered in bands.
fn band_rows(plan: &Plan, frame: &PlannedFrame) -> Option<u32> {
    plan.band_rows.filter(|_| !frame.is_done)
}

fn frame_text(frame: &PlannedFrame) -> String {
    format!("frame {} at {:.4} s {} {}", frame.frame, frame.time_seconds, action(frame), frame.path.display())
}

fn action(frame: &PlannedFrame) -> &'static str {
    if frame.is_done { "keep" } else { "render" }
}
