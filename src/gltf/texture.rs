//! Textures, samplers, and the material's references to them.
//!
//! Source: glTF 2.0 specification, sections 3.8 (texture data) and 5.29 (texture info); `KHR_texture_transform`.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec2;
use gltf::json;
use gltf::json::texture::{MagFilter, MinFilter, WrappingMode};
use gltf::json::validation::Checked;

use super::context::Context;
use super::document::Document;
use super::extension_names::{TEXTURE_BASISU, TEXTURE_TRANSFORM, TEXTURE_WEBP, UNSUPPORTED_IMAGES};
use super::raw::{ANY, Raw};
use crate::error::Result;
use crate::scene::{
    Encoding, Filter, ImageIndex, MipFilter, Sampler, Texture, TextureIndex, TextureRef, UvRotation,
    UvTransform, WrapMode,
};

/// Most texture coordinate sets of a primitive. Bounds the memory for missing sets, which are filled with zeros.
const MAX_UV_SETS: usize = 64;

/// Supported extensions that give a texture an alternative image, in order of preference.
const PREFERRED: [&str; 2] = [TEXTURE_WEBP, TEXTURE_BASISU];

/// Textures that materials use, and their images, each once and in order of first use.
#[derive(Debug)]
pub(super) struct TextureTable<'a> {
    document: &'a Document,
    /// Textures in order of first use.
    pub(super) textures: Vec<Texture>,
    /// Image indices in the file, in order of first use.
    pub(super) images: Vec<usize>,
    /// Encodings for which each image needs mip maps.
    pub(super) uses: BTreeSet<(ImageIndex, Encoding)>,
    texture_of: BTreeMap<usize, TextureIndex>,
    image_of: BTreeMap<usize, ImageIndex>,
}

/// The texture info of a material.
#[derive(Debug)]
struct TextureInfo {
    pointer: String,
    /// Index of the texture in the file.
    index: usize,
    uv_set: usize,
    transform: UvTransform,
}

impl<'a> TextureTable<'a> {
    pub(super) fn new(document: &'a Document) -> Self {
        Self {
            document,
            textures: Vec::new(),
            images: Vec::new(),
            uses: BTreeSet::new(),
            texture_of: BTreeMap::new(),
            image_of: BTreeMap::new(),
        }
    }

    /// Checks the texture info that is the member `key` of `owner`.
    pub(super) fn check_reference(&self, context: &Context, owner: &Raw, key: &str) -> Result<()> {
        self.info(context, owner, key).map(|_| ())
    }

    /// Reads the texture info that is the member `key` of `owner`.
    fn info(&self, context: &Context, owner: &Raw, key: &str) -> Result<Option<TextureInfo>> {
        let Some(info) = owner.field(key) else {
            return Ok(None);
        };
        info.expect_object(context)?;
        let index_pointer = format!("{}/index", info.pointer);
        let Some(index) = info.index(context, "index")? else {
            return Err(context.invalid(index_pointer, "is missing"));
        };
        let mut uv_set = info.index(context, "texCoord")?.unwrap_or(0);
        let mut transform = UvTransform::default();
        if let Some(extension) = info.extension(TEXTURE_TRANSFORM) {
            extension.expect_object(context)?;
            uv_set = extension.index(context, "texCoord")?.unwrap_or(uv_set);
            transform = UvTransform {
                offset: Vec2::from_array(extension.numbers(context, "offset", [0.0; 2], ANY)?),
                rotation: UvRotation::from_radians(extension.number(context, "rotation", 0.0, ANY)?),
                scale: Vec2::from_array(extension.numbers(context, "scale", [1.0; 2], ANY)?),
            };
        }
        context.check_index(index, self.document.root.textures.len(), &index_pointer, "texture")?;
        Ok(Some(TextureInfo { pointer: info.pointer, index, uv_set, transform }))
    }

