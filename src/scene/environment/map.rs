//! Environment map: a checked equirectangular image with its irradiance and its prefiltered copies.

use std::path::Path;
use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};

use super::KeyLight;
use super::equirect::{EquirectImage, uv_from_direction, uvs_from_directions};
use super::filtered_image::FilteredImage;
use super::irradiance::irradiance_image;
use super::lookup_lanes::LookupLanes;
use super::peaks::take_peaks;
use super::prefilter::{Pyramid, STEPS, prefiltered_images};
use crate::error::{Error, Result};
use crate::geometry::{F32Lanes, LANES, Vec2Lanes, Vec3Lanes, vectorized};
use crate::scene::ImageLightIndex;

/// Limit of the pixels of an environment image: 16384x8192.
const MAX_PIXELS: u64 = 1 << 27;

/// Limit of a channel's radiance: far above any light, far below the overflow of sums.
const MAX_RADIANCE: f32 = 1e30;

/// Decoded pixels of an equirectangular environment image.
#[derive(Clone, Debug)]
pub struct EnvironmentImage {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear Rec.709 radiance, row-major from the top.
    pub pixels: Vec<[f32; 3]>,
    /// SHA-256 of the file that the pixels came from, or any other hash of them.
    pub content_hash: [u8; 32],
}

/// An equirectangular environment image, prepared for lookups.
///
/// The top row is +Y. With rotation 0 the centre is −Z, where a glTF camera looks, and +X lies to the right of it. Clones share
/// their pixels.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    tables: Arc<Tables>,
    cos_rotation: f32,
    sin_rotation: f32,
    /// Rotation of an image-based light that clips animate; `None` for any other map.
    animated_rotation: Option<Quat>,
}

#[derive(Debug)]
struct Tables {
    filtered: FilteredImage,
    irradiance: EquirectImage,
    /// Means under GGX lobes of roughness 1/8, 2/8, … 1.
    prefiltered: Vec<EquirectImage>,
    /// The lights that irradiance and lobes do not contain, in the space of the image.
    peaks: Vec<KeyLight>,
    /// The image without them, where there are any.
    without_peaks: Option<FilteredImage>,
    is_lit: bool,
    /// See [`super::Environment::content_key`].
    content_key: String,
}

impl Tables {
    /// The image without its peaks.
    fn open(&self) -> &FilteredImage {
        self.without_peaks.as_ref().unwrap_or(&self.filtered)
    }
}

impl EnvironmentMap {
    /// Checks `image` and prepares its lookups on the current rayon pool. The result does not depend on the number of threads.
    ///
    /// `rotation_degrees` rotates the environment about +Y, counter-clockwise seen from above. Negative values become 0.
    /// `path` appears in messages only.
    ///
    /// # Errors
    /// [`Error::Invalid`] for an empty image, a wrong number of pixels, or a value that is not finite or above 1e30;
    /// [`Error::Refused`] for more than 2^27 pixels; [`Error::Usage`] for a rotation that is not finite.
    pub fn new(path: &Path, image: EnvironmentImage, rotation_degrees: f32) -> Result<Self> {
        let EnvironmentImage { width, height, mut pixels, content_hash } = image;
        check_size(path, (width, height), pixels.len())?;
        if !rotation_degrees.is_finite() {
            return Err(Error::usage(format!(
                "the rotation of environment {} must be a finite number of degrees",
                path.display()
            )));
        }
        check_values(path, width, &mut pixels)?;
        let image = EquirectImage { width: width as usize, height: height as usize, pixels };
        let (peaks, without_peaks) = take_peaks(&image);
        let pyramid = Pyramid::new(without_peaks.as_ref().unwrap_or(&image));
        let tables = Tables {
            irradiance: irradiance_image(pyramid.at_most(256)),
            prefiltered: prefiltered_images(&pyramid),
            without_peaks: without_peaks.map(FilteredImage::new),
            peaks,
            is_lit: image.pixels.iter().any(|pixel| *pixel != [0.0; 3]),
            filtered: FilteredImage::new(image),
            content_key: format!("map {} turned {:08x}", hex(&content_hash), rotation_degrees.to_bits()),
        };
        // Whole revolutions are removed in degrees, where that is exact: the same turn has the same bits.
        let turn = rotation_degrees % 360.0;
        let turn = if turn < 0.0 { turn + 360.0 } else { turn };
        let (sin_rotation, cos_rotation) = libm::sincosf(turn.to_radians());
        Ok(Self { tables: Arc::new(tables), cos_rotation, sin_rotation, animated_rotation: None })
    }

