//! Cameras that frame the scene, checked against projected corners.

use glam::{Mat4, Quat, Vec2, Vec3};
use rayframe::frame::Frame;
use rayframe::framing::{CameraRule, NamedView, ResolvedCamera, resolve_camera};
use rayframe::scene::{
    AnimationTarget, Camera, CameraIndex, CameraProperty, LensRequest, LocalTransform, Node, NodeIndex,
    Orbit, Projection, Scene, SelectedCamera, Target, TurntableRequest, ViewRequest,
};

use crate::stage::{Stage, animate, cuboid, lambert, rectangle, select_all};

/// Share of half the image that the framed corners reach.
const FILLED: f32 = 0.8;

pub(crate) fn cubes(cubes: &[(Vec3, f32)]) -> Scene {
    let mut stage = Stage::new();
    for &(center, half) in cubes {
        stage.add(cuboid(center, Vec3::splat(half)), lambert(Vec3::ONE));
    }
    stage.scene
}

pub(crate) fn resolve(scene: &Scene, request: &ViewRequest, aspect_ratio: f32) -> ResolvedCamera {
    resolve_camera(scene, select_all(scene, SelectedCamera::Auto), request, aspect_ratio)
}

fn view(view: NamedView) -> ViewRequest {
    ViewRequest { orbit: Some(view.orbit()), ..ViewRequest::default() }
}

/// Largest and smallest image coordinates of all corners at `time_seconds`; −1 and 1 are the edges of the image.
pub(crate) fn image_bounds(
    scene: &Scene,
    camera: &ResolvedCamera,
    aspect_ratio: f32,
    time_seconds: f64,
) -> [Vec2; 2] {
    let frame = Frame::at(scene, &camera.selection, time_seconds);
    let camera_from_world = frame.camera.world_from_camera.inverse();
    let half = frame.camera.projection.half_size(aspect_ratio);
    let corners = frame.triangles.iter().flat_map(|triangle| triangle.vertices);
    corners.fold([Vec2::MAX, Vec2::MIN], |[min, max], corner| {
        let local = camera_from_world.transform_point3(corner);
        let depth = match frame.camera.projection {
            Projection::Perspective { .. } => -local.z,
            Projection::Orthographic { .. } => 1.0,
        };
        let image = local.truncate() / (half * depth);
        [min.min(image), max.max(image)]
    })
}

/// Asserts that the corners are in the middle of the image and reach [`FILLED`] in one direction.
#[track_caller]
pub(crate) fn assert_fits(scene: &Scene, camera: &ResolvedCamera, aspect_ratio: f32) {
    let [min, max] = image_bounds(scene, camera, aspect_ratio, 0.0);
    let reach = max.max(-min);
    assert!((reach.max_element() - FILLED).abs() < 1e-3, "{min} to {max}");
    let is_wide = reach.x > reach.y;
    let (low, high) = if is_wide { (min.x, max.x) } else { (min.y, max.y) };
    assert!((low + high).abs() < 1e-3, "{min} to {max}");
}

#[test]
fn the_front_view_of_a_cube_has_its_distance_by_hand() {
    let camera = resolve(&cubes(&[(Vec3::ZERO, 1.0)]), &view(NamedView::Front), 1.0);
    // The front face lies at z = 1 with corners at 0.8 of the half height: 1 = 0.8 tan(22.5°) (z − 1).
    let z = 1.0 + 1.0 / (FILLED * libm::tanf(std::f32::consts::FRAC_PI_8));
    let SelectedCamera::Fixed { world_from_camera, .. } = camera.selection.camera else { panic!() };
    assert!(world_from_camera.abs_diff_eq(Mat4::from_translation(Vec3::new(0.0, 0.0, z)), 1e-4));
    assert_eq!(camera.rule, CameraRule::Requested);
}

