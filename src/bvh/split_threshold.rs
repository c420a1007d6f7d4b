//! Which SA_max early split clipping uses.
//!
//! Splitting pays where boxes overlap massively, and does harm elsewhere. `E`, the sum of the triangles' box areas over the
//! area of the scene's box, is the number of boxes that a line through the scene meets on average. [`Split::Auto`]
//! splits nothing while `E ≤ 16`, nor where the average box takes more than a quarter of the scene's area, since a few cuts then
//! cannot set the triangles apart (identical ones, say), and otherwise aims at `R = min(budget, 1 + ((E − 16) / 118)^0.57)` references a
//! triangle. [`Split::Area`] is used as it is unless it makes more references than the budget; then the budget is the aim.
//!
//! An aim becomes an SA_max through an upper bound of the number of references: a box that is halved k times without
//! clipping contains each box that k steps of Algorithm 4 make from it, so a triangle makes at most 2ᵏ references for the
//! smallest k whose halved box does not exceed SA_max. A histogram of these areas gives the bound for all SA_max at
//! once. Diagonal triangles fill less than the bound, so corrections by what a sample of the triangles
//! makes follow. All counts are integers and all sums have a fixed order: the outcome does not depend on the number of
//! threads.

use rayon::prelude::*;

use super::split_budget::Budget;
use super::split_clip::{Input, Reference, Scratch, gather, split};
use super::{BuildSettings, Split};
use crate::cancel::Cancelled;
use crate::geometry::Aabb;

/// The number of boxes met by a line below which `Split::Auto` does nothing.
const OVERLAP_WORTH_SPLITTING: f64 = 16.0;
/// The average box's share of the scene's area above which `Split::Auto` does nothing.
const SHARE_BEYOND_SPLITTING: f64 = 0.25;
/// Boxes met by a line beyond [`OVERLAP_WORTH_SPLITTING`] at which `Split::Auto` aims at one reference more a triangle.
const OVERLAP_SCALE: f64 = 118.0;
/// How the references beyond one a triangle grow with that excess.
const OVERLAP_EXPONENT: f64 = 0.57;
/// Halvings that the histogram follows; 2⁴⁰ references are beyond any budget.
const MOST_HALVINGS: u32 = 40;
/// How often the bound is corrected.
const CORRECTIONS: u32 = 3;
/// The part of the references wanted that is aimed at, so that the budget is seldom missed.
const AIM_BELOW: f64 = 0.95;
/// Chunks of triangles in the sample.
const SAMPLED_CHUNKS: usize = 8;
/// The bound is not corrected by more than this factor at once.
const LARGEST_CORRECTION: f64 = 16.0;
/// Bins an octave of area, as a power of two.
const BINS_AN_OCTAVE_LOG2: u32 = 3;
/// Bins, 64 octaves below the largest area.
const BINS: usize = 64 << BINS_AN_OCTAVE_LOG2;

/// The SA_max that was used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Threshold {
    /// Square metres; infinite for no splits.
    pub(super) sa_max: f64,
    /// Whether an explicit SA_max was raised to keep within the budget.
    pub(super) budget_reached: bool,
}

/// Sums over the visible triangles.
#[derive(Clone, Copy)]
struct Measures {
    triangles: u64,
    bounds: Aabb,
    area_sum: f64,
    largest_area: f64,
}

/// Fills `references` with the boxes that `settings` ask for.
pub(super) fn gather_references(
    input: Input,
    settings: &BuildSettings,
    scratch: &mut Scratch,
    references: &mut Vec<Reference>,
) -> Result<Threshold, Cancelled> {
    let mut gather_all = |sa_max, limit| gather(input, sa_max, limit, scratch, references);
    let explicit = match settings.split {
        Split::Area(area) if !area.is_nan() => f64::from(area),
        _ => f64::INFINITY,
    };
    let budget = if settings.reference_budget >= 1.0 { f64::from(settings.reference_budget) } else { 1.0 };
    if explicit == f64::INFINITY && settings.split != Split::Auto {
        gather_all(f64::INFINITY, u64::MAX)?;
        return Ok(Threshold { sa_max: f64::INFINITY, budget_reached: false });
    }

    // As asked, if that is within the budget.
    let measures = measure(input)?;
    let limit = (measures.triangles as f64 * budget) as u64;
    let is_auto = settings.split == Split::Auto;
    if !is_auto && gather_all(explicit, limit)? {
        return Ok(Threshold { sa_max: explicit, budget_reached: false });
    }

    // What comes near the aim; or what is sure to keep within it.
    let aim = if is_auto { automatic_aim(&measures, budget) } else { limit };
    let mut sa_max = f64::INFINITY;
    for candidate in thresholds_for(input, &measures, aim)? {
        sa_max = if is_auto { candidate } else { candidate.max(explicit) };
        if gather_all(sa_max, limit)? {
            break;
        }
    }
    Ok(Threshold { sa_max, budget_reached: !is_auto })
}

