//! The result of comparing two images: checks of measures against limits, mismatches, differences by layer, and the likely cause.
//!
//! The types serialise to the JSON that `schema/diff.schema.json` and `schema/test.schema.json` describe.

use serde::{Serialize, Serializer};

use super::Image;
use super::cause::Cause;
use super::changes::hidden_changes;
use super::channel_difference::LayerDifference;
use super::flip::{Exposures, FlipMap};
use super::non_finite::NonFinite;
use super::pooling::PooledErrors;
use super::root_mean_square::RootMeanSquare;
use super::verdict::Verdict;
use crate::image::content_text;

/// Most lines on the content of a scene that a change within the limits tells in its line.
const MAX_CONTENT_LINES: usize = 4;

/// A difference that no limit allows.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Mismatch {
    /// Sizes or windows differ: size of the display window, first pixel of the data window in it, and size of the data window.
    Size {
        /// Those of the compared image.
        actual: [(i64, i64); 3],
        /// Those of the reference.
        reference: [(i64, i64); 3],
    },
    /// Only one of the images has this channel.
    Channel {
        /// The channel's name.
        channel: String,
        /// Whether the reference is the one without it.
        missing_in_reference: bool,
    },
    /// One of the images holds a channel as integers, which are ids, and the other as numbers that are no ids.
    SampleType {
        /// The channel's name.
        channel: String,
        /// Whether the reference is the one with ids.
        ids_in_reference: bool,
    },
    /// Infinite values, or values that are not a number.
    NotFinite {
        /// Whether the reference holds them.
        in_reference: bool,
        /// Their channel, counts and first pixel.
        values: NonFinite,
    },
    /// Content that only the reference's scene has.
    Lost {
        /// What it is: `node`, `clip`, `camera`, `variant`, `light`, `morph_target` or `motion`.
        content: &'static str,
        /// See [`ContentChange::name`](crate::image::ContentChange::name).
        name: String,
        /// How many there are of it. Results leave it out where it is 1.
        #[serde(skip_serializing_if = "is_one")]
        count: usize,
    },
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_one(count: &usize) -> bool {
    *count == 1
}

/// One measure and its limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The measure, in words.
    pub measure: String,
    /// The measured value.
    pub measured: f64,
    /// The largest value that passes.
    pub limit: f64,
    /// Column and row in the whole image of the largest difference, for measures that have a location.
    pub at: Option<(u32, u32)>,
    /// Whether the value is within the limit.
    pub passes: bool,
}

/// The result of comparing an image with its reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// Whether every bit is equal.
    #[serde(rename = "identical")]
    pub is_identical: bool,
    /// Differences that no limit allows.
    #[serde(rename = "faults")]
    pub mismatches: Vec<Mismatch>,
    /// Content that the reference's scene does not have, one line each.
    pub new_content: Vec<String>,
    /// Changes of the scene that pixels need not show, one line each: parts where the pixels are equal, and clips.
    pub scene_changes: Vec<String>,
    /// Measures with limits.
    pub checks: Vec<Check>,
    /// Differences by EXR layer.
    pub layers: Vec<LayerDifference>,
    /// Root mean square error of the colours.
    pub root_mean_square: Option<RootMeanSquare>,
    /// FLIP, pooled over the image.
    pub flip: Option<PooledErrors>,
    /// Exposures of FLIP for linear light.
    pub exposures: Option<Exposures>,
    /// FLIP of every pixel. `None` for images without colours or of different sizes.
    #[serde(skip)]
    pub flip_map: Option<FlipMap>,
    /// The likely cause. `None` for identical images, and where none is found.
    #[serde(flatten, serialize_with = "cause_and_text")]
    pub cause: Option<Cause>,
}

impl Comparison {
    /// That of two images without a difference, whose layers and measures are not listed.
    pub fn identical() -> Self {
        Self { is_identical: true, flip: Some(PooledErrors::default()), ..Self::default() }
    }

    /// The comparison of an image of linear light with one of display values: a failure that has no clearer cause is likely one of exposure
    /// and tone curve.
    #[must_use]
    pub(super) fn of_light_and_display_values(mut self) -> Self {
        let is_vague = match &self.cause {
            None
            | Some(
                Cause::Light { .. }
                | Cause::MaterialOrLight
                | Cause::Settings
                | Cause::Noise
                | Cause::Unclear { .. },
            ) => true,
            Some(_) => false,
        };
        if is_vague && self.checks.iter().any(|check| !check.passes) {
            self.cause = Some(Cause::Encoding);
        }
        self
    }

