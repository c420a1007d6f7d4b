//! Accessor formats that each use allows.
//!
//! Source: glTF 2.0 specification, sections 3.7.2.1 (attributes), 3.7.2.2 (morph targets), 3.7.3.1 (skins) and 3.11
//! (animations); `KHR_mesh_quantization`, "Extending mesh attributes" and "Extending morph target attributes".

use gltf::json::Accessor;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use ComponentType::{F32, I8, I16, U8, U16, U32};

use super::context::Context;
use super::extension_names::QUANTIZATION;
use crate::error::Result;

/// Element type and component encoding of an accessor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Format {
    pub(super) shape: Type,
    pub(super) component: ComponentType,
    pub(super) normalized: bool,
}

impl Format {
    /// The format of `accessor`, or `None` if its type or component type is unknown.
    pub(super) fn of(accessor: &Accessor) -> Option<Self> {
        match (&accessor.type_, &accessor.component_type) {
            (Checked::Valid(shape), Checked::Valid(component)) => {
                Some(Self { shape: *shape, component: component.0, normalized: accessor.normalized })
            }
            _ => None,
        }
    }
}

/// Component type, and whether it is normalized.
type Encoding = (ComponentType, bool);

/// Formats that one use of an accessor allows.
#[derive(Clone, Copy, Debug)]
pub(super) struct AllowedFormats {
    /// Name of the use, for messages.
    pub(super) what: &'static str,
    shapes: &'static [Type],
    core: &'static [Encoding],
    /// Encodings that `KHR_mesh_quantization` adds.
    quantized: &'static [Encoding],
}

const FLOAT: &[Encoding] = &[(F32, false)];
const FLOAT_OR_UNSIGNED: &[Encoding] = &[(F32, false), (U8, true), (U16, true)];
const FLOAT_OR_NORMALIZED: &[Encoding] = &[(F32, false), (U8, true), (U16, true), (I8, true), (I16, true)];
const FLOAT_OR_SIGNED: &[Encoding] = &[(F32, false), (I8, true), (I16, true)];
const ANY_NUMBER: &[Encoding] = &[
    (F32, false),
    (I8, true),
    (I16, true),
    (I8, false),
    (I16, false),
    (U8, true),
    (U16, true),
    (U8, false),
    (U16, false),
    (U32, false),
];
const SIGNED_NORMALIZED: &[Encoding] = &[(I8, true), (I16, true)];
const SIGNED: &[Encoding] = &[(I8, true), (I16, true), (I8, false), (I16, false)];
const ALL_SMALL: &[Encoding] =
    &[(I8, true), (I16, true), (I8, false), (I16, false), (U8, true), (U16, true), (U8, false), (U16, false)];

const fn allowed(
    what: &'static str,
    shapes: &'static [Type],
    core: &'static [Encoding],
    quantized: &'static [Encoding],
) -> AllowedFormats {
    AllowedFormats { what, shapes, core, quantized }
}

pub(super) const POSITION: AllowedFormats = allowed("POSITION", &[Type::Vec3], FLOAT, ALL_SMALL);
pub(super) const NORMAL: AllowedFormats = allowed("NORMAL", &[Type::Vec3], FLOAT, SIGNED_NORMALIZED);
pub(super) const TANGENT: AllowedFormats = allowed("TANGENT", &[Type::Vec4], FLOAT, SIGNED_NORMALIZED);
pub(super) const TEXCOORD: AllowedFormats = allowed("TEXCOORD", &[Type::Vec2], FLOAT_OR_UNSIGNED, ALL_SMALL);
pub(super) const COLOR: AllowedFormats = allowed("COLOR", &[Type::Vec3, Type::Vec4], FLOAT_OR_UNSIGNED, &[]);
pub(super) const JOINTS: AllowedFormats = allowed("JOINTS", &[Type::Vec4], &[(U8, false), (U16, false)], &[]);
pub(super) const WEIGHTS: AllowedFormats = allowed("WEIGHTS", &[Type::Vec4], FLOAT_OR_UNSIGNED, &[]);
pub(super) const INDICES: AllowedFormats =
    allowed("indices", &[Type::Scalar], &[(U8, false), (U16, false), (U32, false)], &[]);
pub(super) const MORPH_POSITION: AllowedFormats = allowed("a POSITION target", &[Type::Vec3], FLOAT, SIGNED);
pub(super) const MORPH_NORMAL: AllowedFormats =
    allowed("a NORMAL target", &[Type::Vec3], FLOAT, SIGNED_NORMALIZED);
pub(super) const MORPH_TANGENT: AllowedFormats =
    allowed("a TANGENT target", &[Type::Vec3], FLOAT, SIGNED_NORMALIZED);
