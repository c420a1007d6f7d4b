//! The time-free scene: what a file holds once it is understood, checked and with all defaults applied.
//!
//! A [`Scene`] is a value of plain data. Every index in it is in range, every number finite, every node has at most
//! one parent and parents come before children in [`Scene::node_order`]; importers guarantee it, later rooms rely on it.
//! Nothing here knows about glTF or about time.

mod animated;
mod animated_material;
mod animation;
mod camera;
mod environment;
mod image_light;
mod light;
mod material;
mod material_extensions;
mod mesh;
mod mip_maps;
mod node;
mod selection;
mod shadow_catcher;
mod texture;
mod variant;

use std::path::PathBuf;

use crate::error::Warning;

pub use animated::{CameraProperty, ImageLightProperty, LightProperty, set_camera, set_light};
pub use animated_material::{MaterialProperty, TextureSlot, set_material};
pub use animation::{Animation, AnimationTarget, Channel, Interpolation, Keyframes};
pub use camera::{Camera, Projection};
pub use environment::{
    ComposedEnvironment, Environment, EnvironmentImage, EnvironmentMap, KeyLight, columns_for_cube,
};
pub use image_light::{CubeLevel, ImageLight, ImageLightPose};
pub use light::{Light, LightKind};
pub use material::{
    AlphaMode, Material, NormalTexture, OcclusionTexture, TextureRef, Transmission, UvRotation, UvTransform,
    Volume,
};
pub use material_extensions::{
    Anisotropy, ClearCoat, DiffuseTransmission, Glossiness, Iridescence, Sheen, Specular,
};
pub use mesh::{Mesh, MorphTarget, Primitive, SkinInfluences};
pub use mip_maps::{ImageMips, MipLevel, mip_bytes, mip_levels, mip_working_bytes};
pub use node::{LocalTransform, Node, Skin};
pub use selection::{CameraRequest, ClipSelection, NameOrIndex, SelectedCamera, Selection, SelectionRequest};
pub use shadow_catcher::{mark_shadow_catchers, mark_shadow_catching_node};
pub use texture::{Encoding, Filter, Image, MipFilter, Sampler, Texels, Texture, WrapMode};
pub use variant::Variant;

macro_rules! typed_index {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);

        impl $name {
            /// The index as a subscript.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

typed_index!(
    /// Subscript of [`Scene::nodes`].
    NodeIndex
);
typed_index!(
    /// Subscript of [`Scene::meshes`].
    MeshIndex
);
typed_index!(
    /// Subscript of [`Scene::skins`].
    SkinIndex
);
typed_index!(
    /// Subscript of [`Scene::materials`].
    MaterialIndex
);
typed_index!(
    /// Subscript of [`Scene::variants`].
    VariantIndex
);
typed_index!(
    /// Subscript of [`Scene::textures`].
    TextureIndex
);
typed_index!(
    /// Subscript of [`Scene::images`].
    ImageIndex
);
typed_index!(
    /// Subscript of [`Scene::lights`].
    LightIndex
);
typed_index!(
    /// Subscript of [`Scene::image_lights`].
    ImageLightIndex
);
typed_index!(
    /// Subscript of [`Scene::cameras`].
    CameraIndex
);
typed_index!(
    /// Subscript of [`Scene::animations`].
    AnimationIndex
);

/// One of the scenes (sets of root nodes) that a file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneRoots {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Nodes without a parent that are drawn.
    pub roots: Vec<NodeIndex>,
    /// What surrounds it, where the file says so.
    pub image_light: Option<ImageLightIndex>,
}

/// Everything a file holds.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The file that was imported, for messages.
    pub path: PathBuf,
    /// Buffers and images outside the file that were read for it.
    pub files: Vec<PathBuf>,
    /// SHA-256 over the scene file and every file it names, in a fixed order.
    pub content_hash: [u8; 32],
    /// All nodes, in the file's order.
    pub nodes: Vec<Node>,
    /// All node indices, every parent before its children.
    pub node_order: Vec<NodeIndex>,
    /// The sets of roots to choose from; at least one.
    pub scenes: Vec<SceneRoots>,
    /// The set of roots that is shown unless another is asked for.
    pub default_scene: usize,
    /// Geometry.
    pub meshes: Vec<Mesh>,
    /// Skins.
    pub skins: Vec<Skin>,
    /// Materials; the last that was imported is the default of primitives without one.
    pub materials: Vec<Material>,
    /// Sets of materials to choose from; without a choice, primitives keep their own.
    pub variants: Vec<Variant>,
    /// Textures: an image and how it is sampled.
    pub textures: Vec<Texture>,
    /// Decoded images.
    pub images: Vec<Image>,
    /// Smaller copies of the images, by [`ImageIndex`]; an image without an entry has none.
    pub mips: Vec<ImageMips>,
    /// Punctual lights, placed by nodes.
    pub lights: Vec<Light>,
    /// Surroundings that the sets of roots may choose.
    pub image_lights: Vec<ImageLight>,
    /// Cameras, placed by nodes.
    pub cameras: Vec<Camera>,
    /// Animation clips.
    pub animations: Vec<Animation>,
    /// How many channels of each clip move something that is not supported and are left out.
    pub ignored_channels: Vec<usize>,
    /// How many textures the file has that no material looks up.
    pub unused_textures: usize,
    /// Format extensions that the file says it uses.
    pub extensions_used: Vec<String>,
    /// Format extensions without which the file says it cannot be understood.
    pub extensions_required: Vec<String>,
    /// What the file asks for and is not honoured.
    pub warnings: Vec<Warning>,
}
