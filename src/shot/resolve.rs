//! Settings to the job that they describe.

use std::path::PathBuf;
use std::sync::Arc;

use crate::asset_cache::AssetCache;
use crate::bvh::{BuildSettings, SimdLevel};
use crate::denoise::Denoiser;
use crate::error::{Error, Result, Warning};
use crate::film::AovFlags;
use crate::framing::{CameraRule, ResolvedCamera, SharedFraming};
use crate::gltf::{self, ImageLoading};
use crate::output::{Aov, AovSet, matte_collisions};
use crate::render::{PathFrame, RenderSettings};
use crate::scene::{
    CameraRequest, ClipSelection, Environment, Ground, Scene, Selection, VariantRequest, ViewRequest,
};
use crate::sequence::{
    ExistingFiles, FirstPose, KnownShares, PixelMemory, Plan, Plates, SequenceJob, SequenceOutputs,
    SharedExposure, Shutter, check_framing_memory, check_image_memory, lowest_band,
};
use crate::settings::{BackgroundSource, DenoiserKind, GroundKind, SettingValues, Switch};

use super::catchers::catch_shadows;
use super::environment::{LoadedEnvironment, LoadedEnvironments, environment_request};
use super::import_options::import_options;
use super::ineffective::{ineffective_settings, moves};
use super::memory_limit::max_memory_bytes;
use super::outline::{SequenceOutline, ShotOutline, plate_files, warnings_of};
use super::render_settings::{exr_output, known_window, path_settings};
use super::shot_settings::ShotSettings;

/// A job with its warnings.
#[derive(Debug)]
pub struct RenderJob {
    /// The job.
    pub sequence: SequenceJob,
    /// Its clip, its camera, its variant and the names of its files.
    pub outline: SequenceOutline,
    /// Notes about settings without effect and clips that are left out. `strict` ignores them.
    pub choices: Vec<Warning>,
    /// Unsupported features.
    pub warnings: Vec<Warning>,
    /// What decided the camera.
    pub camera: CameraRule,
    /// Summary of the environment; empty without one.
    pub environment: String,
    /// Input files, which must not be overwritten: the scene, its files, the environment images and the shot file.
    pub inputs: Vec<PathBuf>,
}

/// Loads the scene and the environment of a shot, and resolves its settings against them.
///
/// # Errors
/// [`Error::Setting`] for settings that have no meaning for the scene or make several sequences, and all errors of loading.
pub fn resolve(shot: &ShotSettings, images: ImageLoading) -> Result<RenderJob> {
    refuse_each(shot)?;
    resolve_scene(shot, Arc::new(load_scene(shot, images)?))
}

/// The same with one job for each clip, camera and variant where the settings ask for each. Environment images that `environments`
/// holds are not loaded again.
///
/// # Errors
/// Those of [`resolve`].
pub fn resolve_each(
    shot: &ShotSettings,
    images: ImageLoading,
    environments: &mut LoadedEnvironments,
) -> Result<Vec<RenderJob>> {
    let scene = Arc::new(load_scene(shot, images)?);
    resolve_sequences(shot, scene, environments).map_err(|error| shot.settings.locate(error))
}

/// Loads the scene of a shot without texels, and checks everything that needs neither environment nor camera. Images of
/// environments and plates must exist; they are not read.
///
/// # Errors
/// Those of [`resolve`] and of [`Plan::new`] as far as they can be found so.
pub fn check_shot(shot: &ShotSettings) -> Result<ShotOutline> {
    let scene = Arc::new(load_scene(shot, ImageLoading::Budget)?);
    check_scene(shot, scene).map_err(|error| shot.settings.locate(error))
}

fn check_scene(shot: &ShotSettings, scene: Arc<Scene>) -> Result<ShotOutline> {
    let scene = prepared(shot, scene)?;
    let outline = ShotOutline::new(shot, &scene)?;
    for path in environment_request(&shot.values).files() {
        std::fs::metadata(path).map_err(Error::missing(path))?;
    }
    for path in plate_files(&shot.values, &outline.sequences) {
        std::fs::metadata(&path).map_err(Error::missing(&path))?;
    }
    denoiser(&shot.values)?;
    for sequence in &outline.sequences {
        let selection = sequence.selection.clone();
        Plan::check(&sequence_job(shot, Arc::clone(&scene), sequence, selection, Environment::None))?;
    }
    Ok(outline)
}

/// Loads the scene of a shot.
///
/// # Errors
/// Those of the import, and [`Error::Refused`] where a band of the image or the scene needs more memory than the limit.
pub(crate) fn load_scene(shot: &ShotSettings, images: ImageLoading) -> Result<Scene> {
    check_image(shot).map_err(|error| shot.settings.locate(error))?;
    let values = &shot.values;
    let folder = values.asset_cache.as_deref().filter(|_| images == ImageLoading::Texels);
    let cache = folder.map(|folder| AssetCache::open(folder, values.asset_cache_size));
    gltf::import_with_cache(&shot.scene, &import_options(values, images), cache.as_ref())
}