#[test]
fn every_view_fits_the_image() {
    let scene = cubes(&[(Vec3::new(3.0, 1.0, -2.0), 0.5), (Vec3::new(4.0, 2.5, -2.0), 0.25)]);
    for named in [NamedView::Back, NamedView::Left, NamedView::Right, NamedView::Top, NamedView::Bottom] {
        for aspect_ratio in [0.5, 1.0, 16.0 / 9.0] {
            assert_fits(&scene, &resolve(&scene, &view(named), aspect_ratio), aspect_ratio);
        }
    }
    let automatic = resolve(&scene, &ViewRequest::default(), 1.5);
    assert_eq!(automatic.rule, CameraRule::Outside);
    assert_fits(&scene, &automatic, 1.5);
    assert_eq!(
        automatic.selection.camera,
        resolve(&scene, &view(NamedView::ThreeQuarter), 1.5).selection.camera
    );
    // A narrow lens stands farther away and fits as well.
    let lens = Some(LensRequest::FieldOfView(10.0));
    assert_fits(&scene, &resolve(&scene, &ViewRequest { lens, ..view(NamedView::Right) }, 1.5), 1.5);
}

#[test]
fn twice_the_distance_is_half_the_size() {
    // From afar, perspective is nearly parallel.
    let scene = cubes(&[(Vec3::ZERO, 1.0)]);
    let size = |distance| {
        let orbit = Some(Orbit { azimuth_degrees: 0.0, elevation_degrees: 0.0, distance });
        let lens = Some(LensRequest::FieldOfView(1.0));
        let camera = resolve(&scene, &ViewRequest { orbit, lens, ..ViewRequest::default() }, 1.0);
        image_bounds(&scene, &camera, 1.0, 0.0)[1].y
    };
    assert!((size(1.0) / size(2.0) - 2.0).abs() < 0.02);
}

fn parallel(request: ViewRequest) -> ViewRequest {
    ViewRequest { lens: Some(LensRequest::Orthographic), ..request }
}

#[test]
fn parallel_views_fit_the_image() {
    // Nearer and farther corners are equally far from the axis, also of what is much deeper than wide.
    let mut stage = Stage::new();
    stage.add(cuboid(Vec3::new(3.0, 1.0, -4.0), Vec3::new(0.5, 0.25, 10.0)), lambert(Vec3::ONE));
    stage.add(cuboid(Vec3::new(4.0, 2.0, 0.0), Vec3::splat(0.5)), lambert(Vec3::ONE));
    let scene = stage.scene;
    for named in [NamedView::Front, NamedView::Right, NamedView::Top, NamedView::ThreeQuarter] {
        for aspect_ratio in [0.5, 1.0, 16.0 / 9.0] {
            let camera = resolve(&scene, &parallel(view(named)), aspect_ratio);
            assert_fits(&scene, &camera, aspect_ratio);
            assert_all_ahead(&scene, &camera);
        }
    }
    let automatic = resolve(&scene, &parallel(ViewRequest::default()), 1.5);
    assert_fits(&scene, &automatic, 1.5);
    let turntable = Some(TurntableRequest { elevation_degrees: None, turn_seconds: 2.0 });
    let turning = resolve(&scene, &parallel(ViewRequest { turntable, ..ViewRequest::default() }), 1.0);
    let reaches = (0..32).map(|step| {
        let [min, max] = image_bounds(&scene, &turning, 1.0, f64::from(step) / 16.0);
        max.max(-min).max_element()
    });
    let largest = reaches.fold(0.0, f32::max);
    assert!((largest - FILLED).abs() < 1e-3, "{largest}");
    assert_all_ahead(&scene, &turning);
}

/// Asserts that no corner is beside or behind the camera at the start.
#[track_caller]
pub(crate) fn assert_all_ahead(scene: &Scene, camera: &ResolvedCamera) {
    let frame = Frame::at(scene, &camera.selection, 0.0);
    let camera_from_world = frame.camera.world_from_camera.inverse();
    let corners = frame.triangles.iter().flat_map(|triangle| triangle.vertices);
    let nearest =
        corners.map(|corner| -camera_from_world.transform_point3(corner).z).fold(f32::MAX, f32::min);
    assert!(nearest > 0.0, "{nearest}");
}

