//! Encoding of a film to the files of a frame.

use glam::Vec3;
use rayon::prelude::*;

use crate::color::{ToneCurve, exposure_scale, linear_to_srgb8, srgb8_to_linear};
use crate::error::Result;
use crate::film::{Film, PixelWindow};
use crate::image::{Channel, ColorEncoding, Image, Plate, RenderedScene, half_from_f32};
use crate::image_file::{DisplayImage, ExrCompression, FrameAttributes, encode_exr, encode_png};

use super::channels::aov_channels;
use super::cryptomatte::Matte;
use super::{Aov, ExrOutput, InstanceIds, LightSamples, sum_channels};

/// Tone mapping from scene-linear light to display values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreviewLook {
    /// Exposure in stops.
    pub exposure_ev: f32,
    /// Curve from scene to display.
    pub tone: ToneCurve,
    /// sRGB colour behind the scene, which becomes opaque. Neither exposure nor curve changes it.
    pub background: Option<[u8; 3]>,
}

/// The EXR files of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrFiles {
    /// The main file, with all AOVs unless they are split.
    pub main: Vec<u8>,
    /// The files of [`ExrOutput::split_aovs`].
    pub aovs: Vec<Vec<u8>>,
}

/// Encodes the EXR files of a frame.
///
/// # Errors
/// [`crate::error::Error::Internal`] when the film did not record an AOV.
pub fn exr_files(
    film: &Film,
    attributes: &FrameAttributes,
    output: &ExrOutput,
    ids: &InstanceIds,
) -> Result<ExrFiles> {
    let file = |aovs: &[Aov]| aovs_file(film, attributes.clone(), output, aovs, ids);
    let split = || output.split_aovs().par_iter().map(|&aov| file(&[aov])).collect();
    let (main, aovs): (_, Result<_>) = rayon::join(|| file(output.main_aovs()), split);
    Ok(ExrFiles { main: main?, aovs: aovs? })
}

/// All channels of a frame's EXR files as one image.
///
/// # Errors
/// [`crate::error::Error::Internal`] when the film has not recorded an AOV.
pub fn exr_image(film: &Film, output: &ExrOutput, instances: &InstanceIds) -> Result<Image> {
    aovs_image(film, output, output.aovs.as_slice(), instances)
}

pub(super) fn aovs_image(
    film: &Film,
    output: &ExrOutput,
    aovs: &[Aov],
    instances: &InstanceIds,
) -> Result<Image> {
    let mut channels = film.sums.as_deref().map(sum_channels).unwrap_or_default();
    for &aov in aovs {
        channels.extend(aov_channels(aov, film, output.samples, instances)?);
    }
    Ok(image(film, channels))
}

fn aovs_file(
    film: &Film,
    attributes: FrameAttributes,
    output: &ExrOutput,
    aovs: &[Aov],
    instances: &InstanceIds,
) -> Result<Vec<u8>> {
    let image = aovs_image(film, output, aovs, instances)?;
    encode_exr(image, output.compression_of(aovs), &attributes_of_file(attributes, aovs, instances))
}

/// The attributes of a file of `aovs`: those of the frame, and those of its Cryptomattes.
pub(super) fn attributes_of_file(
    mut attributes: FrameAttributes,
    aovs: &[Aov],
    instances: &InstanceIds,
) -> FrameAttributes {
    let mattes = aovs.iter().filter_map(|&aov| instances.matte(aov));
    attributes.texts.extend(mattes.flat_map(Matte::attributes));
    attributes
}

fn image(film: &Film, channels: Vec<Channel>) -> Image {
    Image {
        display_window: PixelWindow::full(film.resolution.0, film.resolution.1),
        data_window: film.window,
        encoding: ColorEncoding::Linear,
        channels,
        scene: RenderedScene::default(),
    }
}

/// Encodes the EXR file of a frame's colour alone, as halves with ZIP compression.
///
/// # Errors
/// [`crate::error::Error::Internal`] when the film contradicts its window.
pub fn exr_file(film: &Film, attributes: &FrameAttributes) -> Result<Vec<u8>> {
    let channels = aov_channels(Aov::Beauty, film, LightSamples::Half, &InstanceIds::default())?;
    encode_exr(image(film, channels), ExrCompression::Zip, attributes)
}

