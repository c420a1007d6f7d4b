//! Import of glTF 2.0 files (`.gltf`, `.glb`) into a [`Scene`].
//!
//! Source: *glTF 2.0 Specification* (Khronos Group, 2021) and the texts of the extensions that
//! [`extension_support`] calls honoured. The `gltf` crate lends the types of the JSON objects; reading files,
//! repairing documents, decoding accessors and every check are done here, because the files come from anywhere: a
//! broken or hostile one ends in one error that names the place, never in a panic, a hang or memory that its size
//! does not justify.
//!
//! The steps, each in its own file: `container` splits the file, `document` parses and repairs the JSON,
//! `extensions` says what of it is understood, `resources` and `uri` fetch what it names, `accessor` reads numbers inside
//! what `bounds` has checked, `meshopt` and `draco` unpack what is stored compressed, and `mesh`, `material`, `variants`,
//! `image`, `image_budget`, `mip_maps`, `node`, `skin`, `instancing`, `camera`, `light`, `image_light` and `animation` (with `pointer`)
//! build the scene.
//!
//! It does not pose, evaluate animations, or decode sRGB; points and lines are not drawn.

#![deny(clippy::arithmetic_side_effects)]

mod accessor;
mod animation;
mod attributes;
mod bounds;
mod camera;
mod component;
mod container;
mod context;
mod document;
mod draco;
mod extensions;
mod formats;
mod hierarchy;
mod image;
mod image_budget;
mod image_light;
mod influences;
mod instancing;
mod light;
mod material;
mod mesh;
mod meshopt;
mod mip_maps;
mod morph;
mod node;
mod normals;
mod pointer;
mod primitive;
mod raw;
mod resources;
mod skin;
mod tangents;
#[cfg(test)]
mod tests;
mod texture;
mod topology;
mod uri;
mod variants;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::error::{Error, Result};
use crate::scene::Scene;

pub use extensions::{Support, extension_support};

use accessor::{Data, Replaced};
use context::Context;
use document::Document;

/// What an import may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImportOptions {
    /// Bytes that the imported scene may take, posed triangles included; what would need more is refused before it
    /// is allocated.
    pub max_memory_bytes: u64,
    /// What is wanted of the images that textures use.
    pub images: ImageNeed,
}

/// How far the images that textures use are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImageNeed {
    /// They are decoded.
    #[default]
    Texels,
    /// Headers only, and it is checked that decoding them would stay within the memory limit.
    Budget,
    /// Headers only: sizes are known, and there are no texels.
    Headers,
}

impl Default for ImportOptions {
    /// Four gibibytes.
    fn default() -> Self {
        Self { max_memory_bytes: 4 << 30, images: ImageNeed::Texels }
    }
}

/// Reads the glTF file at `path` and everything it names.
///
/// # Errors
///
/// [`Error::Missing`] when the file or one it names cannot be read, [`Error::Unsupported`] when it requires an
/// extension that is not honoured, [`Error::Refused`] when it needs more memory than allowed or names a file outside its
/// folder, and [`Error::Invalid`] for anything else that is wrong with it.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Scene> {
    // Crates that decode images and tangents could still panic; that must not end the program.
    catch_unwind(AssertUnwindSafe(|| import_unguarded(path, *options)))
        .unwrap_or_else(|_| Err(Error::invalid(path, "", "could not be understood; please report this file")))
}

fn import_unguarded(path: &Path, options: ImportOptions) -> Result<Scene> {
    let mut context = Context::new(path, options.max_memory_bytes);

    // Read the file, its JSON and its buffers.
    let file = container::read(&mut context)?;
    let mut resources = resources::Resources::new(&context, &file.bytes);
    let document = Document::parse(&mut context, file.json())?;
    extensions::check(&mut context, &document)?;
    context.animates_properties = document.uses(extensions::ANIMATION_POINTER);
    bounds::check_all(&context, &document)?;
    texture::check_links(&context, &document)?;
    let buffers = resources.load_buffers(&mut context, &document, file.bin())?;
    let views = meshopt::unpack_views(&mut context, &document, &buffers)?;
    let data = Data { document: &document, buffers: &buffers, views: &views, replaced: &Replaced::default() };

    // Build what stands alone, then what refers to it.
    let mut textures = texture::TextureTable::new(&document);
    let materials = material::import(&mut context, &document, &mut textures)?;
    let images = image::import(&mut context, &data, &mut resources, &textures, options.images)?;
    let mips = if options.images == ImageNeed::Texels {
        mip_maps::import(&mut context, &images, &textures)?
    } else {
        Vec::new()
    };
    let meshes = mesh::import(&mut context, &data, &materials)?;
    let variants = variants::import(&context, &document)?;
    let lights = light::import(&context, &document)?;
    let image_lights = image_light::import(&mut context, &data, &mut resources)?;
    let cameras = camera::import(&mut context, &document)?;
    let skins = skin::import(&mut context, &data)?;
    let hierarchy = node::import(&mut context, &data, &meshes, &skins, (lights.len(), image_lights.len()))?;
    let (animations, ignored_channels) = animation::import(&mut context, &data, &hierarchy.nodes, &meshes)?;

    let unused_textures = document.root.textures.len().saturating_sub(textures.textures.len());

    Ok(Scene {
        path: path.to_owned(),
        files: std::mem::take(&mut resources.files),
        content_hash: resources.finish_hash(),
        nodes: hierarchy.nodes,
        node_order: hierarchy.node_order,
        scenes: hierarchy.scenes,
        default_scene: hierarchy.default_scene,
        meshes,
        skins,
        materials,
        variants,
        textures: textures.textures,
        images,
        mips,
        lights,
        image_lights,
        cameras,
        animations,
        ignored_channels,
        unused_textures,
        extensions_used: document.root.extensions_used.clone(),
        extensions_required: document.root.extensions_required.clone(),
        warnings: context.into_warnings(),
    })
}
