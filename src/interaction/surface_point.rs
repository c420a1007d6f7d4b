//! A point of a surface: geometry on the viewer's side, texture coordinates, and the starts and ends of rays.

use glam::{DVec3, Vec2, Vec3};

use super::texture_lookup::UvDifferential;
use crate::frame::{Frame, MeshInstance};
use crate::geometry::Facing;
use crate::scene::{Scene, TextureRef};
use crate::scene_view::SceneView;

/// A point of a surface, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<'a> {
    /// The mesh instance of the triangle.
    pub instance: &'a MeshInstance,
    /// Index of the triangle in the frame.
    pub triangle: u32,
    /// World-space position, interpolated from the triangle's corners.
    pub position: Vec3,
    /// Unit vector towards the viewer.
    pub wo: Vec3,
    /// The side that the ray hit.
    pub facing: Facing,
    /// Unit normal of the triangle on the side of `wo`.
    pub geometric_normal: Vec3,
    /// Unit normal for shading on the side of `wo`, normal map applied; its mirror ray leaves the surface.
    pub shading_normal: Vec3,
    /// Distance along the geometric normal that bounds the rounding errors of `position`.
    pub offset_distance: f32,
    /// End of shadow rays on the side of `wo`, before the offset: lifted to avoid the shadow terminator artifact.
    pub(super) shadow_position: Vec3,
    /// Vertex indices in the instance's primitive, in the order of the barycentric weights.
    pub(super) corners: [u32; 3],
    /// Barycentric weights of the three corners.
    pub(super) weights: [f32; 3],
    /// Steps on the surface to the hits of the neighbouring rays, metres.
    pub(super) position_steps: [Vec3; 2],
    /// Changes of the second and third barycentric weight over these steps; zero on instances without texture coordinates.
    pub(super) weight_steps: [Vec2; 2],
    /// Derivatives of the interpolated normal over these steps, where they are known beforehand.
    pub(super) normal_steps: Option<[Vec3; 2]>,
}

impl<'a> SurfacePoint<'a> {
    /// A point of `instance` with all values zero.
    pub(super) fn unplaced(instance: &'a MeshInstance) -> Self {
        Self {
            instance,
            triangle: 0,
            position: Vec3::ZERO,
            wo: Vec3::ZERO,
            facing: Facing::Front,
            geometric_normal: Vec3::ZERO,
            shading_normal: Vec3::ZERO,
            offset_distance: 0.0,
            shadow_position: Vec3::ZERO,
            corners: [0; 3],
            weights: [0.0; 3],
            position_steps: [Vec3::ZERO; 2],
            weight_steps: [Vec2::ZERO; 2],
            normal_steps: None,
        }
    }
}

impl SurfacePoint<'_> {
    /// 1 on front faces, −1 on back faces.
    #[inline(always)]
    pub(super) fn side(&self) -> f32 {
        if self.facing == Facing::Front { 1.0 } else { -1.0 }
    }

    /// Texture coordinates of a texture reference, and their change to the neighbouring rays.
    pub(super) fn uv(&self, view: SceneView<'_>, reference: &TextureRef) -> (Vec2, UvDifferential) {
        let [a, b, c] = self.instance.uvs(view.scene, reference.uv_set as usize, self.corners);
        let uv = a * self.weights[0] + b * self.weights[1] + c * self.weights[2];
        let change = |step: Vec2| (b - a) * step.x + (c - a) * step.y;
        (uv, UvDifferential([change(self.weight_steps[0]), change(self.weight_steps[1])]))
    }

    /// Texture coordinates of set `set`, without the texture transform; `None` where there is no such set.
    pub fn texture_coordinates(&self, scene: &Scene, set: usize) -> Option<Vec2> {
        let [a, b, c] = self.instance.stored_uvs(scene, set, self.corners)?;
        Some(a * self.weights[0] + b * self.weights[1] + c * self.weights[2])
    }

    /// World-space position of the same surface point in `frame`, which poses the same scene at another time, metres. Hidden nodes are posed,
    /// too. `None` for a frame of other surfaces.
    pub fn position_in(&self, frame: &Frame) -> Option<DVec3> {
        let triangle = self.triangle as usize;
        let instance = &frame.instances[*frame.instance_of_triangle.get(triangle)? as usize];
        let identity = |instance: &MeshInstance| {
            (instance.node, instance.node_instance, instance.primitive, instance.first_triangle)
        };
        if identity(instance) != identity(self.instance) {
            return None;
        }
        let corner =
            |corner: u32| frame.vertices[instance.first_vertex + corner as usize].position.as_dvec3();
        let [a, b, c] = self.corners.map(corner);
        Some(a + (b - a) * f64::from(self.weights[1]) + (c - a) * f64::from(self.weights[2]))
    }

    /// Start of rays that leave on the viewer's side.
    pub fn origin_outside(&self) -> Vec3 {
        self.position + self.geometric_normal * self.offset_distance
    }

    /// Start of rays that leave on the transmission side.
    pub fn origin_inside(&self) -> Vec3 {
        self.position - self.geometric_normal * self.offset_distance
    }

    /// End of shadow rays that light the viewer's side. `span` is the vector from their start to the point; zero for rays that start
    /// at the point.
    pub fn shadow_end_outside(&self, span: Vec3) -> Vec3 {
        self.shadow_position + self.geometric_normal * self.shadow_offset(span)
    }

    /// End of shadow rays that light the transmission side.
    pub fn shadow_end_inside(&self, span: Vec3) -> Vec3 {
        self.position - self.geometric_normal * self.shadow_offset(span)
    }

    fn shadow_offset(&self, span: Vec3) -> f32 {
        shadow_offset(self.geometric_normal, self.offset_distance, span)
    }
}

/// Offset of the ends of shadow rays. The direction of a shadow ray is its span, rounded, which moves its end. And the corners of
/// the triangle are farther from its start than from the point.
#[inline(always)]
pub(super) fn shadow_offset(normal: Vec3, offset_distance: f32, span: Vec3) -> f32 {
    let rounded = normal.abs().dot(span.abs()) * (2.0 * f32::EPSILON);
    offset_distance + rounded + plane_error(normal, span.abs().max_element())
}

/// Bound on the distance from its plane at which a ray hits a triangle whose corners are within `reach` of the ray's origin: the
/// definition of a hit ([`crate::geometry::ShearedRay`]) moves corners by at most 5 · 2⁻²⁴ of `reach`.
#[inline(always)]
pub(super) fn plane_error(normal: Vec3, reach: f32) -> f32 {
    normal.abs().element_sum() * reach * (3.0 * f32::EPSILON)
}
