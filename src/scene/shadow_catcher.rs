//! Shadow catchers: surfaces on which only shadows are rendered, for compositing over a plate.

use std::collections::BTreeMap;

use super::{
    AlphaMode, AnimationTarget, Channel, Material, MaterialIndex, MaterialProperty, MeshIndex, NodeIndex,
    Scene, TextureSlot,
};

/// Makes all materials and all nodes' meshes named `name` shadow catchers. Returns their number.
///
/// A node gets a copy of its mesh with other materials, so that nodes of other names with the same mesh remain unchanged.
pub fn mark_shadow_catchers(scene: &mut Scene, name: &str) -> usize {
    let has_name = |own: &Option<String>| own.as_deref() == Some(name);
    let mut marked = 0;
    for material in scene.materials.iter_mut().filter(|material| has_name(&material.name)) {
        *material = catcher(material);
        marked += 1;
    }
    let mut copies = BTreeMap::new();
    for index in 0..scene.nodes.len() {
        let node = &scene.nodes[index];
        if let Some(mesh) = node.mesh.filter(|_| has_name(&node.name)) {
            let copy = *copies.entry(mesh.index()).or_insert_with(|| catching_copy(scene, mesh));
            scene.nodes[index].mesh = Some(copy);
            marked += 1;
        }
    }
    marked
}

/// Makes the mesh of one node a shadow catcher. Returns whether the node has a mesh.
pub fn mark_shadow_catching_node(scene: &mut Scene, node: NodeIndex) -> bool {
    let Some(mesh) = scene.nodes.get(node.index()).and_then(|node| node.mesh) else {
        return false;
    };
    scene.nodes[node.index()].mesh = Some(catching_copy(scene, mesh));
    true
}

/// The shadow-catching form of a material: only its sides and its coverage are left.
fn catcher(material: &Material) -> Material {
    let solid = Material {
        name: material.name.clone(),
        is_shadow_catcher: true,
        copy_of: material.copy_of,
        double_sided: material.double_sided,
        ..Material::default()
    };
    match material.alpha_mode {
        AlphaMode::Opaque => solid,
        alpha_mode => Material {
            alpha_mode,
            base_color: material.base_color,
            base_color_texture: material.base_color_texture,
            ..solid
        },
    }
}

/// Adds a copy of a mesh whose materials are shadow catchers in every variant.
fn catching_copy(scene: &mut Scene, mesh: MeshIndex) -> MeshIndex {
    let mut copy = scene.meshes[mesh.index()].clone();
    let mut copies = BTreeMap::new();
    let mut replace = |material: &mut MaterialIndex| {
        let index = material.index();
        *material = *copies.entry(index).or_insert_with(|| {
            let caught = catcher(&scene.materials[index]);
            let copy_of = caught.copy_of.or(Some(*material));
            scene.materials.push(Material { name: None, copy_of, ..caught });
            MaterialIndex(scene.materials.len() as u32 - 1)
        });
    };
    for primitive in &mut copy.primitives {
        replace(&mut primitive.material);
        primitive.variants.iter_mut().for_each(|(_, material)| replace(material));
    }
    scene.meshes.push(copy);
    let copied = MeshIndex(scene.meshes.len() as u32 - 1);
    animate_copy(scene, (mesh, copied), &copies);
    copied
}

/// Makes clips drive the copy of a mesh and its new materials as they drive the mesh and its own.
fn animate_copy(
    scene: &mut Scene,
    (mesh, copied): (MeshIndex, MeshIndex),
    copies: &BTreeMap<usize, MaterialIndex>,
) {
    let materials = &scene.materials;
    let target_of_copy = |target: AnimationTarget| match target {
        AnimationTarget::MeshWeights(own) if own == mesh => Some(AnimationTarget::MeshWeights(copied)),
        AnimationTarget::MeshWeight(own, weight) if own == mesh => {
            Some(AnimationTarget::MeshWeight(copied, weight))
        }
        AnimationTarget::Material(own, property) if decides_about_coverage(property) => {
            let copy = copies.get(&own.index());
            let fading = copy.filter(|copy| materials[copy.index()].alpha_mode != AlphaMode::Opaque);
            fading.map(|&copy| AnimationTarget::Material(copy, property))
        }
        _ => None,
    };
    for clip in &mut scene.animations {
        let channel_of_copy = |channel: &Channel| {
            let target = target_of_copy(channel.target)?;
            Some(Channel { target, keyframes: channel.keyframes.clone() })
        };
        let channels: Vec<Channel> = clip.channels.iter().filter_map(channel_of_copy).collect();
        clip.channels.extend(channels);
    }
}

