//! Bounds of the position, the directions and the power of a set of emitters.

use std::f32::consts::PI;

use glam::Vec3;

use super::emitter::Emitter;
use crate::geometry::Aabb;

/// Cosines down to this one, below zero, are taken for those of lit directions: a bound on their rounding errors.
const LEAST_COSINE: f32 = -2e-3;

/// The least factor of a cosine that may be that of a lit direction.
const LEAST_FACTOR: f32 = 1e-3;

/// The least importance of emitters that may light a point.
const LEAST_IMPORTANCE: f32 = 1e-36;

/// Bounds of a set of emitters (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018,
/// section 4.1). Emitters are diffuse: light leaves at up to θₑ = π/2 from a normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    pub(super) aabb: Aabb,
    /// Radius of a sphere around the box's centre that holds the emitters.
    pub(super) radius: f32,
    pub(super) cone: NormalCone,
    pub(super) power: f32,
    /// Whether any emitter is two-sided.
    pub(super) is_two_sided: bool,
}

/// A cone of normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct NormalCone {
    pub(super) axis: Vec3,
    /// The largest angle between the axis and a normal, θₒ.
    pub(super) theta_o: f32,
}

/// A point that is lit, and the normal of its surface if only the side that this points to is.
#[derive(Clone, Copy, Debug)]
pub(super) struct LitPoint {
    pub(super) point: Vec3,
    pub(super) normal: Option<Vec3>,
}

/// What importances make of bounds: chosen for little variance of direct light from few and many, small and large emitters.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImportanceWeights {
    /// The factor within the sphere that bounds the emitters, in place of the cosines.
    inside: f32,
    /// The weight of the cosines at the centre of emitters that are far away for their size; the rest has those of bounds.
    center: f32,
}

impl ImportanceWeights {
    /// Among emitters, which are nearly points.
    pub(super) const OF_EMITTERS: Self = Self { inside: 0.25, center: 0.9 };
    /// Among sets, of which any part may face the point, or sets and emitters.
    pub(super) const OF_SETS: Self = Self { inside: 0.5, center: 0.0 };
}

/// What the importance of a set of emitters is computed from.
#[derive(Clone, Copy, Debug)]
pub(super) struct CompactLightBounds {
    pub(super) center: Vec3,
    pub(super) radius: f32,
    pub(super) axis: Vec3,
    pub(super) cos_theta_o: f32,
    pub(super) sin_theta_o: f32,
    pub(super) power: f32,
}

impl LightBounds {
    /// The bounds of one emitter with this normal and share of all power.
    pub(super) fn of_emitter(emitter: &Emitter, normal: Vec3, power: f32) -> Self {
        let aabb = Aabb::from_points(&emitter.corners);
        let center = aabb.center();
        let radius =
            emitter.corners.iter().fold(0.0, |radius: f32, &corner| radius.max(center.distance(corner)));
        let cone = NormalCone { axis: normal, theta_o: 0.0 };
        Self { aabb, radius, cone, power, is_two_sided: emitter.is_two_sided }
    }

    /// The bounds of both sets.
    pub(super) fn union(&self, other: &Self) -> Self {
        let aabb = self.aabb.union(other.aabb);
        let center = aabb.center();
        let reach = |part: &Self| center.distance(part.aabb.center()) + part.radius;
        let radius = (0.5 * aabb.extent().length()).min(reach(self).max(reach(other))) * (1.0 + 1e-6);
        // The cone of two-sided emitters may be turned around.
        let is_opposite = self.cone.axis.dot(other.cone.axis) < 0.0;
        let cone = if is_opposite && other.is_two_sided {
            self.cone.union(&other.cone.reversed())
        } else if is_opposite && self.is_two_sided {
            self.cone.reversed().union(&other.cone)
        } else {
            self.cone.union(&other.cone)
        };
        let is_two_sided = self.is_two_sided || other.is_two_sided;
        Self { aabb, radius, cone, power: self.power + other.power, is_two_sided }
    }

    pub(super) fn compact(&self) -> CompactLightBounds {
        let (sin_theta_o, cos_theta_o) = libm::sincosf(self.cone.theta_o);
        CompactLightBounds {
            center: self.aabb.center(),
            radius: self.radius,
            axis: self.cone.axis,
            cos_theta_o,
            sin_theta_o: sin_theta_o.max(0.0),
            power: self.power,
        }
    }
}

