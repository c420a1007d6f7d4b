//! The shortest way from a scene file to a picture.

use std::path::Path;

use super::Picture;
use super::surroundings::Surroundings;
use crate::bvh::{BuildSettings, Builder};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result, Warning};
use crate::film::{Film, PixelWindow};
use crate::frame::Frame;
use crate::gltf::{ImportOptions, import};
use crate::render::{RenderInput, RenderSettings, RenderStatistics, render_frame};
use crate::scene::{Environment, Scene, Selection, SelectionRequest, mark_shadow_catchers};

/// A scene ready to be rendered at any of its frames, with every choice at its default but for the surroundings that it
/// asks for.
#[derive(Debug)]
pub struct SceneRenderer {
    scene: Scene,
    selection: Selection,
    surroundings: Surroundings,
    warnings: Vec<Warning>,
}

impl SceneRenderer {
    /// Imports a scene.
    ///
    /// # Errors
    /// Those of [`import`], and [`Error::Invalid`] or [`Error::Missing`] when its surroundings are wrong.
    pub fn open(path: &Path) -> Result<Self> {
        let mut scene = import(path, &ImportOptions::default())?;
        let surroundings = Surroundings::of_scene(path)?;
        for name in &surroundings.shadow_catchers {
            if mark_shadow_catchers(&mut scene, name) == 0 {
                return Err(Error::invalid(
                    path,
                    "/extras/rayframe",
                    format!("nothing is called \"{name}\""),
                ));
            }
        }
        let (selection, mut warnings) = Selection::resolve(&SelectionRequest::default(), &scene)?;
        warnings.extend(scene.warnings.iter().cloned());
        Ok(Self { scene, selection, surroundings, warnings })
    }

    /// The scene, to be changed.
    pub fn scene_mut(&mut self) -> &mut Scene {
        &mut self.scene
    }

    /// What the file asks for and is not honoured.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        self.warnings.iter().map(ToString::to_string)
    }

    /// Renders the scene at `time_seconds`; gives the picture and how many of its pixels came out not finite.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`] when cancelled.
    pub fn render(
        &self,
        time_seconds: f64,
        resolution: (u32, u32),
        samples: u32,
        cancel: &CancelFlag,
    ) -> Result<(Picture, u64)> {
        let window = PixelWindow::full(resolution.0, resolution.1);
        let settings = RenderSettings { resolution, window, samples, ..RenderSettings::default() };
        let (film, statistics) = self.render_film(time_seconds, &settings, cancel)?;
        Ok((Picture::of_film(film), statistics.non_finite_pixels))
    }

    /// The same with settings of all kinds and all that the film holds. The background is hidden where the scene asks for it.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`] when cancelled.
    pub fn render_film(
        &self,
        time_seconds: f64,
        settings: &RenderSettings,
        cancel: &CancelFlag,
    ) -> Result<(Film, RenderStatistics)> {
        let frame = Frame::at(&self.scene, &self.selection, time_seconds);
        let build = BuildSettings::default();
        let bvh = Builder::default().build(&frame.triangles, &frame.flags, &build, cancel, None)?;
        let image_light = self.selection.image_light.map(|index| &self.scene.image_lights[index.index()]);
        let environment = match (&self.surroundings.environment, image_light) {
            (Some(environment), _) => environment.clone(),
            (None, Some(light)) => {
                Environment::of_image_light(light, self.selection.moves_image_light(&self.scene))
            }
            (None, None) if frame.lights.is_empty() => Environment::Studio,
            (None, None) => Environment::None,
        };
        let settings = RenderSettings {
            show_background: settings.show_background && !self.surroundings.is_transparent,
            ..settings.clone()
        };
        let input = RenderInput { scene: &self.scene, frame: &frame, bvh: &bvh, environment: &environment };
        Ok(render_frame(&input, &settings, cancel, &|_| {})?)
    }
}
