//! The environment that the command line asks for, loaded.

use std::io::Read as _;
use std::path::Path;

use glam::Vec3;
use sha2::{Digest as _, Sha256};

use crate::error::{Error, Result, Warning};
use crate::image_file::read_environment;
use crate::scene::{Environment, EnvironmentMap, Scene, Selection};

use super::options::EnvironmentSource;

/// An environment and what it was made from.
#[derive(Debug)]
pub(super) struct LoadedEnvironment {
    /// The light.
    pub(super) environment: Environment,
    /// Differs whenever the light does.
    pub(super) key: String,
    /// For the first line of a run; empty when there is no environment.
    pub(super) description: String,
    /// What was changed to make it usable.
    pub(super) warnings: Vec<Warning>,
}

/// Loads what was asked for; without a wish the studio lights scenes that have no light of their own.
pub(super) fn load(
    source: Option<&EnvironmentSource>,
    scene: &Scene,
    selection: &Selection,
    max_memory_bytes: u64,
) -> Result<LoadedEnvironment> {
    let plain = |environment, key: String, description: &str| LoadedEnvironment {
        environment,
        key,
        description: description.to_owned(),
        warnings: Vec::new(),
    };
    let none = || plain(Environment::None, "none".to_owned(), "");
    let studio = || plain(Environment::Studio, "studio".to_owned(), "studio light");
    if let Some(index) = selection.image_light.filter(|_| source.is_none())
        && let Some(light) = scene.image_lights.get(index.index())
    {
        let environment = Environment::Map(EnvironmentMap::of_image_light(light));
        // The pictures are part of the scene, whose hash covers them.
        return Ok(plain(environment, format!("image light {}", index.0), "the file's image-based light"));
    }
    Ok(match source {
        None if has_lights(scene, selection) => none(),
        None | Some(EnvironmentSource::Studio) => studio(),
        Some(EnvironmentSource::None) => none(),
        Some(&EnvironmentSource::Constant([r, g, b])) => {
            let bits = [r, g, b].map(|value| format!("{:08x}", value.to_bits())).join(" ");
            let description = format!("environment {r},{g},{b}");
            plain(Environment::Constant(Vec3::new(r, g, b)), format!("constant {bits}"), &description)
        }
        Some(EnvironmentSource::File(path, degrees)) => map(path, *degrees, max_memory_bytes)?,
    })
}

fn map(path: &Path, degrees: f32, max_memory_bytes: u64) -> Result<LoadedEnvironment> {
    let bytes = read_regular_file(path, max_memory_bytes).map_err(|error| explained(error, path))?;
    let digest = Sha256::digest(&bytes);
    let digest: Vec<String> = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    let pixels = read_environment(path, &bytes, max_memory_bytes)?;
    let map = EnvironmentMap::new(path, pixels.width, pixels.height, pixels.pixels, degrees)?;
    Ok(LoadedEnvironment {
        environment: Environment::Map(map),
        key: format!("map {} turned {:08x}", digest.concat(), degrees.to_bits()),
        description: match degrees {
            0.0 => format!("environment {}", path.display()),
            _ => format!("environment {} turned by {degrees}°", path.display()),
        },
        warnings: pixels.warnings,
    })
}

/// Adds what can be written where the file is missing.
fn explained(error: Error, path: &Path) -> Error {
    let Error::Missing { pointer, source, .. } = error else {
        return error;
    };
    let turned = path.to_str().and_then(|text| text.rsplit_once('@'));
    if let Some((file, degrees)) = turned
        && Path::new(file).is_file()
    {
        return Error::usage(format!(
            "--env: after {file}@ stands the number of degrees to turn it by, not \"{degrees}\""
        ));
    }
    let forms = "--env takes a .hdr or .exr file, R,G,B, studio or none";
    let source = std::io::Error::new(source.kind(), format!("{source}; {forms}"));
    Error::Missing { path: path.to_owned(), pointer, source }
}

/// The whole of a file that is one: devices and pipes may never end.
fn read_regular_file(path: &Path, max_bytes: u64) -> Result<Vec<u8>> {
    let missing = |source| Error::Missing { path: path.to_owned(), pointer: String::new(), source };
    let metadata = std::fs::metadata(path).map_err(missing)?;
    if !metadata.is_file() {
        return Err(Error::invalid(path, "", "is not a regular file"));
    }
    if metadata.len() > max_bytes {
        return Err(Error::refused(path, "", "is larger than --max-memory allows"));
    }
    let file = std::fs::File::open(path).map_err(missing)?;
    let mut bytes = Vec::new();
    file.take(max_bytes).read_to_end(&mut bytes).map_err(missing)?;
    Ok(bytes)
}

/// Whether any light is placed below the selected roots.
fn has_lights(scene: &Scene, selection: &Selection) -> bool {
    let mut pending = selection.roots.clone();
    while let Some(node) = pending.pop().and_then(|index| scene.nodes.get(index.index())) {
        if node.light.is_some() {
            return true;
        }
        pending.extend_from_slice(&node.children);
    }
    false
}
