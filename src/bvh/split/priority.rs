//! Splitting the triangles whose boxes waste most.
//!
//! Source: Karras and Aila, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", HPG 2013, section
//! 4: a triangle's priority is the cube root of how much its box area exceeds what many parts would have, times 2⁻ⁱ for a
//! box that the Morton grid first divides at level i, and `⌊D p⌋` splits go to priority p, D being chosen so that
//! their sum is what is wanted.
//!
//! Departure: D comes from a histogram of log p, not from a search over all triangles. Where boxes are cut is decided in
//! [`super::cut`].

use rayon::prelude::*;

use super::cut::{cut_of, split_one};
use crate::bvh::build::morton::Grid;
use crate::bvh::references::{CHUNK, Input, Measures, Reference};
use crate::cancel::Cancelled;
use crate::geometry::Triangle;

/// Bins of priorities, as a power of two, to an octave.
const LOG2_BINS_PER_OCTAVE: u32 = 6;
/// Bins, 16 octaves below one. What is lower than all of them is not split.
const BINS: usize = 16 << LOG2_BINS_PER_OCTAVE;
/// Steps of the search for D.
const SEARCH_STEPS: u32 = 40;
/// More splits than this of one triangle are not wanted.
const MAX_SPLITS: f32 = 4096.0;

/// Memory kept between builds.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    priorities: Vec<f32>,
    parts: Vec<Reference>,
}

/// Splits `references`, the boxes of whole triangles, into at most `aim`.
pub(crate) fn split(
    input: Input,
    whole: &Measures,
    aim: usize,
    scratch: &mut Scratch,
    references: &mut Vec<Reference>,
) -> Result<(), Cancelled> {
    let grid = Grid::around(&whole.bounds);
    let Scratch { priorities, parts } = scratch;
    let histogram = prioritise(input, whole, &grid, references, priorities)?;
    let factor = splits_for_one(&histogram, aim.saturating_sub(references.len()) as u64);
    let splits = |priority: &f32| (factor * *priority).min(MAX_SPLITS) as u32;

    // Room for the parts of each chunk.
    let rooms: Vec<usize> = priorities
        .par_chunks(CHUNK)
        .map(|chunk| chunk.iter().map(|priority| 1 + splits(priority) as usize).sum())
        .collect();
    parts.resize(rooms.iter().sum(), Reference::NONE);
    let mut outputs = Vec::with_capacity(rooms.len());
    let mut rest = parts.as_mut_slice();
    for &room in &rooms {
        let (output, after) = rest.split_at_mut(room);
        outputs.push(output);
        rest = after;
    }

    // The parts.
    let made: Vec<usize> = outputs
        .into_par_iter()
        .zip(references.par_chunks(CHUNK).zip(priorities.par_chunks(CHUNK)))
        .map(|(output, (references, priorities))| {
            input.cancel.check()?;
            let mut count = 0;
            let mut todo = Vec::new();
            for (reference, priority) in references.iter().zip(priorities) {
                let triangle = &input.triangles[reference.triangle_id as usize];
                count += split_one(
                    triangle,
                    reference,
                    splits(priority),
                    (&grid, &mut todo),
                    &mut output[count..],
                );
            }
            Ok(count)
        })
        .collect::<Result<_, _>>()?;

    // Close the gaps that cuts left out leave.
    let (mut from, mut to) = (0, 0);
    for (&room, &count) in rooms.iter().zip(&made) {
        if from != to {
            parts.copy_within(from..from + count, to);
        }
        (from, to) = (from + room, to + count);
    }
    parts.truncate(to);
    std::mem::swap(parts, references);
    Ok(())
}

/// Computes all priorities; gives how many there are by bin.
fn prioritise(
    input: Input,
    whole: &Measures,
    grid: &Grid,
    references: &[Reference],
    priorities: &mut Vec<f32>,
) -> Result<Vec<u64>, Cancelled> {
    let scale = whole.scale();
    priorities.resize(references.len(), 0.0);
    priorities
        .par_chunks_mut(CHUNK)
        .zip(references.par_chunks(CHUNK))
        .map(|(priorities, references)| {
            input.cancel.check()?;
            let mut bins = vec![0_u64; BINS];
            for (priority, reference) in priorities.iter_mut().zip(references) {
                let triangle = &input.triangles[reference.triangle_id as usize];
                *priority = priority_of(triangle, reference, grid, scale);
                if let Some(bin) = bins.get_mut(bin_of(*priority)) {
                    *bin += 1;
                }
            }
            Ok(bins)
        })
        .try_reduce(
            || vec![0; BINS],
            |mut a, b| {
                a.iter_mut().zip(&b).for_each(|(a, b)| *a += b);
                Ok(a)
            },
        )
}

/// The priority of a triangle, from 0 to 1; `scale` makes the scene one long.
fn priority_of(triangle: &Triangle, reference: &Reference, grid: &Grid, scale: f32) -> f32 {
    let e = reference.bounds.extent() * scale;
    let area = e.x * e.y + e.y * e.z + e.z * e.x;
    // The areas of the triangle's shadows along the axes: what tiny boxes around it come to.
    let [a, b, c] = triangle.vertices.map(|vertex| vertex * scale);
    let ideal = 0.5 * (b - a).cross(c - a).abs().element_sum();
    let waste = area - ideal;
    if waste > 0.0 && waste < f32::INFINITY {
        // A third of the areas of a cube as long as the scene.
        let level = cut_of(&reference.bounds, grid).map_or(0, |cut| cut.level.min(21));
        let importance = f32::from_bits((127 - level) << 23);
        rough_cube_root(waste * (1.0 / 3.0) * importance).min(1.0)
    } else {
        0.0
    }
}