/// How many references [`Split::Auto`] aims at.
fn automatic_aim(measures: &Measures, budget: f64) -> u64 {
    let overlap = measures.area_sum / measures.bounds.area();
    let share = overlap / measures.triangles as f64;
    if !overlap.is_finite() || overlap <= OVERLAP_WORTH_SPLITTING || share > SHARE_BEYOND_SPLITTING {
        return measures.triangles;
    }
    let ratio = 1.0 + libm::pow((overlap - OVERLAP_WORTH_SPLITTING) / OVERLAP_SCALE, OVERLAP_EXPONENT);
    (measures.triangles as f64 * ratio.min(budget)) as u64
}

fn measure(input: Input) -> Result<Measures, Cancelled> {
    let none = Measures { triangles: 0, bounds: Aabb::EMPTY, area_sum: 0.0, largest_area: 0.0 };
    let chunks: Vec<Measures> = (0..input.chunks())
        .into_par_iter()
        .map(|chunk| {
            input.cancel.check()?;
            Ok(input.chunk(chunk).fold(none, |sum, (_, triangle)| {
                let bounds = triangle.bounds();
                let area = bounds.area();
                Measures {
                    triangles: sum.triangles + 1,
                    bounds: sum.bounds.union(bounds),
                    area_sum: sum.area_sum + area,
                    largest_area: sum.largest_area.max(area),
                }
            }))
        })
        .collect::<Result<_, _>>()?;
    Ok(chunks.iter().fold(none, |sum, chunk| Measures {
        triangles: sum.triangles + chunk.triangles,
        bounds: sum.bounds.union(chunk.bounds),
        area_sum: sum.area_sum + chunk.area_sum,
        largest_area: sum.largest_area.max(chunk.largest_area),
    }))
}

/// References that `sa_max` makes and triangles, in every `stride`-th chunk; of the former at most `limit`.
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
    // How far beyond the limit the tasks went depends on their timing.
    Ok((budget.spent().min(limit), triangles))
}

/// An SA_max that by a sample makes nearly `aim` references, and one that makes no more.
fn thresholds_for(input: Input, measures: &Measures, aim: u64) -> Result<Vec<f64>, Cancelled> {
    let n = measures.triangles;
    if aim <= n || measures.largest_area <= 0.0 {
        return Ok(vec![f64::INFINITY]);
    }
    let histogram = histogram(input, measures.largest_area, aim)?;
    let sure = sa_max_of(&histogram, measures, aim);

    // Correct the bound by how much of it the sample used.
    let stride = (input.chunks() / SAMPLED_CHUNKS).max(1);
    let wanted = (aim - n) as f64 * AIM_BELOW;
    let mut bound = wanted;
    let mut near = sure;
    for _ in 0..CORRECTIONS {
        let (references, triangles) = sample(input, near, stride, 2 * aim)?;
        let extra = (references - triangles) as f64 * (n as f64 / triangles.max(1) as f64);
        bound *= (wanted / extra.max(1.0)).clamp(1.0 / LARGEST_CORRECTION, LARGEST_CORRECTION);
        near = sa_max_of(&histogram, measures, n + bound as u64);
    }
    Ok(vec![near, sure])
}