    /// Whether there is no mismatch and every check passes.
    pub fn passes(&self) -> bool {
        self.mismatches.is_empty() && self.checks.iter().all(|check| check.passes)
    }

    /// Whether the image is identical, changed within the limits, or failed.
    pub fn verdict(&self) -> Verdict {
        match (self.passes(), self.is_identical && self.content_lines().is_empty()) {
            (false, _) => Verdict::Failed,
            (true, false) => Verdict::Changed,
            (true, true) => Verdict::Identical,
        }
    }

    /// The measure that comes closest to its limit, or exceeds it by most, and what differs of the scene's content, in one line. Where no
    /// measure with a limit shows a difference, the largest difference of a value. `None` where none differs but for numbers of ids and
    /// signs of zeros.
    pub fn largest_measure(&self) -> Option<String> {
        self.largest_measure_with(&self.content_lines())
    }

    /// [`Comparison::largest_measure`] with other lines on the content.
    pub(super) fn largest_measure_with(&self, content: &[String]) -> Option<String> {
        let share = |check: &Check| check.measured / check.limit;
        let shown = self.checks.iter().filter(|check| check.measured > 0.0 && check.limit.is_finite());
        let check = shown.max_by(|a, b| share(a).total_cmp(&share(b))).map(ToString::to_string);
        let lines = content.iter().take(MAX_CONTENT_LINES).cloned();
        let more = content.len().saturating_sub(MAX_CONTENT_LINES);
        let more = (more > 0).then(|| format!("and {more} more"));
        let told: Vec<_> = check.into_iter().chain(lines).chain(more).collect();
        if !told.is_empty() {
            return Some(told.join("; "));
        }
        let channels = self.layers.iter().flat_map(|layer| &layer.channels);
        let channel = channels.filter(|channel| channel.largest > 0.0);
        channel.max_by(|a, b| a.largest.total_cmp(&b.largest)).map(|channel| {
            let (x, y) = channel.largest_at;
            let largest = short(channel.largest);
            format!("largest difference of {}: {largest}, at column {x}, row {y}", channel.channel)
        })
    }

    /// What an image tells of the scene's content besides what is lost: changes before new names, of which there may be many.
    pub(super) fn content_lines(&self) -> Vec<String> {
        self.scene_changes.iter().chain(&self.new_content).cloned().collect()
    }

    /// Adds what changed of the scene of an image of equal pixels, whatever its files list.
    pub fn tell_hidden_changes(&mut self, actual: &Image, reference: &Image) {
        if self.is_identical {
            let hidden = hidden_changes(&actual.scene, &reference.scene);
            self.scene_changes.extend(hidden);
        }
    }

    /// The comparison of windows that begin at a column and row: positions in them become positions in the whole image. Those of
    /// mismatches are so already.
    #[must_use]
    pub(super) fn of_window_at(mut self, origin: (u32, u32)) -> Self {
        let channels = self.layers.iter_mut().flat_map(|layer| &mut layer.channels);
        let of_flip = self.flip.iter_mut().flat_map(|flip| {
            let object = flip.object.as_mut().map(|object| &mut object.at);
            [Some(&mut flip.largest_at), Some(&mut flip.tile_at), object].into_iter().flatten()
        });
        let of_checks = self.checks.iter_mut().filter_map(|check| check.at.as_mut());
        for at in channels.map(|channel| &mut channel.largest_at).chain(of_flip).chain(of_checks) {
            *at = (at.0 + origin.0, at.1 + origin.1);
        }
        self
    }

    /// Mismatches and failed checks, one line each.
    pub fn failures(&self) -> Vec<String> {
        let checks = self.checks.iter().filter(|check| !check.passes).map(ToString::to_string);
        self.mismatches.iter().map(ToString::to_string).chain(checks).collect()
    }
}

/// Serialises the cause as data (`cause`) and as a sentence (`likely`).
#[expect(clippy::ref_option, reason = "serde passes a reference to the field")]
fn cause_and_text<S: Serializer>(cause: &Option<Cause>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct CauseFields<'a> {
        cause: Option<&'a Cause>,
        likely: Option<String>,
    }
    let likely = cause.as_ref().map(ToString::to_string);
    CauseFields { cause: cause.as_ref(), likely }.serialize(serializer)
}

