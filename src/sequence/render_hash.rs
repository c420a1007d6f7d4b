//! Hash of everything that a frame is made from: equal exactly for equal images.
//!
//! It covers the version, the content of scene and environment, the selection, every setting that changes a pixel, the AOVs, sample types
//! and compression of the files, and the time. It does not cover threads, SIMD, builder, splits, crop, sample range, other frames, names,
//! stamps and progress: none changes a pixel. For tone-mapped files it also covers the look and, as they have no data window, the crop.

use glam::Mat4;
use serde_json::json;
use sha2::{Digest as _, Sha256};

use crate::color::ToneCurve;
use crate::film::PixelWindow;
use crate::output::{ExrOutput, PreviewLook, SOFTWARE};
use crate::render::{EnvSamples, GlassShadows, Integrator, PathSettings, RenderSettings};
use crate::scene::{CameraChanges, Ground, Scene, SelectedCamera, Selection, Turntable};
use crate::sha256::hex;

use self::catchers::{catchers_key, shadow_catchers};
use self::sampling::sampling_key;
use super::environment_shares::measured_key;
use super::{Exposure, OutputFormat, SequenceJob, SharedExposure, Shutter};

mod catchers;
mod sampling;

/// Number of the rule by which occluders of the environment are lit in the dark.
const INTERREFLECTIONS: u32 = 1;
/// Number of the rule about lights that a file never shows.
const HIDDEN_LIGHTS: u32 = 1;
/// Number of the rule of automatic exposure: frames by two rules never belong to one sequence.
const METERING: u32 = 8;

/// The hash of a run: of all that its files are made from, the part of the image and of its samples, and what is stored beside pixels.
/// Runs of other frames before plates have other hashes.
pub(super) fn run_hash(job: &SequenceJob) -> String {
    let mut content = content_of_all_frames(job);
    let PixelWindow { x0, y0, x1, y1 } = job.render.window;
    content["part"] = json!([x0, y0, x1, y1, job.render.sample_range_text()]);
    content["stored"] = json!([job.exr.is_stamped, job.exr.lists_content]);
    if job.preview {
        content["preview"] = png_key(job.tone, job.exposure, job.display_background, job.render.window);
    }
    if let Some(plates) = &job.plates {
        let key = |&frame: &i64| {
            let (content_hash, fit) = plates.content_key(frame);
            json!([frame, content_hash.map(|hash| hex(&hash)), fit])
        };
        content["plates"] = job.frames.iter().map(key).collect();
    }
    hash_of(&content)
}

/// The hash of the preview of a frame: equal exactly for equal previews of equal frames. Exposure is that of `look`.
pub(super) fn preview_hash(job: &SequenceJob, render_hash: &str, look: PreviewLook) -> String {
    let PreviewLook { exposure_ev, tone, background } = look;
    let shown = png_key(tone, Exposure::Ev(exposure_ev), background, job.render.window);
    hash_of(&json!([render_hash, shown, job.render.sample_range_text()]))
}

fn hash_of(content: &serde_json::Value) -> String {
    hex(&Sha256::digest(content.to_string().as_bytes()))
}

/// What the frames of a job have in common.
///
/// Every struct of settings is destructured in full, so that a new field is either hashed or left out on purpose.
pub(super) fn content_of_all_frames(job: &SequenceJob) -> serde_json::Value {
    let SequenceJob {
        scene,
        selection,
        camera_follows_clips: _,
        environment,
        is_environment_default: _,
        frames: _,
        rate,
        shutter,
        first_pose: _,
        known_shares: _,
        render,
        build: _,
        output,
        exr,
        preview: _,
        sequence_outputs: _,
        exposure,
        shared_exposure: _,
        tone,
        display_background,
        plates: _,
        existing: _,
        keep_going: _,
        strict: _,
        denoiser,
        checkpoint: _,
        write_behind: _,
        max_memory_bytes: _,
    } = job;
    let Selection { roots, clips, camera, camera_changes, image_light: _, variant } = selection;
    let file = match output.format() {
        OutputFormat::Exr => exr_key(exr),
        _ => png_key(*tone, *exposure, *display_background, render.window),
    };
    // Keys are sorted when printed and floats are given by their bits: one value has one text.
    let mut content = render_settings_key(render, *shutter);
    let of_job = json!({
        "software": SOFTWARE,
        "scene": hex(&scene.content_hash),
        "roots": roots.iter().map(|root| root.0).collect::<Vec<_>>(),
        "clips": clips.iter().map(|clip| clip.0).collect::<Vec<_>>(),
        "camera": camera_key(camera, camera_changes),
        "variant": variant.map(|variant| variant.0),
        "environment": environment.content_key(),
        "shadow_catchers": catchers_key(scene, selection, render),
        "fps": rate.to_string(),
        "file": file,
    });
    for (key, value) in of_job.as_object().into_iter().flatten() {
        content[key] = value.clone();
    }
    if selection.leaves_out_lights(scene) {
        content["hidden_lights"] = HIDDEN_LIGHTS.into();
    }
    // Pixels depend on their neighbours, and so on the crop.
    if let Some(denoiser) = denoiser {
        let PixelWindow { x0, y0, x1, y1 } = render.window;
        content["denoiser"] = json!(["oidn", denoiser.version, x0, y0, x1, y1]);
    }
    if lights_occluders(job) {
        content["interreflections"] = INTERREFLECTIONS.into();
    }
    add_measured(job, &mut content);
    content
}

