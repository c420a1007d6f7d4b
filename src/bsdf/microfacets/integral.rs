//! The quadrature over a region of microfacet normals.

use fearless_simd::Level;
use glam::{DVec2, DVec3};

use super::arc_points::{ArcPoints, rule};
use super::lobe::Microfacets;
use super::region::{Arc, Range, RegionFrame, direction};
use crate::geometry::vectorized;

/// A view is grazing where its cosine is below this share of the length of the scaled view.
const GRAZING: f64 = 0.9;
/// A bound of the region of normals.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bound {
    /// Facets that reflect light from above the surface.
    Above,
    /// Facets at which the squared cosine is at least this.
    Critical(f64),
}

impl Microfacets {
    /// ∫ f D V cos θ_i dω_i for each of several factors f of the angle at the facet.
    pub(in crate::bsdf) fn reflected<const N: usize>(&self, factors: impl Fn(f32) -> [f32; N]) -> [f32; N] {
        self.integrate(None, factors)
    }

    /// The same integral over facets at which the squared cosine is at least `critical_squared`. The factors may start like a square
    /// root there.
    pub(in crate::bsdf) fn reflected_within<const N: usize>(
        &self,
        critical_squared: f64,
        factors: impl Fn(f32) -> [f32; N],
    ) -> [f32; N] {
        self.integrate(Some(Bound::Critical(critical_squared)), factors)
    }

    fn integrate<const N: usize>(
        &self,
        critical: Option<Bound>,
        factors: impl Fn(f32) -> [f32; N],
    ) -> [f32; N] {
        vectorized!(Level::new(), self.integrate_in_lanes(critical, factors))
    }

    #[inline(always)]
    fn integrate_in_lanes<const N: usize>(
        &self,
        critical: Option<Bound>,
        factors: impl Fn(f32) -> [f32; N],
    ) -> [f32; N] {
        let rule = rule();
        let frame = RegionFrame::new(self);
        let arcs = self.arcs(&frame, Bound::Above);
        let is_isotropic = self.alpha.x == self.alpha.y;
        let arcs = critical.map_or(arcs, |bound| {
            let both = arcs.and(self.arcs(&frame, bound));
            if is_isotropic { both } else { both.trimmed(|tangent| self.is_within(&frame, tangent, bound)) }
        });
        let (frame, reach) = frame.centred(arcs);
        let mut sums = [0.0; N];
        // The borders of anisotropic lobes may cross the arcs obliquely, most of all at grazing views and at the critical angle.
        let is_oblique = !is_isotropic && (critical.is_some() || self.wo.z < GRAZING * self.length);
        for (share, weight) in if is_oblique { &rule.many_arcs } else { &rule.arcs } {
            let tangent = reach * (2.0 * share - 1.0);
            let arc = self.arc(&frame, tangent);
            let points = self.points(&arc, Bound::Above);
            let points = critical.map_or(points, |bound| points.and(self.points(&arc, bound)));
            if points.to <= points.from {
                continue;
            }
            let arc = ArcPoints::new(self, &arc);
            let weight = (weight * 4.0 * reach / (1.0 + tangent * tangent)) as f32;
            let part = if is_isotropic {
                arc.integrate(Range { from: 0.0, to: points.to }, &rule.half, &factors)
            } else {
                arc.integrate(points, &rule.whole, &factors)
            };
            for (sum, part) in sums.iter_mut().zip(part) {
                *sum += part * if is_isotropic { 2.0 * weight } else { weight };
            }
        }
        // The visible hemisphere covers π (1 + v_z) / 2 of the plane across the view.
        let norm = (2.0 / (std::f64::consts::PI * (1.0 + self.view.z))) as f32;
        sums.map(|sum| sum * norm)
    }

    /// The bound as a symmetric form of two vectors; a normal is within where its form with itself is at most 0.
    #[inline(always)]
    fn form(&self, bound: Bound, a: DVec3, b: DVec3) -> f64 {
        let lengths = (a * self.alpha).dot(b * self.alpha);
        let (along_a, along_b) = (self.length * self.view.dot(a), self.length * self.view.dot(b));
        match bound {
            Bound::Above => self.wo.z * lengths - (along_a * b.z + along_b * a.z),
            Bound::Critical(squared) => squared * lengths - along_a * along_b,
        }
    }

    /// The arcs that intersect the region of a bound, by the tangent of half their angle from the frame's facing normal.
    fn arcs(&self, frame: &RegionFrame, bound: Bound) -> Range {
        let across = self.form(bound, frame.axis, frame.axis);
        if across <= 0.0 {
            return Range::ALL;
        }
        // The negative discriminant of an arc's intersections with the border
        let discriminant = |a: DVec3, b: DVec3| {
            self.form(bound, a, b) * across
                - self.form(bound, a, frame.axis) * self.form(bound, b, frame.axis)
        };
        let (facing, upward) = (frame.facing, frame.upward);
        // The facing normal is within every bound except for rounding.
        Range::within(
            discriminant(upward, upward),
            discriminant(facing, upward),
            negative(discriminant(facing, facing)),
        )
    }

    /// Whether an arc has points within a bound that reflect light from above the surface.
    fn is_within(&self, frame: &RegionFrame, tangent: f64, bound: Bound) -> bool {
        let arc = self.arc(frame, tangent);
        let both = self.points(&arc, Bound::Above).and(self.points(&arc, bound));
        both.from < both.to
    }

    /// The arc at the given tangent of half its angle from the facing normal.
    #[inline(always)]
    fn arc(&self, frame: &RegionFrame, tangent: f64) -> Arc {
        let level = frame.level(tangent);
        // The arc's normal of the largest cosine to the view, and its normal at a right angle to the view: so both bounds are
        // ellipses.
        let seen = direction(DVec2::new(self.view.dot(level), self.view.dot(frame.axis)));
        Arc {
            middle: level * seen.x + frame.axis * seen.y,
            edge: frame.axis * seen.x - level * seen.y,
            level: DVec2::new(seen.x, -seen.y),
        }
    }

    /// The points of an arc within the bound, by the tangent of half their angle from its middle.
    #[inline(always)]
    fn points(&self, arc: &Arc, bound: Bound) -> Range {
        let form = |a: DVec3, b: DVec3| self.form(bound, a, b);
        Range::within(form(arc.edge, arc.edge), form(arc.middle, arc.edge), form(arc.middle, arc.middle))
    }
}

fn negative(value: f64) -> f64 {
    if value < 0.0 { value } else { 0.0 }
}
