//! Frame specifications.

use std::collections::BTreeSet;

/// Largest number of frames in one run. More is taken for a typing error.
const MAX_FRAMES: usize = 1_000_000;

/// A frame of an animation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedFrame {
    /// Frame 0.
    First,
    /// Half of the last one.
    Middle,
    /// The last of the animation.
    Last,
    /// This one.
    Number(i64),
}

/// The first, the middle and the last frame of an animation.
pub fn first_middle_last(last: i64) -> [i64; 3] {
    [0, last / 2, last]
}

/// Requested frames.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameSpec {
    /// Every frame of the animation, from 0.
    All,
    /// These, in this order, none twice.
    Listed(Vec<i64>),
    /// These of the animation, in increasing order, none twice.
    Named(Vec<NamedFrame>),
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
    /// Parses `7`, `1-10`, `1..10`, `1-10x2` = `1-10:2`, `10-1:-1`, `-3--2`, several of these with commas, or `all`.
    ///
    /// Those are the ranges of Deadline (`1-10x2`, also with `step`, `by` or `every` for the `x`) and of Open Job
    /// Description (`1-10:2`, `10-1:-1`, blanks anywhere), so that chunks of farms need no conversion.
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
            let range = parse_part(part.trim())
                .map_err(|why| format!("\"{text}\": {why}; write 7, 1-10, 1-10x2, 1,5,8-12, -3--2 or all"))?;
            let (first, _, step) = range;
            let count = checked_count(range)?;
            frames.extend((0..count).map(|index| first + index * step).filter(|&frame| seen.insert(frame)));
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
            Self::Named(frames) => return Ok(numbers_of(frames, last_frame)),
            Self::All => (0, last_frame, 1),
            Self::Range { start, end, step } => (start.unwrap_or(0), end.unwrap_or(last_frame), *step),
        };
        if let Self::Range { start: Some(start), end: None, .. } = self
            && first > last
        {
            return Err(format!("{start} lies beyond the animation's last frame, {last}; add `end`"));
        }
        if first > last {
            return Err(format!("no frame lies from {first} to {last}; check `start` and `end`"));
        }
        if step < 1 {
            return Err("a step must be at least 1".to_owned());
        }
        let count = checked_count((first, last, step))?;
        Ok((0..count).map(|index| first + index * step).collect())
    }
}

/// The numbers of frames of an animation, in increasing order.
fn numbers_of(frames: &[NamedFrame], last_frame: i64) -> Vec<i64> {
    let [first, middle, last] = first_middle_last(last_frame);
    let number = |frame: &NamedFrame| match frame {
        NamedFrame::First => first,
        NamedFrame::Middle => middle,
        NamedFrame::Last => last,
        NamedFrame::Number(number) => *number,
    };
    frames.iter().map(number).collect::<BTreeSet<_>>().into_iter().collect()
}

/// First frame, last frame and step, which leads from the first to the last or beyond it.
type Range = (i64, i64, i64);

/// The range of `7`, `1-10` or `1-10x2`.
fn parse_part(part: &str) -> Result<Range, String> {
    if let name @ ("first" | "middle" | "last") = part {
        return Err(format!(
            "{name} is a frame of a suite's `[test]` only, and frames are numbers here; rayframe info prints the last one"
        ));
    }
    let (first, rest) = parse_number(part)?;
    if rest.is_empty() {
        return Ok((first, first, 1));
    }
    let rest = rest
        .strip_prefix("..")
        .or_else(|| rest.strip_prefix('-'))
        .ok_or_else(|| format!("\"{rest}\" after {first} is not valid"))?;
    if rest.trim_start().is_empty() {
        return Err(format!("{first}- has no end, and -s {first} renders from there to the animation's end"));
    }
    let (last, rest) = parse_number(rest.trim_start())?;
    let step = if rest.is_empty() { 1 } else { parse_step(rest, last)? };
    if last < first && step > 0 {
        return Err(format!("{first}-{last} runs backwards (write {first}-{last}:-1)"));
    }
    if last > first && step < 0 {
        return Err(format!("steps of {step} never lead from {first} to {last}"));
    }
    Ok((first, last, step))
}

/// The step after `x` or a synonym; not 0.
fn parse_step(rest: &str, last: i64) -> Result<i64, String> {
    const WORDS: [&str; 5] = ["x", ":", "step", "by", "every"];
    let step = WORDS.iter().find_map(|word| rest.strip_prefix(word));
    let step = step.ok_or_else(|| format!("\"{rest}\" after {last} is not valid"))?.trim_start();
    match step.parse::<i32>() {
        Ok(0) => Err("a step cannot be 0".to_owned()),
        Ok(step) => Ok(i64::from(step)),
        Err(_) => Err(format!("\"{step}\" is not a step")),
    }
}

