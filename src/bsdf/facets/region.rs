//! Arcs across a region of normals, and ranges of angles along them.

use glam::{DVec2, DVec3};

use super::Facets;

/// Halvings that find the arcs at which two bounds of a stretched lobe meet.
const BISECTIONS: usize = 24;

/// The poles of the arcs and the arc in the middle.
pub(super) struct Frame {
    /// The normal whose facet faces the viewer, on the first arc; on the middle one once the frame is centred.
    pub(super) facing: DVec3,
    /// From there towards the surface's normal.
    pub(super) upward: DVec3,
    pub(super) axis: DVec3,
}

impl Frame {
    pub(super) fn new(facets: &Facets) -> Self {
        let facing = (facets.wo / facets.stretch).normalize();
        let level = DVec2::new(facing.x, facing.y).normalize_or(DVec2::X);
        let sine = facing.x * level.x + facing.y * level.y;
        Self { facing, upward: (level * -facing.z).extend(sine), axis: DVec3::new(-level.y, level.x, 0.0) }
    }

    /// Where the arc at half an angle's tangent from the facing normal crosses the plane of that and the surface's normal.
    pub(super) fn level(&self, turn: f64) -> DVec3 {
        let scale = 1.0 / (1.0 + turn * turn);
        self.facing * ((1.0 - turn * turn) * scale) + self.upward * (2.0 * turn * scale)
    }

    /// The frame turned to the middle of a range, and the tangent of half the angle from there to its ends.
    pub(super) fn centred(&self, range: Range) -> (Self, f64) {
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
pub(super) struct Range {
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Range {
    pub(super) const ALL: Self = Self { from: f64::NEG_INFINITY, to: f64::INFINITY };
    pub(super) const NONE: Self = Self { from: 0.0, to: 0.0 };

    /// Where square · t² + 2 mixed · t + constant ≤ 0, t the tangent of the whole angle: around 0 with a negative `constant`.
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
            // Around 0, on either side less than half a turn, in the form that keeps its digits.
            Self { from: half(constant, root - mixed), to: half(-constant, root + mixed) }
        } else {
            Self { from: half(-mixed - root, square), to: half(root - mixed, square) }
        }
    }

    /// The part around 0 at which `holds`, if that is one piece.
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

/// Normals middle · cos λ + edge · sin λ.
pub(super) struct Arc {
    pub(super) middle: DVec3,
    pub(super) edge: DVec3,
    /// Their parts along where the arc crosses the plane that it is symmetric about; dN = N·that dλ dβ.
    pub(super) level: DVec2,
}
