//! The façade: opens a scene, renders frames to memory and sequences to files.
//!
//! [`Renderer`] holds a scene and its [`Settings`]. [`Renderer::frame`] renders one frame to memory, [`Renderer::sequence`] many
//! to files. Both do what `rayframe render` does with the same settings, to the byte. Work runs on the current rayon pool.

mod frame;
mod sequence;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::cancel::CancelFlag;
use crate::error::{Provenance, Result, Warning};
use crate::gltf::ImageLoading;
use crate::output::{Aov, AovSet};
use crate::scene::{CameraRequest, Scene};
use crate::sequence::KnownShares;
use crate::settings::{EnvironmentSource, FrameSpec, Settings};
use crate::shot::{RenderJob, ShotSettings, check_warnings, load_scene, resolve_scene};

pub use frame::RenderedFrame;
pub use sequence::SequenceRenderer;

/// A scene with settings, ready to render.
///
/// Methods that set something take and return the renderer, so that calls chain. A setting that makes no sense for the scene is an
/// error of the call that renders.
///
/// ```no_run
/// use rayframe::Renderer;
///
/// let frame = Renderer::open("robot.glb")?.size(640, 360).samples(16).frame(24)?;
/// println!("{:?}", frame.pixel(320, 180));
/// frame.write_exr("robot.exr")?;
/// # Ok::<(), rayframe::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Renderer {
    settings: Settings,
    shot_file: Option<PathBuf>,
    scene: Arc<Scene>,
    cancel: CancelFlag,
    /// Shares of the environment's light that earlier frames have measured.
    known_shares: KnownShares,
}

