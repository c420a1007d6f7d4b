//! Directional albedo of the GGX lobe with F = 1, smoothly interpolated.
//!
//! The same quantity as the first of [`super::albedo::schlick_terms`], on a finer grid; layers above a material are made of it.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::cubic_table::CubicTable;
use super::ggx;

/// Steps of roughness and of the square root of the view's cosine.
const ROUGHNESS_STEPS: usize = 40;
const VIEW_STEPS: usize = 64;
/// Quadrature points along each axis of the disk of visible normals.
const DISK_STEPS: usize = 40;

/// Share of uniform light that the lobe reflects towards a view; exactly 1 where the surface is smooth.
pub(super) fn total(cos_o: f32, roughness: f32) -> f32 {
    static TABLE: OnceLock<CubicTable> = OnceLock::new();
    if roughness <= 0.0 {
        return 1.0;
    }
    let table = TABLE.get_or_init(|| {
        CubicTable::new(ROUGHNESS_STEPS, VIEW_STEPS, |x, y| {
            if x == 0.0 { 1.0 } else { by_visible_normals(y * y, x * x, DISK_STEPS) }
        })
    });
    table.at(roughness, libm::sqrtf(cos_o.clamp(0.0, 1.0))).clamp(0.0, 1.0)
}

/// The mean of G2 / G1 over visible normals, by midpoints of `steps` turns and as many rings a turn.
///
/// The lobe is symmetric about the plane of the view: half the disk will do. Along a turn, area 1 − s² for s from 1 at the
/// centre; below some s mirrored directions dive under the surface, and points lie denser above it, where the lobe falls.
fn by_visible_normals(cos_o: f32, alpha: f32, steps: usize) -> f32 {
    let wo = Vec3::new(libm::sqrtf(1.0 - cos_o * cos_o), 0.0, cos_o);
    let mut sum = 0.0_f64;
    for turn in 0..steps {
        let around = (turn as f32 + 0.5) / steps as f32 * 0.5 - 0.25;
        let cos_i = |s: f32| {
            let half = ggx::visible_normal(wo, alpha, ggx::disk_point(Vec2::new(1.0 - s * s, around)));
            2.0 * wo.dot(half).clamp(0.0, 1.0) * half.z - cos_o
        };
        let edge = lowest_above(cos_i);
        let (mut lobe, mut areas) = (0.0_f64, 0.0_f64);
        for ring in 0..steps {
            let t = (ring as f32 + 0.5) / steps as f32;
            let s = edge + (1.0 - edge) * t * t;
            let (cos_i, area) = (cos_i(s), f64::from(s * t));
            areas += area;
            if cos_i > 0.0 {
                lobe += f64::from(ggx::shadowing_of_visible(cos_o, cos_i, alpha)) * area;
            }
        }
        // Points above the edge stand for the area there.
        sum += lobe / areas * f64::from(1.0 - edge * edge);
    }
    (sum / steps as f64) as f32
}

/// The least number from 0 to 1 from which on `function` is positive, if it changes sign once.
fn lowest_above(function: impl Fn(f32) -> f32) -> f32 {
    let (mut below, mut above) = (0.0, 1.0);
    if function(below) > 0.0 {
        return 0.0;
    }
    for _ in 0..20 {
        let middle = f32::midpoint(below, above);
        if function(middle) > 0.0 { above = middle } else { below = middle }
    }
    above
}
