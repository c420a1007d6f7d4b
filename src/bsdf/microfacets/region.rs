//! Arcs across a region of normals, and ranges of angles along them.

use glam::{DVec2, DVec3};

use super::lobe::Microfacets;

/// Bisection steps for the arcs at which two bounds of an anisotropic lobe intersect.
const BISECTIONS: usize = 24;

/// Orthonormal frame of the arcs: their common poles and the first arc.
pub(super) struct RegionFrame {
    /// The normal whose facet faces the viewer, on the first arc; on the middle one once the frame is centred.
    pub(super) facing: DVec3,
    /// Unit vector from there towards the surface normal.
    pub(super) upward: DVec3,
    pub(super) axis: DVec3,
}

impl RegionFrame {
    pub(super) fn new(facets: &Microfacets) -> Self {
        let slopes = facets.wo / facets.alpha;
        let facing = slopes * (1.0 / slopes.dot(slopes).sqrt());
        let level = direction(DVec2::new(facing.x, facing.y));
        let sine = facing.x * level.x + facing.y * level.y;
        Self { facing, upward: (level * -facing.z).extend(sine), axis: DVec3::new(-level.y, level.x, 0.0) }
    }

    /// Intersection of an arc with the plane of the facing normal and the surface normal; `tangent` is that of half the angle from
    /// the facing normal.
    pub(super) fn level(&self, tangent: f64) -> DVec3 {
        let scale = 1.0 / (1.0 + tangent * tangent);
        self.facing * ((1.0 - tangent * tangent) * scale) + self.upward * (2.0 * tangent * scale)
    }

    /// The frame rotated to the middle of a range, and the tangent of half the angle from there to its ends.
    pub(super) fn centred(&self, range: Range) -> (Self, f64) {
        let at_tangent = |t: f64| DVec2::new(1.0 - t * t, 2.0 * t) / (1.0 + t * t);
        let both = at_tangent(range.from) + at_tangent(range.to);
        let middle = direction(both);
        // |both| is twice the cosine of the angle to either end.
        let cosine = 0.5 * both.dot(both).sqrt();
        let reach = if cosine < 1.0 { ((1.0 - cosine) / (1.0 + cosine)).sqrt() } else { 0.0 };
        let rotated = Self {
            facing: self.facing * middle.x + self.upward * middle.y,
            upward: self.upward * middle.x - self.facing * middle.y,
            axis: self.axis,
        };
        (rotated, reach)
    }
}

/// A range of angles by the tangents of their halves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Range {
    pub(super) const ALL: Self = Self { from: f64::NEG_INFINITY, to: f64::INFINITY };
    pub(super) const NONE: Self = Self { from: 0.0, to: 0.0 };

    /// The range where square · t² + 2 mixed · t + constant ≤ 0, t being the tangent of the whole angle. With a negative `constant`
    /// it contains 0.
    pub(super) fn within(square: f64, mixed: f64, constant: f64) -> Self {
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
            // The form without cancellation; both ends are less than half a turn from 0.
            Self { from: half(constant, root - mixed), to: half(-constant, root + mixed) }
        } else {
            Self { from: half(-mixed - root, square), to: half(root - mixed, square) }
        }
    }

    /// The part around 0 in which `holds` is true, if that part is connected.
    pub(super) fn trimmed(self, holds: impl Fn(f64) -> bool) -> Self {
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

    pub(super) fn and(self, other: Self) -> Self {
        Self {
            from: if other.from > self.from { other.from } else { self.from },
            to: if other.to < self.to { other.to } else { self.to },
        }
    }
}

/// An arc of normals: middle · cos λ + edge · sin λ.
pub(super) struct Arc {
    pub(super) middle: DVec3,
    pub(super) edge: DVec3,
    /// Components of the vector where the arc crosses its plane of symmetry; dN = N·level dλ dβ.
    pub(super) level: DVec2,
}

/// The unit vector of `v`, X if it has no length or its square is out of range. As [`DVec2::normalize_or`], whose root is assembly for narrow
/// registers: between operations on wide ones it is slow.
#[inline(always)]
pub(super) fn direction(v: DVec2) -> DVec2 {
    let reciprocal = 1.0 / v.dot(v).sqrt();
    let has_length = reciprocal > 0.0 && reciprocal < f64::INFINITY;
    if has_length { v * reciprocal } else { DVec2::X }
}
