//! Albedo of single scattering at the rough surface of a volume: what facets reflect and transmit together.
//!
//! Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007, tabulated over roughness, view and index. Only
//! masking loses light, so the sum has no Fresnel curve in it and is smooth. Rows are even in the root of the roughness, planes in the
//! root of √F0, where the albedo bends evenly from the lowest index to the highest. Columns from the thinner side are those of
//! [`super::albedo_grid`]; from the denser side the critical angle is the middle column for every index.
//!
//! Anisotropic lobes have too many parameters for a table; they are summed over normals for each view.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::albedo_grid::cosine_of;
use super::cubic_table::nearest_four;
use super::fresnel;
use super::ggx_anisotropic::disk_spiral;
use super::rough_transmission::refracted_at;
use super::specular_lobe::SpecularLobe;
use super::stored_values::{UNIT, decoded, stored};

/// The table's values, first those from the thinner side; [`super::albedo_tables`] says how they are made.
pub(super) const STORED: &[u8] = include_bytes!("rough_volume_albedo.bin");
const ROWS: usize = 29;
const COLUMNS: usize = 65;
const PLANES: usize = 18;
/// Bytes of a grid point.
pub(super) const BYTES: usize = 2 * PLANES;
/// Root of √F0 at the first plane, an index of 1.02: surfaces of lower ones transmit as if they were smooth.
const FIRST: f32 = 0.1;
/// Step between planes; the last is at an index of 3.06 and stands for higher ones, too.
const STEP: f32 = 0.036;
/// Roughness of the first row, below [`super::ggx::MIN_ALPHA`].
const MIN_ROUGHNESS: f32 = 0.04;
/// Lowest index from the denser side whose own critical angle is used; below the last plane.
const MIN_IOR: f32 = 0.1;
/// Normals that integrate an entry.
const NORMALS: usize = 2048;

/// What facets reflect and transmit of uniform light; `relative_ior` is not 1. Lookups are within 0.5 % of the sums for indices of 1.025 to
/// 2.5 on both sides and cosines from 0.05.
pub(super) fn reflected_and_transmitted(lobe: &SpecularLobe, wo: Vec3, relative_ior: f32) -> f32 {
    if lobe.anisotropic.is_some() {
        static NORMALS_OF_A_HIT: OnceLock<Vec<(Vec2, f32)>> = OnceLock::new();
        let normals = NORMALS_OF_A_HIT.get_or_init(|| disk_spiral(256));
        return by_summation(lobe, wo, relative_ior, normals);
    }
    tabulated(wo.z, lobe.roughness, relative_ior)
}

/// The same for an isotropic lobe.
fn tabulated(cos_o: f32, roughness: f32, relative_ior: f32) -> f32 {
    let cos_o = cos_o.clamp(0.0, 1.0);
    let roughness = if roughness > MIN_ROUGHNESS { roughness } else { MIN_ROUGHNESS };
    let (row, down) = interval(row(roughness), ROWS);
    let (column, right) = interval(column(cos_o, roughness, relative_ior), COLUMNS);
    let position = (plane(relative_ior) - FIRST) / STEP;
    let (plane, weights) = nearest_four(position.clamp(0.0, (PLANES - 1) as f32), PLANES);
    let side = if relative_ior < 1.0 { ROWS * COLUMNS } else { 0 };
    let (points, _) = STORED.as_chunks::<BYTES>();
    let first = side + row * COLUMNS + column;
    let at = |point: usize| {
        let values = points[point][2 * plane..].first_chunk::<8>().map_or([0.0; 4], decoded);
        (values[0] * weights[0] + values[1] * weights[1]) + (values[2] * weights[2] + values[3] * weights[3])
    };
    let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
    let upper = mix(at(first), at(first + 1), right);
    let lower = mix(at(first + COLUMNS), at(first + COLUMNS + 1), right);
    1.0 - UNIT * mix(upper, lower, down)
}

/// The bytes of every `step`th grid point of both sides, by integration: all indices of one point after another.
pub(super) fn integrated(step: usize) -> Vec<u8> {
    let nodes = disk_spiral(NORMALS);
    let mut bytes = Vec::with_capacity(2 * ROWS * COLUMNS * BYTES / step);
    for point in (0..2 * ROWS * COLUMNS).step_by(step) {
        let (is_denser, point) = (point >= ROWS * COLUMNS, point % (ROWS * COLUMNS));
        let roughness = roughness_of(point / COLUMNS);
        for plane in 0..PLANES {
            let ior = ior_of(plane);
            let ior = if is_denser { 1.0 / ior } else { ior };
            let cos_o = view_of(point % COLUMNS, roughness, ior);
            let wo = Vec3::new((1.0 - cos_o * cos_o).sqrt(), 0.0, cos_o);
            let lobe = SpecularLobe::new(roughness, None);
            bytes.extend(stored(1.0 - by_summation(&lobe, wo, ior, &nodes)));
        }
    }
    bytes
}