impl Renderer {
    /// Opens a scene (`.glb`, `.gltf`), or a shot file (`.toml`) with its settings.
    ///
    /// # Errors
    /// [`Error::Missing`](crate::Error::Missing) for a file that cannot be read, [`Error::Invalid`](crate::Error::Invalid) and
    /// [`Error::Unsupported`](crate::Error::Unsupported) for one that cannot be rendered,
    /// [`Error::Setting`](crate::Error::Setting) for a wrong line of a shot file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Self::open_with(path, Settings::default())
    }

    /// Opens a scene, or a shot file, with settings that replace those of the shot file. Those of the import, `allow_dir`, `max_memory`,
    /// `asset_cache` and `asset_cache_size`, have to be known here. `scene` replaces that of a shot file, and is ignored beside a scene.
    ///
    /// ```
    /// use rayframe::Renderer;
    /// use rayframe::error::Provenance;
    /// use rayframe::settings::Settings;
    ///
    /// let mut settings = Settings::default();
    /// settings.set("allow_dir", "scenes".as_ref(), &Provenance::Library)?;
    /// let renderer = Renderer::open_with("scenes/demo/whitted_1980.gltf", settings)?;
    /// # Ok::<(), rayframe::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Renderer::open`], and [`Error::Setting`](crate::Error::Setting) for settings that cannot be combined.
    pub fn open_with(path: impl AsRef<Path>, settings: Settings) -> Result<Self> {
        let shot = ShotSettings::read_with(path.as_ref(), settings)?;
        let scene = Arc::new(load_scene(&shot, ImageLoading::Texels)?);
        let ShotSettings { settings, shot_file, .. } = shot;
        Ok(Self {
            settings,
            shot_file,
            scene,
            cancel: CancelFlag::new(),
            known_shares: KnownShares::default(),
        })
    }

    /// Sets the size of the image in pixels, in place of an earlier resolution, width, height or scale. The default is 1280x720.
    #[must_use]
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.settings.width = None;
        self.settings.height = None;
        self.settings.scale = None;
        self.settings.resolution = Some((width, height).into());
        self
    }

    /// Sets the samples per pixel. The default is 4.
    #[must_use]
    pub fn samples(mut self, samples: u32) -> Self {
        self.settings.samples = Some(samples.into());
        self
    }

    /// Selects the camera. The default is the first of the file, else one that frames the whole scene.
    #[must_use]
    pub fn camera(mut self, camera: CameraRequest) -> Self {
        self.settings.camera = Some(camera.into());
        self
    }

    /// Sets the environment light. The default is the file's own, else the studio if the scene has no light.
    #[must_use]
    pub fn environment(mut self, environment: EnvironmentSource) -> Self {
        self.settings.env = Some(environment.into());
        self
    }

    /// Records AOVs besides colour and alpha.
    #[must_use]
    pub fn aovs(mut self, aovs: impl IntoIterator<Item = Aov>) -> Self {
        self.settings.aovs = Some(AovSet::new(&aovs.into_iter().collect::<Vec<_>>()).into());
        self
    }

    /// Sets any setting by its name, from the text that its option takes: `set("shutter", "180deg")`. It replaces its earlier value
    /// and settings that cannot be combined with it; repeated settings add up. `threads`, `stats`, `manifest`, `show`, `progress`, `quiet`
    /// and `verbose` concern the program and have no effect here. `allow_dir`, `asset_cache` and `asset_cache_size` have one in
    /// [`Renderer::open_with`] and in the shot file that is opened, and `max_memory` limits the import only where it is given there.
    ///
    /// # Errors
    /// [`Error::Setting`](crate::Error::Setting) for an unknown name, with the closest one, and for a wrong value.
    pub fn set(mut self, name: &str, value: impl AsRef<OsStr>) -> Result<Self> {
        self.settings.set(name, value.as_ref(), &Provenance::Library)?;
        Ok(self)
    }

    /// Ends rendering within a second of raising `cancel`, with [`Error::Interrupted`](crate::Error::Interrupted).
    #[must_use]
    pub fn cancelled_by(mut self, cancel: &CancelFlag) -> Self {
        self.cancel = cancel.clone();
        self
    }

    /// The settings that are given.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The settings, to change all of them.
    pub fn settings_mut(&mut self) -> &mut Settings {
        &mut self.settings
    }

    /// The imported scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Unsupported optional features of the scene.
    pub fn warnings(&self) -> &[Warning] {
        &self.scene.warnings
    }

    /// Renders one frame to memory. It shows the time `frame` / fps, whatever range of frames is set.
    ///
    /// # Errors
    /// [`Error::Setting`](crate::Error::Setting) for settings that make no sense for the scene, errors of loading the
    /// environment, [`Error::Refused`](crate::Error::Refused) where the frame needs more memory than the limit, and with the setting
    /// `strict` the first warning about the scene, and [`Error::Internal`](crate::Error::Internal) for pixels that are not finite.
    pub fn frame(&self, frame: i64) -> Result<RenderedFrame> {
        // The frames that are set may have no plates.
        let mut renderer = self.clone();
        let settings = &mut renderer.settings;
        (settings.all, settings.start, settings.end, settings.step) = (None, None, None, None);
        settings.frames = Some(FrameSpec::Listed(vec![frame]).into());
        RenderedFrame::render(Arc::new(renderer.job()?.sequence), frame, &self.cancel)
    }

    /// The sequence of all frames that are set (by default the whole animation) under the names `output`, such as
    /// `out/robot.####.exr`.
    ///
    /// # Errors
    /// Those of [`Renderer::frame`], and [`Error::Setting`](crate::Error::Setting) for a wrong name.
    pub fn sequence(&self, output: impl AsRef<OsStr>) -> Result<SequenceRenderer> {
        let renderer = self.clone().set("output", output)?;
        let job = renderer.job()?;
        Ok(SequenceRenderer::new(job, renderer.settings, self.cancel.clone()))
    }

    fn job(&self) -> Result<RenderJob> {
        let shot = ShotSettings::merge([self.settings.clone()], self.shot_file.clone())?;
        let mut job = resolve_scene(&shot, Arc::clone(&self.scene))?;
        check_warnings(&job.sequence, &job.warnings)?;
        // Only the program has a terminal.
        job.sequence.sequence_outputs.shows_frames = false;
        job.sequence.known_shares = self.known_shares.clone();
        Ok(job)
    }
}
