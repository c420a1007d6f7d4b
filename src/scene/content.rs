//! The content of a scene file.

use std::collections::BTreeSet;
use std::path::PathBuf;

use glam::Mat4;

use super::{
    Animation, AnimationIndex, AssetCacheUse, Camera, CameraIndex, FileStorage, Image, ImageLight,
    ImageLightIndex, ImageMips, Light, LightIndex, LocalTransform, Material, Mesh, Node, NodeIndex,
    SceneMemory, Skin, Texture, TextureIndex, Variant, VariantWarning,
};
use crate::error::Warning;

/// A scene of the file: a set of root nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneRoots {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Root nodes of the scene.
    pub roots: Vec<NodeIndex>,
    /// Image-based light of the scene, if the file sets one.
    pub image_light: Option<ImageLightIndex>,
}

/// Content of an imported scene file.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The imported file, for messages.
    pub path: PathBuf,
    /// External buffers and images that were read.
    pub files: Vec<PathBuf>,
    /// SHA-256 over the scene file and the files that were read with it, in a fixed order. Images that no material or light uses are not read.
    pub content_hash: [u8; 32],
    /// All nodes, in the order of the file.
    pub nodes: Vec<Node>,
    /// All node indices, every parent before its children.
    pub node_order: Vec<NodeIndex>,
    /// Sets of root nodes; at least one.
    pub scenes: Vec<SceneRoots>,
    /// Index of the default scene in `scenes`.
    pub default_scene: usize,
    /// Meshes.
    pub meshes: Vec<Mesh>,
    /// Skins.
    pub skins: Vec<Skin>,
    /// Materials. The last imported one is the default material of primitives without one.
    pub materials: Vec<Material>,
    /// Material variants. Without a selected one, primitives keep their own materials.
    pub variants: Vec<Variant>,
    /// Textures: images with samplers.
    pub textures: Vec<Texture>,
    /// Decoded images.
    pub images: Vec<Image>,
    /// Mip levels of the images, by [`super::ImageIndex`]; an image without an entry has none.
    pub mips: Vec<ImageMips>,
    /// Punctual lights, referenced by nodes.
    pub lights: Vec<Light>,
    /// Image-based lights, referenced by scenes.
    pub image_lights: Vec<ImageLight>,
    /// Cameras, referenced by nodes.
    pub cameras: Vec<Camera>,
    /// Animation clips.
    pub animations: Vec<Animation>,
    /// Number of ignored channels of each clip, whose targets are not supported.
    pub ignored_channels: Vec<usize>,
    /// Number of textures of the file that nothing looks up.
    pub unused_textures: usize,
    /// Extensions that the file declares as used.
    pub extensions_used: Vec<String>,
    /// Extensions that the file declares as required.
    pub extensions_required: Vec<String>,
    /// How the file stores its content.
    pub storage: FileStorage,
    /// What the asset cache had, where one was used.
    pub asset_cache: Option<AssetCacheUse>,
    /// Memory of the content.
    pub memory: SceneMemory,
    /// Features of the file that are not honoured, whatever is rendered of it: [`Scene::warnings_of`] has those of variants.
    pub warnings: Vec<Warning>,
    /// Those of [`Scene::warnings`] that not all variants have, one for each list of variants.
    pub variant_warnings: Vec<VariantWarning>,
    /// Notes about the import that say nothing about the scene, such as a cache that cannot be written.
    pub notes: Vec<Warning>,
}

impl Scene {
    /// Name of a texture, or else of its image.
    pub fn texture_name(&self, texture: TextureIndex) -> Option<&str> {
        let texture = self.textures.get(texture.index())?;
        let image = self.images.get(texture.image.index());
        texture.name.as_deref().or_else(|| image.and_then(|image| image.name.as_deref()))
    }

    /// Name of a camera, or else of the first node that holds it.
    pub fn camera_name(&self, camera: CameraIndex) -> Option<&str> {
        let own = self.cameras.get(camera.index()).and_then(|camera| camera.name.as_deref());
        own.or_else(|| self.holder_name(|node| node.camera == Some(camera)))
    }

    /// Name of a camera, or else of the first node that holds it, or `camera2` without either.
    pub fn camera_label(&self, camera: CameraIndex) -> String {
        self.camera_name(camera).map_or_else(|| format!("camera{}", camera.index()), str::to_owned)
    }

    /// Name of a clip, or `clip2` without one.
    pub fn clip_label(&self, clip: AnimationIndex) -> String {
        let name = self.animations.get(clip.index()).and_then(|clip| clip.name.clone());
        name.unwrap_or_else(|| format!("clip{}", clip.index()))
    }

    /// Name of a material in quotes, or `#2` without one, for an id of the AOV `material_id`, which is the index plus one.
    pub fn material_of_id(&self, id: u32) -> Option<String> {
        let index = id.checked_sub(1)? as usize;
        let name = &self.materials.get(index)?.name;
        Some(name.as_ref().map_or_else(|| format!("#{index}"), |name| format!("\"{name}\"")))
    }

    /// Computes the world matrices of all nodes from their `local` transforms, parents first.
    pub(crate) fn world_matrices(&self, local: &[LocalTransform], world: &mut Vec<Mat4>) {
        world.clear();
        world.resize(self.nodes.len(), Mat4::IDENTITY);
        for &node in &self.node_order {
            let own = local[node.index()].matrix();
            world[node.index()] = match self.nodes[node.index()].parent {
                Some(parent) => world[parent.index()] * own,
                None => own,
            };
        }
    }

    /// The nodes below `roots`, these included, in no particular order.
    pub fn nodes_below(&self, roots: &[NodeIndex]) -> Vec<NodeIndex> {
        let mut nodes = roots.to_vec();
        let mut at = 0;
        while let Some(node) = nodes.get(at).and_then(|index| self.nodes.get(index.index())) {
            nodes.extend_from_slice(&node.children);
            at += 1;
        }
        nodes
    }

    /// The nodes that stand in a scene of the file, which scenes may share.
    pub fn nodes_of_scenes(&self) -> BTreeSet<NodeIndex> {
        let roots: BTreeSet<_> = self.scenes.iter().flat_map(|scene| &scene.roots).copied().collect();
        self.nodes_below(&roots.into_iter().collect::<Vec<_>>()).into_iter().collect()
    }

    /// The cameras that stand below `roots`.
    pub fn cameras_below(&self, roots: &[NodeIndex]) -> BTreeSet<CameraIndex> {
        self.nodes_below(roots).iter().filter_map(|node| self.nodes.get(node.index())?.camera).collect()
    }

    /// The cameras that stand in the default scene.
    pub fn cameras_of_default_scene(&self) -> BTreeSet<CameraIndex> {
        let roots = self.scenes.get(self.default_scene).map(|scene| scene.roots.as_slice());
        self.cameras_below(roots.unwrap_or_default())
    }

    /// Name of a light, or else of the first node that holds it.
    pub fn light_name(&self, light: LightIndex) -> Option<&str> {
        let own = self.lights.get(light.index()).and_then(|light| light.name.as_deref());
        own.or_else(|| self.holder_name(|node| node.light == Some(light)))
    }

    /// Name of the first node that `holds` something.
    pub fn holder_name(&self, holds: impl Fn(&Node) -> bool) -> Option<&str> {
        self.nodes.iter().find(|node| holds(node))?.name.as_deref()
    }
}
