//! Import of glTF 2.0 files (`.gltf`, `.glb`) into a [`Scene`].
//!
//! Source: *glTF 2.0 Specification* (Khronos Group, 2021) and the texts of the extensions that [`extension_support`]
//! reports as supported. The `gltf` crate provides the types of the JSON objects. This module reads files, repairs
//! documents, decodes accessors and checks everything, because files come from untrusted sources: an invalid or hostile
//! file ends in one error with a JSON pointer, never in a panic, a hang, or memory that its size does not justify.
//!
//! Each step has its own file:
//!
//! - Reading: `container` splits the file, `document` parses and repairs the JSON, `extensions` checks the extensions (with `extension_names`),
//!   `resources` and `uri` load external files, and `named_files` lists them.
//! - Data: `bounds` checks accessors, `accessor` reads them, `meshopt` and `draco` decompress.
//! - Scene: `mesh`, `material`, `variants`, `image` (with `encoded_image` and `image_budget`), `mip_maps`, `node`, `skin`,
//!   `instancing`, `rotation`, `camera`, `light`, `image_light` and `animation` (with `pointer`, `keyframe_checks` and `animated_order`).
//!
//! Not done here: posing, evaluation of animations, sRGB decoding of textures. Points and lines are not imported.

#![deny(clippy::arithmetic_side_effects)]

mod accessor;
mod animated_matrix;
mod animated_order;
mod animation;
mod attributes;
mod bounds;
mod camera;
mod component;
mod container;
mod context;
mod coordinate_steps;
mod document;
#[cfg(feature = "draco")]
mod draco;
#[cfg(not(feature = "draco"))]
#[path = "draco_missing.rs"]
mod draco;
mod encoded_image;
mod extension_names;
mod extensions;
mod extremes;
mod file_storage;
mod fill;
mod flat_volume;
mod formats;
mod hierarchy;
mod image;
mod image_budget;
mod image_light;
mod influences;
mod instancing;
mod keyframe_checks;
mod light;
mod material;
mod mesh;
mod meshopt;
mod mip_maps;
mod morph;
mod named_files;
mod node;
mod normals;
mod options;
mod pointer;
mod primitive;
mod raw;
mod resources;
mod rotation;
mod scan;
mod skin;
mod tangent_faces;
mod tangents;
#[cfg(test)]
mod tests;
mod texture;
mod topology;
mod uri;
mod used_vertices;
mod variants;
mod vertex_lists;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::asset_cache::AssetCache;
use crate::error::{Error, Result, Warning};
use crate::scene::Scene;

pub use extensions::{ExtensionSupport, extension_support};
pub use named_files::named_files;
pub use options::{ImageLoading, ImportOptions};

use accessor::{Data, DecodedAccessors};
use animation::AnimationTargets;
use container::SceneFile;
use context::Context;
use document::Document;
use image::ImportedImages;
use node::LightCounts;
use options::ImageSource;
use resources::Resources;

/// Imports the glTF file at `path` and the files that it refers to.
///
/// # Errors
///
/// [`Error::Missing`] if the file or one that it refers to cannot be read, [`Error::Unsupported`] if it requires an
/// unsupported extension, [`Error::Refused`] if it exceeds the memory limit or refers to a file outside its folder and the allowed ones, and
/// [`Error::Invalid`] if it is malformed.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Scene> {
    import_with_cache(path, options, None)
}

/// The same. Images that `cache` keeps are not decoded.
///
/// # Errors
/// Those of [`import`].
pub(crate) fn import_with_cache(
    path: &Path,
    options: &ImportOptions,
    cache: Option<&AssetCache>,
) -> Result<Scene> {
    // Crates that decode images or compute tangents may panic. Turn that into an error.
    catch_unwind(AssertUnwindSafe(|| import_unguarded(path, options, cache)))
        .unwrap_or_else(|_| Err(Error::invalid(path, "", "could not be imported; please report this file")))
}

fn import_unguarded(path: &Path, options: &ImportOptions, cache: Option<&AssetCache>) -> Result<Scene> {
    let mut context = Context::new(path, options.max_memory_bytes);

    let file = container::read(&mut context)?;
    let mut scene = std::thread::scope(|threads| {
        let resources = Resources::new(&context, &file.bytes, &options.allowed_folders, threads);
        import_file(context, &file, resources, ImageSource { loading: options.images, cache })
    })?;
    scene.warnings.extend(coordinate_steps::coordinate_steps(&scene));
    scene.asset_cache = cache.map(AssetCache::usage);
    scene.notes.extend(cache.and_then(AssetCache::write_error).map(Warning::of_file));
    Ok(scene)
}

fn import_file(
    mut context: Context,
    file: &SceneFile,
    mut resources: Resources,
    source: ImageSource<'_>,
) -> Result<Scene> {
    // Read the JSON and the buffers.
    let document = Document::parse(&mut context, file.json())?;
    extensions::check(&mut context, &document)?;
    bounds::check_all(&context, &document)?;
    texture::check_references(&context, &document)?;
    let buffers = resources.load_buffers(&mut context, &document, file.bin())?;
    let views = meshopt::decompress_views(&mut context, &document, &buffers)?;
    let decoded = DecodedAccessors::default();
    let data = Data::new(&document, &buffers, &views, &decoded);

    // Import independent objects first, then those that refer to them.
    let mut textures = texture::TextureTable::new(&document);
    let materials = material::import(&mut context, &document, &mut textures)?;
    let ImportedImages { images, stored: stored_images, keys } =
        image::import(&mut context, &data, &mut resources, &textures, source)?;
    let mips = mip_maps::import(&mut context, (&images, &keys), &textures, source)?;
    let meshes = mesh::import(&mut context, &data, &materials)?;
    let variants = variants::import(&context, &document)?;
    let lights = light::import(&mut context, &document)?;
    let image_lights = image_light::import(&mut context, &data, &mut resources)?;
    let used_before = context.used_bytes();
    let cameras = camera::import(&mut context, &document)?;
    let skins = skin::import(&mut context, &data)?;
    let light_counts = LightCounts { punctual: lights.len(), image_based: image_lights.len() };
    let mut hierarchy = node::import(&mut context, &data, &meshes, &skins, light_counts)?;
    let targets = AnimationTargets::new(&hierarchy.nodes, &meshes, &lights, &cameras);
    let (animations, ignored_channels) = animation::import(&mut context, &data, &targets)?;
    animated_matrix::decompose(&mut context, &mut hierarchy.nodes, &animations);
    context.keep_since(used_before);
    hierarchy::check_size(&context, &hierarchy, &meshes)?;

    let file_bytes = resources.file_bytes().saturating_add(file.bytes.len() as u64);
    let storage = file_storage::file_storage(&document, file_bytes, stored_images);

    Ok(Scene {
        path: context.path.to_owned(),
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
        unused_textures: document.root.textures.len().saturating_sub(textures.textures.len()),
        textures: textures.textures,
        images,
        mips,
        lights,
        image_lights,
        cameras,
        animations,
        ignored_channels,
        extensions_used: document.root.extensions_used.clone(),
        extensions_required: document.root.extensions_required.clone(),
        storage,
        memory: context.memory(),
        variant_warnings: context.take_variant_warnings(),
        warnings: context.into_warnings(),
        ..Scene::default()
    })
}
