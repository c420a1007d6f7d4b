//! References: the boxes that a hierarchy is built over, one for each traced triangle.
//!
//! Every box is grown by [`BOX_PADDING`] of its triangle's largest coordinate, as the definition of a hit requires
//! ([`crate::geometry::ShearedRay`]). Splitting adds boxes: [`super::split`].

use fearless_simd::{Level, Simd};
use rayon::prelude::*;

use super::box_area::scaled_half_area;
use super::lane_boxes::{LANES, LaneBounds, LaneBoxes};
use super::simd::dispatch_lanes;
use super::triangle_flags::{TriangleFlags, is_traced};

use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::{Aabb, BOX_PADDING, Triangle};
use crate::parallel_resize::resize_with;

/// Range of area sums that single precision suffices for: no term has overflowed, and those that underflow are too small to count in the sum.
/// The latter have the octave of zero.
const ORDINARY_AREAS: std::ops::Range<f64> = 1.0e-20..1.0e30;

/// Triangles, or references, per task.
pub(super) const CHUNK: usize = 1 << 11;

/// Box of a triangle or of a part of one. A cache line holds two.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Reference {
    /// Padded box.
    pub(super) bounds: Aabb,
    /// Index of the triangle.
    pub(super) triangle_id: u32,
}

/// Triangles of a build.
#[derive(Clone, Copy)]
pub(super) struct Input<'a> {
    /// All triangles of the frame.
    pub(super) triangles: &'a [Triangle],
    /// Their flags.
    pub(super) flags: &'a [TriangleFlags],
    /// Cancels the build when raised.
    pub(super) cancel: &'a CancelFlag,
}

/// Count, bounds and area sums of references.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measures {
    /// Number of references.
    pub(super) count: usize,
    /// Box around all references.
    pub(super) bounds: Aabb,
    /// Box around their centres.
    pub(super) centers: Aabb,
    /// Sum of their surface areas, square metres.
    pub(super) area_sum: f64,
    /// Sum of the binary exponents of those areas.
    pub(super) octave_sum: u64,
    /// Sum of the squares of those exponents.
    pub(super) octave_square_sum: u64,
}

impl Reference {
    /// Placeholder of an unfilled entry.
    pub(super) const NONE: Self = Self { bounds: Aabb::EMPTY, triangle_id: u32::MAX };

    /// Reference with the box of a whole triangle.
    #[inline(always)]
    fn of(triangle: &Triangle, triangle_id: u32) -> Self {
        Self { bounds: triangle.bounds().grown(padding(triangle)), triangle_id }
    }
}

impl<'a> Input<'a> {
    /// Traced triangles of a chunk, with their indices.
    pub(super) fn chunk(&self, chunk: usize) -> impl Iterator<Item = (u32, &'a Triangle)> + use<'a> {
        let first = chunk * CHUNK;
        let last = self.triangles.len().min(first + CHUNK);
        let triangles = self.triangles[first..last].iter();
        triangles
            .zip(&self.flags[first..last])
            .enumerate()
            .filter(|(_, (triangle, flags))| is_traced(triangle, **flags))
            .map(move |(i, (triangle, _))| ((first + i) as u32, triangle))
    }

    /// Number of chunks.
    pub(super) fn chunks(&self) -> usize {
        self.triangles.len().div_ceil(CHUNK)
    }
}

impl Measures {
    /// Measures of no references.
    pub(super) const NONE: Self = Self {
        count: 0,
        bounds: Aabb::EMPTY,
        centers: Aabb::EMPTY,
        area_sum: 0.0,
        octave_sum: 0,
        octave_square_sum: 0,
    };

    /// Adds a reference with this box.
    #[inline(always)]
    fn add(&mut self, bounds: &Aabb) {
        self.count += 1;
        self.bounds = self.bounds.union(*bounds);
        self.centers = self.centers.union_point(bounds.center());
        self.add_area(f64::from(2.0 * scaled_half_area(bounds, 1.0)));
    }

    #[inline(always)]
    fn add_area(&mut self, area: f64) {
        self.area_sum += area;
        let octave = area.to_bits() >> (f64::MANTISSA_DIGITS - 1);
        self.octave_sum += octave;
        self.octave_square_sum += octave * octave;
    }

    /// Sum over the chunks of `references`.
    fn total(chunks: &[Self], references: &[Reference]) -> Self {
        let mut total = Self::NONE;
        for chunk in chunks {
            total.count += chunk.count;
            total.bounds = total.bounds.union(chunk.bounds);
            total.centers = total.centers.union(chunk.centers);
            total.area_sum += chunk.area_sum;
            total.octave_sum += chunk.octave_sum;
            total.octave_square_sum += chunk.octave_square_sum;
        }
        // Areas outside the range of f32 are added again in f64.
        if !ORDINARY_AREAS.contains(&total.area_sum) {
            (total.area_sum, total.octave_sum, total.octave_square_sum) = (0.0, 0, 0);
            for reference in references {
                total.add_area(reference.bounds.area());
            }
        }
        total
    }