/// The albedo as a sum over visible normals at points of the unit disk.
pub(super) fn by_summation(lobe: &SpecularLobe, wo: Vec3, relative_ior: f32, nodes: &[(Vec2, f32)]) -> f32 {
    let masking_o = lobe.masking(wo);
    let scattered = nodes.iter().map(|(point, share)| {
        let half = lobe.visible_normal(wo, *point);
        let facet_cosine = wo.dot(half);
        let reflectance = fresnel::exact(facet_cosine, relative_ior);
        let reflected = half * (2.0 * facet_cosine) - wo;
        // G2 / G1(θ_o) = D V cos θ_i over the density of the reflected direction
        let seen = if reflected.z > 0.0 {
            let masking_i = lobe.masking(reflected);
            masking_i / (masking_o + masking_i - masking_o * masking_i)
        } else {
            0.0
        };
        let passed = refracted_at(half, wo, relative_ior).map_or(0.0, |wi| lobe.masking(wi));
        f64::from(share * (reflectance * seen + (1.0 - reflectance) * passed))
    });
    scattered.sum::<f64>() as f32
}

/// What facets transmit of uniform light where a facet lets the share `passes(facet_cosine)` pass.
pub(super) fn transmitted(
    lobe: &SpecularLobe,
    wo: Vec3,
    relative_ior: f32,
    passes: impl Fn(f32) -> f32,
) -> f32 {
    // Few normals, since every hit is summed: transmission is smooth over the lobe.
    static NODES: OnceLock<Vec<(Vec2, f32)>> = OnceLock::new();
    let nodes = NODES.get_or_init(|| disk_spiral(32));
    let transmitted = nodes.iter().map(|(point, share)| {
        let half = lobe.visible_normal(wo, *point);
        let passed = refracted_at(half, wo, relative_ior).map_or(0.0, |wi| lobe.masking(wi));
        f64::from(share * passes(wo.dot(half)) * passed)
    });
    transmitted.sum::<f64>() as f32
}

fn row(roughness: f32) -> f32 {
    let least = MIN_ROUGHNESS.sqrt();
    (roughness.sqrt() - least) / (1.0 - least)
}

fn roughness_of(row: usize) -> f32 {
    let least = MIN_ROUGHNESS.sqrt();
    let root = least + (1.0 - least) * row as f32 / (ROWS - 1) as f32;
    root * root
}

/// Position of an index on either side between the planes.
fn plane(relative_ior: f32) -> f32 {
    ((relative_ior - 1.0) / (relative_ior + 1.0)).abs().sqrt()
}

fn ior_of(plane: usize) -> f32 {
    let root = FIRST + STEP * plane as f32;
    (1.0 + root * root) / (1.0 - root * root)
}

/// Column of a view, 0 to 1.
fn column(cos_o: f32, roughness: f32, relative_ior: f32) -> f32 {
    if relative_ior > 1.0 {
        return dense_at_start(cos_o, roughness);
    }
    let ior = if relative_ior > MIN_IOR { relative_ior } else { MIN_IOR };
    let critical = (1.0 - ior * ior).sqrt();
    if cos_o < critical {
        0.5 * dense_at_ends(cos_o / critical, roughness)
    } else {
        0.5 + 0.5 * dense_at_ends((cos_o - critical) / (1.0 - critical), roughness)
    }
}

/// Maps 0 to 1 to itself, so that even steps are dense at both ends.
fn dense_at_ends(x: f32, roughness: f32) -> f32 {
    0.5 * (dense_at_start(x, roughness) + 1.0 - dense_at_start(1.0 - x, roughness))
}

/// Maps 0 to 1 to itself, so that even steps are dense at 0, within a range of about the roughness.
fn dense_at_start(x: f32, roughness: f32) -> f32 {
    let root = x.sqrt();
    0.5 * root * (1.0 + (1.0 + roughness) / (root + roughness))
}

/// The cosine of a column.
fn view_of(own: usize, roughness: f32, relative_ior: f32) -> f32 {
    cosine_of(own as f32 / (COLUMNS - 1) as f32, |cosine| column(cosine, roughness, relative_ior))
}

/// The interval of `x` between even steps from 0 to 1, and the position in it.
fn interval(x: f32, steps: usize) -> (usize, f32) {
    let position = x.clamp(0.0, 1.0) * (steps - 1) as f32;
    let below = (position as usize).min(steps - 2);
    (below, position - below as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lookups_are_close_to_their_sums() {
        let nodes = disk_spiral(4 * NORMALS);
        for ior in [1.025, 1.1, 1.33, 1.5, 1.8, 2.5] {
            for relative_ior in [ior, 1.0 / ior] {
                for roughness in [0.05, 0.13, 0.37, 0.55, 0.75, 0.93, 1.0] {
                    for cos_o in [0.05, 0.09, 0.2, 0.35, 0.5, 0.65, 0.77, 0.9, 0.97, 1.0_f32] {
                        let wo = Vec3::new((1.0 - cos_o * cos_o).sqrt(), 0.0, cos_o);
                        let sum = by_summation(&SpecularLobe::new(roughness, None), wo, relative_ior, &nodes);
                        let found = tabulated(cos_o, roughness, relative_ior);
                        let error = (found / sum - 1.0).abs();
                        assert!(error < 5e-3, "{relative_ior} {roughness} {cos_o}: {found} for {sum}");
                    }
                }
            }
        }
    }

    #[test]
    fn extreme_views_and_indices_are_in_the_table() {
        for ior in [1e-3, 0.3, 0.99999, 1.00001, 3.0, 1e6] {
            for (cos_o, roughness) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (1e-30, 0.3)] {
                let found = tabulated(cos_o, roughness, ior);
                assert!(found > 0.01 && found < 1.001, "{ior} {cos_o} {roughness}: {found}");
            }
        }
    }
}
