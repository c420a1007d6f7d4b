//! Ray differentials through reflection and refraction at a surface (Igehy 1999, sections 3.1.2 and 3.1.3).
//!
//! The normal's derivative is that of the interpolated vertex normals. Normal maps are left out: their mean is looked up instead.

use glam::{Vec2, Vec3};

use super::normal::{authored_side, inside_out_cosine, is_smooth, weighted_sum};
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
            return self.passed_differential(arriving);
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

    /// The differential of a ray that leaves the surface as wide as the one that arrived: a thin wall scatters light, but does not focus it.
    pub fn passed_differential(&self, arriving: &RayDifferential) -> RayDifferential {
        RayDifferential { origin: self.position_steps, direction: arriving.direction }
    }

    /// Derivatives of the interpolated normal on the viewer's side over the steps on the surface; zero on flat faces.
    fn normal_steps(&self, frame: &Frame) -> [Vec3; 2] {
        self.normal_steps.unwrap_or_else(|| {
            let vertices = &frame.vertices[self.instance.first_vertex..];
            let normals = self.corners.map(|corner| vertices[corner as usize].normal);
            let corners = frame.triangles[self.triangle as usize].vertices;
            let weight_steps = weight_steps(corners, self.position_steps);
            let side = self.side();
            let least_cosine = inside_out_cosine(self.instance);
            let side = side * authored_side(normals, self.geometric_normal * side, least_cosine);
            normal_steps(normals, self.weights, weight_steps, side)
        })
    }
}

/// Derivatives of an interpolated normal times `side`, 1 or −1, by two steps of the barycentric weights; zero unless all vertices have
/// normals. For loops over lanes.
#[inline(always)]
pub(super) fn normal_steps(
    normals: [Vec3; 3],
    weights: [f32; 3],
    weight_steps: [Vec2; 2],
    side: f32,
) -> [Vec3; 2] {
    let [a, b, c] = normals;
    let sum = weighted_sum(normals, weights);
    let length = sum.dot(sum).sqrt();
    let normal = sum / length;
    let scale = side / length;
    let is_curved = is_smooth(normals) && length != 0.0;
    let derivative = |step: Vec2| {
        let change = (b - a) * step.x + (c - a) * step.y;
        let derivative = (change - normal * normal.dot(change)) * scale;
        if is_curved { derivative } else { Vec3::ZERO }
    };
    [derivative(weight_steps[0]), derivative(weight_steps[1])]
}

#[cfg(test)]
mod tests;
