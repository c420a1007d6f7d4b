//! Settings to the job that they describe.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::Arc;

use crate::bvh::{BuildSettings, SimdLevel};
use crate::error::{Error, Result, Warning};
use crate::framing::{CameraRule, ResolvedCamera, resolve_camera};
use crate::gltf::{self, ImageLoading, ImportOptions};
use crate::output::{Aov, AovSet, matte_collisions};
use crate::render::RenderSettings;
use crate::scene::{
    NameOrIndex, Scene, SelectedCamera, Selection, SelectionRequest, mark_shadow_catchers,
    mark_shadow_catching_node,
};
use crate::sequence::{
    ExistingFiles, FrameSpec, OutputPattern, SequenceJob, SequenceOutputs, Shutter, check_image_memory,
    duration_seconds,
};
use crate::settings::{SettingValues, parse, suggest};

use super::camera_path::{self, LoadedPath};
use super::environment::{self, EnvironmentRequest, LoadedEnvironment};
use super::ineffective::ineffective_settings;
use super::memory_limit::default_max_memory_bytes;
use super::render_settings::{exr_output, known_window, render_settings};
use super::shot_settings::ShotSettings;
use super::view::{last_frame, resolve_frames, view_request};

/// A job with its warnings.
#[derive(Debug)]
pub struct RenderJob {
    /// The job.
    pub sequence: SequenceJob,
    /// Notes about settings without effect and clips that are left out. `strict` ignores them.
    pub choices: Vec<Warning>,
    /// Unsupported features.
    pub warnings: Vec<Warning>,
    /// What decided the camera.
    pub camera: CameraRule,
    /// Summary of the environment; empty without one.
    pub environment: String,
    /// Input files, which must not be overwritten: the scene, its files, and the environment images.
    pub inputs: Vec<PathBuf>,
}

/// Loads the scene and the environment of a shot, and resolves its settings against them.
///
/// # Errors
/// [`Error::Setting`] for settings that have no meaning for the scene, and all errors of loading.
pub fn resolve(shot: &ShotSettings, images: ImageLoading) -> Result<RenderJob> {
    resolve_scene(shot, Arc::new(load_scene(shot, images)?))
}

/// Loads the scene of a shot.
///
/// # Errors
/// Those of the import, and [`Error::Refused`] where the image or the scene needs more memory than the limit.
pub(crate) fn load_scene(shot: &ShotSettings, images: ImageLoading) -> Result<Scene> {
    check_image(shot).map_err(|error| shot.settings.locate(error))?;
    let max_memory_bytes = shot.values.max_memory.unwrap_or_else(default_max_memory_bytes);
    gltf::import(&shot.scene, &ImportOptions { max_memory_bytes, images })
}

/// Refuses an image that needs too much memory, where its size does not depend on the scene.
fn check_image(shot: &ShotSettings) -> Result<()> {
    let values = &shot.values;
    let max_memory_bytes = values.max_memory.unwrap_or_else(default_max_memory_bytes);
    match known_window(values)? {
        Some(window) => {
            check_image_memory(&shot.scene, window, shutter(values), &exr_output(values), max_memory_bytes)
        }
        None => Ok(()),
    }
}

/// Loads the environment of a shot whose scene is loaded, and resolves its settings against both.
///
/// # Errors
/// [`Error::Setting`] for settings that have no meaning for the scene, and errors of loading the environment.
pub(crate) fn resolve_scene(shot: &ShotSettings, scene: Arc<Scene>) -> Result<RenderJob> {
    resolve_values(shot, scene).map_err(|error| shot.settings.locate(error))
}

fn shutter(values: &SettingValues) -> Shutter {
    values.shutter.map_or(Shutter::default(), |open| Shutter { open, time_samples: values.time_samples })
}

