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
const DISK_STEPS: usize = 24;

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

/// The mean of G2 / G1 over visible normals.
fn by_visible_normals(cos_o: f32, alpha: f32, steps: usize) -> f32 {
    let wo = Vec3::new(libm::sqrtf(1.0 - cos_o * cos_o), 0.0, cos_o);
    let mut sum = 0.0_f64;
    for ring in 0..steps {
        // Rings lie denser towards the edge, where the lobe's long tail is: area 1 − s² for uniform s.
        let s = (ring as f32 + 0.5) / steps as f32;
        for turn in 0..steps {
            // The lobe is symmetric about the plane of the view: half the disk will do.
            let around = (turn as f32 + 0.5) / steps as f32 * 0.5 - 0.25;
            let half = ggx::visible_normal(wo, alpha, ggx::disk_point(Vec2::new(1.0 - s * s, around)));
            let cos_i = 2.0 * wo.dot(half).clamp(0.0, 1.0) * half.z - cos_o;
            if cos_i > 0.0 {
                sum += f64::from(ggx::shadowing_of_visible(cos_o, cos_i, alpha) * 2.0 * s);
            }
        }
    }
    (sum / (steps * steps) as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore]
    fn probe() {
        for roughness in [0.05, 0.11, 0.23, 0.51, 0.77, 1.0] {
            for cosine in [0.0, 0.01, 0.05, 0.2, 0.5, 0.9, 1.0] {
                let f = by_visible_normals(cosine, roughness * roughness, 400);
                let e = |n| by_visible_normals(cosine, roughness * roughness, n) - f;
                println!(
                    "{roughness} {cosine}: {f} 16 {} 24 {} 48 {} table {}",
                    e(16),
                    e(24),
                    e(48),
                    total(cosine, roughness) - f
                );
            }
        }
    }
}
