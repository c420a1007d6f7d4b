//! Where shadow rays can be blocked: in a sphere around all surfaces that cast shadows.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::whitted::local_frame;
use crate::bvh::TriangleFlags;
use crate::frame::Frame;
use crate::geometry::{Aabb, sin_cos_of_turn};

/// Largest squared sine of half the angle of a cone: 30°. In wider ones, directions are better chosen by the light.
const MAX_SINE_SQUARED: f32 = 0.25;
/// Margin of the sphere for the rounding of rays.
const MARGIN: f32 = 1.001;
/// Triangles of one parallel task.
const TRIANGLES_PER_TASK: usize = 16_384;

/// A sphere around all surfaces that cast shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OccluderSphere {
    center: Vec3,
    radius: f32,
}

/// Directions around an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    axis: Vec3,
    /// One less the cosine of half the angle.
    height: f32,
}

impl OccluderSphere {
    /// The sphere around the visible triangles of a frame but those of shadow catchers.
    pub(super) fn of(frame: &Frame) -> Self {
        let casts_shadows = |instance: u32| {
            let material = frame.instances[instance as usize].material;
            !frame.materials[material.index()].is_shadow_catcher
        };
        let casts_shadows: Vec<bool> = (0..frame.instances.len() as u32).map(casts_shadows).collect();
        let triangles = frame.triangles.par_iter().zip(&frame.flags).zip(&frame.instance_of_triangle);
        let bounds = triangles
            .with_min_len(TRIANGLES_PER_TASK)
            .filter(|((_, flags), instance)| {
                !flags.has(TriangleFlags::HIDDEN) && casts_shadows[**instance as usize]
            })
            .map(|((triangle, _), _)| triangle.bounds())
            .reduce(|| Aabb::EMPTY, Aabb::union);
        if bounds.is_empty() {
            return Self::new(Vec3::ZERO, 0.0);
        }
        Self::new(bounds.center(), 0.5 * bounds.extent().length() * MARGIN)
    }

    pub(super) fn new(center: Vec3, radius: f32) -> Self {
        Self { center, radius }
    }

    /// The directions from a point towards the sphere; `None` if they are not a narrow cone.
    pub(super) fn cone_from(&self, point: Vec3) -> Option<Cone> {
        let span = self.center - point;
        let sine_squared = self.radius * self.radius / span.length_squared();
        let height = sine_squared / (1.0 + (1.0 - sine_squared).sqrt());
        (sine_squared <= MAX_SINE_SQUARED).then(|| Cone { axis: span.normalize(), height })
    }
}

impl Cone {
    /// Solid angle, steradians.
    pub(super) fn solid_angle(&self) -> f32 {
        TAU * self.height
    }

    /// The largest cosine between a direction and a unit vector; 0 if none is positive.
    pub(super) fn largest_cosine(&self, normal: Vec3) -> f32 {
        let (to_axis, half) = (self.axis.dot(normal), 1.0 - self.height);
        if to_axis >= half {
            return 1.0;
        }
        let sines = (1.0 - to_axis * to_axis).max(0.0) * self.height * (2.0 - self.height);
        (to_axis * half + sines.sqrt()).max(0.0)
    }

    /// A direction, evenly by solid angle.
    pub(super) fn direction(&self, u: Vec2) -> Vec3 {
        let height = self.height * u.x;
        let radius = (height * (2.0 - height)).sqrt();
        let (sine, cosine) = sin_cos_of_turn(u.y * TAU);
        local_frame(self.axis) * Vec3::new(radius * cosine, radius * sine, 1.0 - height)
    }

