//! Threshold SA_max of early split clipping.
//!
//! The area of [`crate::bvh::Split::Area`] is used as it is unless it creates more references than the budget. Then the budget is
//! the aim.
//!
//! An upper bound of the number of references turns the aim into SA_max. A box halved k times without clipping contains each
//! box that k steps of Algorithm 4 create from it. So a triangle creates at most 2ᵏ references, for the smallest k whose halved
//! box does not exceed SA_max. A histogram of these areas gives the bound for all SA_max at once. Diagonal triangles stay below
//! the bound, so it is then corrected by the references of a sample of triangles. All counts are integers and all sums have a
//! fixed order, so the result does not depend on the number of threads.

use rayon::prelude::*;

use super::budget::Budget;
use super::clip::{Scratch, gather, split};
use crate::bvh::references::{Input, Reference};
use crate::cancel::Cancelled;

/// Maximum of halvings in the histogram; 2⁴⁰ references exceed any budget.
const MAX_HALVINGS: u32 = 40;
/// Number of corrections of the bound.
const CORRECTIONS: u32 = 3;
/// Part of the wanted references that is the aim, so that the budget is seldom exceeded.
const AIM_BELOW: f64 = 0.95;
/// Chunks of triangles in the sample.
const SAMPLED_CHUNKS: usize = 8;
/// Maximum factor of one correction.
const MAX_CORRECTION: f64 = 16.0;
/// Binary logarithm of the bins per octave of area.
const LOG2_BINS_PER_OCTAVE: u32 = 3;
/// Number of bins, 64 octaves below the largest area.
const BINS: usize = 64 << LOG2_BINS_PER_OCTAVE;

/// SA_max that was used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Threshold {
    /// Square metres; infinite for no splits.
    pub(crate) sa_max: f64,
    /// Whether an explicit SA_max was raised to stay within the budget.
    pub(crate) budget_reached: bool,
}

/// Number of traced triangles and area of the largest box of one.
#[derive(Clone, Copy)]
struct Measures {
    triangles: u64,
    largest_area: f64,
}

/// Fills `references` with the boxes for `sa_max` or, if those exceed `limit`, with nearly that many.
pub(crate) fn gather_by_area(
    input: Input,
    sa_max: f64,
    limit: u64,
    scratch: &mut Scratch,
    references: &mut Vec<Reference>,
) -> Result<Threshold, Cancelled> {
    if gather(input, sa_max, limit, scratch, references)? {
        return Ok(Threshold { sa_max, budget_reached: false });
    }
    // A threshold that approaches the limit, or else one that certainly stays within it.
    let explicit = sa_max;
    let mut sa_max = f64::INFINITY;
    for candidate in thresholds_for(input, &measure(input)?, limit)? {
        sa_max = candidate.max(explicit);
        if gather(input, sa_max, limit, scratch, references)? {
            break;
        }
    }
    Ok(Threshold { sa_max, budget_reached: true })
}

fn measure(input: Input) -> Result<Measures, Cancelled> {
    let none = Measures { triangles: 0, largest_area: 0.0 };
    let both = |a: Measures, b: Measures| Measures {
        triangles: a.triangles + b.triangles,
        largest_area: a.largest_area.max(b.largest_area),
    };
    (0..input.chunks())
        .into_par_iter()
        .map(|chunk| {
            input.cancel.check()?;
            Ok(input.chunk(chunk).fold(none, |sum, (_, triangle)| {
                both(sum, Measures { triangles: 1, largest_area: triangle.bounds().area() })
            }))
        })
        .try_reduce(|| none, |a, b| Ok(both(a, b)))
}