#[test]
fn the_distance_of_a_parallel_view_scales_its_height() {
    let scene = cubes(&[(Vec3::ZERO, 1.0)]);
    for distance in [0.5_f32, 1.0, 3.0] {
        let orbit = Some(Orbit { azimuth_degrees: 0.0, elevation_degrees: 0.0, distance });
        let target = Some(Target::Point(Vec3::new(0.5, 0.0, 5.0)));
        for target in [None, target] {
            let request = ViewRequest { orbit, target, ..ViewRequest::default() };
            let camera = resolve(&scene, &parallel(request), 1.0);
            let [min, max] = image_bounds(&scene, &camera, 1.0, 0.0);
            assert!(((max.y - min.y) * 0.5 - FILLED / distance).abs() < 1e-4, "{distance}: {min} to {max}");
            assert_all_ahead(&scene, &camera);
        }
    }
}

/// The scene with a camera at `translation` that looks along −Z.
fn with_camera(mut scene: Scene, translation: Vec3, projection: Projection) -> Scene {
    scene.cameras.push(Camera { name: None, projection });
    let local = LocalTransform::Trs { translation, rotation: Quat::IDENTITY, scale: Vec3::ONE };
    scene.nodes.push(Node { camera: Some(CameraIndex(0)), local, ..Node::default() });
    scene.node_order.push(NodeIndex(scene.nodes.len() as u32 - 1));
    scene
}

#[test]
fn a_camera_of_the_file_gets_the_height_of_where_it_is_moved() {
    let fov_y_radians = std::f32::consts::FRAC_PI_4;
    let projection = Projection::Perspective { fov_y_radians, aspect_ratio: None, z_near: 0.1, z_far: None };
    let scene = with_camera(cubes(&[(Vec3::ZERO, 1.0)]), Vec3::new(0.0, 0.0, 8.0), projection);
    let selection = || select_all(&scene, SelectedCamera::Node(NodeIndex(1)));
    let half_height = |request: ViewRequest| {
        let request = ViewRequest { keeps_camera: true, ..parallel(request) };
        let camera = resolve_camera(&scene, selection(), &request, 1.0);
        Frame::at(&scene, &camera.selection, 0.0).camera.projection.half_size(1.0).y
    };
    let slope = libm::tanf(std::f32::consts::FRAC_PI_8);
    assert!((half_height(ViewRequest::default()) - 8.0 * slope).abs() < 1e-4);
    let position = Some(Vec3::new(0.0, 0.0, 50.0));
    assert!((half_height(ViewRequest { position, ..ViewRequest::default() }) - 50.0 * slope).abs() < 1e-3);
    // The scene is beside this camera until it looks there.
    let position = Some(Vec3::new(5.0, 0.0, 0.0));
    let target = Some(Target::Point(Vec3::ZERO));
    let looking = ViewRequest { position, target, ..ViewRequest::default() };
    assert!((half_height(looking) - 5.0 * slope).abs() < 1e-4);
    assert!((half_height(ViewRequest { position, ..ViewRequest::default() }) - 5.0 * slope).abs() < 1e-4);
    // In the middle of the scene the height is that of its size, two metres.
    let position = Some(Vec3::ZERO);
    assert!((half_height(ViewRequest { position, ..ViewRequest::default() }) - 2.0 * slope).abs() < 1e-4);
}

#[test]
fn a_turntable_shows_everything_at_all_angles() {
    let scene = cubes(&[(Vec3::new(0.0, 1.0, 0.0), 0.5), (Vec3::new(2.0, 0.5, 0.0), 0.5)]);
    let turntable = Some(TurntableRequest { elevation_degrees: None, turn_seconds: 2.0 });
    let camera = resolve(&scene, &ViewRequest { turntable, ..ViewRequest::default() }, 1.0);
    let reaches = (0..32).map(|step| {
        let [min, max] = image_bounds(&scene, &camera, 1.0, f64::from(step) / 16.0);
        max.max(-min).max_element()
    });
    let largest = reaches.fold(0.0, f32::max);
    assert!((largest - FILLED).abs() < 1e-3, "{largest}");
}

