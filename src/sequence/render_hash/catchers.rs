//! What the hash of a frame holds about shadow catchers.

use crate::scene::{AlphaMode, Scene, VariantIndex};

/// Number of the rule by which catchers that are not opaque catch shadows. Frames before it took them for opaque.
const COVERAGE: usize = 1;

/// Nodes, and which primitives of theirs only catch shadows as they look in `variant`.
pub(super) fn shadow_catchers(scene: &Scene, variant: Option<VariantIndex>) -> Vec<Vec<usize>> {
    let mut catchers = Vec::new();
    for (node_index, node) in scene.nodes.iter().enumerate() {
        let mesh = node.mesh.and_then(|mesh| scene.meshes.get(mesh.index()));
        for (index, primitive) in mesh.into_iter().flat_map(|mesh| &mesh.primitives).enumerate() {
            let material = scene.materials.get(primitive.material_in(variant).index());
            if let Some(material) = material.filter(|material| material.is_shadow_catcher) {
                let is_solid = material.alpha_mode == AlphaMode::Opaque;
                let rule = (!is_solid).then_some(COVERAGE);
                catchers.push([node_index, index].into_iter().chain(rule).collect());
            }
        }
    }
    catchers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, MaterialIndex, Mesh, MeshIndex, Node, Primitive};

    #[test]
    fn shadow_catchers_depend_on_the_variant() {
        let primitive = Primitive {
            material: MaterialIndex(0),
            variants: vec![(VariantIndex(1), MaterialIndex(1))],
            ..Primitive::default()
        };
        let catcher = Material { is_shadow_catcher: true, ..Material::default() };
        let mut scene = Scene {
            materials: vec![Material::default(), catcher],
            meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
            nodes: vec![Node::default(), Node { mesh: Some(MeshIndex(0)), ..Node::default() }],
            ..Scene::default()
        };
        assert!(
            shadow_catchers(&scene, None).is_empty()
                && shadow_catchers(&scene, Some(VariantIndex(0))).is_empty()
        );
        assert_eq!(shadow_catchers(&scene, Some(VariantIndex(1))), [[1, 0]]);
        // Frames of catchers that were taken for opaque are no frames of those that fade.
        scene.materials[1].alpha_mode = AlphaMode::Blend;
        assert_eq!(shadow_catchers(&scene, Some(VariantIndex(1))), [[1, 0, COVERAGE]]);
    }
}
