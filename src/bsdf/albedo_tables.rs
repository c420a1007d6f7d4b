//! The stored tables of albedos, by integration.
//!
//! `cargo run --release -p oracles --bin albedo_tables` writes the files beside this one, and compares them with `--check`; a test compares a
//! part. Integrating when a program starts would take seconds.

use super::{
    anisotropic_albedo, external_albedo, internal_albedo, isotropic_albedo, rough_volume_albedo, sheen,
};

/// Names and bytes of the files.
pub fn integrated_albedo_tables() -> [(&'static str, Vec<u8>); 6] {
    integrated(1)
}

/// Names of the files, and the bytes of every `step`th point of their grids.
fn integrated(step: usize) -> [(&'static str, Vec<u8>); 6] {
    [
        ("lobe_albedo.bin", isotropic_albedo::integrated(step)),
        ("external_albedo.bin", external_albedo::integrated(step)),
        ("internal_albedo.bin", internal_albedo::integrated(step)),
        ("anisotropic_albedo.bin", anisotropic_albedo::integrated(step)),
        ("rough_volume_albedo.bin", rough_volume_albedo::integrated(step)),
        ("sheen_albedo.bin", sheen::integrated(step)),
    ]
}

#[cfg(test)]
mod tests {
    use sha2::{Digest as _, Sha256};

    use super::*;
    use crate::bsdf::index_planes::PLANES;
    use crate::sha256::hex;

    /// Prime to the number of columns of each grid: the points lie in all rows and columns, and each has all indices.
    const STEP: usize = 8;

    const CHECK: &str = "run `cargo run --release -p oracles --bin albedo_tables -- --check`";

    #[test]
    fn stored_tables_are_their_integrals() {
        // Bytes of a grid point, and the hash of the whole file
        let stored = [
            (isotropic_albedo::STORED, 4, "9ed79f26fee9b78a033ba1a15150f32e41cdf558b28f423537fdcacaae2ff109"),
            (
                external_albedo::STORED,
                2 * PLANES,
                "ca890ecb0c357262a1bcfaaacea3ff58745e4e97cb4f62a2f1d71314bd9545ad",
            ),
            (
                internal_albedo::STORED,
                2 * PLANES,
                "b974fc82126eea5b0dbf1358f792129ea59ebf9e52558db4def68a663a8b205f",
            ),
            (
                anisotropic_albedo::STORED,
                anisotropic_albedo::BYTES,
                "eb36f125147f34a31aab834d7aa43a5d2cc51ad4006b2127131147d9e73678e6",
            ),
            (
                rough_volume_albedo::STORED,
                rough_volume_albedo::BYTES,
                "171cd4f2508efb6473dc5e8613a2f63e3a15df7ca3dc52aeef986042e0f35da3",
            ),
            (sheen::STORED, 4, "6cc39b9c4fdfa6eb49bf31a50031d192eaf99652c39dd38a22924c94c2f6524c"),
        ];
        for ((name, integrated), (stored, point_bytes, hash)) in integrated(STEP).into_iter().zip(stored) {
            let points: Vec<u8> = stored.chunks(point_bytes).step_by(STEP).flatten().copied().collect();
            assert!(integrated == points, "{name}: run `cargo run --release -p oracles --bin albedo_tables`");
            assert_eq!(hex(&Sha256::digest(stored)), hash, "{name}: {CHECK}, then store this hash");
        }
    }
}
