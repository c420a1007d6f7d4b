//! The shadow catchers that a shot names.

use std::collections::BTreeSet;

use crate::error::{Error, Result, Warning};
use crate::scene::{
    MaterialIndex, NameOrIndex, Scene, Selection, mark_shadow_catchers, mark_shadow_catching_node,
    visible_nodes,
};
use crate::settings::suggest;

/// Makes the nodes and materials of these names shadow catchers.
///
/// # Errors
/// [`Error::Setting`] for a name that the scene does not have.
pub(super) fn catch_shadows(scene: &mut Scene, names: &[String]) -> Result<()> {
    for name in names {
        if mark_shadow_catchers(scene, name) > 0 {
            continue;
        }
        if let selected @ NameOrIndex::Index(_) = NameOrIndex::parse(name)
            && let Some(node) = scene.node(&selected)
            && mark_shadow_catching_node(scene, node)
        {
            continue;
        }
        let nodes = scene.nodes.iter().filter(|node| node.mesh.is_some()).map(|node| node.name.as_deref());
        let names = nodes.chain(scene.materials.iter().map(|material| material.name.as_deref()));
        return Err(Error::setting(
            "shadow_catcher",
            format!(
                "neither a node with a mesh nor a material is called \"{}\"; {}",
                name.escape_debug(),
                suggest(name, names.flatten())
            ),
        ));
    }
    Ok(())
}

/// Warnings about names of catchers that nothing has which any of the selections renders.
pub(super) fn unrendered_catchers<'s>(
    names: &[String],
    scene: &Scene,
    selections: impl Iterator<Item = &'s Selection>,
) -> Vec<Warning> {
    if names.is_empty() {
        return Vec::new();
    }
    let mut rendered = RenderedSurfaces::default();
    for selection in selections {
        rendered.add(scene, selection);
    }
    let unrendered = names.iter().filter(|name| !rendered.has(scene, name));
    let warning = |name: &String| {
        let name = name.escape_debug();
        Warning::of_file(format!(
            "`shadow_catcher` \"{name}\" does nothing: nothing that is rendered has that name or index"
        ))
    };
    unrendered.map(warning).collect()
}

/// Indices of the nodes with meshes and of the materials of the file that are visible at any time.
#[derive(Debug, Default)]
struct RenderedSurfaces {
    nodes: BTreeSet<usize>,
    materials: BTreeSet<usize>,
}

impl RenderedSurfaces {
    fn add(&mut self, scene: &Scene, selection: &Selection) {
        for node in visible_nodes(scene, selection) {
            let mesh = scene.nodes[node.index()].mesh.and_then(|mesh| scene.meshes.get(mesh.index()));
            let Some(mesh) = mesh else { continue };
            self.nodes.insert(node.index());
            let materials = mesh.primitives.iter().map(|primitive| primitive.material_in(selection.variant));
            // Catchers of nodes have copies of materials.
            let of_file =
                materials.map(|material| scene.materials[material.index()].copy_of.unwrap_or(material));
            self.materials.extend(of_file.map(MaterialIndex::index));
        }
    }

    /// Whether anything has this name or index.
    fn has(&self, scene: &Scene, name: &str) -> bool {
        let has_name = |own: &Option<String>| own.as_deref() == Some(name);
        let by_index = match NameOrIndex::parse(name) {
            selected @ NameOrIndex::Index(_) => scene.node(&selected),
            NameOrIndex::Name(_) => None,
        };
        by_index.is_some_and(|node| self.nodes.contains(&node.index()))
            || self.nodes.iter().any(|&node| has_name(&scene.nodes[node].name))
            || self.materials.iter().any(|&material| has_name(&scene.materials[material].name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{
        Animation, AnimationIndex, AnimationTarget, CameraChanges, Channel, Interpolation, Keyframes,
        Material, Mesh, MeshIndex, Node, NodeIndex, Primitive, SelectedCamera, VariantIndex,
    };

    /// A floor of a material that variant 1 replaces, and a ball below a hidden node, which a clip shows.
    fn scene() -> Scene {
        let material = |name: &str| Material { name: Some(name.to_owned()), ..Material::default() };
        let mesh = |material, variants| {
            let primitive = Primitive { material: MaterialIndex(material), variants, ..Primitive::default() };
            Mesh { primitives: vec![primitive], ..Mesh::default() }
        };
        let node = |name: &str, mesh: Option<u32>| Node {
            name: Some(name.to_owned()),
            mesh: mesh.map(MeshIndex),
            ..Node::default()
        };
        let keyframes = Keyframes {
            times_seconds: vec![0.0, 1.0],
            values: vec![0.0, 1.0],
            width: 1,
            interpolation: Interpolation::Step,
        };
        let shown = Channel { target: AnimationTarget::Visibility(NodeIndex(1)), keyframes };
        let hidden = Node { is_hidden: true, children: vec![NodeIndex(2)], ..node("hidden", None) };
        Scene {
            materials: vec![material("wood"), material("stone"), material("red")],
            meshes: vec![mesh(0, vec![(VariantIndex(1), MaterialIndex(1))]), mesh(2, Vec::new())],
            nodes: vec![node("floor", Some(0)), hidden, node("ball", Some(1)), node("elsewhere", Some(1))],
            animations: vec![Animation { name: None, channels: vec![shown] }],
            ..Scene::default()
        }
    }

    fn selection(clips: &[u32], variant: Option<u32>) -> Selection {
        Selection {
            roots: vec![NodeIndex(0), NodeIndex(1)],
            clips: clips.iter().map(|&clip| AnimationIndex(clip)).collect(),
            camera: SelectedCamera::Auto,
            camera_changes: CameraChanges::default(),
            image_light: None,
            variant: variant.map(VariantIndex),
        }
    }

    fn unrendered(names: &[&str], selections: &[Selection]) -> Vec<String> {
        let mut scene = scene();
        let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
        catch_shadows(&mut scene, &names).unwrap();
        let warnings = unrendered_catchers(&names, &scene, selections.iter());
        let quoted = |warning: &Warning| warning.message.split('"').nth(1).unwrap().to_owned();
        warnings.iter().map(quoted).collect()
    }

    #[test]
    fn catchers_that_no_selection_renders_are_told() {
        let all = ["floor", "wood", "stone", "red", "ball", "#3"];
        let own = [selection(&[], None)];
        for name in all {
            let is_rendered = ["floor", "wood"].contains(&name);
            assert_eq!(unrendered(&[name], &own).is_empty(), is_rendered, "{name}");
        }
        assert_eq!(unrendered(&["wood", "#2"], &own), ["#2"]);
        assert_eq!(unrendered(&["wood", "stone"], &[selection(&[], Some(1))]), ["wood"]);
        // What one of several selections renders is rendered.
        let each = [selection(&[], Some(0)), selection(&[], Some(1))];
        assert!(unrendered(&["wood", "stone"], &each).is_empty());
        // A clip shows the ball.
        assert_eq!(unrendered(&["red", "ball", "elsewhere"], &[selection(&[0], None)]), ["elsewhere"]);
        // A node that catches shadows itself has a copy of its material, and of no other.
        assert!(unrendered(&["floor", "wood"], &own).is_empty());
        assert_eq!(unrendered(&["floor", "stone"], &own), ["stone"]);
        assert_eq!(unrendered(&["floor", "#0", "wood", "stone"], &[selection(&[], Some(1))]), ["wood"]);
    }
}
