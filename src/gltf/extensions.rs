//! Which extensions are honoured, and what is said about the others.

use std::collections::BTreeMap;

use serde_json::Value;

use super::context::Context;
use super::document::Document;
use super::raw::escape;
use crate::error::Result;

pub(super) const ANIMATION_POINTER: &str = "KHR_animation_pointer";
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
pub(super) const EXT_MESHOPT: &str = "EXT_meshopt_compression";
pub(super) const IMAGE_LIGHTS: &str = "EXT_lights_image_based";
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";
pub(super) const KHR_MESHOPT: &str = "KHR_meshopt_compression";
pub(super) const LIGHTS: &str = "KHR_lights_punctual";
pub(super) const ANISOTROPY: &str = "KHR_materials_anisotropy";
pub(super) const CLEAR_COAT: &str = "KHR_materials_clearcoat";
pub(super) const DIFFUSE_TRANSMISSION: &str = "KHR_materials_diffuse_transmission";
pub(super) const DISPERSION: &str = "KHR_materials_dispersion";
pub(super) const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
pub(super) const IOR: &str = "KHR_materials_ior";
pub(super) const IRIDESCENCE: &str = "KHR_materials_iridescence";
pub(super) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
pub(super) const SHEEN: &str = "KHR_materials_sheen";
pub(super) const SPECULAR: &str = "KHR_materials_specular";
pub(super) const TRANSMISSION: &str = "KHR_materials_transmission";
pub(super) const UNLIT: &str = "KHR_materials_unlit";
pub(super) const VARIANTS: &str = "KHR_materials_variants";
pub(super) const VOLUME: &str = "KHR_materials_volume";
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";
pub(super) const TEXTURE_BASISU: &str = "KHR_texture_basisu";
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";
pub(super) const TEXTURE_WEBP: &str = "EXT_texture_webp";
pub(super) const VISIBILITY: &str = "KHR_node_visibility";

/// Extensions of single materials.
const OF_MATERIALS: [&str; 13] = [
    ANISOTROPY,
    CLEAR_COAT,
    DIFFUSE_TRANSMISSION,
    DISPERSION,
    EMISSIVE_STRENGTH,
    IOR,
    IRIDESCENCE,
    SPECULAR_GLOSSINESS,
    SHEEN,
    SPECULAR,
    TRANSMISSION,
    UNLIT,
    VOLUME,
];

/// All others that are honoured.
const OTHERS: [&str; 13] = [
    ANIMATION_POINTER,
    DRACO,
    EXT_MESHOPT,
    IMAGE_LIGHTS,
    INSTANCING,
    KHR_MESHOPT,
    LIGHTS,
    VARIANTS,
    QUANTIZATION,
    TEXTURE_BASISU,
    TEXTURE_TRANSFORM,
    TEXTURE_WEBP,
    VISIBILITY,
];

fn is_honoured(name: &str) -> bool {
    OF_MATERIALS.contains(&name) || OTHERS.contains(&name)
}

/// Extensions that replace data; without them only a fallback, where the file has one, can be read.
const REPLACES_DATA: [&str; 2] = ["EXT_texture_avif", "MSFT_texture_dds"];

/// What becomes of a file that uses an extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// The picture shows it.
    Honoured,
    /// Not supported: the picture is made without it, with one warning, where the file allows that.
    Warned,
    /// Not supported, and the file cannot be read where it requires the extension.
    Refused,
}

/// What becomes of a file that uses the extension `name`, `required` or not.
pub fn extension_support(name: &str, required: bool) -> Support {
    match (is_honoured(name), required) {
        (true, _) => Support::Honoured,
        (false, false) => Support::Warned,
        (false, true) => Support::Refused,
    }
}