/// The number at the beginning, and what follows it and blanks.
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
    Ok((stored_frame(number, 10)?, rest.trim_start()))
}

/// The frame number that `text` is in a radix. Files store frame numbers in 32 bits.
///
/// # Errors
/// One line, where it is beyond them.
pub(crate) fn stored_frame(text: &str, radix: u32) -> Result<i64, String> {
    let prefix = match radix {
        2 => "0b",
        8 => "0o",
        16 => "0x",
        _ => "",
    };
    i32::from_str_radix(text, radix)
        .map(i64::from)
        .map_err(|_| format!("{prefix}{text} is beyond the frame numbers that files can hold, ±2147483647"))
}

/// Number of frames of a range.
fn checked_count((first, last, step): Range) -> Result<i64, String> {
    let count = last.abs_diff(first) / step.unsigned_abs().max(1) + 1;
    if count > MAX_FRAMES as u64 || last > i64::from(i32::MAX) {
        return Err(too_many(count as usize));
    }
    Ok(count as i64)
}

fn too_many(count: usize) -> String {
    format!("{count} frames are more than the {MAX_FRAMES} that one run takes; ask for part of them with -f")
}

/// `frame 7`, `frames 0-60`, `frames 1-9x2` or `frames 1,5,8-12`, in the form that `-f` takes.
pub fn frames_text(frames: &[i64]) -> String {
    if let [frame] = frames {
        return format!("frame {frame}");
    }
    let mut parts = Vec::new();
    let mut rest = frames;
    while let [first, tail @ ..] = rest {
        let step = tail.first().map_or(0, |second| second - first);
        let run = if step > 0 {
            1 + tail.iter().zip(1..).take_while(|&(&f, i)| f == first + step * i).count()
        } else {
            1
        };
        // Two frames with a gap between them read better as two numbers.
        let run = if run == 2 && step > 1 { 1 } else { run };
        parts.push(match (run, step) {
            (1, _) => first.to_string(),
            (_, 1) => format!("{first}-{}", rest[run - 1]),
            _ => format!("{first}-{}x{step}", rest[run - 1]),
        });
        rest = &rest[run..];
    }
    format!("frames {}", parts.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_written_as_they_are_parsed() {
        assert_eq!(frames_text(&[7]), "frame 7");
        for text in ["0-60", "1-9x2", "1,5,8-12", "3,2,1", "-3--1", "1,9", "9,8,1-3"] {
            assert_eq!(frames_text(&listed(text)), format!("frames {text}"));
        }
    }

    fn listed(text: &str) -> Vec<i64> {
        match FrameSpec::parse(text) {
            Ok(FrameSpec::Listed(frames)) => frames,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn every_form_is_parsed() {
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
    fn chunks_of_farms_are_parsed() {
        // Deadline.
        assert_eq!(listed("5"), [5]);
        assert_eq!(listed("1,3,5-9"), [1, 3, 5, 6, 7, 8, 9]);
        for text in ["1-10x4", "1-10step4", "1-10by4", "1-10every4"] {
            assert_eq!(listed(text), [1, 5, 9], "{text}");
        }
        // Open Job Description: blanks anywhere, and steps that lead downwards.
        assert_eq!(listed("1 - 10 : 4, 12"), [1, 5, 9, 12]);
        assert_eq!(listed("-1 - -3 : -1"), [-1, -2, -3]);
        assert_eq!(listed("10-1:-4"), [10, 6, 2]);
        assert_eq!(listed("3-3:-1"), [3]);
    }

    #[test]
    fn invalid_specifications_are_refused_with_the_right_form() {
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
            "10-1x2",
            "10-1:0",
            "1 2",
            "1-10 2",
            "1-10times2",
        ] {
            let error = FrameSpec::parse(text).unwrap_err();
            assert!(error.contains("-f") || error.contains("1-10x2"), "{text}: {error}");
        }
    }

    #[test]
    fn names_of_frames_are_told_from_other_words() {
        for (text, name) in [("last", "last"), ("0,middle", "middle"), (" first ", "first")] {
            let error = FrameSpec::parse(text).unwrap_err();
            assert!(error.contains(&format!("{name} is a frame of a suite's")), "{error}");
            assert!(error.contains("frames are numbers here") && error.contains("write 7, 1-10"), "{error}");
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

    #[test]
    fn named_frames_are_sorted_and_follow_the_animation() {
        use NamedFrame::{First, Last, Middle, Number};
        let named = |frames: &[NamedFrame], last| FrameSpec::Named(frames.to_vec()).resolve(last).unwrap();
        assert_eq!(named(&[Last, First, Middle], 49), [0, 24, 49]);
        assert_eq!(named(&[First, Last], 0), [0]);
        assert_eq!(named(&[Number(7), Last, Number(-1)], 5), [-1, 5, 7]);
    }
}
