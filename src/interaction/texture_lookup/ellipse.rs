//! The ellipse of a lookup, its mip level and its number of probes.

use glam::Vec2;

use crate::scene::{MAX_PROBES, PROBE_SPACING};

/// Derivatives of texture coordinates by one step along the rows and one along the columns of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::interaction) struct UvDifferential(pub(in crate::interaction) [Vec2; 2]);

/// The ellipse of a lookup, in texels of the full image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ellipse {
    /// Length of the long axis; infinite where the derivatives are not finite.
    pub(super) long: f32,
    /// Length of the short axis.
    short: f32,
    /// Unit vector along the long axis.
    pub(super) direction: Vec2,
}

impl Ellipse {
    /// The ellipse of a parallelogram: the singular values of the matrix of both steps, and its first left singular vector.
    pub(super) fn of_steps([a, b]: [Vec2; 2]) -> Self {
        let (xx, yy, xy) = (a.x * a.x + b.x * b.x, a.y * a.y + b.y * b.y, a.x * a.y + b.x * b.y);
        let half_difference = (xx - yy) * 0.5;
        let root = (half_difference * half_difference + xy * xy).sqrt();
        let long = ((xx + yy) * 0.5 + root).sqrt();
        if !long.is_finite() {
            return Self { long: f32::INFINITY, short: f32::INFINITY, direction: Vec2::X };
        }
        // The form of the eigenvector that does not cancel
        let direction = if half_difference >= 0.0 {
            Vec2::new(half_difference + root, xy)
        } else {
            Vec2::new(xy, root - half_difference)
        };
        Self { long, short: a.perp_dot(b).abs() / long, direction: direction.normalize_or(Vec2::X) }
    }

    /// The width of a probe: the short axis, but at least a texel, and wide enough for the probes to cover the long axis.
    pub(super) fn width(&self) -> f32 {
        let needed = self.long / (MAX_PROBES as f32 * PROBE_SPACING);
        let width = if self.short > needed { self.short } else { needed };
        if width > 1.0 { width } else { 1.0 }
    }

    /// Number of probes along the long axis. Each is a tent twice as wide as its texels, so probes leave no gap even where they are
    /// farther apart than their width.
    pub(super) fn probes(&self, width: f32) -> u32 {
        if !self.long.is_finite() {
            return 1;
        }
        let needed = self.long / (width * PROBE_SPACING) - 0.1;
        let whole = needed as u32;
        if whole as f32 == needed && whole > 0 { whole } else { whole + 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ellipses_have_known_axes() {
        // Steps that are perpendicular are the axes themselves.
        let plain = Ellipse::of_steps([Vec2::new(0.0, 3.0), Vec2::new(2.0, 0.0)]);
        assert!((plain.long - 3.0).abs() < 1e-6 && (plain.short - 2.0).abs() < 1e-6);
        assert!(plain.direction.x.abs() < 1e-6);
        // (3, 3) and (1, −1): long 3√2 along the diagonal, short √2.
        let diagonal = Ellipse::of_steps([Vec2::new(3.0, 3.0), Vec2::new(1.0, -1.0)]);
        assert!((diagonal.long - 18_f32.sqrt()).abs() < 1e-5 && (diagonal.short - 2_f32.sqrt()).abs() < 1e-5);
        assert!((diagonal.direction.x - diagonal.direction.y).abs() < 1e-6);
        // A shear: the singular values of ((1, 4), (0, 1)) are √5 ± 2.
        let sheared = Ellipse::of_steps([Vec2::new(1.0, 0.0), Vec2::new(4.0, 1.0)]);
        assert!((sheared.long - (5_f32.sqrt() + 2.0)).abs() < 1e-5);
        assert!((sheared.short - (5_f32.sqrt() - 2.0)).abs() < 1e-5);
        // A line and a point have no second axis.
        let line = Ellipse::of_steps([Vec2::new(3.0, 4.0), Vec2::new(-3.0, -4.0)]);
        assert!((line.long - 50_f32.sqrt()).abs() < 1e-5 && line.short == 0.0);
        assert_eq!((line.width(), line.probes(line.width())), (1.0, 5));
        for broken in [f32::NAN, f32::INFINITY, 1e30] {
            let ellipse = Ellipse::of_steps([Vec2::splat(broken), Vec2::X]);
            assert_eq!((ellipse.width(), ellipse.probes(ellipse.width())), (f32::INFINITY, 1));
        }
    }
}