/// Refuses required extensions that are not honoured, and warns once about each optional one.
pub(super) fn check(context: &mut Context, document: &Document) -> Result<()> {
    let required = &document.root.extensions_required;
    let refused: Vec<&str> = required
        .iter()
        .map(String::as_str)
        .filter(|name| extension_support(name, true) == Support::Refused)
        .collect();
    if !refused.is_empty() {
        let message = format!(
            "the file requires {}, which {} not supported; export it without",
            refused.join(", "),
            if refused.len() == 1 { "is" } else { "are" }
        );
        return Err(context.unsupported("/extensionsRequired", message));
    }

    // Find the first place of each extension: in use, else where it is declared.
    let mut first_use = BTreeMap::new();
    collect(context, &document.value, "", &mut first_use)?;
    for (i, name) in document.root.extensions_used.iter().enumerate() {
        let declared = format!("/extensionsUsed/{i}");
        first_use.entry(name.clone()).or_insert(declared);
    }
    for (name, pointer) in first_use {
        if extension_support(&name, false) != Support::Honoured {
            let consequence = if REPLACES_DATA.contains(&name.as_str()) {
                "what it replaces is shown instead"
            } else {
                "it is ignored"
            };
            context.warn(pointer, format!("the extension {name} is not supported; {consequence}"));
        }
    }
    Ok(())
}

/// Walks all `extensions` objects; recursion is bounded by the JSON parser's depth limit.
fn collect(
    context: &mut Context,
    value: &Value,
    pointer: &str,
    first_use: &mut BTreeMap<String, String>,
) -> Result<()> {
    match value {
        Value::Array(elements) => {
            for (i, element) in elements.iter().enumerate() {
                if element.is_array() || element.is_object() {
                    collect(context, element, &format!("{pointer}/{i}"), first_use)?;
                }
            }
        }
        Value::Object(members) => {
            for (key, member) in members {
                if !(member.is_array() || member.is_object()) {
                    if key == "extensions" {
                        return Err(context.invalid(format!("{pointer}/extensions"), "must be an object"));
                    }
                    continue;
                }
                let inner = format!("{pointer}/{}", escape(key));
                if key == "extensions" {
                    note_uses(context, member, pointer, first_use);
                }
                collect(context, member, &inner, first_use)?;
            }
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
    Ok(())
}

fn note_uses(context: &mut Context, value: &Value, owner: &str, first_use: &mut BTreeMap<String, String>) {
    for (name, content) in value.as_object().into_iter().flatten() {
        let pointer = format!("{owner}/extensions/{}", escape(name));
        if is_honoured(name) && !belongs(name, owner) {
            context.warn(&pointer, format!("{name} has no meaning at this place; it is ignored here"));
        }
        if !(content.is_object() || is_honoured(name)) {
            context.warn(&pointer, format!("{name} is not an object as extensions must be"));
        }
        first_use.entry(name.clone()).or_insert(pointer);
    }
}

/// Whether the honoured extension `name` means something on the object at `owner`.
fn belongs(name: &str, owner: &str) -> bool {
    let depth = owner.matches('/').count();
    let in_array = |array: &str| owner.split('/').nth(1) == Some(array);
    match name {
        ANIMATION_POINTER => owner.ends_with("/target") && in_array("animations"),
        DRACO => depth == 4 && in_array("meshes"),
        EXT_MESHOPT | KHR_MESHOPT => depth == 2 && (in_array("bufferViews") || in_array("buffers")),
        IMAGE_LIGHTS => depth == 0 || (depth == 2 && in_array("scenes")),
        INSTANCING | VISIBILITY => depth == 2 && in_array("nodes"),
        TEXTURE_BASISU | TEXTURE_WEBP => depth == 2 && in_array("textures"),
        LIGHTS => depth == 0 || (depth == 2 && in_array("nodes")),
        VARIANTS => depth == 0 || (depth == 4 && in_array("meshes")),
        name if OF_MATERIALS.contains(&name) => depth == 2 && in_array("materials"),
        TEXTURE_TRANSFORM => depth > 2 && in_array("materials") && owner.ends_with("Texture"),
        _ => true,
    }
}
