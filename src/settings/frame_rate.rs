//! Frame rates: frame f shows time f / rate, computed exactly and never accumulated.

use std::fmt;

/// Frames per second as a fraction in lowest terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    numerator: u32,
    denominator: u32,
}

impl FrameRate {
    /// The default, 24 frames per second.
    pub const FILM: Self = Self { numerator: 24, denominator: 1 };

    /// Parses `24`, `23.976` or `24000/1001`.
    ///
    /// # Errors
    /// One line that says what is wrong.
    pub fn parse(text: &str) -> Result<Self, String> {
        let fraction = match text.split_once('/') {
            Some((numerator, denominator)) => numerator.parse().ok().zip(denominator.parse().ok()),
            None => parse_decimal(text),
        };
        let (numerator, denominator): (u64, u64) = fraction
            .ok_or_else(|| format!("\"{text}\" is not a frame rate; write 24, 29.97 or 30000/1001"))?;
        if numerator == 0 || denominator == 0 {
            return Err(format!("\"{text}\": frames a second must be more than 0"));
        }
        let divisor = greatest_common_divisor(numerator, denominator);
        // OpenEXR stores a signed numerator and an unsigned denominator of 32 bits.
        let numerator = i32::try_from(numerator / divisor).ok();
        let denominator = u32::try_from(denominator / divisor).ok();
        match numerator.zip(denominator) {
            Some((numerator, denominator)) => Ok(Self { numerator: numerator.unsigned_abs(), denominator }),
            None => Err(format!("\"{text}\" has too many digits for a frame rate")),
        }
    }

    /// The time that `frame` shows, rounded once.
    pub fn time_seconds(self, frame: i64) -> f64 {
        let numerator = i128::from(frame) * i128::from(self.denominator);
        // Both fit a double exactly: |frame| < 2³¹ and each part of the rate < 2³², products < 2⁵³ for all rates in use.
        numerator as f64 / f64::from(self.numerator)
    }

    /// The last frame whose time lies within an animation of this duration.
    ///
    /// Exporters round key times, or add up the durations of frames in 32 bits, which loses up to 0.005 frames in the first thousand and 0.02 in two
    /// thousand. So a frame less than 0.006 frames after the end counts as on it, of long animations 0.025, and so does one whose time a file would
    /// store as the end.
    pub fn last_frame(self, duration_seconds: f32) -> i64 {
        let frames = |seconds: f64| seconds * f64::from(self.numerator) / f64::from(self.denominator);
        let [stored, next] = [duration_seconds, duration_seconds.next_up()].map(f64::from);
        let rounding = (frames(stored) * 12e-6).clamp(6e-3, 0.025);
        let last = (frames(stored) + rounding).max(frames(f64::midpoint(stored, next)));
        last.floor() as i64
    }

    /// Numerator and denominator as OpenEXR stores them.
    pub fn as_exr_rational(self) -> (i32, u32) {
        (self.numerator as i32, self.denominator)
    }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.numerator)?;
        if self.denominator != 1 {
            write!(formatter, "/{}", self.denominator)?;
        }
        Ok(())
    }
}

/// `23.976` as 23976 / 1000.
fn parse_decimal(text: &str) -> Option<(u64, u64)> {
    let (whole, decimals) = text.split_once('.').unwrap_or((text, ""));
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || decimals.len() > 9 || !digits(whole) || !digits(decimals) {
        return None;
    }
    let numerator = format!("{whole}{decimals}").parse().ok()?;
    Some((numerator, 10_u64.pow(decimals.len() as u32)))
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_fractions() {
        let rational = |text| FrameRate::parse(text).unwrap().as_exr_rational();
        assert_eq!(rational("24"), (24, 1));
        assert_eq!(rational("23.976"), (2997, 125));
        assert_eq!(rational("48000/2002"), (24000, 1001));
        for text in [
            "",
            "0",
            "-24",
            "24/0",
            "0/1",
            "a",
            "24/",
            "/24",
            ".",
            "1e3",
            "24.0000000001",
            "99999999999",
            "NaN",
        ] {
            assert!(FrameRate::parse(text).is_err(), "{text}");
        }
        assert_eq!(FrameRate::parse("30000/1001").unwrap().to_string(), "30000/1001");
    }

    #[test]
    fn times_are_the_nearest_double_of_the_exact_quotient() {
        let ntsc = FrameRate::parse("24000/1001").unwrap();
        assert_eq!(ntsc.time_seconds(24000), 1001.0);
        assert_eq!(FrameRate::FILM.time_seconds(60), 2.5);
        assert_eq!(FrameRate::FILM.time_seconds(-12), -0.5);
        // One division, one rounding: the same as the literal.
        assert_eq!(FrameRate::parse("10").unwrap().time_seconds(3), 0.3);
    }

    #[test]
    fn the_last_frame_forgives_rounded_durations() {
        assert_eq!(FrameRate::FILM.last_frame(2.5), 60);
        assert_eq!(FrameRate::FILM.last_frame(0.0), 0);
        // 0.7 is 0.699999988 as f32, yet frame 7 at 10 frames per second belongs to it.
        assert_eq!(FrameRate::parse("10").unwrap().last_frame(0.7), 7);
        assert_eq!(FrameRate::FILM.last_frame(2.49), 59);
        // Steps between durations that a file can store grow with the duration.
        let rate = FrameRate::parse("60").unwrap();
        assert!(
            (0..1_000_000)
                .step_by(7)
                .all(|frame| rate.last_frame((f64::from(frame) / 60.0) as f32) == i64::from(frame))
        );
        assert_eq!(FrameRate::FILM.last_frame(1e6), 24_000_000);
        // Durations of frames, added up as they are stored
        for numerator in [24_u32, 25, 30, 60] {
            let rate = FrameRate::parse(&numerator.to_string()).unwrap();
            let mut sum = 0.0_f32;
            for frame in 1..=2000 {
                sum += 1.0 / numerator as f32;
                assert_eq!(rate.last_frame(sum), frame, "{numerator}");
            }
        }
        // A third of a second at 29.97 is 9.99 frames: frame 10 is clearly outside.
        assert_eq!(FrameRate::parse("30000/1001").unwrap().last_frame(1.0 / 3.0), 9);
    }
}
