//! From the options that were typed to the job that is meant. After this nothing parses text.

use std::ffi::OsStr;
use std::path::PathBuf;

use crate::bvh::{BuildSettings, BuilderKind, SimdLevel};
use crate::color::ToneCurve;
use crate::error::{Error, Result, Warning};
use crate::frame;
use crate::gltf::{self, ImageLoading, ImportOptions};
use crate::output::{Aov, AovSet, ExrOutput, matte_collisions};
use crate::render::RenderSettings;
use crate::scene::{
    NameOrIndex, Scene, Selection, SelectionRequest, mark_shadow_catchers, mark_shadow_catching_node,
};
use crate::sequence::{
    ExistingFiles, Exposure, FrameRate, FrameSpec, OutputPattern, SequenceJob, SequenceOutputs, Shutter,
    check_image_memory, duration_seconds,
};

use super::choices::choices;
use super::environment::{self, EnvironmentWishes, LoadedEnvironment};
use super::idle_options::idle_options;
use super::memory_limit::default_max_memory_bytes;
use super::options;
use super::render_args::{BvhArg, RenderArgs, SimdArg, ToneArg};
use super::render_settings::{known_window, render_settings};

/// A job, and what is to be said about it.
#[derive(Debug)]
pub struct RenderJob {
    /// What to do.
    pub sequence: SequenceJob,
    /// What was left out by choice, which `--strict` has nothing against.
    pub choices: Vec<Warning>,
    /// What is not honoured.
    pub warnings: Vec<Warning>,
    /// The environment in words; empty when there is none.
    pub environment: String,
    /// Files that are read and must not be written over: the scene, the files it names, and the environment's picture.
    pub inputs: Vec<PathBuf>,
}

/// What can be understood without the scene.
struct Wishes {
    frames: FrameSpec,
    rate: FrameRate,
    output: Option<OutputPattern>,
    environment: EnvironmentWishes,
    exposure: Exposure,
    simd: SimdLevel,
    max_memory_bytes: u64,
}

/// Understands the options, loads the scene and the environment, and puts the job together.
///
/// # Errors
/// [`Error::Usage`] for options that make no sense, found before anything is loaded where that is possible; and all that
/// loading can meet.
pub fn render_job(args: &RenderArgs) -> Result<RenderJob> {
    let wishes = understand(args)?;
    let max_memory_bytes = wishes.max_memory_bytes;
    let shutter =
        args.shutter.map_or(Shutter::default(), |open| Shutter { open, time_samples: args.time_samples });
    let exr = exr_output(args);
    if let Some(window) = known_window(args)? {
        check_image_memory(&args.scene, window, shutter, &exr, max_memory_bytes)?;
    }
    let images = if args.dry_run { ImageLoading::Budget } else { ImageLoading::Texels };
    let options = ImportOptions { max_memory_bytes, images };
    let mut scene = gltf::import(&args.scene, &options)?;
    catch_shadows(&mut scene, &args.shadow_catcher)?;
    let (selection, mut choices) = Selection::resolve(&selection_request(args), &scene)?;
    let LoadedEnvironment { environment, key: environment_key, description, warnings: environment_warnings } =
        environment::load(&wishes.environment, &scene, &selection, max_memory_bytes)?;
    let show_background = wishes.environment.shows_background();
    let mut inputs = vec![args.scene.clone()];
    inputs.extend(scene.files.iter().cloned());
    inputs.extend(wishes.environment.files().map(PathBuf::from));
    let layers = args.layers.iter().flat_map(AovSet::as_slice);
    let has_mattes = layers.into_iter().any(|layer| matches!(layer, Aov::CryptoObject | Aov::CryptoMaterial));
    let matte_warnings = if has_mattes { matte_collisions(&scene) } else { Vec::new() };
    let warnings = [scene.warnings.clone(), environment_warnings, matte_warnings].concat();
    let description = match (show_background, description.as_str()) {
        (true, _) => description,
        (false, "") => "background none".to_owned(),
        (false, _) => format!("{description}, background none"),
    };

    let duration = duration_seconds(&scene, &selection);
    let frames = wishes.frames.resolve(wishes.rate.last_frame(duration)).map_err(Error::usage)?;
    let numbered = frames.len() > 1 || duration > 0.0;
    let stem = args.scene.file_stem().unwrap_or(OsStr::new("frame"));
    let output = wishes.output.unwrap_or_else(|| OutputPattern::default_for(stem, numbered));

    let render = RenderSettings { show_background, ..render_settings(args, &scene, &selection)? };
    let aspect_ratio = render.resolution.0 as f32 / render.resolution.1 as f32;
    let selection = frame::resolve_auto_camera(&scene, selection, aspect_ratio);
    let sequence = SequenceJob {
        render,
        build: build_settings(args, wishes.simd),
        scene,
        selection,
        environment,
        environment_key,
        frames,
        rate: wishes.rate,
        shutter,
        output,
        exr,
        preview: args.preview.is_some(),
        sequence_outputs: SequenceOutputs {
            movie: args.movie.clone(),
            contact_sheet: args.contact_sheet.clone(),
            shows_frames: args.show,
        },
        exposure: wishes.exposure,
        tone: match args.tone.unwrap_or(ToneArg::Standard) {
            ToneArg::Standard => ToneCurve::Standard,
            ToneArg::Agx => ToneCurve::Agx,
            ToneArg::Aces => ToneCurve::Aces,
            ToneArg::Neutral => ToneCurve::Neutral,
        },
        existing: existing_files(args),
        keep_going: args.keep_going,
        strict: args.strict,
        max_memory_bytes,
    };
    choices.extend(idle_options(args, &sequence));
    Ok(RenderJob { sequence, choices, warnings, environment: description, inputs })
}