#[test]
fn what_moves_stays_in_the_image() {
    let mut scene = cubes(&[(Vec3::ZERO, 0.5)]);
    animate(&mut scene, AnimationTarget::Translation(NodeIndex(0)), &[0.0, 0.0, 0.0], &[4.0, 0.0, 0.0]);
    let camera = resolve(&scene, &ViewRequest::default(), 1.0);
    let reaches = (0..=10).map(|step| {
        let [min, max] = image_bounds(&scene, &camera, 1.0, f64::from(step) / 10.0);
        max.max(-min).max_element()
    });
    assert!((reaches.fold(0.0, f32::max) - FILLED).abs() < 1e-3);
}

#[test]
fn skies_and_grounds_do_not_shrink_the_content() {
    let content: Vec<_> = (0..12).map(|index| (Vec3::new(index as f32 * 0.1, 0.0, 0.0), 0.5)).collect();
    let expected = resolve(&cubes(&content), &ViewRequest::default(), 1.0).selection.camera;
    for sky in [(Vec3::ZERO, 100.0), (Vec3::new(40.0, -50.0, 0.0), 50.0)] {
        let scene = cubes(&[content.as_slice(), &[sky]].concat());
        assert_eq!(resolve(&scene, &ViewRequest::default(), 1.0).selection.camera, expected);
    }
    // Far smaller instances are no content of their own.
    let bolt = [(Vec3::new(3.0, 0.0, 0.0), 0.01), (Vec3::ZERO, 0.5), (Vec3::new(0.0, 2.0, 0.0), 0.5)];
    let both = resolve(&cubes(&bolt), &ViewRequest::default(), 1.0);
    let [min, max] = image_bounds(&cubes(&bolt), &both, 1.0, 0.0);
    assert!((max.max(-min).max_element() - FILLED).abs() < 1e-3, "{min} to {max}");
    // A stray triangle among many.
    let mut scene = cubes(&content);
    let primitive = &mut scene.meshes[0].primitives[0];
    let far = primitive.positions.len() as u32;
    primitive.positions.push(Vec3::splat(1e4));
    primitive.triangles.push([0, 1, far]);
    assert_eq!(resolve(&scene, &ViewRequest::default(), 1.0).selection.camera, expected);
}

/// An interior of six walls that are seen from both sides, with objects on its floor.
fn interior(objects: usize) -> Scene {
    let mut stage = Stage::new();
    let wall = rayframe::scene::Material { double_sided: true, ..lambert(Vec3::ONE) };
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let half = Vec3::new(4.0, 1.5, 3.0);
            let (mut center, mut u, mut v) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
            center[axis] = half[axis] * sign;
            u[(axis + 1) % 3] = half[(axis + 1) % 3];
            v[(axis + 2) % 3] = half[(axis + 2) % 3];
            stage.add(rectangle(center, u, v), wall.clone());
        }
    }
    for index in 0..objects {
        let center = Vec3::new(index as f32 - 2.0, -1.3, (index % 3) as f32 - 1.0);
        stage.add(cuboid(center, Vec3::splat(0.2)), lambert(Vec3::ONE));
    }
    stage.scene
}

