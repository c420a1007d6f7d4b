//! Differences between the values of two channels, and counts of those beyond limits.

use std::collections::{HashMap, HashSet};

use serde::Serialize;

use super::common_form::{is_count, is_statistic};
use super::{Samples, layer_of};

/// The differences of one EXR layer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LayerDifference {
    /// The layer's name.
    pub layer: String,
    /// Pixels with a value beyond the limits.
    pub different_pixels: usize,
    /// The differences of each channel.
    pub channels: Vec<ChannelDifference>,
}

/// The differences of one channel. [`super::NonFinite`] reports values that are not finite; they are skipped here.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ChannelDifference {
    /// The channel's name.
    pub channel: String,
    /// Values whose bits differ.
    pub different: usize,
    /// Values beyond the absolute limit.
    pub beyond_absolute: usize,
    /// Values beyond the relative limit, as a share of the reference's magnitude.
    pub beyond_relative: usize,
    /// The largest absolute difference. Ids differ by 1 or by 0. In a Cryptomatte, that of the coverage of an id.
    pub largest: f64,
    /// Column and row of the largest difference.
    pub largest_at: (u32, u32),
    /// The largest difference as a share of the reference's magnitude; infinite where that is 0.
    pub largest_relative: f64,
}

impl ChannelDifference {
    /// No difference of the channel `name`.
    pub(super) fn named(name: &str) -> Self {
        Self { channel: name.to_owned(), ..Self::default() }
    }

    /// Counts the difference of pixel `at` of an image of a width, where the reference has this magnitude, and returns whether it is beyond
    /// both limits.
    pub(super) fn count(
        &mut self,
        difference: f64,
        magnitude: f64,
        limits: &ValueLimits,
        (at, width): (usize, u32),
    ) -> bool {
        if difference == 0.0 {
            return false;
        }
        let relative = difference / magnitude;
        let beyond = (difference > limits.absolute, relative > limits.relative);
        self.beyond_absolute += usize::from(beyond.0);
        self.beyond_relative += usize::from(beyond.1);
        if difference > self.largest {
            self.largest = difference;
            self.largest_at = (at as u32 % width, at as u32 / width);
        }
        self.largest_relative = self.largest_relative.max(relative);
        beyond.0 && beyond.1
    }
}

/// Limits on the difference of a value from its reference. A value is too far off when it is beyond both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ValueLimits {
    /// Limit in units of the value.
    pub absolute: f64,
    /// Limit as a share of the reference's magnitude.
    pub relative: f64,
}

/// Compares two channels of images `width` pixels wide, and sets `is_beyond` for each pixel beyond both limits.
pub fn channel_difference(
    name: &str,
    values: (&Samples, &Samples),
    limits: &ValueLimits,
    width: u32,
    is_beyond: &mut [bool],
) -> ChannelDifference {
    let mut found = ChannelDifference::named(name);
    let floats = (values.0.floats(), values.1.floats());
    let values = match (&floats, values) {
        ((Some(actual), Some(reference)), _) => Pair::Floats(actual, reference),
        (_, (Samples::Uint(actual), Samples::Uint(reference))) if is_count(name) => {
            Pair::Counts(actual, reference)
        }
        (_, (Samples::Uint(actual), Samples::Uint(reference))) if is_statistic(layer_of(name)) => {
            Pair::Words(actual, reference)
        }
        (_, (Samples::Uint(actual), Samples::Uint(reference))) => Pair::Ids(actual, reference),
        _ => Pair::Mixed,
    };
    let renumbered = match values {
        Pair::Ids(actual, reference) => renumbering(reference.iter().copied().zip(actual.iter().copied())),
        Pair::Floats(..) | Pair::Counts(..) | Pair::Words(..) | Pair::Mixed => HashMap::new(),
    };
    for (at, is_beyond) in is_beyond.iter_mut().enumerate() {
        found.different += usize::from(!same_bits(values, at));
        let Some((difference, magnitude)) = difference(values, at, &renumbered) else { continue };
        *is_beyond |= found.count(difference, magnitude, limits, (at, width));
    }
    found
}

/// Samples of two channels.
#[derive(Clone, Copy)]
enum Pair<'a> {
    Floats(&'a [f32], &'a [f32]),
    Ids(&'a [u32], &'a [u32]),
    Counts(&'a [u32], &'a [u32]),
    /// Parts of numbers, of which bits alone are compared.
    Words(&'a [u32], &'a [u32]),
    /// Floats and ids.
    Mixed,
}

fn same_bits(values: Pair<'_>, at: usize) -> bool {
    match values {
        Pair::Floats(actual, reference) => actual[at].to_bits() == reference[at].to_bits(),
        Pair::Ids(actual, reference) | Pair::Counts(actual, reference) | Pair::Words(actual, reference) => {
            actual[at] == reference[at]
        }
        Pair::Mixed => false,
    }
}

