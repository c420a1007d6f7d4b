//! Pictures of the surroundings from those of a cube, with the irradiance and the rough lookups that the file brings.
//!
//! Sources: the text of `EXT_lights_image_based`; for the harmonics Ramamoorthi and Hanrahan, "An Efficient Representation for
//! Irradiance Environment Maps" (SIGGRAPH 2001), section 3. The cube is laid out as OpenGL has it, seen from inside.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

#[cfg(test)]
use super::irradiance::irradiance_picture;
use super::map::EnvironmentMap;
use super::picture::{Picture, direction_from_uv};
use super::prefilter::{Pyramid, STEPS, prefiltered_pictures};
use crate::scene::{CubeLevel, ImageLight, ImageLightPose};

/// Columns of the picture of irradiance.
const IRRADIANCE_WIDTH: usize = 64;
/// Columns of the picture that rays see, at most.
const MOST_COLUMNS: usize = 8192;

/// Columns of the equirectangular picture that is as sharp as a cube of `size` texels an edge; it has half as many rows.
pub fn columns_for_cube(size: u32) -> usize {
    (size as usize).saturating_mul(4).clamp(IRRADIANCE_WIDTH, MOST_COLUMNS)
}

impl EnvironmentMap {
    /// The surroundings that `light` describes, as strong and turned as `pose` says.
    pub fn of_image_light(light: &ImageLight, pose: ImageLightPose) -> Self {
        let ImageLightPose { intensity, rotation } = pose;
        let turned = |direction: Vec3| rotation.inverse() * direction;
        let levels = &light.levels;
        let picture = pictured(columns_for_cube(levels[0].size), |direction| {
            radiance(&levels[0], turned(direction)) * intensity
        });
        let irradiance =
            pictured(IRRADIANCE_WIDTH, |normal| irradiance(&light.irradiance, turned(normal)) * intensity);
        if levels.len() == 1 {
            // Nothing for rough surfaces: make it from the picture.
            let pyramid = Pyramid::new(&picture);
            return Self::from_pictures(picture, irradiance, prefiltered_pictures(&pyramid));
        }
        let prefiltered = (1..=STEPS)
            .map(|step| {
                let roughness = step as f32 / STEPS as f32;
                let width = [256, 128, 64][(step - 1).min(2)];
                pictured(width, |direction| rough(levels, turned(direction), roughness) * intensity)
            })
            .collect();
        Self::from_pictures(picture, irradiance, prefiltered)
    }

    /// [`EnvironmentMap::of_image_light`] without the file's irradiance, for comparison.
    #[cfg(test)]
    fn integrated(light: &ImageLight) -> Picture {
        let picture = pictured(256, |direction| radiance(&light.levels[0], direction));
        irradiance_picture(&picture)
    }
}

/// A picture `width` texels wide of what is in each texel's direction.
fn pictured(width: usize, value: impl Fn(Vec3) -> Vec3 + Sync) -> Picture {
    let mut picture = Picture { width, height: width / 2, pixels: Vec::new() };
    picture.pixels = (0..width * width / 2)
        .into_par_iter()
        .map(|index| value(direction_from_uv(picture.texel_uv(index % width, index / width))).to_array())
        .collect();
    picture
}

/// Between the levels that evenly cover roughness 0 to 1.
fn rough(levels: &[CubeLevel], direction: Vec3, roughness: f32) -> Vec3 {
    let place = roughness * (levels.len() - 1) as f32;
    let sharper = (place as usize).min(levels.len() - 1);
    let share = place - sharper as f32;
    let sharp = radiance(&levels[sharper], direction);
    match levels.get(sharper + 1) {
        Some(rougher) if share > 0.0 => sharp * (1.0 - share) + radiance(rougher, direction) * share,
        _ => sharp,
    }
}

/// Radiance along `direction`, between the texels of the face that it meets.
fn radiance(level: &CubeLevel, direction: Vec3) -> Vec3 {
    let (face, right, down) = place_on_cube(direction);
    let size = level.size as usize;
    let position = |share: f32| (share * size as f32 - 0.5).clamp(0.0, (size - 1) as f32);
    let (x, y) = (position(right), position(down));
    let (column, row) = (x as usize, y as usize);
    let (right_share, bottom_share) = (x - column as f32, y - row as f32);
    let texel = |column: usize, row: usize| {
        Vec3::from_array(level.faces[face][row.min(size - 1) * size + column.min(size - 1)])
    };
    let across = |row: usize| texel(column, row) * (1.0 - right_share) + texel(column + 1, row) * right_share;
    across(row) * (1.0 - bottom_share) + across(row + 1) * bottom_share
}

/// The face that a direction meets and where on it, from its left top corner in the unit square.
fn place_on_cube(direction: Vec3) -> (usize, f32, f32) {
    let Vec3 { x, y, z } = direction;
    let size = direction.abs();
    let (face, right, down, depth) = if size.x >= size.y && size.x >= size.z {
        if x > 0.0 { (0, z, -y, x) } else { (1, -z, -y, -x) }
    } else if size.y >= size.z {
        if y > 0.0 { (2, -x, z, y) } else { (3, -x, -z, -y) }
    } else if z > 0.0 {
        (4, -x, -y, z)
    } else {
        (5, x, -y, -z)
    };
    (face, (right / depth + 1.0) * 0.5, (down / depth + 1.0) * 0.5)
}