/// Refuses an image that needs too much memory even in bands of rows, where its size does not depend on the scene.
fn check_image(shot: &ShotSettings) -> Result<()> {
    let values = &shot.values;
    let Some(window) = known_window(values)? else { return Ok(()) };
    let exr = exr_output(values);
    let path = path_settings(values)?;
    let aovs = exr.aov_flags();
    let guides = aovs.guides || values.denoise != DenoiserKind::None;
    let image = PixelMemory {
        window,
        shutter: shutter(values),
        filter: values.filter,
        exr: &exr,
        sums: PathFrame::sum_flags(values.integrator, &path, AovFlags { guides, ..aovs }),
        stores_sums: values.checkpoint || path.sample_range.is_some(),
        is_denoised: values.denoise != DenoiserKind::None,
    };
    let check =
        |window| check_image_memory(&shot.scene, &PixelMemory { window, ..image }, max_memory_bytes(values));
    // Whether bands are possible is known when the scene is loaded.
    check(lowest_band(window, &exr)).or_else(|_| check(window))
}

/// Loads the environment of a shot whose scene is loaded, and resolves its settings against both.
///
/// # Errors
/// [`Error::Setting`] for settings that have no meaning for the scene or make several sequences, and errors of loading the
/// environment.
pub(crate) fn resolve_scene(shot: &ShotSettings, scene: Arc<Scene>) -> Result<RenderJob> {
    resolve_scene_with(shot, scene, &mut LoadedEnvironments::default())
}

/// The same. Environment images that `environments` holds are not loaded again.
///
/// # Errors
/// Those of [`resolve_scene`].
pub(super) fn resolve_scene_with(
    shot: &ShotSettings,
    scene: Arc<Scene>,
    environments: &mut LoadedEnvironments,
) -> Result<RenderJob> {
    refuse_each(shot)?;
    let jobs = resolve_sequences(shot, scene, environments);
    let mut jobs = jobs.map_err(|error| shot.settings.locate(error))?;
    match (jobs.pop(), jobs.is_empty()) {
        (Some(job), true) => Ok(job),
        _ => Err(Error::Internal { message: "one sequence was requested and not one resolved".to_owned() }),
    }
}

/// Refuses settings that make several sequences.
fn refuse_each(shot: &ShotSettings) -> Result<()> {
    let Some((setting, what)) = each_setting(&shot.values) else { return Ok(()) };
    let why = format!("each makes several sequences, which only rayframe render takes; name one {what}");
    Err(shot.settings.error(setting, why))
}

/// The first setting that makes several sequences, and of what.
pub(super) fn each_setting(values: &SettingValues) -> Option<(&'static str, &'static str)> {
    match (&values.animation, &values.camera, &values.variant) {
        (ClipSelection::Each, ..) => Some(("animation", "clip")),
        (_, Some(CameraRequest::Each), _) => Some(("camera", "camera")),
        (.., Some(VariantRequest::Each)) => Some(("variant", "variant")),
        _ => None,
    }
}

fn shutter(values: &SettingValues) -> Shutter {
    values.shutter.map_or(Shutter::default(), |open| Shutter { open, time_samples: values.time_samples })
}

/// The scene with its shadow catchers.
pub(super) fn prepared(shot: &ShotSettings, mut scene: Arc<Scene>) -> Result<Arc<Scene>> {
    if !shot.values.shadow_catcher.is_empty() {
        catch_shadows(Arc::make_mut(&mut scene), &shot.values.shadow_catcher)?;
    }
    Ok(scene)
}

fn resolve_sequences(
    shot: &ShotSettings,
    scene: Arc<Scene>,
    environments: &mut LoadedEnvironments,
) -> Result<Vec<RenderJob>> {
    let args = &shot.values;
    let scene = prepared(shot, scene)?;
    let ShotOutline { sequences, choices, inputs } = ShotOutline::new(shot, &scene)?;
    let request = environment_request(args);
    let mut scene_warnings = warnings_of(&scene, sequences.iter().map(|outline| &outline.selection));
    scene_warnings.extend(matte_warnings(args, &scene));
    let denoiser = denoiser(args)?;

    // Environment, stage and camera of each sequence. All have the environment of one, so that their exposure does not depend on which
    // of them measures it: one that moves the file's light, if any does.
    let lit = sequences.iter().find(|outline| outline.selection.moves_image_light(&scene));
    let Some(lit) = lit.or(sequences.first()).map(|outline| outline.selection.clone()) else {
        return Ok(Vec::new());
    };
    let mut jobs = Vec::new();
    let framing = if sequences.len() > 1 || args.ground != GroundKind::None {
        SharedFraming::of_several(&scene)
    } else {
        SharedFraming::of_one(&scene)
    };
    for outline in sequences {
        let max_memory_bytes = max_memory_bytes(args);
        let LoadedEnvironment { environment, description, warnings } =
            environments.load(&request, &scene, &lit, max_memory_bytes)?;
        let (width, height) = outline.render.resolution;
        let aspect_ratio = width as f32 / height as f32;
        let alone = outline.view.measured_clips.len();
        check_framing_memory(&scene, &outline.selection, alone, max_memory_bytes)?;
        let framed = outline.framed_selection();
        let (ResolvedCamera { selection, rule }, posed) =
            framing.resolve(framed.clone(), &outline.view, aspect_ratio);
        let selection = Selection { variant: outline.selection.variant, ..selection };
        let mut sequence = sequence_job(shot, Arc::clone(&scene), &outline, selection, environment);
        if let Some(frame) = posed {
            sequence.first_pose = FirstPose::new(frame, &scene, framed.clone());
        }
        sequence.render.ground = ground(args, &framing, &framed, &outline.view);
        sequence.denoiser.clone_from(&denoiser);
        sequence.plates = plates(args, &outline.frames, max_memory_bytes)?;
        let mut choices = choices.clone();
        choices.extend(ineffective_settings(args, &sequence));
        jobs.push(RenderJob {
            sequence,
            outline,
            choices,
            warnings: [scene_warnings.as_slice(), &warnings].concat(),
            camera: rule,
            environment: request.with_background(description),
            inputs: inputs.clone(),
        });
    }
    share_light(&mut jobs);
    Ok(jobs)
}

