//! What a scene of a suite asks for around it, beyond what its format can say.
//!
//! `extras.rayframe.surroundings` of the root holds `environment` and `background`, each `[R, G, B]` or
//! `{"picture": FILE, "degrees": D}` with a path from the scene's folder; `intensity` of the environment; `transparent` for no
//! background; and `shadow_catchers`, names of nodes and materials. All may be left out.

use std::path::Path;

use glam::Vec3;
use serde::Deserialize;

use crate::error::{Error, Result};
use crate::gltf::ImportOptions;
use crate::image_file::read_environment;
use crate::scene::{ComposedEnvironment, Environment, EnvironmentMap};

const POINTER: &str = "/extras/rayframe/surroundings";

/// As the file says it.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Wishes {
    environment: Option<Source>,
    intensity: Option<f32>,
    background: Option<Source>,
    transparent: bool,
    shadow_catchers: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Source {
    Constant([f32; 3]),
    Picture { picture: String, degrees: f32 },
}

/// What surrounds a scene.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    /// The light; `None` is the default.
    pub(super) environment: Option<Environment>,
    /// Whether what is behind the scene is not seen.
    pub(super) is_transparent: bool,
    /// What is invisible but for the shadows on it.
    pub(super) shadow_catchers: Vec<String>,
}

impl Surroundings {
    /// Reads what the scene file at `path` asks for.
    ///
    /// # Errors
    /// [`Error::Missing`] when the scene or a picture cannot be read, [`Error::Invalid`] when either is wrong.
    pub(super) fn of_scene(path: &Path) -> Result<Self> {
        let bytes = read(path)?;
        // A file in another form than text has no extras; the import says what is wrong with one that is broken.
        let json: serde_json::Value = serde_json::from_slice(&bytes).unwrap_or_default();
        let Some(wishes) = json.pointer(POINTER) else {
            return Ok(Self::default());
        };
        let wishes = Wishes::deserialize(wishes)
            .map_err(|error| Error::invalid(path, POINTER, format!("is not understood: {error}")))?;
        let load = |source: &Option<Source>| source.as_ref().map(|source| source.load(path)).transpose();
        let (light, background) = (load(&wishes.environment)?, load(&wishes.background)?);
        let intensity = wishes.intensity.unwrap_or(1.0);
        let environment = light.map(|light| {
            Environment::Composed(Box::new(ComposedEnvironment { light, intensity, background }))
        });
        Ok(Self { environment, is_transparent: wishes.transparent, shadow_catchers: wishes.shadow_catchers })
    }
}

impl Source {
    fn load(&self, scene: &Path) -> Result<Environment> {
        match self {
            Self::Constant(color) => Ok(Environment::Constant(Vec3::from_array(*color))),
            Self::Picture { picture, degrees } => {
                let path = scene.parent().unwrap_or(Path::new("")).join(picture);
                let limit_bytes = ImportOptions::default().max_memory_bytes;
                let pixels = read_environment(&path, &read(&path)?, limit_bytes)?;
                let map = EnvironmentMap::new(&path, pixels.width, pixels.height, pixels.pixels, *degrees)?;
                Ok(Environment::Map(map))
            }
        }
    }
}

fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(Error::missing(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(surroundings: &str) -> Result<Surroundings> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        let text = format!(r#"{{"extras": {{"rayframe": {{"surroundings": {surroundings}}}}}}}"#);
        std::fs::write(&path, text).unwrap();
        Surroundings::of_scene(&path)
    }

    #[test]
    fn wishes_are_understood_or_refused() {
        let all = r#"{"environment": [1, 2, 3], "intensity": 0.5, "background": [0, 1, 0], "transparent": true,
            "shadow_catchers": ["floor"]}"#;
        let found = of(all).unwrap();
        let environment = found.environment.unwrap();
        assert_eq!(environment.radiance(Vec3::X), Vec3::new(0.5, 1.0, 1.5));
        assert_eq!(environment.background_over(Vec3::X, [Vec3::ZERO; 2]), Vec3::Y);
        assert!(found.is_transparent && found.shadow_catchers == ["floor"]);
        assert!(of("{}").unwrap().environment.is_none());
        for wrong in [r#"{"enviroment": [1, 1, 1]}"#, r#"{"environment": "sky"}"#, r#"{"transparent": 1}"#] {
            assert!(of(wrong).unwrap_err().to_string().contains(POINTER), "{wrong}");
        }
        let missing = of(r#"{"environment": {"picture": "gone.hdr", "degrees": 0}}"#).unwrap_err();
        assert!(missing.to_string().contains("gone.hdr"), "{missing}");
    }
}
