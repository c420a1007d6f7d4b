//! What the header of a Radiance file tells of its values. Source: Ward, "Radiance File Formats".

use std::path::Path;

use glam::{DMat3, Vec2};
use image::codecs::hdr::HdrMetadata;
use rayon::prelude::*;

use super::exr_rgba::{converted, plausible_aspect};
use crate::color::Chromaticities;
use crate::error::Warning;

/// How the light of a Radiance file follows from its values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RadianceValues {
    /// What red, green and blue were multiplied by: the products of all lines `EXPOSURE` and `COLORCORR`.
    multipliers: [f32; 3],
    /// From the `PRIMARIES` to Rec.709, where they are others.
    to_rec709: Option<DMat3>,
    /// Width of a pixel as a share of its height: the inverse of `PIXASPECT`.
    pub(super) pixel_aspect: f64,
    /// Whether the multipliers are of no light, and do not count.
    is_malformed: bool,
}

impl RadianceValues {
    pub(super) fn of(header: &HdrMetadata) -> Self {
        let exposure = header.exposure.unwrap_or(1.0);
        let (r, g, b) = header.color_correction.unwrap_or((1.0, 1.0, 1.0));
        let multipliers = [r, g, b].map(|correction| correction * exposure);
        // Quotients of others are no light: exposures of 0, or beyond all that floats hold.
        let is_malformed = !multipliers.iter().all(|multiplier| *multiplier > 0.0 && multiplier.is_normal());
        let primaries = header.custom_attributes.iter().rfind(|(name, _)| name == "PRIMARIES");
        Self {
            multipliers: if is_malformed { [1.0; 3] } else { multipliers },
            to_rec709: primaries.and_then(|(_, value)| to_rec709(value)),
            pixel_aspect: plausible_aspect(1.0 / header.pixel_aspect_ratio.unwrap_or(1.0)),
            is_malformed,
        }
    }

    /// Makes light of Rec.709 of the values of a file.
    pub(super) fn make_light(&self, pixels: &mut [[f32; 3]]) {
        if self.multipliers != [1.0; 3] {
            pixels.par_iter_mut().for_each(|pixel| {
                pixel.iter_mut().zip(self.multipliers).for_each(|(value, multiplier)| *value /= multiplier);
            });
        }
        if let Some(matrix) = &self.to_rec709 {
            pixels.par_iter_mut().for_each(|pixel| {
                let [r, g, b] = *pixel;
                [pixel[0], pixel[1], pixel[2], _] = converted([r, g, b, 1.0], matrix);
            });
        }
    }

    /// What the header of the file at `path` tells in vain.
    pub(super) fn warnings(&self, path: &Path) -> Vec<Warning> {
        let told = self.is_malformed.then(|| {
            format!(
                "the lines EXPOSURE and COLORCORR of {} multiply light by no positive number, and do not count",
                path.display()
            )
        });
        told.into_iter().map(Warning::of_file).collect()
    }
}

/// The matrix of x and y of red, green, blue and white. `None` for Rec.709, and for what is malformed or no colours: some programs write zeros.
fn to_rec709(primaries: &str) -> Option<DMat3> {
    let numbers: Vec<f32> = primaries.split_ascii_whitespace().map_while(|word| word.parse().ok()).collect();
    let [red_x, red_y, green_x, green_y, blue_x, blue_y, white_x, white_y] = numbers[..] else { return None };
    let chromaticities = Chromaticities {
        red: Vec2::new(red_x, red_y),
        green: Vec2::new(green_x, green_y),
        blue: Vec2::new(blue_x, blue_y),
        white: Vec2::new(white_x, white_y),
    };
    if chromaticities.is_rec709() { None } else { chromaticities.to_rec709() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use crate::image_file::{read_environment, read_plate};

    /// A file of one pixel with these lines in its header. The value is (0.5, 0.25, 1).
    fn file(lines: &str) -> Vec<u8> {
        let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{lines}\n-Y 1 +X 1\n");
        [header.as_bytes(), b"\x40\x20\x80\x81"].concat()
    }

    fn light(lines: &str) -> [f32; 3] {
        read_environment(Path::new("a.hdr"), &file(lines), 1 << 20).unwrap().pixels[0]
    }

    #[test]
    fn light_is_the_value_divided_by_all_exposures_and_corrections() {
        for (lines, expected) in [
            ("", [0.5, 0.25, 1.0]),
            ("EXPOSURE=1.0\n", [0.5, 0.25, 1.0]),
            ("EXPOSURE=4\nSOFTWARE=any\nEXPOSURE= 0.5\n", [0.25, 0.125, 0.5]),
            ("COLORCORR= 1 2 0.5\n", [0.5, 0.125, 2.0]),
            ("COLORCORR=1 2 0.5\nEXPOSURE=0.25\nCOLORCORR=2 1 1\n", [1.0, 0.5, 8.0]),
        ] {
            assert_eq!(light(lines), expected, "{lines}");
        }
    }

    #[test]
    fn plates_and_compared_images_hold_the_same_light() {
        let (path, bytes) = (Path::new("a.hdr"), file("EXPOSURE=2\n"));
        assert_eq!(read_plate(path, &bytes, 1 << 20).unwrap().image.pixels, [[0.25, 0.125, 0.5, 1.0]]);
        let equal = Image::decode(path, &bytes).unwrap();
        assert_eq!(equal.rgba().unwrap(), [[0.25, 0.125, 0.5, 1.0]]);
    }

    #[test]
    fn multipliers_that_are_none_do_not_count() {
        for lines in ["EXPOSURE=0\n", "EXPOSURE=-1\n", "EXPOSURE=nan\n", "EXPOSURE=1e30\nEXPOSURE=1e30\n"] {
            let environment = read_environment(Path::new("a.hdr"), &file(lines), 1 << 20).unwrap();
            assert_eq!(environment.pixels, [[0.5, 0.25, 1.0]], "{lines}");
            let said = environment.warnings[0].to_string();
            assert!(said.contains("EXPOSURE and COLORCORR of a.hdr"), "{said}");
        }
        assert!(
            read_environment(Path::new("a.hdr"), &file("EXPOSURE=3\n"), 1 << 20).unwrap().warnings.is_empty()
        );
    }

    #[test]
    fn colours_of_other_primaries_become_rec709() {
        let aces = "PRIMARIES=0.7347 0.2653 0.0 1.0 0.0001 -0.077 0.32168 0.33767\n";
        // The published matrix gives −0.276480 · 0.5 + 1.372719 · 0.25 − 0.096239 in green, and so on.
        let expected = [0.589_755, 0.108_701, 1.122_42];
        for (value, expected) in light(aces).into_iter().zip(expected) {
            assert!((value - expected).abs() < 1e-5, "{value} is not {expected}");
        }
        let rec709 = "PRIMARIES= 0.6400 0.3300 0.3000 0.6000 0.1500 0.0600 0.3127 0.3290\n";
        for kept in [rec709, "PRIMARIES=0 0 0 0 0 0 0 0\n", "PRIMARIES=0.64 0.33\n", "PRIMARIES=red\n"] {
            assert_eq!(light(kept), [0.5, 0.25, 1.0], "{kept}");
        }
    }

    #[test]
    fn plates_have_the_aspect_ratio_of_pixels() {
        let aspect =
            |lines: &str| read_plate(Path::new("a.hdr"), &file(lines), 1 << 20).unwrap().pixel_aspect;
        // PIXASPECT is of height to width.
        assert_eq!(["", "PIXASPECT=0.5\n", "PIXASPECT=0\n"].map(aspect), [1.0, 2.0, 1.0]);
    }
}
