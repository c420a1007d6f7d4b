//! Directional albedo of the GGX lobe, by table: how much of uniform light it reflects, with and without a Fresnel factor.
//!
//! Source: the split sum of Karis, "Real Shading in Unreal Engine 4", 2013, equation 8, over the visible normals of Heitz 2018.
//! Beside Karis' two terms for Schlick's curve there is a table over the relative index for the exact curve. Tables hold the
//! differences from "lobe without Fresnel × Fresnel at the view angle": these vanish for smooth surfaces, where the
//! albedo is therefore exactly F(θ). Single scattering only, as in glTF: rough lobes lose a little light.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::fresnel::{self, Dielectric, Shape};
use super::ggx;

/// Steps of roughness from 0 to 1.
const ROUGHNESS_STEPS: usize = 32;
/// Steps of the square root of the view's cosine from 0 to 1, dense at grazing angles.
const VIEW_STEPS: usize = 48;
/// Steps of (n − 1) / (n + 1) from −1 to 1; n is the relative index.
const INDEX_STEPS: usize = 64;
/// Pieces into which Fresnel's curve is cut inside a lobe, over the square root of the facet's cosine.
const FACET_STEPS: usize = 128;
/// Quadrature points of a lobe, along each axis of the disk of visible normals.
const DISK_STEPS: usize = 16;

/// Steps of roughness over which the exact curve at the view's angle fades out of the formula: a sharp lobe follows that
/// curve with its bend at the critical angle, a rough one is smoother than it.
const SHARP_STEPS: usize = 8;

const VIEWS: usize = VIEW_STEPS + 1;
const PLANE: usize = (ROUGHNESS_STEPS + 1) * VIEWS;

struct Tables {
    /// The lobe with F = 1.
    total: Vec<f32>,
    /// The lobe with F = (1 − o·h)⁵, less `total` times that of the view.
    schlick: Vec<f32>,
    /// The lobe with the exact F, less `sharpness` times `total` times F of the view; one plane for each step of the index.
    exact: Vec<f32>,
}

/// The lobe's albedo for F = 1 and for F = (1 − o·h)⁵; together they give that of any Schlick curve.
pub(super) fn schlick_terms(cos_o: f32, roughness: f32) -> (f32, f32) {
    let tables = tables();
    let place = Place::new(cos_o, roughness);
    let total = place.interpolate(&tables.total);
    let weight = total * fresnel::schlick_weight(cos_o) + place.interpolate(&tables.schlick);
    (total, weight)
}

/// The lobe's albedo under a dielectric's curve. Roughness 0 gives exactly F(θ_o).
pub(super) fn dielectric(cos_o: f32, roughness: f32, curve: &Dielectric) -> Vec3 {
    match curve.shape {
        Shape::Exact => {
            let (total, exact) = exact_terms(cos_o, roughness, curve.relative_ior);
            curve.albedo(total, exact)
        }
        Shape::Schlick => {
            let (total, grazing) = schlick_terms(cos_o, roughness);
            curve.albedo(total, grazing)
        }
    }
}

/// The lobe's albedo for F = 1 and for Fresnel's F of a relative index.
fn exact_terms(cos_o: f32, roughness: f32, relative_ior: f32) -> (f32, f32) {
    let tables = tables();
    let place = Place::new(cos_o, roughness);
    let total = place.interpolate(&tables.total);
    let index = (relative_ior - 1.0) / (relative_ior + 1.0);
    let (below, share) = split((index + 1.0) * (INDEX_STEPS as f32 * 0.5), INDEX_STEPS);
    let plane = |step: usize| place.interpolate(&tables.exact[step * PLANE..(step + 1) * PLANE]);
    let rest = plane(below) * (1.0 - share) + plane(below + 1) * share;
    let sharp = sharpness(roughness * ROUGHNESS_STEPS as f32);
    (total, sharp * total * fresnel::exact(cos_o, relative_ior) + rest)
}

/// From 1 for smooth lobes down to 0; `place` is in steps of roughness.
fn sharpness(place: f32) -> f32 {
    (1.0 - place / SHARP_STEPS as f32).clamp(0.0, 1.0)
}

/// Where a lookup falls in a plane of roughness and view.
struct Place {
    corner: usize,
    roughness_share: f32,
    view_share: f32,
}

impl Place {
    fn new(cos_o: f32, roughness: f32) -> Self {
        let (row, roughness_share) = split(roughness * ROUGHNESS_STEPS as f32, ROUGHNESS_STEPS);
        let (column, view_share) = split(cos_o.clamp(0.0, 1.0).sqrt() * VIEW_STEPS as f32, VIEW_STEPS);
        Self { corner: row * VIEWS + column, roughness_share, view_share }
    }

    fn interpolate(&self, plane: &[f32]) -> f32 {
        let along = |at: usize| plane[at] * (1.0 - self.view_share) + plane[at + 1] * self.view_share;
        along(self.corner) * (1.0 - self.roughness_share) + along(self.corner + VIEWS) * self.roughness_share
    }
}

