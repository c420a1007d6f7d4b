//! Motion blur: an open shutter records the mean over its time.

use glam::{Mat4, Vec3, Vec4};
use rayframe::cancel::CancelFlag;
use rayframe::film::LightPass;
use rayframe::output::{Aov, AovSet, ExrOutput};
use rayframe::regression::Image;
use rayframe::render::{Adaptive, Integrator, PixelFilter};
use rayframe::scene::{
    AnimationTarget, LightKind, Material, Mesh, MeshIndex, Node, NodeIndex, Projection, Scene, SelectedCamera,
};
use rayframe::sequence::{ExistingFiles, FrameRate, Plan, Shutter, run};

use crate::stage::{Stage, animate, lambert, rectangle, sequence_job, unlit};

/// A white half plane x < 0 that moves by one metre along x from 0 s to 1 s.
pub(crate) fn moving_edge() -> Scene {
    let mut scene = Scene {
        nodes: vec![Node { mesh: Some(MeshIndex(0)), ..Node::default() }],
        node_order: vec![NodeIndex(0)],
        meshes: vec![Mesh {
            primitives: vec![rectangle(Vec3::X * -4.5, Vec3::X * 4.5, Vec3::Y * 9.0)],
            ..Mesh::default()
        }],
        materials: vec![Material { base_color: Vec4::ONE, unlit: true, ..Material::default() }],
        ..Scene::default()
    };
    animate(&mut scene, AnimationTarget::Translation(NodeIndex(0)), &[0.0; 3], &[1.0, 0.0, 0.0]);
    scene
}

/// Renders eight pixels in a row from x = 0 to x = 1 m, of frame 1 at 2 fps: 0.5 s.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(shutter: Shutter, samples: u32) -> Vec<f32> {
    let folder = tempfile::tempdir().unwrap();
    let camera = SelectedCamera::Fixed {
        world_from_camera: Mat4::from_translation(Vec3::new(0.5, 0.0, 5.0)),
        projection: Projection::Orthographic { x_mag: 0.5, y_mag: 0.0625, z_near: 0.0, z_far: 10.0 },
    };
    let mut job = sequence_job(moving_edge(), camera, (8, 1), &folder.path().join("a.####.exr"));
    job.rate = FrameRate::parse("2").unwrap();
    job.shutter = shutter;
    job.render.samples = samples;
    let plan = Plan::new(&job).unwrap();
    plan.prepare().unwrap();
    run(&job, &plan, &CancelFlag::new(), &|_| ()).outcome().unwrap();
    let image = Image::read(&folder.path().join("a.0001.exr")).unwrap();
    image.rgba().unwrap().iter().map(|pixel| pixel[0]).collect()
}

