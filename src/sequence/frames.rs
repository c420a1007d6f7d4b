//! Which frames are asked for.

use std::collections::BTreeSet;

/// Most frames of one run; more is taken for a slip of the keyboard.
const MAX_FRAMES: usize = 1_000_000;

/// Frames as a user asks for them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FrameSpec {
    /// Every frame of the animation, from 0.
    All,
    /// These, in this order, none twice.
    Listed(Vec<i64>),
    /// A first and a last frame, each the animation's own unless given, and the distance between frames.
    Range {
        /// First frame.
        start: Option<i64>,
        /// Last frame.
        end: Option<i64>,
        /// Distance, at least 1.
        step: i64,
    },
}

impl FrameSpec {
    /// Parses `7`, `1-10`, `1..10`, `1-10x2` = `1-10:2`, `-3--2`, several of these with commas, or `all`.
    ///
    /// # Errors
    /// One line that says what is wrong and what would be right.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text.trim() == "all" {
            return Ok(Self::All);
        }
        let mut seen = BTreeSet::new();
        let mut frames = Vec::new();
        for part in text.split(',') {
            let (first, last, step) = parse_part(part.trim())
                .map_err(|why| format!("\"{text}\": {why}; write 7, 1-10, 1-10x2, 1,5,8-12, -3--2 or all"))?;
            check_count(first, last, step)?;
            for frame in (first..=last).step_by(step) {
                if seen.insert(frame) {
                    frames.push(frame);
                }
            }
            if frames.len() > MAX_FRAMES {
                return Err(too_many(frames.len()));
            }
        }
        Ok(Self::Listed(frames))
    }

    /// The frames of an animation whose last frame is `last_frame`.
    ///
    /// # Errors
    /// One line, when there is none or there are too many.
    pub fn resolve(&self, last_frame: i64) -> Result<Vec<i64>, String> {
        let (first, last, step) = match self {
            Self::Listed(frames) => return Ok(frames.clone()),
            Self::All => (0, last_frame, 1),
            Self::Range { start, end, step } => (start.unwrap_or(0), end.unwrap_or(last_frame), *step),
        };
        if let Self::Range { start: Some(start), end: None, .. } = self
            && first > last
        {
            return Err(format!("--start {start} lies beyond the animation's last frame, {last}; add --end"));
        }
        if first > last {
            return Err(format!("no frame lies from {first} to {last}; check --start and --end"));
        }
        let step = usize::try_from(step).ok().filter(|&step| step > 0);
        let step = step.ok_or("--step must be at least 1")?;
        check_count(first, last, step)?;
        Ok((first..=last).step_by(step).collect())
    }
}

/// First frame, last frame and step of `7`, `1-10` or `1-10x2`.
fn parse_part(part: &str) -> Result<(i64, i64, usize), String> {
    let (first, rest) = parse_number(part)?;
    if rest.is_empty() {
        return Ok((first, first, 1));
    }
    let rest = rest
        .strip_prefix("..")
        .or_else(|| rest.strip_prefix('-'))
        .ok_or_else(|| format!("\"{rest}\" after {first} is not understood"))?;
    if rest.is_empty() {
        return Err(format!("{first}- has no end, and -s {first} renders from there to the animation's end"));
    }
    let (last, rest) = parse_number(rest)?;
    if last < first {
        return Err(format!("{first}-{last} runs backwards"));
    }
    if rest.is_empty() {
        return Ok((first, last, 1));
    }
    let step =
        rest.strip_prefix(['x', ':']).ok_or_else(|| format!("\"{rest}\" after {last} is not understood"))?;
    match step.parse::<u32>() {
        Ok(0) => Err("a step must be at least 1".to_owned()),
        Ok(step) => Ok((first, last, step as usize)),
        Err(_) => Err(format!("\"{step}\" is not a step")),
    }
}

/// The number at the beginning, and what follows it.
fn parse_number(text: &str) -> Result<(i64, &str), String> {
    let sign = usize::from(text.starts_with('-'));
    let digits = text[sign..].bytes().take_while(u8::is_ascii_digit).count();
    let (number, rest) = text.split_at(sign + digits);
    if digits == 0 && text.is_empty() {
        return Err("a frame number is missing".to_owned());
    }
    if digits == 0 {
        return Err(format!("a frame number is missing before \"{text}\""));
    }
    // Files store frame numbers in 32 bits.
    let number = number
        .parse::<i32>()
        .map_err(|_| format!("{number} is beyond the frame numbers that files can hold, ±2147483647"))?;
    Ok((i64::from(number), rest))
}

fn check_count(first: i64, last: i64, step: usize) -> Result<(), String> {
    let count = (last - first) as u64 / step as u64 + 1;
    if count > MAX_FRAMES as u64 || last > i64::from(i32::MAX) {
        return Err(too_many(count as usize));
    }
    Ok(())
}

fn too_many(count: usize) -> String {
    format!("{count} frames are more than the {MAX_FRAMES} that one run takes; ask for part of them with -f")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(text: &str) -> Vec<i64> {
        match FrameSpec::parse(text) {
            Ok(FrameSpec::Listed(frames)) => frames,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn every_form_of_the_command_line_is_understood() {
        assert_eq!(listed("7"), [7]);
        assert_eq!(listed("1-4"), [1, 2, 3, 4]);
        assert_eq!(listed("1..4"), [1, 2, 3, 4]);
        assert_eq!(listed("1-10x3"), [1, 4, 7, 10]);
        assert_eq!(listed("1-9:3"), [1, 4, 7]);
        assert_eq!(listed("1,5,8-10"), [1, 5, 8, 9, 10]);
        assert_eq!(listed("-3--2"), [-3, -2]);
        assert_eq!(listed("-3..-2"), [-3, -2]);
        assert_eq!(listed("-1-1"), [-1, 0, 1]);
        assert_eq!(listed("5-6,1-5, 6"), [5, 6, 1, 2, 3, 4]);
        assert_eq!(FrameSpec::parse("all"), Ok(FrameSpec::All));
    }

    #[test]
    fn nonsense_is_refused_and_the_right_form_named() {
        for text in [
            "",
            ",",
            "1,",
            "a",
            "1-",
            "1--",
            "-",
            "1-10x",
            "1-10x0",
            "1-10y2",
            "10-1",
            "1.5",
            "1-2-3",
            "1x2",
            "99999999999",
            "0-2000000000",
            "1-10x-1",
        ] {
            let error = FrameSpec::parse(text).unwrap_err();
            assert!(error.contains("-f") || error.contains("1-10x2"), "{text}: {error}");
        }
    }

    #[test]
    fn all_and_ranges_follow_the_animation() {
        assert_eq!(FrameSpec::All.resolve(2).unwrap(), [0, 1, 2]);
        let range = |start, end, step| FrameSpec::Range { start, end, step }.resolve(6);
        assert_eq!(range(Some(4), None, 1).unwrap(), [4, 5, 6]);
        assert_eq!(range(None, Some(1), 1).unwrap(), [0, 1]);
        assert_eq!(range(Some(-2), Some(3), 2).unwrap(), [-2, 0, 2]);
        assert!(range(Some(7), None, 1).unwrap_err().contains("last frame, 6"));
        assert!(range(Some(7), Some(5), 1).unwrap_err().contains("from 7 to 5"));
        assert!(range(None, None, 0).is_err());
        assert!(FrameSpec::All.resolve(i64::from(i32::MAX)).is_err());
    }
}