/// Encodes a film as a tone-mapped PNG file with its render hash: a frame, or the preview of an EXR file.
pub fn png_file(film: &Film, look: PreviewLook, render_hash: &str) -> Result<Vec<u8>> {
    let image = display_image(film.window.size(), &film.pixels, film.plate.as_deref(), look);
    encode_png(image.size, &image.pixels, render_hash)
}

/// Tone-maps linear pixels over a plate. A plate for displays keeps its values; the light of any other is mapped with the pixels.
pub fn display_image(
    size: (u32, u32),
    pixels: &[[f32; 4]],
    plate: Option<&Plate>,
    look: PreviewLook,
) -> DisplayImage {
    let pixels = match plate {
        Some(plate) if plate.is_display_referred => pixels_over_display_plate(pixels, plate, look),
        Some(plate) => display_pixels(&plate.under(pixels), look),
        None => display_pixels(pixels, look),
    };
    DisplayImage { size, pixels }
}

/// Tone-maps to sRGB with straight alpha. Values are rounded to halves first, so that a preview made while rendering equals
/// one made from the stored EXR file.
fn display_pixels(pixels: &[[f32; 4]], look: PreviewLook) -> Vec<[u8; 4]> {
    let gain = exposure_scale(look.exposure_ev);
    let background = look.background.map(|color| Vec3::from_array(color.map(srgb8_to_linear)));
    pixels
        .par_iter()
        .map(|pixel| {
            let ToneMapped { color, cover, alpha } = tone_mapped(pixel, look.tone, gain);
            match background {
                Some(background) => display_pixel(color * cover + background * (1.0 - alpha), 1.0),
                None => display_pixel(color, alpha),
            }
        })
        .collect()
}

/// A pixel of the scene in linear display light.
struct ToneMapped {
    /// Straight colour.
    color: Vec3,
    /// Factor of the colour over a background: alpha, or 1 for light without coverage.
    cover: f32,
    alpha: f32,
}

fn tone_mapped(pixel: &[f32; 4], tone: ToneCurve, gain: f32) -> ToneMapped {
    let [r, g, b, alpha] = pixel.map(|value| half_from_f32(value).to_f32());
    // Light without coverage, such as a glow over the background, is not divided.
    let cover = if alpha > 0.0 { alpha } else { 1.0 };
    ToneMapped { color: tone.apply(Vec3::new(r, g, b) * (1.0 / cover * gain)), cover, alpha }
}

/// Tone-maps a scene and puts it over a plate for displays, with straight alpha.
fn pixels_over_display_plate(pixels: &[[f32; 4]], plate: &Plate, look: PreviewLook) -> Vec<[u8; 4]> {
    let gain = exposure_scale(look.exposure_ev);
    let mapped = pixels.par_iter().zip(&plate.pixels).map(|(pixel, &[r, g, b, plate_alpha])| {
        let ToneMapped { color, cover, alpha } = tone_mapped(pixel, look.tone, gain);
        let covered = alpha + plate_alpha * (1.0 - alpha);
        if plate_alpha == 0.0 || covered <= 0.0 {
            return display_pixel(color, alpha);
        }
        display_pixel((color * cover + Vec3::new(r, g, b) * (1.0 - alpha)) / covered, covered)
    });
    mapped.collect()
}

