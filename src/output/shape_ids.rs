//! What numbers and names the shapes of a frame go by.

use crate::frame::MeshInstance;
use crate::scene::Scene;

use super::cryptomatte::Matte;
use super::{Layer, LayerSet};

/// Numbers and names of shapes; the same in all frames of a sequence.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ShapeIds {
    objects: Vec<u32>,
    materials: Vec<u32>,
    nodes: Vec<u32>,
    object_matte: Option<Matte>,
    material_matte: Option<Matte>,
}

impl ShapeIds {
    /// Those of `shapes` that `layers` need.
    pub fn new(scene: &Scene, shapes: &[MeshInstance], layers: &LayerSet) -> Self {
        let has = |layer| layers.layers().contains(&layer);
        // Zero is nothing.
        let numbers =
            |index: fn(&MeshInstance) -> u32| shapes.iter().map(|instance| index(instance) + 1).collect();
        let (objects, materials) = (Layer::CryptoObject, Layer::CryptoMaterial);
        Self {
            objects: numbers(|instance| instance.mesh.0),
            materials: numbers(|instance| instance.material.0),
            nodes: numbers(|instance| instance.node.0),
            object_matte: has(objects).then(|| Matte::of_objects(objects.name(), scene, shapes)),
            material_matte: has(materials).then(|| Matte::of_materials(materials.name(), scene, shapes)),
        }
    }

    /// The numbers of a layer of ids, by instance.
    pub(super) fn numbers(&self, layer: Layer) -> &[u32] {
        match layer {
            Layer::ObjectId => &self.objects,
            Layer::MaterialId => &self.materials,
            Layer::NodeId => &self.nodes,
            _ => &[],
        }
    }

    /// The mattes of a layer.
    pub(super) fn matte(&self, layer: Layer) -> Option<&Matte> {
        match layer {
            Layer::CryptoObject => self.object_matte.as_ref(),
            Layer::CryptoMaterial => self.material_matte.as_ref(),
            _ => None,
        }
    }
}
