//! The stored tables of albedos, by integration.
//!
//! `cargo run --release -p oracles --bin albedo_tables` writes the files beside this one; a test compares them. Integrating when a program
//! starts would take half a second.

use super::{internal_albedo, isotropic_albedo};

/// Names and bytes of the files.
pub fn integrated_albedo_tables() -> [(&'static str, Vec<u8>); 2] {
    [
        ("isotropic_albedo.bin", bytes(isotropic_albedo::integrated_grid())),
        ("internal_albedo.bin", bytes(internal_albedo::integrated_grid())),
    ]
}

fn bytes<const N: usize>(entries: Vec<[f32; N]>) -> Vec<u8> {
    entries.into_iter().flatten().flat_map(f32::to_le_bytes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_tables_are_their_integrals() {
        let stored = [isotropic_albedo::STORED, internal_albedo::STORED];
        for ((name, integrated), stored) in integrated_albedo_tables().into_iter().zip(stored) {
            assert!(integrated == stored, "{name}: run `cargo run --release -p oracles --bin albedo_tables`");
        }
    }
}