    /// A map of the image-based light `index` from prepared images: radiance, irradiance, and means under lobes of roughness
    /// 1/8, 2/8, … 1.
    pub(super) fn from_images(
        index: ImageLightIndex,
        image: EquirectImage,
        irradiance: EquirectImage,
        prefiltered: Vec<EquirectImage>,
    ) -> Self {
        let is_lit = [&image, &irradiance].iter().any(|p| p.pixels.iter().any(|pixel| *pixel != [0.0; 3]));
        let filtered = FilteredImage::new(image);
        let content_key = format!("image light {}", index.0);
        let (peaks, without_peaks) = (Vec::new(), None);
        let tables = Tables { filtered, irradiance, prefiltered, peaks, without_peaks, is_lit, content_key };
        Self { tables: Arc::new(tables), cos_rotation: 1.0, sin_rotation: 0.0, animated_rotation: None }
    }

    /// The map with the animated rotation set to `rotation`.
    pub(super) fn rotated(&self, rotation: Quat) -> Self {
        Self { animated_rotation: Some(rotation), ..self.clone() }
    }

    /// Whether clips animate the rotation.
    pub(super) fn is_animated(&self) -> bool {
        self.animated_rotation.is_some()
    }

    /// See [`super::Environment::content_key`].
    pub(super) fn content_key(&self) -> &str {
        &self.tables.content_key
    }

    /// Columns and rows of the image.
    pub fn size(&self) -> (u32, u32) {
        let image = self.tables.filtered.image();
        (image.width as u32, image.height as u32)
    }

    pub(super) fn is_lit(&self) -> bool {
        self.tables.is_lit
    }

    /// See [`super::Environment::peaks`].
    pub(super) fn peaks(&self) -> Vec<KeyLight> {
        let turned = |peak: &KeyLight| {
            let direction_to_light = self.world_from_map(peak.direction_to_light);
            KeyLight { direction_to_light, ..*peak }
        };
        self.tables.peaks.iter().map(turned).collect()
    }

    pub(super) fn radiance(&self, direction: Vec3) -> Vec3 {
        let uv = uv_from_direction(self.map_from_world(direction));
        self.tables.filtered.image().bilinear(uv)
    }

    pub(super) fn radiance_over(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        let differentials = differentials.map(|differential| self.map_from_world(differential));
        self.tables.filtered.radiance(self.map_from_world(direction), differentials)
    }

    /// See [`super::Environment::open_radiance_over`].
    pub(super) fn open_radiance_over(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        let differentials = differentials.map(|differential| self.map_from_world(differential));
        self.tables.open().radiance(self.map_from_world(direction), differentials)
    }

    pub(super) fn irradiance(&self, normal: Vec3) -> Vec3 {
        let uv = uv_from_direction(self.map_from_world(normal));
        self.tables.irradiance.bilinear(uv)
    }

    pub(super) fn prefiltered(&self, direction: Vec3, roughness: f32) -> Vec3 {
        self.prefiltered_at(uv_from_direction(self.map_from_world(direction)), roughness)
    }

    #[inline]
    fn prefiltered_at(&self, uv: Vec2, roughness: f32) -> Vec3 {
        let step = roughness.clamp(0.0, 1.0) * STEPS as f32;
        let below = (step as usize).min(STEPS - 1);
        let share = step - below as f32;
        let sharper = match below {
            0 => self.tables.open().image(),
            _ => &self.tables.prefiltered[below - 1],
        };
        let rougher = &self.tables.prefiltered[below];
        sharper.bilinear(uv) * (1.0 - share) + rougher.bilinear(uv) * share
    }

    /// See [`super::Environment::irradiances`].
    pub(super) fn irradiances(&self, lookups: &LookupLanes<'_>, out: &mut Vec3Lanes) {
        let (_, uvs) = self.positions(lookups);
        for lane in lookups.lanes {
            out.set(lane, self.tables.irradiance.bilinear(uvs.get(lane)));
        }
    }

    /// See [`super::Environment::prefiltered_lanes`].
    pub(super) fn prefiltered_lanes(
        &self,
        lookups: &LookupLanes<'_>,
        roughness: &F32Lanes,
        out: &mut Vec3Lanes,
    ) {
        let (_, uvs) = self.positions(lookups);
        for lane in lookups.lanes {
            out.set(lane, self.prefiltered_at(uvs.get(lane), roughness[lane]));
        }
    }