/// Whether the coverage of a surface depends on a property of its material.
fn decides_about_coverage(property: MaterialProperty) -> bool {
    matches!(
        property,
        MaterialProperty::BaseColor
            | MaterialProperty::AlphaCutoff
            | MaterialProperty::TextureOffset(TextureSlot::BaseColor)
            | MaterialProperty::TextureRotation(TextureSlot::BaseColor)
            | MaterialProperty::TextureScale(TextureSlot::BaseColor)
    )
}

#[cfg(test)]
mod tests {
    use glam::Vec4;

    use super::*;
    use crate::scene::{
        Animation, Interpolation, Keyframes, Mesh, Node, Primitive, TextureIndex, TextureRef, UvTransform,
        VariantIndex, Volume,
    };

    fn scene() -> Scene {
        let named = |name: &str| Material {
            name: Some(name.to_owned()),
            alpha_mode: AlphaMode::Blend,
            double_sided: name == "ground",
            volume: Some(Volume {
                thickness: 1.0,
                attenuation_distance: 1.0,
                attenuation_color: glam::Vec3::ONE,
            }),
            ..Material::default()
        };
        let primitive = |material| Primitive {
            material: MaterialIndex(material),
            variants: vec![(VariantIndex(0), MaterialIndex(1))],
            ..Primitive::default()
        };
        let node =
            |name: &str| Node { name: Some(name.to_owned()), mesh: Some(MeshIndex(0)), ..Node::default() };
        let keyframes = Keyframes {
            times_seconds: vec![0.0],
            values: vec![1.0],
            width: 1,
            interpolation: Interpolation::Step,
        };
        let weights = Channel { target: AnimationTarget::MeshWeights(MeshIndex(0)), keyframes };
        Scene {
            materials: vec![named("ground"), named("ball")],
            meshes: vec![Mesh { primitives: vec![primitive(0), primitive(1)], ..Mesh::default() }],
            nodes: vec![node("floor"), node("ball")],
            animations: vec![Animation { name: None, channels: vec![weights] }],
            ..Scene::default()
        }
    }

    #[test]
    fn a_named_material_catches_everywhere() {
        let mut scene = scene();
        assert_eq!(mark_shadow_catchers(&mut scene, "ground"), 1);
        assert_eq!(scene.meshes.len(), 1);
        let ground = &scene.materials[0];
        assert!(ground.is_shadow_catcher && ground.double_sided && ground.volume.is_none());
        assert!(!scene.materials[1].is_shadow_catcher);
    }

    #[test]
    fn a_catcher_keeps_its_coverage() {
        let texture = TextureRef { texture: TextureIndex(3), uv_set: 1, transform: UvTransform::default() };
        let modes = [AlphaMode::Opaque, AlphaMode::Mask { cutoff: 0.25 }, AlphaMode::Blend];
        for alpha_mode in modes {
            let surface = Material {
                alpha_mode,
                base_color: Vec4::new(0.5, 0.5, 0.5, 0.75),
                base_color_texture: Some(texture),
                emissive_texture: Some(texture),
                ..Material::default()
            };
            let caught = catcher(&surface);
            assert_eq!((caught.alpha_mode, caught.emissive_texture), (alpha_mode, None));
            // What covers all needs no colour.
            let kept = (caught.base_color, caught.base_color_texture);
            let is_solid = alpha_mode == AlphaMode::Opaque;
            assert_eq!(kept, if is_solid { (Vec4::ONE, None) } else { (surface.base_color, Some(texture)) });
            assert_eq!(catcher(&caught), caught);
        }
    }

