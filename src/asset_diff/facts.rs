//! The contents of a scene as groups of items.

mod clips;
mod file;
mod lights_and_cameras;
mod materials;
mod meshes;
pub(super) mod nodes;
mod texture_names;
mod textures;

use serde::Serialize;

use super::group_kind::GroupKind;
use super::item::{Group, Item};
use crate::scene::Scene;

/// The contents of a scene, one group for each [`GroupKind`] in its order.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct AssetFacts {
    /// The groups.
    pub groups: Vec<Group>,
}

impl AssetFacts {
    /// The contents of `scene`, which may be imported without texels.
    pub fn new(scene: &Scene) -> Self {
        let groups = [
            (GroupKind::File, vec![file::file(scene)]),
            (GroupKind::Extensions, file::extensions(scene)),
            (GroupKind::Scenes, file::scenes(scene)),
            (GroupKind::Nodes, nodes::nodes(scene)),
            (GroupKind::Meshes, meshes::meshes(scene)),
            (GroupKind::Materials, materials::materials(scene)),
            (GroupKind::Textures, textures::textures(scene)),
            (GroupKind::Variants, variants(scene)),
            (GroupKind::Clips, clips::clips(scene)),
            (GroupKind::Skins, nodes::skins(scene)),
            (GroupKind::Cameras, lights_and_cameras::cameras(scene)),
            (GroupKind::Lights, lights_and_cameras::lights(scene)),
            (GroupKind::ImageLights, lights_and_cameras::image_lights(scene)),
        ];
        Self { groups: groups.into_iter().map(|(group, items)| Group { group, items }).collect() }
    }

    /// The items of a group.
    pub fn items(&self, group: GroupKind) -> &[Item] {
        self.groups.iter().find(|found| found.group == group).map_or(&[], |group| &group.items)
    }
}

fn variants(scene: &Scene) -> Vec<Item> {
    let item = |(index, variant): (usize, &crate::scene::Variant)| {
        let name = Some(variant.name.as_str());
        Item { is_content: true, ..Item::new(name, index) }
    };
    scene.variants.iter().enumerate().map(item).collect()
}
