//! Ray differentials against known widths, and against traced neighbouring rays.

use glam::{DVec3, Vec2};

use super::*;
use crate::bvh::{BuildSettings, Builder, Bvh, Hit};
use crate::cancel::CancelFlag;
use crate::frame::Frame;
use crate::geometry::{Facing, Ray, Triangle};
use crate::interaction::texture_lookup::UvDifferential;
use crate::scene::{
    Environment, Material, MaterialIndex, Mesh, MeshIndex, Node, NodeIndex, Primitive, Scene, SelectedCamera,
    Selection, TextureIndex, TextureRef, UvTransform,
};
use crate::scene_view::SceneView;

const UVS: [Vec2; 3] = [Vec2::new(0.1, 0.9), Vec2::new(0.8, 0.7), Vec2::new(0.3, 0.2)];

/// At equal distances from the origin, so that the normals of a sphere about the axis change evenly over them.
const BALL_CORNERS: [Vec3; 3] =
    [Vec3::new(-0.24, -0.07, 0.0), Vec3::new(0.2, -0.15, 0.0), Vec3::new(0.0, 0.25, 0.0)];

/// A scene of one triangle.
struct Stage {
    scene: Scene,
    frame: Frame,
    bvh: Bvh,
}

impl Stage {
    fn new(positions: [Vec3; 3], normals: Option<[Vec3; 3]>) -> Self {
        let primitive = Primitive {
            positions: positions.to_vec(),
            normals: normals.map(|normals| normals.map(Vec3::normalize).to_vec()),
            uvs: vec![UVS.to_vec()],
            triangles: vec![[0, 1, 2]],
            material: MaterialIndex(0),
            ..Primitive::default()
        };
        let scene = Scene {
            nodes: vec![Node { mesh: Some(MeshIndex(0)), ..Node::default() }],
            node_order: vec![NodeIndex(0)],
            meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
            materials: vec![Material::default()],
            ..Scene::default()
        };
        let selection = Selection {
            camera_changes: crate::scene::CameraChanges::default(),
            image_light: None,
            variant: None,
            roots: vec![NodeIndex(0)],
            clips: Vec::new(),
            camera: SelectedCamera::Fixed {
                world_from_camera: glam::Mat4::IDENTITY,
                projection: crate::frame::PosedCamera::default().projection,
            },
        };
        let frame = Frame::at(&scene, &selection, 0.0);
        let (build, cancel) = (BuildSettings::default(), CancelFlag::new());
        let bvh = Builder::default().build(&frame.triangles, &frame.flags, &build, &cancel, None).unwrap();
        Self { scene, frame, bvh }
    }

    fn view(&self) -> SceneView<'_> {
        SceneView { scene: &self.scene, frame: &self.frame, bvh: &self.bvh, environment: &Environment::None }
    }

    /// Intersection of a ray with the triangle's plane, in f64: t, barycentric weights and side.
    fn intersect(&self, origin: DVec3, direction: DVec3) -> (f64, [f64; 3], Facing) {
        let [a, b, c] = self.frame.triangles[0].vertices.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        let t = (a - origin).dot(normal) / direction.dot(normal);
        let from_a = origin + direction * t - a;
        let u = from_a.cross(c - a).dot(normal) / normal.dot(normal);
        let v = (b - a).cross(from_a).dot(normal) / normal.dot(normal);
        let facing = if direction.dot(normal) < 0.0 { Facing::Front } else { Facing::Back };
        (t, [1.0 - u - v, u, v], facing)
    }

    /// Hit point, mirror direction, refracted direction and texture coordinates of a ray.
    fn follow(&self, origin: DVec3, direction: DVec3, ior: f64) -> (DVec3, DVec3, DVec3, DVec3) {
        let (t, weights, _) = self.intersect(origin, direction);
        let sum = |of: &dyn Fn(usize) -> DVec3| of(0) * weights[0] + of(1) * weights[1] + of(2) * weights[2];
        let normal = sum(&|i| self.frame.vertices[i].normal.as_dvec3()).normalize();
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        let cosine = -direction.dot(normal);
        let mirrored = direction + normal * (2.0 * cosine);
        let eta = 1.0 / ior;
        let cosine_transmitted = libm::sqrt(1.0 - eta * eta * (1.0 - cosine * cosine));
        let refracted = direction * eta + normal * (eta * cosine - cosine_transmitted);
        (origin + direction * t, mirrored, refracted, sum(&|i| UVS[i].extend(0.0).as_dvec3()))
    }

    fn point(&self, ray: &Ray, differential: &RayDifferential) -> SurfacePoint<'_> {
        let (t, [_, u, v], facing) = self.intersect(ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let hit = Hit { t: t as f32, triangle: 0, u: u as f32, v: v as f32, facing };
        SurfacePoint::new(self.view(), ray, &hit, differential)
    }
}