    /// Resolves the texture info that is the member `key` of `owner`, and adds its texture.
    pub(super) fn reference(
        &mut self,
        context: &mut Context,
        owner: &Raw,
        key: &str,
    ) -> Result<Option<TextureRef>> {
        let Some(info) = self.info(context, owner, key)? else {
            return Ok(None);
        };
        let TextureInfo { pointer, index, uv_set, transform } = info;
        if uv_set >= MAX_UV_SETS {
            let message = format!("uses TEXCOORD_{uv_set}; no more than {MAX_UV_SETS} sets are supported");
            return Err(context.refused(pointer, message));
        }
        let Some(texture) = self.texture(context, index, &pointer)? else {
            return Ok(None);
        };
        self.record_use(texture, key);
        Ok(Some(TextureRef { texture, uv_set: u32::try_from(uv_set).unwrap_or_default(), transform }))
    }

    /// Records the encodings of the texture; the material member `key` determines them.
    fn record_use(&mut self, texture: TextureIndex, key: &str) {
        let Some(Texture { image, sampler, .. }) = self.textures.get(texture.index()) else {
            return;
        };
        // Emitters are measured in mip levels whatever the sampler.
        if sampler.mip == MipFilter::None && key != "emissiveTexture" {
            return;
        }
        let encodings: &[Encoding] = match key {
            // The alpha mode decides between the two. An image without alpha has one set of mip maps for both.
            "baseColorTexture" | "diffuseTexture" => &[Encoding::Srgb, Encoding::CoveredSrgb],
            "emissiveTexture"
            | "specularColorTexture"
            | "sheenColorTexture"
            | "specularGlossinessTexture"
            | "diffuseTransmissionColorTexture" => &[Encoding::Srgb],
            "normalTexture" | "clearcoatNormalTexture" => &[Encoding::Normal],
            _ => &[Encoding::Linear],
        };
        self.uses.extend(encodings.iter().map(|encoding| (*image, *encoding)));
    }

    /// Adds the texture `index`, to which the texture info at `pointer` refers. `None`, after a warning, if it has no image.
    fn texture(
        &mut self,
        context: &mut Context,
        index: usize,
        pointer: &str,
    ) -> Result<Option<TextureIndex>> {
        if let Some(&known) = self.texture_of.get(&index) {
            return Ok(Some(known));
        }
        let Some(texture) = self.document.root.textures.get(index) else {
            return Err(context.invalid(format!("{pointer}/index"), "there is no such texture"));
        };
        let Some(image) = self.image(context, texture, index)? else {
            return Ok(None);
        };
        let sampler = sampler(context, self.document, texture, index)?;
        let slot = TextureIndex(u32::try_from(self.textures.len()).unwrap_or(u32::MAX));
        self.textures.push(Texture { name: texture.name.clone(), image, sampler });
        self.texture_of.insert(index, slot);
        Ok(Some(slot))
    }

    fn image(
        &mut self,
        context: &mut Context,
        texture: &json::Texture,
        index: usize,
    ) -> Result<Option<ImageIndex>> {
        let pointer = format!("/textures/{index}");
        let raw = self.document.element("textures", index);
        let preferred = match &raw {
            Some(raw) => preferred_source(context, raw)?.map(|(source, _)| source),
            None => None,
        };
        let plain = has_source(texture).then(|| texture.source.value());
        let Some(source) = preferred.or(plain) else {
            let has = |name: &&&str| raw.as_ref().is_some_and(|raw| raw.extension(name).is_some());
            let replaced = UNSUPPORTED_IMAGES.iter().find(has);
            if let Some(name) = replaced {
                let message = format!(
                    "{name} is not supported and the texture has no PNG or JPEG source; export the file with one"
                );
                return Err(context.unsupported(format!("{pointer}/extensions/{name}"), message));
            }
            context.warn(pointer, "textures without a source image are ignored");
            return Ok(None);
        };
        let images = &mut self.images;
        let slot = *self.image_of.entry(source).or_insert_with(|| {
            images.push(source);
            ImageIndex(u32::try_from(images.len().saturating_sub(1)).unwrap_or(u32::MAX))
        });
        Ok(Some(slot))
    }
}

/// Image of the first supported extension of a texture, and the JSON pointer of the reference.
fn preferred_source(context: &Context, raw: &Raw) -> Result<Option<(usize, String)>> {
    for extension in PREFERRED.iter().filter_map(|name| raw.extension(name)) {
        extension.expect_object(context)?;
        if let Some(source) = extension.index(context, "source")? {
            return Ok(Some((source, format!("{}/source", extension.pointer))));
        }
    }
    Ok(None)
}

