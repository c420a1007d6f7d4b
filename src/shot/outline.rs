//! The sequences of a shot, as far as they are known without its environment and its automatic camera.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::{Error, Result, Warning};
use crate::gltf::ImageLoading;
use crate::render::RenderSettings;
use crate::scene::{
    CameraRequest, ClipSelection, NamedSelection, Scene, SelectedCamera, Selection, SelectionRequest,
    VariantRequest, ViewRequest,
};
use crate::sequence::{FrameSpec, OutputPattern, duration_seconds};
use crate::settings::{BackgroundSource, OutputNames, Placeholder, SettingValues};

use super::camera_path::{self, LoadedPath};
use super::catchers::unrendered_catchers;
use super::environment::environment_request;
use super::import_options::import_options;
use super::render_settings::render_settings;
use super::sequence_names::SequenceNames;
use super::shot_settings::{ShotSettings, refusal};
use super::view::{ambiguous_nodes, last_frame, resolve_frames, view_request};

/// The sequences of a shot: one, or one for each clip, camera and variant.
#[derive(Clone, Debug)]
pub struct ShotOutline {
    /// The sequences: cameras within clips, variants within cameras.
    pub sequences: Vec<SequenceOutline>,
    /// Notes about clips that are left out, ambiguous names and catchers that are not rendered.
    pub choices: Vec<Warning>,
    /// Input files, which must not be overwritten: the scene, its files, images of environments and plates, the camera path and the
    /// shot file.
    pub inputs: Vec<PathBuf>,
}

/// One sequence: a clip in a variant seen by a camera, its frames and the names of its files.
#[derive(Clone, Debug)]
pub struct SequenceOutline {
    /// Its clips, its variant and its camera, before the view changes that.
    pub selection: Selection,
    /// The requested view.
    pub view: ViewRequest,
    /// Image, sampling and shading.
    pub render: RenderSettings,
    /// Frame numbers in the order of rendering.
    pub frames: Vec<i64>,
    /// The names that tell it from the others.
    pub names: SequenceNames,
    /// The names that replace placeholders.
    pub output_names: OutputNames,
    /// Names of the frame files, with placeholders.
    pub pattern: OutputPattern,
    /// Names of the frame files.
    pub output: OutputPattern,
    /// Movie.
    pub movie: Option<PathBuf>,
    /// Contact sheet.
    pub contact_sheet: Option<PathBuf>,
    /// Statistics.
    pub stats: Option<PathBuf>,
    /// Manifest.
    pub manifest: Option<PathBuf>,
}

impl SequenceOutline {
    /// The files beside the frames, each with the setting that names it.
    pub fn sidecar_files(&self) -> impl Iterator<Item = (&Path, &'static str)> {
        let files = [
            (&self.movie, "movie"),
            (&self.contact_sheet, "contact_sheet"),
            (&self.stats, "stats"),
            (&self.manifest, "manifest"),
        ];
        files.into_iter().filter_map(|(path, setting)| Some((path.as_deref()?, setting)))
    }

    /// `clip "walk", camera "left"`, as far as the settings ask for each; empty otherwise.
    pub fn label(&self) -> String {
        self.names.labels().collect::<Vec<_>>().join(", ")
    }

    /// The selection that cameras and the ground are fitted to: with the primitives' own materials where each variant has a
    /// sequence, so that all variants are framed alike.
    pub(super) fn framed_selection(&self) -> Selection {
        let variant = self.selection.variant.filter(|_| self.names.variant.is_none());
        Selection { variant, ..self.selection.clone() }
    }
}

impl ShotOutline {
    /// Resolves the settings of `shot` against its scene.
    ///
    /// # Errors
    /// [`Error::Setting`] for settings that have no meaning for the scene; under `strict` the first warning of the scene.
    pub(super) fn new(shot: &ShotSettings, scene: &Scene) -> Result<Self> {
        let args = &shot.values;
        let request = selection_request(args);
        let (mut selections, mut choices) = Selection::resolve_each(&request, scene)?;
        let warnings = warnings_of(scene, selections.iter().map(|named| &named.selection));
        if let Some(error) = refusal(&scene.path, &warnings).filter(|_| args.strict) {
            return Err(error);
        }
        choices.extend(ambiguous_nodes(args, scene));
        let selected = selections.iter().map(|named| &named.selection);
        choices.extend(unrendered_catchers(&args.shadow_catcher, scene, selected));
        choices.extend(scene.notes.iter().cloned());
        let mut inputs = vec![shot.scene.clone()];
        if let Some(source) = &args.camera_path {
            let options = import_options(args, ImageLoading::Budget);
            let LoadedPath { path, files, choices: of_path } = camera_path::load(source, &options)?;
            choices.extend(of_path);
            let path = SelectedCamera::Path(Arc::new(path));
            for named in &mut selections {
                named.selection.camera = path.clone();
                // No camera of the file.
                "auto".clone_into(&mut named.camera);
            }
            inputs.extend(files);
        }
        let view = view_request(args, scene, Selection::clips_of_each(&request, scene))?;
        let pattern = output_pattern(shot, scene, &request, &selections)?;
        let outline = |named| sequence_outline(shot, scene, named, &view, &pattern);
        let sequences: Vec<_> = selections.into_iter().map(outline).collect::<Result<_>>()?;
        inputs.extend(scene.files.iter().cloned());
        inputs.extend(environment_request(args).files().map(PathBuf::from));
        inputs.extend(plate_files(args, &sequences));
        inputs.extend(shot.shot_file.clone());
        Ok(Self { sequences, choices, inputs })
    }
}