impl std::fmt::Display for Check {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = if self.passes { "<=" } else { ">" };
        write!(formatter, "{}: {} {sign} {}", self.measure, short(self.measured), short(self.limit))?;
        match self.at {
            Some((x, y)) => write!(formatter, ", worst at column {x}, row {y}"),
            None => Ok(()),
        }
    }
}

/// A number with four significant digits, without trailing zeros.
fn short(value: f64) -> String {
    // Counts stay whole.
    if value == libm::trunc(value) && value.abs() < 1e9 {
        return format!("{value:.0}");
    }
    let digits = if value == 0.0 { 0.0 } else { libm::floor(libm::log10(value.abs())) };
    if !digits.is_finite() || !(-4.0..4.0).contains(&digits) {
        return format!("{value:.1e}");
    }
    let text = format!("{value:.0$}", (3.0 - digits) as usize);
    if text.contains('.') {
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    text
}

impl std::fmt::Display for Mismatch {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Size { actual, reference } if actual[0] != reference[0] => {
                let [(w, h), (rw, rh)] = [actual[0], reference[0]];
                write!(formatter, "the size is {w}x{h}, the reference's {rw}x{rh}")
            }
            Self::Size { actual, reference } => {
                let [[(x, y), (w, h)], [(rx, ry), (rw, rh)]] =
                    [actual, reference].map(|[_, origin, size]| [*origin, *size]);
                write!(
                    formatter,
                    "holds {w}x{h} pixels from column {x}, row {y}, the reference {rw}x{rh} from column {rx}, row {ry}"
                )
            }
            Self::Channel { channel, missing_in_reference: true } => {
                write!(formatter, "has the channel {channel}, which the reference lacks")
            }
            Self::Channel { channel, .. } => {
                write!(formatter, "lacks the channel {channel} of the reference")
            }
            Self::SampleType { channel, ids_in_reference } => {
                let (ours, theirs) = if *ids_in_reference { ("numbers", "ids") } else { ("ids", "numbers") };
                write!(formatter, "holds {channel} as {ours}, the reference as {theirs}")
            }
            Self::NotFinite { in_reference: false, values } => write!(formatter, "{values}"),
            Self::NotFinite { values, .. } => write!(formatter, "in the reference {values}"),
            Self::Lost { content, name, count } => {
                write!(formatter, "lost: {}", content_text(content, name, *count))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_measure_is_the_one_closest_to_its_limit() {
        let check = |measure: &str, measured: f64, limit: f64| Check {
            measure: measure.to_owned(),
            measured,
            limit,
            at: None,
            passes: measured <= limit,
        };
        let checks = vec![check("a", 0.5, f64::INFINITY), check("b", 0.1, 0.2), check("c", 0.3, 0.4)];
        let mut comparison = Comparison { checks, ..Comparison::default() };
        assert_eq!(comparison.largest_measure().as_deref(), Some("c: 0.3 <= 0.4"));
        assert_eq!(comparison.verdict(), Verdict::Changed);
        comparison.checks.push(check("d", 0.1, 0.0));
        assert_eq!(comparison.largest_measure().as_deref(), Some("d: 0.1 > 0"));
        assert_eq!(comparison.verdict(), Verdict::Failed);
        comparison.checks.clear();
        assert_eq!(comparison.largest_measure(), None);
    }

    #[test]
    fn changes_are_told_before_many_new_names() {
        let comparison = Comparison {
            new_content: (1..=5).map(|node| format!("new: node \"{node}\"")).collect(),
            scene_changes: vec!["motion of clip \"run\" changed".to_owned()],
            ..Comparison::identical()
        };
        let told =
            "motion of clip \"run\" changed; new: node \"1\"; new: node \"2\"; new: node \"3\"; and 2 more";
        assert_eq!(comparison.largest_measure().as_deref(), Some(told));
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in
            [(0.031_04, "0.03104"), (0.02, "0.02"), (12.0, "12"), (0.0, "0"), (3e-7, "3.0e-7")]
        {
            assert_eq!(short(value), text);
        }
    }
}
