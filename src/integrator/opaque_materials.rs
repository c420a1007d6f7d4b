//! Materials without the lobes of extensions, and their albedos.

use std::collections::BTreeMap;

use crate::bsdf::{AlbedoTable, LARGEST_SCALED_IOR};
use crate::scene::Material;

/// Most indices of refraction of a frame whose tables have memory of their own, 76 kB each. Files of some thousand indices would take hundreds of MB
/// that no budget knows. The lookups of the others give the same values, one at a time.
const MOST_TABLES: usize = 64;

/// Tables of albedos of opaque materials, seen through vacuum: one for each index of refraction.
#[derive(Clone, Debug)]
pub(super) struct OpaqueAlbedos {
    /// By the bits of the index.
    tables: BTreeMap<u32, AlbedoTable>,
}

impl OpaqueAlbedos {
    /// The tables of the opaque ones of `materials`.
    pub(super) fn of(materials: &[Material]) -> Self {
        let mut tables = BTreeMap::new();
        for material in materials.iter().filter(|material| is_opaque(material)) {
            let has_memory = tables.len() < MOST_TABLES;
            let table = if has_memory { AlbedoTable::between } else { AlbedoTable::of_slice };
            tables.entry(material.ior.to_bits()).or_insert_with(|| table(1.0, material.ior));
        }
        Self { tables }
    }

    /// The table of a material.
    pub(super) fn table(&self, material: &Material) -> Option<&AlbedoTable> {
        self.tables.get(&material.ior.to_bits())
    }
}

/// Whether the lobes of a material are those of the metallic-roughness model alone, so that hits can be shaded in blocks.
pub(super) fn is_opaque(material: &Material) -> bool {
    let is_unlayered = material.clear_coat.is_none()
        && material.sheen.is_none()
        && material.iridescence.is_none()
        && material.anisotropy.is_none()
        && material.diffuse_transmission.is_none();
    // Blocks know the exact curve alone.
    let has_exact_curve =
        material.ior > 0.0 && (material.specular.is_none() || material.ior <= LARGEST_SCALED_IOR);
    is_unlayered && !material.unlit && !material.transmits() && has_exact_curve
}

#[cfg(test)]
mod tests {
    use super::*;

    fn materials(indices: usize) -> Vec<Material> {
        let of = |index: usize| Material { ior: 1.2 + index as f32 / 4096.0, ..Material::default() };
        // Two of each index.
        (0..indices).chain(0..indices).map(of).collect()
    }

    #[test]
    fn every_index_has_a_table_and_the_first_have_memory() {
        for (indices, with_memory) in [(1, 1), (64, 64), (3000, 64)] {
            let materials = materials(indices);
            let albedos = OpaqueAlbedos::of(&materials);
            let tables: Vec<&AlbedoTable> =
                materials[..indices].iter().map(|material| albedos.table(material).unwrap()).collect();
            let sizes: Vec<usize> = tables.iter().map(|table| table.heap_bytes()).collect();
            assert!(sizes[..with_memory].iter().all(|bytes| (1..100_000).contains(bytes)), "{indices}");
            assert!(sizes[with_memory..].iter().all(|bytes| *bytes == 0), "{indices}");
            for (material, table) in materials.iter().zip(tables) {
                assert_eq!(table.slice(), AlbedoTable::of_slice(1.0, material.ior).slice());
            }
        }
        let mirror = Material { ior: 0.0, ..Material::default() };
        assert!(OpaqueAlbedos::of(&materials(2)).table(&mirror).is_none());
    }
}
