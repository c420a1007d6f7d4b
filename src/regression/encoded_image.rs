//! Images packed for a report page, as half floats that a script unpacks and shows at any exposure.
//!
//! Three planes of 16-bit integers hold green, red − green and blue − green with wrapping. Each value is stored as the difference
//! from its left neighbour, the first of a row as the difference from the one above. High bytes of all planes precede low bytes, in
//! one zlib stream. Smooth images take a quarter of the bytes of their halves, and browsers unpack them without a library.

use std::io::{Read as _, Write as _};

use flate2::{Compression, read::ZlibDecoder, write::ZlibEncoder};
use half::f16;

use super::{ColorEncoding, FlipMap, Image};

/// The colours of an image, packed for a report page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncodedImage {
    /// Columns and rows.
    pub(super) size: (u32, u32),
    /// What the colours mean.
    pub(super) encoding: ColorEncoding,
    /// The packed halves; `None` when the image was too large to keep.
    pub(super) colors: Option<Vec<u8>>,
    /// FLIP of every pixel in 255 steps, packed likewise.
    pub(super) errors: Option<Vec<u8>>,
    /// Bytes on the page before the pixels were dropped.
    dropped_bytes: usize,
}

impl EncodedImage {
    /// Packs the colours of an image over black; `None` for an image without colours. Finite values beyond the range of halves
    /// become the largest half.
    pub fn new(image: &Image) -> Option<Self> {
        let colors = pack_colors(&image.colors()?, image.size().0 as usize);
        Some(Self {
            size: image.size(),
            encoding: image.encoding,
            colors: Some(colors),
            errors: None,
            dropped_bytes: 0,
        })
    }

    /// Adds the FLIP map from which the page makes the heat map.
    #[must_use]
    pub fn with_errors(self, map: &FlipMap) -> Self {
        Self { errors: (map.size == self.size).then(|| pack_errors(map)), ..self }
    }

    /// Drops the pixels and keeps their size. The page then says that the image is omitted.
    #[must_use]
    pub fn without_pixels(self) -> Self {
        Self { colors: None, errors: None, dropped_bytes: self.needed_bytes(), ..self }
    }

    /// The colours row by row, as packed. `None` where the pixels were dropped.
    pub(super) fn unpacked_colors(&self) -> Option<Vec<[f32; 3]>> {
        let halves = unpack_colors(self.colors.as_deref()?, self.size)?;
        Some(halves.into_iter().map(|color| color.map(|bits| f16::from_bits(bits).to_f32())).collect())
    }

    /// FLIP of every pixel in 255 steps. `None` where there is no map.
    pub(super) fn unpacked_errors(&self) -> Option<Vec<u8>> {
        let (width, count) = (self.size.0 as usize, pixel_count(self.size));
        let mut steps = inflated(self.errors.as_deref()?)?;
        for at in 0..steps.len() {
            steps[at] = steps[at].wrapping_add(before(&steps, at, width).unwrap_or_default());
        }
        (steps.len() == count).then_some(steps)
    }

    /// Bytes on the page, including those of dropped pixels.
    pub(super) fn needed_bytes(&self) -> usize {
        self.dropped_bytes + self.size_bytes()
    }

    /// Bytes on the page.
    pub fn size_bytes(&self) -> usize {
        [&self.colors, &self.errors].into_iter().flatten().map(|bytes| base64_bytes(bytes.len())).sum()
    }
}

/// Length of `bytes` bytes as base64.
pub(super) fn base64_bytes(bytes: usize) -> usize {
    bytes.div_ceil(3) * 4
}

/// Packs FLIP of every pixel.
pub(super) fn pack_errors(map: &FlipMap) -> Vec<u8> {
    let steps: Vec<u8> = map.errors.iter().map(|error| (error * 255.0 + 0.5) as u8).collect();
    let width = map.size.0 as usize;
    let delta = |at: usize| steps[at].wrapping_sub(before(&steps, at, width).unwrap_or_default());
    deflated(&(0..steps.len()).map(delta).collect::<Vec<_>>())
}

fn pack_colors(colors: &[[f32; 3]], width: usize) -> Vec<u8> {
    let halves: Vec<[u16; 3]> = colors.iter().map(|color| color.map(half_bits)).collect();
    let planes: [Vec<u16>; 3] = [
        halves.iter().map(|[_, g, _]| *g).collect(),
        halves.iter().map(|[r, g, _]| r.wrapping_sub(*g)).collect(),
        halves.iter().map(|[_, g, b]| b.wrapping_sub(*g)).collect(),
    ];
    let mut bytes = Vec::with_capacity(colors.len() * 6);
    let mut low = Vec::with_capacity(colors.len() * 3);
    for plane in &planes {
        for (at, value) in plane.iter().enumerate() {
            let delta = value.wrapping_sub(before(plane, at, width).unwrap_or_default());
            let [high_byte, low_byte] = delta.to_be_bytes();
            bytes.push(high_byte);
            low.push(low_byte);
        }
    }
    bytes.append(&mut low);
    deflated(&bytes)
}

