//! Filters after the attribute codec: unit vectors, rotations, floats and colours.
//!
//! Source: *KHR_meshopt_compression* (Khronos Group), appendix B.

/// Filter of decoded attributes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    /// No filter.
    None,
    /// Unit vectors in octahedral encoding.
    Octahedral,
    /// Unit quaternions stored by their three smaller components.
    Quaternion,
    /// Floats stored as exponent and mantissa.
    Exponential,
    /// Colours stored as YCoCg.
    Color,
}

impl Filter {
    /// Whether the filter applies to elements of `stride` bytes.
    pub(super) fn fits(self, stride: usize) -> bool {
        match self {
            Self::None | Self::Exponential => true,
            Self::Octahedral | Self::Color => stride == 4 || stride == 8,
            Self::Quaternion => stride == 8,
        }
    }

    /// Filters elements of `stride` bytes in place.
    pub(super) fn apply(self, bytes: &mut [u8], stride: usize) {
        match (self, stride) {
            (Self::None, _) => {}
            (Self::Octahedral, 4) => each4(bytes, |value| {
                octahedral(value.map(|byte| f32::from(byte as i8)), 127.0)
                    .map_or([0, 0, 0, value[3]], |[x, y, z]| [x as u8, y as u8, z as u8, value[3]])
            }),
            (Self::Octahedral, _) => each8(bytes, |value| {
                octahedral(value.map(|short| f32::from(short as i16)), 32767.0)
                    .map_or([0, 0, 0, value[3]], |[x, y, z]| [x as u16, y as u16, z as u16, value[3]])
            }),
            (Self::Quaternion, _) => each8(bytes, quaternion),
            (Self::Exponential, _) => each4(bytes, |value| exponential(value).to_le_bytes()),
            (Self::Color, 4) => each4(bytes, |[y, co, cg, alpha]| {
                let chroma = [co as i8, cg as i8].map(i32::from);
                color(i32::from(y), chroma, u32::from(alpha), 255.0).map(|channel| channel as u8)
            }),
            (Self::Color, _) => each8(bytes, |[y, co, cg, alpha]| {
                let chroma = [co as i16, cg as i16].map(i32::from);
                color(i32::from(y), chroma, u32::from(alpha), 65535.0).map(|channel| channel as u16)
            }),
        }
    }
}

fn each4(bytes: &mut [u8], filter: impl Fn([u8; 4]) -> [u8; 4]) {
    let (elements, _) = bytes.as_chunks_mut::<4>();
    for element in elements {
        *element = filter(*element);
    }
}

fn each8(bytes: &mut [u8], filter: impl Fn([u16; 4]) -> [u16; 4]) {
    let (elements, _) = bytes.as_chunks_mut::<8>();
    for element in elements {
        let [a, b, c, d, e, f, g, h] = *element;
        let filtered = filter([[a, b], [c, d], [e, f], [g, h]].map(u16::from_le_bytes));
        let (pairs, _) = element.as_chunks_mut::<2>();
        pairs.iter_mut().zip(filtered).for_each(|(pair, value)| *pair = value.to_le_bytes());
    }
}

