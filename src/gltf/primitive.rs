//! Primitives: attributes, triangles, and the vertex data that their materials need.
//!
//! Source: glTF 2.0 specification, section 3.7.2 (geometry).

use std::collections::BTreeSet;

use glam::{Vec2, Vec3, Vec4};
use gltf::json;
use gltf::json::mesh::Mode;
use gltf::json::validation::Checked;

use super::accessor::Data;
use super::attributes::{Attributes, Reference, missing_set};
use super::context::Context;
use super::extension_names::DRACO;
use super::raw::Raw;
use super::tangents::generate;
use super::used_vertices::select_vertices;
use super::{draco, formats, influences, morph, normals, topology, variants};
use crate::error::Result;
use crate::scene::{Material, MaterialIndex, Primitive, VariantIndex};

/// Imports one primitive. `None` for a primitive without triangles, after a warning.
pub(super) fn import_primitive(
    context: &mut Context,
    data: &Data,
    materials: &[Material],
    primitive: &json::mesh::Primitive,
    raw: &Raw,
) -> Result<Option<Primitive>> {
    let pointer = raw.pointer.clone();
    let Checked::Valid(mode) = primitive.mode else {
        return Err(context.invalid(format!("{pointer}/mode"), "must lie between 0 and 6"));
    };
    let material = material_index(context, primitive, materials, &pointer)?;
    let Some(raw_attributes) = raw.field("attributes") else {
        return Err(context.invalid(pointer, "has no attributes"));
    };
    let attributes = Attributes::new(context, data, &raw_attributes)?;
    let Some(position) = attributes.find("POSITION") else {
        context.warn(raw_attributes.pointer, "primitives without POSITION are not rendered");
        return Ok(None);
    };
    if let Some(kind) = unsupported_topology(mode) {
        context.warn(format!("{pointer}/mode"), format!("primitives that are {kind} are not rendered"));
        return Ok(None);
    }
    let compressed = match raw.extension(DRACO) {
        Some(extension) => Some(draco::decode_primitive(context, data, &attributes, primitive, &extension)?),
        None => None,
    };
    let (decoded, compressed_triangles) =
        compressed.map(|primitive| (primitive.decoded, primitive.triangles)).unzip();
    let data = &Data { decoded: decoded.as_ref().unwrap_or(data.decoded), ..*data };
    let vertex_count = count_vertices(context, data, position)?;
    attributes.check_counts(context, data, vertex_count)?;
    attributes.warn_unused(context);

    // Read the triangles, then the attributes of the vertices that they use.
    let mut triangles = match compressed_triangles {
        Some(triangles) => triangles,
        None => read_triangles(context, data, primitive, mode, vertex_count as usize, &pointer)?,
    };
    let used_vertices = select_vertices(context, &mut triangles, vertex_count as usize, &pointer)?;
    let data = &Data { vertices: used_vertices.as_deref(), ..*data };
    let positions: Vec<[f32; 3]> = data.floats_as(context, position, &formats::POSITION)?;
    let positions: Vec<Vec3> = positions.into_iter().map(Vec3::from_array).collect();
    let frames = read_tangent_frames(context, data, &attributes, &positions, &triangles)?;
    let (normals, tangents) = frames.map_or((None, None), |frames| (Some(frames.normals), frames.tangents));
    let variants = variants::of_primitive(context, data.document, raw)?;
    let used = used_materials(materials, material, &variants);
    let uv_sets = used.iter().map(|&(_, material)| super::material::uv_sets(material)).max();
    let uvs = read_uvs(context, data, &attributes, uv_sets.unwrap_or(0), positions.len() as u64)?;
    let mut imported = Primitive {
        colors: read_colors(context, data, &attributes, "COLOR_0")?,
        influences: influences::read(context, data, &attributes, &pointer)?,
        targets: morph::read(context, data, raw, (&attributes, uvs.len()), vertex_count)?,
        uvs,
        positions,
        normals,
        tangents,
        triangles,
        material,
        variants,
        ..Primitive::default()
    };
    imported.is_inside_out = normals::are_inside_out(&imported);
    add_attributes_of_materials(context, data, &mut imported, &used, &pointer)?;
    Ok(Some(imported))
}