/// Reverses [`pack_colors`]: the bits of halves, row by row.
pub(super) fn unpack_colors(packed: &[u8], size: (u32, u32)) -> Option<Vec<[u16; 3]>> {
    let (width, count) = (size.0 as usize, pixel_count(size));
    let bytes = inflated(packed).filter(|bytes| bytes.len() == count * 6)?;
    let (high, low) = bytes.split_at(count * 3);
    let mut planes = [0, 1, 2].map(|_| vec![0_u16; count]);
    for (index, plane) in planes.iter_mut().enumerate() {
        for at in 0..count {
            let delta = u16::from_be_bytes([high[index * count + at], low[index * count + at]]);
            plane[at] = delta.wrapping_add(before(plane, at, width).unwrap_or_default());
        }
    }
    let [green, red, blue] = &planes;
    let pixel = |at: usize| [red[at].wrapping_add(green[at]), green[at], blue[at].wrapping_add(green[at])];
    Some((0..count).map(pixel).collect())
}

fn pixel_count((width, height): (u32, u32)) -> usize {
    width as usize * height as usize
}

/// The neighbour from which a value is predicted.
fn before<T: Copy>(plane: &[T], at: usize, width: usize) -> Option<T> {
    let distance = if at.is_multiple_of(width) { width } else { 1 };
    at.checked_sub(distance).map(|before| plane[before])
}

/// The nearest half. Only infinite values become infinite.
fn half_bits(value: f32) -> u16 {
    let value = if value.is_infinite() { value } else { value.clamp(-65504.0, 65504.0) };
    f16::from_f32(value).to_bits()
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(6));
    // Writing to memory cannot fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

fn inflated(packed: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    ZlibDecoder::new(packed).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_round_trip_as_halves() {
        let values =
            [0.0, -1.5, 1e-7, 0.18, 1.0, 2047.0, 1e30, f32::INFINITY, f32::NEG_INFINITY, 3e-3, 7.0, 0.5];
        let pixel = |at: usize| [values[at % 12], values[(at * 5 + 1) % 12], values[(at * 7 + 3) % 12], 1.0];
        let pixels: Vec<_> = (0..5 * 7).map(pixel).collect();
        let image = Image::from_rgba((5, 7), ColorEncoding::Linear, &pixels);
        let packed = EncodedImage::new(&image).unwrap();
        let back = unpack_colors(packed.colors.as_ref().unwrap(), (5, 7)).unwrap();
        let halves = |[r, g, b, _]: [f32; 4]| {
            [r, g, b].map(|value| f16::from_f32(if value == 1e30 { 65504.0 } else { value }).to_bits())
        };
        assert_eq!(back, pixels.into_iter().map(halves).collect::<Vec<_>>());
        let nan = Image::from_rgba((1, 1), ColorEncoding::Linear, &[[f32::NAN, 1.0, 1.0, 1.0]]);
        let back = unpack_colors(&EncodedImage::new(&nan).unwrap().colors.unwrap(), (1, 1)).unwrap();
        assert!(f16::from_bits(back[0][0]).is_nan());
    }

    #[test]
    fn eight_bits_of_a_display_survive_halves() {
        let pixels: Vec<_> = (0..=255).map(|step: u8| [f32::from(step) / 255.0; 4]).collect();
        let opaque = pixels.iter().map(|[v, ..]| [*v, *v, *v, 1.0]).collect::<Vec<_>>();
        let image = Image::from_rgba((16, 16), ColorEncoding::Srgb, &opaque);
        let back = unpack_colors(&EncodedImage::new(&image).unwrap().colors.unwrap(), (16, 16)).unwrap();
        for (step, [r, ..]) in back.into_iter().enumerate() {
            assert_eq!((f16::from_bits(r).to_f32() * 255.0 + 0.5) as usize, step);
        }
    }

    #[test]
    fn smooth_images_take_a_quarter_and_errors_round_trip() {
        let pixel = |at: u32| {
            let (x, y) = ((at % 320) as f32, (at / 320) as f32);
            [0.2 + x * 1e-3, 0.3 + y * 2e-3, 0.1 + (x + y) * 5e-4, 1.0]
        };
        let pixels: Vec<_> = (0..320 * 180).map(pixel).collect();
        let image = Image::from_rgba((320, 180), ColorEncoding::Linear, &pixels);
        let map = FlipMap {
            size: (320, 180),
            errors: (0..320 * 180).map(|at| at as f32 / 57599.0).collect(),
            exposures: None,
        };
        let packed = EncodedImage::new(&image).unwrap();
        assert!(packed.size_bytes() < 320 * 180 * 6 / 4, "{}", packed.size_bytes());
        let with_errors = packed.clone().with_errors(&map);
        assert!(with_errors.size_bytes() > packed.size_bytes());
        let errors = with_errors.unpacked_errors().unwrap();
        assert_eq!((errors[0], errors[320 * 90], errors[320 * 180 - 1]), (0, 128, 255));
        assert_eq!(packed.without_pixels().size_bytes(), 0);
    }

    #[test]
    fn images_without_colours_are_none_and_empty_ones_empty() {
        let mut image = Image::from_rgba((1, 1), ColorEncoding::Linear, &[[0.0; 4]]);
        image.channels.retain(|channel| channel.name == "A");
        assert_eq!(EncodedImage::new(&image), None);
        let empty = Image::from_rgba((0, 0), ColorEncoding::Linear, &[]);
        assert_eq!(EncodedImage::new(&empty).unwrap().unpacked_colors(), Some(Vec::new()));
    }
}
