//! The table of [`super::albedo_slice`] for views from the denser side of a boundary.
//!
//! The transmitted share is 0 beyond the critical angle of a smooth surface and rises like a square root below it. Roughness blurs that
//! edge over a width in proportion to α. Columns are dense around the critical angle and around views along the surface; the critical
//! angle is the middle column for every index, so that values of a column differ smoothly between indices.

use super::albedo_grid::{COLUMNS, Cell, cosine_of, grid_points, roughness_of};
use super::fresnel;
use super::index_planes::{IndexPosition, PLANES, ior_of};
use super::isotropic_albedo::mirror_share;
use super::microfacets::Microfacets;
use super::stored_values::stored;

/// The transmitted share without that of the smooth surface; [`super::albedo_tables`] says how it is made.
pub(super) const STORED: &[u8] = include_bytes!("internal_albedo.bin");
/// Part of the columns that is even in the root of the distance from the edge.
const EVEN: f32 = 0.6;
/// Part of the columns beyond the edge that is even in the root of the cosine, for views along the surface.
const GRAZING: f32 = 0.15;
/// Scale of the edge by roughness, and its change with the index.
const EDGE: (f32, f32) = (0.15, 0.85);
/// Lowest index, whose columns are used for lower ones, too: their critical angles are too close to the normal for floats.
const MIN_INDEX: f32 = 0.01;

/// The transmitted share without that of the smooth surface.
pub(super) fn transmitted(cos_o: f32, roughness: f32, relative_ior: f32, position: &IndexPosition) -> f32 {
    position.interpolate(STORED, &Cell::at(roughness, column(cos_o, roughness, relative_ior)))
}

/// Column of a view, 0 to 1.
fn column(cos_o: f32, roughness: f32, relative_ior: f32) -> f32 {
    let ior = if relative_ior > MIN_INDEX { relative_ior } else { MIN_INDEX };
    let critical = (1.0 - ior * ior).sqrt();
    let width = roughness * (EDGE.0 + EDGE.1 * ior);
    if cos_o < critical {
        let grazing = (cos_o / critical).sqrt();
        let width_grazing = 0.5 * width;
        let along = grazing * (1.0 + width_grazing) / (grazing + width_grazing);
        let edge = from_edge(critical - cos_o, critical, width);
        0.5 * ((1.0 - GRAZING) * (1.0 - edge) + GRAZING * along)
    } else {
        0.5 + 0.5 * from_edge(cos_o - critical, 1.0 - critical, width)
    }
}

/// Position of a distance from the edge, from 0 to 1 at `end`.
fn from_edge(distance: f32, end: f32, width: f32) -> f32 {
    let (root, end) = (distance.sqrt(), end.sqrt());
    (root / end) * (EVEN + (1.0 - EVEN) * (end + width) / (root + width))
}

/// The bytes of every `step`th grid point, by integration: all indices of one point after another.
pub(super) fn integrated(step: usize) -> Vec<u8> {
    let points = grid_points(step, |row, column| {
        let roughness = roughness_of(row);
        std::array::from_fn::<_, PLANES, _>(|plane| {
            let ior = 1.0 / ior_of(plane);
            let cos_o = view_of(column, roughness, ior);
            let facets = Microfacets::isotropic(cos_o, roughness * roughness);
            let [total] = facets.reflected(|_| [1.0]);
            let mirrored = total * mirror_share(roughness) * (1.0 - fresnel::exact(cos_o, ior));
            stored(by_quadrature(&facets, ior) - mirrored)
        })
    });
    points.into_iter().flatten().flatten().collect()
}

/// The transmitted share by integration.
pub(super) fn by_quadrature(facets: &Microfacets, relative_ior: f32) -> f32 {
    let index = f64::from(relative_ior);
    let transmitted = |cosine: f32| [1.0 - fresnel::exact(cosine, relative_ior)];
    let [transmitted] = facets.reflected_within(1.0 - index * index, transmitted);
    transmitted
}

/// The cosine of a column.
fn view_of(own: usize, roughness: f32, relative_ior: f32) -> f32 {
    if own == COLUMNS / 2 {
        return (1.0 - relative_ior * relative_ior).sqrt();
    }
    let own = own as f32 / (COLUMNS - 1) as f32;
    cosine_of(own, |cosine| column(cosine, roughness, relative_ior))
}
