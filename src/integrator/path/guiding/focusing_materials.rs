//! Materials that may focus light.

use crate::bsdf::is_smooth_roughness;
use crate::scene::Material;

/// Whether a surface of the material may send a photon on as [`super::PhotonPath::Caustic`]: as a mirror, as a smooth coat, or as the glass of a volume that bends it.
///
/// Textures may make any lobe smooth. Thin walls do not bend what they transmit. Volumes count at any roughness, since their lobes are the smoother the
/// less they bend light, which depends on the volume around them.
pub(super) fn may_focus_light(material: &Material) -> bool {
    let is_smooth = match &material.glossiness {
        Some(gloss) => gloss.texture.is_some() || is_smooth_roughness(1.0 - gloss.factor),
        None => material.metallic_roughness_texture.is_some() || is_smooth_roughness(material.roughness),
    };
    let has_smooth_coat = material.clear_coat.is_some_and(|coat| {
        coat.factor > 0.0 && (coat.roughness_texture.is_some() || is_smooth_roughness(coat.roughness))
    });
    is_smooth || has_smooth_coat || material.is_glass_volume()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{
        ClearCoat, DiffuseTransmission, Glossiness, TextureIndex, TextureRef, Transmission, UvTransform,
        Volume,
    };

    #[test]
    fn mirrors_coats_volumes_and_textures_may_focus_light() {
        let texture =
            Some(TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() });
        let rough = Material { roughness: 0.3, ..Material::default() };
        let transmission = Some(Transmission { factor: 1.0, texture: None });
        let coat = ClearCoat {
            factor: 1.0,
            texture: None,
            roughness: 0.0,
            roughness_texture: None,
            normal_texture: None,
        };
        let coated = |coat: ClearCoat| Material { clear_coat: Some(coat), ..rough.clone() };
        let glossy = |factor: f32, texture: Option<TextureRef>| Material {
            roughness: 1.0 - factor,
            glossiness: Some(Glossiness { factor, texture }),
            ..Material::default()
        };
        let thin = Material { transmission, ..rough.clone() };
        let half =
            DiffuseTransmission { factor: 0.5, texture: None, color: glam::Vec3::ONE, color_texture: None };
        let wax = Material { diffuse_transmission: Some(half), volume: Some(Volume::CLEAR), ..rough.clone() };
        let materials = vec![
            (rough.clone(), false),
            (Material { roughness: 0.0, ..rough.clone() }, true),
            (Material { roughness: 0.04, ..rough.clone() }, true),
            (Material { roughness: 0.05, ..rough.clone() }, false),
            (Material { metallic_roughness_texture: texture, ..rough.clone() }, true),
            (Material { base_color_texture: texture, ..rough.clone() }, false),
            (thin.clone(), false),
            (Material { roughness: 0.0, ..thin.clone() }, true),
            (Material { volume: Some(Volume::CLEAR), ..thin }, true),
            (wax, false),
            (coated(coat), true),
            (coated(ClearCoat { factor: 0.0, ..coat }), false),
            (coated(ClearCoat { roughness: 0.3, ..coat }), false),
            (coated(ClearCoat { roughness: 0.3, roughness_texture: texture, ..coat }), true),
            (glossy(1.0, None), true),
            (glossy(0.5, None), false),
            (glossy(0.5, texture), true),
        ];
        for (material, may_focus) in materials {
            assert_eq!(may_focus_light(&material), may_focus, "{material:?}");
        }
    }
}