/// The number of vertices, by that of positions.
fn count_vertices(context: &Context, data: &Data, position: &Reference) -> Result<u64> {
    let count = data.accessor(context, position.accessor, &position.pointer)?.count.0;
    if u32::try_from(count).is_err() {
        let message = format!("has {count} vertices, more than 32-bit indices can address");
        return Err(context.refused(&position.pointer, message));
    }
    Ok(count)
}

pub(super) fn unsupported_topology(mode: Mode) -> Option<&'static str> {
    match mode {
        Mode::Points => Some("points"),
        Mode::Lines | Mode::LineLoop | Mode::LineStrip => Some("lines"),
        Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => None,
    }
}

fn material_index(
    context: &Context,
    primitive: &json::mesh::Primitive,
    materials: &[Material],
    pointer: &str,
) -> Result<MaterialIndex> {
    let default = materials.len().saturating_sub(1);
    let index = match primitive.material {
        Some(material) => {
            context.check_index(material.value(), default, &format!("{pointer}/material"), "material")?
        }
        None => default,
    };
    Ok(MaterialIndex::of(index))
}

fn read_triangles(
    context: &mut Context,
    data: &Data,
    primitive: &json::mesh::Primitive,
    mode: Mode,
    vertex_count: usize,
    pointer: &str,
) -> Result<Vec<[u32; 3]>> {
    let indices = primitive.indices.map(|accessor| Reference {
        name: "indices".to_owned(),
        accessor: accessor.value(),
        pointer: format!("{pointer}/indices"),
    });
    let list = topology::read_indices(context, data, indices.as_ref(), vertex_count, pointer)?;
    let count = topology::triangle_count(mode, list.len()) as u64;
    context.charge(count.saturating_mul(size_of::<[u32; 3]>() as u64), pointer)?;
    let (triangles, unused_count) = topology::triangles(mode, &list);
    if unused_count > 0 {
        let message = "some vertices at the end do not complete a triangle; they are ignored";
        context.warn(pointer, message);
    }
    Ok(triangles)
}

/// Unit normals of vertices, and unit tangents, which there are with normals only.
struct TangentFrames {
    normals: Vec<Vec3>,
    tangents: Option<Vec<Vec4>>,
}

/// Reads the normals and tangents. Exporters write NaN where triangles have no area.
fn read_tangent_frames(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    positions: &[Vec3],
    triangles: &[[u32; 3]],
) -> Result<Option<TangentFrames>> {
    let Some(reference) = attributes.find("NORMAL") else {
        return Ok(None);
    };
    let normals: Vec<[f32; 3]> = data.floats_or_zeros_as(context, reference, &formats::NORMAL)?;
    let mut normals: Vec<Vec3> = normals.into_iter().map(Vec3::from_array).collect();
    normals::normalize(context, &mut normals, positions, triangles, &reference.pointer);
    let Some(reference) = attributes.find("TANGENT") else {
        return Ok(Some(TangentFrames { normals, tangents: None }));
    };
    let tangents: Vec<[f32; 4]> = data.floats_or_zeros_as(context, reference, &formats::TANGENT)?;
    let mut tangents: Vec<Vec4> = tangents.into_iter().map(Vec4::from_array).collect();
    normals::normalize_tangents(&mut tangents, &normals);
    Ok(Some(TangentFrames { normals, tangents: Some(tangents) }))
}

/// Reads the texture coordinates. Those beyond the first `used_sets` belong to no texture, so that their values and numbers may be wrong. Missing
/// ones before a later one that is used are zero.
fn read_uvs(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    used_sets: usize,
    vertex_count: u64,
) -> Result<Vec<Vec<Vec2>>> {
    const PREFIX: &str = "TEXCOORD_";
    let mut uvs = Vec::new();
    loop {
        let set = uvs.len();
        if let Some(reference) = attributes.find(&format!("{PREFIX}{set}")) {
            let values: Vec<[f32; 2]> = if set < used_sets {
                data.floats_as(context, reference, &formats::TEXCOORD)?
            } else {
                data.floats_or_zeros_as(context, reference, &formats::TEXCOORD)?
            };
            uvs.push(values.into_iter().map(Vec2::from_array).collect());
            continue;
        }
        let Some((later, stray)) = attributes.sets_from(PREFIX, set).min_by_key(|(number, _)| *number) else {
            return Ok(uvs);
        };
        let missing = missing_set(PREFIX, set);
        if later >= used_sets {
            context.warn(&stray.pointer, format!("{missing}, and {} is ignored", stray.name));
            return Ok(uvs);
        }
        context.warn(&stray.pointer, missing);
        uvs.push(zeros(context, vertex_count, &stray.pointer)?);
    }
}

