//! Albedos of GGX lobes at one index of refraction, over roughness and view: a slice whose cubic over the index is evaluated once.
//!
//! The values are those of [`AlbedoSlice`]. A lookup reads four grid points, and the arithmetic around it is done for the lanes of a block
//! together.

use fearless_simd::Level;
use glam::Vec4;

use super::albedo_grid::{COLUMNS, CellLanes, ROWS};
use super::albedo_slice::AlbedoSlice;
use super::isotropic_albedo::{self, AlbedoTerms, SMOOTH, mirror_share};
use super::stored_values::UNIT;
use super::{external_albedo, fresnel};
use crate::geometry::{ActiveLanes, F32Lanes, LANES, vectorized};

/// The albedos of lobes at one relative index of refraction.
#[derive(Clone, Debug)]
pub(crate) struct AlbedoTable {
    slice: AlbedoSlice,
    /// Values of the grid points: the albedo with F = 1 and that with Schlick's F without the mirror's part, both in multiples of [`UNIT`],
    /// and that with the exact F without the mirror's part. Empty where the slice has no such table, or does the lookups itself.
    points: Vec<Vec4>,
}

/// Albedo terms of a block.
#[derive(Debug, Default)]
pub(crate) struct AlbedoTermLanes {
    total: F32Lanes,
    schlick: F32Lanes,
    exact: F32Lanes,
}

impl AlbedoTermLanes {
    /// The terms of a lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> AlbedoTerms {
        AlbedoTerms { total: self.total[lane], schlick: self.schlick[lane], exact: self.exact[lane] }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, terms: AlbedoTerms) {
        (self.total[lane], self.schlick[lane], self.exact[lane]) = (terms.total, terms.schlick, terms.exact);
    }
}

impl AlbedoTable {
    /// The table of the boundary between two media.
    pub(crate) fn between(ior_outside: f32, ior_inside: f32) -> Self {
        let slice = AlbedoSlice::between(ior_outside, ior_inside);
        let points = match slice.thinner_side() {
            Some(position) => (0..ROWS * COLUMNS)
                .map(|point| {
                    let [total, schlick] = isotropic_albedo::at_point(point);
                    Vec4::new(total, schlick, position.at_point(external_albedo::STORED, point), 0.0)
                })
                .collect(),
            None => Vec::new(),
        };
        Self { slice, points }
    }

    /// The same values without memory of their own: the slice does each lookup.
    pub(crate) fn of_slice(ior_outside: f32, ior_inside: f32) -> Self {
        Self { slice: AlbedoSlice::between(ior_outside, ior_inside), points: Vec::new() }
    }

    /// Bytes on the heap.
    #[cfg(test)]
    pub(crate) fn heap_bytes(&self) -> usize {
        self.points.capacity() * size_of::<Vec4>()
    }

    /// The slice of the table.
    pub(crate) fn slice(&self) -> AlbedoSlice {
        self.slice
    }

    /// The terms of [`AlbedoSlice::terms`] for a block of views and roughnesses.
    pub(crate) fn terms(
        &self,
        (level, lanes): (Level, ActiveLanes),
        cos_o: &F32Lanes,
        roughness: &F32Lanes,
        out: &mut AlbedoTermLanes,
    ) {
        if self.points.is_empty() {
            for lane in lanes {
                out.set(lane, self.slice.terms(cos_o[lane], roughness[lane]));
            }
            return;
        }
        let mut cells = CellLanes::default();
        vectorized!(level, cells.locate(cos_o, roughness));
        for lane in lanes {
            let [total, schlick, exact, _] = cells.interpolate(lane, &self.points).to_array();
            out.set(lane, AlbedoTerms { total, schlick, exact });
        }
        vectorized!(level, self.complete(cos_o, roughness, out));
    }

    /// Adds the mirror's parts to interpolated values.
    #[inline(always)]
    fn complete(&self, cos_o: &F32Lanes, roughness: &F32Lanes, out: &mut AlbedoTermLanes) {
        for lane in 0..LANES {
            let (cos_o, roughness) = (cos_o[lane].clamp(0.0, 1.0), roughness[lane]);
            let terms = out.get(lane);
            let (total, rest) = (terms.total * UNIT, terms.schlick * UNIT);
            let total = if total < 1.0 { total } else { 1.0 };
            let mirrored = mirror_share(roughness) * total;
            let weight = fresnel::schlick_weight(cos_o);
            let reflectance = self.slice.reflectance(cos_o);
            let schlick = (rest + mirrored * weight).clamp(0.0, total);
            let exact = self.slice.exact_beyond(terms.exact, mirrored, total) + mirrored * reflectance;
            let is_mirror = roughness < SMOOTH;
            out.set(
                lane,
                AlbedoTerms {
                    total: if is_mirror { 1.0 } else { total },
                    schlick: if is_mirror { weight } else { schlick },
                    exact: if is_mirror { reflectance } else { exact.clamp(0.0, total) },
                },
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_those_of_the_slice() {
        let lanes = ActiveLanes::first(LANES);
        for ior in [1.0, 1.004, 1.2, 1.5, 1.9, 40.0, 0.7] {
            let tables = [AlbedoTable::between(1.0, ior), AlbedoTable::of_slice(1.0, ior)];
            let slice = AlbedoSlice::between(1.0, ior);
            for row in 0..20 {
                let roughness =
                    [if row == 0 { 0.0 } else { (row as f32 / 19.0) * (row as f32 / 19.0) }; LANES];
                let cos_o: F32Lanes = std::array::from_fn(|lane| lane as f32 / 15.0);
                let levels = [Level::fallback(), Level::new()];
                for (table, level) in tables.iter().flat_map(|table| levels.map(|level| (table, level))) {
                    let mut out = AlbedoTermLanes::default();
                    table.terms((level, lanes), &cos_o, &roughness, &mut out);
                    for lane in lanes {
                        let (found, expected) = (out.get(lane), slice.terms(cos_o[lane], roughness[lane]));
                        assert_eq!(found, expected, "{ior} {} {}", cos_o[lane], roughness[lane]);
                    }
                }
            }
        }
    }
}