/// Whether the occluders of the environment's shadow rays may be lit.
fn lights_occluders(job: &SequenceJob) -> bool {
    let RenderSettings { integrator, env_samples, .. } = job.render;
    integrator == Integrator::Whitted && env_samples != EnvSamples::Fixed(0) && job.environment.is_lit()
}

/// Adds the rules and selections by which measured values decide about pixels.
fn add_measured(job: &SequenceJob, content: &mut serde_json::Value) {
    let SequenceJob { scene, selection, render, output, exposure, shared_exposure, .. } = job;
    if let Some(key) = measured_key(job) {
        content["environment_shares"] = key;
    }
    let decides_about_samples = render.decides_by_display_values();
    if decides_about_samples {
        content["sampled_at"] = exposure_key(*exposure);
    }
    let is_shown = decides_about_samples || output.format() != OutputFormat::Exr;
    let measured = shared_exposure.as_ref().filter(|_| is_shown && *exposure == Exposure::Auto);
    let own = (selection, render.resolution);
    if let Some(key) = measured.and_then(|shared| shared_exposure_key(scene, shared, own)) {
        content["measured"] = key;
    }
}

fn render_settings_key(render: &RenderSettings, shutter: Shutter) -> serde_json::Value {
    let RenderSettings {
        resolution,
        window: _,
        samples,
        integrator,
        path,
        adaptive: _,
        filter: _,
        lens: _,
        max_depth,
        glass_shadows,
        light_scale,
        light_size: _,
        glossy_samples: _,
        env_samples: _,
        environment_shares,
        show_background,
        ground,
        noise_time: _,
        exposure_ev: _,
        aovs: _,
    } = render;
    let mut key = json!({
        "resolution": [resolution.0, resolution.1],
        "samples": samples,
        "max_depth": max_depth,
        "glass_shadows": glass_shadows_key(*glass_shadows),
        "light_scale": light_scale.to_bits(),
        "show_background": show_background,
        "sampling": sampling_key(render, shutter),
        "integrator": integrator_key(*integrator, path),
    });
    if let Some(Ground { up, height, is_mirror }) = ground {
        key["ground"] = json!([up.to_array().map(f32::to_bits), height.to_bits(), is_mirror]);
    }
    if let Some(shares) = environment_shares {
        key["environment_shares"] = json!(shares.bits());
    }
    key
}

fn integrator_key(integrator: Integrator, path: &PathSettings) -> serde_json::Value {
    let PathSettings {
        seed,
        seed_per_frame,
        noise,
        clamp_indirect,
        regularize,
        sample_range: _,
        time_limit_seconds,
    } = *path;
    match integrator {
        Integrator::Path => {
            let [noise, time_limit_seconds] =
                [noise, time_limit_seconds].map(|limit| limit.map(f32::to_bits));
            let clamp = clamp_indirect.to_bits();
            json!(["path", seed, seed_per_frame, noise, clamp, regularize, time_limit_seconds])
        }
        Integrator::Whitted => json!("whitted"),
    }
}

fn glass_shadows_key(glass_shadows: GlassShadows) -> &'static str {
    match glass_shadows {
        GlassShadows::Straight => "straight",
        GlassShadows::Opaque => "opaque",
    }
}

/// Automatic exposure of several sequences depends on all of them, and on the shape of the first; that of one sequence alone, by its
/// own selection and resolution, is hashed already.
fn shared_exposure_key(
    scene: &Scene,
    shared: &SharedExposure,
    (own, own_resolution): (&Selection, (u32, u32)),
) -> Option<serde_json::Value> {
    // Shadow catchers are not measured. Those of the own selection are hashed already.
    let catchers_of = |selection: &Selection| shadow_catchers(scene, selection).primitives;
    let own_catchers = catchers_of(own);
    let key = |selection: &Selection| {
        let catchers = catchers_of(selection);
        let key = selection_key(selection);
        if catchers == own_catchers { key } else { json!([key, catchers]) }
    };
    let keys: Vec<_> = shared.selections.iter().map(key).collect();
    let (width, height) = shared.resolution;
    if shared.resolution != own_resolution {
        return Some(json!({ "resolution": [width, height], "selections": keys }));
    }
    (keys != [selection_key(own)]).then(|| keys.into())
}

