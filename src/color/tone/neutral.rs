//! Khronos PBR Neutral, for accurate product colours.
//!
//! Source: Khronos, "PBR Neutral Tone Mapper" (2024). It subtracts the reflection of a common dielectric, 0.04. Light up to
//! 0.8, that of base colours up to 0.76, is otherwise unchanged; brighter light is compressed towards white.

use glam::Vec3;

use super::channels::{largest, smallest};

/// Normal reflectance that is subtracted.
const REFLECTANCE: f32 = 0.04;
/// Value of the largest channel above which colours are compressed.
const COMPRESSED_FROM: f32 = 0.8 - REFLECTANCE;
/// Rate at which compressed colours desaturate.
const DESATURATION: f32 = 0.15;

/// Applies the curve to light without negative channels.
pub(super) fn apply(light: Vec3) -> Vec3 {
    let least = smallest(light);
    let offset =
        if least < 2.0 * REFLECTANCE { least - least * least / (4.0 * REFLECTANCE) } else { REFLECTANCE };
    let color = light - offset;
    let peak = largest(color);
    if peak < COMPRESSED_FROM {
        return color;
    }
    if peak == f32::INFINITY {
        return Vec3::ONE;
    }
    let headroom = 1.0 - COMPRESSED_FROM;
    let shown_peak = 1.0 - headroom * headroom / (peak + headroom - COMPRESSED_FROM);
    let share = 1.0 - 1.0 / (DESATURATION * (peak - shown_peak) + 1.0);
    let color = color * (shown_peak / peak);
    color + (Vec3::splat(shown_peak) - color) * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_colours_are_unchanged() {
        // Lit by white light, a dielectric of base colour c reflects c + 0.04.
        for base in [Vec3::new(0.6, 0.3, 0.1), Vec3::new(0.05, 0.7, 0.4), Vec3::new(0.759, 0.1, 0.2)] {
            assert!((apply(base + REFLECTANCE) - base).abs().max_element() < 1e-6);
        }
        // 1 − 0.24² / (0.8 + 0.24 − 0.76) = 0.79429.
        assert!((apply(Vec3::splat(0.84)) - Vec3::splat(0.794_29)).abs().max_element() < 1e-5);
    }

    #[test]
    fn bright_light_is_compressed() {
        // White: 0.96 after the reflection; 1 − 0.24² / (0.96 + 0.24 − 0.76) = 0.86909.
        assert!((apply(Vec3::ONE) - Vec3::splat(0.869_09)).abs().max_element() < 1e-4);
        let red = apply(Vec3::new(1e6, 0.0, 0.0));
        assert!(red.min_element() > 0.99, "{red}");
    }
}
