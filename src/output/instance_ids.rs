//! Ids and matte names of mesh instances.

use crate::frame::MeshInstance;
use crate::scene::Scene;

use super::cryptomatte::Matte;
use super::{Aov, AovSet};

/// Ids and mattes by mesh instance, the same in all frames of a sequence.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InstanceIds {
    objects: Vec<u32>,
    materials: Vec<u32>,
    nodes: Vec<u32>,
    object_matte: Option<Matte>,
    material_matte: Option<Matte>,
}

impl InstanceIds {
    /// Ids and mattes of `instances` that `aovs` need.
    pub fn new(scene: &Scene, instances: &[MeshInstance], aovs: &AovSet) -> Self {
        let has = |aov| aovs.as_slice().contains(&aov);
        // Id 0 is the background.
        let numbers =
            |index: fn(&MeshInstance) -> u32| instances.iter().map(|instance| index(instance) + 1).collect();
        let (objects, materials) = (Aov::CryptoObject, Aov::CryptoMaterial);
        Self {
            objects: numbers(|instance| instance.mesh.0),
            materials: numbers(|instance| instance.material.0),
            nodes: numbers(|instance| instance.node.0),
            object_matte: has(objects).then(|| Matte::of_objects(objects.name(), scene, instances)),
            material_matte: has(materials).then(|| Matte::of_materials(materials.name(), scene, instances)),
        }
    }

    /// Ids of an id AOV, by instance.
    pub(super) fn numbers(&self, aov: Aov) -> &[u32] {
        match aov {
            Aov::ObjectId => &self.objects,
            Aov::MaterialId => &self.materials,
            Aov::NodeId => &self.nodes,
            _ => &[],
        }
    }

    /// Matte of a Cryptomatte AOV.
    pub(super) fn matte(&self, aov: Aov) -> Option<&Matte> {
        match aov {
            Aov::CryptoObject => self.object_matte.as_ref(),
            Aov::CryptoMaterial => self.material_matte.as_ref(),
            _ => None,
        }
    }
}
