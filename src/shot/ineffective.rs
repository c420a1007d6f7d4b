//! Settings that are given and have no effect on a job.

use crate::count_text::counted;
use crate::error::Warning;
use crate::image::PlateFit;
use crate::render::{EnvSamples, FIRST_DECISION, Integrator, LightSize};
use crate::scene::{CameraRequest, Environment, Light, LightKind, Orbit, SelectedCamera};
use crate::sequence::{Exposure, FIRST_SAMPLES, OutputFormat, Plates, SequenceJob};

use crate::settings::{GroundKind, SettingValues};

/// One warning for each setting that has no effect on this job.
pub(crate) fn ineffective_settings(values: &SettingValues, job: &SequenceJob) -> Vec<Warning> {
    let lights = job.selection.lights(&job.scene);
    let is_sun = |light: &&Light| matches!(light.kind, LightKind::Directional);
    let has_sun = lights.iter().any(is_sun) || has_key_light(job);
    let is_seen =
        job.preview || job.output.format() != OutputFormat::Exr || job.sequence_outputs.needs_tone_mapping();
    let ineffective = [
        (
            values.env_intensity != 1.0 && is_dark(&job.environment),
            "env_intensity",
            "no environment is in use",
        ),
        (
            values.noise.is_some() && values.samples <= FIRST_DECISION,
            "noise",
            "pixels first decide after 32 samples, and take no more than `samples`; set that to 4096, say",
        ),
        (
            values.time_limit.is_some() && values.samples <= FIRST_SAMPLES,
            "time_limit",
            "the first 4 samples are always taken, and `samples` asks for no more; set that to 4096, say",
        ),
        (values.light_scale != 1.0 && lights.is_empty(), "light_scale", "the scene places no light"),
        (
            values.light_radius != 0.0 && lights.iter().all(is_sun),
            "light_radius",
            "the scene places no point or spot light",
        ),
        (values.sun_angle != 0.0 && !has_sun, "sun_angle", "the scene places no directional light"),
        (
            values.env_samples != EnvSamples::Auto && !job.environment.is_lit(),
            "env_samples",
            "no environment lights the scene",
        ),
        (values.shutter.is_some() && !moves(job), "shutter", "nothing moves"),
        (
            values.shutter.is_some() && moves(job) && values.time_samples == 1,
            "shutter",
            "`time_samples` is 1, and one time has no motion",
        ),
        (
            values.background_fit != PlateFit::Fill && job.plates.is_none(),
            "background_fit",
            "the background is no image",
        ),
        (
            values.split_aovs && job.exr.split_aovs().is_empty(),
            "split_aovs",
            "the EXR files have no AOVs; name some with `aovs`",
        ),
        (
            job.exposure != Exposure::Auto && !is_seen && !job.render.decides_by_display_values(),
            "exposure",
            "EXR files hold light as it is; add `preview`",
        ),
        (values.tone.is_some() && !is_seen, "tone", "EXR files hold light as it is; add `preview`"),
    ];
    let warning =
        |(_, setting, why): (bool, &str, &str)| Warning::of_file(format!("`{setting}` does nothing: {why}"));
    let all = of_camera(values).into_iter().chain(ineffective);
    let ineffective = all.filter(|(is_ineffective, ..)| *is_ineffective).map(warning);
    let stage = ground_without_shadows(values, job);
    let infinite = infinite_lights(&lights, job.render.light_scale);
    ineffective.chain(stage).chain(equal_frames(job)).chain(infinite).collect()
}

/// Settings of the camera: whether each has no effect, its name, and why.
fn of_camera(values: &SettingValues) -> [(bool, &'static str, &'static str); 2] {
    [
        (
            values.elevation != Orbit::THREE_QUARTER.elevation_degrees && starts_from_camera(values),
            "elevation",
            "the turntable starts from the camera that `camera` names",
        ),
        (
            values.frame_node.is_some() && has_decided_camera(values),
            "frame_node",
            "`camera_position` and `look_at` decide what is seen",
        ),
    ]
}

/// Whether a turntable starts from a camera of the file.
fn starts_from_camera(values: &SettingValues) -> bool {
    let is_named = matches!(values.camera, Some(CameraRequest::Camera(_) | CameraRequest::Each));
    values.turntable.is_some() && values.frame_node.is_none() && is_named
}

