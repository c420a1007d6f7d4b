//! Light of the environment inside a closed space, as it comes from all directions around one point there.
//!
//! It is smooth: nine spherical harmonics, of which irradiance needs no more (Ramamoorthi and Hanrahan 2001).

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

/// Functions of the bands 0 to 2.
const FUNCTIONS: usize = 9;
/// Factors of these bands in irradiance, over π: the cosine lobe.
const COSINE_BANDS: [f32; 3] = [1.0, 2.0 / 3.0, 0.25];
/// Variance of the directions of a lobe of roughness 1, square radians: about that of the cosine lobe.
const ROUGHEST_VARIANCE: f32 = 0.405;
/// Lobes are at least as rough. Sharper ones would show the ripples of a few harmonics.
const MIN_ROUGHNESS: f32 = 0.6;

/// Radiance by direction, as harmonics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnclosedLight {
    coefficients: [Vec3; FUNCTIONS],
}

impl EnclosedLight {
    /// The light of directions, the radiances from there, and the shares of all solid angles that they stand for. They are added in their order.
    pub(super) fn new(radiances: impl IntoIterator<Item = (Vec3, Vec3, f32)>) -> Self {
        let mut coefficients = [Vec3::ZERO; FUNCTIONS];
        for (direction, radiance, share) in radiances {
            for (coefficient, value) in coefficients.iter_mut().zip(harmonics(direction)) {
                *coefficient += radiance * (value * share * (4.0 * PI));
            }
        }
        Self { coefficients }
    }

    /// The mean of lights by their weights, whose sum must not be 0.
    pub(super) fn mean(lights: &[(Self, f32)]) -> Self {
        let mut mean = Self { coefficients: [Vec3::ZERO; FUNCTIONS] };
        let total: f32 = lights.iter().map(|(_, weight)| weight).sum();
        for (light, weight) in lights {
            for (coefficient, value) in mean.coefficients.iter_mut().zip(light.coefficients) {
                *coefficient += value * (weight / total);
            }
        }
        mean
    }

    /// The light times a factor.
    pub(super) fn scaled(&self, factor: f32) -> Self {
        Self { coefficients: self.coefficients.map(|coefficient| coefficient * factor) }
    }

    /// Irradiance on a surface with this normal.
    #[inline]
    pub(super) fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.sum(normal, COSINE_BANDS) * PI
    }

    /// Mean radiance in a lobe around a direction.
    #[inline]
    pub(super) fn prefiltered(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let roughness = if roughness > MIN_ROUGHNESS { roughness } else { MIN_ROUGHNESS };
        let band = libm::expf(-ROUGHEST_VARIANCE * roughness * roughness);
        self.sum(direction, [1.0, band, band * band * band])
    }

    /// Mean radiance over all directions.
    pub(super) fn mean_radiance(&self) -> Vec3 {
        self.coefficients[0] * (0.5 * FRAC_1_PI.sqrt())
    }

    /// Numbers that tell one light from any other.
    pub(super) fn bits(&self) -> impl Iterator<Item = u32> {
        self.coefficients.iter().flat_map(Vec3::to_array).map(f32::to_bits)
    }

    /// The light around a direction, by the factors of its bands. Ripples below zero become 0.
    #[inline]
    fn sum(&self, direction: Vec3, bands: [f32; 3]) -> Vec3 {
        let [band_0, band_1, band_2] = bands;
        let factors = [band_0, band_1, band_1, band_1, band_2, band_2, band_2, band_2, band_2];
        let mut sum = Vec3::ZERO;
        for ((coefficient, value), factor) in self.coefficients.iter().zip(harmonics(direction)).zip(factors)
        {
            sum += *coefficient * (value * factor);
        }
        sum.max(Vec3::ZERO)
    }
}

/// Real spherical harmonics of the bands 0 to 2 in a unit direction.
#[inline]
fn harmonics(Vec3 { x, y, z }: Vec3) -> [f32; FUNCTIONS] {
    // √(1/4π), √(3/4π), √(15/4π), √(5/16π) and √(15/16π)
    [
        0.282_094_8,
        0.488_602_5 * y,
        0.488_602_5 * z,
        0.488_602_5 * x,
        1.092_548_4 * (x * y),
        1.092_548_4 * (y * z),
        0.315_391_57 * (3.0 * z * z - 1.0),
        1.092_548_4 * (x * z),
        0.546_274_2 * (x * x - y * y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::spiral_direction;

    const DIRECTIONS: u32 = 4096;

    fn light_of(radiance: impl Fn(Vec3) -> Vec3) -> EnclosedLight {
        let directions = (0..DIRECTIONS).map(|index| spiral_direction(index, DIRECTIONS));
        let share = 1.0 / DIRECTIONS as f32;
        EnclosedLight::new(directions.map(|direction| (direction, radiance(direction), share)))
    }

    #[test]
    fn harmonics_are_orthonormal() {
        let mut products = [[0.0_f64; FUNCTIONS]; FUNCTIONS];
        for index in 0..DIRECTIONS {
            let values = harmonics(spiral_direction(index, DIRECTIONS));
            for (row, a) in products.iter_mut().zip(values) {
                for (product, b) in row.iter_mut().zip(values) {
                    *product += f64::from(a * b) * 4.0 * std::f64::consts::PI / f64::from(DIRECTIONS);
                }
            }
        }
        for (i, row) in products.iter().enumerate() {
            for (j, product) in row.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 0.004, "{i} {j}: {product}");
            }
        }
    }

    #[test]
    fn uniform_light_is_the_same_everywhere() {
        let color = Vec3::new(0.2, 0.5, 0.9);
        let light = light_of(|_| color);
        assert!((light.mean_radiance() - color).length() < 1e-4);
        for direction in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8)] {
            assert!((light.irradiance(direction) - color * PI).length() < 0.01);
            for roughness in [0.0, 0.6, 1.0] {
                assert!((light.prefiltered(direction, roughness) - color).length() < 0.003);
            }
        }
    }

    #[test]
    fn a_bright_half_lights_what_faces_it() {
        // A hemisphere of radiance 1 above: irradiance π (1 + n·y) / 2, to a hundredth by three bands.
        let light = light_of(|direction| Vec3::splat(if direction.y > 0.0 { 1.0 } else { 0.0 }));
        for normal in [Vec3::Y, Vec3::X, Vec3::NEG_Y, Vec3::new(0.0, 0.6, 0.8), Vec3::new(0.8, -0.6, 0.0)] {
            let expected = PI * 0.5 * (1.0 + normal.y);
            let found = light.irradiance(normal).x;
            assert!((found - expected).abs() < 0.03, "{normal}: {found}, expected {expected}");
        }
        // Rougher lobes see more of the other half.
        let up = [0.6, 0.8, 1.0].map(|roughness| light.prefiltered(Vec3::Y, roughness).x);
        assert!(up[0] > up[1] && up[1] > up[2] && up[2] > 0.8, "{up:?}");
        assert!(light.prefiltered(Vec3::NEG_Y, 0.6).min_element() >= 0.0);
    }

    #[test]
    fn means_are_weighted() {
        let lights = [Vec3::ZERO, Vec3::ONE].map(|color| light_of(|_| color));
        let mean = EnclosedLight::mean(&[(lights[0], 0.5), (lights[1], 1.5)]);
        assert!((mean.mean_radiance() - 0.75).length() < 1e-4);
        assert_eq!(EnclosedLight::mean(&[(lights[1], 0.25); 4]), lights[1]);
        assert!(mean.bits().ne(lights[1].bits()) && mean.bits().count() == 27);
    }
}
