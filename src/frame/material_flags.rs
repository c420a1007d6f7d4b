//! Traversal flags that follow from a material.

use crate::bvh::TriangleFlags;
use crate::scene::{AlphaMode, Material};

/// The traversal flags of triangles with `material`.
///
/// Volumes and double-sided surfaces are hit from both sides. Every query asks its filter about surfaces with holes and about those
/// that only catch shadows. Glass hides what is behind it from rays that look for a surface, but not from shadow rays.
pub(super) fn material_flags(material: &Material) -> TriangleFlags {
    let mut flags = TriangleFlags::default();
    if !material.double_sided && !material.is_volume() {
        flags = flags.with(TriangleFlags::SINGLE_SIDED);
    }
    if material.alpha_mode != AlphaMode::Opaque || material.is_shadow_catcher {
        flags = flags.with(TriangleFlags::FILTERED);
    }
    if material.transmits() {
        flags = flags.with(TriangleFlags::TRANSMISSIVE);
    }
    flags
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::{DiffuseTransmission, Transmission, Volume};

    #[test]
    fn flags_follow_the_material() {
        let transmission = Some(Transmission { factor: 1.0, texture: None });
        let volume = Some(Volume::CLEAR);
        let solid = Material::default();
        assert_eq!(material_flags(&solid), TriangleFlags::SINGLE_SIDED);
        let glass = Material { transmission, volume, ..Material::default() };
        assert_eq!(material_flags(&glass), TriangleFlags::TRANSMISSIVE);
        let holes = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..glass };
        assert_eq!(material_flags(&holes), TriangleFlags::FILTERED.with(TriangleFlags::TRANSMISSIVE));
        // A volume without transmission has no effect.
        let inert = Material { volume, ..Material::default() };
        assert_eq!(material_flags(&inert), TriangleFlags::SINGLE_SIDED);
        let half = DiffuseTransmission { factor: 0.5, texture: None, color: Vec3::ONE, color_texture: None };
        let paper = Material { diffuse_transmission: Some(half), ..Material::default() };
        assert_eq!(material_flags(&paper), TriangleFlags::SINGLE_SIDED);
        // Shadow rays end at wax, which has two sides.
        let wax = Material { volume, ..paper };
        assert_eq!(material_flags(&wax), TriangleFlags::default());
        let card = Material { alpha_mode: AlphaMode::Blend, double_sided: true, ..Material::default() };
        assert_eq!(material_flags(&card), TriangleFlags::FILTERED);
    }
}
