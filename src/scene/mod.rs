//! The scene, independent of time: the content of a file after import, validated and with all defaults applied.
//!
//! A [`Scene`] is plain data. Every index is in range and every number is finite. Every node has at most one parent, and parents
//! precede children in [`Scene::node_order`]. Importers guarantee these invariants, and later modules rely on them. This module
//! reads no files and evaluates no animation.

mod animated;
mod animated_material;
mod animation;
mod camera;
mod camera_curve;
mod camera_path;
mod camera_placement;
mod content;
mod decomposed_matrix;
mod environment;
mod file_storage;
mod ground;
mod image_light;
mod index;
mod light;
mod material;
mod material_extensions;
mod memory;
mod mesh;
mod mip_blocks;
mod mip_lookup;
mod mip_maps;
mod named_kind;
mod node;
pub(crate) mod ranges;
mod resolve_clips;
mod resolve_each;
mod resolve_selection;
mod selected_camera;
mod selection;
mod selection_request;
mod shadow_catcher;
mod texture;
mod texture_ref;
mod unique_names;
mod variant;
mod view_request;
mod visible_nodes;
mod warnings;

pub use animated::{CameraProperty, ImageLightProperty, LightProperty};
pub(crate) use animated::{set_camera, set_light};
pub(crate) use animated_material::set_material;
pub use animated_material::{MaterialProperty, TextureSlot};
pub use animation::{Animation, AnimationTarget, Channel, Interpolation, Keyframes};
pub use camera::{Camera, Projection};
pub use camera_curve::{CurveKind, KeyTimes, KeyedPoint, KeyedValue};
pub use camera_path::{CameraKeys, CameraMotion, CameraPath};
pub use camera_placement::{look_along, rolled};
pub use content::{Scene, SceneRoots};
pub(crate) use decomposed_matrix::DecomposedMatrix;
pub use environment::{
    BuiltInLight, ComposedEnvironment, Environment, EnvironmentImage, EnvironmentMap, KeyLight,
};
pub(crate) use environment::{
    EnvironmentSectors, LightGrid, LookupLanes, LuminanceImage, SECTOR_COLUMNS, SECTOR_ROWS, SECTORS,
    image_bytes_for_cube, interval, prefix_sums,
};
pub use file_storage::{AssetCacheUse, FileStorage, StoredImage};
pub use ground::Ground;
pub use image_light::{CubeLevel, ImageLight, ImageLightPose};
pub use index::{
    AnimationIndex, CameraIndex, ImageIndex, ImageLightIndex, LightIndex, MaterialIndex, MeshIndex,
    NodeIndex, SkinIndex, TextureIndex, VariantIndex,
};
pub use light::{Light, LightKind};
pub use material::{AlphaMode, Material, Transmission, Volume};
pub use material_extensions::{
    Anisotropy, ClearCoat, DiffuseTransmission, Glossiness, Iridescence, Sheen, Specular,
};
pub use memory::SceneMemory;
pub use mesh::{INSIDE_OUT_COSINE, Mesh, MorphTarget, Primitive, SkinInfluences};
pub(crate) use mip_lookup::{MAX_PROBES, PROBE_SPACING, blended, level_of};
pub use mip_maps::{ImageMips, MipLevel, mip_levels};
pub(crate) use mip_maps::{mip_bytes, mip_sizes, mip_working_bytes};
pub(crate) use named_kind::NamedKind;
pub use node::{LocalTransform, Node, Skin};
pub use resolve_each::NamedSelection;
pub use selected_camera::{CameraChanges, SelectedCamera, Turntable};
pub use selection::Selection;
pub use selection_request::{CameraRequest, ClipSelection, NameOrIndex, SelectionRequest, VariantRequest};
pub use shadow_catcher::{mark_shadow_catchers, mark_shadow_catching_node};
pub use texture::{Encoding, Filter, Image, MipFilter, Sampler, Texels, Texture, WrapMode};
pub use texture_ref::{NormalTexture, OcclusionTexture, TextureRef, UvRotation, UvTransform};
pub(crate) use unique_names::{make_unique, make_unique_for_files};
pub use variant::{Variant, VariantWarning};
pub use view_request::{LensRequest, Orbit, Target, TurntableRequest, ViewRequest};
pub use visible_nodes::visible_nodes;
