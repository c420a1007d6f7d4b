//! Quadrature along an arc of microfacet normals.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::lobe::Microfacets;
use super::region::{Arc, Range};
use crate::geometry::{F32Lanes, LANES};

/// Number of arcs over the region.
const ARCS: usize = 28;
/// Number of points on a whole arc, and on half an arc, which is enough for isotropic lobes.
const POINTS: usize = 16;
const HALF_POINTS: usize = 8;
const _: () = assert!(POINTS <= LANES && HALF_POINTS <= LANES, "a lane holds one point");
/// Number of arcs where a border crosses them obliquely.
const MANY_ARCS: usize = 64;

/// An arc prepared for integration, in single precision.
pub(super) struct ArcPoints {
    wo: Vec3,
    alpha: Vec3,
    length: f32,
    /// The arc's normals, scaled by α.
    middle: Vec3,
    edge: Vec3,
    /// The cosine of the arc's middle to the view; that of its edge is 0.
    seen: f32,
    level: Vec2,
}

impl ArcPoints {
    #[inline(always)]
    pub(super) fn new(facets: &Microfacets, arc: &Arc) -> Self {
        Self {
            wo: facets.wo.as_vec3(),
            alpha: facets.alpha.as_vec3(),
            length: facets.length as f32,
            middle: (arc.middle * facets.alpha).as_vec3(),
            edge: (arc.edge * facets.alpha).as_vec3(),
            seen: facets.view.dot(arc.middle) as f32,
            level: arc.level.as_vec2(),
        }
    }

    /// ∫ f G2 / G1 (v·N) dN / dβ.
    #[inline(always)]
    pub(super) fn integrate<const N: usize>(
        &self,
        range: Range,
        nodes: &Nodes,
        factors: impl Fn(f32) -> [f32; N],
    ) -> [f32; N] {
        let (from, width) = (range.from as f32, (range.to - range.from) as f32);
        let mut values = [[0.0; LANES]; N];
        for lane in 0..LANES {
            let tangent = from + width * nodes.shares[lane];
            let scale = 1.0 / (1.0 + tangent * tangent);
            let (cosine, sine) = ((1.0 - tangent * tangent) * scale, 2.0 * tangent * scale);
            // The facet and the reflected direction
            let normal = self.middle * cosine + self.edge * sine;
            let shrink = 1.0 / normal.dot(normal).sqrt();
            let seen = self.seen * cosine;
            let breadth = self.level.x * cosine + self.level.y * sine;
            let facet_cosine = self.length * seen * shrink;
            let wi = normal * (2.0 * facet_cosine * shrink) - self.wo;
            let cos_i = if wi.z > 0.0 { wi.z } else { 0.0 };
            // G2 / G1
            let slopes = wi * self.alpha;
            let root_i = slopes.dot(slopes).sqrt();
            let shadowing = cos_i * (self.wo.z + self.length) / (cos_i * self.length + self.wo.z * root_i);
            let weight = shadowing * seen * breadth * (2.0 * scale * nodes.weights[lane] * width);
            let factors = factors(if facet_cosine < 1.0 { facet_cosine } else { 1.0 });
            for (values, factor) in values.iter_mut().zip(factors) {
                values[lane] = weight * factor;
            }
        }
        values.map(|values| values.iter().sum())
    }
}

/// Nodes along an arc with their weights; lanes without a node have no weight.
pub(super) struct Nodes {
    shares: F32Lanes,
    weights: F32Lanes,
}

impl Nodes {
    fn new(nodes: impl Iterator<Item = (f64, f64)>) -> Self {
        let mut lanes = Self { shares: [0.0; LANES], weights: [0.0; LANES] };
        for ((share, weight), node) in lanes.shares.iter_mut().zip(&mut lanes.weights).zip(nodes) {
            (*share, *weight) = (node.0 as f32, node.1 as f32);
        }
        lanes
    }
}

/// Quadrature nodes in [0, 1] and their weights, denser towards ends where the integrand may start like a square root.
pub(super) struct Rule {
    pub(super) arcs: Vec<(f64, f64)>,
    pub(super) many_arcs: Vec<(f64, f64)>,
    /// From the middle of an arc to its end.
    pub(super) half: Nodes,
    pub(super) whole: Nodes,
}

pub(super) fn rule() -> &'static Rule {
    static RULE: OnceLock<Rule> = OnceLock::new();
    RULE.get_or_init(|| {
        let eased = |(x, weight): (f64, f64)| (x * x * (3.0 - 2.0 * x), weight * 6.0 * x * (1.0 - x));
        let towards_end = |(x, weight): (f64, f64)| (x * (2.0 - x), weight * 2.0 * (1.0 - x));
        Rule {
            arcs: legendre(ARCS).map(eased).collect(),
            many_arcs: legendre(MANY_ARCS).map(eased).collect(),
            half: Nodes::new(legendre(HALF_POINTS).map(towards_end)),
            whole: Nodes::new(legendre(POINTS).map(eased)),
        }
    })
}

/// Gauss–Legendre nodes in [0, 1] and their weights.
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
