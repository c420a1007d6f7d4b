//! The shortest way from a scene file to a picture.

use std::path::Path;

use super::Picture;
use crate::bvh::{BuildSettings, Builder};
use crate::cancel::CancelFlag;
use crate::error::{Result, Warning};
use crate::film::PixelWindow;
use crate::frame::Frame;
use crate::gltf::{ImportOptions, import};
use crate::render::{RenderInput, RenderSettings, render_frame};
use crate::scene::{Environment, EnvironmentMap, Scene, Selection, SelectionRequest};

/// A scene ready to be rendered at any of its frames, with every choice at its default.
#[derive(Debug)]
pub struct SceneRenderer {
    scene: Scene,
    selection: Selection,
    warnings: Vec<Warning>,
}

impl SceneRenderer {
    /// Imports a scene.
    ///
    /// # Errors
    /// Those of [`import`].
    pub fn open(path: &Path) -> Result<Self> {
        let scene = import(path, &ImportOptions::default())?;
        let (selection, mut warnings) = Selection::resolve(&SelectionRequest::default(), &scene)?;
        warnings.extend(scene.warnings.iter().cloned());
        Ok(Self { scene, selection, warnings })
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
        let frame = Frame::at(&self.scene, &self.selection, time_seconds);
        let build = BuildSettings::default();
        let bvh = Builder::default().build(&frame.triangles, &frame.flags, &build, cancel, None)?;
        let image_light = self.selection.image_light.map(|index| &self.scene.image_lights[index.index()]);
        let environment = match image_light {
            Some(light) => Environment::Map(EnvironmentMap::of_image_light(light)),
            None if frame.lights.is_empty() => Environment::Studio,
            None => Environment::None,
        };
        let settings = RenderSettings {
            resolution,
            window: PixelWindow::full(resolution.0, resolution.1),
            samples,
            ..RenderSettings::default()
        };
        let input = RenderInput { scene: &self.scene, frame: &frame, bvh: &bvh, environment: &environment };
        let (film, statistics) = render_frame(&input, &settings, cancel, &|_| {})?;
        Ok((Picture::of_film(film), statistics.non_finite_pixels))
    }
}
