//! Textures that materials use, with their images.

use crate::asset_diff::item::Item;
use crate::asset_diff::value::Value;
use crate::scene::{Image, Scene, Texture, TextureIndex};

use super::materials::texture_slots;
use super::texture_names::texture_name;

/// Textures in the order of first use. Names of files count without folder and ending, which change with the format.
pub(super) fn textures(scene: &Scene) -> Vec<Item> {
    let items = scene.textures.iter().zip(uses(scene)).enumerate();
    items.map(|(index, (item, uses))| texture(scene, index, (item, uses))).collect()
}

/// Memory of an image with mip maps on a graphics processor: one byte a texel for KTX2, which stays compressed there, four for all
/// others, and a third for the mip maps.
pub(super) fn texture_memory_bytes(scene: &Scene, image: usize) -> u64 {
    let Some(Image { width, height, .. }) = scene.images.get(image) else { return 0 };
    let is_compressed = scene.storage.images.get(image).is_some_and(|image| image.format == "KTX2");
    let texels = u64::from(*width) * u64::from(*height);
    texels * if is_compressed { 1 } else { 4 } * 4 / 3
}

/// The slots that each texture fills, in the order of the materials.
fn uses(scene: &Scene) -> Vec<Vec<String>> {
    let mut uses = vec![Vec::new(); scene.textures.len()];
    for (number, material) in scene.materials.iter().enumerate() {
        let name = material.name.clone().unwrap_or_else(|| format!("#{number}"));
        for (slot, filled) in texture_slots(material) {
            if let Some(uses) = uses.get_mut(filled.texture.index()) {
                uses.push(format!("{name}: {slot}"));
            }
        }
    }
    uses
}

fn texture(scene: &Scene, index: usize, (texture, mut uses): (&Texture, Vec<String>)) -> Item {
    let mut item = Item::new(texture_name(scene, TextureIndex(index as u32)), index);
    item.alias = uses.first().cloned();
    uses.sort();
    let image = texture.image.index();
    if let Some(Image { width, height, .. }) = scene.images.get(image) {
        item.set("size", Value::Text(format!("{width}x{height}")));
    }
    if let Some(stored) = scene.storage.images.get(image) {
        item.set("format", Value::Text(stored.format.to_owned()));
        item.set("encoded image", Value::Bytes(stored.bytes));
    }
    item.set("memory", Value::Bytes(texture_memory_bytes(scene, image)));
    item.set("bits", Value::Count(scene.images.get(image).map_or(0, |image| image.bits().into())));
    item.set("sampling", Value::Text(texture.sampler.to_string()));
    item.set("uses", Value::List(uses));
    item
}
