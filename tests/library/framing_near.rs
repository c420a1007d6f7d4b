//! Cameras close to what they frame.

use glam::Vec3;
use rayframe::framing::NamedView;
use rayframe::scene::{LensRequest, SelectedCamera, ViewRequest};

use crate::framing::{assert_all_ahead, assert_fits, cubes, resolve};
use crate::stage::{Stage, cuboid, lambert};

#[test]
fn very_wide_cameras_stand_before_the_nearest_point() {
    let scene = cubes(&[(Vec3::ZERO, 0.5)]);
    for degrees in [100.0, 160.0, 175.0] {
        let request = ViewRequest { lens: Some(LensRequest::FieldOfView(degrees)), ..ViewRequest::default() };
        let camera = resolve(&scene, &request, 1.0);
        let SelectedCamera::Fixed { world_from_camera, .. } = camera.selection.camera else { panic!() };
        let from_corner = world_from_camera.w_axis.truncate().distance(Vec3::splat(0.5));
        assert!(from_corner > 1e-3, "{degrees}: {from_corner}");
        assert_all_ahead(&scene, &camera);
    }
}

#[test]
fn thin_objects_seen_end_on_fill_the_image() {
    let mut stage = Stage::new();
    stage.add(cuboid(Vec3::ZERO, Vec3::new(0.01, 0.01, 5.0)), lambert(Vec3::ONE));
    let front = ViewRequest { orbit: Some(NamedView::Front.orbit()), ..ViewRequest::default() };
    assert_fits(&stage.scene, &resolve(&stage.scene, &front, 1.0), 1.0);
}
