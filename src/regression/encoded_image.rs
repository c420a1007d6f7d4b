//! Images packed for a report page, as half floats that a script unpacks and shows at any exposure.
//!
//! Three planes of 16-bit integers hold green, red − green and blue − green with wrapping. Each value is stored as the difference
//! from its left neighbour, the first of a row as the difference from the one above. High bytes of all planes precede low bytes, in
//! one zlib stream. Smooth images take a quarter of the bytes of their halves, and browsers unpack them without a library.

use std::io::Write as _;

use flate2::{Compression, write::ZlibEncoder};
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

#[cfg(test)]
pub(super) mod tests {
    use std::io::Read as _;

    use super::*;

    fn inflated(packed: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(packed).read_to_end(&mut bytes).unwrap();
        bytes
    }

    /// Unpacks colours as the script does.
    pub(crate) fn unpacked(packed: &[u8], width: usize) -> Vec<[u16; 3]> {
        let bytes = inflated(packed);
        let count = bytes.len() / 6;
        let mut planes = vec![vec![0_u16; count]; 3];
        for (plane, values) in planes.iter_mut().enumerate() {
            for at in 0..count {
                let delta =
                    u16::from_be_bytes([bytes[plane * count + at], bytes[count * 3 + plane * count + at]]);
                let before = match at {
                    0 => 0,
                    _ if at % width == 0 => values[at - width],
                    _ => values[at - 1],
                };
                values[at] = delta.wrapping_add(before);
            }
        }
        let pixel = |at: usize| {
            let g = planes[0][at];
            [planes[1][at].wrapping_add(g), g, planes[2][at].wrapping_add(g)]
        };
        (0..count).map(pixel).collect()
    }

    #[test]
    fn colours_round_trip_as_halves() {
        let values =
            [0.0, -1.5, 1e-7, 0.18, 1.0, 2047.0, 1e30, f32::INFINITY, f32::NEG_INFINITY, 3e-3, 7.0, 0.5];
        let pixel = |at: usize| [values[at % 12], values[(at * 5 + 1) % 12], values[(at * 7 + 3) % 12], 1.0];
        let pixels: Vec<_> = (0..5 * 7).map(pixel).collect();
        let image = Image::from_rgba((5, 7), ColorEncoding::Linear, &pixels);
        let packed = EncodedImage::new(&image).unwrap();
        let back = unpacked(packed.colors.as_ref().unwrap(), 5);
        let halves = |[r, g, b, _]: [f32; 4]| {
            [r, g, b].map(|value| f16::from_f32(if value == 1e30 { 65504.0 } else { value }).to_bits())
        };
        assert_eq!(back, pixels.into_iter().map(halves).collect::<Vec<_>>());
        let nan = Image::from_rgba((1, 1), ColorEncoding::Linear, &[[f32::NAN, 1.0, 1.0, 1.0]]);
        let back = unpacked(&EncodedImage::new(&nan).unwrap().colors.unwrap(), 1);
        assert!(f16::from_bits(back[0][0]).is_nan());
    }

    #[test]
    fn eight_bits_of_a_display_survive_halves() {
        let pixels: Vec<_> = (0..=255).map(|step: u8| [f32::from(step) / 255.0; 4]).collect();
        let opaque = pixels.iter().map(|[v, ..]| [*v, *v, *v, 1.0]).collect::<Vec<_>>();
        let image = Image::from_rgba((16, 16), ColorEncoding::Srgb, &opaque);
        let back = unpacked(&EncodedImage::new(&image).unwrap().colors.unwrap(), 16);
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
        let deltas = inflated(&with_errors.errors.unwrap());
        let last_row: u8 = (0..180).map(|row| deltas[row * 320]).fold(0, u8::wrapping_add);
        let last = deltas[179 * 320 + 1..].iter().fold(last_row, |sum, delta| sum.wrapping_add(*delta));
        assert_eq!(last, 255);
        assert_eq!(packed.without_pixels().size_bytes(), 0);
    }

    #[test]
    fn images_without_colours_are_none_and_empty_ones_empty() {
        let mut image = Image::from_rgba((1, 1), ColorEncoding::Linear, &[[0.0; 4]]);
        image.channels.retain(|channel| channel.name == "A");
        assert_eq!(EncodedImage::new(&image), None);
        let empty = Image::from_rgba((0, 0), ColorEncoding::Linear, &[]);
        assert_eq!(unpacked(&EncodedImage::new(&empty).unwrap().colors.unwrap(), 0), [[0; 3]; 0]);
    }
}
