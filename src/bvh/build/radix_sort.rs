//! Parallel stable radix sort of 64-bit keys.
//!
//! Source: Satish, Harris, Garland, "Designing Efficient Sorting Algorithms for Manycore GPUs", IPDPS 2009: least significant
//! digit first, with a histogram per block, a prefix sum over (digit, block), and a stable scatter. Stability makes the result
//! independent of the number of blocks, and so of threads.
//!
//! Keys are stored as relaxed atomics, because blocks write to interleaved positions of one array. A relaxed store compiles to
//! a plain store.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::cancel::{CancelFlag, Cancelled};
use crate::parallel_resize::resize_with;

/// Key in an array that several tasks write to.
pub(crate) type Key = AtomicU64;

/// Bits per pass. Shorter digits need more passes, which cost more than the longer histogram.
const DIGIT_BITS: u32 = 12;
const DIGITS: usize = 1 << DIGIT_BITS;
/// Number of keys below which a comparison sort is faster.
const SMALL: usize = 1024;
/// Smallest number of keys per block.
const SMALLEST_BLOCK: usize = 1 << 14;

/// Number of keys of a block with each digit; after the prefix sum, the next output position of each digit.
type Histogram = [u32; DIGITS];

/// Scratch memory of the sort.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    keys: Vec<Key>,
    histograms: Vec<Histogram>,
}

/// Sorts `keys` by their `bits`, stably. These are whole digits of [`DIGIT_BITS`].
pub(crate) fn sort(
    keys: &mut Vec<Key>,
    bits: Range<u32>,
    scratch: &mut Scratch,
    cancel: &CancelFlag,
) -> Result<(), Cancelled> {
    debug_assert!((bits.end - bits.start).is_multiple_of(DIGIT_BITS), "a pass sorts by a whole digit");
    cancel.check()?;
    if keys.len() < SMALL {
        let mask = u64::MAX >> (u64::BITS - (bits.end - bits.start)) << bits.start;
        keys.sort_by_key(|key| load(key) & mask);
        return Ok(());
    }
    resize_with(&mut scratch.keys, keys.len(), Key::default);

    let blocks = (keys.len() / SMALLEST_BLOCK).clamp(1, rayon::current_num_threads());
    let shifts = bits.step_by(DIGIT_BITS as usize);
    if blocks == 1 {
        // A pass does not change the numbers of other digits.
        scratch.histograms.resize(shifts.len(), [0; DIGITS]);
        count_all(keys, &shifts, &mut scratch.histograms);
    } else {
        scratch.histograms.resize(blocks, [0; DIGITS]);
    }
    for (pass, shift) in shifts.enumerate() {
        cancel.check()?;
        let histograms = if blocks == 1 {
            std::slice::from_mut(&mut scratch.histograms[pass])
        } else {
            count(keys, shift, &mut scratch.histograms);
            scratch.histograms.as_mut_slice()
        };
        if scatter(keys, &scratch.keys, shift, histograms) {
            std::mem::swap(keys, &mut scratch.keys);
        }
    }
    Ok(())
}

/// Value of a key.
#[inline(always)]
pub(crate) fn load(key: &Key) -> u64 {
    key.load(Ordering::Relaxed)
}

/// Counts the digits of all passes.
fn count_all(keys: &[Key], shifts: &(impl Iterator<Item = u32> + Clone), histograms: &mut [Histogram]) {
    for histogram in &mut *histograms {
        histogram.fill(0);
    }
    for key in keys {
        let key = load(key);
        for (histogram, shift) in histograms.iter_mut().zip(shifts.clone()) {
            histogram[digit(key, shift)] += 1;
        }
    }
}

/// Counts the digits of one pass in each block.
fn count(keys: &[Key], shift: u32, histograms: &mut [Histogram]) {
    let block = keys.len().div_ceil(histograms.len());
    keys.par_chunks(block).zip(histograms).for_each(|(keys, histogram)| {
        histogram.fill(0);
        for key in keys {
            histogram[digit(load(key), shift)] += 1;
        }
    });
}

/// Copies all keys from `from` to `to` in the order of one digit. Copies nothing and returns false if all digits are equal.
fn scatter(from: &[Key], to: &[Key], shift: u32, histograms: &mut [Histogram]) -> bool {
    let block = from.len().div_ceil(histograms.len());

    // Prefix sum: output positions of each block's keys of each digit.
    let mut start = 0;
    for digit in 0..DIGITS {
        let first = start;
        for histogram in &mut *histograms {
            start += std::mem::replace(&mut histogram[digit], start);
        }
        if start - first == from.len() as u32 {
            return false;
        }
    }

    from.par_chunks(block).zip(histograms).for_each(|(keys, positions)| {
        for key in keys {
            let key = load(key);
            let position = &mut positions[digit(key, shift)];
            to[*position as usize].store(key, Ordering::Relaxed);
            *position += 1;
        }
    });
    true
}

#[inline(always)]
fn digit(key: u64, shift: u32) -> usize {
    (key >> shift) as usize & (DIGITS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(keys: impl Iterator<Item = u64>, bits: Range<u32>) {
        let keys: Vec<u64> = keys.collect();
        let mask = (1 << bits.end) - (1 << bits.start);
        let mut expected = keys.clone();
        expected.sort_by_key(|key| key & mask);
        for threads in [1, 2, 3, 8] {
            let mut sorted: Vec<Key> = keys.iter().map(|&key| Key::new(key)).collect();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (mut scratch, cancel) = (Scratch::default(), CancelFlag::new());
            pool.install(|| sort(&mut sorted, bits.clone(), &mut scratch, &cancel)).unwrap();
            let sorted: Vec<u64> = sorted.iter().map(load).collect();
            assert!(sorted == expected, "{threads} threads, {} keys", keys.len());
        }
    }

    fn scrambled(i: u64) -> u64 {
        let x = (i ^ 0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (x ^ x >> 31).wrapping_mul(0x94d0_49bb_1331_11eb) >> 1
    }

    #[test]
    fn equals_the_stable_comparison_sort() {
        for n in [0, 1, 2, SMALL as u64, 100_003] {
            check((0..n).map(scrambled), 27..63);
            check((0..n).map(scrambled), 0..36);
        }
    }

    #[test]
    fn keeps_the_order_of_equal_codes() {
        check((0..70_000).map(|_| 42), 0..12);
        check((0..70_000).map(|i| scrambled(i) & 0x0000_ff00_0000_0003), 24..60);
        check((0..70_000).rev(), 4..16);
    }

    #[test]
    fn stops_when_cancelled() {
        let cancel = CancelFlag::new();
        cancel.raise();
        let mut keys: Vec<Key> = (0..10_000).map(Key::new).collect();
        assert!(sort(&mut keys, 28..64, &mut Scratch::default(), &cancel).is_err());
    }
}
