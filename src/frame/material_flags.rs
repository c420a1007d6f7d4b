//! Traversal flags that follow from a material.

use crate::bvh::TriangleFlags;
use crate::scene::{AlphaMode, Material};

/// The traversal flags of triangles with `material`.
///
/// Volumes and double-sided surfaces are hit from both sides. Traversal asks the hit filter about every surface that lets light
/// through or only catches shadows.
pub(super) fn material_flags(material: &Material) -> TriangleFlags {
    let mut flags = TriangleFlags::default();
    if !material.double_sided && !material.is_volume() {
        flags = flags.with(TriangleFlags::SINGLE_SIDED);
    }
    if material.alpha_mode != AlphaMode::Opaque || material.transmits() || material.is_shadow_catcher {
        flags = flags.with(TriangleFlags::FILTERED);
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Transmission, Volume};

    #[test]
    fn flags_follow_the_material() {
        let transmission = Some(Transmission { factor: 1.0, texture: None });
        let volume = Some(Volume::CLEAR);
        let solid = Material::default();
        assert_eq!(material_flags(&solid), TriangleFlags::SINGLE_SIDED);
        let glass = Material { transmission, volume, ..Material::default() };
        assert_eq!(material_flags(&glass), TriangleFlags::FILTERED);
        // A volume without transmission has no effect.
        let inert = Material { volume, ..Material::default() };
        assert_eq!(material_flags(&inert), TriangleFlags::SINGLE_SIDED);
        let card = Material { alpha_mode: AlphaMode::Blend, double_sided: true, ..Material::default() };
        assert_eq!(material_flags(&card), TriangleFlags::FILTERED);
    }
}