/// Whether position and target of the camera are given, and it has no planes of a camera of the file, which framing removes.
fn has_decided_camera(values: &SettingValues) -> bool {
    let keeps_camera = matches!(values.camera, Some(CameraRequest::Camera(_) | CameraRequest::Each));
    values.camera_position.is_some() && values.look_at.is_some() && !keeps_camera
}

/// Whether the environment brings a directional light.
fn has_key_light(job: &SequenceJob) -> bool {
    let has_peaks = job.render.integrator == Integrator::Whitted && !job.environment.peaks().is_empty();
    has_peaks || job.environment.key_light().is_some()
}

/// Note of lights that `light_scale` makes infinite: pixels that are not finite are black, and paths leave such lights out.
fn infinite_lights(lights: &[&Light], light_scale: f32) -> Option<Warning> {
    let count = lights.iter().filter(|light| !(light.intensity * light_scale).is_finite()).count();
    (count > 0).then(|| {
        let lights = counted(count, "light");
        Warning::of_file(format!(
            "`light_scale` takes the intensity of {lights} beyond 3.4e38, the largest number: its light is missing, or what it lights is black; lower it"
        ))
    })
}

/// Note that no light casts a shadow on the ground.
fn ground_without_shadows(values: &SettingValues, job: &SequenceJob) -> Option<Warning> {
    let has_lamps = job.render.light_scale > 0.0 && job.selection.has_lights(&job.scene);
    let traces_environment =
        job.render.integrator == Integrator::Path || job.render.env_samples != EnvSamples::Fixed(0);
    let casts_shadows = has_lamps || has_key_light(job) || traces_environment && job.environment.is_lit();
    (values.ground != GroundKind::None && !casts_shadows).then(|| {
        Warning::of_file(format!(
            "`ground` shows no shadow: no light casts one; add a light to the scene, or light it with `env` studio{}",
            if job.render.env_samples == EnvSamples::Fixed(0) { " and without `env_samples`" } else { "" }
        ))
    })
}

/// A warning about several frames of a scene in which nothing moves, before one plate or none.
fn equal_frames(job: &SequenceJob) -> Option<Warning> {
    let count = job.frames.len();
    let but_for_noise = if changes_noise(job) { " but for noise" } else { "" };
    let message = || {
        format!(
            "nothing moves, so that all {count} frames are equal{but_for_noise}; `turntable` {count} turns the camera"
        )
    };
    let changes_plate = job.plates.as_ref().is_some_and(Plates::differ);
    (count > 1 && !moves(job) && !changes_plate).then(|| Warning::of_file(message()))
}

fn is_dark(environment: &Environment) -> bool {
    match environment {
        Environment::None => true,
        Environment::Composed(composed) => is_dark(&composed.light),
        _ => false,
    }
}

/// Whether anything has noise of its own in every frame: lenses, sized lights, rough lobes, what only receives shadows and is seen in a mirror, and
/// paths on demand. Paths have the points of their own sequence for lights, but not on what only receives shadows.
fn changes_noise(job: &SequenceJob) -> bool {
    let settings = &job.render;
    let has_sized_lights = settings.light_size != LightSize::default();
    let has_catchers = || job.scene.materials.iter().any(|material| material.is_shadow_catcher);
    let has_receivers = settings.ground.is_some() || has_catchers();
    let traces_environment = settings.env_samples != EnvSamples::Fixed(0) && job.environment.is_lit();
    settings.lens.is_some()
        || match settings.integrator {
            Integrator::Path => settings.path.seed_per_frame || has_sized_lights && has_receivers,
            Integrator::Whitted => {
                let is_mirrored = has_receivers && traces_environment && settings.max_depth > 0;
                has_sized_lights || settings.glossy_samples > 0 || is_mirrored
            }
        }
}

/// Whether the camera turns or follows a path, or any selected clip changes anything.
pub(super) fn moves(job: &SequenceJob) -> bool {
    if matches!(job.selection.camera, SelectedCamera::Turntable(_) | SelectedCamera::Path(_)) {
        return true;
    }
    let clips = job.selection.clips.iter().filter_map(|clip| job.scene.animations.get(clip.index()));
    clips.flat_map(|clip| &clip.channels).any(|channel| !channel.keyframes.are_constant())
}
