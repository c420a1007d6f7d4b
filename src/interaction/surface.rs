//! Construction of surface points from hits.

use glam::{Vec2, Vec3};

use super::normal;
use super::ray_differential::{RayDifferential, weight_steps};
use super::surface_point::{SurfacePoint, plane_error};
use super::texture_lookup::Lookups;
use crate::bvh::Hit;
use crate::frame::MeshInstance;
use crate::geometry::{Facing, Ray, unit_or};
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
        let position = position_of([a, b, c], [hit.u, hit.v]);
        let wo = -unit_or(ray.direction, Vec3::Y);
        let side = if hit.facing == Facing::Front { 1.0 } else { -1.0 };
        let front_normal = normal::of_triangle(triangle);
        let corners = corner_indices(view, instance, hit.triangle);
        let vertex = |corner: usize| &frame.vertices[instance.first_vertex + corners[corner] as usize];
        let vertices = [vertex(0), vertex(1), vertex(2)];
        let (position_steps, weight_steps) = if *differential == RayDifferential::ZERO {
            ([Vec3::ZERO; 2], [Vec2::ZERO; 2])
        } else {
            let steps = differential.on_surface(ray.direction, hit.t, front_normal);
            let has_uvs = !instance.primitive(view.scene).uvs.is_empty();
            (steps, if has_uvs { weight_steps(triangle.vertices, steps) } else { [Vec2::ZERO; 2] })
        };

        let mut point = Self {
            instance,
            triangle: hit.triangle,
            position,
            wo,
            facing: hit.facing,
            geometric_normal: front_normal * side,
            shading_normal: front_normal * side,
            offset_distance: offset_distance(front_normal, position, triangle.vertices),
            shadow_position: position,
            corners,
            weights,
            position_steps,
            weight_steps,
        };
        let normals = [vertices[0].normal, vertices[1].normal, vertices[2].normal];
        if is_smooth(normals) {
            point.shadow_position =
                terminator_free_point(position, point.geometric_normal, [a, b, c], normals, weights);
        }
        let authored = normal::shading_normal(textures, &point, front_normal, &vertices);
        point.shading_normal = normal::bent_into_view(point.geometric_normal, authored * side, wo);
        point
    }
}

/// The hit point of a triangle, rounded once, so that it leaves the plane as little as floats allow.
#[inline(always)]
pub(super) fn position_of(corners: [Vec3; 3], [u, v]: [f32; 2]) -> Vec3 {
    let [a, b, c] = [corners[0].as_dvec3(), corners[1].as_dvec3(), corners[2].as_dvec3()];
    (a + (b - a) * f64::from(u) + (c - a) * f64::from(v)).as_vec3()
}

/// Whether all vertices have normals, so that these are interpolated.
#[inline(always)]
pub(super) fn is_smooth(normals: [Vec3; 3]) -> bool {
    let [a, b, c] = normals;
    a != Vec3::ZERO && b != Vec3::ZERO && c != Vec3::ZERO
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
#[inline(always)]
pub(super) fn offset_distance(normal: Vec3, position: Vec3, corners: [Vec3; 3]) -> f32 {
    let off_plane = normal.abs().dot(position.abs()) * (4.0 * f32::EPSILON);
    let separation = position.abs().max_element() * (2.0 * f32::EPSILON);
    let away = |corner: Vec3| (corner - position).abs();
    let reach = away(corners[0]).max(away(corners[1])).max(away(corners[2])).max_element();
    off_plane + separation + plane_error(normal, reach) + f32::MIN_POSITIVE
}

/// The end of shadow rays without the terminator artifact (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021,
/// chapter 4): the point is lifted onto the curved surface that the vertex normals define, so that flat facets of a smooth
/// surface do not shadow themselves.
///
/// Normals are taken on the side of `wo`, inside-out ones too. A normal that still points below the triangle lifts nothing.
#[inline(always)]
pub(super) fn terminator_free_point(
    position: Vec3,
    up: Vec3,
    corners: [Vec3; 3],
    normals: [Vec3; 3],
    weights: [f32; 3],
) -> Vec3 {
    let side = if normal::weighted_sum(normals, weights).dot(up) < 0.0 { -1.0 } else { 1.0 };
    let mut lifted = position;
    for corner in 0..3 {
        let normal = normals[corner] * side;
        let height = (position - corners[corner]).dot(normal);
        let raised = lifted - normal * (height * weights[corner]);
        let lifts = height < 0.0 && normal.dot(up) > 0.0;
        lifted = if lifts { raised } else { lifted };
    }
    lifted
}
