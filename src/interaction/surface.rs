//! Construction of surface points from hits.

use glam::{Vec2, Vec3};

use super::normal;
use super::ray_differential::{RayDifferential, weight_steps};
use super::surface_point::{SurfacePoint, plane_error};
use super::texture_lookup::Lookups;
use crate::bvh::Hit;
use crate::frame::{MeshInstance, PosedVertex};
use crate::geometry::{Facing, Ray, Triangle, unit};
use crate::scene_view::SceneView;

impl<'a> SurfacePoint<'a> {
    /// The point where `ray` hits a surface. A ray with a non-zero differential has a direction of unit length.
    pub fn new(view: SceneView<'a>, ray: &Ray, hit: &Hit, differential: &RayDifferential) -> Self {
        Self::with_lookups(&Lookups::new(view), ray, hit, differential)
    }

    pub(super) fn with_lookups(
        textures: &Lookups<'a>,
        ray: &Ray,
        hit: &Hit,
        differential: &RayDifferential,
    ) -> Self {
        let view = textures.view();
        let frame = view.frame;
        let instance = frame.instance(hit.triangle);
        let triangle = &frame.triangles[hit.triangle as usize];
        let [a, b, c] = triangle.vertices;
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let position = interpolated([a, b, c], hit);
        let wo = -unit(ray.direction).unwrap_or(Vec3::Y);
        let side = if hit.facing == Facing::Front { 1.0 } else { -1.0 };
        let front_normal = normal::of_triangle(triangle);
        let corners = corner_indices(view, instance, hit.triangle);
        let vertices = corners.map(|corner| &frame.vertices[instance.first_vertex + corner as usize]);
        let (position_steps, weight_steps) = if *differential == RayDifferential::ZERO {
            ([Vec3::ZERO; 2], [Vec2::ZERO; 2])
        } else {
            let steps = differential.on_surface(ray.direction, hit.t, front_normal);
            let has_uvs = !instance.primitive(view.scene).uvs.is_empty();
            (steps, if has_uvs { weight_steps(triangle, steps) } else { [Vec2::ZERO; 2] })
        };

        let mut point = Self {
            instance,
            triangle: hit.triangle,
            position,
            wo,
            facing: hit.facing,
            geometric_normal: front_normal * side,
            shading_normal: front_normal * side,
            offset_distance: offset_distance(front_normal, position, triangle),
            shadow_position: position,
            corners,
            weights,
            position_steps,
            weight_steps,
        };
        if vertices.iter().all(|vertex| vertex.normal != Vec3::ZERO) {
            point.shadow_position = terminator_free_point(&point, [a, b, c], &vertices);
        }
        let authored = normal::shading_normal(textures, &point, front_normal, &vertices);
        point.shading_normal = normal::bent_into_view(point.geometric_normal, authored * side, wo);
        point
    }
}

/// The hit point of a triangle, rounded once, so that it leaves the plane as little as floats allow.
fn interpolated(corners: [Vec3; 3], hit: &Hit) -> Vec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (a + (b - a) * f64::from(hit.u) + (c - a) * f64::from(hit.v)).as_vec3()
}

/// Vertex indices of a triangle in the order of its posed corners.
pub(super) fn corner_indices(view: SceneView<'_>, instance: &MeshInstance, triangle: u32) -> [u32; 3] {
    let local = (triangle - instance.first_triangle) as usize;
    let [a, b, c] = instance.primitive(view.scene).triangles[local];
    if instance.mirrored { [a, c, b] } else { [a, b, c] }
}

/// Bound on how far rounding moves the start of a ray off the plane, and the plane as a ray from there hits it. The point is rounded
/// a few times, each by half a unit in the last place of its coordinates. The second term separates touching surfaces that were
/// transformed differently.
fn offset_distance(normal: Vec3, position: Vec3, triangle: &Triangle) -> f32 {
    let off_plane = normal.abs().dot(position.abs()) * (4.0 * f32::EPSILON);
    let separation = position.abs().max_element() * (2.0 * f32::EPSILON);
    let [a, b, c] = triangle.vertices.map(|corner| (corner - position).abs());
    let reach = a.max(b).max(c).max_element();
    off_plane + separation + plane_error(normal, reach) + f32::MIN_POSITIVE
}

/// The end of shadow rays without the terminator artifact (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021,
/// chapter 4): the point is lifted onto the curved surface that the vertex normals define, so that flat facets of a smooth
/// surface do not shadow themselves.
///
/// Normals are taken on the side of `wo`, inside-out ones too. A normal that still points below the triangle lifts nothing.
fn terminator_free_point(point: &SurfacePoint<'_>, corners: [Vec3; 3], vertices: &[&PosedVertex; 3]) -> Vec3 {
    let up = point.geometric_normal;
    let weighted = vertices.iter().zip(point.weights).map(|(vertex, weight)| vertex.normal * weight);
    let side = if weighted.sum::<Vec3>().dot(up) < 0.0 { -1.0 } else { 1.0 };
    let mut lifted = point.position;
    for ((corner, vertex), weight) in corners.into_iter().zip(vertices).zip(point.weights) {
        let normal = vertex.normal * side;
        let height = (point.position - corner).dot(normal);
        if height < 0.0 && normal.dot(up) > 0.0 {
            lifted -= normal * (height * weight);
        }
    }
    lifted
}