    /// Factor that makes the longest edge of the scene one, so that products of two scaled lengths neither overflow nor
    /// underflow.
    pub(super) fn scale(&self) -> f32 {
        let extent = (self.bounds.max.as_dvec3() - self.bounds.min.as_dvec3()).max_element();
        if extent > 0.0 { extent.recip() as f32 } else { 1.0 }
    }

    /// Variance of the areas' octaves, their binary exponents. Every reference counts alike, so a few huge ones hardly matter.
    pub(super) fn octave_variance(&self) -> f64 {
        if self.count == 0 {
            return 0.0;
        }
        let count = self.count as f64;
        let mean = self.octave_sum as f64 / count;
        self.octave_square_sum as f64 / count - mean * mean
    }

    /// Average number of boxes that a line through the scene's box intersects.
    pub(super) fn overlap(&self) -> f64 {
        let scene = self.bounds.area();
        if scene > 0.0 { self.area_sum / scene } else { 0.0 }
    }
}

/// Padding of the box of a triangle or of a part of it.
#[inline(always)]
pub(super) fn padding(triangle: &Triangle) -> f32 {
    triangle.magnitude() * BOX_PADDING + f32::MIN_POSITIVE
}

/// Fills `references` with the boxes of all traced triangles, in their order, and measures them.
pub(super) fn gather_whole(input: Input, references: &mut Vec<Reference>) -> Result<Measures, Cancelled> {
    resize_with(references, input.triangles.len(), || Reference::NONE);
    let level = Level::new();
    let chunks: Vec<Measures> = references
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(chunk, out)| {
            input.cancel.check()?;
            Ok(dispatch_lanes!(level, simd => gather_chunk(simd, input, chunk * CHUNK, out)))
        })
        .collect::<Result<_, _>>()?;

    // Close the gaps of triangles that are not traced.
    let mut kept = 0;
    for (chunk, measures) in chunks.iter().enumerate() {
        let first = chunk * CHUNK;
        if kept != first {
            references.copy_within(first..first + measures.count, kept);
        }
        kept += measures.count;
    }
    references.truncate(kept);
    Ok(Measures::total(&chunks, references))
}

/// Fills the front of `out` with the boxes of the traced triangles from `first` on.
#[inline(always)]
fn gather_chunk<S: Simd>(simd: S, input: Input, first: usize, out: &mut [Reference]) -> Measures {
    let last = first + out.len();
    let (triangles, flags) = (&input.triangles[first..last], &input.flags[first..last]);
    let mut measures = Measures::NONE;
    let mut lanes = LaneBounds::empty(simd);
    for (start, flags) in (0..).step_by(LANES).zip(flags.chunks(LANES)) {
        let triangles = &triangles[start..start + flags.len()];
        let next = &mut out[measures.count..];
        let is_hidden = flags.iter().any(|flags| flags.has(TriangleFlags::HIDDEN));
        if let Some(eight) = triangles.first_chunk().filter(|_| !is_hidden)
            && let Some(boxes) = LaneBoxes::of(simd, eight)
        {
            for ((triangle_id, out), bounds) in ((first + start) as u32..).zip(next).zip(boxes.boxes()) {
                *out = Reference { bounds, triangle_id };
            }
            lanes.add(&boxes);
            measures.count += LANES;
            boxes.areas().into_iter().for_each(|area| measures.add_area(f64::from(area)));
        } else {
            gather_some(triangles, flags, first + start, next, &mut measures);
        }
    }
    let [bounds, centers] = lanes.total();
    measures.bounds = measures.bounds.union(bounds);
    measures.centers = measures.centers.union(centers);
    measures
}

/// Fills the front of `out` with the boxes of those of a few triangles that are traced.
#[inline(never)]
fn gather_some(
    triangles: &[Triangle],
    flags: &[TriangleFlags],
    first: usize,
    out: &mut [Reference],
    measures: &mut Measures,
) {
    let mut out = out.iter_mut();
    for (triangle_id, (triangle, &flags)) in (first as u32..).zip(triangles.iter().zip(flags)) {
        if is_traced(triangle, flags)
            && let Some(out) = out.next()
        {
            *out = Reference::of(triangle, triangle_id);
            measures.add(&out.bounds);
        }
    }
}

