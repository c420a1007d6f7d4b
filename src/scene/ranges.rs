//! Ranges of the numbers of a file: its own values, and those of keyframes.

use std::ops::RangeInclusive;

/// All finite numbers.
pub(crate) const ANY: RangeInclusive<f32> = f32::MIN..=f32::MAX;
/// All non-negative finite numbers.
pub(crate) const NOT_NEGATIVE: RangeInclusive<f32> = 0.0..=f32::MAX;
/// All positive finite numbers.
pub(crate) const POSITIVE: RangeInclusive<f32> = f32::MIN_POSITIVE..=f32::MAX;
/// From zero to one.
pub(crate) const UNIT: RangeInclusive<f32> = 0.0..=1.0;
/// From one up.
pub(crate) const AT_LEAST_ONE: RangeInclusive<f32> = 1.0..=f32::MAX;
