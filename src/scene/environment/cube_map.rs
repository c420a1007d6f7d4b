//! Environment maps from the cube maps of image-based lights, with the irradiance and the prefiltered levels of the file.
//!
//! Sources: the extension `EXT_lights_image_based`; for the spherical harmonics Ramamoorthi and Hanrahan, "An Efficient
//! Representation for Irradiance Environment Maps" (SIGGRAPH 2001), section 3. Faces are laid out as in OpenGL, seen from inside.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

#[cfg(test)]
use super::bordered_image::BorderedImage;
use super::equirect::{EquirectImage, direction_from_uv};
#[cfg(test)]
use super::irradiance::irradiance_map;
use super::map::EnvironmentMap;
use super::prefilter::{Pyramid, STEPS, prefiltered_images};
use crate::scene::{CubeLevel, ImageLight, ImageLightIndex, ImageLightPose};

/// Columns of the irradiance image.
const IRRADIANCE_WIDTH: usize = 64;
/// Limit of the columns of the radiance image.
const MAX_COLUMNS: usize = 8192;

/// Columns of the equirectangular image that matches the resolution of a cube of `size` texels an edge. It has half as many
/// rows.
pub(crate) fn columns_for_cube(size: u32) -> usize {
    (size as usize).saturating_mul(4).clamp(IRRADIANCE_WIDTH, MAX_COLUMNS)
}

/// Memory of the radiance image of a cube of `size` texels an edge with its mip levels, bytes, rounded up.
pub(crate) fn image_bytes_for_cube(size: u32) -> u64 {
    let columns = columns_for_cube(size) as u64;
    let image = columns * (columns / 2) * size_of::<[f32; 3]>() as u64;
    image + image.div_ceil(3)
}

impl EnvironmentMap {
    /// The map of the scene's image-based light `index`, with the intensity and rotation of `pose`.
    pub(super) fn of_image_light(light: &ImageLight, index: ImageLightIndex, pose: ImageLightPose) -> Self {
        let ImageLightPose { intensity, rotation } = pose;
        let rotated = |direction: Vec3| rotation.inverse() * direction;
        let levels = &light.levels;
        let image = image_of(columns_for_cube(levels[0].size), |direction| {
            radiance(&levels[0], rotated(direction)) * intensity
        });
        let irradiance =
            image_of(IRRADIANCE_WIDTH, |normal| irradiance(&light.irradiance, rotated(normal)) * intensity);
        if levels.len() == 1 {
            // The file has no rough levels: prefilter the radiance image.
            let pyramid = Pyramid::new(&image);
            return Self::from_images(index, image, &irradiance, &prefiltered_images(&pyramid));
        }
        let prefiltered: Vec<_> = (1..=STEPS)
            .map(|step| {
                let roughness = step as f32 / STEPS as f32;
                let width = [256, 128, 64][(step - 1).min(2)];
                image_of(width, |direction| prefiltered(levels, rotated(direction), roughness) * intensity)
            })
            .collect();
        Self::from_images(index, image, &irradiance, &prefiltered)
    }

    /// Irradiance integrated from the faces, the reference for the file's spherical harmonics.
    #[cfg(test)]
    fn reference_irradiance(light: &ImageLight) -> BorderedImage {
        let image = image_of(256, |direction| radiance(&light.levels[0], direction));
        irradiance_map(&image)
    }
}

/// An equirectangular image `width` texels wide of `value` in each texel's direction.
fn image_of(width: usize, value: impl Fn(Vec3) -> Vec3 + Sync) -> EquirectImage {
    let mut image = EquirectImage { width, height: width / 2, pixels: Vec::new() };
    image.pixels = (0..width * width / 2)
        .into_par_iter()
        .map(|index| value(direction_from_uv(image.texel_uv(index % width, index / width))).to_array())
        .collect();
    image
}

