//! What the hash of a frame holds about shadow catchers.

use serde_json::json;

use crate::scene::{AlphaMode, Ground, Scene, VariantIndex};

/// Number of the rule by which catchers that are not opaque catch shadows. Frames before it took them for opaque.
const COVERAGE: usize = 1;
/// Number of the rule by which the ground is mirrored below catchers. They hid its mirror images before it.
const MIRROR: usize = 1;

/// The shadow catchers as they look in `variant`, and how the ground lies below them.
pub(super) fn catchers_key(
    scene: &Scene,
    variant: Option<VariantIndex>,
    ground: Option<&Ground>,
) -> serde_json::Value {
    let catchers = shadow_catchers(scene, variant);
    let is_mirrored = ground.is_some_and(|ground| ground.is_mirror) && !catchers.is_empty();
    if is_mirrored { json!([catchers, "mirror", MIRROR]) } else { json!(catchers) }
}

/// Nodes, and which primitives of theirs only catch shadows as they look in `variant`.
fn shadow_catchers(scene: &Scene, variant: Option<VariantIndex>) -> Vec<Vec<usize>> {
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
    use glam::Vec3;

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
        // So are those that hid mirror images.
        let [plain, mirror] = [false, true].map(|is_mirror| Ground { up: Vec3::Y, height: 0.0, is_mirror });
        let key = |variant, ground| catchers_key(&scene, Some(VariantIndex(variant)), ground);
        assert_eq!(key(1, Some(&plain)), key(1, None));
        assert_ne!(key(1, Some(&mirror)), key(1, None));
        assert_eq!(key(0, Some(&mirror)), key(0, None));
    }
}
