//! Image-based lights of a file that clips rotate and scale, beside still ones.

use std::f32::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::{Quat, Vec3};
use rayframe::render::{EnvSamples, Integrator};
use rayframe::scene::{
    AnimationTarget, CubeLevel, Environment, ImageLight, ImageLightIndex, ImageLightProperty, Material,
    Projection, SelectedCamera,
};
use rayframe::sequence::{SequenceJob, render_hash};

use crate::closed_spaces::{ALBEDO, box_with_hole, painted_box};
use crate::environment_shares::{brightness, camera_at};
use crate::stage::{Stage, animate, lambert, rectangle, select_all, sequence_job};

/// The job lit by an image-based light of the file, of radiance 1 above and 0 below. A clip moves `property` of it from `from` at 0 s to `to` at 1 s.
fn lit_by_image(job: &SequenceJob, property: ImageLightProperty, [from, to]: [&[f32]; 2]) -> SequenceJob {
    let index = ImageLightIndex(0);
    let level = CubeLevel { size: 1, faces: [0.5, 0.5, 1.0, 0.0, 0.5, 0.5].map(|face| vec![[face; 3]]) };
    // E(n) = π (1 + n.y) / 2 in the harmonics Y₀₀ and Y₁₋₁
    let (mean, slope) = (PI / 2.0 * (4.0 * PI).sqrt(), PI / 2.0 * (4.0 * PI / 3.0).sqrt());
    let mut irradiance = [Vec3::ZERO; 9];
    (irradiance[0], irradiance[1]) = (Vec3::splat(mean), Vec3::splat(slope));
    let levels = vec![level.clone(), level];
    let light = ImageLight { name: None, intensity: 1.0, rotation: Quat::IDENTITY, irradiance, levels };
    let mut job = job.clone();
    let scene = Arc::make_mut(&mut job.scene);
    scene.image_lights.push(light);
    animate(scene, AnimationTarget::ImageLight(index, property), from, to);
    job.selection = select_all(&job.scene, job.selection.camera);
    job.selection.image_light = Some(index);
    with_image_light(job)
}

/// The job in the image-based light of its scene.
fn with_image_light(mut job: SequenceJob) -> SequenceJob {
    let moves = job.selection.moves_image_light(&job.scene);
    job.environment = Environment::of_image_light(&job.scene.image_lights[0], ImageLightIndex(0), moves);
    job
}

/// The job in the light of its scene with that intensity and rotation, without any clip.
fn still(job: &SequenceJob, intensity: f32, rotation: Quat) -> SequenceJob {
    let mut job = job.clone();
    job.selection.clips.clear();
    let light = &mut Arc::make_mut(&mut job.scene).image_lights[0];
    (light.intensity, light.rotation) = (intensity, rotation);
    with_image_light(job)
}

#[test]
fn closed_spaces_fade_with_the_image_based_light_of_the_file() {
    // Unlit walls light the board between them, however bright the environment is.
    let sky = Material { unlit: true, double_sided: true, ..lambert(Vec3::splat(0.1)) };
    let dome = box_with_hole(&sky, &lambert(Vec3::splat(ALBEDO)), 0.8);
    let job = lit_by_image(&dome, ImageLightProperty::Intensity, [&[0.25], &[4.0]]);
    for (time_seconds, intensity) in [(0.0, 0.25), (1.0, 4.0)] {
        let found = brightness(&job, time_seconds);
        let expected = brightness(&still(&job, intensity, Quat::IDENTITY), 0.0);
        assert!((found / expected - 1.0).abs() < 0.05, "{intensity}: {found}, alone {expected}");
    }
}

#[test]
fn hashes_tell_that_the_light_of_closed_spaces_follows_the_intensity() {
    // But for what the clip animates, which the hash of the file holds, both are the same.
    let lit_box = painted_box(Vec3::splat(ALBEDO), 0.8);
    let hash = |property, keys| render_hash(&lit_by_image(&lit_box, property, keys), 0);
    let rotation = Quat::IDENTITY.to_array();
    let rotated = hash(ImageLightProperty::Rotation, [&rotation[..], &rotation[..]]);
    assert_ne!(hash(ImageLightProperty::Intensity, [&[1.0], &[2.0]]), rotated);
}

#[test]
fn closed_boxes_are_lit_by_the_image_based_light_as_clips_rotate_it() {
    // The clip holds the light upside down: none comes in at the top.
    let upside_down = Quat::from_xyzw(1.0, 0.0, 0.0, 0.0);
    let keys = upside_down.to_array();
    let lit_box = painted_box(Vec3::splat(ALBEDO), 0.8);
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let mut job = lit_by_image(&lit_box, ImageLightProperty::Rotation, [&keys, &keys]);
        job.render.integrator = integrator;
        let jobs = [&job, &still(&job, 1.0, upside_down), &still(&job, 1.0, Quat::IDENTITY)];
        let [found, expected, upright] = jobs.map(|job| brightness(job, 0.0));
        assert!((found - expected).abs() < 0.03 * upright, "{integrator:?}: {found}, alone {expected}");
        assert!(found < 0.5 * upright, "{integrator:?}: {found}, upright {upright}");
    }
}

/// A floor with a wall beside the seen point, towards +X.
fn beside_wall(integrator: Integrator) -> SequenceJob {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::Z * 9.0, Vec3::X * 9.0), lambert(Vec3::splat(ALBEDO)));
    let wall = Material { double_sided: true, ..lambert(Vec3::ZERO) };
    stage.add(rectangle(Vec3::new(0.3, 1.0, 0.0), Vec3::Z * 9.0, Vec3::Y), wall);
    let projection =
        Projection::Perspective { fov_y_radians: 1e-3, aspect_ratio: None, z_near: 0.0, z_far: None };
    let world_from_camera = camera_at(Vec3::new(-1.0, 3.0, 0.5), Vec3::ZERO);
    let camera = SelectedCamera::Fixed { world_from_camera, projection };
    let mut job = sequence_job(stage.scene, camera, (8, 8), Path::new("unused.exr"));
    job.render.integrator = integrator;
    job.render.env_samples = EnvSamples::Fixed(1);
    job.render.samples = 64;
    job
}

#[test]
fn rotated_and_scaled_lights_cast_the_shadows_of_still_ones() {
    // The bright side is turned towards the wall, which hides it, or away from it.
    let half = 0.5_f32.sqrt();
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let [hidden, seen] = [-half, half].map(|z| {
            let rotation = Quat::from_xyzw(0.0, 0.0, z, half);
            let keys = rotation.to_array();
            let property = ImageLightProperty::Rotation;
            let job = lit_by_image(&beside_wall(integrator), property, [&keys, &keys]);
            let (found, expected) = (brightness(&job, 0.0), brightness(&still(&job, 1.0, rotation), 0.0));
            assert!((found / expected - 1.0).abs() < 0.03, "{integrator:?} {z}: {found}, still {expected}");
            expected
        });
        assert!(hidden < 0.75 * seen, "{integrator:?}: {hidden} {seen}");
        let job = lit_by_image(&beside_wall(integrator), ImageLightProperty::Intensity, [&[0.0], &[4.0]]);
        let expected = brightness(&still(&job, 2.0, Quat::IDENTITY), 0.0);
        let [dark, found] = [0.0, 0.5].map(|time_seconds| brightness(&job, time_seconds));
        assert_eq!(dark, 0.0);
        assert!((found / expected - 1.0).abs() < 0.01, "{integrator:?}: {found}, still {expected}");
    }
}
