//! Morton codes of box centres.
//!
//! Source: the order is Morton's (1966); its use for building hierarchies is Lauterbach et al., "Fast BVH Construction
//! on GPUs", Eurographics 2009. Codes have 63 bits, 21 an axis, over a cubic grid.

use glam::Vec3;
use rayon::prelude::*;

use super::radix_sort::Keyed;
use super::split_clip::Reference;
use crate::cancel::{CancelFlag, Cancelled};
use crate::geometry::Aabb;

const CHUNK: usize = 1 << 14;
const BITS_AN_AXIS: u32 = 21;

/// A cubic grid of 2²¹ cells an axis.
#[derive(Clone, Copy, Debug)]
struct Grid {
    origin: [f64; 3],
    cells_a_metre: f64,
}

/// Fills `keys` with the code and index of every reference.
pub(super) fn codes(
    references: &[Reference],
    keys: &mut Vec<Keyed>,
    cancel: &CancelFlag,
) -> Result<(), Cancelled> {
    let centers = references
        .par_chunks(CHUNK)
        .map(|chunk| {
            chunk.iter().fold(Aabb::EMPTY, |all, reference| all.union_point(reference.bounds.center()))
        })
        .reduce(|| Aabb::EMPTY, Aabb::union);
    let grid = Grid::around(&centers);

    keys.clear();
    keys.resize(references.len(), Keyed::default());
    keys.par_chunks_mut(CHUNK).zip(references.par_chunks(CHUNK)).enumerate().try_for_each(
        |(chunk, (keys, references))| {
            cancel.check()?;
            for (i, (key, reference)) in keys.iter_mut().zip(references).enumerate() {
                *key =
                    Keyed { code: grid.code(reference.bounds.center()), index: (chunk * CHUNK + i) as u32 };
            }
            Ok(())
        },
    )
}

impl Grid {
    /// The grid whose first cell starts at the lowest corner of `bounds` and whose cube holds all of it.
    fn around(bounds: &Aabb) -> Self {
        let min = bounds.min.as_dvec3();
        let extent = (bounds.max.as_dvec3() - min).max_element();
        Self {
            origin: min.to_array(),
            // Of points that are all alike, each is in the first cell.
            cells_a_metre: if extent > 0.0 { f64::from(1_u32 << BITS_AN_AXIS) / extent } else { 0.0 },
        }
    }

    /// The code of the cell that holds `point`: the bits of its three coordinates interleaved, x first.
    fn code(&self, point: Vec3) -> u64 {
        let mut code = 0;
        for axis in 0..3 {
            let cell = (f64::from(point[axis]) - self.origin[axis]) * self.cells_a_metre;
            // The conversion saturates, at zero for what is negative.
            let cell = (cell as u64).min((1 << BITS_AN_AXIS) - 1);
            code |= spread(cell) << (2 - axis);
        }
        code
    }
}

/// The low 21 bits with two zeros before each.
fn spread(value: u64) -> u64 {
    let mut x = value & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreading_places_every_bit() {
        for bit in 0..21 {
            assert_eq!(spread(1 << bit), 1 << (3 * bit));
        }
        assert_eq!(spread(0x1f_ffff).count_ones(), 21);
    }

    #[test]
    fn the_grid_spans_any_extent() {
        for scale in [1.0, 1.0e30, 1.0e-30, 3.0e38] {
            let bounds = Aabb { min: Vec3::splat(-scale), max: Vec3::splat(scale) };
            let grid = Grid::around(&bounds);
            assert_eq!(grid.code(bounds.min), 0);
            assert_eq!(grid.code(bounds.max), (1 << 63) - 1);
            // One step beyond the middle of x alone sets its top bit alone.
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
        let point = Aabb::from_point(Vec3::splat(1.0e30));
        assert_eq!(Grid::around(&point).code(point.min), 0);
    }
}