/// A set of texture coordinates (0, 0).
fn zeros(context: &mut Context, vertex_count: u64, pointer: &str) -> Result<Vec<Vec2>> {
    let mut set = context.allocate(vertex_count, pointer)?;
    set.resize(vertex_count as usize, Vec2::ZERO);
    Ok(set)
}

/// The colours of the attribute called `name`, if there is one.
pub(super) fn read_colors(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    name: &str,
) -> Result<Option<Vec<Vec4>>> {
    let Some(reference) = attributes.find(name) else {
        return Ok(None);
    };
    let colors = data.colors_as(context, reference, &formats::COLOR, 1.0)?;
    if colors.iter().flatten().any(|value| !(0.0..=1.0).contains(value)) {
        context.warn(&reference.pointer, format!("{name} has values outside 0 to 1; they are clamped"));
    }
    Ok(Some(colors.into_iter().map(|color| Vec4::from_array(color).clamp(Vec4::ZERO, Vec4::ONE)).collect()))
}

/// The material of a primitive, and the others of its variants, each once.
fn used_materials<'m>(
    materials: &'m [Material],
    own: MaterialIndex,
    variants: &[(VariantIndex, MaterialIndex)],
) -> Vec<(MaterialIndex, &'m Material)> {
    let indices = std::iter::once(own).chain(variants.iter().map(|(_, material)| *material));
    let mut seen = BTreeSet::new();
    indices
        .filter(|index| seen.insert(*index))
        .filter_map(|index| Some((index, materials.get(index.index())?)))
        .collect()
}

/// Adds the vertex data that the materials of a primitive need, with warnings about what the file does not have.
fn add_attributes_of_materials(
    context: &mut Context,
    data: &Data,
    primitive: &mut Primitive,
    materials: &[(MaterialIndex, &Material)],
    pointer: &str,
) -> Result<()> {
    let stored_uv_sets = primitive.uvs.len();
    for &(index, material) in materials {
        let lacks = lacking_attributes(primitive, material, stored_uv_sets);
        add_material_attributes(context, primitive, material, pointer)?;
        for message in lacks {
            let variants = variants::with_material(data.document, primitive, index);
            context.warn_of_variants(&format!("{pointer}/attributes"), &message, variants);
        }
    }
    Ok(())
}

/// Adds the vertex data that a material needs: texture coordinate sets, and tangents for a normal map or an anisotropic
/// highlight.
fn add_material_attributes(
    context: &mut Context,
    primitive: &mut Primitive,
    material: &Material,
    pointer: &str,
) -> Result<()> {
    if let Some(set) = material.tangent_uv_set()
        && primitive.tangents.is_none()
        && !primitive.triangles.is_empty()
    {
        generate(context, primitive, set as usize, pointer)?;
        primitive.tangent_uv_set = primitive.tangents.is_some().then_some(set);
    }
    let vertex_count = primitive.positions.len() as u64;
    while primitive.uvs.len() < super::material::uv_sets(material) {
        primitive.uvs.push(zeros(context, vertex_count, pointer)?);
    }
    Ok(())
}

/// What a material needs and a primitive with `stored_uv_sets` in the file does not have.
fn lacking_attributes(primitive: &Primitive, material: &Material, stored_uv_sets: usize) -> Vec<String> {
    let wanted = super::material::uv_sets(material);
    // Missing coordinates of textures tell enough.
    if wanted == 0
        && material.anisotropy.is_some()
        && primitive.tangents.is_none()
        && primitive.uvs.is_empty()
    {
        let message =
            "TANGENT and TEXCOORD_0 are missing, and anisotropy has no direction without; it has no effect";
        return vec![message.to_owned()];
    }
    let missing =
        |set| format!("TEXCOORD_{set} is missing, which the material's textures need; (0, 0) is used");
    (stored_uv_sets..wanted).map(missing).collect()
}
