//! Ray differentials through reflection and refraction at a surface (Igehy 1999, sections 3.1.2 and 3.1.3).
//!
//! The normal's derivative is that of the interpolated vertex normals. Normal maps are left out: their mean is looked up instead.

use glam::{Vec2, Vec3};

use super::ray_differential::{RayDifferential, weight_steps};
use super::surface_point::SurfacePoint;
use crate::frame::Frame;

impl SurfacePoint<'_> {
    /// The differential of the mirror ray; `arriving` is that of the ray that hit the surface.
    pub fn reflected_differential(&self, frame: &Frame, arriving: &RayDifferential) -> RayDifferential {
        let (incoming, normal) = (-self.wo, self.shading_normal);
        let normal_steps = self.normal_steps(frame);
        // D' = D − 2 (D·N) N
        let derivative = |axis: usize| {
            let (step, normal_step) = (arriving.direction[axis], normal_steps[axis]);
            let cosine_step = step.dot(normal) + incoming.dot(normal_step);
            step - (normal_step * incoming.dot(normal) + normal * cosine_step) * 2.0
        };
        RayDifferential { origin: self.position_steps, direction: [derivative(0), derivative(1)] }
    }

    /// The differential of the refracted ray along the unit vector `refracted`, where the index of refraction changes by the factor
    /// `relative_ior`. An unbent ray keeps the derivatives of its direction.
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
        let normal_steps = self.normal_steps(frame);
        // D' = η D − μ N with μ = η (D·N) − D'·N
        let eta = 1.0 / relative_ior;
        let (cosine, cosine_transmitted) = (incoming.dot(normal), refracted.dot(normal));
        let mu = eta * cosine - cosine_transmitted;
        let mu_per_cosine = eta - eta * eta * cosine / cosine_transmitted;
        let derivative = |axis: usize| {
            let (step, normal_step) = (arriving.direction[axis], normal_steps[axis]);
            let cosine_step = step.dot(normal) + incoming.dot(normal_step);
            step * eta - normal_step * mu - normal * (mu_per_cosine * cosine_step)
        };
        RayDifferential { origin: self.position_steps, direction: [derivative(0), derivative(1)] }
    }

    /// Derivatives of the interpolated normal on the viewer's side over the steps on the surface; zero on flat faces.
    fn normal_steps(&self, frame: &Frame) -> [Vec3; 2] {
        let vertices = &frame.vertices[self.instance.first_vertex..];
        let normal = |corner: usize| vertices[self.corners[corner] as usize].normal;
        let [a, b, c] = [normal(0), normal(1), normal(2)];
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
        let [row, column] =
            weight_steps(frame.triangles[self.triangle as usize].vertices, self.position_steps);
        let derivative = |step: Vec2| {
            let change = (b - a) * step.x + (c - a) * step.y;
            (change - normal * normal.dot(change)) * scale
        };
        [derivative(row), derivative(column)]
    }
}

#[cfg(test)]
mod tests;