#[test]
fn interiors_are_seen_from_inside() {
    let scene = interior(6);
    let camera = resolve(&scene, &ViewRequest::default(), 1.5);
    assert_eq!(camera.rule, CameraRule::Inside);
    let SelectedCamera::Fixed { world_from_camera, .. } = camera.selection.camera else { panic!() };
    let position = world_from_camera.w_axis.truncate();
    assert!(position.abs().cmplt(Vec3::new(4.0, 1.5, 3.0)).all(), "{position}");
    // Half of the height is below 1.6 metres.
    assert!((position.y - 0.0).abs() < 0.25, "{position}");
    // Parallel views show the whole.
    let outside = resolve(&scene, &parallel(ViewRequest::default()), 1.5);
    assert_eq!(outside.rule, CameraRule::Outside);
    assert_fits(&scene, &outside, 1.5);
    // A view that was asked for is not replaced.
    assert_eq!(resolve(&scene, &view(NamedView::ThreeQuarter), 1.5).rule, CameraRule::Requested);
}

#[test]
fn cameras_of_the_file_change_where_asked() {
    let projection = Projection::Perspective {
        fov_y_radians: 0.5,
        aspect_ratio: Some(2.0),
        z_near: 0.1,
        z_far: Some(9.0),
    };
    let scene = with_camera(cubes(&[(Vec3::ZERO, 1.0)]), Vec3::new(0.0, 0.0, 7.0), projection);
    let selection = || select_all(&scene, SelectedCamera::Node(NodeIndex(1)));
    let posed = |request: &ViewRequest| {
        let camera = resolve_camera(&scene, selection(), request, 1.0);
        (Frame::camera_at(&scene, &camera.selection, 0.0), camera.rule)
    };
    let (own, rule) = posed(&ViewRequest::default());
    assert_eq!((own.projection, rule), (projection, CameraRule::OfFile));

    let target = Some(Target::Point(Vec3::new(0.0, 7.0, 7.0)));
    let (changed, rule) = posed(&ViewRequest { target, ..ViewRequest::default() });
    assert_eq!((changed.world_from_camera.z_axis.truncate(), rule), (Vec3::NEG_Y, CameraRule::Changed));
    let (changed, _) =
        posed(&ViewRequest { target: Some(Target::Node(NodeIndex(0))), ..ViewRequest::default() });
    assert_eq!(changed.world_from_camera, own.world_from_camera);
    let lens = Some(LensRequest::FieldOfView(90.0));
    let (changed, _) = posed(&ViewRequest { lens, ..ViewRequest::default() });
    assert!((changed.projection.half_size(1.0).y - 1.0).abs() < 1e-6);

    // An orbit does not keep the camera, unless it is asked for: then it keeps its lens.
    let orbit = view(NamedView::Front);
    let height = |request: &ViewRequest| posed(request).0.projection.half_size(2.0).y;
    assert!((height(&orbit) - libm::tanf(std::f32::consts::FRAC_PI_8)).abs() < 1e-6);
    assert!((height(&ViewRequest { keeps_camera: true, ..orbit }) - libm::tanf(0.25)).abs() < 1e-6);
}

#[test]
fn rolled_views_fit_the_image() {
    let scene = cubes(&[(Vec3::new(3.0, 1.0, -2.0), 0.5), (Vec3::new(5.0, 1.5, -2.0), 0.25)]);
    for roll_degrees in [90.0, 30.0, -135.0] {
        for aspect_ratio in [0.5, 16.0 / 9.0] {
            let request = ViewRequest { roll_degrees, ..view(NamedView::Front) };
            assert_fits(&scene, &resolve(&scene, &request, aspect_ratio), aspect_ratio);
            assert_fits(&scene, &resolve(&scene, &parallel(request), aspect_ratio), aspect_ratio);
        }
    }
    let turntable = Some(TurntableRequest { elevation_degrees: None, turn_seconds: 2.0 });
    let request = ViewRequest { turntable, roll_degrees: 90.0, ..ViewRequest::default() };
    for request in [request.clone(), parallel(request)] {
        let camera = resolve(&scene, &request, 1.5);
        let reaches = (0..32).map(|step| {
            let [min, max] = image_bounds(&scene, &camera, 1.5, f64::from(step) / 16.0);
            max.max(-min).max_element()
        });
        let largest = reaches.fold(0.0, f32::max);
        assert!((largest - FILLED).abs() < 1e-3, "{largest}");
    }
}