impl NormalCone {
    fn reversed(self) -> Self {
        Self { axis: -self.axis, ..self }
    }

    /// A cone around both (algorithm 1 of the paper).
    fn union(&self, other: &Self) -> Self {
        let (a, b) = if self.theta_o >= other.theta_o { (self, other) } else { (other, self) };
        let cosine = a.axis.dot(b.axis);
        let across = b.axis - a.axis * cosine;
        let theta_d = libm::atan2f(across.length(), cosine);
        if (theta_d + b.theta_o).min(PI) <= a.theta_o {
            return *a;
        }
        // Opposite axes leave no direction to turn to.
        let theta_o = 0.5 * (a.theta_o + theta_d + b.theta_o) + 1e-6;
        if theta_o >= PI || across.length() < 1e-6 {
            let theta_o = if cosine > 0.0 { theta_o.min(PI) } else { PI };
            let needed = (theta_d + b.theta_o + 1e-6).min(PI);
            return Self { axis: a.axis, theta_o: theta_o.max(needed) };
        }
        let (sin, cos) = libm::sincosf(theta_o - a.theta_o);
        Self { axis: (a.axis * cos + across.normalize() * sin).normalize(), theta_o }
    }
}

impl CompactLightBounds {
    /// The weight of the emitters in a choice: the bound on their light of section 4.2 of the paper, adjusted by `weights`; zero only if they
    /// send none to the point, or none to the front of a surface with its normal.
    ///
    /// There are no branches, so that a loop over sets is vectorised.
    #[inline(always)]
    pub(super) fn importance(&self, at: LitPoint, is_two_sided: bool, weights: ImportanceWeights) -> f32 {
        let LitPoint { point, normal } = at;
        let to_center = self.center - point;
        let distance_squared = to_center.length_squared();
        let radius_squared = self.radius * self.radius;
        // Within the sphere, light may come from every direction. At its centre, the mean of 1 / distance² over it is 3 / r².
        let is_inside = distance_squared <= radius_squared * (1.0 + 1e-4) + f32::MIN_POSITIVE;
        let clamped = larger(larger(distance_squared, radius_squared * (1.0 / 3.0)), 1e-30);
        let inside = larger(weights.inside * self.power / clamped, LEAST_IMPORTANCE);

        let by_distance = 1.0 / distance_squared.sqrt();
        let sin_b = self.radius * by_distance;
        let cos_b = larger(1.0 - sin_b * sin_b, 0.0).sqrt();

        // Bound the cosine at the emitters: θ' = θ - (θₒ + θ_b).
        let axis_cosine = -self.axis.dot(to_center) * by_distance;
        let cosine = if is_two_sided { axis_cosine.abs() } else { axis_cosine };
        let cos_sum = self.cos_theta_o * cos_b - self.sin_theta_o * sin_b;
        let sin_sum = self.sin_theta_o * cos_b + self.cos_theta_o * sin_b;
        let is_beyond_pi = sin_sum < 0.0;
        let cosine_prime = if is_beyond_pi { 1.0 } else { cosine_of_difference(cosine, cos_sum, sin_sum) };

        // Bound the cosine at the surface: θᵢ' = θᵢ - θ_b.
        let surface_cosine = normal.map_or(1.0, |normal| normal.dot(to_center) * by_distance);
        let surface_prime = normal.map_or(1.0, |_| cosine_of_difference(surface_cosine, cos_b, sin_b));
        let is_lit = cosine_prime >= LEAST_COSINE && surface_prime >= LEAST_COSINE;
        let center = weights.center * larger(1.0 - 2.0 * sin_b, 0.0);
        let factor = |cosine: f32, prime: f32| {
            larger(prime, LEAST_FACTOR) * (1.0 - center) + larger(cosine, LEAST_FACTOR) * center
        };
        let factors = factor(cosine, cosine_prime) * factor(surface_cosine, surface_prime);
        let importance = larger(self.power * factors * (by_distance * by_distance), LEAST_IMPORTANCE);
        let outside = if is_lit { importance } else { 0.0 };
        if is_inside { inside } else { outside }
    }
}

/// The larger of two numbers; the second where the first is none.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// cos(max(a - b, 0)) of angles in [0, π].
#[inline(always)]
fn cosine_of_difference(cos_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    let cosine = cos_a * cos_b + larger(1.0 - cos_a * cos_a, 0.0).sqrt() * sin_b;
    if cos_a >= cos_b { 1.0 } else { cosine }
}
