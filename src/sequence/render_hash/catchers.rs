//! What the hash of a frame holds about shadow catchers.

use std::collections::BTreeSet;

use serde_json::json;

use crate::render::RenderSettings;
use crate::scene::{AlphaMode, NodeIndex, Scene, Selection, visible_nodes};

/// Number of the rule by which catchers that are not opaque catch shadows. Frames before the first took them for opaque; the second
/// takes the coverage of the selected variant.
const COVERAGE: usize = 2;
/// Number of the rule by which the ground is mirrored below catchers. They hid its mirror images before the first; tables do by the
/// second, and mirror images hold no shadows on catchers.
const MIRROR: usize = 2;

/// The shadow catchers of a selection, and how the ground lies below them.
pub(super) fn catchers_key(
    scene: &Scene,
    selection: &Selection,
    render: &RenderSettings,
) -> serde_json::Value {
    let ShadowCatchers { primitives, are_visible } = shadow_catchers(scene, selection);
    let is_mirrored =
        are_visible && render.max_depth > 0 && render.ground.is_some_and(|ground| ground.is_mirror);
    if is_mirrored { json!([primitives, "mirror", MIRROR]) } else { json!(primitives) }
}

/// The primitives that only catch shadows in the variant of a selection.
#[derive(Debug, PartialEq)]
pub(super) struct ShadowCatchers {
    /// Indices of the node and of the primitive, and the rule of its coverage if that decides about a pixel.
    pub(super) primitives: Vec<Vec<usize>>,
    /// Whether any of them is ever visible.
    are_visible: bool,
}

/// The shadow catchers of a selection. Those that it never shows are listed as well, as ever, without a rule.
pub(super) fn shadow_catchers(scene: &Scene, selection: &Selection) -> ShadowCatchers {
    let mut catchers = ShadowCatchers { primitives: Vec::new(), are_visible: false };
    if !scene.materials.iter().any(|material| material.is_shadow_catcher) {
        return catchers;
    }
    let visible: BTreeSet<NodeIndex> = visible_nodes(scene, selection).into_iter().collect();
    for (node_index, node) in scene.nodes.iter().enumerate() {
        let is_visible = visible.contains(&NodeIndex(node_index as u32));
        let mesh = node.mesh.and_then(|mesh| scene.meshes.get(mesh.index()));
        for (index, primitive) in mesh.into_iter().flat_map(|mesh| &mesh.primitives).enumerate() {
            let material = scene.materials.get(primitive.material_in(selection.variant).index());
            if let Some(material) = material.filter(|material| material.is_shadow_catcher) {
                let fades = is_visible && material.alpha_mode != AlphaMode::Opaque;
                let rule = fades.then_some(COVERAGE);
                catchers.primitives.push([node_index, index].into_iter().chain(rule).collect());
                catchers.are_visible |= is_visible;
            }
        }
    }
    catchers
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::{
        CameraChanges, Ground, Material, MaterialIndex, Mesh, MeshIndex, Node, Primitive, SelectedCamera,
        VariantIndex,
    };

    fn selection(variant: Option<u32>) -> Selection {
        Selection {
            roots: vec![NodeIndex(1)],
            clips: Vec::new(),
            camera: SelectedCamera::Auto,
            camera_changes: CameraChanges::default(),
            image_light: None,
            variant: variant.map(VariantIndex),
        }
    }

    /// A node whose material catches shadows in variant 1.
    fn scene() -> Scene {
        let primitive = Primitive {
            material: MaterialIndex(0),
            variants: vec![(VariantIndex(1), MaterialIndex(1))],
            ..Primitive::default()
        };
        let catcher = Material { is_shadow_catcher: true, ..Material::default() };
        Scene {
            materials: vec![Material::default(), catcher],
            meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
            nodes: vec![Node::default(), Node { mesh: Some(MeshIndex(0)), ..Node::default() }],
            ..Scene::default()
        }
    }

    #[test]
    fn shadow_catchers_depend_on_the_variant() {
        let mut scene = scene();
        let catchers = |scene: &Scene, variant| shadow_catchers(scene, &selection(variant)).primitives;
        assert!(catchers(&scene, None).is_empty() && catchers(&scene, Some(0)).is_empty());
        assert_eq!(catchers(&scene, Some(1)), [[1, 0]]);
        // Frames of catchers that were taken for opaque are no frames of those that fade.
        scene.materials[1].alpha_mode = AlphaMode::Blend;
        assert_eq!(catchers(&scene, Some(1)), [[1, 0, COVERAGE]]);
        // What is never visible fades nowhere.
        scene.nodes[1].is_hidden = true;
        assert_eq!(catchers(&scene, Some(1)), [[1, 0]]);
    }

    #[test]
    fn mirror_images_count_where_a_catcher_is_visible() {
        let mut scene = scene();
        let ground = |is_mirror| Some(Ground { up: Vec3::Y, height: 0.0, is_mirror });
        let key = |scene: &Scene, variant, ground, max_depth| {
            let render = RenderSettings { max_depth, ground, ..RenderSettings::default() };
            catchers_key(scene, &selection(Some(variant)), &render)
        };
        assert_eq!(key(&scene, 1, ground(false), 4), key(&scene, 1, None, 4));
        assert_ne!(key(&scene, 1, ground(true), 4), key(&scene, 1, None, 4));
        assert_eq!(key(&scene, 0, ground(true), 4), key(&scene, 0, None, 4));
        // No mirror ray is sent at depth 0.
        assert_eq!(key(&scene, 1, ground(true), 0), key(&scene, 1, None, 0));
        scene.nodes.swap(0, 1);
        assert_eq!(key(&scene, 1, ground(true), 4), key(&scene, 1, None, 4));
    }
}
