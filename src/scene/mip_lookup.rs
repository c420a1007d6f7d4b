//! Where anisotropic lookups read mip levels: the number and distance of their probes, and the levels between which they interpolate.

/// Limit of the probes along the long axis.
pub(crate) const MAX_PROBES: usize = 16;

/// Distance of probes along the long axis, in widths of a probe.
pub(crate) const PROBE_SPACING: f32 = 1.4;

/// The level whose texels are at most `width` wide, and the share of the next one; 0 is the full image and `last` the
/// coarsest. `width` is at least one.
pub(crate) fn level_of(width: f32, last: usize) -> (usize, f32) {
    let bits = width.to_bits();
    let level = (bits >> 23).saturating_sub(127) as usize;
    if level >= last {
        return (last, 0.0);
    }
    // The mantissa runs from one to two between two levels.
    (level, f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000) - 1.0)
}

/// The blend of two levels: in the outer quarters of the way from one to the next it is one of them alone.
pub(crate) fn blended(level: usize, share: f32) -> (usize, f32) {
    let share = (share - 0.25) * 2.0;
    if share <= 0.0 {
        (level, 0.0)
    } else if share >= 1.0 {
        (level + 1, 0.0)
    } else {
        (level, share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_follow_the_width() {
        for (width, expected) in [
            (1.0, (0, 0.0)),
            (1.5, (0, 0.5)),
            (2.0, (1, 0.0)),
            (3.0, (1, 0.5)),
            (5.0, (2, 0.25)),
            (1e9, (3, 0.0)),
        ] {
            assert_eq!(level_of(width, 3), expected, "{width}");
        }
        assert_eq!(level_of(f32::INFINITY, 3), (3, 0.0));
        assert_eq!(level_of(2.5, 0), (0, 0.0));
    }
}
