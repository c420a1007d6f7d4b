//! Integrals over the facets of a GGX lobe that a view sees, by quadrature: round or stretched, with any factor of the angle at
//! the facet.
//!
//! Sources: visible normals of Heitz, "Sampling the GGX Distribution of Visible Normals", 2018: stretched by α the surface is a
//! hemisphere, whose seen normals N are uniform across the view. Nodes and weights: Gauss and Legendre (Press et al.,
//! "Numerical Recipes", 3rd edition, section 4.6).
//!
//! What bounds the integral is a quadratic form of N: mirrored light that runs along the surface, and the critical angle of
//! total reflection at the facet. Both bounds hold N = o/α, whose facet faces the viewer. The region is cut into arcs
//! from pole to pole of an axis across the plane of that N and the normal, so that its border is met exactly on each arc and
//! nothing within has a kink.

mod points;
mod region;

use glam::{DVec2, DVec3, Vec2, Vec3};

use points::{Points, rule};
use region::{Arc, Frame, Range};

/// A view is close to the surface where its cosine is less than this share of the stretched view's length.
const GRAZING: f64 = 0.9;
/// Cosine of the views that stand for those along the surface.
const LOWEST: f64 = 1e-12;

/// The lobe of a view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facets {
    wo: DVec3,
    /// α along X and Y, 1 along Z.
    stretch: DVec3,
    /// Length of the stretched view.
    length: f64,
    /// The stretched view's direction.
    view: DVec3,
}

/// Which facets count.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bound {
    /// Those that mirror light from above the surface.
    Above,
    /// Those at which the cosine's square is at least this.
    Critical(f64),
}

impl Facets {
    /// A lobe with `alpha` along X and Y, both above 0.
    pub(super) fn anisotropic(wo: Vec3, alpha: Vec2) -> Self {
        Self::new(wo.as_dvec3(), alpha.as_dvec2())
    }

    /// A lobe of the same α all around, above 0.
    pub(super) fn isotropic(cos_o: f32, alpha: f32) -> Self {
        let cosine = f64::from(cos_o);
        Self::new(DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine), DVec2::splat(f64::from(alpha)))
    }

    fn new(mut wo: DVec3, alpha: DVec2) -> Self {
        // Along the surface the limit is that of views just above it.
        if wo.z < LOWEST {
            wo.z = LOWEST;
        }
        let stretch = alpha.extend(1.0);
        let length = (wo * stretch).length();
        Self { wo, stretch, length, view: wo * stretch / length }
    }

    /// ∫ f D V cos θ_i dω_i for each of several factors f of the angle at the facet.
    pub(super) fn reflected<const N: usize>(&self, factors: impl Fn(f32) -> [f32; N]) -> [f32; N] {
        self.integrate(None, factors)
    }

    /// The same over facets at which the square of the angle's cosine is at least `critical_squared`; the factors may
    /// begin like a square root there.
    pub(super) fn reflected_within<const N: usize>(
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
        let rule = rule();
        let frame = Frame::new(self);
        let arcs = self.arcs(&frame, Bound::Above);
        let round = self.stretch.x == self.stretch.y;
        let arcs = critical.map_or(arcs, |bound| {
            let both = arcs.and(self.arcs(&frame, bound));
            if round { both } else { both.trimmed(|turn| self.is_met(&frame, turn, bound)) }
        });
        let (frame, reach) = frame.centred(arcs);
        let mut sums = [0.0; N];
        // The borders of stretched lobes may run aslant to the arcs, close to the surface and at the critical angle most of all.
        let aslant = !round && (critical.is_some() || self.wo.z < GRAZING * self.length);
        for (share, weight) in if aslant { &rule.many_arcs } else { &rule.arcs } {
            let turn = reach * (2.0 * share - 1.0);
            let arc = self.arc(&frame, turn);
            let points = self.points(&arc, Bound::Above);
            let points = critical.map_or(points, |bound| points.and(self.points(&arc, bound)));
            if points.to <= points.from {
                continue;
            }
            let arc = Points::new(self, &arc);
            let weight = (weight * 4.0 * reach / (1.0 + turn * turn)) as f32;
            let part = if round {
                arc.integrate(Range { from: 0.0, to: points.to }, &rule.half, &factors)
            } else {
                arc.integrate(points, &rule.whole, &factors)
            };
            for (sum, part) in sums.iter_mut().zip(part) {
                *sum += part * if round { 2.0 * weight } else { weight };
            }
        }
        // The seen hemisphere covers π (1 + v_z) / 2 of the plane across the view.
        let norm = (2.0 / (std::f64::consts::PI * (1.0 + self.view.z))) as f32;
        sums.map(|sum| sum * norm)
    }

    /// The bound as a symmetric form of two vectors; a normal is within where its form with itself is at most 0.
    fn form(&self, bound: Bound, a: DVec3, b: DVec3) -> f64 {
        let lengths = (a * self.stretch).dot(b * self.stretch);
        let (along_a, along_b) = (self.length * self.view.dot(a), self.length * self.view.dot(b));
        match bound {
            Bound::Above => self.wo.z * lengths - (along_a * b.z + along_b * a.z),
            Bound::Critical(squared) => squared * lengths - along_a * along_b,
        }
    }

    /// The arcs that meet the bound, by half their angle from the frame's facing normal.
    fn arcs(&self, frame: &Frame, bound: Bound) -> Range {
        let across = self.form(bound, frame.axis, frame.axis);
        if across <= 0.0 {
            return Range::ALL;
        }
        // −(discriminant) of an arc's crossings with the border.
        let apart = |a: DVec3, b: DVec3| {
            self.form(bound, a, b) * across
                - self.form(bound, a, frame.axis) * self.form(bound, b, frame.axis)
        };
        let (facing, upward) = (frame.facing, frame.upward);
        // The facing normal is within every bound, but for rounding.
        Range::within(apart(upward, upward), apart(facing, upward), negative(apart(facing, facing)))
    }

    /// Whether an arc has points that are within a bound and mirror light from above the surface.
    fn is_met(&self, frame: &Frame, turn: f64, bound: Bound) -> bool {
        let arc = self.arc(frame, turn);
        let both = self.points(&arc, Bound::Above).and(self.points(&arc, bound));
        both.from < both.to
    }

    /// The arc at half an angle's tangent from the facing normal.
    fn arc(&self, frame: &Frame, turn: f64) -> Arc {
        let level = frame.level(turn);
        // The normal that is seen most, and the one of the same arc that is seen edge-on: so both bounds are ellipses.
        let seen = DVec2::new(self.view.dot(level), self.view.dot(frame.axis)).normalize_or(DVec2::X);
        Arc {
            middle: level * seen.x + frame.axis * seen.y,
            edge: frame.axis * seen.x - level * seen.y,
            level: DVec2::new(seen.x, -seen.y),
        }
    }

    /// The points of an arc within the bound, by half their angle from its middle.
    fn points(&self, arc: &Arc, bound: Bound) -> Range {
        let form = |a: DVec3, b: DVec3| self.form(bound, a, b);
        Range::within(form(arc.edge, arc.edge), form(arc.middle, arc.edge), form(arc.middle, arc.middle))
    }
}

fn negative(value: f64) -> f64 {
    if value < 0.0 { value } else { 0.0 }
}
