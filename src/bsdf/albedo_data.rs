//! Tabulated albedos as they are stored beside the code: 32-bit floats, little-endian, `isotropic` before `internal`.
//!
//! `cargo run --release -p oracles --bin albedo_tables` writes the file; a test compares it with the integrals. Integrating when a
//! program starts would take half a second.

use super::{internal_albedo, isotropic_albedo};

/// The values of both tables.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AlbedoData {
    /// Rows of roughness, columns of views.
    pub(super) isotropic: Vec<[f32; isotropic_albedo::ENTRIES]>,
    pub(super) internal: Vec<[f32; internal_albedo::INDICES]>,
}

const STORED: &[u8] = include_bytes!("albedo_tables.bin");

/// The stored values.
pub(super) fn stored() -> AlbedoData {
    let mut floats = STORED.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
    let mut next = || floats.next().unwrap_or(0.0);
    let isotropic = isotropic_albedo::ROUGHNESS_STEPS * isotropic_albedo::VIEW_STEPS;
    let internal = internal_albedo::ROUGHNESS_STEPS * internal_albedo::VIEW_STEPS;
    AlbedoData {
        isotropic: (0..isotropic).map(|_| std::array::from_fn(|_| next())).collect(),
        internal: (0..internal).map(|_| std::array::from_fn(|_| next())).collect(),
    }
}

/// The file's bytes, by integration.
pub fn integrated_bytes() -> Vec<u8> {
    let isotropic = isotropic_albedo::integrated_grid().into_iter().flatten();
    let internal = internal_albedo::integrated_grid().into_iter().flatten();
    isotropic.chain(internal).flat_map(f32::to_le_bytes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_tables_are_their_integrals() {
        assert!(STORED == integrated_bytes(), "run `cargo run --release -p oracles --bin albedo_tables`");
    }
}
