//! Environment map: a checked equirectangular image with its irradiance and its prefiltered copies.

mod checks;

use std::path::Path;
use std::sync::{Arc, OnceLock};

use glam::{Quat, Vec2, Vec3};

use self::checks::{check_size, check_values};
use super::KeyLight;
use super::bordered_image::BorderedImage;
use super::distribution::EnvironmentDistribution;
use super::equirect::{EquirectImage, uv_from_direction, uvs_from_directions};
use super::filtered_image::FilteredImage;
use super::irradiance::irradiance_map;
use super::light_grid::LightGrid;
use super::lookup_lanes::LookupLanes;
use super::map_rotation::MapRotation;
use super::peaks::take_peaks;
use super::prefilter::{Pyramid, STEPS, prefiltered_images};
use super::sectors::{SECTOR_ROWS, SectorTables};
use crate::color::luminance;
use crate::error::{Error, Result};
use crate::geometry::{DirectionSample, F32Lanes, LANES, Vec2Lanes, Vec3Lanes, vectorized};
use crate::scene::ImageLightIndex;
use crate::sha256::hex;

/// Rows of the distribution of samples, which has twice as many columns.
const MAX_DISTRIBUTION_ROWS: usize = 512;
/// The same for sectors.
const SECTOR_TABLE_ROWS: usize = 256;

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
    rotation: MapRotation,
}

