//! Directional albedos of anisotropic GGX lobes.
//!
//! A view sees an anisotropic lobe about as it sees the isotropic one whose roughness is that along the view's azimuth. The table holds
//! the difference between both, which is small and smooth, over the roughness along Y, that along X, that along the azimuth, the view's
//! elevation and the index of refraction; cubics interpolate it. At least 99 % of lobes and views are within 1e-3 of the integrals, all
//! within 0.02 (`bsdf::tests::quadrature`).
//!
//! What a lobe transmits from within a medium has the edge of total reflection, which no small table resolves: it is integrated for
//! each view, as is what it reflects at indices beyond the table.

use std::array::from_fn;

use fearless_simd::Level;
use glam::{Vec2, Vec3};

use super::albedo_grid;
use super::albedo_slice::AlbedoSlice;
use super::cubic_table::nearest_four;
use super::ggx::MIN_ALPHA;
use super::ggx_anisotropic::{AnisotropicGgx, ReflectedDirection, disk_spiral};
use super::index_planes::{self, FIRST_IOR, LAST_IOR, ior_after, steps_to};
use super::isotropic_albedo::{self, AlbedoTerms};
use super::microfacets::Microfacets;
use super::stored_values::{UNIT, decoded, stored};
use super::{fresnel, internal_albedo};
use crate::geometry::vectorized;

/// The differences of the albedos with F = 1, with Schlick's weight and with the exact F of each index, point by point;
/// [`super::albedo_tables`] says how they are made.
pub(super) const STORED: &[u8] = include_bytes!("anisotropic_albedo.bin");
/// Grid points along the roughness along Y, that along X, that along the view's azimuth, and the view's column.
const SIZES: [usize; 4] = [9, 7, 9, 13];
const PLANES: usize = 14;
/// Steps of [`index_planes`] from one plane to the next.
const SPACING: f32 = (index_planes::PLANES - 1) as f32 / (PLANES - 1) as f32;
const VALUES: usize = 2 + PLANES;
/// Normals that integrate an entry.
const NORMALS: usize = 4096;
/// Bytes of a grid point.
pub(super) const BYTES: usize = 2 * VALUES;

/// The albedos of a lobe for a view from above the surface.
pub(super) fn terms(ggx: AnisotropicGgx, wo: Vec3, slice: &AlbedoSlice) -> AlbedoTerms {
    let position = Position::new(ggx, wo);
    let ior = slice.relative_ior();
    if !(1.0..=LAST_IOR).contains(&ior) {
        let AlbedoTerms { total, schlick, .. } = schlick_terms_at(&position);
        let facets = Microfacets::anisotropic(wo, ggx.alpha);
        let exact = if ior < 1.0 {
            total - internal_albedo::by_quadrature(&facets, ior)
        } else {
            let [exact] = facets.reflected(|cosine| [fresnel::exact(cosine, ior)]);
            exact
        };
        // A difference may leave its range.
        return AlbedoTerms { total, schlick, exact: if exact > 0.0 { exact.min(total) } else { 0.0 } };
    }
    let terms = slice.terms(position.cos_o, position.roughness);
    if ior == 1.0 {
        return position.complete(terms, 0.0);
    }
    let (plane, weights) = nearest_four(steps_to(ior) / SPACING, PLANES);
    let [_, _, planes @ ..] = &position.differences;
    let exact: f32 = weights.iter().zip(&planes[plane..]).map(|(weight, value)| weight * value).sum();
    // Towards an index of 1 both lobes reflect nothing.
    let vanishing = if ior < FIRST_IOR { (ior - 1.0) / (FIRST_IOR - 1.0) } else { 1.0 };
    position.complete(terms, exact * vanishing)
}

/// The albedos with F = 1 and with Schlick's weight; `exact` stays 0.
pub(super) fn schlick_terms(ggx: AnisotropicGgx, wo: Vec3) -> AlbedoTerms {
    schlick_terms_at(&Position::new(ggx, wo))
}

fn schlick_terms_at(position: &Position) -> AlbedoTerms {
    position.complete(isotropic_albedo::schlick_terms(position.cos_o, position.roughness), 0.0)
}

/// A view of a lobe with the differences from the isotropic lobe that it resembles.
struct Position {
    cos_o: f32,
    /// Roughness along the view's azimuth.
    roughness: f32,
    differences: [f32; VALUES],
}

impl Position {
    fn new(ggx: AnisotropicGgx, wo: Vec3) -> Self {
        let cos_o = wo.z.clamp(0.0, 1.0);
        let (least, most) = (ggx.alpha.y.sqrt(), ggx.alpha.x.sqrt());
        let scaled = ggx.alpha * wo.truncate();
        let ratio = scaled.length_squared() / wo.truncate().length_squared();
        // Along the normal any azimuth will do.
        let roughness = if ratio > 0.0 { ratio.sqrt().sqrt() } else { least };
        let roughness = if roughness > least { roughness } else { least };
        let roughness = if roughness < most { roughness } else { most };
        let least_of_all = MIN_ALPHA.sqrt();
        let coordinates = [
            share(least_of_all, least, 1.0),
            share(least, most, 1.0),
            share(least, roughness, most),
            albedo_grid::column(cos_o, roughness),
        ];
        let axes = from_fn(|axis| {
            let size = SIZES[axis];
            nearest_four(coordinates[axis].clamp(0.0, 1.0) * (size - 1) as f32, size)
        });
        Self { cos_o, roughness, differences: vectorized!(Level::new(), interpolated(&axes)) }
    }

