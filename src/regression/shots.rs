//! Which pictures a folder of scenes asks for.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// One picture of one scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shot {
    /// The scene's path below its folder without the extension, and the frame if the scene lists frames:
    /// `light/point`, `skin/two_bone_strip.0012`.
    pub name: String,
    /// The scene file.
    pub scene: PathBuf,
    /// Frame number; frame 0 is time 0.
    pub frame: i32,
}

impl Shot {
    /// The shot's file in a folder of pictures.
    pub fn file_in(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.exr", self.name))
    }
}

/// All shots of the `.gltf` files below `folder`, in the order of their names.
///
/// A scene's root `extras.rayframe.frames` lists its frames; without it there is one picture, of frame 0.
///
/// # Errors
/// [`Error::Missing`] when something cannot be read, [`Error::Invalid`] when the list is not one of frame numbers.
pub fn discover(folder: &Path) -> Result<Vec<Shot>> {
    let mut shots = Vec::new();
    for scene in files_below(folder, "gltf")? {
        let Some(name) = name_below(folder, &scene) else {
            continue;
        };
        match frames_of(&scene)? {
            None => shots.push(Shot { name, scene, frame: 0 }),
            Some(frames) => shots.extend(frames.into_iter().map(|frame| Shot {
                name: format!("{name}.{frame:04}"),
                scene: scene.clone(),
                frame,
            })),
        }
    }
    Ok(shots)
}

/// The path of `file` below `folder` without its extension, with `/` on every system.
pub(super) fn name_below(folder: &Path, file: &Path) -> Option<String> {
    let below = file.strip_prefix(folder).ok()?.with_extension("");
    let parts: Vec<_> = below.iter().map(|part| part.to_string_lossy()).collect();
    Some(parts.join("/"))
}

/// All files below `folder` with an extension, sorted.
pub(super) fn files_below(folder: &Path, extension: &str) -> Result<Vec<PathBuf>> {
    let missing = Error::missing(folder);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(missing)? {
        let path = entry.map_err(missing)?.path();
        if path.is_dir() {
            files.extend(files_below(&path, extension)?);
        } else if path.extension().is_some_and(|found| found == extension) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn frames_of(scene: &Path) -> Result<Option<Vec<i32>>> {
    const POINTER: &str = "/extras/rayframe/frames";
    let bytes = std::fs::read(scene).map_err(Error::missing(scene))?;
    let json: serde_json::Value =
        serde_json::from_slice(&bytes).map_err(|error| Error::invalid(scene, "", error.to_string()))?;
    let Some(list) = json.pointer(POINTER) else {
        return Ok(None);
    };
    let frames: Option<Vec<i32>> = list.as_array().and_then(|list| {
        let number = |value: &serde_json::Value| value.as_i64().and_then(|frame| i32::try_from(frame).ok());
        list.iter().map(number).collect()
    });
    match frames {
        Some(frames) if !frames.is_empty() => Ok(Some(frames)),
        _ => Err(Error::invalid(scene, POINTER, "must be a list of frame numbers")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        folder
    }

    #[test]
    fn still_scenes_have_one_shot_and_others_one_a_frame() {
        let folder = folder_with(&[
            ("b/still.gltf", "{}"),
            ("a/moving.gltf", r#"{"extras": {"rayframe": {"frames": [0, 12]}}}"#),
            ("a/notes.txt", "not a scene"),
        ]);
        let shots = discover(folder.path()).unwrap();
        let names: Vec<_> = shots.iter().map(|shot| (shot.name.as_str(), shot.frame)).collect();
        assert_eq!(names, [("a/moving.0000", 0), ("a/moving.0012", 12), ("b/still", 0)]);
        assert_eq!(shots[1].file_in(Path::new("r")), Path::new("r/a/moving.0012.exr"));
    }

    #[test]
    fn a_wrong_list_of_frames_is_an_error() {
        for list in ["[]", "7", "[0.5]", "[\"0\"]"] {
            let folder =
                folder_with(&[("a.gltf", &format!(r#"{{"extras":{{"rayframe":{{"frames":{list}}}}}}}"#))]);
            let error = discover(folder.path()).unwrap_err();
            assert!(error.to_string().contains("/extras/rayframe/frames"), "{error}");
        }
    }
}