    /// See [`super::Environment::backgrounds`].
    pub(super) fn radiances_over(
        &self,
        lookups: &LookupLanes<'_>,
        differentials: &[Vec3Lanes; 2],
        out: &mut Vec3Lanes,
    ) {
        let (directions, uvs) = self.positions(lookups);
        for lane in lookups.lanes {
            let differentials = [0, 1].map(|axis| self.map_from_world(differentials[axis].get(lane)));
            let (uv, direction) = (uvs.get(lane), directions.get(lane));
            out.set(lane, self.tables.filtered.radiance_around(uv, direction, differentials));
        }
    }

    /// Directions in the map, and their image coordinates.
    #[inline(always)]
    fn positions(&self, lookups: &LookupLanes<'_>) -> (Vec3Lanes, Vec2Lanes) {
        let LookupLanes { level, directions, lanes } = *lookups;
        let (mut in_map, mut uvs) = (Vec3Lanes::default(), Vec2Lanes::default());
        vectorized!(level, {
            for lane in 0..LANES {
                in_map.set(lane, self.map_from_world(directions.get(lane)));
            }
        });
        uvs_from_directions(level, &in_map, lanes, &mut uvs);
        (in_map, uvs)
    }

    /// Rotates a direction of the map into the world.
    fn world_from_map(&self, direction: Vec3) -> Vec3 {
        let Vec3 { x, y, z } = direction;
        let turned = Vec3::new(
            self.cos_rotation * x + self.sin_rotation * z,
            y,
            self.cos_rotation * z - self.sin_rotation * x,
        );
        self.animated_rotation.map_or(turned, |rotation| rotation * turned)
    }

    /// Rotates a world direction into the map.
    #[inline(always)]
    fn map_from_world(&self, direction: Vec3) -> Vec3 {
        let direction = self.animated_rotation.map_or(direction, |rotation| rotation.inverse() * direction);
        let Vec3 { x, y, z } = direction;
        Vec3::new(
            self.cos_rotation * x - self.sin_rotation * z,
            y,
            self.sin_rotation * x + self.cos_rotation * z,
        )
    }
}

/// Lower-case hexadecimal digits.
fn hex(hash: &[u8; 32]) -> String {
    hash.iter()
        .flat_map(|byte| [byte >> 4, byte & 15])
        .filter_map(|digit| char::from_digit(u32::from(digit), 16))
        .collect()
}

fn check_size(path: &Path, (width, height): (u32, u32), pixels: usize) -> Result<()> {
    let expected = u64::from(width) * u64::from(height);
    if expected == 0 {
        return Err(Error::invalid(path, "", "the environment image is empty"));
    }
    if expected > MAX_PIXELS {
        return Err(Error::refused(
            path,
            "",
            format!(
                "the environment image has {width}x{height} pixels, more than the limit of {MAX_PIXELS}; make it smaller"
            ),
        ));
    }
    if pixels as u64 != expected {
        return Err(Error::invalid(
            path,
            "",
            format!("the environment image should have {width}x{height} pixels but has {pixels}"),
        ));
    }
    Ok(())
}

