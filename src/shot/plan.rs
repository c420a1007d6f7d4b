//! What a dry run prints: the settings as a shot file, then the frames; or both as JSON.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::parser::ValueSource;
use clap::{Arg, Command};
use serde_json::json;
use toml::de::DeValue;

use super::one_line;
use crate::output::SOFTWARE;
use crate::scene::SelectedCamera;
use crate::sequence::{OutputPattern, Plan, PlannedFrame, SequenceJob};

use super::environment::has_lights;
use super::form::{Form, Single};
use super::setting::{Origin, Setting, Value, is_setting, rebased};
use super::{MeantOptions, options, parse};
use crate::sequence::frames_text;

/// Raised when a field changes its meaning.
const SCHEMA: u32 = 1;

/// A shot file that makes the same frames wherever it lies, with the plan as comments at its end.
pub fn plan_text(meant: &MeantOptions, job: &SequenceJob, plan: &Plan) -> String {
    let command = options();
    let mut lines = vec![format!("# {SOFTWARE}")];
    let mut heading = None;
    for (arg, value) in resolved(&command, meant, job) {
        if heading != Some(arg.get_help_heading()) {
            heading = Some(arg.get_help_heading());
            lines.extend(arg.get_help_heading().map(|heading| format!("\n# {heading}")));
        }
        lines.push(setting_line(arg, &value));
    }
    lines.push("\n# Frames, as far as they are there now".to_owned());
    lines.extend(plan.frames.iter().map(|frame| format!("# {}", one_line(&frame_text(frame)))));
    lines.join("\n")
}

/// The same as one JSON object.
pub fn plan_json(meant: &MeantOptions, job: &SequenceJob, plan: &Plan) -> String {
    let command = options();
    let settings: serde_json::Map<String, serde_json::Value> = resolved(&command, meant, job)
        .into_iter()
        .map(|(arg, value)| (arg.get_id().to_string(), json_value(arg, &value)))
        .collect();
    let frames: Vec<_> = plan
        .frames
        .iter()
        .map(|frame| {
            json!({
                "frame": frame.frame,
                "time_seconds": frame.time_seconds,
                "action": action(frame),
                "path": frame.path.to_string_lossy(),
            })
        })
        .collect();
    json!({ "schema": SCHEMA, "event": "plan", "settings": settings, "frames": frames }).to_string()
}

fn frame_text(frame: &PlannedFrame) -> String {
    format!("frame {} at {:.4} s {} {}", frame.frame, frame.time_seconds, action(frame), frame.path.display())
}

fn action(frame: &PlannedFrame) -> &'static str {
    if frame.is_done { "keep" } else { "render" }
}

/// Every setting that has a value, with what follows from the scene in its place.
fn resolved<'a>(command: &'a Command, meant: &MeantOptions, job: &SequenceJob) -> Vec<(&'a Arg, Value)> {
    let folder = std::env::current_dir().unwrap_or_default();
    let mut from_job = from_job(meant, job);
    let mut settings = Vec::new();
    for arg in command.get_arguments().filter(|arg| is_setting(arg)) {
        let value = match from_job.remove(arg.get_id().as_str()) {
            Some(value) => value,
            None => as_parsed(command, meant, arg),
        };
        match value {
            Some(Value::Texts(texts)) => {
                let texts = texts.into_iter().map(|text| rebased(arg, &folder, text));
                settings.push((arg, Value::Texts(texts.collect())));
            }
            Some(Value::Flag(true)) => settings.push((arg, Value::Flag(true))),
            Some(Value::Flag(false)) | None => {}
        }
    }
    settings
}

/// The settings that the scene or other settings decide; `None` for those that others stand for.
fn from_job(meant: &MeantOptions, job: &SequenceJob) -> BTreeMap<&'static str, Option<Value>> {
    let text = |text: OsString| Some(Value::Texts(vec![text]));
    let frames = frames_text(&job.frames);
    let (width, height) = job.render.resolution;
    let mut settings = BTreeMap::from([
        ("frames", text(frames.trim_start_matches("frames ").trim_start_matches("frame ").into())),
        ("resolution", text(format!("{width}x{height}").into())),
    ]);
    for replaced in ["all", "start", "end", "step", "width", "height", "scale"] {
        settings.insert(replaced, None);
    }
    if meant.args.output.is_none() {
        let stem = meant.args.scene.file_stem().unwrap_or(OsStr::new("frame"));
        let mut output = OutputPattern::escaped(Path::new(stem));
        output.push(if job.output.is_numbered() { ".####.exr" } else { ".exr" });
        settings.insert("output", text(output));
    }
    if meant.args.camera.is_none() {
        settings.insert("camera", text(camera(job).into()));
    }
    if meant.args.env.is_none() && job.selection.image_light.is_none() {
        let env = if has_lights(&job.scene, &job.selection) { "none" } else { "studio" };
        settings.insert("env", text(env.into()));
    }
    settings
}

