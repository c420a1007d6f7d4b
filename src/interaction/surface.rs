//! Geometry at a hit: point, error bound, normals on the viewer's side, and where shadow rays end.

use glam::{Vec2, Vec3};

use super::{PosedScene, normal};
use crate::bvh::Hit;
use crate::frame::{PosedVertex, Shape};
use crate::geometry::{Facing, Ray};
use crate::scene::TextureRef;

/// A point of a surface, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<'a> {
    /// The mesh primitive that was hit.
    pub shape: &'a Shape,
    /// Primitive id of the triangle.
    pub primitive: u32,
    /// World-space point, interpolated from the triangle's corners.
    pub position: Vec3,
    /// Unit vector towards where the ray came from.
    pub wo: Vec3,
    /// The side that was met.
    pub facing: Facing,
    /// Unit normal of the triangle on the side of `wo`.
    pub geometric_normal: Vec3,
    /// Unit normal for shading on the side of `wo`, normal map applied; its mirror ray leaves the surface.
    pub shading_normal: Vec3,
    /// Distance along the geometric normal that clears the rounding errors of `position`.
    pub offset_distance: f32,
    /// Where shadow rays on the side of `wo` end (before the offset): see [`terminator_free_point`].
    shadow_position: Vec3,
    /// Vertex subscripts in the shape's primitive, in the order of the barycentric weights.
    pub(super) corners: [u32; 3],
    /// Weights of the three corners.
    pub(super) weights: [f32; 3],
    /// Width of the ray's footprint, metres.
    pub(super) footprint_width: f32,
    /// Twice the triangle's area, square metres.
    pub(super) doubled_area: f32,
}

impl<'a> SurfacePoint<'a> {
    /// The point where `ray` meets `hit`; `footprint_width` is the ray's width there in metres.
    pub fn new(posed: PosedScene<'a>, ray: &Ray, hit: &Hit, footprint_width: f32) -> Self {
        let frame = posed.frame;
        let shape = frame.shape(hit.primitive);
        let triangle = &frame.triangles[hit.primitive as usize];
        let [a, b, c] = triangle.vertices;
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let position = a * weights[0] + b * weights[1] + c * weights[2];
        let wo = -normal::unit(ray.direction);
        let side = if hit.facing == Facing::Front { 1.0 } else { -1.0 };
        let (front_normal, doubled_area) = normal::of_triangle(triangle);
        let corners = corner_indices(posed, shape, hit.primitive);
        let vertices = corners.map(|corner| frame.vertices[shape.first_vertex + corner as usize]);

        let mut point = Self {
            shape,
            primitive: hit.primitive,
            position,
            wo,
            facing: hit.facing,
            geometric_normal: front_normal * side,
            shading_normal: front_normal * side,
            offset_distance: offset_distance(front_normal, [a, b, c], ray.origin),
            shadow_position: position,
            corners,
            weights,
            footprint_width,
            doubled_area,
        };
        if vertices.iter().all(|vertex| vertex.normal != Vec3::ZERO) {
            point.shadow_position = terminator_free_point(position, [a, b, c], &vertices, weights, side);
        }
        let authored = normal::shading_normal(posed, &point, front_normal, &vertices) * side;
        point.shading_normal = normal::bent_into_view(point.geometric_normal, authored, wo);
        point
    }

    /// Texture coordinates that `reference` looks up, and the footprint's width in them.
    pub(super) fn uv(&self, posed: PosedScene<'_>, reference: &TextureRef) -> (Vec2, f32) {
        let [a, b, c] = self.shape.uvs(posed.scene, reference.uv_set as usize, self.corners);
        let uv = a * self.weights[0] + b * self.weights[1] + c * self.weights[2];
        let doubled_uv_area = (b - a).perp_dot(c - a).abs();
        let uv_a_metre =
            if self.doubled_area > 0.0 { libm::sqrtf(doubled_uv_area / self.doubled_area) } else { 0.0 };
        (uv, self.footprint_width * uv_a_metre)
    }

    /// A start for rays that leave on the side of `wo`.
    pub fn origin_outside(&self) -> Vec3 {
        self.position + self.geometric_normal * self.offset_distance
    }

    /// A start for rays that pass through to the other side.
    pub fn origin_inside(&self) -> Vec3 {
        self.position - self.geometric_normal * self.offset_distance
    }

    /// The end of shadow rays that light the side of `wo`.
    pub fn shadow_end_outside(&self) -> Vec3 {
        self.shadow_position + self.geometric_normal * self.offset_distance
    }
}

/// Vertex subscripts of a triangle in the order of its posed corners.
pub(super) fn corner_indices(posed: PosedScene<'_>, shape: &Shape, primitive: u32) -> [u32; 3] {
    let local = (primitive - shape.first_triangle) as usize;
    let [a, b, c] = shape.primitive(posed.scene).triangles[local];
    if shape.mirrored { [a, c, b] } else { [a, b, c] }
}

/// Interpolating the corners rounds each component a few times relative to the largest of them, and a ray's origin is
/// itself rounded; the sum along the normal bounds how far the point can be from the true plane.
fn offset_distance(normal: Vec3, corners: [Vec3; 3], origin: Vec3) -> f32 {
    const ROUNDINGS: f32 = 16.0;
    let largest = corners.iter().fold(origin.abs(), |largest, corner| largest.max(corner.abs()));
    normal.abs().dot(largest) * (ROUNDINGS * f32::EPSILON) + f32::MIN_POSITIVE
}

/// Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II (2021), chapter 4: the point is lifted onto the curved
/// surface that the vertex normals suggest, so that flat facets of a smooth surface do not shadow themselves.
fn terminator_free_point(
    position: Vec3,
    corners: [Vec3; 3],
    vertices: &[PosedVertex; 3],
    weights: [f32; 3],
    side: f32,
) -> Vec3 {
    let mut lifted = position;
    for ((corner, vertex), weight) in corners.into_iter().zip(vertices).zip(weights) {
        let normal = vertex.normal * side;
        let height = (position - corner).dot(normal);
        if height < 0.0 {
            lifted -= normal * (height * weight);
        }
    }
    lifted
}