#[test]
fn a_closed_shutter_shows_the_frames_own_time() {
    // The edge is at 0.5 m: four white pixels, four black ones.
    assert_eq!(render(Shutter::default(), 4), [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn a_moving_edge_is_a_ramp_as_long_as_its_way() {
    // Open for one frame of half a second around 0.5 s the edge goes from 0.25 to 0.75 m: pixels 2 to 5. The pixel from x to
    // x + 1/8 is white as long as the edge is beyond it: 7/8, 5/8, 3/8 and 1/8 of the time on average.
    let expected = [1.0, 1.0, 0.875, 0.625, 0.375, 0.125, 0.0, 0.0];
    for (time_samples, samples) in [(64, 1), (16, 64)] {
        let seen = render(Shutter { open: 1.0, time_samples }, samples);
        for (pixel, (seen, expected)) in seen.iter().zip(expected).enumerate() {
            assert!(
                (seen - expected).abs() < 0.04,
                "{time_samples}: pixel {pixel}: {seen} is not {expected}"
            );
        }
    }
}

/// Two pixels of an unlit surface of radiance 0.75 that fills the image.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render_uniform(
    filter: PixelFilter,
    (samples, max_samples): (u32, u32),
    shutter: Shutter,
) -> rayframe::image::Image {
    let scene = Scene {
        nodes: vec![Node { mesh: Some(MeshIndex(0)), ..Node::default() }],
        node_order: vec![NodeIndex(0)],
        meshes: vec![Mesh {
            primitives: vec![rectangle(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0)],
            ..Mesh::default()
        }],
        materials: vec![unlit(Vec3::splat(0.75))],
        ..Scene::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let camera = SelectedCamera::Fixed {
        world_from_camera: Mat4::from_translation(Vec3::Z * 5.0),
        projection: Projection::Orthographic { x_mag: 0.5, y_mag: 0.25, z_near: 0.0, z_far: 10.0 },
    };
    let mut job = sequence_job(scene, camera, (2, 1), &folder.path().join("a.####.exr"));
    let aovs = AovSet::new(&[Aov::Beauty, Aov::Light(LightPass::Emission), Aov::CryptoObject]);
    job.exr = ExrOutput { aovs, ..ExrOutput::default() };
    job.render.aovs = job.exr.aov_flags();
    job.shutter = shutter;
    job.render.filter = filter;
    job.render.samples = samples;
    let adaptive = Adaptive { max_samples, threshold: 0.05 };
    job.render.adaptive = (max_samples > samples).then_some(adaptive);
    let plan = Plan::new(&job).unwrap();
    plan.prepare().unwrap();
    run(&job, &plan, &CancelFlag::new(), &|_| ()).outcome().unwrap();
    Image::read(&folder.path().join("a.0001.exr")).unwrap()
}

#[test]
fn a_uniform_image_has_its_value_and_coverage_with_any_filter_and_shutter() {
    // The weights of Mitchell's filter are 1 and −1. Some times of the shutter have one or two samples, whose weights sum to −1 or 0.
    for filter in PixelFilter::ALL {
        for time_samples in [1, 2, 8, 16] {
            for samples in [(1, 1), (2, 2), (4, 4), (7, 7), (16, 16), (64, 64), (4, 24), (16, 32)] {
                let image = render_uniform(filter, samples, Shutter { open: 0.5, time_samples });
                let what = format!("{filter:?} {samples:?} {time_samples}");
                for pixel in image.rgba().unwrap() {
                    assert_eq!(pixel, [0.75, 0.75, 0.75, 1.0], "{what}");
                }
                for (name, expected) in [("emission.R", 0.75), ("crypto_object00.G", 1.0)] {
                    let values = image.channel(name).unwrap().samples.floats().unwrap();
                    let is_exact = |value: &f32| (value - expected).abs() < 1e-6;
                    assert!(values.iter().all(is_exact), "{what} {name}: {values:?}");
                }
            }
        }
    }
}

#[test]
fn all_times_of_a_shutter_share_one_set_of_samples() {
    // The penumbra of a square. What moves is not seen, so that an open shutter has about the noise of a closed one.
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0), lambert(Vec3::ONE));
    stage.add(rectangle(Vec3::Z * 0.5, Vec3::X * 0.3, Vec3::Y * 0.3), lambert(Vec3::ONE));
    stage.add_light(LightKind::Point, 10.0, Vec3::Z * 3.0, Vec3::Z);
    let mut scene = stage.scene;
    let moving = NodeIndex(scene.nodes.len() as u32);
    scene.nodes.push(Node::default());
    scene.node_order.push(moving);
    animate(&mut scene, AnimationTarget::Translation(moving), &[0.0; 3], &[1.0, 0.0, 0.0]);
    let camera = SelectedCamera::Fixed {
        world_from_camera: Mat4::from_translation(Vec3::Z * 5.0),
        projection: Projection::Orthographic { x_mag: 0.6, y_mag: 0.6, z_near: 0.0, z_far: 10.0 },
    };
    let folder = tempfile::tempdir().unwrap();
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let render = |shutter: Shutter, samples: u32| {
            let mut job =
                sequence_job(scene.clone(), camera.clone(), (16, 16), &folder.path().join("b.####.exr"));
            (job.shutter, job.existing) = (shutter, ExistingFiles::Overwrite);
            (job.render.samples, job.render.integrator) = (samples, integrator);
            (job.render.light_size.radius, job.render.path.seed_per_frame) = (0.3, true);
            let plan = Plan::new(&job).unwrap();
            plan.prepare().unwrap();
            run(&job, &plan, &CancelFlag::new(), &|_| ()).outcome().unwrap();
            Image::read(&folder.path().join("b.0001.exr")).unwrap().rgba().unwrap()
        };
        let converged = render(Shutter::default(), 4096);
        let squared_error = |shutter: Shutter| -> f32 {
            let pixels = render(shutter, 64);
            pixels.iter().zip(&converged).map(|(a, b)| (a[0] - b[0]) * (a[0] - b[0])).sum()
        };
        let closed = squared_error(Shutter::default());
        let open = squared_error(Shutter { open: 0.5, time_samples: 32 });
        assert!(open < 2.0 * closed, "{integrator:?}: {open} {closed}");
    }
}