fn understand(args: &RenderArgs) -> Result<Wishes> {
    let usage = |option: &'static str| move |why: String| Error::usage(format!("{option}: {why}"));
    let output = args.output.as_deref().map(OutputPattern::parse).transpose();
    let exposure = options::exposure(&args.exposure).map_err(usage("--exposure"))?;
    Ok(Wishes {
        frames: frame_spec(args).map_err(usage("--frames"))?,
        rate: FrameRate::parse(&args.fps).map_err(usage("--fps"))?,
        output: output.map_err(usage("--output"))?,
        environment: EnvironmentWishes {
            light: args.env.as_deref().map(options::environment).transpose().map_err(usage("--env"))?,
            intensity: args.env_intensity,
            background: options::background(&args.background).map_err(usage("--background"))?,
        },
        exposure: exposure.map_or(Exposure::Auto, Exposure::Ev),
        simd: simd_level(args.simd)?,
        max_memory_bytes: args.max_memory.unwrap_or_else(default_max_memory_bytes),
    })
}

fn catch_shadows(scene: &mut Scene, names: &[String]) -> Result<()> {
    for name in names {
        if mark_shadow_catchers(scene, name) > 0 {
            continue;
        }
        if let NameOrIndex::Index(_) = options::choice(name)
            && let Some(node) = scene.node(&options::choice(name))
            && mark_shadow_catching_node(scene, node)
        {
            continue;
        }
        let nodes = scene.nodes.iter().filter(|node| node.mesh.is_some()).map(|node| node.name.as_deref());
        let names = nodes.chain(scene.materials.iter().map(|material| material.name.as_deref()));
        return Err(Error::usage(format!(
            "--shadow-catcher: neither a node with a mesh nor a material is called \"{}\"; {}",
            name.escape_debug(),
            choices(name, names.flatten())
        )));
    }
    Ok(())
}

fn frame_spec(args: &RenderArgs) -> std::result::Result<FrameSpec, String> {
    if let Some(text) = &args.frames {
        return FrameSpec::parse(text);
    }
    // Blender's -a goes with -s and -e, so it asks for nothing that is not the default.
    if (args.start, args.end, args.step) == (None, None, None) {
        return Ok(FrameSpec::All);
    }
    Ok(FrameSpec::Range {
        start: args.start.map(i64::from),
        end: args.end.map(i64::from),
        step: args.step.map_or(1, i64::from),
    })
}

fn simd_level(arg: SimdArg) -> Result<SimdLevel> {
    let level = match arg {
        SimdArg::Best => SimdLevel::best(),
        SimdArg::Scalar => SimdLevel::Scalar,
        SimdArg::Sse42 => SimdLevel::Sse42,
        SimdArg::Avx2 => SimdLevel::Avx2,
        SimdArg::Avx512 => SimdLevel::Avx512,
        SimdArg::Neon => SimdLevel::Neon,
    };
    if !level.is_supported() {
        return Err(Error::usage("--simd: this machine lacks these instructions; leave the option out"));
    }
    Ok(level)
}

fn selection_request(args: &RenderArgs) -> SelectionRequest {
    SelectionRequest {
        scene: args.scene_choice.as_deref().map(options::choice),
        clips: options::clips(&args.animation),
        camera: args.camera.as_deref().map(options::camera),
        variant: args.variant.as_deref().map(options::choice),
    }
}

fn existing_files(args: &RenderArgs) -> ExistingFiles {
    match (args.resume, args.overwrite) {
        (_, true) => ExistingFiles::Overwrite,
        (true, false) => ExistingFiles::Resume,
        (false, false) => ExistingFiles::Protect,
    }
}

pub fn exr_output(args: &RenderArgs) -> ExrOutput {
    let (samples, compression) = args.exr.unwrap_or_default();
    ExrOutput {
        aovs: args.layers.clone().unwrap_or_default(),
        samples,
        compression,
        is_split: args.split_aovs,
        is_stamped: args.stamp,
    }
}

fn build_settings(args: &RenderArgs, simd: SimdLevel) -> BuildSettings {
    BuildSettings {
        builder: match args.bvh {
            BvhArg::Auto => BuilderKind::Auto,
            BvhArg::Lbvh => BuilderKind::Lbvh,
            BvhArg::Ploc => BuilderKind::Ploc,
            BvhArg::Karras => BuilderKind::Karras,
            BvhArg::Brute => BuilderKind::BruteForce,
        },
        split: args.split,
        simd,
        refit: args.refit,
        ..BuildSettings::default()
    }
}
