//! Geometry at a hit: point, error bound, normals on the viewer's side, and where shadow rays end.

use glam::{DVec3, Vec2, Vec3};

use super::ray_differential::weight_steps;
use super::texture_lookup::{Lookups, UvDifferential};
use super::{RayDifferential, normal};
use crate::bvh::{Hit, TriangleFlags};
use crate::frame::{Frame, MeshInstance, PosedVertex};
use crate::geometry::{Facing, Ray, Triangle, unit};
use crate::scene::{Scene, TextureRef};
use crate::scene_view::SceneView;

/// A point of a surface, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<'a> {
    /// The mesh primitive that was hit.
    pub instance: &'a MeshInstance,
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
    /// Vertex subscripts in the instance's primitive, in the order of the barycentric weights.
    pub(super) corners: [u32; 3],
    /// Weights of the three corners.
    pub(super) weights: [f32; 3],
    /// How far on the surface the neighbours of the ray lie, metres.
    pub(super) position_steps: [Vec3; 2],
    /// How the weights of the second and third corner change over these steps; known where there are texture coordinates.
    weight_steps: [Vec2; 2],
}

impl<'a> SurfacePoint<'a> {
    /// The point where `ray` meets `hit`. A ray that stands for more than itself has a direction of unit length.
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
            primitive: hit.triangle,
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

    /// Texture coordinates that `reference` looks up, and how they change over the ray's footprint.
    pub(super) fn uv(&self, view: SceneView<'_>, reference: &TextureRef) -> (Vec2, UvDifferential) {
        let [a, b, c] = self.instance.uvs(view.scene, reference.uv_set as usize, self.corners);
        let uv = a * self.weights[0] + b * self.weights[1] + c * self.weights[2];
        (uv, UvDifferential(self.weight_steps.map(|step| (b - a) * step.x + (c - a) * step.y)))
    }

    /// Texture coordinates of set `set` as the file has them; zero where there is no such set.
    pub fn texture_coordinates(&self, scene: &Scene, set: usize) -> Vec2 {
        let [a, b, c] = self.instance.uvs(scene, set, self.corners);
        a * self.weights[0] + b * self.weights[1] + c * self.weights[2]
    }

    /// Where the same point of the surface is in `frame`, which poses the same scene at another time; `None` where the
    /// surface is hidden there. World space, metres.
    pub fn position_in(&self, frame: &Frame) -> Option<DVec3> {
        let primitive = self.primitive as usize;
        let instance = &frame.instances[*frame.instance_of_triangle.get(primitive)? as usize];
        let place = |instance: &MeshInstance| {
            (instance.node, instance.node_instance, instance.primitive, instance.first_triangle)
        };
        if place(instance) != place(self.instance) || frame.flags[primitive].has(TriangleFlags::HIDDEN) {
            return None;
        }
        let corner =
            |corner: u32| frame.vertices[instance.first_vertex + corner as usize].position.as_dvec3();
        let [a, b, c] = self.corners.map(corner);
        Some(a + (b - a) * f64::from(self.weights[1]) + (c - a) * f64::from(self.weights[2]))
    }

    /// A start for rays that leave on the side of `wo`.
    pub fn origin_outside(&self) -> Vec3 {
        self.position + self.geometric_normal * self.offset_distance
    }

    /// A start for rays that pass through to the other side.
    pub fn origin_inside(&self) -> Vec3 {
        self.position - self.geometric_normal * self.offset_distance
    }

    /// The end of shadow rays that light the side of `wo` and reach over `span`, from their start to here; zero for rays
    /// that start here.
    pub fn shadow_end_outside(&self, span: Vec3) -> Vec3 {
        self.shadow_position + self.geometric_normal * self.shadow_offset(span)
    }

    /// The same for shadow rays that light the other side.
    pub fn shadow_end_inside(&self, span: Vec3) -> Vec3 {
        self.position - self.geometric_normal * self.shadow_offset(span)
    }

    /// The direction of a shadow ray is its span, rounded: where it ends is off by that much, too, and the corners of the
    /// triangle are so much farther from its start.
    fn shadow_offset(&self, span: Vec3) -> f32 {
        let rounded = self.geometric_normal.abs().dot(span.abs()) * (2.0 * f32::EPSILON);
        self.offset_distance + rounded + plane_error(self.geometric_normal, span.abs().max_element())
    }
}

/// The point of a triangle that was hit, rounded only once, so that it leaves the plane as little as floats allow.
fn interpolated(corners: [Vec3; 3], hit: &Hit) -> Vec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (a + (b - a) * f64::from(hit.u) + (c - a) * f64::from(hit.v)).as_vec3()
}

/// Vertex subscripts of a triangle in the order of its posed corners.
pub(super) fn corner_indices(view: SceneView<'_>, instance: &MeshInstance, primitive: u32) -> [u32; 3] {
    let local = (primitive - instance.first_triangle) as usize;
    let [a, b, c] = instance.primitive(view.scene).triangles[local];
    if instance.mirrored { [a, c, b] } else { [a, b, c] }
}

/// Bounds how far rounding moves a start of rays off the plane, and the plane as a ray from there meets it. The point is rounded a
/// few times, each by half a unit in the last place of its coordinates. The second term sets apart what touches here but was
/// transformed differently.
fn offset_distance(normal: Vec3, position: Vec3, triangle: &Triangle) -> f32 {
    let off_plane = normal.abs().dot(position.abs()) * (4.0 * f32::EPSILON);
    let apart = position.abs().max_element() * (2.0 * f32::EPSILON);
    let [a, b, c] = triangle.vertices.map(|corner| (corner - position).abs());
    let reach = a.max(b).max(c).max_element();
    off_plane + apart + plane_error(normal, reach) + f32::MIN_POSITIVE
}

/// How far from its plane a ray may meet a triangle whose corners are within `reach` of the ray's origin: the definition of a hit
/// ([`crate::geometry::ShearedRay`]) moves corners by at most 5 · 2⁻²⁴ of that.
fn plane_error(normal: Vec3, reach: f32) -> f32 {
    normal.abs().element_sum() * reach * (3.0 * f32::EPSILON)
}

/// Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II (2021), chapter 4: the point is lifted onto the curved
/// surface that the vertex normals suggest, so that flat facets of a smooth surface do not shadow themselves.
///
/// Normals are taken on the side of `wo`, inside-out ones too; one that still looks below the triangle lifts nothing.
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
