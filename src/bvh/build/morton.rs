//! Morton codes of box centres, and references sorted by them.
//!
//! Source: Morton 1966 for the order; Lauterbach et al., "Fast BVH Construction on GPUs", Eurographics 2009 for its use in
//! hierarchies. Codes have 63 bits, 21 per axis, over a cubic grid.
//!
//! A radix sort moves the upper 36 bits of a code and the 28-bit index of its reference as one word. Runs of codes with equal
//! upper bits are then sorted by the lower 27. Such runs are rare except for small dense objects in large scenes.

use std::sync::atomic::Ordering;

use fearless_simd::{Level, Simd};
use glam::Vec3;
use rayon::prelude::*;

use super::radix_sort::{self, Key, load};
use crate::bvh::references::Reference;
use crate::bvh::simd::dispatch_lanes;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Aabb;
use crate::parallel_resize::{resize_with, resize_zeroed};

const CHUNK: usize = 1 << 11;
const BITS_PER_AXIS: u32 = 21;
/// Bits of a key that hold the index of a reference; above them are the upper bits of its code.
const INDEX_BITS: u32 = 28;
const INDEX_MASK: u64 = (1 << INDEX_BITS) - 1;
/// Lower bits of a code, which its key does not hold.
const LOWER_BITS: u32 = 3 * BITS_PER_AXIS - (u64::BITS - INDEX_BITS);
const LOWER_MASK: u64 = (1 << LOWER_BITS) - 1;
/// Runs of keys with equal upper bits up to this length are sorted by insertion.
const SHORT_RUN: usize = 24;

/// Cubic grid of 2²¹ cells per axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    origin: [f64; 3],
    cells_per_metre: f64,
    metres_per_cell: f64,
}

/// References sorted by code; those with equal codes keep their order.
#[derive(Debug, Default)]
pub(crate) struct MortonOrder {
    keys: Vec<Key>,
    /// Lower bits of the code of each reference, in the order of the references.
    lower: Vec<u32>,
    scratch: radix_sort::Scratch,
}

impl MortonOrder {
    /// Sorts `references`, whose centres lie in `centers`.
    pub(crate) fn sort(
        &mut self,
        references: &[Reference],
        centers: &Aabb,
        cancel: &CancelFlag,
    ) -> Result<(), Cancelled> {
        let grid = Grid::around(centers);
        resize_with(&mut self.keys, references.len(), Key::default);
        resize_zeroed(&mut self.lower, references.len(), 0);
        let level = Level::new();
        let chunks = self.keys.par_chunks_mut(CHUNK).zip(self.lower.par_chunks_mut(CHUNK));
        chunks.zip(references.par_chunks(CHUNK)).enumerate().for_each(
            |(chunk, ((keys, lower), references))| {
                dispatch_lanes!(level, simd => grid.fill(simd, references, chunk * CHUNK, keys, lower));
            },
        );
        radix_sort::sort(&mut self.keys, INDEX_BITS..u64::BITS, &mut self.scratch, cancel)?;
        self.sort_runs(cancel)
    }

    /// Number of references.
    pub(crate) fn len(&self) -> usize {
        self.keys.len()
    }

    /// Index of the reference at a position.
    #[inline(always)]
    pub(crate) fn index(&self, position: usize) -> u32 {
        (load(&self.keys[position]) & INDEX_MASK) as u32
    }

    /// Code of the reference at a position.
    #[inline(always)]
    pub(crate) fn code(&self, position: usize) -> u64 {
        load(&self.keys[position]) >> INDEX_BITS << LOWER_BITS | self.lower(position)
    }

    /// Lower bits of the code of the reference at a position.
    #[inline(always)]
    fn lower(&self, position: usize) -> u64 {
        u64::from(self.lower[self.index(position) as usize])
    }

