//! Display images, and noise.

use rayframe::regression::{ColorEncoding, Image};

/// Linear light as sRGB, extended beyond 1.
fn srgb_from_linear(light: f32) -> f32 {
    if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * libm::powf(light, 1.0 / 2.4) - 0.055 }
}

fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { libm::powf((value + 0.055) / 1.055, 2.4) }
}

/// Changes linear light in sRGB values. The result is never negative.
pub(crate) fn changed_on_display(light: f32, change: impl Fn(f32) -> f32) -> f32 {
    let changed = linear_from_srgb(change(srgb_from_linear(light)));
    if changed > 0.0 { changed } else { 0.0 }
}

/// The values of an 8-bit PNG file, without a tone curve.
pub(crate) fn display(image: &Image) -> Image {
    let eight_bits = |value: f32| (srgb_from_linear(value.clamp(0.0, 1.0)) * 255.0 + 0.5).floor() / 255.0;
    let pixels = image.rgba().unwrap_or_default().into_iter().map(|[r, g, b, a]| {
        [eight_bits(r), eight_bits(g), eight_bits(b), (a.clamp(0.0, 1.0) * 255.0 + 0.5).floor() / 255.0]
    });
    Image::from_rgba(image.size(), ColorEncoding::Srgb, &pixels.collect::<Vec<_>>())
}

/// A normally distributed number, by the Box–Muller transform of two hashes of `seed`.
pub(crate) fn gaussian(seed: u32) -> f32 {
    let uniform = |salt: u32| (mixed(seed.wrapping_mul(2).wrapping_add(salt)) as f32 + 0.5) / 4_294_967_296.0;
    libm::sqrtf(-2.0 * libm::logf(uniform(0))) * libm::cosf(std::f32::consts::TAU * uniform(1))
}

/// The finalizer of MurmurHash3.
fn mixed(mut bits: u32) -> u32 {
    bits ^= bits >> 16;
    bits = bits.wrapping_mul(0x85eb_ca6b);
    bits ^= bits >> 13;
    bits = bits.wrapping_mul(0xc2b2_ae35);
    bits ^ (bits >> 16)
}