/// The warnings about a scene that hold for any of the selections.
pub(super) fn warnings_of<'s>(
    scene: &Scene,
    selections: impl Iterator<Item = &'s Selection>,
) -> Vec<Warning> {
    let variants: Vec<_> = selections.map(|selection| selection.variant).collect();
    scene.warnings_of(&variants)
}

/// The plates behind all frames, each once.
pub(super) fn plate_files(args: &SettingValues, sequences: &[SequenceOutline]) -> BTreeSet<PathBuf> {
    let BackgroundSource::Plate(pattern) = &args.background else { return BTreeSet::new() };
    let frames = sequences.iter().flat_map(|sequence| &sequence.frames);
    frames.map(|&frame| pattern.path(frame)).collect()
}

fn sequence_outline(
    shot: &ShotSettings,
    scene: &Scene,
    named: NamedSelection,
    view: &ViewRequest,
    pattern: &OutputPattern,
) -> Result<SequenceOutline> {
    let args = &shot.values;
    if pattern.is_movie() && args.manifest.is_some() {
        let why =
            "lists the files of frames, and a movie is one file; leave it out, or name frames with `output`";
        return Err(Error::setting("manifest", why));
    }
    let NamedSelection { selection, clip, camera, variant } = named;
    // A view that does not keep the camera of the file has no name.
    let camera = if view.replaces_camera() { "auto".to_owned() } else { camera };
    let output_names = OutputNames::new(&shot.scene, shot.shot_file.as_deref(), &clip, &camera, &variant);
    let fill = |path: &Option<PathBuf>| path.as_ref().map(|path| output_names.fill(path));
    Ok(SequenceOutline {
        view: view.clone(),
        render: render_settings(args, scene, &selection, view)?,
        frames: if is_thumbnail(args, pattern) { vec![0] } else { frames(args, scene, &selection)? },
        names: SequenceNames {
            clip: (args.animation == ClipSelection::Each).then_some(clip),
            camera: (args.camera == Some(CameraRequest::Each)).then_some(camera),
            variant: (args.variant == Some(VariantRequest::Each)).then_some(variant),
        },
        pattern: pattern.clone(),
        output: pattern.with_names(&output_names, &Placeholder::ALL),
        movie: fill(&args.movie),
        contact_sheet: fill(&args.contact_sheet),
        stats: fill(&args.stats),
        manifest: fill(&args.manifest),
        output_names,
        selection,
    })
}

/// The output setting, or `<scene>.####.exr` with the names of each clip, camera and variant; without a number if all sequences
/// are stills: neither an animation, a turntable and numbered plates, nor several frames.
fn output_pattern(
    shot: &ShotSettings,
    scene: &Scene,
    request: &SelectionRequest,
    selections: &[NamedSelection],
) -> Result<OutputPattern> {
    let args = &shot.values;
    if let Some(output) = &args.output {
        return Ok(output.clone());
    }
    let mut names = Vec::new();
    if request.clips == ClipSelection::Each && !scene.animations.is_empty() {
        names.push(Placeholder::Clip);
    }
    let has_cameras = selections.iter().any(|named| named.camera != "auto");
    if request.camera == Some(CameraRequest::Each) && has_cameras {
        names.push(Placeholder::Camera);
    }
    if request.variant == Some(VariantRequest::Each) && !scene.variants.is_empty() {
        names.push(Placeholder::Variant);
    }
    let has_plates = matches!(&args.background, BackgroundSource::Plate(pattern) if pattern.is_numbered());
    let mut numbered = args.turntable.is_some() || has_plates;
    for NamedSelection { selection, .. } in selections {
        numbered |= duration_seconds(scene, selection) > 0.0 || frames(args, scene, selection)?.len() > 1;
    }
    let stem = shot.scene.file_stem().unwrap_or(OsStr::new("frame"));
    Ok(OutputPattern::default_for(stem, &names, numbered))
}

/// Whether the output names one image for each scene, and neither frames nor a movie, which shows all of them, are requested.
fn is_thumbnail(args: &SettingValues, pattern: &OutputPattern) -> bool {
    let names_scenes = pattern.has_name(Placeholder::Scene) || pattern.has_name(Placeholder::Shot);
    let requests_frames =
        args.all || args.turntable.is_some() || args.frames.is_some() || args.movie.is_some();
    let requests_range = args.start.is_some() || args.end.is_some() || args.step.is_some();
    names_scenes && !(pattern.is_numbered() || pattern.is_movie() || requests_frames || requests_range)
}

fn frames(args: &SettingValues, scene: &Scene, selection: &Selection) -> Result<Vec<i64>> {
    let last = last_frame(args.fps, scene, selection);
    resolve_frames(args, &frame_spec(args), last).map_err(|why| Error::setting(frame_setting(args), why))
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
