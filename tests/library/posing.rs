//! Frames that are posed again keep what has not moved, and are as new ones.

use std::path::Path;

use glam::{Mat4, Vec3};
use rayframe::cancel::CancelFlag;
use rayframe::frame::Frame;
use rayframe::gltf::{ImportOptions, import};
use rayframe::regression::Image;
use rayframe::scene::{Projection, SelectedCamera, Selection, SelectionRequest};
use rayframe::sequence::{Plan, run};

use crate::motion_blur::moving_edge;
use crate::stage::sequence_job;

/// The order is that of no sequence: times come back, and repeat.
const TIMES: [f64; 8] = [0.0, 0.5, 0.5, 0.25, 1.0, 1.0, 0.0, 1.75];

/// Animated nodes, skins, morph targets, visibility and materials.
#[test]
fn a_frame_that_is_posed_again_is_as_a_new_one() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut moved = 0;
    for folder in ["animation", "demo", "morph", "showcase", "skin"] {
        for file in std::fs::read_dir(scenes.join(folder)).unwrap().map(|entry| entry.unwrap().path()) {
            if file.extension().is_none_or(|extension| extension != "gltf") {
                continue;
            }
            let scene = import(&file, &ImportOptions::default()).unwrap();
            let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
            let mut frame = Frame::at(&scene, &selection, TIMES[0]);
            for time in TIMES {
                let before = frame.triangles.clone();
                frame.pose_again(&scene, &selection, time);
                let expected = Frame::at(&scene, &selection, time);
                let context = format!("{} at {time} s", file.display());
                moved += usize::from(frame.triangles != before);
                assert_eq!(frame.triangles, expected.triangles, "{context}");
                assert_eq!(frame.vertices, expected.vertices, "{context}");
                assert!(frame.flags == expected.flags, "{context}");
                assert_eq!(frame.instance_of_triangle, expected.instance_of_triangle, "{context}");
                assert_eq!(frame.instances, expected.instances, "{context}");
                assert_eq!(frame.materials, expected.materials, "{context}");
                assert_eq!(frame.lights, expected.lights, "{context}");
                assert_eq!(frame.camera, expected.camera, "{context}");
                assert!(frame.image_light == expected.image_light, "{context}");
            }
        }
    }
    assert!(moved > 40, "{moved} poses moved");
}

#[test]
fn parts_of_a_scene_are_those_of_the_frame_where_a_clip_plays() {
    let folder = tempfile::tempdir().unwrap();
    let parts = |name: &str, plays: bool| {
        let output = folder.path().join(format!("{name}.####.exr"));
        let mut job = sequence_job(moving_edge(), SelectedCamera::Auto, (4, 4), &output);
        job.frames = vec![0, 6];
        if !plays {
            job.selection.clips.clear();
        }
        let plan = Plan::new(&job).unwrap();
        plan.prepare().unwrap();
        run(&job, &plan, &CancelFlag::new(), &|_| ()).outcome().unwrap();
        [0, 6].map(|frame| {
            let path = folder.path().join(format!("{name}.{frame:04}.exr"));
            Image::read(&path).unwrap().scene.parts.unwrap()
        })
    };
    let [[still, later], [first, moved]] = [parts("still", false), parts("moving", true)];
    // The clip begins where the node is.
    assert_eq!((&later, &first), (&still, &still));
    assert_ne!(moved.geometry, still.geometry);
    assert_eq!((moved.materials, moved.lights), (still.materials, still.lights));
}

#[test]
fn bytes_depend_on_neither_threads_nor_the_order_of_frames() {
    let folder = tempfile::tempdir().unwrap();
    // Four tiles, and an edge that moves through them
    let camera = SelectedCamera::Fixed {
        world_from_camera: Mat4::from_translation(Vec3::new(0.1, 0.0, 5.0)),
        projection: Projection::Orthographic { x_mag: 0.2, y_mag: 0.15, z_near: 0.0, z_far: 10.0 },
    };
    let bytes = |name: &str, frames: &[i64], threads: usize| {
        let output = folder.path().join(name);
        let mut job = sequence_job(moving_edge(), camera.clone(), (40, 30), &output);
        job.frames = frames.to_vec();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let plan = Plan::new(&job).unwrap();
        pool.install(|| run(&job, &plan, &CancelFlag::new(), &|_| ())).outcome().unwrap();
        std::fs::read(job.output.path(2)).unwrap()
    };
    let alone = bytes("a.####.exr", &[2], 1);
    assert!(bytes("b.####.exr", &[1, 2], 2) == alone);
    assert!(bytes("c.####.exr", &[3, 2, 1], 8) == alone);
    // A twelfth of a second: the edge is at 0.083 m of 0.4 m, from −0.1 m.
    let image = Image::read(&folder.path().join("a.0002.exr")).unwrap();
    let row: Vec<f32> = image.rgba().unwrap()[..40].iter().map(|pixel| pixel[0]).collect();
    let white = row.iter().filter(|value| **value == 1.0).count();
    assert!((17..=19).contains(&white) && row.is_sorted_by(|a, b| a >= b), "{row:?}");
}