/// Σ c Y(n); what falls below zero between the harmonics is no light.
fn irradiance(coefficients: &[Vec3; 9], normal: Vec3) -> Vec3 {
    let basis = harmonics(normal);
    let sum = coefficients.iter().zip(basis).fold(Vec3::ZERO, |sum, (c, value)| sum + *c * value);
    sum.map(|channel| if channel > 0.0 { channel } else { 0.0 })
}

/// The real spherical harmonics up to the second band.
fn harmonics(n: Vec3) -> [f32; 9] {
    let band0 = 0.5 / PI.sqrt();
    let band1 = (3.0 / (4.0 * PI)).sqrt();
    let band2 = (15.0 / (4.0 * PI)).sqrt();
    [
        band0,
        band1 * n.y,
        band1 * n.z,
        band1 * n.x,
        band2 * n.x * n.y,
        band2 * n.y * n.z,
        (5.0 / (16.0 * PI)).sqrt() * (3.0 * n.z * n.z - 1.0),
        band2 * n.x * n.z,
        0.5 * band2 * (n.x * n.x - n.y * n.y),
    ]
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::scene::Environment;

    /// Faces of 16 texels of what is seen in each texel's direction from inside.
    fn cube(radiance: impl Fn(Vec3) -> Vec3) -> CubeLevel {
        let size = 16_u32;
        let face = |face: usize| {
            let texel = |index: u32| {
                let a = ((index % size) as f32 + 0.5) / size as f32 * 2.0 - 1.0;
                let b = ((index / size) as f32 + 0.5) / size as f32 * 2.0 - 1.0;
                // To the right and down on a wall that one faces: forward × up is right.
                let (forward, up) = [
                    (Vec3::X, Vec3::Y),
                    (Vec3::NEG_X, Vec3::Y),
                    (Vec3::Y, Vec3::NEG_Z),
                    (Vec3::NEG_Y, Vec3::Z),
                    (Vec3::Z, Vec3::Y),
                    (Vec3::NEG_Z, Vec3::Y),
                ][face];
                radiance((forward + forward.cross(up) * a - up * b).normalize()).to_array()
            };
            (0..size * size).map(texel).collect()
        };
        CubeLevel { size, faces: [0, 1, 2, 3, 4, 5].map(face) }
    }

    fn light(levels: Vec<CubeLevel>) -> ImageLight {
        let irradiance = [Vec3::ZERO; 9];
        ImageLight { name: None, intensity: 1.0, rotation: Quat::IDENTITY, irradiance, levels }
    }

    #[test]
    fn a_cube_is_seen_as_from_inside() {
        let level = cube(|d| d + Vec3::ONE);
        for index in 0..300 {
            let uv = glam::Vec2::new((index as f32 * 0.618_034).fract(), (index as f32 + 0.5) / 300.0);
            let direction = direction_from_uv(uv);
            // Between centres of texels 1/8 apart, and less sharp beside the edges.
            let difference = radiance(&level, direction) - (direction + Vec3::ONE);
            assert!(difference.abs().max_element() < 0.07, "{direction}: {difference}");
        }
    }

    #[test]
    fn the_harmonics_of_linear_light_give_its_irradiance() {
        // L = 1 + 0.5 x has E = π + 0.5 · 2π/3 · x (Ramamoorthi and Hanrahan, equation 8).
        let mut image = light(vec![cube(|d| Vec3::splat(1.0 + 0.5 * d.x))]);
        let coefficient = |value: f32, basis: f32| Vec3::splat(value / basis);
        image.irradiance[0] = coefficient(PI, harmonics(Vec3::X)[0]);
        image.irradiance[3] = coefficient(PI / 3.0, harmonics(Vec3::X)[3]);
        let integrated = EnvironmentMap::integrated(&image);
        let environment = Environment::Map(EnvironmentMap::of_image_light(&image, image.pose()));
        for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::new(0.6, 0.0, 0.8)] {
            let found = environment.irradiance(normal).x;
            assert!((found - (PI + PI / 3.0 * normal.x)).abs() < 0.02, "{normal}: {found}");
            let quadrature = integrated.bilinear(super::super::picture::uv_from_direction(normal)).x;
            assert!((found - quadrature).abs() < 0.03, "{normal}: {found} {quadrature}");
        }
    }

    #[test]
    fn rotation_intensity_and_levels_are_applied() {
        let sharp = cube(|d| if d.x > 0.5 { Vec3::ONE } else { Vec3::ZERO });
        let rough = cube(|_| Vec3::splat(0.25));
        let mut image = light(vec![sharp, rough]);
        image.intensity = 2.0;
        // A quarter turn about +Y takes +X to −Z.
        image.rotation = Quat::from_xyzw(0.0, (0.5_f32).sqrt(), 0.0, (0.5_f32).sqrt());
        let environment = Environment::Map(EnvironmentMap::of_image_light(&image, image.pose()));
        assert!((environment.radiance(Vec3::NEG_Z).x - 2.0).abs() < 1e-5);
        assert_eq!(environment.radiance(Vec3::X).x, 0.0);
        assert!((environment.prefiltered(Vec3::X, 1.0).x - 0.5).abs() < 1e-5);
        assert!((environment.prefiltered(Vec3::NEG_Z, 0.5).x - 1.25).abs() < 1e-5);
    }
}
