//! JSON document: parsed with a depth limit, repaired where exporters deviate unambiguously, then typed.

use std::path::Path;

use gltf::json::{Asset, Root};
use serde::de::DeserializeOwned;
use serde_json::{Map, Number, Value};
use serde_path_to_error::Segment;

use super::context::Context;
use super::extension_names::is_supported;
use super::raw::{Raw, escape, shortened};
use crate::error::{Result, json_error_text};

/// Placeholder for the missing node of an animation channel.
pub(super) const NO_NODE: usize = u32::MAX as usize;

/// Parsed document, typed and as raw JSON.
#[derive(Debug)]
pub(super) struct Document {
    /// Typed core objects.
    pub(super) root: Root,
    /// Repaired JSON, for extensions and for members that the types do not model.
    pub(super) value: Value,
}

impl Document {
    /// Parses JSON text.
    pub(super) fn parse(context: &mut Context, json: &[u8]) -> Result<Self> {
        let text =
            std::str::from_utf8(json).map_err(|_| context.invalid("", not_text_message(context.path)))?;
        context.charge(parsed_bytes(json), "")?;
        // serde_json limits the nesting depth, so walking the value cannot overflow the stack.
        let mut value: Value = serde_json::from_str(text)
            .map_err(|error| context.invalid("", invalid_json_message(text, &error)))?;
        if !value.is_object() {
            return Err(context.invalid("", "is not a glTF file: the JSON is not an object"));
        }
        normalize(context, &mut value, "");
        repair_scenes(&mut value);
        repair_channels(context, &mut value)?;
        let root = typed_root(context, &value)?;
        check_version(context, &root.asset)?;
        Ok(Self { root, value })
    }

    /// Whether the file uses or requires the extension `name`.
    pub(super) fn uses(&self, name: &str) -> bool {
        let Root { extensions_used, extensions_required, .. } = &self.root;
        extensions_used.iter().chain(extensions_required).any(|used| used == name)
    }

    /// JSON of element `index` of the top-level array `array`.
    pub(super) fn element(&self, array: &str, index: usize) -> Option<Raw<'_>> {
        Raw::at(&self.value, format!("/{array}/{index}"))
    }
}

/// Message for a file that is not UTF-8 text.
fn not_text_message(path: &Path) -> String {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let hint =
        if extension == "hdr" || extension == "exr" { " (pass an environment with `env`)" } else { "" };
    format!("is not a glTF file; name a .glb or .gltf{hint}")
}

/// Message for text that is not valid JSON.
fn invalid_json_message(text: &str, error: &serde_json::Error) -> String {
    if text.trim_start().starts_with('{') {
        format!("is not valid JSON: {error}")
    } else {
        format!("is not a glTF file: it is not valid JSON ({error}); name a .glb or .gltf")
    }
}

/// Estimated memory of JSON text once parsed and typed, bytes, rounded up. Small objects grow most. Strings, such as `data:` URIs, are in the
/// values and in the typed objects.
fn parsed_bytes(json: &[u8]) -> u64 {
    const COPIES_OF_STRINGS: u64 = 2;
    const OBJECT_BYTES: u64 = 1024;
    const ARRAY_BYTES: u64 = 160;
    const VALUE_BYTES: u64 = 64;
    let (mut objects, mut arrays, mut values) = (0_u64, 0_u64, 0_u64);
    for byte in json {
        objects = objects.saturating_add(u64::from(*byte == b'{'));
        arrays = arrays.saturating_add(u64::from(*byte == b'['));
        values = values.saturating_add(u64::from(*byte == b','));
    }
    objects
        .saturating_mul(OBJECT_BYTES)
        .saturating_add(arrays.saturating_mul(ARRAY_BYTES))
        .saturating_add(values.saturating_mul(VALUE_BYTES))
        .saturating_add(COPIES_OF_STRINGS.saturating_mul(json.len() as u64))
}

