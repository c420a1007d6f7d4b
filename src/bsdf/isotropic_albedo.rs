//! Directional albedo of the isotropic GGX lobe without a Fresnel factor, and with Schlick's weight.
//!
//! Source: the integrals of [`super::microfacets`], tabulated. As in the split sum of Karis, "Real Shading in Unreal Engine 4", 2013,
//! equation 8, both give the albedo of every Schlick curve. [`super::albedo_slice`] adds the exact curves.
//!
//! Single scattering only; [`super::multiple_scattering`] adds the light that rough lobes lose.

use super::albedo_grid::{Cell, grid_points, roughness_of, view_of};
use super::fresnel;
use super::microfacets::Microfacets;
use super::stored_values::{UNIT, decoded, stored};

/// Albedos of a lobe: with F = 1, with F = (1 − o·h)⁵, and with the exact F of an index.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AlbedoTerms {
    pub(crate) total: f32,
    pub(crate) schlick: f32,
    pub(crate) exact: f32,
}

/// Surfaces of a lower roughness are mirrors: their lobes look the same, and α would leave the range of floats.
pub(super) const SMOOTH: f32 = 1e-6;
/// The values of the table, in turn `total` and `schlick` without the mirror's part; [`super::albedo_tables`] says how they are made.
pub(super) const STORED: &[u8] = include_bytes!("lobe_albedo.bin");
/// From this roughness the tables hold whole albedos.
const ROUGH: f32 = 0.4;

/// The albedos with F = 1 and with F = (1 − o·h)⁵; `exact` stays 0.
#[inline(always)]
pub(super) fn schlick_terms(cos_o: f32, roughness: f32) -> AlbedoTerms {
    let cos_o = cos_o.clamp(0.0, 1.0);
    if roughness < SMOOTH {
        return AlbedoTerms { total: 1.0, schlick: fresnel::schlick_weight(cos_o), exact: 0.0 };
    }
    schlick_terms_in(&Cell::of_view(cos_o, roughness), cos_o, roughness)
}

/// The same for a view of a lobe whose cell is known.
pub(super) fn schlick_terms_in(cell: &Cell, cos_o: f32, roughness: f32) -> AlbedoTerms {
    let [total, rest] = interpolated(cell);
    let schlick = rest + mirror_share(roughness) * total * fresnel::schlick_weight(cos_o);
    AlbedoTerms { total, schlick: schlick.clamp(0.0, total), exact: 0.0 }
}

/// The albedo with F = 1.
pub(super) fn total(cos_o: f32, roughness: f32) -> f32 {
    if roughness < SMOOTH { 1.0 } else { total_in(&Cell::of_view(cos_o.clamp(0.0, 1.0), roughness)) }
}

/// The albedo with F = 1 in a cell.
pub(super) fn total_in(cell: &Cell) -> f32 {
    let [total, _] = interpolated(cell);
    total
}

/// The table's values in a cell.
fn interpolated(cell: &Cell) -> [f32; 2] {
    let [total, rest] = cell.interpolate(STORED.as_chunks::<4>().0, decoded).map(|value| value * UNIT);
    // Rounding must not create light.
    [if total < 1.0 { total } else { 1.0 }, rest]
}

/// The table's values at a grid point, in multiples of [`UNIT`].
pub(super) fn at_point(point: usize) -> [f32; 2] {
    let (points, _) = STORED.as_chunks::<4>();
    decoded(&points[point])
}

/// Share of a mirror's reflectance that the tables leave out, so that they hold small differences for smooth lobes, although the
/// reflectance is steep.
#[inline(always)]
pub(super) fn mirror_share(roughness: f32) -> f32 {
    let share = 1.0 - roughness / ROUGH;
    if share > 0.0 { share * share } else { 0.0 }
}

/// The bytes of every `step`th grid point, by integration.
pub(super) fn integrated(step: usize) -> Vec<u8> {
    let entries = grid_points(step, |row, column| {
        let roughness = roughness_of(row);
        let cos_o = view_of(column, roughness);
        let facets = Microfacets::isotropic(cos_o, roughness * roughness);
        let [total, schlick] = facets.reflected(|cosine| [1.0, fresnel::schlick_weight(cosine)]);
        let difference = schlick - mirror_share(roughness) * total * fresnel::schlick_weight(cos_o);
        [stored(total), stored(difference)]
    });
    entries.into_iter().flatten().flatten().collect()
}
