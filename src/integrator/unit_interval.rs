//! Random bits as fractions.

/// The number in [0, 1) of the highest 24 bits, which a float holds exactly.
#[inline(always)]
pub(crate) fn unit_interval(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}
