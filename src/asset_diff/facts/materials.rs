//! Materials with every property that changes how they look.

use glam::{Vec2, Vec3};

use crate::asset_diff::group_kind::GroupKind;
use crate::asset_diff::item::Item;
use crate::asset_diff::value::Value;
use crate::scene::{AlphaMode, Material, Scene, TextureRef, UvTransform};

use super::texture_names::texture_name;

/// Materials of the file, and the default one after them where a primitive needs it.
pub(super) fn materials(scene: &Scene) -> Vec<Item> {
    let Some((default, own)) = scene.materials.split_last() else {
        return Vec::new();
    };
    let mut primitives = scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let items = own.iter().enumerate();
    let mut items: Vec<_> =
        items.map(|(index, item)| material(scene, item, material_item(index, item))).collect();
    if primitives.any(|part| part.material.index() == own.len()) {
        items.push(material(scene, default, Item::new(Some("default"), own.len())));
    }
    items
}

/// The texture of each slot that has one.
pub(super) fn texture_slots(material: &Material) -> Vec<(&'static str, TextureRef)> {
    let Material { transmission, specular, glossiness, clear_coat, .. } = material;
    let Material { sheen, iridescence, anisotropy, diffuse_transmission, .. } = material;
    let slots = [
        ("base color texture", material.base_color_texture),
        ("metallic roughness texture", material.metallic_roughness_texture),
        ("normal texture", material.normal_texture.map(|map| map.texture)),
        ("occlusion texture", material.occlusion_texture.map(|map| map.texture)),
        ("emissive texture", material.emissive_texture),
        ("transmission texture", transmission.and_then(|part| part.texture)),
        ("specular texture", specular.and_then(|part| part.texture)),
        ("specular color texture", specular.and_then(|part| part.color_texture)),
        ("glossiness texture", glossiness.and_then(|part| part.texture)),
        ("clear coat texture", clear_coat.and_then(|part| part.texture)),
        ("clear coat roughness texture", clear_coat.and_then(|part| part.roughness_texture)),
        ("clear coat normal texture", clear_coat.and_then(|part| part.normal_texture).map(|map| map.texture)),
        ("sheen color texture", sheen.and_then(|part| part.color_texture)),
        ("sheen roughness texture", sheen.and_then(|part| part.roughness_texture)),
        ("iridescence texture", iridescence.and_then(|part| part.texture)),
        ("iridescence thickness texture", iridescence.and_then(|part| part.thickness_texture)),
        ("anisotropy texture", anisotropy.and_then(|part| part.texture)),
        ("diffuse transmission texture", diffuse_transmission.and_then(|part| part.texture)),
        ("diffuse transmission color texture", diffuse_transmission.and_then(|part| part.color_texture)),
    ];
    slots.into_iter().filter_map(|(name, texture)| Some((name, texture?))).collect()
}

fn material_item(index: usize, material: &Material) -> Item {
    Item::new(material.name.as_deref(), index)
}

fn material(scene: &Scene, material: &Material, mut item: Item) -> Item {
    core(&mut item, material);
    transparency(&mut item, material);
    layers(&mut item, material);
    for (slot, texture) in texture_slots(material) {
        let name = texture_name(scene, texture.texture);
        item.set(slot, Value::item(GroupKind::Textures, texture.texture.index(), name));
        if texture.uv_set != 0 {
            item.set(format!("{slot} coordinates"), Value::Text(format!("TEXCOORD_{}", texture.uv_set)));
        }
        let UvTransform { offset, rotation, scale } = texture.transform;
        if texture.transform != UvTransform::default() {
            item.set(format!("{slot} offset"), pair(offset));
            item.set(format!("{slot} rotation"), Value::degrees(rotation.radians()));
            item.set(format!("{slot} scale"), pair(scale));
        }
    }
    item
}

fn core(item: &mut Item, material: &Material) {
    item.set("base color", Value::Vector(material.base_color.to_array().to_vec()));
    item.set("metallic", Value::number(material.metallic));
    item.set("roughness", Value::number(material.roughness));
    item.set("emissive", color(material.emissive));
    let mode = match material.alpha_mode {
        AlphaMode::Opaque => "opaque",
        AlphaMode::Mask { .. } => "mask",
        AlphaMode::Blend => "blend",
    };
    item.set("alpha mode", Value::Text(mode.to_owned()));
    if let AlphaMode::Mask { cutoff } = material.alpha_mode {
        item.set("alpha cutoff", Value::number(cutoff));
    }
    item.set("double-sided", Value::Flag(material.double_sided));
    item.set("unlit", Value::Flag(material.unlit));
    item.set("index of refraction", Value::number(material.ior));
    if let Some(map) = material.normal_texture {
        item.set("normal scale", Value::number(map.scale));
    }
    if let Some(map) = material.occlusion_texture {
        item.set("occlusion strength", Value::number(map.strength));
    }
}

fn transparency(item: &mut Item, material: &Material) {
    if let Some(part) = material.transmission {
        item.set("transmission", Value::number(part.factor));
    }
    if let Some(volume) = material.volume {
        item.set("thickness", Value::number(volume.thickness));
        item.set("attenuation distance", Value::Number(volume.attenuation_distance, "m"));
        item.set("attenuation color", color(volume.attenuation_color));
    }
    if material.dispersion != 0.0 {
        item.set("dispersion", Value::number(material.dispersion));
    }
    if let Some(part) = material.diffuse_transmission {
        item.set("diffuse transmission", Value::number(part.factor));
        item.set("diffuse transmission color", color(part.color));
    }
}

fn layers(item: &mut Item, material: &Material) {
    if let Some(part) = material.specular {
        item.set("specular", Value::number(part.factor));
        item.set("specular color", color(part.color));
    }
    if let Some(part) = material.glossiness {
        item.set("glossiness", Value::number(part.factor));
    }
    if let Some(part) = material.clear_coat {
        item.set("clear coat", Value::number(part.factor));
        item.set("clear coat roughness", Value::number(part.roughness));
        if let Some(map) = part.normal_texture {
            item.set("clear coat normal scale", Value::number(map.scale));
        }
    }
    if let Some(part) = material.sheen {
        item.set("sheen color", color(part.color));
        item.set("sheen roughness", Value::number(part.roughness));
    }
    if let Some(part) = material.iridescence {
        item.set("iridescence", Value::number(part.factor));
        item.set("iridescence index of refraction", Value::number(part.ior));
        item.set("iridescence thickness minimum", Value::Number(part.thickness_minimum_nm, "nm"));
        item.set("iridescence thickness maximum", Value::Number(part.thickness_maximum_nm, "nm"));
    }
    if let Some(part) = material.anisotropy {
        item.set("anisotropy", Value::number(part.strength));
        item.set("anisotropy rotation", Value::degrees(part.rotation_radians));
    }
}

fn color(color: Vec3) -> Value {
    Value::Vector(color.to_array().to_vec())
}

fn pair(vector: Vec2) -> Value {
    Value::Vector(vector.to_array().to_vec())
}
