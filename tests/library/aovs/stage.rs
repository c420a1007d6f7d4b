//! A square in front of a camera; tests move either.

use glam::{Mat4, Quat, Vec2, Vec3, Vec4};
use rayframe::bvh::{BuildSettings, Builder};
use rayframe::cancel::CancelFlag;
use rayframe::film::{AovFlags, Film, PixelCenterSample, PixelWindow};
use rayframe::frame::Frame;
use rayframe::render::{AdjacentFrames, SceneView, render_pixel_centers};
use rayframe::scene::{
    Camera, CameraIndex, Environment, Material, Mesh, MeshIndex, Node, NodeIndex, Primitive, Projection,
    Scene, SelectedCamera,
};

use crate::stage::{rectangle, select_all};

/// Resolution, pixels.
pub(crate) const SIZE: (u32, u32) = (40, 20);
/// Time from one frame to the next, seconds.
pub(crate) const STEP: f64 = 0.25;

/// Nodes of the square and the camera, and a spare one.
pub(crate) const SQUARE: NodeIndex = NodeIndex(0);
pub(crate) const CAMERA: NodeIndex = NodeIndex(1);
pub(crate) const SPARE: NodeIndex = NodeIndex(2);

/// Orthographic, 10 pixels a metre.
pub(crate) const PARALLEL: Projection =
    Projection::Orthographic { x_mag: 2.0, y_mag: 1.0, z_near: 0.0, z_far: 100.0 };

/// A field of view of 90°: 10 pixels a metre at a distance of one metre.
pub(crate) const PINHOLE: Projection = Projection::Perspective {
    fov_y_radians: std::f32::consts::FRAC_PI_2,
    aspect_ratio: None,
    z_near: 0.0,
    z_far: None,
};

/// A camera at the origin that looks along −Z at a square with edges of two metres, `distance` metres away. The square does
/// not fill the image.
pub(crate) fn square(projection: Projection, distance: f32) -> Scene {
    let primitive = Primitive {
        uvs: vec![[(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)].map(|(u, v)| Vec2::new(u, v)).to_vec()],
        ..rectangle(Vec3::NEG_Z * distance, Vec3::X, Vec3::Y)
    };
    Scene {
        nodes: vec![
            Node { mesh: Some(MeshIndex(0)), ..Node::default() },
            Node { camera: Some(CameraIndex(0)), ..Node::default() },
            Node::default(),
        ],
        node_order: vec![SQUARE, CAMERA, SPARE],
        meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
        cameras: vec![Camera { name: None, projection }],
        materials: vec![Material { base_color: Vec4::new(0.2, 0.4, 0.6, 1.0), ..Material::default() }],
        ..Scene::default()
    }
}

/// A rotation around +Y as a quaternion.
pub(crate) fn rotation_y(angle: f32) -> [f32; 4] {
    Quat::from_xyzw(0.0, libm::sinf(angle * 0.5), 0.0, libm::cosf(angle * 0.5)).to_array()
}

/// Pixel-centre samples of frame `frame`.
#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
pub(crate) fn pixel_centers(scene: &Scene, frame: i32) -> Vec<PixelCenterSample> {
    let selection = select_all(scene, SelectedCamera::Node(CAMERA));
    let at = |frame: i32| Frame::at(scene, &selection, f64::from(frame) * STEP);
    let (before, now, after) = (at(frame - 1), at(frame), at(frame + 1));
    let cancel = CancelFlag::new();
    let build = BuildSettings::default();
    let bvh = Builder::default().build(&now.triangles, &now.flags, &build, &cancel, None).unwrap();
    let input = SceneView { scene, frame: &now, bvh: &bvh, environment: &Environment::None };
    let request = AovFlags { centers: true, ..AovFlags::NONE };
    let mut film = Film::with_aovs(SIZE, PixelWindow::full(SIZE.0, SIZE.1), request);
    render_pixel_centers(&mut film, &input, AdjacentFrames { before: &before, after: &after }, &cancel)
        .unwrap();
    film.aovs.centers.unwrap()
}

/// The samples with the centres of their pixels on the plane one metre in front of the camera, +Y up.
pub(crate) fn on_plane(samples: &[PixelCenterSample]) -> impl Iterator<Item = (Vec2, &PixelCenterSample)> {
    samples.iter().enumerate().map(|(index, sample)| {
        let (x, y) = (index as u32 % SIZE.0, index as u32 / SIZE.0);
        let right = (x as f32 + 0.5) / 10.0 - 2.0;
        let up = 1.0 - (y as f32 + 0.5) / 10.0;
        (Vec2::new(right, up), sample)
    })
}

/// A translation matrix.
pub(crate) fn translation(x: f32, y: f32, z: f32) -> Mat4 {
    Mat4::from_translation(Vec3::new(x, y, z))
}