    /// Whether a unit vector lies within.
    pub(super) fn contains(&self, direction: Vec3) -> bool {
        direction.dot(self.axis) >= 1.0 - self.height
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::spiral_direction;
    use crate::scene::{Selection, SelectionRequest, mark_shadow_catchers};

    #[test]
    fn the_sphere_holds_what_casts_shadows_and_nothing_else() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/environment/shadow_catcher.gltf");
        let mut scene = crate::gltf::import(path.as_ref(), &crate::gltf::ImportOptions::default()).unwrap();
        let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
        let with_floor = OccluderSphere::of(&Frame::at(&scene, &selection, 0.0));
        assert!(mark_shadow_catchers(&mut scene, "floor") > 0);
        let mut frame = Frame::at(&scene, &selection, 0.0);
        let without_floor = OccluderSphere::of(&frame);
        assert!(without_floor.radius < 0.5 * with_floor.radius);
        let casts = |frame: &Frame, index: usize| {
            let material = frame.instances[frame.instance_of_triangle[index] as usize].material;
            !frame.materials[material.index()].is_shadow_catcher
        };
        for (index, triangle) in frame.triangles.iter().enumerate().filter(|(index, _)| casts(&frame, *index))
        {
            let is_inside = |corner: &Vec3| corner.distance(without_floor.center) <= without_floor.radius;
            assert!(triangle.vertices.iter().all(is_inside), "{index}");
        }

        // Hidden triangles are not there.
        let last = (0..frame.triangles.len()).rev().find(|&index| casts(&frame, index)).unwrap();
        for index in 0..frame.triangles.len() {
            if index != last {
                frame.flags[index] = frame.flags[index].with(TriangleFlags::HIDDEN);
            }
        }
        let of_last = OccluderSphere::of(&frame);
        assert_eq!(of_last.center, frame.triangles[last].bounds().center());
        assert!(of_last.radius > 0.0 && of_last.radius < without_floor.radius);
        assert_eq!(OccluderSphere::of(&Frame::default()), OccluderSphere::new(Vec3::ZERO, 0.0));
    }

    /// The largest cosine between directions on the rim of a cone or its axis and a normal.
    fn spiral_cosines(cone: &Cone, normal: Vec3) -> f32 {
        let rim = (0..128).map(|i| cone.direction(Vec2::new(1.0, i as f32 / 128.0)).dot(normal));
        let inside = (0..4096).map(|i| {
            let i = i as f32 / 4096.0;
            cone.direction(Vec2::new(i, i * 64.0 % 1.0)).dot(normal)
        });
        rim.chain(inside).fold(f32::NEG_INFINITY, f32::max)
    }

    #[test]
    fn cones_hold_the_directions_to_the_sphere_and_no_others() {
        let sphere = OccluderSphere::new(Vec3::new(1.0, -2.0, 0.5), 0.75);
        for point in [Vec3::new(1.0, 0.0, 0.5), Vec3::new(-7.0, 3.0, 2.0), Vec3::new(900.0, 0.0, 0.0)] {
            let cone = sphere.cone_from(point).unwrap();
            let to_center = sphere.center - point;
            let is_hit = |wi: Vec3| to_center.reject_from_normalized(wi).length();
            for i in 0..64_u8 {
                let u = Vec2::new((f32::from(i) + 0.5) / 64.0, f32::from(i) * 0.618_034 % 1.0);
                let inside = cone.direction(u);
                assert!((inside.length() - 1.0).abs() < 1e-6);
                assert!(is_hit(inside) <= sphere.radius * 1.0001 && inside.dot(to_center) > 0.0);
                let normal = spiral_direction(u32::from(i), 64);
                let cosines = spiral_cosines(&cone, normal);
                assert!(cosines <= cone.largest_cosine(normal) + 1e-6);
                assert!(cosines.max(0.0) > cone.largest_cosine(normal) - 0.02, "{normal}");
                let far = spiral_direction(u32::from(i), 64);
                let hits = is_hit(far) < sphere.radius && far.dot(to_center) > 0.0;
                assert_eq!(cone.contains(far), hits, "{far}");
            }
            // A sphere of radius r at distance d fills 2 pi (1 - sqrt(1 - r²/d²)).
            let distance = f64::from(to_center.length());
            let expected =
                std::f64::consts::TAU * (1.0 - (1.0 - (f64::from(sphere.radius) / distance).powi(2)).sqrt());
            assert!((f64::from(cone.solid_angle()) / expected - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn near_points_and_points_inside_have_no_cone() {
        let sphere = OccluderSphere::new(Vec3::ZERO, 1.0);
        for point in [Vec3::ZERO, Vec3::X * 0.5, Vec3::X, Vec3::X * 1.9] {
            assert_eq!(sphere.cone_from(point), None);
        }
        let empty = OccluderSphere::new(Vec3::ZERO, 0.0);
        assert_eq!(empty.cone_from(Vec3::X).map(|cone| cone.solid_angle()), Some(0.0));
        assert_eq!(empty.cone_from(Vec3::ZERO), None);
    }
}