/// Clips, camera and variant of a selection; no variant where primitives keep their own materials. All of a scene share the rest.
fn selection_key(selection: &Selection) -> serde_json::Value {
    let Selection { clips, camera, camera_changes, variant, roots: _, image_light: _ } = selection;
    let clips: Vec<_> = clips.iter().map(|clip| clip.0).collect();
    let camera = camera_key(camera, camera_changes);
    match variant {
        Some(variant) => json!([clips, camera, variant.0]),
        None => json!([clips, camera]),
    }
}

fn camera_key(camera: &SelectedCamera, changes: &CameraChanges) -> String {
    let bits = |matrix: Mat4| matrix.to_cols_array().map(f32::to_bits);
    match camera {
        SelectedCamera::Auto => "auto".to_owned(),
        SelectedCamera::Node(node) if *changes == CameraChanges::default() => format!("node {}", node.0),
        SelectedCamera::Node(node) => format!("node {} {}", node.0, changes_key(changes)),
        SelectedCamera::Path(path) => format!("path {} {}", path.content_key, changes_key(changes)),
        SelectedCamera::Fixed { world_from_camera, projection } => {
            format!("fixed {:x?} {projection:?}", bits(*world_from_camera))
        }
        SelectedCamera::Turntable(Turntable { start, projection, center, axis, turn_seconds }) => {
            let points = [center, axis].map(|point| point.to_array().map(f32::to_bits));
            format!("turntable {:x?} {projection:?} {points:x?} {:x}", bits(*start), turn_seconds.to_bits())
        }
    }
}

fn changes_key(changes: &CameraChanges) -> String {
    let CameraChanges { position, target, up, roll_radians, projection } = *changes;
    let points = [position, target, up].map(|point| point.map(|point| point.to_array().map(f32::to_bits)));
    format!("{points:x?} {:x} {projection:?}", roll_radians.to_bits())
}

/// Content and encoding of EXR files. A stamp describes the run, not the image: it is left out.
fn exr_key(exr: &ExrOutput) -> serde_json::Value {
    let ExrOutput { aovs, samples, compression, is_split, is_stamped, lists_content } = exr;
    // The default file has a name of its own.
    if *exr == (ExrOutput { is_stamped: *is_stamped, lists_content: *lists_content, ..ExrOutput::default() })
    {
        return json!("exr rgba half");
    }
    json!({
        "layers": aovs.as_slice().iter().map(|aov| aov.name()).collect::<Vec<_>>(),
        "samples": samples.name(),
        "compression": compression.name(),
        "split": is_split,
    })
}

fn exposure_key(exposure: Exposure) -> serde_json::Value {
    match exposure {
        Exposure::Auto => json!(["auto", METERING]),
        Exposure::Ev(ev) => json!(ev.to_bits()),
    }
}

/// Look and crop of PNG files and movies, which have no data window.
fn png_key(
    tone: ToneCurve,
    exposure: Exposure,
    background: Option<[u8; 3]>,
    window: PixelWindow,
) -> serde_json::Value {
    json!({
        "png": tone.name(),
        "exposure": exposure_key(exposure),
        "background": background,
        "crop": [window.x0, window.y0, window.x1, window.y1],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, MaterialIndex, Mesh, MeshIndex, Node, Primitive, VariantIndex};

    fn selection(variant: Option<VariantIndex>) -> Selection {
        Selection {
            roots: Vec::new(),
            clips: Vec::new(),
            camera: SelectedCamera::Auto,
            camera_changes: CameraChanges::default(),
            image_light: None,
            variant,
        }
    }

    #[test]
    fn measured_selections_differ_in_their_variants() {
        let [own, first, second] = [None, Some(VariantIndex(0)), Some(VariantIndex(1))]
            .map(|variant| selection_key(&selection(variant)));
        assert!(own != first && first != second, "{own} {first} {second}");
    }

    #[test]
    fn measured_selections_differ_in_their_catchers() {
        let primitive =
            Primitive { variants: vec![(VariantIndex(1), MaterialIndex(1))], ..Primitive::default() };
        let mut scene = Scene {
            materials: vec![Material::default(); 2],
            meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
            nodes: vec![Node { mesh: Some(MeshIndex(0)), ..Node::default() }],
            ..Scene::default()
        };
        let each = [0, 1].map(|variant| selection(Some(VariantIndex(variant))));
        let shared = SharedExposure::new(each.to_vec(), (64, 64));
        let key = |scene: &Scene| shared_exposure_key(scene, &shared, (&each[0], (64, 64)));
        let measured = key(&scene);
        assert_eq!(measured, Some(each.iter().map(selection_key).collect()));
        scene.materials[1].is_shadow_catcher = true;
        assert_ne!(key(&scene), measured);
        // A catcher of all variants is in the hash of each.
        scene.materials[0].is_shadow_catcher = true;
        assert_eq!(key(&scene), measured);
    }
}
