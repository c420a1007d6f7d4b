//! Integrals over the facets of a GGX lobe that a view sees, by quadrature: round or stretched, with any factor of the angle at
//! the facet.
//!
//! Sources: visible normals of Heitz, "Sampling the GGX Distribution of Visible Normals", 2018: stretched by α the surface is a
//! hemisphere, whose seen normals N are uniform across the view. Nodes and weights: Gauss and Legendre (Press et al.,
//! "Numerical Recipes", 3rd edition, section 4.6).
//!
//! What bounds the integral is a quadratic form of N: mirrored light that runs along the surface, and the critical angle of
//! total reflection at the facet. Both bounds hold N = o/α, whose facet faces the viewer. The region is cut into arcs
//! from pole to pole of an axis across the plane of the stretched view and the normal, so that its border is met exactly on each arc and
//! nothing within has a kink.

use std::sync::OnceLock;

use glam::{DVec2, DVec3, Vec2, Vec3};

/// Arcs over the region.
const ARCS: usize = 28;
/// Points of a whole arc, and of half of one, which will do for round lobes.
const POINTS: usize = 20;
const HALF_POINTS: usize = 8;
/// Arcs where a border crosses them aslant.
const MANY_ARCS: usize = 64;
/// A view is close to the surface where its cosine is less than this share of the stretched view's length.
const GRAZING: f64 = 0.9;
/// Halvings that find the arcs at which two bounds of a stretched lobe meet.
const BISECTIONS: usize = 24;
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
    pub(super) fn stretched(wo: Vec3, alpha: Vec2) -> Self {
        Self::new(wo.as_dvec3(), alpha.as_dvec2())
    }

    /// A lobe of the same α all around, above 0.
    pub(super) fn round(cos_o: f32, alpha: f32) -> Self {
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

/// The poles of the arcs and the arc in the middle.
struct Frame {
    /// Where the arc through the normal whose facet faces the viewer crosses the plane of the seen and the surface's normal.
    facing: DVec3,
    /// From there towards the surface's normal.
    upward: DVec3,
    axis: DVec3,
}

impl Frame {
    fn new(facets: &Facets) -> Self {
        let facing = facets.wo / facets.stretch;
        let level = DVec2::new(facing.x, facing.y).normalize_or(DVec2::X);
        let facing = DVec2::new(facing.x * level.x + facing.y * level.y, facing.z).normalize();
        Self {
            facing: (level * facing.x).extend(facing.y),
            upward: (level * -facing.y).extend(facing.x),
            axis: DVec3::new(-level.y, level.x, 0.0),
        }
    }

    /// Where the arc at half an angle's tangent from the facing normal crosses the plane of that and the surface's normal.
    fn level(&self, turn: f64) -> DVec3 {
        let scale = 1.0 / (1.0 + turn * turn);
        self.facing * ((1.0 - turn * turn) * scale) + self.upward * (2.0 * turn * scale)
    }

    /// The frame turned to the middle of a range, and the tangent of half the angle from there to its ends.
    fn centred(&self, range: Range) -> (Self, f64) {
        let direction = |t: f64| DVec2::new(1.0 - t * t, 2.0 * t) / (1.0 + t * t);
        let both = direction(range.from) + direction(range.to);
        let middle = both.normalize_or(DVec2::X);
        // |both| is twice the cosine of the angle to either end.
        let cosine = 0.5 * both.length();
        let reach = if cosine < 1.0 { ((1.0 - cosine) / (1.0 + cosine)).sqrt() } else { 0.0 };
        let turned = Self {
            facing: self.facing * middle.x + self.upward * middle.y,
            upward: self.upward * middle.x - self.facing * middle.y,
            axis: self.axis,
        };
        (turned, reach)
    }
}

/// Tangents of half the angles at both ends of an arc.
#[derive(Clone, Copy, Debug)]
struct Range {
    from: f64,
    to: f64,
}

impl Range {
    const ALL: Self = Self { from: f64::NEG_INFINITY, to: f64::INFINITY };
    const NONE: Self = Self { from: 0.0, to: 0.0 };

    /// Where square · t² + 2 mixed · t + constant ≤ 0, t the tangent of the whole angle: around 0 with a negative `constant`.
    fn within(square: f64, mixed: f64, constant: f64) -> Self {
        let discriminant = mixed * mixed - square * constant;
        if discriminant < 0.0 {
            return if square < 0.0 { Self::ALL } else { Self::NONE };
        }
        let root = discriminant.sqrt();
        let half = |opposite: f64, adjacent: f64| {
            let hypotenuse = (opposite * opposite + adjacent * adjacent).sqrt();
            opposite / (adjacent + hypotenuse)
        };
        if constant < 0.0 {
            // Around 0, on either side less than half a turn, in the form that keeps its digits.
            Self { from: half(constant, root - mixed), to: half(-constant, root + mixed) }
        } else {
            Self { from: half(-mixed - root, square), to: half(root - mixed, square) }
        }
    }

    /// The part around 0 at which `holds`, if that is one piece.
    fn trimmed(self, holds: impl Fn(f64) -> bool) -> Self {
        let end = |end: f64| {
            let (mut inside, mut outside) = (0.0, end);
            for _ in 0..BISECTIONS {
                let middle = f64::midpoint(inside, outside);
                if holds(middle) { inside = middle } else { outside = middle }
            }
            inside
        };
        Self { from: end(self.from), to: end(self.to) }
    }

    fn and(self, other: Self) -> Self {
        Self {
            from: if other.from > self.from { other.from } else { self.from },
            to: if other.to < self.to { other.to } else { self.to },
        }
    }
}

/// Normals middle · cos λ + edge · sin λ.
struct Arc {
    middle: DVec3,
    edge: DVec3,
    /// Their parts along where the arc crosses the plane that it is symmetric about; dN = N·that dλ dβ.
    level: DVec2,
}

/// What the points of an arc need.
struct Points {
    wo: Vec3,
    stretch: Vec3,
    length: f32,
    /// The arc's normals, stretched.
    middle: Vec3,
    edge: Vec3,
    /// The cosine of the arc's middle to the view; that of its edge is 0.
    seen: f32,
    level: Vec2,
}

impl Points {
    fn new(facets: &Facets, arc: &Arc) -> Self {
        Self {
            wo: facets.wo.as_vec3(),
            stretch: facets.stretch.as_vec3(),
            length: facets.length as f32,
            middle: (arc.middle * facets.stretch).as_vec3(),
            edge: (arc.edge * facets.stretch).as_vec3(),
            seen: facets.view.dot(arc.middle) as f32,
            level: arc.level.as_vec2(),
        }
    }

    /// ∫ f G2 / G1 (v·N) dN / dβ.
    fn integrate<const N: usize>(
        &self,
        range: Range,
        points: &[(f32, f32)],
        factors: impl Fn(f32) -> [f32; N],
    ) -> [f32; N] {
        let (from, width) = (range.from as f32, (range.to - range.from) as f32);
        let mut sums = [0.0; N];
        for (share, weight) in points {
            let turn = from + width * share;
            let scale = 1.0 / (1.0 + turn * turn);
            let (cosine, sine) = ((1.0 - turn * turn) * scale, 2.0 * turn * scale);
            // The facet and the mirrored direction
            let normal = self.middle * cosine + self.edge * sine;
            let shrink = 1.0 / normal.dot(normal).sqrt();
            let seen = self.seen * cosine;
            let breadth = self.level.x * cosine + self.level.y * sine;
            let facet_cosine = self.length * seen * shrink;
            let wi = normal * (2.0 * facet_cosine * shrink) - self.wo;
            let cos_i = if wi.z > 0.0 { wi.z } else { 0.0 };
            // G2 / G1
            let slopes = wi * self.stretch;
            let root_i = slopes.dot(slopes).sqrt();
            let kept = cos_i * (self.wo.z + self.length) / (cos_i * self.length + self.wo.z * root_i);
            let weight = kept * seen * breadth * (2.0 * scale * weight * width);
            let factors = factors(if facet_cosine < 1.0 { facet_cosine } else { 1.0 });
            for (sum, factor) in sums.iter_mut().zip(factors) {
                *sum += weight * factor;
            }
        }
        sums
    }
}

/// Places from 0 to 1 and their weights. All lie denser at ends where the integrand may begin like a square root.
struct Rule {
    arcs: Vec<(f64, f64)>,
    many_arcs: Vec<(f64, f64)>,
    /// From the middle of an arc to its end.
    half: Vec<(f32, f32)>,
    whole: Vec<(f32, f32)>,
}

fn rule() -> &'static Rule {
    static RULE: OnceLock<Rule> = OnceLock::new();
    RULE.get_or_init(|| {
        let eased = |(x, weight): (f64, f64)| (x * x * (3.0 - 2.0 * x), weight * 6.0 * x * (1.0 - x));
        let towards_end = |(x, weight): (f64, f64)| (x * (2.0 - x), weight * 2.0 * (1.0 - x));
        let single = |(x, weight): (f64, f64)| (x as f32, weight as f32);
        Rule {
            arcs: legendre(ARCS).map(eased).collect(),
            many_arcs: legendre(MANY_ARCS).map(eased).collect(),
            half: legendre(HALF_POINTS).map(towards_end).map(single).collect(),
            whole: legendre(POINTS).map(eased).map(single).collect(),
        }
    })
}

/// Roots of Legendre's polynomial, moved to the range from 0 to 1, and their weights.
fn legendre(count: usize) -> impl Iterator<Item = (f64, f64)> {
    let degree = count as f64;
    (0..count).map(move |index| {
        let mut x = libm::cos(std::f64::consts::PI * (index as f64 + 0.75) / (degree + 0.5));
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut before, mut value) = (1.0, x);
            for step in 2..=count {
                let step = step as f64;
                let next = ((2.0 * step - 1.0) * x * value - (step - 1.0) * before) / step;
                (before, value) = (value, next);
            }
            slope = degree * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
}
