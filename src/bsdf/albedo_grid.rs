//! What the tables of directional albedos have in common: their rows, their indices of refraction, and how they are stored.

/// Roughness of the first row. Smoother lobes are scaled from it.
pub(super) const MIN_ROUGHNESS: f32 = 0.01;
/// ln((n − 1) / (n + 1)) for n = 1.06 and n = 3.2, n being the larger index over the smaller one.
pub(super) const MIN_INDEX: f32 = -3.53;
/// See [`MIN_INDEX`].
pub(super) const MAX_INDEX: f32 = -0.647;

/// Row of a roughness, 0 to 1; rows are denser towards smooth lobes.
pub(super) fn row(roughness: f32) -> f32 {
    libm::sqrtf((roughness - MIN_ROUGHNESS) / (1.0 - MIN_ROUGHNESS))
}

pub(super) fn roughness_of(row: f32) -> f32 {
    MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * row * row
}

/// The inverse hyperbolic sine, for x ≥ 0.
pub(super) fn arsinh(x: f32) -> f32 {
    libm::log1pf(x + x * x / (1.0 + libm::sqrtf(1.0 + x * x)))
}

/// The entries of a table from its bytes: 32-bit floats, little-endian, rows of roughness with columns of views.
pub(super) fn stored<const N: usize>(bytes: &[u8]) -> Vec<[f32; N]> {
    let floats: Vec<f32> = bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    floats.as_chunks().0.to_vec()
}