/// Turns integers written as `3.0` or `3e0` into JSON integers, and removes the application-specific `extras` and members that are null,
/// as exporters in JavaScript write infinite numbers.
fn normalize(context: &mut Context, value: &mut Value, pointer: &str) {
    match value {
        Value::Number(number) => normalize_number(number),
        Value::Array(elements) => {
            for (i, element) in elements.iter_mut().enumerate() {
                match element {
                    Value::Number(number) => normalize_number(number),
                    Value::Array(_) | Value::Object(_) => {
                        normalize(context, element, &format!("{pointer}/{i}"));
                    }
                    Value::Null | Value::Bool(_) | Value::String(_) => {}
                }
            }
        }
        Value::Object(members) => {
            members.remove("extras");
            // Extensions that are not supported may hold anything.
            let holds_extensions = pointer.ends_with("/extensions");
            members.retain(|key, member| {
                if holds_extensions && !is_supported(key) {
                    return true;
                }
                let pointer = || format!("{pointer}/{}", shortened(&escape(key)));
                match member {
                    Value::Null => context.warn(pointer(), "is null; it counts as absent"),
                    Value::Array(_) | Value::Object(_) => normalize(context, member, &pointer()),
                    Value::Number(number) => normalize_number(number),
                    Value::Bool(_) | Value::String(_) => {}
                }
                !member.is_null()
            });
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

fn normalize_number(number: &mut Number) {
    /// Below this magnitude every integer is exact in double precision.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    if let Some(float) = number.as_f64().filter(|_| number.is_f64()) {
        let whole = float.fract() == 0.0 && float.abs() < EXACT;
        if whole && !(float == 0.0 && float.is_sign_negative()) {
            *number = Number::from(float as i64);
        }
    }
}

/// Adds a missing node list to scenes: it is optional in glTF, but required by the types.
fn repair_scenes(value: &mut Value) {
    for scene in objects(value.get_mut("scenes")) {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
}

/// Adds a placeholder for a missing node to animation channels: it is optional in glTF, but required by the types.
fn repair_channels(context: &Context, value: &mut Value) -> Result<()> {
    for (i, animation) in objects(value.get_mut("animations")).enumerate() {
        for (j, channel) in objects(animation.get_mut("channels")).enumerate() {
            let Some(Value::Object(target)) = channel.get_mut("target") else {
                continue;
            };
            if target.get("node").and_then(Value::as_u64) == Some(NO_NODE as u64) {
                let pointer = format!("/animations/{i}/channels/{j}/target/node");
                return Err(context.invalid(pointer, "there is no such node"));
            }
            target.entry("node").or_insert_with(|| Value::from(NO_NODE));
        }
    }
    Ok(())
}

fn objects(array: Option<&mut Value>) -> impl Iterator<Item = &mut Map<String, Value>> {
    array.and_then(Value::as_array_mut).into_iter().flatten().filter_map(Value::as_object_mut)
}

/// Deserializes every element separately, so that an error names the element.
fn typed_root(context: &Context, value: &Value) -> Result<Root> {
    let asset = value
        .get("asset")
        .ok_or_else(|| context.invalid("/asset", "is missing; this is not a glTF 2.0 file"))?;
    Ok(Root {
        asset: typed(context, asset, "/asset")?,
        scene: match value.get("scene") {
            Some(scene) => Some(typed(context, scene, "/scene")?),
            None => None,
        },
        accessors: elements(context, value, "accessors")?,
        animations: elements(context, value, "animations")?,
        buffers: elements(context, value, "buffers")?,
        buffer_views: elements(context, value, "bufferViews")?,
        cameras: elements(context, value, "cameras")?,
        extensions_used: elements(context, value, "extensionsUsed")?,
        extensions_required: elements(context, value, "extensionsRequired")?,
        images: elements(context, value, "images")?,
        materials: elements(context, value, "materials")?,
        meshes: elements(context, value, "meshes")?,
        nodes: elements(context, value, "nodes")?,
        samplers: elements(context, value, "samplers")?,
        scenes: elements(context, value, "scenes")?,
        skins: elements(context, value, "skins")?,
        textures: elements(context, value, "textures")?,
        ..Root::default()
    })
}

fn elements<T: DeserializeOwned>(context: &Context, value: &Value, key: &str) -> Result<Vec<T>> {
    match value.get(key) {
        None => Ok(Vec::new()),
        Some(Value::Array(array)) => array
            .iter()
            .enumerate()
            .map(|(i, element)| typed(context, element, &format!("/{key}/{i}")))
            .collect(),
        Some(_) => Err(context.invalid(format!("/{key}"), "must be an array")),
    }
}

fn typed<T: DeserializeOwned>(context: &Context, value: &Value, pointer: &str) -> Result<T> {
    T::deserialize(value).map_err(|error| {
        // Once more, to find the member: following it slows all objects down.
        let member = serde_path_to_error::deserialize::<_, T>(value).err();
        let member = member.map_or_else(String::new, |error| member_pointer(error.path()));
        context.invalid(format!("{pointer}{member}"), json_error_text(&error))
    })
}

/// The JSON pointer of a member below an object.
fn member_pointer(path: &serde_path_to_error::Path) -> String {
    let segments = path.iter().map_while(|segment| match segment {
        Segment::Seq { index } => Some(format!("/{index}")),
        Segment::Map { key } => Some(format!("/{}", escape(key))),
        Segment::Enum { .. } | Segment::Unknown => None,
    });
    segments.collect()
}

fn check_version(context: &Context, asset: &Asset) -> Result<()> {
    let version = |text: &str| -> Option<(u32, u32)> {
        let (major, minor) = text.split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    let (major, _) = version(&asset.version).ok_or_else(|| {
        context.invalid("/asset/version", format!("\"{}\" is not a version", asset.version))
    })?;
    if major != 2 {
        let message = format!("glTF {} is not supported, only 2.0; export the file again", asset.version);
        return Err(context.unsupported("/asset/version", message));
    }
    let Some(minimum) = &asset.min_version else {
        return Ok(());
    };
    match version(minimum) {
        Some(minimum) if minimum <= (2, 0) => Ok(()),
        Some(_) => Err(context.unsupported(
            "/asset/minVersion",
            format!("the file requires glTF {minimum}; only 2.0 is supported"),
        )),
        None => Err(context.invalid("/asset/minVersion", format!("\"{minimum}\" is not a version"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_count_as_values_and_as_typed_ones() {
        // Two objects, one list, and a string of 1000 characters in 1026 bytes of text.
        let json = format!("{{\"buffers\": [{{\"uri\": \"{}\"}}]}}", "a".repeat(1000));
        assert_eq!(json.len(), 1026);
        assert_eq!(parsed_bytes(json.as_bytes()), 2 * 1024 + 160 + 2 * 1026);
    }
}
