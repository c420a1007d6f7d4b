//! Directional albedo of the isotropic GGX lobe for views from the denser side of a surface.
//!
//! Source: the integrals of [`super::microfacets`], tabulated: the share that is transmitted, which is 0 beyond the critical angle of a
//! smooth surface and rises like a square root below it. Roughness blurs that edge over a width in proportion to α. Columns are
//! dense around the critical angle and around views along the surface; the critical angle is the middle column for every index, so
//! that values of a column differ smoothly between indices and can be interpolated as in [`super::isotropic_albedo`].

use std::sync::OnceLock;

use super::albedo_grid::{
    AlbedoTable, MAX_INDEX, MIN_INDEX, MIN_ROUGHNESS, arsinh, index_nodes, roughness_of, row,
};
use super::cubic_table::grid_values;
use super::fresnel;
use super::microfacets::Microfacets;

/// Rows of roughness and columns of the view's elevation; an odd number has a middle column.
const ROUGHNESS_STEPS: usize = 32;
const VIEW_STEPS: usize = 81;
/// Number of indices of refraction in the table.
const INDICES: usize = 9;
/// The values of the table; [`super::albedo_tables`] says how they are made.
pub(super) const STORED: &[u8] = include_bytes!("internal_albedo.bin");
/// Scale of the columns around the critical angle as a share of α.
const EDGE_WIDTH: f32 = 0.25;
/// Scale of the columns around views along the surface as a share of α.
const GRAZING_WIDTH: f32 = 0.5;

/// Whether the table holds an index of refraction.
pub(super) fn covers(relative_ior: f32) -> bool {
    (MIN_INDEX..=MAX_INDEX).contains(&index_of(relative_ior))
}

/// Share of uniform light that the surface transmits, for an index that the table covers. `total` is the lobe's albedo with F = 1.
pub(super) fn transmitted(cos_o: f32, roughness: f32, total: f32, relative_ior: f32) -> f32 {
    let tabulated = if roughness > MIN_ROUGHNESS { roughness } else { MIN_ROUGHNESS };
    let table = table();
    let values = table.values.at(row(tabulated), column(cos_o, tabulated * tabulated, relative_ior));
    let weights = table.nodes.weights(index_of(relative_ior));
    let rough: f32 = weights.iter().zip(values).map(|(weight, value)| weight * value).sum();
    if roughness >= MIN_ROUGHNESS {
        return rough;
    }
    // Smoother lobes than the table holds lie between it and a mirror, in proportion to α.
    let share = (roughness / MIN_ROUGHNESS) * (roughness / MIN_ROUGHNESS);
    let smooth = total * (1.0 - fresnel::exact(cos_o, relative_ior));
    smooth + (rough - smooth) * share
}

/// The transmitted share by integration.
pub(super) fn integrated(facets: &Microfacets, relative_ior: f32) -> f32 {
    let index = f64::from(relative_ior);
    let transmitted = |cosine: f32| [1.0 - fresnel::exact(cosine, relative_ior)];
    let [transmitted] = facets.reflected_within(1.0 - index * index, transmitted);
    transmitted
}

/// ln((1 − n) / (1 + n)); NaN above 1.
fn index_of(relative_ior: f32) -> f32 {
    libm::logf((1.0 - relative_ior) / (1.0 + relative_ior))
}

/// Column of a view, 0 to 1.
fn column(cos_o: f32, alpha: f32, relative_ior: f32) -> f32 {
    let critical = libm::sqrtf(1.0 - relative_ior * relative_ior);
    let width = alpha * (EDGE_WIDTH * relative_ior + 0.02);
    if cos_o < critical {
        let begin = -arsinh(critical / width);
        let end = arsinh(critical / (GRAZING_WIDTH * alpha));
        let at = arsinh(cos_o / (GRAZING_WIDTH * alpha)) - arsinh((critical - cos_o) / width);
        0.5 * (at - begin) / (end - begin)
    } else {
        0.5 + 0.5 * arsinh((cos_o - critical) / width) / arsinh((1.0 - critical) / width)
    }
}

/// The inverse of [`column`], by bisection.
fn cosine_of(own: f32, alpha: f32, relative_ior: f32) -> f32 {
    let (mut low, mut high) = (0.0_f32, 1.0_f32);
    for _ in 0..40 {
        let middle = f32::midpoint(low, high);
        if column(middle, alpha, relative_ior) < own { low = middle } else { high = middle }
    }
    f32::midpoint(low, high)
}

fn table() -> &'static AlbedoTable<INDICES, INDICES> {
    static TABLE: OnceLock<AlbedoTable<INDICES, INDICES>> = OnceLock::new();
    TABLE.get_or_init(|| AlbedoTable::stored(STORED, ROUGHNESS_STEPS))
}

/// The table's values, by integration.
pub(super) fn integrated_grid() -> Vec<[f32; INDICES]> {
    let iors = index_nodes::<INDICES>().positions.map(|index| {
        let root = libm::expf(index);
        (1.0 - root) / (1.0 + root)
    });
    grid_values(ROUGHNESS_STEPS, VIEW_STEPS, |x, y| {
        let roughness = roughness_of(x);
        let alpha = roughness * roughness;
        iors.map(|ior| integrated(&Microfacets::isotropic(cosine_of(y, alpha, ior), alpha), ior))
    })
}

#[cfg(test)]
mod tests {
    use super::super::isotropic_albedo;
    use super::*;

    #[test]
    fn the_table_is_within_two_thousandths_of_the_integrals() {
        let (mut worst, mut squares, mut count) = (0.0_f32, 0.0_f64, 0);
        for step in 0..24 {
            let share = (step as f32 + 0.37) / 24.0;
            let roughness = 0.002 + 0.998 * share * share;
            for ior in [1.07_f32, 1.2, 1.33, 1.45, 1.5, 1.7, 2.0, 2.4, 3.1].map(|ior| 1.0 / ior) {
                for view in 0..60 {
                    let cosine = (view as f32 + 0.5) / 60.0;
                    let total = isotropic_albedo::total(cosine, roughness);
                    let facets = Microfacets::isotropic(cosine, roughness * roughness);
                    let difference =
                        (transmitted(cosine, roughness, total, ior) - integrated(&facets, ior)).abs();
                    // The edge of lobes that are nearly mirrors is narrower than what is compared.
                    if roughness < MIN_ROUGHNESS && difference < 0.02 {
                        continue;
                    }
                    worst = worst.max(difference);
                    squares += f64::from(difference * difference);
                    count += 1;
                }
            }
        }
        let mean = (squares / f64::from(count)).sqrt();
        assert!(worst < 2e-3 && mean < 2e-4, "largest {worst}, root mean square {mean}");
    }

    #[test]
    fn columns_have_inverses() {
        for (alpha, ior) in [(1e-4, 0.9), (0.04, 0.66), (1.0, 0.4)] {
            for step in 0..=20 {
                let own = step as f32 / 20.0;
                let found = column(cosine_of(own, alpha, ior), alpha, ior);
                assert!((found - own).abs() < 2e-3, "{alpha} {ior}: {own} {found}");
            }
        }
    }
}