fn resolve_values(shot: &ShotSettings, mut scene: Arc<Scene>) -> Result<RenderJob> {
    let args = &shot.values;
    let max_memory_bytes = args.max_memory.unwrap_or_else(default_max_memory_bytes);
    let request = EnvironmentRequest {
        light: args.env.clone(),
        intensity: args.env_intensity,
        background: args.background.clone(),
    };
    let exr = exr_output(args);
    if !args.shadow_catcher.is_empty() {
        catch_shadows(Arc::make_mut(&mut scene), &args.shadow_catcher)?;
    }
    let (mut selection, mut choices) = Selection::resolve(&selection_request(args), &scene)?;
    let mut inputs = vec![shot.scene.clone()];
    if let Some(source) = &args.camera_path {
        let LoadedPath { path, files } = camera_path::load(source, max_memory_bytes)?;
        selection.camera = SelectedCamera::Path(Arc::new(path));
        inputs.extend(files);
    }
    let LoadedEnvironment { environment, description, warnings: environment_warnings } =
        environment::load(&request, &scene, &selection, max_memory_bytes)?;
    inputs.extend(scene.files.iter().cloned());
    inputs.extend(request.files().map(PathBuf::from));
    let layers = args.aovs.iter().flat_map(AovSet::as_slice);
    let has_mattes = layers.into_iter().any(|layer| matches!(layer, Aov::CryptoObject | Aov::CryptoMaterial));
    let matte_warnings = if has_mattes { matte_collisions(&scene) } else { Vec::new() };
    let warnings = [scene.warnings.clone(), environment_warnings, matte_warnings].concat();
    let description = request.with_background(description);

    let duration = duration_seconds(&scene, &selection);
    let frames = resolve_frames(args, &frame_spec(args), last_frame(args.fps, &scene, &selection))
        .map_err(|why| Error::setting(frame_setting(args), why))?;
    let numbered = frames.len() > 1 || duration > 0.0;
    let stem = shot.scene.file_stem().unwrap_or(OsStr::new("frame"));
    let output = args.output.clone().unwrap_or_else(|| OutputPattern::default_for(stem, numbered));

    if output.is_movie() && args.manifest.is_some() {
        let why =
            "lists the files of frames, and a movie is one file; leave it out, or name frames with `output`";
        return Err(Error::setting("manifest", why));
    }

    let render = RenderSettings {
        show_background: request.shows_background(),
        ..render_settings(args, &scene, &selection)?
    };
    let aspect_ratio = render.resolution.0 as f32 / render.resolution.1 as f32;
    let view = view_request(args, &scene)?;
    let ResolvedCamera { selection, rule } = resolve_camera(&scene, selection, &view, aspect_ratio);
    let sequence = SequenceJob {
        render,
        build: build_settings(args),
        scene,
        selection,
        environment,
        is_environment_default: args.env.is_none(),
        frames,
        rate: args.fps,
        shutter: shutter(args),
        output,
        exr,
        preview: args.preview.is_some(),
        sequence_outputs: SequenceOutputs {
            movie: args.movie.clone(),
            contact_sheet: args.contact_sheet.clone(),
            shows_frames: args.show,
        },
        exposure: args.exposure,
        tone: args.tone.unwrap_or_default(),
        display_background: request.display_background(),
        existing: existing_files(args),
        keep_going: args.keep_going,
        strict: args.strict,
        max_memory_bytes,
    };
    choices.extend(ineffective_settings(args, &sequence));
    Ok(RenderJob { sequence, choices, warnings, camera: rule, environment: description, inputs })
}

fn catch_shadows(scene: &mut Scene, names: &[String]) -> Result<()> {
    for name in names {
        if mark_shadow_catchers(scene, name) > 0 {
            continue;
        }
        if let NameOrIndex::Index(_) = parse::choice(name)
            && let Some(node) = scene.node(&parse::choice(name))
            && mark_shadow_catching_node(scene, node)
        {
            continue;
        }
        let nodes = scene.nodes.iter().filter(|node| node.mesh.is_some()).map(|node| node.name.as_deref());
        let names = nodes.chain(scene.materials.iter().map(|material| material.name.as_deref()));
        return Err(Error::setting(
            "shadow_catcher",
            format!(
                "neither a node with a mesh nor a material is called \"{}\"; {}",
                name.escape_debug(),
                suggest(name, names.flatten())
            ),
        ));
    }
    Ok(())
}

fn frame_spec(args: &SettingValues) -> FrameSpec {
    if let Some(frames) = &args.frames {
        return frames.clone();
    }
    // Blender's -a is combined with -s and -e, so it means no more than the default.
    if (args.start, args.end, args.step) == (None, None, None) {
        return FrameSpec::All;
    }
    FrameSpec::Range {
        start: args.start.map(i64::from),
        end: args.end.map(i64::from),
        step: args.step.map_or(1, i64::from),
    }
}

/// The setting that decides the frames.
fn frame_setting(args: &SettingValues) -> &'static str {
    match (&args.frames, args.start, args.end) {
        (None, Some(_), _) => "start",
        (None, None, Some(_)) => "end",
        _ => "frames",
    }
}

fn selection_request(args: &SettingValues) -> SelectionRequest {
    SelectionRequest {
        scene: args.scene_choice.clone(),
        clips: args.animation.clone(),
        camera: args.camera.clone(),
        variant: args.variant.clone(),
    }
}

fn existing_files(args: &SettingValues) -> ExistingFiles {
    match (args.resume, args.overwrite) {
        (_, true) => ExistingFiles::Overwrite,
        (true, false) => ExistingFiles::Resume,
        (false, false) => ExistingFiles::Protect,
    }
}

fn build_settings(args: &SettingValues) -> BuildSettings {
    BuildSettings {
        builder: args.bvh,
        split: args.split,
        simd: args.simd.unwrap_or_else(SimdLevel::best),
        refit: args.refit,
        ..BuildSettings::default()
    }
}
