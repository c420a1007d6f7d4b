//! Texture references with parameters: normal and occlusion textures.
//!
//! Source: glTF 2.0 specification, sections 5.20 (normal texture info) and 5.21 (occlusion texture info).

use crate::error::Result;
use crate::gltf::context::Context;
use crate::gltf::raw::{ANY, Raw};
use crate::gltf::texture::TextureTable;
use crate::scene::{NormalTexture, OcclusionTexture};

/// Reads the normal texture that is the member `key` of `raw`.
pub(super) fn normal_texture(
    context: &mut Context,
    raw: &Raw,
    key: &str,
    textures: &mut TextureTable,
) -> Result<Option<NormalTexture>> {
    let (Some(texture), Some(info)) = (textures.reference(context, raw, key)?, raw.field(key)) else {
        return Ok(None);
    };
    let scale = info.number(context, "scale", 1.0, ANY)?;
    Ok(Some(NormalTexture { texture, scale }))
}

/// Reads the occlusion texture of the material `raw`.
pub(super) fn occlusion_texture(
    context: &mut Context,
    raw: &Raw,
    textures: &mut TextureTable,
) -> Result<Option<OcclusionTexture>> {
    let (Some(texture), Some(info)) =
        (textures.reference(context, raw, "occlusionTexture")?, raw.field("occlusionTexture"))
    else {
        return Ok(None);
    };
    let strength = info.unit(context, "strength", 1.0)?;
    Ok(Some(OcclusionTexture { texture, strength }))
}
