//! Levels of support for extensions, and the warnings and errors about unsupported ones.

use std::collections::BTreeMap;

use serde_json::Value;

use super::context::Context;
use super::document::Document;
use super::extension_names::{
    ANIMATION_POINTER, DRACO, EXT_MESHOPT, IMAGE_LIGHTS, INSTANCING, KHR_MESHOPT, LIGHTS,
    MATERIAL_EXTENSIONS, TEXTURE_BASISU, TEXTURE_TRANSFORM, TEXTURE_WEBP, UNSUPPORTED_IMAGES, VARIANTS,
    VISIBILITY, is_supported,
};
use super::raw::{escape, shortened};
use crate::error::Result;

/// Extensions that no image shows, though files may require them: polygons, features, metadata, sound, behaviour.
const NO_EFFECT: [&str; 13] = [
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_ngon_encoding",
    "KHR_audio_emitter",
    "KHR_audio_graph",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Moves the whole scene; automatic cameras follow it.
const CESIUM_RTC: &str = "CESIUM_RTC";

/// Level of support for an extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtensionSupport {
    /// Supported: the image shows its effect.
    Supported,
    /// Unsupported, and optional or without an effect on images: the scene is rendered without it, with one warning where an image
    /// could show it.
    Ignored,
    /// Unsupported and required: the file is refused.
    Refused,
}

/// Level of support for the extension `name` in a file that requires it or not.
pub fn extension_support(name: &str, required: bool) -> ExtensionSupport {
    match (is_supported(name), required && !NO_EFFECT.contains(&name) && name != CESIUM_RTC) {
        (true, _) => ExtensionSupport::Supported,
        (false, false) => ExtensionSupport::Ignored,
        (false, true) => ExtensionSupport::Refused,
    }
}

/// Refuses unsupported required extensions and warns once about each unsupported optional one.
pub(super) fn check(context: &mut Context, document: &Document) -> Result<()> {
    let required = &document.root.extensions_required;
    let refused: Vec<&str> = required
        .iter()
        .map(String::as_str)
        .filter(|name| extension_support(name, true) == ExtensionSupport::Refused)
        .collect();
    if !refused.is_empty() {
        let message = format!(
            "the file requires {}, which {} not supported; export the file without",
            refused.join(", "),
            if refused.len() == 1 { "is" } else { "are" }
        );
        return Err(context.unsupported("/extensionsRequired", message));
    }

    // Find the first use of each extension, or else its declaration.
    let mut first_use = BTreeMap::new();
    collect(context, &document.value, "", &mut first_use)?;
    for (i, name) in document.root.extensions_used.iter().enumerate() {
        let declared = format!("/extensionsUsed/{i}");
        first_use.entry(name.clone()).or_insert(declared);
    }
    context.animates_properties = first_use.contains_key(ANIMATION_POINTER);
    for (name, pointer) in first_use {
        if !is_supported(&name) && !NO_EFFECT.contains(&name.as_str()) {
            let consequence = if UNSUPPORTED_IMAGES.contains(&name.as_str()) {
                "the fallback is used"
            } else {
                "it is ignored"
            };
            context.warn(pointer, format!("the extension {name} is not supported; {consequence}"));
        }
    }
    Ok(())
}

/// Collects all `extensions` objects, but for those inside extensions that are not supported, which may hold anything. The JSON parser's
/// depth limit bounds the recursion.
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
                let inner = format!("{pointer}/{}", shortened(&escape(key)));
                if key == "extensions" {
                    record_uses(context, member, pointer, first_use);
                    for (name, content) in member.as_object().into_iter().flatten() {
                        if is_supported(name) {
                            collect(context, content, &format!("{inner}/{}", escape(name)), first_use)?;
                        }
                    }
                } else {
                    collect(context, member, &inner, first_use)?;
                }
            }
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
    Ok(())
}

fn record_uses(context: &mut Context, value: &Value, owner: &str, first_use: &mut BTreeMap<String, String>) {
    for (name, content) in value.as_object().into_iter().flatten() {
        let pointer = format!("{owner}/extensions/{}", escape(name));
        if is_supported(name) && !applies_to(name, owner) {
            context.warn(&pointer, format!("{name} is not defined for this object; it is ignored"));
        }
        if !(content.is_object() || is_supported(name)) {
            context.warn(&pointer, format!("{name} must be an object"));
        }
        first_use.entry(name.clone()).or_insert(pointer);
    }
}

/// Whether the supported extension `name` is defined for the object at `owner`.
fn applies_to(name: &str, owner: &str) -> bool {
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
        name if MATERIAL_EXTENSIONS.contains(&name) => depth == 2 && in_array("materials"),
        TEXTURE_TRANSFORM => depth > 2 && in_array("materials") && owner.ends_with("Texture"),
        _ => true,
    }
}