fn assert_near(found: Vec3, expected: DVec3, scale: f64) {
    assert!((found.as_dvec3() - expected).length() <= 2e-3 * scale, "{found} for {expected}");
}

#[test]
fn differentials_equal_those_of_traced_neighbouring_rays() {
    let positions = [Vec3::new(-2.0, -1.0, 0.3), Vec3::new(2.5, -1.2, -0.4), Vec3::new(0.2, 2.0, 0.5)];
    // Convex towards +Z, unevenly
    let normals = [Vec3::new(-0.5, -0.3, 1.0), Vec3::new(0.4, -0.2, 1.0), Vec3::new(0.1, 0.6, 1.0)];
    let stage = Stage::new(positions, Some(normals));
    let differential = RayDifferential {
        origin: [Vec3::new(0.3, 0.1, -0.2), Vec3::new(-0.1, 0.4, 0.2)],
        direction: [Vec3::new(0.05, 0.02, 0.0), Vec3::new(-0.01, 0.04, 0.03)],
    };
    // From the front at two angles, and from the back
    for (eye, target, ior) in [
        (Vec3::new(0.5, 1.0, 4.0), Vec3::new(0.1, -0.2, 0.0), 1.5),
        (Vec3::new(1.2, 1.0, 3.0), Vec3::new(0.3, 0.1, 0.0), 0.8),
        (Vec3::new(-1.0, 0.5, -3.0), Vec3::new(0.2, 0.2, 0.0), 1.33),
    ] {
        let direction = (target - eye).normalize();
        let ray = Ray::new(eye, direction);
        let point = stage.point(&ray, &differential);
        let straight = stage.follow(eye.as_dvec3(), direction.as_dvec3(), ior);
        let refracted_direction = straight.2.as_vec3();
        let reflected = point.reflected_differential(&stage.frame, &differential);
        let refracted =
            point.refracted_differential(&stage.frame, &differential, refracted_direction, ior as f32);
        assert!(refracted_direction.is_finite());
        let reference = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
        let (_, UvDifferential(uvs)) = point.uv(stage.view(), &reference);

        for (axis, uv_step) in uvs.into_iter().enumerate() {
            let step = 1e-6;
            let near = stage.follow(
                eye.as_dvec3() + differential.origin[axis].as_dvec3() * step,
                direction.as_dvec3() + differential.direction[axis].as_dvec3() * step,
                ior,
            );
            let change = |from: DVec3, to: DVec3| (to - from) / step;
            assert_near(reflected.origin[axis], change(straight.0, near.0), 1.0);
            assert_near(refracted.origin[axis], change(straight.0, near.0), 1.0);
            assert_near(reflected.direction[axis], change(straight.1, near.1), 1.0);
            assert_near(refracted.direction[axis], change(straight.2, near.2), 1.0);
            assert_near(uv_step.extend(0.0), change(straight.3, near.3), 1.0);
            assert!(reflected.direction[axis].length() > 0.1);
        }
    }
}

/// The differential of a ray along −Z whose neighbours diverge by 0.01 along x and y.
fn spreading() -> RayDifferential {
    RayDifferential { origin: [Vec3::ZERO; 2], direction: [Vec3::X * 0.01, Vec3::Y * 0.01] }
}

