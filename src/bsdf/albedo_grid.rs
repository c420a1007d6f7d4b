//! What the tables of directional albedos have in common: their rows, their indices of refraction, and how they are stored.

use super::chebyshev::ChebyshevNodes;
use super::cubic_table::CubicTable;

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

/// A table of albedos over roughness, view and index of refraction.
pub(super) struct AlbedoTable<const ENTRIES: usize, const INDICES: usize> {
    pub(super) nodes: ChebyshevNodes<INDICES>,
    pub(super) values: CubicTable<ENTRIES>,
}

impl<const ENTRIES: usize, const INDICES: usize> AlbedoTable<ENTRIES, INDICES> {
    /// The table from its bytes: 32-bit floats, little-endian, `rows` of roughness with columns of views.
    pub(super) fn stored(bytes: &[u8], rows: usize) -> Self {
        let floats: Vec<f32> = bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        Self { nodes: index_nodes(), values: CubicTable::of_grid(floats.as_chunks().0, rows) }
    }
}

/// The tabulated indices of refraction in the scale of [`MIN_INDEX`].
pub(super) fn index_nodes<const INDICES: usize>() -> ChebyshevNodes<INDICES> {
    ChebyshevNodes::between(MIN_INDEX, MAX_INDEX)
}