#[test]
fn a_turntable_from_a_camera_of_the_file_rolls_once() {
    let projection =
        Projection::Perspective { fov_y_radians: 0.5, aspect_ratio: None, z_near: 1.0, z_far: None };
    let scene = with_camera(cubes(&[(Vec3::ZERO, 1.0)]), Vec3::new(0.0, 0.0, 7.0), projection);
    let selection = select_all(&scene, SelectedCamera::Node(NodeIndex(1)));
    let turntable = Some(TurntableRequest { elevation_degrees: None, turn_seconds: 2.0 });
    let request = ViewRequest { turntable, roll_degrees: 30.0, keeps_camera: true, ..ViewRequest::default() };
    let camera = resolve_camera(&scene, selection, &request, 1.0);
    let right = Frame::camera_at(&scene, &camera.selection, 0.0).world_from_camera.x_axis;
    // cos 30° and sin 30°
    assert!(right.truncate().abs_diff_eq(Vec3::new(0.866_025, 0.5, 0.0), 1e-5), "{right}");
}

#[test]
fn planes_stay_with_a_camera_that_is_not_framed_anew() {
    let own =
        Projection::Perspective { fov_y_radians: 0.5, aspect_ratio: None, z_near: 5.5, z_far: Some(9.0) };
    let scene = with_camera(cubes(&[(Vec3::ZERO, 1.0)]), Vec3::new(0.0, 0.0, 7.0), own);
    let planes = |request: ViewRequest| {
        let selection = select_all(&scene, SelectedCamera::Node(NodeIndex(1)));
        let request = ViewRequest { keeps_camera: true, ..request };
        let camera = resolve_camera(&scene, selection, &request, 1.0);
        match Frame::camera_at(&scene, &camera.selection, 0.0).projection {
            Projection::Perspective { z_near, z_far, .. } => (z_near, z_far),
            Projection::Orthographic { z_near, z_far, .. } => (z_near, Some(z_far)),
        }
    };
    let lens = Some(LensRequest::FieldOfView(30.0));
    let (kept, none) = ((5.5, Some(9.0)), (0.0, None));
    assert_eq!(planes(ViewRequest::default()), kept);
    assert_eq!(planes(ViewRequest { lens, ..ViewRequest::default() }), kept);
    assert_eq!(planes(ViewRequest { roll_degrees: 20.0, ..ViewRequest::default() }), kept);
    assert_eq!(planes(parallel(ViewRequest::default())), kept);
    assert_eq!(planes(ViewRequest { position: Some(Vec3::Z * 8.0), lens, ..ViewRequest::default() }), kept);
    // They would cut what is framed from elsewhere.
    assert_eq!(planes(view(NamedView::Right)), none);
    assert_eq!(planes(ViewRequest { lens, ..view(NamedView::Right) }), none);
    assert_eq!(planes(parallel(view(NamedView::Right))), (0.0, Some(f32::MAX)));
}

#[test]
fn animated_planes_stay_animated_with_another_lens() {
    let own = Projection::Perspective { fov_y_radians: 0.5, aspect_ratio: None, z_near: 5.5, z_far: None };
    let mut scene = with_camera(cubes(&[(Vec3::ZERO, 1.0)]), Vec3::new(0.0, 0.0, 7.0), own);
    animate(&mut scene, AnimationTarget::Camera(CameraIndex(0), CameraProperty::ZNear), &[5.5], &[1.5]);
    let selection = select_all(&scene, SelectedCamera::Node(NodeIndex(1)));
    let lens = Some(LensRequest::FieldOfView(30.0));
    let camera = resolve_camera(&scene, selection, &ViewRequest { lens, ..ViewRequest::default() }, 1.0);
    let at_end = Frame::camera_at(&scene, &camera.selection, 1.0).projection;
    assert!(matches!(at_end, Projection::Perspective { z_near: 1.5, .. }), "{at_end:?}");
}
