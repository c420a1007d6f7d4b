//! Sources of camera paths.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::os_text::around;
use crate::scene::NameOrIndex;

/// Ends of file names that hold scenes.
const SCENE_ENDINGS: [&str; 2] = [".glb", ".gltf"];

/// File with a camera path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CameraPathSource {
    /// Keys in `.toml`, or a scene in `.glb` or `.gltf`.
    pub file: PathBuf,
    /// Camera of the scene; `None` for the first.
    pub camera: Option<NameOrIndex>,
}

impl CameraPathSource {
    /// `path.toml`, `cameras.glb`, `cameras.glb#NAME` or `cameras.glb#0`.
    ///
    /// # Errors
    /// One line that says what to write.
    pub fn parse(text: &OsStr) -> Result<Self, String> {
        let has_ending = |text: &OsStr, ending: &str| {
            text.to_string_lossy().to_ascii_lowercase().ends_with(ending) && text.len() > ending.len()
        };
        let is_scene = |text: &OsStr| SCENE_ENDINGS.iter().any(|ending| has_ending(text, ending));
        if is_scene(text) || has_ending(text, ".toml") {
            return Ok(Self { file: PathBuf::from(text), camera: None });
        }
        let marks = text.as_encoded_bytes().iter().enumerate().filter(|(_, byte)| **byte == b'#');
        let named = marks.filter_map(|(at, _)| around(text, at)).find(|(file, _)| is_scene(file));
        match named {
            Some((_, "")) => Err("after the # stands the name of a camera, or its number".to_owned()),
            Some((file, camera)) => {
                let camera = match camera.parse() {
                    Ok(index) => NameOrIndex::Index(index),
                    Err(_) => NameOrIndex::Name(camera.to_owned()),
                };
                Ok(Self { file: PathBuf::from(file), camera: Some(camera) })
            }
            None => Err(
                "write a .toml file of keys, or a .glb or .gltf file with a camera, such as walk.toml or \
                         cameras.glb#NAME"
                    .to_owned(),
            ),
        }
    }

    /// As the setting is written.
    pub fn to_text(&self) -> OsString {
        let mut text = self.file.clone().into_os_string();
        match &self.camera {
            None => {}
            Some(NameOrIndex::Name(name)) => text.push(format!("#{name}")),
            Some(NameOrIndex::Index(index)) => text.push(format!("#{index}")),
        }
        text
    }

    /// Whether the file holds keys.
    pub fn is_keys(&self) -> bool {
        Path::new(&self.file).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_name_a_file_and_a_camera() {
        let parse = |text: &str| CameraPathSource::parse(OsStr::new(text));
        for (text, file, camera) in [
            ("walk.toml", "walk.toml", None),
            ("a/cams.GLB", "a/cams.GLB", None),
            ("cams.glb#Hero cam", "cams.glb", Some(NameOrIndex::Name("Hero cam".to_owned()))),
            ("c#1.gltf#2", "c#1.gltf", Some(NameOrIndex::Index(2))),
        ] {
            let source = parse(text).unwrap();
            assert_eq!((source.file.as_path(), &source.camera), (Path::new(file), &camera), "{text}");
            assert_eq!(source.to_text(), text);
        }
        for text in ["", ".toml", "walk", "walk.json", "cams.glb#", "#a"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
