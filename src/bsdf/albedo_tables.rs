//! The stored tables of albedos, by integration.
//!
//! `cargo run --release -p oracles --bin albedo_tables` writes the files beside this one; a test compares them. Integrating when a program
//! starts would take seconds.

use super::{external_albedo, internal_albedo, isotropic_albedo, rough_volume_albedo, sheen};

/// Names and bytes of the files.
pub fn integrated_albedo_tables() -> [(&'static str, Vec<u8>); 5] {
    [
        ("lobe_albedo.bin", isotropic_albedo::integrated()),
        ("external_albedo.bin", external_albedo::integrated()),
        ("internal_albedo.bin", internal_albedo::integrated()),
        ("rough_volume_albedo.bin", rough_volume_albedo::integrated()),
        ("sheen_albedo.bin", sheen::integrated()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_tables_are_their_integrals() {
        let stored = [
            isotropic_albedo::STORED,
            external_albedo::STORED,
            internal_albedo::STORED,
            rough_volume_albedo::STORED,
            sheen::STORED,
        ];
        for ((name, integrated), stored) in integrated_albedo_tables().into_iter().zip(stored) {
            assert!(integrated == stored, "{name}: run `cargo run --release -p oracles --bin albedo_tables`");
        }
    }
}
