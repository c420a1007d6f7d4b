//! An open shutter sees the mean over its time.

use std::path::PathBuf;

use glam::{Mat4, Quat, Vec3, Vec4};
use rayframe::bvh::BuildSettings;
use rayframe::cancel::CancelFlag;
use rayframe::color::ToneCurve;
use rayframe::film::PixelWindow;
use rayframe::output::ExrOutput;
use rayframe::regression::Image;
use rayframe::render::RenderSettings;
use rayframe::scene::{
    Animation, AnimationIndex, AnimationTarget, Channel, Environment, Interpolation, Keyframes,
    LocalTransform, Material, MaterialIndex, Mesh, MeshIndex, Node, NodeIndex, Primitive, Projection, Scene,
    SelectedCamera, Selection,
};
use rayframe::sequence::{
    ExistingFiles, Exposure, FrameRate, OutputPattern, Plan, Presentation, SequenceJob, Shutter, run,
};

/// White where x < 0, moving by one metre along x in the second from 0 to 1.
fn moving_edge() -> Scene {
    let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let primitive = Primitive {
        positions: vec![at(-9.0, -9.0), at(0.0, -9.0), at(0.0, 9.0), at(-9.0, 9.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: MaterialIndex(0),
        ..Primitive::default()
    };
    let still = LocalTransform::Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };
    let keyframes = Keyframes {
        times_seconds: vec![0.0, 1.0],
        values: vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        width: 3,
        interpolation: Interpolation::Linear,
    };
    Scene {
        path: PathBuf::from("edge.gltf"),
        nodes: vec![Node { mesh: Some(MeshIndex(0)), local: still, ..Node::default() }],
        node_order: vec![NodeIndex(0)],
        meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
        materials: vec![Material { base_color: Vec4::ONE, unlit: true, ..Material::default() }],
        animations: vec![Animation {
            name: None,
            channels: vec![Channel { target: AnimationTarget::Translation(NodeIndex(0)), keyframes }],
        }],
        ..Scene::default()
    }
}

/// Eight pixels in a row from x = 0 to x = 1 m, at frame 1 of two a second: half a second.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn picture(shutter: Shutter, samples: u32) -> Vec<f32> {
    let folder = tempfile::tempdir().unwrap();
    let camera = SelectedCamera::Fixed {
        world_from_camera: Mat4::from_translation(Vec3::new(0.5, 0.0, 5.0)),
        projection: Projection::Orthographic { x_mag: 0.5, y_mag: 0.0625, z_near: 0.0, z_far: 10.0 },
    };
    let job = SequenceJob {
        scene: moving_edge(),
        selection: Selection {
            image_light: None,
            variant: None,
            roots: vec![NodeIndex(0)],
            clips: vec![AnimationIndex(0)],
            camera,
        },
        environment: Environment::None,
        environment_key: String::new(),
        frames: vec![1],
        rate: FrameRate::parse("2").unwrap(),
        shutter,
        render: RenderSettings {
            resolution: (8, 1),
            window: PixelWindow::full(8, 1),
            samples,
            ..RenderSettings::default()
        },
        build: BuildSettings::default(),
        output: OutputPattern::parse(folder.path().join("a.####.exr").as_os_str()).unwrap(),
        exr: ExrOutput::default(),
        preview: false,
        presentation: Presentation::default(),
        exposure: Exposure::Auto,
        tone: ToneCurve::Standard,
        existing: ExistingFiles::Protect,
        keep_going: false,
        strict: false,
        max_memory_bytes: 1 << 30,
    };
    let plan = Plan::new(&job).unwrap();
    plan.prepare().unwrap();
    run(&job, &plan, &CancelFlag::new(), &|_| ()).outcome().unwrap();
    let picture = Image::read(&folder.path().join("a.0001.exr")).unwrap();
    picture.rgba().unwrap().iter().map(|pixel| pixel[0]).collect()
}

#[test]
fn a_closed_shutter_shows_the_frames_own_time() {
    // The edge is at 0.5 m: four white pixels, four black ones.
    assert_eq!(picture(Shutter::default(), 4), [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn a_moving_edge_is_a_ramp_as_long_as_its_way() {
    // Open for one frame of half a second around 0.5 s the edge goes from 0.25 to 0.75 m: pixels 2 to 5. The pixel from x to
    // x + 1/8 is white as long as the edge is beyond it: 7/8, 5/8, 3/8 and 1/8 of the time on average.
    let expected = [1.0, 1.0, 0.875, 0.625, 0.375, 0.125, 0.0, 0.0];
    for (time_samples, samples) in [(64, 1), (16, 64)] {
        let seen = picture(Shutter { open: 1.0, time_samples }, samples);
        for (pixel, (seen, expected)) in seen.iter().zip(expected).enumerate() {
            assert!(
                (seen - expected).abs() < 0.04,
                "{time_samples}: pixel {pixel}: {seen} is not {expected}"
            );
        }
    }
}