#[test]
fn a_tilted_plane_elongates_by_the_cosine() {
    // At distance 5 a pixel of 0.01 is 0.05 wide; on a plane tilted by 60° about x it is 0.05 / cos 60° = 0.1 long.
    let tilt = glam::Quat::from_rotation_x(60_f32.to_radians());
    let corners = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    let stage = Stage::new(corners.map(|corner| tilt * corner), None);
    let point = stage.point(&Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z), &spreading());
    let [across, along] = point.position_steps.map(Vec3::length);
    assert!((across - 0.05).abs() < 1e-6 && (along - 0.1).abs() < 1e-5, "{across} {along}");
    // A flat mirror keeps the divergence.
    let mirrored = point.reflected_differential(&stage.frame, &spreading());
    assert!(mirrored.direction.iter().all(|step| (step.length() - 0.01).abs() < 1e-6));
}

#[test]
fn a_mirror_ball_diverges_and_a_hollow_ball_converges() {
    // On a ball of radius R the normal turns by p / R over a step p, the mirror ray by δ + 2 p / R: with R = 0.5 and p = 0.05
    // by 0.01 + 0.2. From within, a hollow ball of the same radius converges: 0.01 − 0.2.
    let corners = BALL_CORNERS;
    let ball = Stage::new(corners, Some(corners.map(|corner| corner + Vec3::Z * 0.5)));
    let point = ball.point(&Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z), &spreading());
    let mirrored = point.reflected_differential(&ball.frame, &spreading());
    assert!((mirrored.direction[0] - Vec3::X * 0.21).length() < 1e-5, "{:?}", mirrored.direction);
    assert!((mirrored.direction[1] - Vec3::Y * 0.21).length() < 1e-5, "{:?}", mirrored.direction);

    let hollow = Stage::new(corners, Some(corners.map(|corner| Vec3::Z * 0.5 - corner)));
    let point = hollow.point(&Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z), &spreading());
    let mirrored = point.reflected_differential(&hollow.frame, &spreading());
    assert!((mirrored.direction[0] + Vec3::X * 0.19).length() < 1e-5, "{:?}", mirrored.direction);
}

#[test]
fn a_flat_window_narrows_and_a_ball_lens_converges() {
    let corners = BALL_CORNERS;
    // Into glass of 1.5 angles near the normal shrink to two thirds.
    let window = Stage::new(corners, None);
    let point = window.point(&Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z), &spreading());
    let transmitted =
        point.refracted_differential(&window.frame, &spreading(), Vec3::NEG_Z * 0.999_999_9, 1.5);
    assert!(
        (transmitted.direction[0] - Vec3::X * (0.01 / 1.5)).length() < 1e-6,
        "{:?}",
        transmitted.direction
    );
    // An unbent ray keeps its derivatives.
    let straight = point.refracted_differential(&window.frame, &spreading(), Vec3::NEG_Z, 1.5);
    assert_eq!(straight.direction, spreading().direction);
    assert_eq!(point.passed_differential(&spreading()), straight);
    // A surface of radius R bends by (n − 1) / n · p / R towards the axis: 0.01 / 1.5 − 1/3 · 0.05 / 0.5.
    let ball = Stage::new(corners, Some(corners.map(|corner| corner + Vec3::Z * 0.5)));
    let point = ball.point(&Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z), &spreading());
    let transmitted = point.refracted_differential(&ball.frame, &spreading(), Vec3::NEG_Z * 0.999_999_9, 1.5);
    let expected = 0.01 / 1.5 - 0.1 / 3.0;
    assert!((transmitted.direction[0] - Vec3::X * expected).length() < 1e-5, "{:?}", transmitted.direction);
}

#[test]
fn weights_of_slivers_change_evenly() {
    let sliver = Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::new(0.5, 1e-12, 0.0)] };
    let [step, _] = weight_steps(sliver.vertices, [Vec3::X * 0.25, Vec3::ZERO]);
    assert!((step - Vec2::new(0.25, 0.0)).length() < 1e-6, "{step}");
}
