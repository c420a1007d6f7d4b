//! A parallel stable radix sort of Morton codes.
//!
//! Source: least significant digit first, as in Satish, Harris, Garland, "Designing Efficient Sorting Algorithms for
//! Manycore GPUs", IPDPS 2009: a histogram a block, a prefix sum over (digit, block), and a stable scatter. Stability makes the
//! result independent of the number of blocks, and so of threads.

use rayon::prelude::*;

use crate::cancel::{CancelFlag, Cancelled};

/// A code and the index of the reference it belongs to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Keyed {
    /// Morton code.
    pub(super) code: u64,
    /// Index into the references.
    pub(super) index: u32,
}

const DIGIT_BITS: u32 = 8;
const DIGITS: usize = 1 << DIGIT_BITS;
/// Below this many keys a comparison sort is faster.
const SMALL: usize = 2048;
/// Blocks are not smaller than this.
const SMALLEST_BLOCK: usize = 1 << 14;

type Histogram = [u32; DIGITS];

/// Sorts `keys` by code; equal codes keep their order. `scratch` is memory to use, its contents do not matter.
pub(super) fn sort(
    keys: &mut Vec<Keyed>,
    scratch: &mut Vec<Keyed>,
    cancel: &CancelFlag,
) -> Result<(), Cancelled> {
    cancel.check()?;
    if keys.len() < SMALL {
        keys.sort_by_key(|key| key.code);
        return Ok(());
    }
    scratch.resize(keys.len(), Keyed::default());

    let varying = varying_bits(keys);
    let block = keys.len().div_ceil(4 * rayon::current_num_threads()).max(SMALLEST_BLOCK);
    for shift in (0..u64::BITS).step_by(DIGIT_BITS as usize) {
        // Digits that all codes share need no pass.
        if varying >> shift & (DIGITS as u64 - 1) == 0 {
            continue;
        }
        cancel.check()?;
        pass(keys, scratch, shift, block);
        std::mem::swap(keys, scratch);
    }
    Ok(())
}

/// The bits in which any two codes differ.
fn varying_bits(keys: &[Keyed]) -> u64 {
    let first = keys.first().map_or(0, |key| key.code);
    keys.par_chunks(SMALLEST_BLOCK)
        .map(|chunk| chunk.iter().fold(0, |bits, key| bits | (key.code ^ first)))
        .reduce(|| 0, |a, b| a | b)
}

/// Moves all keys from `from` to `to` in the order of one digit.
fn pass(from: &[Keyed], to: &mut [Keyed], shift: u32, block: usize) {
    let histograms: Vec<Histogram> = from
        .par_chunks(block)
        .map(|keys| {
            let mut histogram = [0; DIGITS];
            for key in keys {
                histogram[digit(key, shift)] += 1;
            }
            histogram
        })
        .collect();

    // Cut the output into one run a digit and block; every block then owns the runs it fills.
    let mut runs: Vec<Vec<std::slice::IterMut<Keyed>>> =
        histograms.iter().map(|_| Vec::with_capacity(DIGITS)).collect();
    let mut rest = to;
    for digit in 0..DIGITS {
        for (histogram, runs) in histograms.iter().zip(&mut runs) {
            let (run, after) = rest.split_at_mut(histogram[digit] as usize);
            runs.push(run.iter_mut());
            rest = after;
        }
    }

    from.par_chunks(block).zip(runs).for_each(|(keys, mut runs)| {
        for key in keys {
            // The histogram counted exactly these keys, so there is always a place.
            if let Some(place) = runs[digit(key, shift)].next() {
                *place = *key;
            }
        }
    });
}

fn digit(key: &Keyed, shift: u32) -> usize {
    (key.code >> shift) as usize & (DIGITS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(codes: impl Iterator<Item = u64>) {
        let mut keys: Vec<Keyed> =
            codes.enumerate().map(|(i, code)| Keyed { code, index: i as u32 }).collect();
        let mut expected = keys.clone();
        expected.sort_by_key(|key| key.code);
        for threads in [1, 2, 3, 8] {
            let mut sorted = keys.clone();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| sort(&mut sorted, &mut Vec::new(), &CancelFlag::new())).unwrap();
            assert!(sorted == expected, "{threads} threads, {} keys", keys.len());
        }
        keys.clear();
    }

    fn scrambled(i: u64) -> u64 {
        let x = (i ^ 0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (x ^ x >> 31).wrapping_mul(0x94d0_49bb_1331_11eb) >> 1
    }

    #[test]
    fn equals_the_stable_comparison_sort() {
        for n in [0, 1, 2, SMALL as u64, 100_003] {
            check((0..n).map(scrambled));
        }
    }

    #[test]
    fn keeps_the_order_of_equal_codes() {
        check((0..70_000).map(|_| 42));
        check((0..70_000).map(|i| scrambled(i) & 0x0000_ff00_0000_0003));
        check((0..70_000).rev());
    }

    #[test]
    fn stops_when_asked() {
        let cancel = CancelFlag::new();
        cancel.raise();
        assert!(sort(&mut vec![Keyed::default(); 10_000], &mut Vec::new(), &cancel).is_err());
    }
}