    /// Difference of the keys at `position` and the next one. Differences compare like the highest bit in which the codes differ.
    /// Equal codes compare below all others, by the highest bit in which the positions differ (Karras 2012, section 4).
    #[inline(always)]
    pub(crate) fn difference(&self, position: usize) -> u64 {
        const CODES: u64 = 1 << 63;
        let upper = (load(&self.keys[position]) ^ load(&self.keys[position + 1])) >> INDEX_BITS;
        if upper != 0 {
            return upper << LOWER_BITS | CODES;
        }
        match self.lower(position) ^ self.lower(position + 1) {
            0 => (position ^ (position + 1)) as u64,
            lower => lower | CODES,
        }
    }

    /// Sorts runs of keys with equal upper bits by the lower bits.
    fn sort_runs(&mut self, cancel: &CancelFlag) -> Result<(), Cancelled> {
        let Self { keys, lower, .. } = self;
        let keys = keys.as_slice();
        (0..keys.len().div_ceil(CHUNK)).into_par_iter().try_for_each(|chunk| {
            cancel.check()?;
            // A chunk sorts the runs that start in it.
            let mut position = chunk * CHUNK;
            let end = keys.len().min(position + CHUNK);
            if position > 0 {
                position +=
                    keys[position - 1..end].windows(2).take_while(|pair| are_in_one_run(pair)).count();
            }
            while position < end {
                let run = keys[position..].windows(2).take_while(|pair| are_in_one_run(pair)).count() + 1;
                if run > 1 {
                    sort_run(&keys[position..position + run], lower);
                }
                position += run;
            }
            Ok(())
        })
    }
}

fn are_in_one_run(pair: &[Key]) -> bool {
    (load(&pair[0]) ^ load(&pair[1])) >> INDEX_BITS == 0
}

/// Sorts a run by the lower bits of its codes, then by index.
fn sort_run(run: &[Key], lower: &[u32]) {
    let upper = load(&run[0]) & !INDEX_MASK;
    let lower_first = |key: &Key| {
        let index = load(key) & INDEX_MASK;
        u64::from(lower[index as usize]) << INDEX_BITS | index
    };
    let put =
        |position: usize, sorted: u64| run[position].store(upper | sorted & INDEX_MASK, Ordering::Relaxed);
    if run.len() > SHORT_RUN {
        let mut sorted: Vec<u64> = run.iter().map(lower_first).collect();
        sorted.sort_unstable();
        sorted.into_iter().enumerate().for_each(|(position, key)| put(position, key));
        return;
    }
    let mut sorted = [0; SHORT_RUN];
    for (count, key) in run.iter().map(lower_first).enumerate() {
        let mut position = count;
        while position > 0 && sorted[position - 1] > key {
            sorted[position] = sorted[position - 1];
            position -= 1;
        }
        sorted[position] = key;
    }
    sorted[..run.len()].iter().enumerate().for_each(|(position, &key)| put(position, key));
}

impl Grid {
    /// Grid whose first cell starts at the lowest corner of `bounds` and whose cube contains all of it.
    pub(crate) fn around(bounds: &Aabb) -> Self {
        let min = bounds.min.as_dvec3();
        let extent = (bounds.max.as_dvec3() - min).max_element();
        Self {
            origin: min.to_array(),
            // Identical points are all in the first cell.
            metres_per_cell: extent / f64::from(1_u32 << BITS_PER_AXIS),
            cells_per_metre: if extent > 0.0 { f64::from(1_u32 << BITS_PER_AXIS) / extent } else { 0.0 },
        }
    }

    /// Computes the keys of references, of which the first has the index `first`, and the lower bits of their codes.
    #[inline(always)]
    fn fill<S: Simd>(
        &self,
        _: S,
        references: &[Reference],
        first: usize,
        keys: &mut [Key],
        lower: &mut [u32],
    ) {
        for (key, reference) in keys.iter_mut().zip(references) {
            *key.get_mut() = self.code(reference.bounds.center());
        }
        for (index, (key, lower)) in (first as u64..).zip(keys.iter_mut().zip(lower)) {
            let code = *key.get_mut();
            *key.get_mut() = code >> LOWER_BITS << INDEX_BITS | index;
            *lower = (code & LOWER_MASK) as u32;
        }
    }