/// Numbers of references for `sa_max` (at most `limit`) and of triangles, in every `stride`-th chunk.
fn sample(input: Input, sa_max: f64, stride: usize, limit: u64) -> Result<(u64, u64), Cancelled> {
    let budget = Budget::new(limit, input.cancel);
    let triangles = (0..input.chunks().div_ceil(stride))
        .into_par_iter()
        .map(|i| {
            let mut share = budget.share();
            let mut triangles = 0;
            for (_, triangle) in input.chunk(i * stride) {
                triangles += 1;
                split(triangle, sa_max, |_| share.spend());
            }
            triangles
        })
        .sum();
    input.cancel.check()?;
    // The excess over the limit depends on the timing of tasks.
    Ok((budget.spent().min(limit), triangles))
}

/// Two thresholds: one that by a sample creates nearly `aim` references, and one that certainly creates no more.
fn thresholds_for(input: Input, measures: &Measures, aim: u64) -> Result<Vec<f64>, Cancelled> {
    let n = measures.triangles;
    if aim <= n || measures.largest_area <= 0.0 {
        return Ok(vec![f64::INFINITY]);
    }
    let histogram = histogram(input, measures.largest_area, aim)?;
    let safe = sa_max_of(&histogram, measures, aim);

    // Correct the bound by the references of a sample.
    let stride = (input.chunks() / SAMPLED_CHUNKS).max(1);
    let wanted = (aim - n) as f64 * AIM_BELOW;
    let mut bound = wanted;
    let mut near = safe;
    for _ in 0..CORRECTIONS {
        let (references, triangles) = sample(input, near, stride, 2 * aim)?;
        let extra = (references - triangles) as f64 * (n as f64 / triangles.max(1) as f64);
        bound *= (wanted / extra.max(1.0)).clamp(1.0 / MAX_CORRECTION, MAX_CORRECTION);
        near = sa_max_of(&histogram, measures, n + bound as u64);
    }
    Ok(vec![near, safe])
}

/// For each bin of area, the references that the bound gains when SA_max falls below the bin.
fn histogram(input: Input, largest_area: f64, aim: u64) -> Result<Vec<u64>, Cancelled> {
    let top = largest_area.to_bits();
    (0..input.chunks())
        .into_par_iter()
        .try_fold(
            || vec![0_u64; BINS],
            |mut bins, chunk| {
                input.cancel.check()?;
                for (_, triangle) in input.chunk(chunk) {
                    let bounds = triangle.bounds();
                    let mut extent = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).to_array();
                    for halvings in 0..MAX_HALVINGS {
                        let [x, y, z] = extent;
                        let area = 2.0 * (x * y + y * z + z * x);
                        // Halving k + 1 turns 2^k references into twice as many.
                        let gain = 1_u64 << halvings;
                        if area <= 0.0 || gain > aim {
                            break;
                        }
                        bins[bin_of(area, top)] += gain;
                        let longest = (0..3).fold(0, |a, b| if extent[b] > extent[a] { b } else { a });
                        extent[longest] *= 0.5;
                    }
                }
                Ok(bins)
            },
        )
        .try_reduce(
            || vec![0; BINS],
            |mut a, b| {
                a.iter_mut().zip(&b).for_each(|(a, b)| *a += b);
                Ok(a)
            },
        )
}

/// Bin of an area: eighths of octaves below the largest, by its bits.
fn bin_of(area: f64, top: u64) -> usize {
    let below = top.saturating_sub(area.to_bits()) >> (52 - LOG2_BINS_PER_OCTAVE);
    (below as usize).min(BINS - 1)
}

/// Smallest upper edge of a bin at which the bound does not exceed `aim`.
fn sa_max_of(histogram: &[u64], measures: &Measures, aim: u64) -> f64 {
    let mut total = measures.triangles;
    let mut bin = 0;
    // The last bin has no lower edge.
    while bin + 1 < BINS && total + histogram[bin] <= aim {
        total += histogram[bin];
        bin += 1;
    }
    let top = measures.largest_area.to_bits();
    f64::from_bits(top.saturating_sub((bin as u64) << (52 - LOG2_BINS_PER_OCTAVE)))
}
