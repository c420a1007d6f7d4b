//! The output of a dry run: the settings as a shot file and the frames, or both as JSON.

use serde_json::json;

use crate::progress::one_line;
use rayframe::output::SOFTWARE;
use rayframe::sequence::{Plan, PlannedFrame};
use rayframe::settings::Settings;

/// Raised when a field changes its meaning.
const SCHEMA: u32 = 1;

/// A shot file that makes the same frames from any folder. The frames follow as comments.
pub(super) fn plan_text(settings: &Settings, plan: &Plan) -> String {
    let mut lines = vec![format!("# {SOFTWARE}"), settings.to_toml()];
    lines.push("\n# Frames and their present state".to_owned());
    lines.extend(plan.frames.iter().map(|frame| format!("# {}", one_line(&frame_text(frame)))));
    lines.join("\n")
}

/// The same as one JSON object.
pub(super) fn plan_json(settings: &Settings, plan: &Plan) -> String {
    let frames = plan.frames.iter().map(|frame| {
        json!({
            "frame": frame.frame,
            "time_seconds": frame.time_seconds,
            "action": action(frame),
            "path": frame.path.to_string_lossy(),
        })
    });
    let frames: Vec<_> = frames.collect();
    json!({ "schema": SCHEMA, "event": "plan", "settings": settings.to_json(), "frames": frames }).to_string()
}

fn frame_text(frame: &PlannedFrame) -> String {
    format!("frame {} at {:.4} s {} {}", frame.frame, frame.time_seconds, action(frame), frame.path.display())
}

fn action(frame: &PlannedFrame) -> &'static str {
    if frame.is_done { "keep" } else { "render" }
}
