//! Options that were given and have nothing to act on.

use crate::error::Warning;
use crate::scene::{Environment, LightKind, Scene, Selection};
use crate::sequence::{Exposure, OutputFormat, SequenceJob};

use super::render_args::RenderArgs;

/// One line for each option that does nothing for this job.
pub fn idle_options(args: &RenderArgs, job: &SequenceJob) -> Vec<Warning> {
    let lights = light_kinds(&job.scene, &job.selection);
    let is_sun = |kind: &LightKind| matches!(kind, LightKind::Directional);
    let has_sun = lights.iter().any(is_sun) || job.environment.key_light().is_some();
    let is_seen =
        job.preview || job.output.format() == OutputFormat::Png || job.sequence_outputs.needs_tone_mapping();
    let idle = [
        (
            args.env_intensity != 1.0 && is_dark(&job.environment),
            "--env-intensity",
            "no environment is in use",
        ),
        (args.light_scale != 1.0 && lights.is_empty(), "--light-scale", "the scene places no light"),
        (
            args.light_radius != 0.0 && lights.iter().all(is_sun),
            "--light-radius",
            "the scene places no point or spot light",
        ),
        (args.sun_angle != 0.0 && !has_sun, "--sun-angle", "the scene places no directional light"),
        (args.shutter.is_some() && !moves(job), "--shutter", "nothing moves"),
        (
            args.split_aovs && job.exr.split_aovs().is_empty(),
            "--split-aovs",
            "the EXR files hold the picture alone; name layers with --layers",
        ),
        (
            job.exposure != Exposure::Auto && !is_seen,
            "--exposure",
            "EXR files hold light as it is; add --preview png",
        ),
        (args.tone.is_some() && !is_seen, "--tone", "EXR files hold light as it is; add --preview png"),
    ];
    let warning = |(_, option, why): (bool, &str, &str)| Warning {
        pointer: String::new(),
        message: format!("{option} does nothing: {why}"),
    };
    idle.into_iter().filter(|(is_idle, ..)| *is_idle).map(warning).collect()
}

fn is_dark(environment: &Environment) -> bool {
    match environment {
        Environment::None => true,
        Environment::Composed(composed) => is_dark(&composed.light),
        _ => false,
    }
}

/// Whether any selected clip has two keys for anything.
fn moves(job: &SequenceJob) -> bool {
    let clips = job.selection.clips.iter().filter_map(|clip| job.scene.animations.get(clip.index()));
    clips.flat_map(|clip| &clip.channels).any(|channel| channel.keyframes.times_seconds.len() > 1)
}

/// The kind of every light that is placed below the selected roots.
fn light_kinds(scene: &Scene, selection: &Selection) -> Vec<LightKind> {
    let mut kinds = Vec::new();
    let mut pending = selection.roots.clone();
    while let Some(node) = pending.pop().and_then(|index| scene.nodes.get(index.index())) {
        let light = node.light.and_then(|light| scene.lights.get(light.index()));
        kinds.extend(light.map(|light| light.kind));
        pending.extend_from_slice(&node.children);
    }
    kinds
}