    /// Plane between `low` and `high` on an axis at which the grid is divided first, and its level in the grid. Codes are rounded, so they
    /// change half a cell below the plane ([`Self::code`]).
    pub(crate) fn first_plane(&self, axis: usize, low: f32, high: f32) -> Option<(f32, u32)> {
        let origin = self.origin[axis];
        let cell = |x: f32| ((f64::from(x) - origin) * self.cells_per_metre) as i32;
        let (low, high) = (cell(low), cell(high));
        let bit = (low ^ high).checked_ilog2().filter(|_| low >= 0)?;
        let plane = origin + f64::from(high >> bit << bit) * self.metres_per_cell;
        Some((plane as f32, (BITS_PER_AXIS - 1).saturating_sub(bit)))
    }

    /// Code of `point`: the bits of its three coordinates interleaved, x first. A coordinate is the number of cells from the grid's origin,
    /// rounded to the nearest integer: `k` stands for `k` − ½ to `k` + ½ cells, not for one cell.
    #[inline(always)]
    pub(crate) fn code(&self, point: Vec3) -> u64 {
        // Adding this to a number from 0 to 2²¹ leaves the nearest integer in the lowest bits.
        const WHOLE: f64 = (1_u64 << 52) as f64;
        const LAST: f64 = ((1 << BITS_PER_AXIS) - 1) as f64;
        let mut code = 0;
        for axis in 0..3 {
            let cell = (f64::from(point[axis]) - self.origin[axis]) * self.cells_per_metre;
            let cell = if cell < LAST { cell } else { LAST };
            code |= spread((cell + WHOLE).to_bits()) << (2 - axis);
        }
        code
    }
}