/// The step at or below `place` and the share of the next one.
fn split(place: f32, steps: usize) -> (usize, f32) {
    let place = place.clamp(0.0, steps as f32);
    let below = (place as usize).min(steps - 1);
    (below, place - below as f32)
}

fn tables() -> &'static Tables {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    // On one thread: waiting for a pool while holding the lock could wait for itself.
    TABLES.get_or_init(build)
}

fn build() -> Tables {
    let facet_cosines: Vec<f32> = (0..=FACET_STEPS).map(facet_cosine).collect();
    let curves: Vec<Vec<f32>> = (0..=INDEX_STEPS)
        .map(|step| {
            let root = step as f32 * (2.0 / INDEX_STEPS as f32) - 1.0;
            facet_cosines.iter().map(|cosine| exact_of_root(*cosine, root)).collect()
        })
        .collect();
    let mut tables = Tables {
        // A smooth lobe reflects everything, and nothing but at the view's own angle.
        total: vec![1.0; PLANE],
        schlick: vec![0.0; PLANE],
        exact: vec![0.0; PLANE * (INDEX_STEPS + 1)],
    };
    let points = disk_points();
    for row in 1..=ROUGHNESS_STEPS {
        let roughness = row as f32 / ROUGHNESS_STEPS as f32;
        for column in 0..VIEWS {
            let root = column as f32 / VIEW_STEPS as f32;
            let cos_o = root * root;
            let lobe = Lobe::integrate(cos_o, roughness * roughness, &points);
            let at = row * VIEWS + column;
            tables.total[at] = lobe.total;
            tables.schlick[at] = lobe.schlick - lobe.total * fresnel::schlick_weight(cos_o);
            // The same straight pieces on both sides, so that their error cancels in sharp lobes.
            let (piece, share) = facet_piece(cos_o);
            for (plane, curve) in curves.iter().enumerate() {
                let mean: f32 = curve.iter().zip(&lobe.by_facet).map(|(f, weight)| f * weight).sum();
                let view = curve[piece] * (1.0 - share) + curve[piece + 1] * share;
                tables.exact[plane * PLANE + at] = mean - sharpness(row as f32) * lobe.total * view;
            }
        }
    }
    tables
}

/// The exact curve of the relative index whose (n − 1) / (n + 1) is `root`; both ends reflect everything.
fn exact_of_root(cosine: f32, root: f32) -> f32 {
    if root.abs() >= 1.0 { 1.0 } else { fresnel::exact(cosine, (1.0 + root) / (1.0 - root)) }
}

/// The lobe's light, sorted by the angle at the facet.
struct Lobe {
    total: f32,
    schlick: f32,
    by_facet: [f32; FACET_STEPS + 1],
}

impl Lobe {
    fn integrate(cos_o: f32, alpha: f32, points: &[(Vec2, f32)]) -> Self {
        let mut lobe = Self { total: 0.0, schlick: 0.0, by_facet: [0.0; FACET_STEPS + 1] };
        let wo = Vec3::new((1.0 - cos_o * cos_o).sqrt(), 0.0, cos_o);
        for (point, share) in points {
            let half = ggx::visible_normal(wo, alpha, *point);
            let facet = wo.dot(half).clamp(0.0, 1.0);
            let cos_i = 2.0 * facet * half.z - cos_o;
            if cos_i <= 0.0 {
                continue;
            }
            let weight = ggx::shadowing_of_visible(cos_o, cos_i, alpha) * share;
            lobe.total += weight;
            lobe.schlick += weight * fresnel::schlick_weight(facet);
            let (piece, share) = facet_piece(facet);
            lobe.by_facet[piece] += weight * (1.0 - share);
            lobe.by_facet[piece + 1] += weight * share;
        }
        lobe
    }
}

/// Points of the half disk and their weights; the lobe is symmetric about the plane of the view. Rings lie denser towards
/// the edge, where the lobe's long tail is: area 1 − s² for uniform s.
fn disk_points() -> Vec<(Vec2, f32)> {
    let mut points = Vec::with_capacity(DISK_STEPS * DISK_STEPS);
    for ring in 0..DISK_STEPS {
        let s = (ring as f32 + 0.5) / DISK_STEPS as f32;
        for turn in 0..DISK_STEPS {
            // From −90° to 90°, where the first coordinate, across the plane of the view, is positive.
            let around = (turn as f32 + 0.5) / DISK_STEPS as f32 * 0.5 - 0.25;
            let weight = 2.0 * s / (DISK_STEPS * DISK_STEPS) as f32;
            points.push((ggx::disk_point(Vec2::new(1.0 - s * s, around)), weight));
        }
    }
    points
}

fn facet_cosine(step: usize) -> f32 {
    let root = step as f32 / FACET_STEPS as f32;
    root * root
}

