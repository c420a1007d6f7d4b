//! The table of [`super::albedo_slice`] for views from the thinner side of a boundary.

use super::albedo_grid::{grid_points, roughness_of, view_of};
use super::fresnel;
use super::index_planes::{PLANES, ior_of};
use super::isotropic_albedo::mirror_share;
use super::microfacets::Microfacets;
use super::stored_values::stored;

/// The reflected share without that of the mirror; [`super::albedo_tables`] says how it is made.
pub(super) const STORED: &[u8] = include_bytes!("external_albedo.bin");

/// The bytes of every `step`th grid point, by integration: all indices of one point after another.
pub(super) fn integrated(step: usize) -> Vec<u8> {
    let iors: [f32; PLANES] = std::array::from_fn(ior_of);
    let points = grid_points(step, |row, column| {
        let roughness = roughness_of(row);
        let cos_o = view_of(column, roughness);
        let facets = Microfacets::isotropic(cos_o, roughness * roughness);
        let [total] = facets.reflected(|_| [1.0]);
        let exact = facets.reflected(|cosine| iors.map(|ior| fresnel::exact(cosine, ior)));
        let mirrored = total * mirror_share(roughness);
        std::array::from_fn::<_, PLANES, _>(|plane| {
            stored(exact[plane] - mirrored * fresnel::exact(cos_o, iors[plane]))
        })
    });
    points.into_iter().flatten().flatten().collect()
}
