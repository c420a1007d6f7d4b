//! Loading of environments.

use std::path::Path;

use glam::Vec3;
use sha2::{Digest as _, Sha256};

use crate::error::{Error, Result, Warning};
use crate::image_file::{EnvironmentPixels, read_environment, read_regular_file};
use crate::scene::{
    BuiltInLight, ComposedEnvironment, Environment, EnvironmentImage, EnvironmentMap, Scene, Selection,
};

use crate::settings::{BackgroundSource, ENVIRONMENT_FORMS, EnvironmentSource, SettingValues};

/// A loaded environment.
#[derive(Clone, Debug)]
pub struct LoadedEnvironment {
    /// The environment.
    pub environment: Environment,
    /// Summary; empty without an environment.
    pub description: String,
    /// Warnings about changed pixels.
    pub warnings: Vec<Warning>,
}

/// Requested environment and background.
#[derive(Debug)]
pub struct EnvironmentRequest {
    /// Source of the light; `None` for the default.
    pub light: Option<EnvironmentSource>,
    /// Factor of the light.
    pub intensity: f32,
    /// Source of the background.
    pub background: BackgroundSource,
}

impl EnvironmentRequest {
    /// The image files of the request.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let sources = [self.light.as_ref(), self.background.environment()];
        sources.into_iter().flatten().filter_map(|source| match source {
            EnvironmentSource::File(path, _) => Some(path.as_path()),
            _ => None,
        })
    }

    /// Whether the background is rendered. Without it pixels are transparent.
    pub fn shows_background(&self) -> bool {
        match self.background {
            BackgroundSource::Environment(EnvironmentSource::None)
            | BackgroundSource::Display(_)
            | BackgroundSource::Plate(_) => false,
            BackgroundSource::Light | BackgroundSource::Environment(_) => true,
        }
    }

    /// Summary of the environment, with a background that is not rendered.
    pub fn with_background(&self, description: String) -> String {
        if self.shows_background() {
            return description;
        }
        let background = format!("background {}", self.background.to_text().display());
        if description.is_empty() { background } else { format!("{description}, {background}") }
    }

    /// The exact colour of display images behind the scene, if there is one.
    pub fn display_background(&self) -> Option<[u8; 3]> {
        match self.background {
            BackgroundSource::Display(color) => Some(color),
            BackgroundSource::Light | BackgroundSource::Environment(_) | BackgroundSource::Plate(_) => None,
        }
    }
}

/// The environment and the background that the settings ask for.
pub(crate) fn environment_request(args: &SettingValues) -> EnvironmentRequest {
    EnvironmentRequest {
        light: args.env.clone(),
        intensity: args.env_intensity,
        background: args.background.clone(),
    }
}

/// Loads the requested environment. By default the studio lights scenes without lights.
pub fn load(
    request: &EnvironmentRequest,
    scene: &Scene,
    selection: &Selection,
    max_memory_bytes: u64,
) -> Result<LoadedEnvironment> {
    LoadedEnvironments::default().load(request, scene, selection, max_memory_bytes)
}

/// The images of the last environments, shared by scenes that are lit alike.
#[derive(Debug, Default)]
pub struct LoadedEnvironments {
    images: Vec<(EnvironmentSource, LoadedEnvironment)>,
}

impl LoadedEnvironments {
    /// Images that are kept: that of a light and that of a background.
    const KEPT: usize = 2;

    /// Loads the requested environment, unless it is loaded. By default the studio lights scenes without lights.
    ///
    /// # Errors
    /// Those of reading an image.
    pub fn load(
        &mut self,
        request: &EnvironmentRequest,
        scene: &Scene,
        selection: &Selection,
        max_memory_bytes: u64,
    ) -> Result<LoadedEnvironment> {
        compose(request, scene, selection, &mut |source, setting| {
            self.of_source(source, setting, max_memory_bytes)
        })
    }

    fn of_source(
        &mut self,
        source: &EnvironmentSource,
        setting: &str,
        max_memory_bytes: u64,
    ) -> Result<LoadedEnvironment> {
        if let Some((_, loaded)) = self.images.iter().find(|(kept, _)| kept == source) {
            return Ok(loaded.clone());
        }
        let is_image = matches!(source, EnvironmentSource::File(..));
        if is_image && self.images.len() >= Self::KEPT {
            // Free it before the next one is read.
            self.images.remove(0);
        }
        let loaded = of_source(source, setting, max_memory_bytes)?;
        if is_image {
            self.images.push((source.clone(), loaded.clone()));
        }
        Ok(loaded)
    }
}

