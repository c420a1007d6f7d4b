//! Construction of surface points from hits.

use std::cell::RefCell;

use glam::Vec3;

use super::normal;
use super::ray_differential::{RayDifferential, weight_steps};
use super::surface_point::{SurfacePoint, plane_error};
use super::texture_lookup::{Lookups, TextureProbes};
use crate::bvh::Hit;
use crate::frame::MeshInstance;
use crate::geometry::{Facing, Ray, unit_or};
use crate::scene_view::SceneView;

impl<'a> SurfacePoint<'a> {
    /// The point where `ray` hits a surface. A ray with a non-zero differential has a direction of unit length.
    pub fn new(view: SceneView<'a>, ray: &Ray, hit: &Hit, differential: &RayDifferential) -> Self {
        Self::with_lookups(&Lookups::new(view, &RefCell::default()), ray, hit, differential)
    }

    /// The directions and normals alone of [`SurfacePoint::new`], for a ray without extent. Positions and steps are zero.
    pub fn orientation(view: SceneView<'a>, ray: &Ray, hit: &Hit, probes: &RefCell<TextureProbes>) -> Self {
        let mut point = Self::unshaded(view, ray, hit);
        point.shading_normal = point.mapped_normal(&Lookups::new(view, probes));
        point
    }

    /// [`SurfacePoint::new`] of a flat surface without a normal map, for a ray without extent.
    pub fn flat(view: SceneView<'a>, ray: &Ray, hit: &Hit) -> Self {
        let mut point = Self::unshaded(view, ray, hit);
        let corners = view.frame.triangles[hit.triangle as usize].vertices;
        point.position = position_of(corners, [hit.u, hit.v]);
        point.shadow_position = point.position;
        let front_normal = point.geometric_normal * point.side();
        point.offset_distance = offset_distance(front_normal, point.position, corners);
        point
    }

    pub(super) fn with_lookups(
        textures: &Lookups<'_, 'a>,
        ray: &Ray,
        hit: &Hit,
        differential: &RayDifferential,
    ) -> Self {
        let view = textures.view();
        let frame = view.frame;
        let mut point = Self::flat(view, ray, hit);
        let triangle = &frame.triangles[hit.triangle as usize];
        let front_normal = point.geometric_normal * point.side();

        // Steps to the hits of the neighbouring rays
        if *differential != RayDifferential::ZERO {
            point.position_steps = differential.on_surface(ray.direction, hit.t, front_normal);
            if !point.instance.primitive(view.scene).uvs.is_empty() {
                point.weight_steps = weight_steps(triangle.vertices, point.position_steps);
            }
        }

        // Vertex normals
        let vertices = &frame.vertices[point.instance.first_vertex..];
        let normals = point.corners.map(|corner| vertices[corner as usize].normal);
        point.shadow_position = if normal::is_smooth(normals) {
            let (up, side) = (point.geometric_normal, point.side());
            let least_cosine = normal::inside_out_cosine(point.instance);
            let side = side * normal::authored_side(normals, up * side, least_cosine);
            let outward = normals.map(|normal| normal * side);
            terminator_free_point(point.position, up, triangle.vertices, outward, point.weights)
        } else {
            point.position
        };
        point.shading_normal = point.mapped_normal(textures);
        point
    }

    /// The directions and the geometric normal, which is the shading normal too.
    fn unshaded(view: SceneView<'a>, ray: &Ray, hit: &Hit) -> Self {
        let instance = view.frame.instance(hit.triangle);
        let side = if hit.facing == Facing::Front { 1.0 } else { -1.0 };
        let normal = normal::of_triangle(&view.frame.triangles[hit.triangle as usize]) * side;
        Self {
            triangle: hit.triangle,
            wo: -unit_or(ray.direction, Vec3::Y),
            facing: hit.facing,
            geometric_normal: normal,
            shading_normal: normal,
            corners: corner_indices(view, instance, hit.triangle),
            weights: [1.0 - hit.u - hit.v, hit.u, hit.v],
            ..Self::unplaced(instance)
        }
    }

    /// The shading normal by the normal map of the material.
    fn mapped_normal(&self, textures: &Lookups<'_, '_>) -> Vec3 {
        let material = &textures.view().frame.materials[self.instance.material.index()];
        normal::mapped_by(textures, self, material.normal_texture.as_ref())
    }
}

/// The hit point of a triangle, rounded once, so that it leaves the plane as little as floats allow.
#[inline(always)]
pub(super) fn position_of(corners: [Vec3; 3], [u, v]: [f32; 2]) -> Vec3 {
    let [a, b, c] = [corners[0].as_dvec3(), corners[1].as_dvec3(), corners[2].as_dvec3()];
    (a + (b - a) * f64::from(u) + (c - a) * f64::from(v)).as_vec3()
}

/// Vertex indices of a triangle in the order of its posed corners.
#[inline(always)]
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
/// `up` and the normals are on the side of the viewer. A normal that still points below the triangle lifts nothing.
#[inline(always)]
pub(super) fn terminator_free_point(
    position: Vec3,
    up: Vec3,
    corners: [Vec3; 3],
    normals: [Vec3; 3],
    weights: [f32; 3],
) -> Vec3 {
    let mut lifted = position;
    for corner in 0..3 {
        let normal = normals[corner];
        let height = (position - corners[corner]).dot(normal);
        let raised = lifted - normal * (height * weights[corner]);
        let lifts = height < 0.0 && normal.dot(up) > 0.0;
        lifted = if lifts { raised } else { lifted };
    }
    lifted
}