/// Whether a texture has a source. The `gltf` crate represents a missing one by the highest index.
fn has_source(texture: &json::Texture) -> bool {
    texture.source.value() != u32::MAX as usize
}

/// Checks the references from textures to images and samplers and from images to buffer views, including unused ones.
pub(super) fn check_references(context: &Context, document: &Document) -> Result<()> {
    let root = &document.root;
    for (i, texture) in root.textures.iter().enumerate() {
        if has_source(texture) {
            let pointer = format!("/textures/{i}/source");
            context.check_index(texture.source.value(), root.images.len(), &pointer, "image")?;
        }
        if let Some(raw) = document.element("textures", i)
            && let Some((source, pointer)) = preferred_source(context, &raw)?
        {
            context.check_index(source, root.images.len(), &pointer, "image")?;
        }
        if let Some(sampler) = texture.sampler {
            let pointer = format!("/textures/{i}/sampler");
            context.check_index(sampler.value(), root.samplers.len(), &pointer, "sampler")?;
        }
    }
    for (i, image) in root.images.iter().enumerate() {
        if let Some(view) = image.buffer_view {
            let pointer = format!("/images/{i}/bufferView");
            context.check_index(view.value(), root.buffer_views.len(), &pointer, "buffer view")?;
        }
    }
    Ok(())
}

fn sampler(context: &Context, document: &Document, texture: &json::Texture, index: usize) -> Result<Sampler> {
    let default = json::texture::Sampler::default();
    let (sampler, pointer) = match texture.sampler {
        None => (&default, String::new()),
        Some(sampler) => {
            let samplers = &document.root.samplers;
            let pointer = format!("/textures/{index}/sampler");
            let i = context.check_index(sampler.value(), samplers.len(), &pointer, "sampler")?;
            (samplers.get(i).unwrap_or(&default), format!("/samplers/{i}"))
        }
    };
    let wrap = |mode: &Checked<WrappingMode>, key: &str| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Ok(WrapMode::ClampToEdge),
        Checked::Valid(WrappingMode::MirroredRepeat) => Ok(WrapMode::MirroredRepeat),
        Checked::Valid(WrappingMode::Repeat) => Ok(WrapMode::Repeat),
        Checked::Invalid => Err(context.invalid(format!("{pointer}/{key}"), "must be 10497, 33071 or 33648")),
    };
    let magnify = match &sampler.mag_filter {
        None | Some(Checked::Valid(MagFilter::Linear)) => Filter::Linear,
        Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
        Some(Checked::Invalid) => {
            return Err(context.invalid(format!("{pointer}/magFilter"), "must be 9728 or 9729"));
        }
    };
    // Filter within a level and between levels. The specification leaves undefined filters to the implementation.
    let (minify, mip) = match &sampler.min_filter {
        None | Some(Checked::Valid(MinFilter::LinearMipmapLinear)) => (Filter::Linear, MipFilter::Linear),
        Some(Checked::Valid(MinFilter::Linear)) => (Filter::Linear, MipFilter::None),
        Some(Checked::Valid(MinFilter::LinearMipmapNearest)) => (Filter::Linear, MipFilter::Nearest),
        Some(Checked::Valid(MinFilter::Nearest)) => (Filter::Nearest, MipFilter::None),
        Some(Checked::Valid(MinFilter::NearestMipmapNearest)) => (Filter::Nearest, MipFilter::Nearest),
        Some(Checked::Valid(MinFilter::NearestMipmapLinear)) => (Filter::Nearest, MipFilter::Linear),
        Some(Checked::Invalid) => {
            let message = "must be 9728, 9729 or one of 9984 to 9987";
            return Err(context.invalid(format!("{pointer}/minFilter"), message));
        }
    };
    Ok(Sampler {
        wrap_u: wrap(&sampler.wrap_s, "wrapS")?,
        wrap_v: wrap(&sampler.wrap_t, "wrapT")?,
        magnify,
        minify,
        mip,
    })
}