/// The low 21 bits, each preceded by two zeros.
#[inline(always)]
fn spread(value: u64) -> u64 {
    let mut x = value & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Order of references with the given sorted codes.
    pub(crate) fn order_of(codes: &[u64]) -> MortonOrder {
        let key = |(i, code): (usize, &u64)| Key::new(code >> LOWER_BITS << INDEX_BITS | i as u64);
        MortonOrder {
            keys: codes.iter().enumerate().map(key).collect(),
            lower: codes.iter().map(|code| (code & LOWER_MASK) as u32).collect(),
            scratch: radix_sort::Scratch::default(),
        }
    }

    fn check(codes: &[u64]) {
        let mut expected: Vec<u32> = (0..codes.len() as u32).collect();
        expected.sort_by_key(|&index| codes[index as usize]);
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut order = order_of(codes);
            let cancel = CancelFlag::new();
            pool.install(|| {
                radix_sort::sort(&mut order.keys, INDEX_BITS..u64::BITS, &mut order.scratch, &cancel)
                    .unwrap();
                order.sort_runs(&cancel).unwrap();
            });
            let sorted: Vec<u32> = (0..order.len()).map(|position| order.index(position)).collect();
            assert!(sorted == expected, "{threads} threads, {} codes", codes.len());
        }
    }

    #[test]
    fn equals_the_stable_comparison_sort() {
        let scrambled = |i: u64| (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 1;
        for n in [0, 1, 2, 100, 30_000] {
            // Codes of all bits; codes that differ in lower bits only; codes in long and short runs; equal codes.
            for mask in [!0 >> 1, LOWER_MASK, 3 << 50 | LOWER_MASK, 0xffff << 22 | 3, 1, 0] {
                check(&(0..n).map(|i| scrambled(i) & mask).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn differences_compare_like_first_differing_bits() {
        let codes = [0, 1, 1, 1, 5, 1 << 30, 1 << 62];
        let order = order_of(&codes);
        let differences: Vec<u64> = (0..6).map(|position| order.difference(position)).collect();
        // Positions 1, 2, 3 have equal codes: 1 ^ 2 = 3, 2 ^ 3 = 1.
        assert_eq!(differences[1..3], [3, 1]);
        assert!(differences[2] < differences[0] && differences[0] < differences[3]);
        assert!(differences[3] < differences[4] && differences[4] < differences[5]);
    }

    #[test]
    fn spread_moves_every_bit() {
        for bit in 0..21 {
            assert_eq!(spread(1 << bit), 1 << (3 * bit));
        }
        assert_eq!(spread(0x1f_ffff).count_ones(), 21);
    }

    #[test]
    fn codes_interleave_the_bits_of_cells() {
        // A cell is a metre. Digits of x, y and z in turn, from the highest.
        let cube = Aabb { min: Vec3::ZERO, max: Vec3::splat((1 << BITS_PER_AXIS) as f32) };
        let code = |x: i32, y: i32, z: i32| Grid::around(&cube).code(Vec3::new(x as f32, y as f32, z as f32));
        assert_eq!(code(0b1, 0b0, 0b0), 0b100);
        assert_eq!(code(0b101, 0b011, 0b110), 0b101_011_110);
        assert_eq!(code(0b1011, 0b0110, 0b1100), 0b101_011_110_100);
        // In a plane every third digit is zero.
        let codes = [[0, 0], [0, 1], [1, 0], [1, 1], [2, 3], [3, 2]].map(|[x, y]| code(x, y, 0));
        assert_eq!(codes, [0, 0b010, 0b100, 0b110, 0b110_010, 0b110_100]);
    }

    #[test]
    fn codes_change_half_a_cell_below_the_planes() {
        // A cell is a metre, and its first plane is at 1.
        let cube = Aabb { min: Vec3::ZERO, max: Vec3::splat((1 << BITS_PER_AXIS) as f32) };
        let grid = Grid::around(&cube);
        // Codes are of the nearest whole number, of two the even one.
        let codes = [0.4, 0.5, 0.6, 1.4, 1.5, 1.6].map(|z| grid.code(Vec3::Z * z));
        assert_eq!(codes, [0, 0, 1, 1, 0b1000, 0b1000]);
        assert_eq!(grid.first_plane(2, 0.4, 0.6), None);
        assert_eq!(grid.first_plane(2, 0.6, 1.4), Some((1.0, BITS_PER_AXIS - 1)));
    }

    #[test]
    fn the_grid_spans_any_extent() {
        for scale in [1.0, 1.0e30, 1.0e-30, 3.0e38] {
            let bounds = Aabb { min: Vec3::splat(-scale), max: Vec3::splat(scale) };
            let grid = Grid::around(&bounds);
            assert_eq!(grid.code(bounds.min), 0);
            assert_eq!(grid.code(bounds.max), (1 << 63) - 1);
            // The middle of x alone sets its top bit alone.
            assert_eq!(grid.code(Vec3::new(0.0, -scale, -scale)), 1 << 62);
            assert_eq!(grid.code(Vec3::new(-scale, 0.0, -scale)), 1 << 61);
            assert_eq!(grid.code(Vec3::new(-scale, -scale, 0.0)), 1 << 60);
        }
    }

    #[test]
    fn flat_and_single_points_have_codes() {
        let flat = Aabb { min: Vec3::new(1.0, 5.0, 1.0), max: Vec3::new(2.0, 5.0, 1.5) };
        let code = Grid::around(&flat).code(flat.max);
        assert_eq!(code & spread(0x1f_ffff) << 1, 0, "the flat axis has no bits");
        assert_ne!(code, 0);
        let point = Aabb::from_points(&[Vec3::splat(1.0e30)]);
        assert_eq!(Grid::around(&point).code(point.min), 0);
    }
}