/// Measures references.
pub(super) fn measure(references: &[Reference]) -> Measures {
    let measure_chunk = |chunk: &[Reference]| {
        let mut measures = Measures::NONE;
        for reference in chunk {
            measures.add(&reference.bounds);
        }
        measures
    };
    let chunks: Vec<Measures> = references.par_chunks(CHUNK).map(measure_chunk).collect();
    Measures::total(&chunks, references)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::SimdLevel;
    use glam::Vec3;

    /// Triangles of which some are hidden and some have zero area.
    fn with_gaps(n: usize) -> (Vec<Triangle>, Vec<TriangleFlags>) {
        let triangles = (0..n)
            .map(|i| {
                let corner = Vec3::new(i as f32, (i % 17) as f32, -(i as f32));
                let second = if i % 5 == 0 { corner } else { corner + Vec3::X };
                Triangle { vertices: [corner, second, corner + Vec3::Y] }
            })
            .collect();
        let hidden = |i| if i % 7 == 0 { TriangleFlags::HIDDEN } else { TriangleFlags::SINGLE_SIDED };
        (triangles, (0..n).map(hidden).collect())
    }

    #[test]
    fn hidden_and_degenerate_triangles_are_skipped_for_any_number_of_threads() {
        for n in [0, 1, 2, 100, 10_000] {
            let (triangles, flags) = with_gaps(n);
            let expected: Vec<Reference> = (0..n)
                .filter(|i| i % 5 != 0 && i % 7 != 0)
                .map(|i| Reference::of(&triangles[i], i as u32))
                .collect();
            for threads in [1, 2, 3, 8] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let cancel = CancelFlag::new();
                let input = Input { triangles: &triangles, flags: &flags, cancel: &cancel };
                let mut references = vec![Reference::NONE; 5];
                let measures = pool.install(|| gather_whole(input, &mut references)).unwrap();
                assert_eq!(references, expected);
                assert_eq!(measures.count, expected.len());
                assert_eq!(
                    measures.bounds,
                    expected.iter().fold(Aabb::EMPTY, |all, reference| all.union(reference.bounds))
                );
            }
        }
    }

    /// Triangles of mixed sizes, of which one in `gap` is hidden, one has no area, and one is not finite.
    fn mixed(n: usize, gap: usize) -> (Vec<Triangle>, Vec<TriangleFlags>) {
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let triangles = (0..n)
            .map(|i| {
                let size = [1.0e-4, 0.01, 1.0, 50.0][i % 4];
                let [a, b, c] = [0; 3].map(|_| Vec3::new(random(), random(), random()));
                let b = if i % gap == 1 { a } else { a + b * size };
                let c = if i % gap == 2 { Vec3::splat(f32::NAN) } else { a + c * size };
                Triangle { vertices: [a, b, c] }
            })
            .collect();
        let hidden = |i| if i % gap == 0 { TriangleFlags::HIDDEN } else { TriangleFlags::default() };
        (triangles, (0..n).map(hidden).collect())
    }

    #[test]
    fn lanes_equal_single_triangles_at_every_level() {
        for (n, gap) in [(7, 100), (8, 100), (1003, 100), (1003, 9), (1003, 1_000_000)] {
            let (triangles, flags) = mixed(n, gap);
            let cancel = CancelFlag::new();
            let input = Input { triangles: &triangles, flags: &flags, cancel: &cancel };
            let mut expected = vec![Reference::NONE; n];
            let mut measures = Measures::NONE;
            gather_some(&triangles, &flags, 0, &mut expected, &mut measures);
            for level in SimdLevel::ALL.into_iter().filter(|level| level.is_supported()) {
                let mut out = vec![Reference::NONE; n];
                let level = level.level();
                let found = dispatch_lanes!(level, simd => gather_chunk(simd, input, 0, &mut out));
                assert_eq!(found, measures, "{n} {gap} {level:?}");
                assert_eq!(out[..found.count], expected[..found.count]);
            }
        }
    }

    #[test]
    fn measures_of_two_unit_cubes() {
        // Each has area 6; together they are 3 x 1 x 1, area 14; their centres are 2 apart.
        let cube = |x: f32| Reference {
            bounds: Aabb { min: Vec3::X * x, max: Vec3::X * x + Vec3::ONE },
            triangle_id: 0,
        };
        let measures = measure(&[cube(0.0), cube(2.0)]);
        assert_eq!((measures.count, measures.area_sum), (2, 12.0));
        assert_eq!(measures.centers, Aabb { min: Vec3::splat(0.5), max: Vec3::new(2.5, 0.5, 0.5) });
        assert_eq!(measures.overlap(), 12.0 / 14.0);
        assert_eq!(measures.octave_variance(), 0.0);
        // With a third one of eight times the edge, six octaves above: mean 2, variance (4 + 4 + 16) / 3.
        let large = Reference { bounds: Aabb { min: Vec3::ZERO, max: Vec3::splat(8.0) }, triangle_id: 0 };
        let variance = measure(&[cube(0.0), cube(2.0), large]).octave_variance();
        assert!((variance - 8.0).abs() < 1.0e-6, "{variance}");
    }
}