fn check_values(path: &Path, width: u32, pixels: &mut [[f32; 3]]) -> Result<()> {
    for (index, pixel) in pixels.iter_mut().enumerate() {
        if pixel.iter().any(|value| !value.is_finite() || *value > MAX_RADIANCE) {
            let (column, row) = (index % width as usize, index / width as usize);
            return Err(Error::invalid(
                path,
                "",
                format!(
                    "pixel ({column}, {row}) of the environment image is {pixel:?}; values must be finite and at most \
                     {MAX_RADIANCE:e}"
                ),
            ));
        }
        // −0 becomes 0 as well.
        *pixel = pixel.map(|value| if value > 0.0 { value } else { 0.0 });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: u32, height: u32, pixels: Vec<[f32; 3]>, rotation: f32) -> Result<EnvironmentMap> {
        let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
        EnvironmentMap::new(Path::new("sky.hdr"), image, rotation)
    }

    /// Red in the middle half (around −Z), green elsewhere.
    fn two_halves(rotation: f32) -> EnvironmentMap {
        let pixels = (0..32 * 64)
            .map(|index| if (16..48).contains(&(index % 64)) { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] })
            .collect();
        map(64, 32, pixels, rotation).unwrap()
    }

    #[test]
    fn rotation_is_counter_clockwise_from_above() {
        let straight = two_halves(0.0);
        assert_eq!(straight.radiance(Vec3::NEG_Z), Vec3::X);
        assert_eq!(straight.radiance(Vec3::Z), Vec3::Y);
        // Seen from above, 90° counter-clockwise takes −Z (up on the page) to −X (left).
        let rotated = two_halves(450.0);
        assert_eq!(rotated.radiance(Vec3::NEG_X), Vec3::X);
        assert_eq!(rotated.radiance(Vec3::X), Vec3::Y);
        assert!((rotated.irradiance(Vec3::NEG_X) - straight.irradiance(Vec3::NEG_Z)).length() < 1e-5);
        let rough = two_halves(-90.0).prefiltered(Vec3::X, 0.5);
        assert!(rough.x > 0.85 && rough.x + rough.y < 1.0001, "{rough}");
    }

    #[test]
    fn a_lit_hemisphere_gives_its_share_of_irradiance() {
        // A horizontal normal towards the lit hemisphere receives π, one away from it 0, one upwards half.
        let map = two_halves(0.0);
        let pi = std::f32::consts::PI;
        assert!((map.irradiance(Vec3::NEG_Z).x - pi).abs() < 0.02);
        assert!(map.irradiance(Vec3::Z).x < 0.02);
        assert!((map.irradiance(Vec3::Y).x - pi / 2.0).abs() < 0.08);
    }

    #[test]
    fn roughness_moves_smoothly_from_the_image_to_the_mean() {
        let map = two_halves(0.0);
        let direction = Vec3::new(0.97, 0.1, -0.2).normalize();
        assert_eq!(map.prefiltered(direction, 0.0), map.radiance(direction));
        let mut last = map.prefiltered(direction, 0.0);
        for step in 1..=1000 {
            let next = map.prefiltered(direction, step as f32 / 1000.0);
            assert!((next - last).abs().max_element() < 0.01);
            last = next;
        }
    }

    #[test]
    fn tiny_and_odd_images_work() {
        for (width, height) in [(1, 1), (3, 7), (65, 33)] {
            let pixels = vec![[0.25, 0.5, 1.0]; (width * height) as usize];
            let map = map(width, height, pixels, 12.0).unwrap();
            for direction in [Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.0, 0.8)] {
                let mean = Vec3::new(0.25, 0.5, 1.0);
                assert!((map.radiance(direction) - mean).abs().max_element() < 1e-5);
                assert!((map.prefiltered(direction, 0.3) - mean).abs().max_element() < 1e-5);
                assert!((map.irradiance(direction) / std::f32::consts::PI - mean).abs().max_element() < 1e-4);
            }
        }
    }

    #[test]
    fn bad_images_are_refused_and_negative_values_become_zero() {
        assert!(matches!(map(0, 4, vec![], 0.0), Err(Error::Invalid { .. })));
        assert!(matches!(map(2, 2, vec![[0.0; 3]; 3], 0.0), Err(Error::Invalid { .. })));
        assert!(matches!(map(1 << 20, 1 << 20, vec![], 0.0), Err(Error::Refused { .. })));
        assert!(matches!(map(1, 1, vec![[1.0; 3]], f32::NAN), Err(Error::Usage { .. })));
        for bad in [f32::NAN, f32::INFINITY, 1e35] {
            let message = map(2, 1, vec![[0.0; 3], [0.0, bad, 0.0]], 0.0).unwrap_err().to_string();
            assert!(message.contains("(1, 0)") && message.contains("sky.hdr"), "{message}");
        }
        let dark = map(2, 1, vec![[-1.0, 0.0, 0.0], [0.0; 3]], 0.0).unwrap();
        assert!(!dark.is_lit());
        assert_eq!(dark.radiance(Vec3::X), Vec3::ZERO);
        let blinding = map(2, 1, vec![[1e30; 3]; 2], 0.0).unwrap();
        assert!(blinding.irradiance(Vec3::Y).is_finite() && blinding.prefiltered(Vec3::Y, 1.0).is_finite());
    }

    #[test]
    fn lookups_do_not_depend_on_threads() {
        let pixels: Vec<[f32; 3]> =
            (0..64 * 32).map(|index| [((index * 7919) % 101) as f32, 1.0, 0.5]).collect();
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| map(64, 32, pixels.clone(), 30.0)).unwrap()
        };
        let (one, three) = (build(1), build(3));
        assert_eq!(one.tables.irradiance.pixels, three.tables.irradiance.pixels);
        for (a, b) in one.tables.prefiltered.iter().zip(&three.tables.prefiltered) {
            assert_eq!(a.pixels, b.pixels);
        }
    }
}