fn display_pixel(color: Vec3, alpha: f32) -> [u8; 4] {
    let [r, g, b] = color.to_array().map(linear_to_srgb8);
    [r, g, b, (alpha * 255.0 + 0.5) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::AovFlags;
    use crate::frame::PosedCamera;
    use crate::output::{AovSet, frame_attributes};
    use crate::scene::Scene;

    const LOOK: PreviewLook = PreviewLook { exposure_ev: 0.0, tone: ToneCurve::Standard, background: None };

    #[test]
    fn alpha_is_kept_and_colour_is_straight() {
        let full = display_pixels(&[[0.5, 0.25, 0.125, 1.0]], LOOK)[0];
        let half = display_pixels(&[[0.25, 0.125, 0.0625, 0.5]], LOOK)[0];
        assert_eq!(full[..3], half[..3]);
        assert_eq!((full[3], half[3]), (255, 128));
    }

    #[test]
    fn display_backgrounds_are_exact_under_every_curve_and_exposure() {
        let curves =
            [ToneCurve::Standard, ToneCurve::Agx, ToneCurve::Aces, ToneCurve::Neutral, ToneCurve::Linear];
        for (tone, exposure_ev) in curves.into_iter().zip([-7.5, 0.0, 1.0, 16.0, -1.0]) {
            for code in 0..=255 {
                let look = PreviewLook { exposure_ev, tone, background: Some([code, 255, 255 - code]) };
                assert_eq!(display_pixels(&[[0.0; 4]], look), [[code, 255, 255 - code, 255]]);
            }
        }
    }

    #[test]
    fn surfaces_are_tone_mapped_before_they_cover_the_background() {
        let look = PreviewLook { background: Some([255; 3]), ..LOOK };
        let surface = [0.18, 0.09, 0.04, 1.0];
        assert_eq!(display_pixels(&[surface], look), display_pixels(&[surface], LOOK));
        // Mid-grey keeps its value 0.18 under the curve. Half of it and half of white: 0.59, sRGB 202.
        assert_eq!(display_pixels(&[[0.09, 0.09, 0.09, 0.5]], look), [[202, 202, 202, 255]]);
        // A shadow is black of some alpha: 0.75 of white, sRGB 225.
        assert_eq!(display_pixels(&[[0.0, 0.0, 0.0, 0.25]], look), [[225, 225, 225, 255]]);
        // Light without coverage adds to the background.
        let black = PreviewLook { background: Some([0; 3]), ..LOOK };
        assert_eq!(display_pixels(&[[0.18, 0.18, 0.18, 0.0]], black)[0][..3], [118, 118, 118]);
    }

    /// A film with all AOVs.
    fn film() -> Film {
        let all = AovFlags { light: true, centers: true, coverage: true, noise: true, guides: true };
        let mut film = Film::with_aovs((5, 4), PixelWindow { x0: 1, y0: 2, x1: 4, y1: 4 }, all);
        film.pixels = (0..6).map(|i| [i as f32, 0.5, -0.0, 1.0]).collect();
        film
    }

    fn attributes() -> FrameAttributes {
        let camera = PosedCamera::default();
        frame_attributes(1, 0.0, (24, 1), "00ff", (&camera, (5, 4)))
    }

    #[test]
    fn the_default_is_colour_alone() {
        let files =
            exr_files(&film(), &attributes(), &ExrOutput::default(), &InstanceIds::default()).unwrap();
        assert!(files.main == exr_file(&film(), &attributes()).unwrap());
        assert!(files.aovs.is_empty());
    }

    #[test]
    fn split_aovs_hold_what_one_file_would() {
        let scene = Scene::default();
        let aovs = AovSet::new(&Aov::ALL);
        let ids = InstanceIds::new(&scene, &[], &aovs);
        let together = ExrOutput { aovs, ..ExrOutput::default() };
        let split = ExrOutput { is_split: true, ..together.clone() };
        let together = exr_files(&film(), &attributes(), &together, &ids).unwrap();
        assert!(together.aovs.is_empty());
        let split = exr_files(&film(), &attributes(), &split, &ids).unwrap();
        assert_eq!(split.aovs.len(), Aov::ALL.len() - 1);
        assert!(split.main == exr_file(&film(), &attributes()).unwrap());
        // Cryptomatte attributes are in the files of their channels.
        let names = |file: &[u8]| file.windows(12).filter(|window| window == b"cryptomatte/").count();
        assert_eq!(names(&together.main), 8);
        assert_eq!(split.aovs.iter().map(|file| names(file)).collect::<Vec<_>>()[16..18], [4, 4]);
        assert_eq!(names(&split.main), 0);
    }

    #[test]
    fn one_stop_is_a_factor_of_two() {
        let brighter = PreviewLook { exposure_ev: 1.0, ..LOOK };
        let dark = [0.1, 0.2, 0.3, 1.0].map(|v| half_from_f32(v).to_f32());
        let light = [dark[0] * 2.0, dark[1] * 2.0, dark[2] * 2.0, 1.0];
        assert_eq!(display_pixels(&[dark], brighter), display_pixels(&[light], LOOK));
    }

    #[test]
    fn stored_pixels_give_the_same_preview() {
        // Any value and its rounding to a half give the same byte, because the rounding comes first.
        for i in 0..1000 {
            let value = i as f32 * 0.001_7;
            let stored = half_from_f32(value).to_f32();
            let pixels = [[value, value, value, 1.0], [stored, stored, stored, 1.0]];
            let shown = display_pixels(&pixels, LOOK);
            assert_eq!(shown[0], shown[1]);
        }
    }
}