/// For each bin of area, how many references the bound gains when SA_max falls below the bin.
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
                    for halvings in 0..MOST_HALVINGS {
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

/// The bin of an area: eighths of octaves, by bits, below the largest.
fn bin_of(area: f64, top: u64) -> usize {
    let below = top.saturating_sub(area.to_bits()) >> (52 - BINS_AN_OCTAVE_LOG2);
    (below as usize).min(BINS - 1)
}

/// The smallest upper edge of a bin at which the bound is not above `aim`.
fn sa_max_of(histogram: &[u64], measures: &Measures, aim: u64) -> f64 {
    let mut total = measures.triangles;
    let mut bin = 0;
    // The last bin has no lower edge.
    while bin + 1 < BINS && total + histogram[bin] <= aim {
        total += histogram[bin];
        bin += 1;
    }
    let top = measures.largest_area.to_bits();
    f64::from_bits(top.saturating_sub((bin as u64) << (52 - BINS_AN_OCTAVE_LOG2)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::{PrimitiveFlags, SimdLevel};
    use crate::cancel::CancelFlag;
    use crate::geometry::Triangle;
    use glam::Vec3;

    /// Long thin diagonal triangles through a unit cube: they overlap massively.
    fn bars(n: usize) -> Vec<Triangle> {
        let mut state = 3_u32;
        let mut random = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        (0..n)
            .map(|_| {
                let [a, b] = [0; 2].map(|_| Vec3::new(random(), random(), random()));
                Triangle { vertices: [a, b, b + Vec3::new(0.001, 0.002, 0.0)] }
            })
            .collect()
    }

    fn chosen(triangles: &[Triangle], split: Split, budget: f32) -> (Threshold, usize) {
        let flags = vec![PrimitiveFlags::default(); triangles.len()];
        let cancel = CancelFlag::new();
        let input = Input { triangles, flags: &flags, cancel: &cancel };
        let settings = BuildSettings {
            split,
            reference_budget: budget,
            simd: SimdLevel::Scalar,
            ..BuildSettings::default()
        };
        let mut references = Vec::new();
        let threshold =
            gather_references(input, &settings, &mut Scratch::default(), &mut references).unwrap();
        (threshold, references.len())
    }

    #[test]
    fn scattered_triangles_are_not_split() {
        // 1000 small triangles in a large box: E is far below 16.
        let triangles: Vec<Triangle> = (0..1000)
            .map(|i| {
                let p = Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32);
                Triangle { vertices: [p, p + Vec3::X * 0.1, p + Vec3::Y * 0.1] }
            })
            .collect();
        assert_eq!(chosen(&triangles, Split::Auto, 4.0).0.sa_max, f64::INFINITY);
    }

    #[test]
    fn triangles_that_no_cut_sets_apart_are_not_split() {
        let triangles = vec![Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::ONE] }; 1000];
        assert_eq!(chosen(&triangles, Split::Auto, 4.0), (chosen(&triangles, Split::Off, 4.0).0, 1000));
    }

    #[test]
    fn auto_comes_near_its_aim() {
        let triangles = bars(2000);
        let (threshold, count) = chosen(&triangles, Split::Auto, 4.0);
        assert!(!threshold.budget_reached);
        // The mean extents of such boxes are a third of the cube's, so E is about 2000 / 9 and the aim about 2.4.
        let ratio = count as f64 / 2000.0;
        assert!((2.0..=2.5).contains(&ratio), "{ratio}");
        // A smaller budget is kept.
        let ratio = chosen(&triangles, Split::Auto, 1.5).1 as f64 / 2000.0;
        assert!((1.2..=1.5).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_tiny_area_keeps_to_the_budget() {
        let triangles = bars(2000);
        for area in [1.0e-9, 1.0e-30, 0.0] {
            let (threshold, count) = chosen(&triangles, Split::Area(area), 3.0);
            assert!(threshold.budget_reached);
            assert!((4000..=6000).contains(&count), "{count}");
        }
        let one = &triangles[..1];
        assert!(chosen(one, Split::Area(1.0e-30), 4.0).1 <= 4);
        assert_eq!(chosen(one, Split::Area(1.0e-30), f32::NAN).1, 1);
    }

    #[test]
    fn an_area_within_the_budget_is_used_as_it_is() {
        let (threshold, count) = chosen(&bars(500), Split::Area(1.0), 4.0);
        assert_eq!((threshold.sa_max, threshold.budget_reached), (1.0, false));
        assert!(count > 500);
        assert_eq!(chosen(&bars(500), Split::Area(f32::NAN), 4.0).1, 500);
    }

    #[test]
    fn no_triangles_need_no_threshold() {
        for split in [Split::Off, Split::Auto, Split::Area(0.0)] {
            assert_eq!(chosen(&[], split, 4.0).1, 0);
        }
    }
}