/// Within a thousandth of the cube root; the same on every machine.
fn rough_cube_root(x: f32) -> f32 {
    // A third of the exponent, and one step of Newton's.
    let guess = f32::from_bits(x.to_bits() / 3 + 0x2a51_37a0);
    guess - (guess - x / (guess * guess)) * (1.0 / 3.0)
}

/// The bin of a priority; beyond all bins for those too low.
fn bin_of(priority: f32) -> usize {
    let shift = f32::MANTISSA_DIGITS - 1 - LOG2_BINS_PER_OCTAVE;
    ((1.0_f32.to_bits() >> shift) - (priority.to_bits() >> shift)) as usize
}

/// The highest priority of a bin.
fn top_of(bin: usize) -> f32 {
    let shift = f32::MANTISSA_DIGITS - 1 - LOG2_BINS_PER_OCTAVE;
    f32::from_bits((((1.0_f32.to_bits() >> shift) - bin as u32 + 1) << shift) - 1)
}

/// The largest D that makes at most `wanted` splits: how many a triangle of priority 1 gets.
fn splits_for_one(histogram: &[u64], wanted: u64) -> f32 {
    let total = |factor: f32| -> u64 {
        let splits = |bin| (factor * top_of(bin)).min(MAX_SPLITS) as u64;
        histogram.iter().enumerate().map(|(bin, &count)| count * splits(bin)).sum()
    };
    // What is beyond the last bin must get none.
    let (mut low, mut high) = (0.0, top_of(BINS - 1).recip());
    for _ in 0..SEARCH_STEPS {
        let middle = 0.5 * (low + high);
        *(if total(middle) <= wanted { &mut low } else { &mut high }) = middle;
    }
    low
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::bvh::TriangleFlags;
    use crate::bvh::references::gather_whole;
    use crate::cancel::CancelFlag;
    use crate::geometry::Aabb;
    use glam::Vec3;

    /// Long thin diagonal triangles through a unit cube, among small ones.
    pub(crate) fn bars(n: usize) -> Vec<Triangle> {
        let mut state = 3_u32;
        let mut random = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        (0..n)
            .map(|i| {
                let [a, b] = [0; 2].map(|_| Vec3::new(random(), random(), random()));
                let b = if i % 2 == 0 { b } else { a + Vec3::splat(0.01) };
                Triangle { vertices: [a, b, b + Vec3::new(0.001, 0.002, 0.0)] }
            })
            .collect()
    }

    fn parts_of(triangles: &[Triangle], aim: usize) -> Vec<Reference> {
        let flags = vec![TriangleFlags::default(); triangles.len()];
        let cancel = CancelFlag::new();
        let input = Input { triangles, flags: &flags, cancel: &cancel };
        let mut references = Vec::new();
        let whole = gather_whole(input, &mut references).unwrap();
        split(input, &whole, aim, &mut Scratch::default(), &mut references).unwrap();
        references
    }

    #[test]
    fn comes_near_the_aim_and_covers_every_triangle() {
        let triangles = bars(20_000);
        for aim in [20_000, 21_000, 40_000, 80_000] {
            let references = parts_of(&triangles, aim);
            assert!(references.len() <= aim && references.len() * 100 > aim * 94, "{}", references.len());
            assert!(references.is_sorted_by_key(|reference| reference.triangle_id));
            for parts in references.chunk_by(|a, b| a.triangle_id == b.triangle_id) {
                let covered = parts.iter().fold(Aabb::EMPTY, |all, part| all.union(part.bounds));
                assert!(covered.contains(&triangles[parts[0].triangle_id as usize].bounds()));
            }
            let areas: f64 = references.iter().map(|reference| reference.bounds.area()).sum();
            let whole: f64 = triangles.iter().map(|triangle| triangle.bounds().area()).sum();
            assert!(aim == 20_000 || areas < 0.95 * whole);
        }
    }

    #[test]
    fn threads_do_not_matter() {
        let triangles = bars(10_000);
        let results = [1, 2, 3, 8].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| parts_of(&triangles, 25_000))
        });
        assert!(results.iter().all(|result| *result == results[0]));
    }

    #[test]
    fn the_cube_root_is_near() {
        for x in [1.0e-12_f32, 1.0e-3, 0.3, 1.0] {
            let error = rough_cube_root(x) / libm::cbrtf(x) - 1.0;
            assert!(error.abs() < 2.0e-3, "{x} {error}");
        }
    }

    #[test]
    fn a_bin_holds_what_lies_below_its_top() {
        for bin in [0, 1, 100, BINS - 1] {
            assert_eq!(bin_of(top_of(bin).min(1.0)), bin);
            assert_eq!(bin_of(top_of(bin).next_up().min(1.0)), bin.saturating_sub(1));
        }
        assert!(bin_of(0.0) >= BINS);
    }
}
