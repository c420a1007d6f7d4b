//! Hermite interpolation from 0 to 1 with slopes of 0 at both ends.

/// 0 up to `low`, 1 from `high` on, and a cubic in between.
#[inline(always)]
pub(crate) fn smoothstep([low, high]: [f32; 2], x: f32) -> f32 {
    let s = ((x - low) / (high - low)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// [`smoothstep`] in double precision.
#[inline(always)]
pub(crate) fn smoothstep_f64([low, high]: [f64; 2], x: f64) -> f64 {
    let s = ((x - low) / (high - low)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_is_five_thirty_seconds() {
        // (1/4)² (3 − 1/2) = 5/32, and the rest of it at three quarters.
        let values = [0.0, 2.0, 2.5, 3.0, 3.5, 4.0, 9.0].map(|x| smoothstep([2.0, 4.0], x));
        assert_eq!(values, [0.0, 0.0, 5.0 / 32.0, 0.5, 27.0 / 32.0, 1.0, 1.0]);
        for (x, value) in [(0.0, 0.0), (2.5, 5.0 / 32.0), (3.5, 27.0 / 32.0), (9.0, 1.0)] {
            assert_eq!(smoothstep_f64([2.0, 4.0], x), value);
        }
    }
}
