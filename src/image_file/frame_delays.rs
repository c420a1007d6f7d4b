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

/// Shortest and longest time that a frame is shown for, each a fraction of seconds.
pub(super) type Durations = [(u32, u32); 2];

/// Those of animated PNG, whose delays are fractions of 16-bit integers.
pub(super) const PNG_DURATIONS: Durations = [(1, 65_535), (65_535, 1)];
/// Those of WebP: milliseconds in 24 bits.
pub(super) const WEBP_DURATIONS: Durations = [(1, 1000), ((1 << 24) - 1, 1000)];
/// Those of GIF: hundredths of a second in 16 bits. Of shorter ones frames are left out.
pub(super) const GIF_DURATIONS: Durations = [(0, 1), (65_535, 100)];

/// How a movie of a format with these durations differs from its rate; `None` where it does not.
pub(super) fn lost_rate(
    (numerator, denominator): (u32, u32),
    [shortest, longest]: Durations,
) -> Option<String> {
    let [numerator, denominator] = [numerator, denominator].map(u64::from);
    // A limit and the duration of a frame, both by the same factor.
    let scaled =
        |(seconds, parts): (u32, u32)| (u64::from(seconds) * numerator, u64::from(parts) * denominator);
    let text = |(seconds, parts): (u32, u32)| {
        if seconds == 1 { format!("1/{parts}") } else { (seconds / parts).to_string() }
    };
    let (limit, duration) = scaled(shortest);
    if duration < limit {
        let shortest = text(shortest);
        return Some(format!("frames are shown for {shortest} s at least: the movie is slower than `fps`"));
    }
    let (limit, duration) = scaled(longest);
    let longest = text(longest);
    (duration > limit)
        .then(|| format!("frames are shown for {longest} s at most: the movie is faster than `fps`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_beyond_a_format_are_told() {
        for (rate, durations, words) in [
            ((24, 1), WEBP_DURATIONS, None),
            ((1000, 1), WEBP_DURATIONS, None),
            ((1001, 1), WEBP_DURATIONS, Some("for 1/1000 s at least: the movie is slower")),
            ((1, 16_777), WEBP_DURATIONS, None),
            ((1, 16_778), WEBP_DURATIONS, Some("for 16777 s at most: the movie is faster")),
            ((65_535, 1), PNG_DURATIONS, None),
            ((100_000, 1), PNG_DURATIONS, Some("for 1/65535 s at least")),
            ((1, 65_536), PNG_DURATIONS, Some("for 65535 s at most")),
            ((120, 1), GIF_DURATIONS, None),
            ((1, 656), GIF_DURATIONS, Some("for 655 s at most")),
        ] {
            let told = lost_rate(rate, durations);
            assert_eq!(told.is_some(), words.is_some(), "{rate:?}: {told:?}");
            assert!(told.unwrap_or_default().contains(words.unwrap_or_default()), "{rate:?}");
        }
    }

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
