//! What a ray stands for: how it changes from one sample to its neighbours.
//!
//! Source: Igehy, "Tracing Ray Differentials" (SIGGRAPH 1999): the derivatives of a ray's origin and direction by a step
//! along the picture's rows and columns are carried to surfaces (section 3.1.1) and through mirrors and refraction
//! (3.1.2, 3.1.3). Cones would be cheaper but round: at grazing angles, in curved mirrors and behind glass the area that a
//! ray stands for is long and narrow.
//!
//! Normals change as the vertices' do. What a normal map adds is left out: its mean is looked up instead.

use glam::{Vec2, Vec3};

use super::SurfacePoint;
use crate::frame::Frame;
use crate::geometry::Triangle;

/// Derivatives of a ray by one step along the rows and one along the columns of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayDifferential {
    /// How the origin moves, metres.
    pub origin: [Vec3; 2],
    /// How the unit direction turns.
    pub direction: [Vec3; 2],
}

impl RayDifferential {
    /// A ray that stands for nothing but itself.
    pub const ZERO: Self = Self { origin: [Vec3::ZERO; 2], direction: [Vec3::ZERO; 2] };

    /// The steps in the plane of `normal` that the ray along the unit vector `direction` makes where it meets it at `t`.
    /// Infinite or not a number where the ray grazes the plane.
    pub(super) fn on_surface(&self, direction: Vec3, t: f32, normal: Vec3) -> [Vec3; 2] {
        let per_cosine = 1.0 / direction.dot(normal);
        [0, 1].map(|axis| {
            let across = self.origin[axis] + self.direction[axis] * t;
            across - direction * (across.dot(normal) * per_cosine)
        })
    }
}

impl SurfacePoint<'_> {
    /// Of the mirror ray; `arriving` belongs to the ray that met the surface.
    pub fn reflected_differential(&self, frame: &Frame, arriving: &RayDifferential) -> RayDifferential {
        let (incoming, normal) = (-self.wo, self.shading_normal);
        let turns = self.normal_steps(frame);
        // D' = D − 2 (D·N) N
        let direction = [0, 1].map(|axis| {
            let (step, turn) = (arriving.direction[axis], turns[axis]);
            let cosine_step = step.dot(normal) + incoming.dot(turn);
            step - (turn * incoming.dot(normal) + normal * cosine_step) * 2.0
        });
        RayDifferential { origin: self.position_steps, direction }
    }

    /// Of the ray that goes on along the unit vector `refracted`, where the index of refraction changes by the factor
    /// `relative_ior`; an unbent ray keeps its directions.
    pub fn refracted_differential(
        &self,
        frame: &Frame,
        arriving: &RayDifferential,
        refracted: Vec3,
        relative_ior: f32,
    ) -> RayDifferential {
        let (incoming, normal) = (-self.wo, self.shading_normal);
        if refracted == incoming {
            return RayDifferential { origin: self.position_steps, direction: arriving.direction };
        }
        let turns = self.normal_steps(frame);
        // D' = η D − μ N with μ = η (D·N) − D'·N
        let eta = 1.0 / relative_ior;
        let (cosine, cosine_behind) = (incoming.dot(normal), refracted.dot(normal));
        let mu = eta * cosine - cosine_behind;
        let mu_per_cosine = eta - eta * eta * cosine / cosine_behind;
        let direction = [0, 1].map(|axis| {
            let (step, turn) = (arriving.direction[axis], turns[axis]);
            let cosine_step = step.dot(normal) + incoming.dot(turn);
            step * eta - turn * mu - normal * (mu_per_cosine * cosine_step)
        });
        RayDifferential { origin: self.position_steps, direction }
    }

    /// How the interpolated normal turns over the steps on the surface, on the side of the viewer; not at all on flat faces.
    fn normal_steps(&self, frame: &Frame) -> [Vec3; 2] {
        let [a, b, c] =
            self.corners.map(|corner| frame.vertices[self.instance.first_vertex + corner as usize].normal);
        if a == Vec3::ZERO || b == Vec3::ZERO || c == Vec3::ZERO {
            return [Vec3::ZERO; 2];
        }
        let sum = a * self.weights[0] + b * self.weights[1] + c * self.weights[2];
        let length = libm::sqrtf(sum.dot(sum));
        if length == 0.0 {
            return [Vec3::ZERO; 2];
        }
        let normal = sum / length;
        let side = if normal.dot(self.geometric_normal) < 0.0 { -1.0 } else { 1.0 };
        let scale = side / length;
        weight_steps(&frame.triangles[self.primitive as usize], self.position_steps).map(|step| {
            let turn = (b - a) * step.x + (c - a) * step.y;
            (turn - normal * normal.dot(turn)) * scale
        })
    }
}

/// How the weights of a triangle's second and third corner change over steps in its plane; in f64, for slivers.
pub(super) fn weight_steps(triangle: &Triangle, steps: [Vec3; 2]) -> [Vec2; 2] {
    let [a, b, c] = triangle.vertices.map(Vec3::as_dvec3);
    let (to_b, to_c) = (b - a, c - a);
    let normal = to_b.cross(to_c);
    let scale = 1.0 / normal.dot(normal);
    // The normal's cross products with both edges span the plane, each perpendicular to its edge.
    let (for_b, for_c) = (to_c.cross(normal) * scale, normal.cross(to_b) * scale);
    steps.map(|step| {
        let step = step.as_dvec3();
        Vec2::new(for_b.dot(step) as f32, for_c.dot(step) as f32)
    })
}

#[cfg(test)]
mod tests;