#[derive(Debug)]
struct Tables {
    filtered: FilteredImage,
    irradiance: BorderedImage,
    /// Means under GGX lobes of roughness 1/8, 2/8, … 1.
    prefiltered: Vec<BorderedImage>,
    /// The lights that irradiance and lobes do not contain, in the space of the image.
    peaks: Vec<KeyLight>,
    /// The image without them, where there are any.
    without_peaks: Option<FilteredImage>,
    /// Of the radiance, in the space of the image.
    distribution: EnvironmentDistribution,
    /// Of the radiance, in the space of the image; made where they are used.
    sectors: OnceLock<Option<SectorTables>>,
    /// In the world, for maps that clips do not rotate; made where it is used.
    light_grid: OnceLock<Arc<LightGrid>>,
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
            irradiance: irradiance_map(pyramid.at_most(256)),
            prefiltered: prefiltered_images(&pyramid).iter().map(BorderedImage::new).collect(),
            without_peaks: without_peaks.map(FilteredImage::new),
            peaks,
            distribution: distribution(&image),
            sectors: OnceLock::new(),
            light_grid: OnceLock::new(),
            is_lit: image.pixels.iter().any(|pixel| *pixel != [0.0; 3]),
            filtered: FilteredImage::new(image),
            content_key: format!("map {} turned {:08x}", hex(&content_hash), rotation_degrees.to_bits()),
        };
        // Whole revolutions are removed in degrees, where that is exact: the same turn has the same bits.
        let turn = rotation_degrees % 360.0;
        let turn = if turn < 0.0 { turn + 360.0 } else { turn };
        let (sin, cos) = libm::sincosf(turn.to_radians());
        let rotation = MapRotation { cos, sin, animated: None };
        Ok(Self { tables: Arc::new(tables), rotation })
    }

    /// A map of the image-based light `index` from prepared images: radiance, irradiance, and means under lobes of roughness
    /// 1/8, 2/8, … 1.
    pub(super) fn from_images(
        index: ImageLightIndex,
        image: EquirectImage,
        irradiance: &EquirectImage,
        prefiltered: &[EquirectImage],
    ) -> Self {
        let is_lit = [&image, irradiance].iter().any(|p| p.pixels.iter().any(|pixel| *pixel != [0.0; 3]));
        let distribution = distribution(&image);
        let filtered = FilteredImage::new(image);
        let content_key = format!("image light {}", index.0);
        let (peaks, without_peaks) = (Vec::new(), None);
        let tables = Tables {
            filtered,
            irradiance: BorderedImage::new(irradiance),
            prefiltered: prefiltered.iter().map(BorderedImage::new).collect(),
            peaks,
            without_peaks,
            distribution,
            sectors: OnceLock::new(),
            light_grid: OnceLock::new(),
            is_lit,
            content_key,
        };
        Self { tables: Arc::new(tables), rotation: MapRotation::NONE }
    }

    /// The map with the animated rotation set to `rotation`.
    pub(super) fn rotated(&self, rotation: Quat) -> Self {
        let rotation = MapRotation { animated: Some(rotation), ..self.rotation };
        Self { rotation, ..self.clone() }
    }

    /// Pixels of the image.
    pub(super) fn pixel_count(&self) -> usize {
        self.tables.filtered.image().pixels.len()
    }

    /// Whether clips animate the rotation.
    pub(super) fn is_animated(&self) -> bool {
        self.rotation.animated.is_some()
    }

    /// How the map lies in the world.
    pub(super) fn rotation(&self) -> &MapRotation {
        &self.rotation
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
            let direction_to_light = self.rotation.world_from_map(peak.direction_to_light);
            KeyLight { direction_to_light, ..*peak }
        };
        self.tables.peaks.iter().map(turned).collect()
    }

    /// See [`super::Environment::sample`].
    pub(super) fn sample(&self, u: Vec2) -> Option<DirectionSample> {
        let sample = self.tables.distribution.sample(u)?;
        Some(DirectionSample { direction: self.rotation.world_from_map(sample.direction), ..sample })
    }

    /// See [`super::Environment::pdf`].
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        self.tables.distribution.pdf(self.rotation.map_from_world(direction))
    }

    /// See [`super::Environment::sectors`].
    pub(super) fn sectors(&self) -> Option<&SectorTables> {
        let Tables { sectors, filtered, .. } = &*self.tables;
        if sectors.get().is_none() {
            // Made outside of the lock: on a thread that makes them, rayon may run a task that needs the sectors, too.
            let (_, luminances) = luminances(filtered.image(), SECTOR_TABLE_ROWS, SECTOR_ROWS);
            sectors.get_or_init(|| SectorTables::new(&luminances));
        }
        sectors.get()?.as_ref()
    }

    /// See [`super::Environment::light_grid`].
    pub(super) fn light_grid(&self) -> Arc<LightGrid> {
        let kept = &self.tables.light_grid;
        // Made outside of the lock, as the sectors are.
        let made = || {
            Arc::new(LightGrid::new(|lookups, roughness, out| {
                self.prefiltered_lanes(lookups, roughness, out);
            }))
        };
        let grid = kept.get().cloned().unwrap_or_else(made);
        Arc::clone(kept.get_or_init(|| grid))
    }

    pub(super) fn radiance(&self, direction: Vec3) -> Vec3 {
        let uv = uv_from_direction(self.rotation.map_from_world(direction));
        self.tables.filtered.image().bilinear(uv)
    }

    pub(super) fn radiance_over(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        let differentials = differentials.map(|differential| self.rotation.map_from_world(differential));
        self.tables.filtered.radiance(self.rotation.map_from_world(direction), differentials)
    }

    /// See [`super::Environment::open_radiance_over`].
    pub(super) fn open_radiance_over(&self, direction: Vec3, differentials: [Vec3; 2]) -> Vec3 {
        let differentials = differentials.map(|differential| self.rotation.map_from_world(differential));
        self.tables.open().radiance(self.rotation.map_from_world(direction), differentials)
    }

    pub(super) fn irradiance(&self, normal: Vec3) -> Vec3 {
        let uv = uv_from_direction(self.rotation.map_from_world(normal));
        self.tables.irradiance.bilinear(uv)
    }

    pub(super) fn prefiltered(&self, direction: Vec3, roughness: f32) -> Vec3 {
        self.prefiltered_at(uv_from_direction(self.rotation.map_from_world(direction)), roughness)
    }

    #[inline(always)]
    fn prefiltered_at(&self, uv: Vec2, roughness: f32) -> Vec3 {
        let step = roughness.clamp(0.0, 1.0) * STEPS as f32;
        let below = (step as usize).min(STEPS - 1);
        let share = step - below as f32;
        let sharper = match below {
            0 => self.tables.open().image().bilinear(uv),
            _ => self.tables.prefiltered[below - 1].bilinear(uv),
        };
        sharper * (1.0 - share) + self.tables.prefiltered[below].bilinear(uv) * share
    }

    /// See [`super::Environment::irradiances`].
    pub(super) fn irradiances(&self, lookups: &LookupLanes<'_>, out: &mut Vec3Lanes) {
        let (_, uvs) = self.positions(lookups);
        vectorized!(lookups.level, {
            for lane in lookups.lanes {
                out.set(lane, self.tables.irradiance.bilinear(uvs.get(lane)));
            }
        });
    }

    /// See [`super::Environment::prefiltered_lanes`].
    pub(super) fn prefiltered_lanes(
        &self,
        lookups: &LookupLanes<'_>,
        roughness: &F32Lanes,
        out: &mut Vec3Lanes,
    ) {
        let (_, uvs) = self.positions(lookups);
        vectorized!(lookups.level, {
            for lane in lookups.lanes {
                out.set(lane, self.prefiltered_at(uvs.get(lane), roughness[lane]));
            }
        });
    }

    /// [`EnvironmentMap::radiance_over`] of several directions.
    pub(super) fn radiances_over(
        &self,
        lookups: &LookupLanes<'_>,
        differentials: &[Vec3Lanes; 2],
        out: &mut Vec3Lanes,
    ) {
        self.radiances_of(&self.tables.filtered, lookups, differentials, out);
    }

    /// [`EnvironmentMap::open_radiance_over`] of several directions.
    pub(super) fn open_radiances_over(
        &self,
        lookups: &LookupLanes<'_>,
        differentials: &[Vec3Lanes; 2],
        out: &mut Vec3Lanes,
    ) {
        self.radiances_of(self.tables.open(), lookups, differentials, out);
    }

    fn radiances_of(
        &self,
        image: &FilteredImage,
        lookups: &LookupLanes<'_>,
        differentials: &[Vec3Lanes; 2],
        out: &mut Vec3Lanes,
    ) {
        let LookupLanes { level, lanes, .. } = *lookups;
        let (directions, uvs) = self.positions(lookups);
        let mut in_map = [Vec3Lanes::default(); 2];
        vectorized!(level, {
            for (in_map, differentials) in in_map.iter_mut().zip(differentials) {
                for lane in 0..LANES {
                    in_map.set(lane, self.rotation.map_from_world(differentials.get(lane)));
                }
            }
        });
        let lookups = LookupLanes { level, directions: &directions, lanes };
        image.radiances(&lookups, &uvs, &in_map, out);
    }

    /// Directions in the map, and their image coordinates.
    #[inline(always)]
    fn positions(&self, lookups: &LookupLanes<'_>) -> (Vec3Lanes, Vec2Lanes) {
        let LookupLanes { level, directions, lanes } = *lookups;
        let (mut in_map, mut uvs) = (Vec3Lanes::default(), Vec2Lanes::default());
        vectorized!(level, {
            for lane in 0..LANES {
                in_map.set(lane, self.rotation.map_from_world(directions.get(lane)));
            }
        });
        uvs_from_directions(level, &in_map, lanes, &mut uvs);
        (in_map, uvs)
    }
}

fn distribution(image: &EquirectImage) -> EnvironmentDistribution {
    let (columns, luminances) = luminances(image, MAX_DISTRIBUTION_ROWS, 1);
    EnvironmentDistribution::new(columns, luminances)
}

/// Columns and mean luminances of cells no wider than half a texel, or of `rows` rows, a multiple of `multiple` as all numbers of rows. The means are those
/// of what rays see: lookups between texels.
fn luminances(image: &EquirectImage, rows: usize, multiple: usize) -> (u32, Vec<f32>) {
    let columns = 2 * rows;
    let cells = if image.height > rows && image.width >= columns {
        image.interpolated_means(columns, rows)
    } else {
        image.interpolated((2 * image.height).min(rows).next_multiple_of(multiple))
    };
    let luminances = cells.pixels.iter().map(|&pixel| luminance(Vec3::from_array(pixel))).collect();
    (cells.width as u32, luminances)
}

#[cfg(test)]
mod tests;