/// Radiance for a roughness, interpolated between levels that evenly cover roughness 0 to 1.
fn prefiltered(levels: &[CubeLevel], direction: Vec3, roughness: f32) -> Vec3 {
    let level = roughness * (levels.len() - 1) as f32;
    let sharper = (level as usize).min(levels.len() - 1);
    let share = level - sharper as f32;
    let sharp = radiance(&levels[sharper], direction);
    match levels.get(sharper + 1) {
        Some(rougher) if share > 0.0 => sharp * (1.0 - share) + radiance(rougher, direction) * share,
        _ => sharp,
    }
}

/// Radiance along `direction`, interpolated between the texels of the face that it hits.
fn radiance(level: &CubeLevel, direction: Vec3) -> Vec3 {
    let (face, right, down) = cube_face_uv(direction);
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

/// The face that a direction hits, and the coordinates on it in the unit square, origin at the top left.
fn cube_face_uv(direction: Vec3) -> (usize, f32, f32) {
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

/// Irradiance Σ c Y(n). Negative values, which truncated harmonics produce, are clamped to zero.
fn irradiance(coefficients: &[Vec3; 9], normal: Vec3) -> Vec3 {
    let basis = harmonics(normal);
    let sum = coefficients.iter().zip(basis).fold(Vec3::ZERO, |sum, (c, value)| sum + *c * value);
    sum.map(|channel| if channel > 0.0 { channel } else { 0.0 })
}

/// Real spherical harmonics up to the second band.
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

    /// A cube map of 16 texels an edge that holds `radiance` of each texel's direction.
    fn cube(radiance: impl Fn(Vec3) -> Vec3) -> CubeLevel {
        let size = 16_u32;
        let face = |face: usize| {
            let texel = |index: u32| {
                let a = ((index % size) as f32 + 0.5) / size as f32 * 2.0 - 1.0;
                let b = ((index / size) as f32 + 0.5) / size as f32 * 2.0 - 1.0;
                // Seen from inside, facing the wall: forward × up is right.
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
    fn faces_are_seen_from_inside() {
        let level = cube(|d| d + Vec3::ONE);
        for index in 0..300 {
            let uv = glam::Vec2::new((index as f32 * 0.618_034).fract(), (index as f32 + 0.5) / 300.0);
            let direction = direction_from_uv(uv);
            // Texel centres are 1/8 apart; lookups beside the edges are less accurate.
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
        let integrated = EnvironmentMap::reference_irradiance(&image);
        let environment =
            Environment::Map(EnvironmentMap::of_image_light(&image, ImageLightIndex(0), image.pose()));
        for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::new(0.6, 0.0, 0.8)] {
            let found = environment.irradiance(normal).x;
            assert!((found - (PI + PI / 3.0 * normal.x)).abs() < 0.02, "{normal}: {found}");
            let quadrature = integrated.bilinear(super::super::equirect::uv_from_direction(normal)).x;
            assert!((found - quadrature).abs() < 0.03, "{normal}: {found} {quadrature}");
        }
    }

    #[test]
    fn rotation_intensity_and_levels_are_applied() {
        let sharp = cube(|d| if d.x > 0.5 { Vec3::ONE } else { Vec3::ZERO });
        let rough = cube(|_| Vec3::splat(0.25));
        let mut image = light(vec![sharp, rough]);
        image.intensity = 2.0;
        // A rotation by 90° about +Y takes +X to −Z.
        image.rotation = Quat::from_xyzw(0.0, (0.5_f32).sqrt(), 0.0, (0.5_f32).sqrt());
        let environment =
            Environment::Map(EnvironmentMap::of_image_light(&image, ImageLightIndex(0), image.pose()));
        assert!((environment.radiance(Vec3::NEG_Z).x - 2.0).abs() < 1e-5);
        assert_eq!(environment.radiance(Vec3::X).x, 0.0);
        assert!((environment.prefiltered(Vec3::X, 1.0).x - 0.5).abs() < 1e-5);
        assert!((environment.prefiltered(Vec3::NEG_Z, 0.5).x - 1.25).abs() < 1e-5);
    }
}