pub(super) const MORPH_TEXCOORD: AllowedFormats =
    allowed("a TEXCOORD target", &[Type::Vec2], FLOAT_OR_NORMALIZED, SIGNED);
pub(super) const MORPH_COLOR: AllowedFormats =
    allowed("a COLOR target", &[Type::Vec3, Type::Vec4], FLOAT_OR_NORMALIZED, &[]);
pub(super) const BIND_MATRICES: AllowedFormats = allowed("inverseBindMatrices", &[Type::Mat4], FLOAT, &[]);
pub(super) const TIMES: AllowedFormats = allowed("keyframe times", &[Type::Scalar], FLOAT, &[]);
pub(super) const VECTOR_KEYS: AllowedFormats =
    allowed("translation or scale keys", &[Type::Vec3], FLOAT, &[]);
pub(super) const ROTATION_KEYS: AllowedFormats =
    allowed("rotation keys", &[Type::Vec4], FLOAT_OR_NORMALIZED, &[]);
pub(super) const WEIGHT_KEYS: AllowedFormats =
    allowed("weight keys", &[Type::Scalar], FLOAT_OR_NORMALIZED, &[]);

pub(super) const INSTANCE_VECTORS: AllowedFormats =
    allowed("TRANSLATION or SCALE of instances", &[Type::Vec3], FLOAT, &[]);
pub(super) const INSTANCE_ROTATIONS: AllowedFormats =
    allowed("ROTATION of instances", &[Type::Vec4], FLOAT_OR_SIGNED, &[]);
/// Formats of values of animated properties, by number of components less one.
pub(super) const PROPERTY_KEYS: [AllowedFormats; 4] = [
    allowed("keys of a number", &[Type::Scalar], ANY_NUMBER, &[]),
    allowed("keys of two numbers", &[Type::Vec2], ANY_NUMBER, &[]),
    allowed("keys of three numbers", &[Type::Vec3], ANY_NUMBER, &[]),
    allowed("keys of four numbers", &[Type::Vec4], ANY_NUMBER, &[]),
];
pub(super) const BOOLEAN_KEYS: AllowedFormats =
    allowed("keys of a boolean", &[Type::Scalar], &[(U8, false)], &[]);

/// Errors unless `allowed` contains the format of `accessor`; `pointer` is the JSON pointer of the reference to it.
pub(super) fn check(
    context: &Context,
    accessor: &Accessor,
    allowed: &AllowedFormats,
    quantization_declared: bool,
    pointer: &str,
) -> Result<()> {
    match mismatch(accessor, allowed, quantization_declared) {
        None => Ok(()),
        Some(message) => Err(context.invalid(pointer, message)),
    }
}

/// Why `allowed` excludes the format of `accessor`; `None` if it contains it.
pub(super) fn mismatch(
    accessor: &Accessor,
    allowed: &AllowedFormats,
    quantization_declared: bool,
) -> Option<String> {
    let Some(format) = Format::of(accessor) else {
        return Some("its accessor has an unknown componentType or type".to_owned());
    };
    let encoding = (format.component, format.normalized);
    let shape_fits = allowed.shapes.contains(&format.shape);
    if shape_fits && allowed.core.contains(&encoding) {
        return None;
    }
    let quantized = shape_fits && allowed.quantized.contains(&encoding);
    if quantized && quantization_declared {
        return None;
    }
    let is_not_normalized =
        shape_fits && !format.normalized && allowed.core.contains(&(format.component, true));
    let hint = if quantized {
        format!(" unless the file declares {QUANTIZATION}")
    } else if is_not_normalized {
        " unless its accessor is \"normalized\"".to_owned()
    } else {
        String::new()
    };
    Some(format!("{} cannot be {}{hint}", allowed.what, format_name(format)))
}

/// Describes the format in words.
pub(super) fn format_name(format: Format) -> String {
    let shape = match format.shape {
        Type::Scalar => "SCALAR",
        Type::Vec2 => "VEC2",
        Type::Vec3 => "VEC3",
        Type::Vec4 => "VEC4",
        Type::Mat2 => "MAT2",
        Type::Mat3 => "MAT3",
        Type::Mat4 => "MAT4",
    };
    let component = match format.component {
        I8 => "signed bytes",
        U8 => "unsigned bytes",
        I16 => "signed 16-bit integers",
        U16 => "unsigned 16-bit integers",
        U32 => "unsigned 32-bit integers",
        F32 => "floats",
    };
    let normalized = if format.normalized { "normalized " } else { "" };
    format!("{shape} of {normalized}{component}")
}