/// The piece of the facet's cosine and how far along it, linear in the cosine.
fn facet_piece(cosine: f32) -> (usize, f32) {
    let (piece, _) = split(cosine.sqrt() * FACET_STEPS as f32, FACET_STEPS);
    let (low, high) = (facet_cosine(piece), facet_cosine(piece + 1));
    (piece, ((cosine - low) / (high - low)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::fresnel::Tint;

    /// The slow twin: ∫ D V F cos dω over half vectors, in double steps fine enough for the lobe; no sampling of visible
    /// normals. Half vectors are spread by tan² θ_h = α² ξ / (1 − ξ), whose density is D cos θ_h.
    fn by_quadrature(cos_o: f32, alpha: f32, fresnel: impl Fn(f32) -> f32) -> f32 {
        let wo = Vec3::new((1.0 - cos_o * cos_o).sqrt(), 0.0, cos_o);
        let (rings, turns) = (800, 400);
        let mut sum = 0.0_f64;
        for ring in 0..rings {
            // Denser towards the tail: ξ = 1 − s².
            let s = (ring as f32 + 0.5) / rings as f32;
            let xi = 1.0 - s * s;
            let tan_squared = alpha * alpha * xi / (s * s);
            let cos_half = 1.0 / (1.0 + tan_squared).sqrt();
            let sin_half = cos_half * tan_squared.sqrt();
            for turn in 0..turns {
                let (sin_turn, cos_turn) =
                    libm::sincosf((turn as f32 + 0.5) / turns as f32 * std::f32::consts::PI);
                let half = Vec3::new(sin_half * cos_turn, sin_half * sin_turn, cos_half);
                let facet = wo.dot(half);
                let cos_i = 2.0 * facet * half.z - cos_o;
                if facet <= 0.0 || cos_i <= 0.0 {
                    continue;
                }
                // dω_i = 4 (o·h) dω_h.
                let value =
                    ggx::visibility(cos_o, cos_i, alpha) * cos_i * 4.0 * facet / cos_half * fresnel(facet);
                sum += f64::from(value) * 2.0 * f64::from(s);
            }
        }
        (sum / f64::from(rings * turns)) as f32
    }

    #[test]
    fn smooth_lobes_are_exactly_fresnel() {
        for (outside, inside) in [(1.0, 1.5), (1.5, 1.0), (1.33, 1.5), (1.0, 1.0), (1.0, 0.0)] {
            let curve = Dielectric::between(outside, inside, Tint::NONE);
            for step in 0..=100 {
                let cosine = step as f32 / 100.0;
                let difference = dielectric(cosine, 0.0, &curve) - curve.reflectance(cosine);
                assert!(difference.abs().max_element() < 1e-6, "{curve:?} {cosine}: {difference}");
            }
        }
        assert_eq!(schlick_terms(0.25, 0.0), (1.0, 0.75_f32.powi(5)));
    }

    #[test]
    fn rough_lobes_agree_with_quadrature() {
        let mut worst = [0.0_f32; 4];
        for roughness in [0.14_f32, 0.25, 0.43, 0.68, 0.81, 1.0] {
            for cosine in [0.03_f32, 0.11, 0.27, 0.5, 0.83, 1.0] {
                let alpha = roughness * roughness;
                let (total, schlick) = schlick_terms(cosine, roughness);
                let errors = [
                    total - by_quadrature(cosine, alpha, |_| 1.0),
                    schlick - by_quadrature(cosine, alpha, fresnel::schlick_weight),
                    error_of(1.5, cosine, roughness),
                    error_of(1.0 / 1.5, cosine, roughness),
                ];
                for (largest, error) in worst.iter_mut().zip(errors) {
                    assert!(error.abs() < 0.05, "{roughness} {cosine}: {errors:?}");
                    if error.abs() > *largest {
                        *largest = error.abs();
                    }
                }
            }
        }
        // The coarse grid shows most at grazing views of sharp lobes and, from inside, beside the critical angle.
        let allowed = [4e-3, 2e-3, 2.2e-3, 0.02];
        assert!(worst.iter().zip(allowed).all(|(error, limit)| *error < limit), "{worst:?}");
    }

    fn error_of(relative_ior: f32, cosine: f32, roughness: f32) -> f32 {
        let curve = Dielectric::between(1.0, relative_ior, Tint::NONE);
        dielectric(cosine, roughness, &curve).x
            - by_quadrature(cosine, roughness * roughness, |facet| curve.reflectance(facet).x)
    }

    #[test]
    fn albedo_stays_between_nothing_and_everything() {
        for index in [0.4_f32, 0.75, 1.0, 1.01, 1.45, 2.4, 40.0] {
            let curve = Dielectric::between(1.0, index, Tint::NONE);
            for roughness in [0.0, 0.01, 0.2, 0.77, 1.0] {
                for cosine in [0.0, 0.001, 0.2, 0.7, 1.0] {
                    let albedo = dielectric(cosine, roughness, &curve).x;
                    let (total, schlick) = schlick_terms(cosine, roughness);
                    assert!((0.0..=1.0).contains(&albedo), "{index} {roughness} {cosine}: {albedo}");
                    assert!(schlick > -1e-3 && schlick <= total + 1e-6 && total < 1.0 + 1e-5);
                }
            }
        }
    }
}
