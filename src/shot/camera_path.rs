//! Camera paths: keys in a TOML file, or an animated camera of a glTF file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::de::DeValue;

use crate::error::{Error, Result, SettingError, Warning};
use crate::gltf::{self, ImportOptions};
use crate::scene::{
    AnimationIndex, AnimationTarget, CameraKeys, CameraMotion, CameraPath, CameraRequest, Channel, CurveKind,
    KeyTimes, KeyedPoint, KeyedValue, NodeIndex, Scene, SelectedCamera, Selection, SelectionRequest,
};
use crate::settings::{CameraPathSource, TomlEntry, TomlFile, entries, number, read_text};

/// Largest time of a key.
const MAX_SECONDS: f64 = 1e6;
/// Keys of the file.
const FILE_KEYS: [&str; 3] = ["interpolation", "loop", "key"];
/// Keys of one key of the path.
const KEY_KEYS: [&str; 5] = ["time", "position", "look_at", "fov", "roll"];

/// A path and the files that it was read from.
#[derive(Debug)]
pub(super) struct LoadedPath {
    pub(super) path: CameraPath,
    pub(super) files: Vec<PathBuf>,
    /// Notes about what of the file is not used.
    pub(super) choices: Vec<Warning>,
}

/// Reads the path that `source` names, a scene file with `options`.
///
/// # Errors
/// Those of reading the file; of keys with line and column.
pub(super) fn load(source: &CameraPathSource, options: &ImportOptions) -> Result<LoadedPath> {
    if source.is_keys() {
        let text = read_text(&source.file)?;
        let path = read_keys(&TomlFile { path: &source.file, text: &text })?;
        return Ok(LoadedPath { path, files: vec![source.file.clone()], choices: Vec::new() });
    }
    let scene = Arc::new(gltf::import(&source.file, options)?);
    let request = SelectionRequest {
        camera: source.camera.clone().map(CameraRequest::Camera),
        ..SelectionRequest::default()
    };
    let of_path = |why: &str| Error::setting("camera_path", format!("{}: {why}", source.file.display()));
    let (selection, warnings) = Selection::resolve(&request, &scene).map_err(|error| match error {
        Error::Setting(SettingError { why, .. }) => of_path(&why),
        error => error,
    })?;
    let SelectedCamera::Node(node) = selection.camera else {
        return Err(of_path("the file has no camera; name one that has, or a .toml file of keys"));
    };
    let is_ambiguous = warnings.iter().any(|warning| warning.pointer.starts_with("/cameras/"));
    let same_name = is_ambiguous.then(|| {
        let (file, camera) = (file_name(&source.file), selection.camera_name(&scene).unwrap_or_default());
        Warning::of_file(format!(
            "`camera_path` {file}: several cameras are called \"{}\", and the first one is used; '{file}#0' selects one by its index",
            camera.escape_debug()
        ))
    });
    let choices = same_name.into_iter().chain(left_out_clips(source, &scene, &selection, node)).collect();
    let clips: Vec<_> = selection.clips.iter().map(|clip| clip.0).collect();
    let mut files = vec![source.file.clone()];
    files.extend(scene.files.iter().cloned());
    let path = CameraPath {
        content_key: format!("scene {:x?} {} {clips:?}", scene.content_hash, node.0),
        label: format!("{} {}", file_name(&source.file), selection.camera_label(&scene)),
        duration_seconds: f64::from(selection.duration_seconds(&scene)),
        is_loop: false,
        motion: CameraMotion::Scene { clips: selection.clips, node, scene },
    };
    Ok(LoadedPath { path, files, choices })
}

/// The note about clips that move the camera and do not play, since earlier ones animate the same; `None` without such clips.
fn left_out_clips(
    source: &CameraPathSource,
    scene: &Scene,
    selection: &Selection,
    node: NodeIndex,
) -> Option<Warning> {
    let parent = |node: &NodeIndex| scene.nodes.get(node.index())?.parent;
    let moving: BTreeSet<NodeIndex> = std::iter::successors(Some(node), parent).collect();
    let camera = scene.nodes.get(node.index()).and_then(|node| node.camera);
    let moves = |channel: &Channel| match channel.target {
        AnimationTarget::Camera(of, _) => Some(of) == camera,
        target => target.node().is_some_and(|node| moving.contains(&node)),
    };
    let clips = scene.animations.iter().enumerate();
    let mut left_out = clips.filter(|(index, clip)| {
        !selection.clips.contains(&AnimationIndex::of(*index)) && clip.channels.iter().any(moves)
    });
    let (index, clip) = left_out.next()?;
    let name = clip.name.as_ref().map_or_else(String::new, |name| format!(" \"{}\"", name.escape_debug()));
    let others = match left_out.count() {
        0 => String::new(),
        others => format!(" and {others} more"),
    };
    let file = file_name(&source.file);
    Some(Warning::of_file(format!(
        "`camera_path` {file}: all clips of the file play together without #{index}{name}{others}, since earlier ones animate the same"
    )))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).display().to_string()
}