/// Gives the jobs of one scene one automatic exposure, and what is known of shares of the environment's light.
fn share_light(jobs: &mut [RenderJob]) {
    let Some(first) = jobs.first().filter(|_| jobs.len() > 1) else { return };
    // Cameras may have shapes of their own, and which of them needs the exposure first depends on what is there.
    let resolution = first.sequence.render.resolution;
    let selections = jobs.iter().map(|job| job.sequence.selection.clone()).collect();
    let shared = Arc::new(SharedExposure::new(selections, resolution));
    let known_shares = first.sequence.known_shares.clone();
    for job in jobs {
        job.sequence.shared_exposure = Some(Arc::clone(&shared));
        job.sequence.known_shares = known_shares.clone();
    }
}

fn sequence_job(
    shot: &ShotSettings,
    scene: Arc<Scene>,
    outline: &SequenceOutline,
    selection: Selection,
    environment: Environment,
) -> SequenceJob {
    let args = &shot.values;
    let has_clips = !selection.clips.is_empty() || !outline.view.measured_clips.is_empty();
    let mut job = SequenceJob {
        scene,
        camera_follows_clips: has_clips && outline.view.follows_subject(),
        selection,
        environment,
        is_environment_default: args.env.is_none(),
        frames: outline.frames.clone(),
        rate: args.fps,
        shutter: shutter(args),
        first_pose: FirstPose::default(),
        known_shares: KnownShares::default(),
        render: RenderSettings {
            show_background: environment_request(args).shows_background(),
            ..outline.render.clone()
        },
        build: build_settings(args),
        output: outline.output.clone(),
        exr: exr_output(args),
        preview: args.preview.is_some(),
        sequence_outputs: SequenceOutputs {
            movie: outline.movie.clone(),
            contact_sheet: outline.contact_sheet.clone(),
            is_on_common_sheet: false,
            shows_frames: args.show,
        },
        exposure: args.exposure,
        shared_exposure: None,
        tone: args.tone.unwrap_or_default(),
        display_background: environment_request(args).display_background(),
        plates: None,
        existing: existing_files(args),
        denoiser: None,
        checkpoint: args.checkpoint,
        write_behind: args.write_behind == Switch::On,
        // Of a movie all frames are needed; other scenes may go on.
        keep_going: args.keep_going && !outline.output.is_movie(),
        strict: args.strict,
        max_memory_bytes: max_memory_bytes(args),
    };
    if !moves(&job) {
        // One pose shows what several would, in less time.
        job.shutter = Shutter::default();
    }
    job
}

fn matte_warnings(args: &SettingValues, scene: &Scene) -> Vec<Warning> {
    let layers = args.aovs.iter().flat_map(AovSet::as_slice);
    let has_mattes = layers.into_iter().any(|layer| matches!(layer, Aov::CryptoObject | Aov::CryptoMaterial));
    if has_mattes { matte_collisions(scene) } else { Vec::new() }
}

/// The denoiser, where one is asked for.
fn denoiser(args: &SettingValues) -> Result<Option<Denoiser>> {
    match args.denoise {
        DenoiserKind::None => Ok(None),
        DenoiserKind::Oidn => Denoiser::find(args.oidn.as_deref())
            .map(Some)
            .map_err(|why| Error::setting(if args.oidn.is_some() { "oidn" } else { "denoise" }, why)),
    }
}

fn plates(args: &SettingValues, frames: &[i64], max_memory_bytes: u64) -> Result<Option<Plates>> {
    match &args.background {
        BackgroundSource::Plate(pattern) => {
            Plates::open(pattern, args.background_fit, frames, max_memory_bytes).map(Some)
        }
        _ => Ok(None),
    }
}

fn ground(
    args: &SettingValues,
    framing: &SharedFraming<'_>,
    framed: &Selection,
    view: &ViewRequest,
) -> Option<Ground> {
    match args.ground {
        GroundKind::None => None,
        kind => framing.ground_below(framed, view, kind == GroundKind::Reflection),
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
        reference_budget: args.split_budget,
        simd: args.simd.unwrap_or_else(SimdLevel::best),
        refit: args.refit,
        ..BuildSettings::default()
    }
}
