//! Values of the stored tables: 16-bit fixed point, little-endian.

/// Stored values are multiples of this.
pub(super) const UNIT: f32 = 1.0 / 32767.0;

/// The bytes of a value from −1 to 1.
pub(super) fn stored(value: f32) -> [u8; 2] {
    ((value / UNIT).round() as i16).to_le_bytes()
}

/// Several values in multiples of [`UNIT`].
#[inline(always)]
pub(super) fn decoded<const BYTES: usize, const N: usize>(bytes: &[u8; BYTES]) -> [f32; N] {
    std::array::from_fn(|at| f32::from(i16::from_le_bytes([bytes[2 * at], bytes[2 * at + 1]])))
}
