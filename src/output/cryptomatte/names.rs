//! Unique names of objects and materials for mattes.

use std::collections::BTreeMap;

use super::hash::name_id;
use crate::error::Warning;
use crate::scene::{Scene, make_unique};

/// Names of nodes with a mesh, by node index; empty for other nodes.
pub(super) fn node_names(scene: &Scene) -> Vec<String> {
    let nodes = scene.nodes.iter().enumerate().map(|(index, node)| match node.mesh {
        Some(_) => non_empty(node.name.as_deref()).unwrap_or_else(|| format!("#{index}")),
        None => String::new(),
    });
    let mut names: Vec<_> = nodes.collect();
    make_unique(&mut names);
    names
}

/// Names of materials, by material index.
pub(super) fn material_names(scene: &Scene) -> Vec<String> {
    let last = scene.materials.len().saturating_sub(1);
    let materials = scene.materials.iter().enumerate().map(|(index, material)| {
        let unnamed = || if index == last { "default".to_owned() } else { format!("#{index}") };
        non_empty(material.name.as_deref()).unwrap_or_else(unnamed)
    });
    let mut names: Vec<_> = materials.collect();
    make_unique(&mut names);
    names
}

/// Warnings about names with equal hashes.
pub(super) fn collisions(names: &[String], what: &str) -> Vec<Warning> {
    let mut by_id = BTreeMap::<u32, &str>::new();
    let mut warnings = Vec::new();
    for name in names.iter().filter(|name| !name.is_empty()) {
        if let Some(other) = by_id.insert(name_id(name), name) {
            let message = format!(
                "Cryptomatte cannot tell the {what} \"{}\" and \"{}\" apart, whose names have the same hash; rename one",
                other.escape_debug(),
                name.escape_debug()
            );
            warnings.push(Warning::of_file(message));
        }
    }
    warnings
}

fn non_empty(name: Option<&str>) -> Option<String> {
    name.filter(|name| !name.is_empty()).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, MeshIndex, Node};

    #[test]
    fn unnamed_objects_are_named_by_index() {
        let mesh = Some(MeshIndex(0));
        let node = |name: Option<&str>, mesh| Node { name: name.map(str::to_owned), mesh, ..Node::default() };
        let scene = Scene {
            nodes: vec![
                node(Some("ball"), None),
                node(Some("ball"), mesh),
                node(None, mesh),
                node(Some(""), mesh),
                node(Some("#2"), mesh),
            ],
            materials: vec![Material::default(), Material::default()],
            ..Scene::default()
        };
        assert_eq!(node_names(&scene), ["", "ball", "#2", "#3", "#2 (2)"]);
        assert_eq!(material_names(&scene), ["#0", "default"]);
    }

    #[test]
    fn equal_hashes_are_a_warning() {
        // Found by search: both hash to 0x30cf5f63.
        let names = ["n40665", "x", "", "", "n93112"].map(str::to_owned);
        let warnings = collisions(&names, "nodes");
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].message.contains("n40665") && warnings[0].message.contains("n93112"));
        assert!(collisions(&names[..4], "nodes").is_empty());
    }
}