/// The absolute difference and the reference's magnitude; `None` when either value is not finite. Ids that differ are infinitely
/// far apart by share and 1 by value, as are numbers and ids. An id equals the one that `renumbered` gives it.
fn difference(values: Pair<'_>, at: usize, renumbered: &HashMap<u32, u32>) -> Option<(f64, f64)> {
    match values {
        Pair::Floats(actual, reference) => {
            let (actual, reference) = (f64::from(actual[at]), f64::from(reference[at]));
            let is_finite = actual.is_finite() && reference.is_finite();
            is_finite.then(|| ((actual - reference).abs(), reference.abs()))
        }
        Pair::Counts(actual, reference) => {
            let (actual, reference) = (f64::from(actual[at]), f64::from(reference[at]));
            Some(((actual - reference).abs(), reference))
        }
        Pair::Ids(actual, reference) => {
            let is_other = renumbered.get(&reference[at]) != Some(&actual[at]);
            Some((f64::from(u8::from(is_other)), 0.0))
        }
        Pair::Words(..) => None,
        Pair::Mixed => Some((1.0, 0.0)),
    }
}

/// The id that each id of the reference has in the other image, from both ids of each pixel, the reference's first: ids are indices in the
/// file, and a file that lists its meshes in another order shows the same. Each id has at most one other: the pair with the most pixels
/// comes first, of equal ones the pair with the smallest ids. No id, 0, stays so.
pub(crate) fn renumbering(ids: impl Iterator<Item = (u32, u32)>) -> HashMap<u32, u32> {
    let mut pixels: HashMap<(u32, u32), usize> = HashMap::new();
    for pair in ids {
        *pixels.entry(pair).or_default() += 1;
    }
    let mut pairs: Vec<_> = pixels.into_iter().collect();
    pairs.sort_unstable_by_key(|&(pair, count)| (std::cmp::Reverse(count), pair));
    let (mut renumbered, mut taken) = (HashMap::from([(0, 0)]), HashSet::from([0]));
    for ((theirs, ours), _) in pairs {
        if !taken.contains(&ours) && !renumbered.contains_key(&theirs) {
            renumbered.insert(theirs, ours);
            taken.insert(ours);
        }
    }
    renumbered
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_count_apart_and_together() {
        let numbers = |values: &[f32]| Samples::Float(values.to_vec());
        // By 0.5 of 100 (0.5 %), 0.5 of 1 (50 %), 0.0625 of 0.125 (50 %), not at all, and not a number.
        let actual = numbers(&[100.5, 1.5, 0.1875, 3.0, f32::NAN, 1.0]);
        let reference = numbers(&[100.0, 1.0, 0.125, 3.0, 1.0, 1.0]);
        let limits = ValueLimits { absolute: 0.1, relative: 0.01 };
        let mut beyond = [false; 6];
        let found = channel_difference("R", (&actual, &reference), &limits, 3, &mut beyond);
        assert_eq!((found.different, found.beyond_absolute, found.beyond_relative), (4, 2, 2));
        assert_eq!((found.largest, found.largest_at, found.largest_relative), (0.5, (0, 0), 0.5));
        assert_eq!(beyond, [false, true, false, false, false, false]);
    }

    #[test]
    fn counts_of_samples_are_numbers() {
        let difference = |name: &str| {
            let values = (&Samples::Uint(vec![16, 17, 16, 0]), &Samples::Uint(vec![64, 16, 16, 0]));
            let mut beyond = [false; 4];
            let limits = ValueLimits { absolute: 0.0, relative: 0.5 };
            let found = channel_difference(name, values, &limits, 4, &mut beyond);
            (found.different, found.largest, found.largest_relative, beyond)
        };
        for name in ["sample_count", "sums.count"] {
            assert_eq!(difference(name), (2, 48.0, 0.75, [true, false, false, false]));
        }
        assert_eq!(difference("node_id").1, 1.0);
    }

    #[test]
    fn ids_are_equal_up_to_their_numbers() {
        let beyond_of = |actual: &[u32], reference: &[u32]| {
            let mut beyond = vec![false; actual.len()];
            let limits = ValueLimits { absolute: 0.5, relative: 100.0 };
            let values = (&Samples::Uint(actual.to_vec()), &Samples::Uint(reference.to_vec()));
            let found = channel_difference("node_id", values, &limits, 8, &mut beyond);
            (found, beyond)
        };
        // Objects 1 and 2 change numbers; their bits differ, and no pixel shows another object.
        let (found, beyond) = beyond_of(&[0, 2, 2, 1, 1, 1], &[0, 1, 1, 2, 2, 2]);
        assert_eq!((found.different, found.largest), (5, 0.0));
        assert!(!beyond.contains(&true));
        // A pixel of object 1 shows object 2.
        let (found, beyond) = beyond_of(&[1, 1, 2, 2, 2], &[1, 1, 1, 2, 2]);
        assert_eq!((found.different, found.largest, found.largest_at), (1, 1.0, (2, 0)));
        assert_eq!(beyond, [false, false, true, false, false]);
        // An object vanishes: it is not renumbered to the background, nor to another object.
        assert_eq!(beyond_of(&[0, 0, 0, 3], &[0, 5, 5, 3]).1, [false, true, true, false]);
        assert_eq!(beyond_of(&[3, 3, 3, 3], &[3, 5, 5, 3]).1, [false, true, true, false]);
    }
}