/// Decodes a unit vector to signed integers up to `max`. `None` if the third component, the encoding of 1, is zero.
fn octahedral([x, y, one, _]: [f32; 4], max: f32) -> Option<[i32; 3]> {
    let (mut x, mut y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    // Unfold the lower half.
    let fold = if z < 0.0 { z } else { 0.0 };
    x -= fold.copysign(x);
    y -= fold.copysign(y);
    let length = (x * x + y * y + z * z).sqrt();
    let vector = [x, y, z].map(|component| component / length);
    vector
        .iter()
        .all(|component| component.is_finite())
        .then(|| vector.map(|component| libm::roundf(component * max) as i32))
}

fn quaternion(value: [u16; 4]) -> [u16; 4] {
    let [a, b, c, scale] = value.map(|short| short as i16);
    let one = f32::from(scale | 3);
    let [x, y, z] = [a, b, c].map(|component| f32::from(component) / one * std::f32::consts::FRAC_1_SQRT_2);
    let square = 1.0 - x * x - y * y - z * z;
    let w = if square > 0.0 { square.sqrt() } else { 0.0 };
    let mut rotation = [w, x, y, z].map(|component| libm::roundf(component * 32767.0) as i16 as u16);
    rotation.rotate_right(usize::from(value[3] & 3));
    rotation
}

/// Float from its mantissa and exponent.
fn exponential(value: [u8; 4]) -> f32 {
    let [low, middle, high, exponent] = value;
    let mantissa = i32::from_le_bytes([0, low, middle, high]) >> 8;
    libm::ldexpf(mantissa as f32, i32::from(exponent as i8))
}

/// Decodes red, green, blue and alpha up to `max`. Transparent black if alpha does not encode the number of bits.
fn color(luma: i32, [co, cg]: [i32; 2], alpha: u32, max: f32) -> [i32; 4] {
    let Some(highest_bit) = alpha.checked_ilog2() else {
        return [0; 4];
    };
    let all = (2_u32 << highest_bit).wrapping_sub(1);
    let red = luma.wrapping_add(co).wrapping_sub(cg);
    let green = luma.wrapping_add(cg);
    let blue = luma.wrapping_sub(co).wrapping_sub(cg);
    let alpha = alpha & (all >> 1);
    let alpha = (alpha << 1 | alpha & 1) as i32;
    let scale = max / all as f32;
    [red, green, blue, alpha].map(|channel| libm::roundf((channel as f32 * scale).clamp(0.0, max)) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filtered<const N: usize>(filter: Filter, mut bytes: [u8; N]) -> [u8; N] {
        filter.apply(&mut bytes, N);
        bytes
    }

    fn shorts(values: [i16; 4]) -> [u8; 8] {
        values.map(i16::to_le_bytes).concat().try_into().unwrap()
    }

    #[test]
    fn octahedral_vectors_are_decoded() {
        // (0, 0) is +Z, (1, 0) is +X, (1, 1) folds to −Z. The last byte is not changed.
        assert_eq!(filtered(Filter::Octahedral, [0, 0, 127, 9]), [0, 0, 127, 9]);
        assert_eq!(filtered(Filter::Octahedral, [127, 0, 127, 9]), [127, 0, 0, 9]);
        let [x, y, z, _] = filtered(Filter::Octahedral, [127, 127, 127, 9]);
        assert_eq!([x, y, z as i8 as u8], [0, 0, 129], "z is −127");
        // Four bits: 7 encodes 1, so (7, 0) is +X. Sixteen bits: one half each is the diagonal 23170 = 32767 / √2.
        assert_eq!(filtered(Filter::Octahedral, [7, 0, 7, 0]), [127, 0, 0, 0]);
        let diagonal = filtered(Filter::Octahedral, shorts([1 << 13, 1 << 13, 1 << 14, 5]));
        assert_eq!(diagonal, shorts([23170, 23170, 0, 5]));
        assert_eq!(filtered(Filter::Octahedral, [1, 1, 0, 3]), [0, 0, 0, 3], "no one, no vector");
    }

    #[test]
    fn the_largest_quaternion_component_is_restored() {
        // Identity: three components are 0. The largest is w, component 3.
        assert_eq!(filtered(Filter::Quaternion, shorts([0, 0, 0, 32767])), shorts([0, 0, 0, 32767]));
        // The largest is x, component 0. y = 1/2 is stored as 0.5 √2 of the encoding of 1. x = √3/2.
        let half = (0.5 * std::f32::consts::SQRT_2 * 32764.0) as i16;
        let found = filtered(Filter::Quaternion, shorts([half, 0, 0, 32764]));
        let [x, y, z, w] = [0, 2, 4, 6].map(|i| i16::from_le_bytes([found[i], found[i + 1]]));
        assert!((x - 28377).abs() <= 2 && (y - 16383).abs() <= 2 && z == 0 && w == 0, "{x} {y} {z} {w}");
        // Negative components are signed.
        let found = filtered(Filter::Quaternion, shorts([-half, 0, 0, 32764]));
        assert!((i16::from_le_bytes([found[2], found[3]]) + 16383).abs() <= 2);
    }

    #[test]
    fn exponents_are_exact() {
        // 3 · 2^−1 and −5 · 2^4.
        let stored = |exponent: i8, mantissa: i32| {
            let [low, middle, high, _] = mantissa.to_le_bytes();
            [low, middle, high, exponent as u8]
        };
        let value = |bytes| f32::from_le_bytes(filtered(Filter::Exponential, bytes));
        assert_eq!(value(stored(-1, 3)), 1.5);
        assert_eq!(value(stored(4, -5)), -80.0);
        assert_eq!(value(stored(0, 0)), 0.0);
        assert_eq!(value(stored(-100, 1)), 2.0_f32.powi(-100));
    }

    #[test]
    fn colours_are_decoded_from_luma_and_chroma() {
        // Eight bits: alpha 0x80 | a, and a = 127 doubles to 255. Grey 100 has no chroma.
        assert_eq!(filtered(Filter::Color, [100, 0, 0, 0xff]), [100, 100, 100, 255]);
        // Y = 50, Co = 20, Cg = −10: r = 80, g = 40, b = 40.
        assert_eq!(filtered(Filter::Color, [50, 20, 246, 0x80]), [80, 40, 40, 0]);
        // Two bits: alpha 0b11, maximum 3, so luma 3 is white.
        assert_eq!(filtered(Filter::Color, [3, 0, 0, 3]), [255; 4]);
        assert_eq!(filtered(Filter::Color, [3, 0, 0, 0]), [0; 4]);
    }
}
