//! Materials without the lobes of extensions, and their albedos.

use crate::bsdf::{AlbedoTable, LARGEST_SCALED_IOR};
use crate::scene::Material;

/// Tables of albedos of opaque materials, seen through vacuum: one for each index of refraction.
#[derive(Clone, Debug)]
pub(super) struct OpaqueAlbedos {
    tables: Vec<(f32, AlbedoTable)>,
}

impl OpaqueAlbedos {
    /// The tables of the opaque ones of `materials`.
    pub(super) fn of(materials: &[Material]) -> Self {
        let mut tables: Vec<(f32, AlbedoTable)> = Vec::new();
        for material in materials.iter().filter(|material| is_opaque(material)) {
            if tables.iter().all(|(ior, _)| *ior != material.ior) {
                tables.push((material.ior, AlbedoTable::between(1.0, material.ior)));
            }
        }
        Self { tables }
    }

    /// The table of a material.
    pub(super) fn table(&self, material: &Material) -> Option<&AlbedoTable> {
        self.tables.iter().find(|(ior, _)| *ior == material.ior).map(|(_, table)| table)
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