/// The environment of `scene` from sources that `of_source` loads.
fn compose(
    request: &EnvironmentRequest,
    scene: &Scene,
    selection: &Selection,
    of_source: &mut dyn FnMut(&EnvironmentSource, &str) -> Result<LoadedEnvironment>,
) -> Result<LoadedEnvironment> {
    let image_light =
        selection.image_light.and_then(|index| Some((index, scene.image_lights.get(index.index())?)));
    let mut loaded = match (&request.light, image_light) {
        (Some(source), _) => of_source(source, "env")?,
        (None, Some((index, light))) => LoadedEnvironment {
            environment: Environment::of_image_light(light, index, selection.moves_image_light(scene)),
            description: "the file's image-based light".to_owned(),
            warnings: Vec::new(),
        },
        (None, None) if selection.has_lights(scene) => of_source(&EnvironmentSource::None, "env")?,
        (None, None) => of_source(&EnvironmentSource::BuiltIn(BuiltInLight::Studio), "env")?,
    };
    let background = request.background.environment().filter(|_| request.shows_background());
    let background = background.map(|source| of_source(source, "background")).transpose()?;
    let intensity = request.intensity;
    if intensity == 1.0 && background.is_none() {
        return Ok(loaded);
    }
    if intensity != 1.0 && !loaded.description.is_empty() {
        loaded.description = format!("{} times {intensity}", loaded.description);
    }
    let background = background.map(|background| {
        let behind = format!("background {}", background.description.trim_start_matches("environment "));
        let described = [std::mem::take(&mut loaded.description), behind];
        loaded.description =
            described.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ");
        loaded.warnings.extend(background.warnings);
        background.environment
    });
    let light = std::mem::take(&mut loaded.environment);
    loaded.environment =
        Environment::Composed(Box::new(ComposedEnvironment { light, intensity, background }));
    Ok(loaded)
}

/// Loads one source.
fn of_source(source: &EnvironmentSource, setting: &str, max_memory_bytes: u64) -> Result<LoadedEnvironment> {
    let plain = |environment, description: &str| LoadedEnvironment {
        environment,
        description: description.to_owned(),
        warnings: Vec::new(),
    };
    Ok(match source {
        EnvironmentSource::None => plain(Environment::None, ""),
        &EnvironmentSource::BuiltIn(light) => {
            plain(Environment::BuiltIn(light), &format!("{} light", light.name()))
        }
        &EnvironmentSource::Constant([r, g, b]) => {
            let description = format!("environment {r},{g},{b}");
            plain(Environment::Constant(Vec3::new(r, g, b)), &description)
        }
        EnvironmentSource::File(path, degrees) => {
            map(path, *degrees, max_memory_bytes).map_err(|error| explained(error, path, setting))?
        }
    })
}

fn map(path: &Path, degrees: f32, max_memory_bytes: u64) -> Result<LoadedEnvironment> {
    let bytes = read_regular_file(path, max_memory_bytes)?;
    let (content_hash, decoded) =
        rayon::join(|| Sha256::digest(&bytes).into(), || read_environment(path, &bytes, max_memory_bytes));
    let EnvironmentPixels { width, height, pixels, warnings } = decoded?;
    let image = EnvironmentImage { width, height, pixels, content_hash };
    let environment = Environment::Map(EnvironmentMap::new(path, image, degrees)?);
    Ok(LoadedEnvironment {
        environment,
        description: match degrees {
            0.0 => format!("environment {}", path.display()),
            _ => format!("environment {} turned by {degrees}°", path.display()),
        },
        warnings,
    })
}

/// Adds the accepted forms to the error of a missing file.
fn explained(error: Error, path: &Path, setting: &str) -> Error {
    let Error::Missing { pointer, source, .. } = error else {
        return error;
    };
    let turned = path.to_str().and_then(|text| text.rsplit_once('@'));
    if let Some((file, degrees)) = turned
        && Path::new(file).is_file()
    {
        return Error::setting(
            setting,
            format!("after {file}@ stands the number of degrees to turn it by, not \"{degrees}\""),
        );
    }
    let forms = match setting {
        "background" => {
            format!("`background` takes env, white, black, #rrggbb, an image, {ENVIRONMENT_FORMS}")
        }
        _ => format!("`env` takes {ENVIRONMENT_FORMS}"),
    };
    let source = std::io::Error::new(source.kind(), format!("{source}; {forms}"));
    Error::Missing { path: path.to_owned(), pointer, source }
}