    /// The terms of the isotropic lobe with the differences added; `exact` is that of the exact curve.
    fn complete(&self, terms: AlbedoTerms, exact: f32) -> AlbedoTerms {
        let total = terms.total + self.differences[0];
        // A limit that is not a number would stop the program.
        let total = if total > 0.0 { total.min(1.0) } else { 0.0 };
        // Interpolation must not create light.
        AlbedoTerms {
            total,
            schlick: (terms.schlick + self.differences[1]).clamp(0.0, total),
            exact: (terms.exact + exact).clamp(0.0, total),
        }
    }
}

/// Where `value` is between `from` and `to`, 0 to 1; 0 where they are one.
fn share(from: f32, value: f32, to: f32) -> f32 {
    if to > from { (value - from) / (to - from) } else { 0.0 }
}

/// The differences at a position on each axis: its first grid point of four, and their weights.
#[inline(always)]
fn interpolated(axes: &[(usize, [f32; 4]); 4]) -> [f32; VALUES] {
    let (points, _) = STORED.as_chunks::<BYTES>();
    let [rows, widths, azimuths, columns] = axes;
    let mut sums = [0.0; VALUES];
    for (row, row_weight) in rows.1.into_iter().enumerate() {
        for (width, width_weight) in widths.1.into_iter().enumerate() {
            for (azimuth, azimuth_weight) in azimuths.1.into_iter().enumerate() {
                let weight = row_weight * width_weight * azimuth_weight * UNIT;
                let line = (rows.0 + row) * SIZES[1] + widths.0 + width;
                let first = (line * SIZES[2] + azimuths.0 + azimuth) * SIZES[3] + columns.0;
                for (point, column_weight) in points[first..first + 4].iter().zip(columns.1) {
                    let weight = weight * column_weight;
                    let values: [f32; VALUES] = decoded(point);
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += weight * value;
                    }
                }
            }
        }
    }
    sums
}

/// The bytes of every `step`th grid point, by sums over visible normals, which bear any view: all values of one point after another.
pub(super) fn integrated(step: usize) -> Vec<u8> {
    let iors: [f32; PLANES] = from_fn(|plane| ior_after(plane as f32 * SPACING));
    let normals: &'static [(Vec2, f32)] = disk_spiral(NORMALS).leak();
    let sums = |ggx: AnisotropicGgx, wo: Vec3| {
        let mut sums = [0.0_f64; VALUES];
        for ReflectedDirection { facet_cosine, weight, .. } in ggx.reflected(wo, normals) {
            let factors = [1.0, fresnel::schlick_weight(facet_cosine)];
            let exact = iors.iter().map(|ior| fresnel::exact(facet_cosine, *ior));
            for (sum, factor) in sums.iter_mut().zip(factors.into_iter().chain(exact)) {
                *sum += f64::from(weight * factor);
            }
        }
        sums
    };
    let points = (0..SIZES.iter().product()).step_by(step).map(|point| {
        let (ggx, isotropic, wo) = lobes_of(point);
        let both = sums(ggx, wo).into_iter().zip(sums(isotropic, wo));
        both.flat_map(|(value, isotropic)| stored((value - isotropic) as f32)).collect::<Vec<u8>>()
    });
    points.collect::<Vec<_>>().concat()
}

/// The lobe of a grid point, the isotropic lobe that it resembles, and the view.
fn lobes_of(point: usize) -> (AnisotropicGgx, AnisotropicGgx, Vec3) {
    let mut rest = point;
    let mut coordinates = [0.0; 4];
    for (coordinate, size) in coordinates.iter_mut().zip(SIZES).rev() {
        *coordinate = (rest % size) as f32 / (size - 1) as f32;
        rest /= size;
    }
    let [row, width, azimuth, column] = coordinates;
    let mix = |from: f32, to: f32, share: f32| from + (to - from) * share;
    let least = mix(MIN_ALPHA.sqrt(), 1.0, row);
    let most = mix(least, 1.0, width);
    let roughness = mix(least, most, azimuth);
    let cos_o = albedo_grid::cosine_of(column, |cosine| albedo_grid::column(cosine, roughness));
    // α² along the azimuth is the mean of both by its squared cosine and sine.
    let [squared_y, squared_x, squared] = [least, most, roughness].map(|roughness| roughness.powi(4));
    let cosine_squared = share(squared_y, squared, squared_x).clamp(0.0, 1.0);
    let sine = (1.0 - cos_o * cos_o).sqrt();
    let wo = Vec3::new(sine * cosine_squared.sqrt(), sine * (1.0 - cosine_squared).sqrt(), cos_o);
    let of_alpha = |alpha| AnisotropicGgx { alpha };
    (of_alpha(Vec2::new(most * most, least * least)), of_alpha(Vec2::splat(roughness * roughness)), wo)
}