/// One key as it stands in the file.
struct Key {
    /// Byte of the key in the text.
    at: usize,
    time: f64,
    position: [f64; 3],
    target: [f64; 3],
    roll: Option<f64>,
    fov: Option<f64>,
}

/// The path of a file of keys.
fn read_keys(file: &TomlFile<'_>) -> Result<CameraPath> {
    let table = file.table()?;
    let (mut kind, mut is_loop, mut keys) = (CurveKind::default(), false, Vec::new());
    for entry in entries(&table) {
        match (entry.key, entry.value) {
            ("interpolation", value) => {
                kind = match value.as_str() {
                    Some("smooth") => CurveKind::Smooth,
                    Some("linear") => CurveKind::Linear,
                    _ => return Err(file.wrong_value(entry, "write \"smooth\" or \"linear\"")),
                }
            }
            ("loop", DeValue::Boolean(value)) => is_loop = *value,
            ("loop", _) => return Err(file.wrong_kind(entry, "true or false")),
            ("key", DeValue::Array(elements)) => {
                for element in elements {
                    keys.push(read_key(file, entry, (element.span().start, element.get_ref()))?);
                }
            }
            ("key", _) => return Err(file.wrong_kind(entry, "tables [[key]]")),
            _ => return Err(file.unknown_key(entry, "a key of a camera path", &FILE_KEYS)),
        }
    }
    check_keys(file, &keys)?;
    // A path that rolls begins without a roll, unless its first key has one.
    if keys.iter().any(|key| key.roll.is_some()) {
        keys[0].roll.get_or_insert(0.0);
    }
    Ok(path_of(file, kind, is_loop, &keys))
}