    #[test]
    fn clips_fade_the_catcher_of_a_node() {
        let mut scene = scene();
        let keyframes = scene.animations[0].channels[0].keyframes.clone();
        let [color, roughness] = [MaterialProperty::BaseColor, MaterialProperty::Roughness]
            .map(|property| AnimationTarget::Material(MaterialIndex(0), property));
        scene.animations[0].channels =
            [color, roughness].map(|target| Channel { target, keyframes: keyframes.clone() }).to_vec();
        let targets = |scene: &Scene| -> Vec<_> {
            scene.animations[0].channels.iter().map(|channel| channel.target).collect()
        };
        let mut solid = scene.clone();
        mark_shadow_catchers(&mut scene, "floor");
        let copied = scene.meshes[1].primitives[0].material;
        let faded = AnimationTarget::Material(copied, MaterialProperty::BaseColor);
        assert_eq!(targets(&scene), [color, roughness, faded]);
        solid.materials[0].alpha_mode = AlphaMode::Opaque;
        mark_shadow_catchers(&mut solid, "floor");
        assert_eq!(targets(&solid), [color, roughness]);
    }

    #[test]
    fn a_node_catches_by_the_coverage_of_each_variant() {
        let mut scene = scene();
        scene.materials[1].alpha_mode = AlphaMode::Mask { cutoff: 0.25 };
        mark_shadow_catchers(&mut scene, "floor");
        let material_in = |variant: Option<u32>| {
            let primitive = &scene.meshes[1].primitives[0];
            &scene.materials[primitive.material_in(variant.map(VariantIndex)).index()]
        };
        for (variant, of, alpha_mode) in
            [(None, 0, AlphaMode::Blend), (Some(0), 1, AlphaMode::Mask { cutoff: 0.25 })]
        {
            let material = material_in(variant);
            assert!(material.is_shadow_catcher && material.name.is_none());
            assert_eq!((material.alpha_mode, material.copy_of), (alpha_mode, Some(MaterialIndex(of))));
        }
        // One copy of each.
        assert_eq!(scene.materials.len(), 4);
    }

    #[test]
    fn nodes_of_one_name_share_the_copy_of_their_mesh() {
        let mut scene = scene();
        let floor = scene.nodes[0].clone();
        scene.nodes.extend([floor.clone(), floor]);
        assert_eq!(mark_shadow_catchers(&mut scene, "floor"), 3);
        let meshes: Vec<_> = scene.nodes.iter().map(|node| node.mesh.unwrap().index()).collect();
        assert_eq!((meshes, scene.meshes.len()), (vec![1, 0, 1, 1], 2));
        // Two materials and their copies, and the animated weights of the mesh and of its copy
        assert_eq!((scene.materials.len(), scene.animations[0].channels.len()), (4, 2));
    }

    #[test]
    fn a_named_node_catches_and_others_with_its_mesh_do_not() {
        let mut scene = scene();
        assert_eq!(mark_shadow_catchers(&mut scene, "floor"), 1);
        let catches = |scene: &Scene, node: usize| {
            let mesh = scene.nodes[node].mesh.unwrap();
            let primitives = &scene.meshes[mesh.index()].primitives;
            primitives.iter().all(|primitive| scene.materials[primitive.material.index()].is_shadow_catcher)
        };
        assert!(catches(&scene, 0) && !catches(&scene, 1));
        let mesh = scene.nodes[0].mesh.unwrap();
        // Animated weights of the mesh also drive the copy.
        let moved: Vec<_> = scene.animations[0].channels.iter().map(|channel| channel.target).collect();
        assert_eq!(moved, [AnimationTarget::MeshWeights(MeshIndex(0)), AnimationTarget::MeshWeights(mesh)]);
        // A name of both a node and a material marks both.
        assert_eq!(mark_shadow_catchers(&mut scene, "ball"), 2);
        assert_eq!(mark_shadow_catchers(&mut scene, "nobody"), 0);
        let mut other = super::tests::scene();
        assert!(mark_shadow_catching_node(&mut other, NodeIndex(0)));
        assert!(catches(&other, 0) && !catches(&other, 1));
        assert!(!mark_shadow_catching_node(&mut other, NodeIndex(2)));
    }
}
