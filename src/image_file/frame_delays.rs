//! Durations of the frames of animated images, in the units of their formats.

/// Seconds a frame as the nearest fraction of 16-bit integers.
pub(super) fn png_delay((numerator, denominator): (u32, u32)) -> (u16, u16) {
    let (numerator, denominator) = (u64::from(numerator.max(1)), u64::from(denominator));
    let nearest = |parts: u16| {
        let seconds = (u64::from(parts) * denominator + numerator / 2) / numerator;
        (u16::try_from(seconds).unwrap_or(u16::MAX), parts)
    };
    // Distances from the exact value are `error` over `parts`, times a constant.
    let error = |&(seconds, parts): &(u16, u16)| {
        u128::from((u64::from(seconds) * numerator).abs_diff(denominator * u64::from(parts)))
    };
    let fractions = (1..=u16::MAX).map(nearest);
    let best = fractions.min_by(|a, b| (error(a) * u128::from(b.1)).cmp(&(error(b) * u128::from(a.1))));
    best.unwrap_or((1, 24))
}

/// Duration of frame `index` in whole parts of a second, `parts` to the second. Rounding errors do not accumulate over frames.
pub(super) fn rounded_delay(index: u64, (numerator, denominator): (u32, u32), parts: u32) -> u32 {
    let start = |index: u64| {
        let exact = u128::from(parts) * u128::from(index) * u128::from(denominator);
        (exact + u128::from(numerator) / 2) / u128::from(numerator.max(1))
    };
    u32::try_from(start(index + 1) - start(index)).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_of_animated_pngs_are_the_nearest_fractions() {
        assert_eq!(
            [(24, 1), (24000, 1001), (100_000, 1), (1, 100_000)].map(png_delay),
            [(1, 24), (1001, 24000), (1, 65535), (65535, 1)]
        );
        let (seconds, parts) = png_delay((120_000, 1001));
        let exact = 1001.0 / 120_000.0;
        assert!((f64::from(seconds) / f64::from(parts) / exact - 1.0).abs() < 1e-7, "{seconds}/{parts}");
    }
}