fn read_key(file: &TomlFile<'_>, all: TomlEntry<'_>, (at, value): (usize, &DeValue<'_>)) -> Result<Key> {
    let DeValue::Table(table) = value else {
        return Err(file.wrong_kind(all, "tables [[key]]"));
    };
    let (mut time, mut position, mut target, mut roll, mut fov) = (None, None, None, None, None);
    for entry in entries(table) {
        match entry.key {
            "time" => {
                let seconds = finite(file, entry, "write seconds from frame 0")?;
                if seconds.abs() > MAX_SECONDS {
                    return Err(file.wrong_value(entry, "write seconds from frame 0, up to a million"));
                }
                time = Some(seconds);
            }
            "position" => position = Some(point(file, entry)?),
            "look_at" => target = Some(point(file, entry)?),
            "roll" => roll = Some(finite(file, entry, "write degrees")?),
            "fov" => {
                let why = "write degrees from 0.1 to 175";
                let degrees = finite(file, entry, why)?;
                if !(0.1..=175.0).contains(&degrees) {
                    return Err(file.wrong_value(entry, why));
                }
                fov = Some(degrees);
            }
            _ => return Err(file.unknown_key(entry, "part of a key", &KEY_KEYS)),
        }
    }
    let missing =
        |what: &str| wrong_key(file, at, format!("names no {what}; a key has time, position and look_at"));
    Ok(Key {
        at,
        time: time.ok_or_else(|| missing("time"))?,
        position: position.ok_or_else(|| missing("position"))?,
        target: target.ok_or_else(|| missing("look_at"))?,
        roll,
        fov,
    })
}

/// Refuses keys that make no path.
fn check_keys(file: &TomlFile<'_>, keys: &[Key]) -> Result<()> {
    if let [] | [_] = keys {
        let at = keys.first().map_or(0, |key| key.at);
        let count = keys.len();
        return Err(wrong_key(file, at, format!("a path needs at least two keys, and the file has {count}")));
    }
    for pair in keys.windows(2) {
        let (earlier, later) = (pair[0].time, pair[1].time);
        if later <= earlier {
            let why = format!("time {later} is not after {earlier} of the key before; times increase");
            return Err(wrong_key(file, pair[1].at, why));
        }
    }
    let same = |key: &&Key| key.position.map(|x| x as f32) == key.target.map(|x| x as f32);
    match keys.iter().find(same) {
        Some(key) => {
            let why = "look_at is the position, which gives no direction; move one of the two";
            Err(wrong_key(file, key.at, why.to_owned()))
        }
        None => Ok(()),
    }
}

fn path_of(file: &TomlFile<'_>, kind: CurveKind, is_loop: bool, keys: &[Key]) -> CameraPath {
    let (first, last) = (keys[0].time, keys[keys.len() - 1].time);
    // The way back to the first key takes as long as the other ways do on average.
    let period = is_loop.then(|| (last - first) * keys.len() as f64 / (keys.len() - 1) as f64);
    let seconds: Vec<f64> = keys.iter().map(|key| key.time).collect();
    let times = KeyTimes { seconds, period };
    let points = |of: fn(&Key) -> [f64; 3]| {
        KeyedPoint::new(times.clone(), kind, keys.iter().map(of).collect::<Vec<_>>())
    };
    let values = |of: fn(&Key) -> Option<f64>| {
        let (seconds, values): (Vec<_>, Vec<_>) =
            keys.iter().filter_map(|key| Some((key.time, of(key)?))).unzip();
        let times = KeyTimes { seconds, period };
        (!values.is_empty()).then(|| KeyedValue::new(times, kind, values))
    };
    let bits = |key: &Key| {
        let Key { at: _, time, position, target, roll, fov } = key;
        let point = [*position, *target].map(|point| point.map(f64::to_bits));
        format!("{:x} {point:x?} {:x?}", time.to_bits(), [roll, fov].map(|value| value.map(f64::to_bits)))
    };
    let bits: Vec<_> = keys.iter().map(bits).collect();
    CameraPath {
        content_key: format!("keys {kind:?} {is_loop} {}", bits.join(" ")),
        label: file_name(file.path),
        // A loop lasts one period, from frame 0 on.
        duration_seconds: period.unwrap_or(last).max(0.0),
        is_loop,
        motion: CameraMotion::Keys(Box::new(CameraKeys {
            position: points(|key| key.position),
            target: points(|key| key.target),
            roll_degrees: values(|key| key.roll),
            fov_degrees: values(|key| key.fov),
        })),
    }
}

fn finite(file: &TomlFile<'_>, entry: TomlEntry<'_>, why: &str) -> Result<f64> {
    number(entry.value).filter(|number| number.is_finite()).ok_or_else(|| file.wrong_value(entry, why))
}

/// `[X, Y, Z]`.
fn point(file: &TomlFile<'_>, entry: TomlEntry<'_>) -> Result<[f64; 3]> {
    let numbers: Option<Vec<f64>> = entry.value.as_array().and_then(|elements| {
        let numbers = elements.iter().map(|element| number(element.get_ref()));
        numbers.map(|number| number.filter(|number| (*number as f32).is_finite())).collect()
    });
    let point = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    point.ok_or_else(|| file.wrong_value(entry, "write three numbers in metres, such as [0, 1.5, 4]"))
}

/// An error about the key at byte `at`.
fn wrong_key(file: &TomlFile<'_>, at: usize, why: String) -> Error {
    SettingError { setting: "key".to_owned(), origin: file.origin(at), why }.into()
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::scene::NameOrIndex;

    #[test]
    fn what_a_path_does_not_take_from_its_file_is_told() {
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/animation/pointer_light_camera.gltf");
        let mut document: Value = serde_json::from_str(&std::fs::read_to_string(source).unwrap()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let told = |document: &Value, camera: Option<&str>| -> Vec<String> {
            let file = folder.path().join("cams.gltf");
            std::fs::write(&file, document.to_string()).unwrap();
            let source = CameraPathSource { file, camera: camera.map(NameOrIndex::parse) };
            let choices = load(&source, &ImportOptions::default()).unwrap().choices;
            choices.into_iter().map(|warning| warning.message).collect()
        };
        assert_eq!(told(&document, None), [""; 0]);

        // The same clip twice more, which animates the camera
        for _ in 0..2 {
            let mut clip = document["animations"][0].clone();
            clip["name"] = "again".into();
            document["animations"].as_array_mut().unwrap().push(clip);
        }
        let left_out = "`camera_path` cams.gltf: all clips of the file play together without #1 \"again\" and 1 more, since earlier ones animate the same";
        assert_eq!(told(&document, None), [left_out]);

        // Another camera of the same name, which nothing animates
        let eye = json!({"name": "eye", "type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}});
        document["cameras"] = json!([eye, eye]);
        let nodes = document["nodes"].as_array_mut().unwrap();
        nodes.push(json!({"camera": 1}));
        let added = nodes.len() - 1;
        document["scenes"][0]["nodes"].as_array_mut().unwrap().push(added.into());
        let ambiguous = "`camera_path` cams.gltf: several cameras are called \"eye\", and the first one is used; 'cams.gltf#0' selects one by its index";
        assert_eq!(told(&document, Some("eye")), [ambiguous, left_out]);
        assert_eq!(told(&document, Some("#0")), [left_out]);
        assert_eq!(told(&document, Some("#1")), [""; 0]);
    }
}
