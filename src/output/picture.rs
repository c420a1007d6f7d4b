//! A frame's files as bytes.

use glam::Vec3;

use crate::color::{ToneCurve, exposure_scale, linear_to_srgb8};
use crate::error::Result;
use crate::film::{Film, PixelWindow};
use crate::image_file::{DisplayPicture, FrameAttributes, RgbaPixels, encode_exr, encode_png, half_from_f32};

/// How scene-linear colour becomes a viewable picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewLook {
    /// Stops by which the picture is brightened.
    pub exposure_ev: f32,
    /// Curve from scene to display.
    pub tone: ToneCurve,
}

/// The EXR file of a frame.
pub fn exr_file(film: &Film, attributes: &FrameAttributes) -> Result<Vec<u8>> {
    let PixelWindow { x0, y0, .. } = film.window;
    let pixels = RgbaPixels {
        picture_size: film.resolution,
        origin: (x0, y0),
        size: (film.window.width(), film.window.height()),
        pixels: &film.pixels,
    };
    encode_exr(&pixels, attributes)
}

/// A tone-mapped PNG file of linear pixels, with what they were made from: a frame of its own, or the preview beside an
/// EXR file, made from that file's pixels.
pub fn png_file(
    size: (u32, u32),
    pixels: &[[f32; 4]],
    look: PreviewLook,
    render_hash: &str,
) -> Result<Vec<u8>> {
    encode_png(size, &display_pixels(pixels, look), render_hash)
}

/// Linear pixels as a display shows them.
pub fn display_picture(size: (u32, u32), pixels: &[[f32; 4]], look: PreviewLook) -> DisplayPicture {
    DisplayPicture { size, pixels: display_pixels(pixels, look) }
}

/// sRGB with straight alpha. Values are rounded to halves first, so that a preview made while rendering and one made
/// from the stored EXR are the same.
fn display_pixels(pixels: &[[f32; 4]], look: PreviewLook) -> Vec<[u8; 4]> {
    let gain = exposure_scale(look.exposure_ev);
    pixels
        .iter()
        .map(|pixel| display_pixel(pixel.map(|value| half_from_f32(value).to_f32()), gain, look.tone))
        .collect()
}

fn display_pixel([r, g, b, alpha]: [f32; 4], gain: f32, tone: ToneCurve) -> [u8; 4] {
    // Light without coverage (a glow over nothing) is shown as it is.
    let straight = if alpha > 0.0 { 1.0 / alpha } else { 1.0 };
    let color = tone.apply(Vec3::new(r, g, b) * (straight * gain));
    let [r, g, b] = color.to_array().map(linear_to_srgb8);
    [r, g, b, (alpha * 255.0 + 0.5) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOK: PreviewLook = PreviewLook { exposure_ev: 0.0, tone: ToneCurve::Standard };

    #[test]
    fn alpha_is_kept_and_colour_is_straight() {
        let full = display_pixels(&[[0.5, 0.25, 0.125, 1.0]], LOOK)[0];
        let half = display_pixels(&[[0.25, 0.125, 0.0625, 0.5]], LOOK)[0];
        assert_eq!(full[..3], half[..3]);
        assert_eq!((full[3], half[3]), (255, 128));
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
