//! A square in front of a camera, either of which moves.

use glam::{Mat4, Quat, Vec2, Vec3, Vec4};
use rayframe::bvh::{BuildSettings, Builder};
use rayframe::cancel::CancelFlag;
use rayframe::film::{AovFlags, Film, PixelCenterSample, PixelWindow};
use rayframe::frame::Frame;
use rayframe::render::{AdjacentFrames, SceneView, render_pixel_centers};
use rayframe::scene::{
    Animation, AnimationIndex, AnimationTarget, Camera, CameraIndex, Channel, Environment, Interpolation,
    Keyframes, Material, MaterialIndex, Mesh, MeshIndex, Node, NodeIndex, Primitive, Projection, Scene,
    SelectedCamera, Selection,
};

/// The picture, pixels.
pub(crate) const SIZE: (u32, u32) = (40, 20);
/// Seconds from one frame to the next.
pub(crate) const STEP: f64 = 0.25;

/// The square's node, the camera's, and a spare one.
pub(crate) const SQUARE: NodeIndex = NodeIndex(0);
pub(crate) const CAMERA: NodeIndex = NodeIndex(1);
pub(crate) const SPARE: NodeIndex = NodeIndex(2);

/// Shows 10 pixels a metre.
pub(crate) const PARALLEL: Projection =
    Projection::Orthographic { x_mag: 2.0, y_mag: 1.0, z_near: 0.0, z_far: 100.0 };

/// Half the picture's height is as high as it is far away: 10 pixels a metre at one metre.
pub(crate) const PINHOLE: Projection = Projection::Perspective {
    fov_y_radians: std::f32::consts::FRAC_PI_2,
    aspect_ratio: None,
    z_near: 0.0,
    z_far: None,
};

/// The camera at the origin looks along −Z at a square with edges of two metres, `distance` metres away, which does not
/// fill the picture.
pub(crate) fn square(projection: Projection, distance: f32) -> Scene {
    let at = |x: f32, y: f32| Vec3::new(x, y, -distance);
    let primitive = Primitive {
        positions: vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)],
        uvs: vec![[(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)].map(|(u, v)| Vec2::new(u, v)).to_vec()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: MaterialIndex(0),
        ..Primitive::default()
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

/// Adds a clip whose only channel goes from `from` at 0 s to `to` at 1 s.
pub(crate) fn animate(scene: &mut Scene, target: AnimationTarget, from: &[f32], to: &[f32]) {
    let keyframes = Keyframes {
        times_seconds: vec![0.0, 1.0],
        values: [from, to].concat(),
        width: from.len(),
        interpolation: Interpolation::Linear,
    };
    scene.animations.push(Animation { name: None, channels: vec![Channel { target, keyframes }] });
}

/// A turn around +Y.
pub(crate) fn turned(angle: f32) -> [f32; 4] {
    Quat::from_xyzw(0.0, libm::sinf(angle * 0.5), 0.0, libm::cosf(angle * 0.5)).to_array()
}

/// What the middles of pixels show of frame `frame`.
#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
pub(crate) fn centres(scene: &Scene, frame: i32) -> Vec<PixelCenterSample> {
    let selection = Selection {
        roots: scene.node_order.clone(),
        clips: (0..scene.animations.len() as u32).map(AnimationIndex).collect(),
        camera: SelectedCamera::Node(CAMERA),
        image_light: None,
        variant: None,
    };
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

/// Each pixel's middle on the plane one metre in front of a pinhole (or of parallel rays), +Y up, with its sample.
pub(crate) fn on_plane(samples: &[PixelCenterSample]) -> impl Iterator<Item = (Vec2, &PixelCenterSample)> {
    samples.iter().enumerate().map(|(subscript, sample)| {
        let (x, y) = (subscript as u32 % SIZE.0, subscript as u32 / SIZE.0);
        let right = (x as f32 + 0.5) / 10.0 - 2.0;
        let up = 1.0 - (y as f32 + 0.5) / 10.0;
        (Vec2::new(right, up), sample)
    })
}

/// A matrix that places something.
pub(crate) fn placed(x: f32, y: f32, z: f32) -> Mat4 {
    Mat4::from_translation(Vec3::new(x, y, z))
}
