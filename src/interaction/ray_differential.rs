//! Ray differentials: the change of a ray from one sample to its neighbours.
//!
//! Source: Igehy, "Tracing Ray Differentials" (SIGGRAPH 1999): the derivatives of a ray's origin and direction by a step along the
//! rows and columns of the image are transferred to surfaces (section 3.1.1), and through reflection and refraction (3.1.2 and
//! 3.1.3, in [`super::surface_differentials`]). Cones would be cheaper but round: at grazing angles, in curved mirrors and beyond glass
//! the area of a sample is long and narrow.

use glam::{Vec2, Vec3};

/// Derivatives of a ray by one step along the rows and one along the columns of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayDifferential {
    /// Derivatives of the origin, metres.
    pub origin: [Vec3; 2],
    /// Derivatives of the unit direction.
    pub direction: [Vec3; 2],
}

impl RayDifferential {
    /// A ray without extent.
    pub const ZERO: Self = Self { origin: [Vec3::ZERO; 2], direction: [Vec3::ZERO; 2] };

    /// The differential of the mirror ray of a plane that the ray along the unit vector `direction` hits at `t`; zero where the ray
    /// grazes the plane.
    #[must_use]
    pub fn mirrored(&self, direction: Vec3, t: f32, normal: Vec3) -> Self {
        let origin = self.on_surface(direction, t, normal);
        if !origin.iter().all(|step| step.is_finite()) {
            return Self::ZERO;
        }
        Self { origin, direction: self.direction.map(|step| step - normal * (2.0 * step.dot(normal))) }
    }

    /// Derivatives of the hit point in the plane of `normal`, for a ray along the unit vector `direction` that hits the plane at `t`.
    /// Infinite or not a number where the ray grazes the plane.
    #[inline(always)]
    pub(super) fn on_surface(&self, direction: Vec3, t: f32, normal: Vec3) -> [Vec3; 2] {
        let per_cosine = 1.0 / direction.dot(normal);
        let step = |axis: usize| {
            let across = self.origin[axis] + self.direction[axis] * t;
            across - direction * (across.dot(normal) * per_cosine)
        };
        [step(0), step(1)]
    }
}

/// Changes of a triangle's second and third barycentric weight over steps in its plane; in f64, for slivers.
#[inline(always)]
pub(super) fn weight_steps(corners: [Vec3; 3], steps: [Vec3; 2]) -> [Vec2; 2] {
    let [a, b, c] = [corners[0].as_dvec3(), corners[1].as_dvec3(), corners[2].as_dvec3()];
    let (to_b, to_c) = (b - a, c - a);
    let normal = to_b.cross(to_c);
    let scale = 1.0 / normal.dot(normal);
    // The cross products of the normal with both edges span the plane; each is perpendicular to its edge.
    let (for_b, for_c) = (to_c.cross(normal) * scale, normal.cross(to_b) * scale);
    let change = |step: Vec3| {
        let step = step.as_dvec3();
        Vec2::new(for_b.dot(step) as f32, for_c.dot(step) as f32)
    };
    [change(steps[0]), change(steps[1])]
}