/// The camera that stands for no choice: the first that is placed.
fn camera(job: &SequenceJob) -> String {
    let SelectedCamera::Node(node) = job.selection.camera else {
        return "auto".to_owned();
    };
    let camera = job.scene.nodes.get(node.index()).and_then(|node| node.camera);
    camera.map_or_else(|| "auto".to_owned(), |camera| format!("#{}", camera.index()))
}

/// The value of an option, its default included unless it would be refused beside the others.
fn as_parsed(command: &Command, meant: &MeantOptions, arg: &Arg) -> Option<Value> {
    let key = arg.get_id().as_str();
    let is_default = meant.matches.value_source(key)? == ValueSource::DefaultValue;
    if !arg.get_action().takes_values() {
        return Some(Value::Flag(!is_default));
    }
    let texts: Vec<OsString> = meant.matches.get_raw(key)?.map(OsStr::to_owned).collect();
    let value = Value::Texts(texts);
    if is_default {
        let own = Setting { key: key.to_owned(), value: value.clone(), origin: Origin::Typed };
        let others = meant.settings.iter().filter(|setting| setting.key != key);
        parse(command, others.chain([&own])).ok()?;
    }
    Some(value)
}

fn setting_line(arg: &Arg, value: &Value) -> String {
    let key = arg.get_id();
    let form = Form::of(arg);
    match value {
        Value::Flag(flag) => format!("{key} = {flag}"),
        Value::Texts(texts) => match texts.iter().map(|text| text.to_str()).collect::<Option<Vec<_>>>() {
            None => format!("# {key} cannot be written here, for it is not Unicode"),
            Some(texts) if form.is_repeated => {
                let texts: Vec<_> = texts.into_iter().map(quoted).collect();
                format!("{key} = [{}]", texts.join(", "))
            }
            Some(texts) => {
                let text = texts.last().copied().unwrap_or_default();
                format!("{key} = {}", number(form, text).unwrap_or_else(|| quoted(text)))
            }
        },
    }
}

fn json_value(arg: &Arg, value: &Value) -> serde_json::Value {
    let form = Form::of(arg);
    let Value::Texts(texts) = value else {
        return json!(matches!(value, Value::Flag(true)));
    };
    let mut texts = texts.iter().map(|text| text.to_string_lossy());
    if form.is_repeated {
        return json!(texts.collect::<Vec<_>>());
    }
    let text = texts.next_back().unwrap_or_default();
    // What may also be said in letters is always a text, so that a setting has one type.
    let number = number(form, &text).filter(|_| form.single == Single::Number);
    number.and_then(|number| serde_json::from_str(&number).ok()).unwrap_or_else(|| json!(text))
}

/// The text as a number of TOML and JSON, where it is one and may be.
fn number(form: Form, text: &str) -> Option<String> {
    let value = text.parse::<f64>().ok().filter(|value| form.takes_number() && value.is_finite())?;
    // Both languages want digits on either side of the point, and no plus or zeros in front.
    let is_number = |text: &str| {
        DeValue::parse(text).is_ok_and(|value| value.get_ref().is_integer() || value.get_ref().is_float())
            && serde_json::from_str::<serde_json::Number>(text).is_ok()
    };
    let same = |number: &String| number.parse::<f64>().is_ok_and(|same| same == value);
    [text.to_owned(), format!("{value}"), format!("{value:?}")]
        .into_iter()
        .find(|number| is_number(number) && same(number))
}

/// A basic string of TOML.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.extend(format!("\\u{:04X}", u32::from(c)).chars()),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::super::setting::arg_of;
    use super::*;

    #[test]
    fn numbers_stay_as_they_were_typed_where_they_can() {
        let options = options();
        let form = |key: &str| Form::of(arg_of(&options, key).unwrap());
        for (typed, printed) in [
            ("4", "4"),
            ("+4", "4"),
            ("007", "7"),
            (".5", "0.5"),
            ("5.", "5"),
            ("0.10", "0.10"),
            ("1e3", "1e3"),
        ] {
            assert_eq!(number(form("samples"), typed).as_deref(), Some(printed), "{typed}");
        }
        assert_eq!(number(form("exposure"), "-1.5").as_deref(), Some("-1.5"));
        assert_eq!((number(form("exposure"), "auto"), number(form("camera"), "1")), (None, None));
    }

    #[test]
    fn texts_are_read_as_they_were_written() {
        for text in ["", "a\"b\\c", "\u{1}\u{7f}\u{85}\n\t", "'''", "#0 → é"] {
            let line = quoted(text);
            let read = DeValue::parse(&line).unwrap();
            assert_eq!(read.get_ref().as_str(), Some(text), "{line}");
        }
    }
}
