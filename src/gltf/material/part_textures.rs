//! Textures of a part of a material: of its core, or of one of its extensions. Those of a part without effect are checked alone, so that
//! nothing reads their images.

use crate::error::Result;
use crate::gltf::context::Context;
use crate::gltf::raw::{ANY, Raw};
use crate::gltf::texture::TextureTable;
use crate::scene::{NormalTexture, OcclusionTexture, TextureRef};

/// Reads the texture references of a part.
#[derive(Debug)]
pub(super) struct PartTextures<'t, 'd> {
    table: &'t mut TextureTable<'d>,
    /// Whether the finished material has the part.
    is_kept: bool,
}

impl<'t, 'd> PartTextures<'t, 'd> {
    pub(super) fn new(table: &'t mut TextureTable<'d>) -> Self {
        Self { table, is_kept: true }
    }

    /// The textures of a part of this part, which the finished material has if it has both.
    pub(super) fn if_kept(&mut self, is_kept: bool) -> PartTextures<'_, 'd> {
        PartTextures { table: self.table, is_kept: self.is_kept && is_kept }
    }

    /// Reads the texture info that is the member `key` of `owner`. `None` if the material does not keep it.
    pub(super) fn reference(
        &mut self,
        context: &mut Context,
        owner: &Raw,
        key: &str,
    ) -> Result<Option<TextureRef>> {
        if self.is_kept {
            return self.table.reference(context, owner, key);
        }
        self.table.check_reference(context, owner, key).map(|()| None)
    }

    /// Reads the normal texture that is the member `key` of `owner`.
    pub(super) fn normal_texture(
        &mut self,
        context: &mut Context,
        owner: &Raw,
        key: &str,
    ) -> Result<Option<NormalTexture>> {
        let texture = self.reference(context, owner, key)?;
        let Some(info) = owner.field(key) else {
            return Ok(None);
        };
        let scale = info.number(context, "scale", 1.0, ANY)?;
        Ok(texture.map(|texture| NormalTexture { texture, scale }))
    }

    /// Reads the occlusion texture of the material `owner`.
    pub(super) fn occlusion_texture(
        &mut self,
        context: &mut Context,
        owner: &Raw,
    ) -> Result<Option<OcclusionTexture>> {
        let texture = self.reference(context, owner, "occlusionTexture")?;
        let Some(info) = owner.field("occlusionTexture") else {
            return Ok(None);
        };
        let strength = info.unit(context, "strength", 1.0)?;
        Ok(texture.map(|texture| OcclusionTexture { texture, strength }))
    }
}
