//! What is in a file, as plain data. `--json` prints it as `schema/info.schema.json` describes.

use std::collections::BTreeSet;

use serde::Serialize;

use rayframe::error::Warning;
use rayframe::gltf::{ExtensionSupport, extension_support};
use rayframe::scene::{
    AlphaMode, CameraIndex, Image, LightIndex, Material, Node, Scene, Selection, Texture, TextureIndex,
};
use rayframe::sequence::{FrameRate, duration_seconds, triangle_count};

use crate::cli::camera_text::default_camera_text;
use crate::progress::option_names;

/// The support state of what is shown as the file means it.
const SUPPORTED: &str = "supported";

/// What is in a file. Lists are in the file's order, so that `#2` on the command line is the third.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) schema: u32,
    pub(super) file: String,
    pub(super) scenes: Vec<SceneReport>,
    pub(super) nodes: usize,
    /// Nodes that draw, look or shine, which options take by name.
    pub(super) holding_nodes: Vec<NodeReport>,
    /// Named nodes without these, such as joints, which options take too.
    pub(super) other_nodes: Vec<OtherNodeReport>,
    pub(super) meshes: Vec<MeshReport>,
    pub(super) materials: Vec<MaterialReport>,
    /// Names for `--variant`.
    pub(super) variants: Vec<String>,
    pub(super) textures: Vec<TextureReport>,
    /// Textures of the file that no material looks up; they are not loaded and not listed.
    pub(super) unused_textures: usize,
    pub(super) clips: Vec<ClipReport>,
    pub(super) cameras: Vec<CameraReport>,
    pub(super) lights: Vec<LightReport>,
    pub(super) image_lights: Vec<ImageLightReport>,
    pub(super) skins: usize,
    pub(super) extensions: Vec<ExtensionReport>,
    pub(super) rendered: RenderedReport,
    /// Clips that are not rendered, and why.
    pub(super) left_out: Vec<WarningReport>,
    pub(super) not_supported: Vec<WarningReport>,
}

#[derive(Debug, Serialize)]
pub(super) struct SceneReport {
    pub(super) name: Option<String>,
    pub(super) is_default: bool,
    pub(super) triangles: u64,
}

/// A node that holds something.
#[derive(Debug, Serialize)]
pub(super) struct NodeReport {
    pub(super) index: usize,
    pub(super) name: Option<String>,
    pub(super) holds: Vec<&'static str>,
}

/// A named node that holds nothing.
#[derive(Debug, Serialize)]
pub(super) struct OtherNodeReport {
    pub(super) index: usize,
    pub(super) name: String,
}

#[derive(Debug, Serialize)]
pub(super) struct MeshReport {
    pub(super) name: Option<String>,
    pub(super) primitives: usize,
    pub(super) vertices: usize,
    pub(super) triangles: usize,
    pub(super) morph_targets: usize,
    pub(super) is_skinned: bool,
}

#[derive(Debug, Serialize)]
pub(super) struct MaterialReport {
    pub(super) name: Option<String>,
    /// Whether it is that of primitives without one; reported only where there are such.
    pub(super) is_default: bool,
    pub(super) features: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
pub(super) struct TextureReport {
    pub(super) name: Option<String>,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) bits: u32,
    pub(super) sampling: String,
    pub(super) support: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct ClipReport {
    pub(super) name: Option<String>,
    pub(super) start_seconds: f32,
    pub(super) seconds: f32,
    pub(super) channels: usize,
    /// Channels that move something which is not supported.
    pub(super) ignored_channels: usize,
    pub(super) support: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct CameraReport {
    pub(super) name: Option<String>,
    pub(super) kind: &'static str,
    pub(super) is_placed: bool,
    pub(super) support: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct LightReport {
    pub(super) name: Option<String>,
    pub(super) kind: &'static str,
    pub(super) is_placed: bool,
    pub(super) support: &'static str,
}

/// Image-based light of the file.
#[derive(Debug, Serialize)]
pub(super) struct ImageLightReport {
    pub(super) name: Option<String>,
    /// Texels along an edge of the sharpest cube.
    pub(super) size: u32,
    pub(super) levels: usize,
    /// Whether a scene of the file asks for it.
    pub(super) is_used: bool,
    pub(super) support: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct ExtensionReport {
    pub(super) name: String,
    pub(super) is_required: bool,
    pub(super) support: &'static str,
}

/// What `rayframe render` does without options.
#[derive(Debug, Serialize)]
pub(super) struct RenderedReport {
    pub(super) clips: Vec<usize>,
    pub(super) seconds: f32,
    pub(super) last_frame_at_24_fps: i64,
    pub(super) camera: String,
    /// Whether the built-in studio lights it, because the file shows no light.
    pub(super) is_lit_by_studio: bool,
    pub(super) triangles: u64,
}

#[derive(Debug, Serialize)]
pub(super) struct WarningReport {
    pub(super) pointer: String,
    pub(super) message: String,
}

impl Report {
    /// `left_out` says which clips `selection` leaves out, and why.
    pub(super) fn new(scene: &Scene, selection: &Selection, left_out: &[Warning]) -> Self {
        let seconds = duration_seconds(scene, selection);
        Self {
            schema: 2,
            file: scene.path.display().to_string(),
            scenes: scenes(scene),
            nodes: scene.nodes.len(),
            holding_nodes: holding_nodes(scene),
            other_nodes: other_nodes(scene),
            meshes: scene.meshes.iter().map(mesh).collect(),
            materials: materials(scene),
            variants: scene.variants.iter().map(|variant| variant.name.clone()).collect(),
            textures: scene
                .textures
                .iter()
                .enumerate()
                .map(|(index, item)| texture(scene, index, item))
                .collect(),
            unused_textures: scene.unused_textures,
            clips: clips(scene),
            cameras: cameras(scene),
            lights: lights(scene),
            image_lights: image_lights(scene),
            skins: scene.skins.len(),
            extensions: extensions(scene),
            rendered: RenderedReport {
                clips: selection.clips.iter().map(|clip| clip.index()).collect(),
                seconds,
                last_frame_at_24_fps: FrameRate::FILM.last_frame(seconds),
                is_lit_by_studio: selection.image_light.is_none() && !selection.has_lights(scene),
                camera: default_camera_text(scene, selection),
                triangles: triangle_count(scene, &selection.roots),
            },
            left_out: warnings(left_out),
            not_supported: warnings(&scene.warnings),
        }
    }
}

fn scenes(scene: &Scene) -> Vec<SceneReport> {
    let report = |(index, roots): (usize, &rayframe::scene::SceneRoots)| SceneReport {
        name: roots.name.clone(),
        is_default: index == scene.default_scene,
        triangles: triangle_count(scene, &roots.roots),
    };
    scene.scenes.iter().enumerate().map(report).collect()
}

/// What a node holds, in words.
fn held(node: &Node) -> Vec<&'static str> {
    let held =
        [(node.mesh.is_some(), "mesh"), (node.camera.is_some(), "camera"), (node.light.is_some(), "light")];
    held.iter().filter(|(is, _)| *is).map(|&(_, name)| name).collect()
}

fn holding_nodes(scene: &Scene) -> Vec<NodeReport> {
    let report = |(index, node): (usize, &Node)| {
        let holds = held(node);
        (!holds.is_empty()).then(|| NodeReport { index, name: node.name.clone(), holds })
    };
    scene.nodes.iter().enumerate().filter_map(report).collect()
}

fn other_nodes(scene: &Scene) -> Vec<OtherNodeReport> {
    let report = |(index, node): (usize, &Node)| {
        let name = node.name.clone().filter(|_| held(node).is_empty())?;
        Some(OtherNodeReport { index, name })
    };
    scene.nodes.iter().enumerate().filter_map(report).collect()
}

fn mesh(mesh: &rayframe::scene::Mesh) -> MeshReport {
    MeshReport {
        name: mesh.name.clone(),
        primitives: mesh.primitives.len(),
        vertices: mesh.vertex_count(),
        triangles: mesh.triangle_count(),
        morph_targets: mesh.morph_target_count(),
        is_skinned: mesh.primitives.iter().any(|part| part.influences.is_some()),
    }
}

/// All materials of the file, and the default one after them where a primitive needs it.
fn materials(scene: &Scene) -> Vec<MaterialReport> {
    let Some((last, own)) = scene.materials.split_last() else {
        return Vec::new();
    };
    let mut primitives = scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut reports: Vec<_> = own.iter().map(|item| material(item, false)).collect();
    if primitives.any(|part| part.material.index() == own.len()) {
        reports.push(material(last, true));
    }
    reports
}

fn material(material: &Material, is_default: bool) -> MaterialReport {
    let features = [
        (material.texture_refs().next().is_some(), "textured"),
        (material.emissive != glam::Vec3::ZERO, "emissive"),
        (matches!(material.alpha_mode, AlphaMode::Mask { .. }), "alpha mask"),
        (material.alpha_mode == AlphaMode::Blend, "alpha blend"),
        (material.double_sided, "double-sided"),
        (material.unlit, "unlit"),
        (material.transmission.is_some(), "transmission"),
        (material.volume.is_some_and(|volume| volume.thickness > 0.0), "volume"),
        (material.dispersion > 0.0, "dispersion"),
        (material.specular.is_some(), "specular"),
        (material.glossiness.is_some(), "specular-glossiness"),
        (material.clear_coat.is_some(), "clear coat"),
        (material.sheen.is_some(), "sheen"),
        (material.iridescence.is_some(), "iridescence"),
        (material.anisotropy.is_some(), "anisotropy"),
        (material.diffuse_transmission.is_some(), "diffuse transmission"),
    ];
    MaterialReport {
        name: material.name.clone(),
        is_default,
        features: features.iter().filter(|(is, _)| *is).map(|&(_, name)| name).collect(),
    }
}

fn texture(scene: &Scene, index: usize, texture: &Texture) -> TextureReport {
    let image = scene.images.get(texture.image.index());
    TextureReport {
        name: scene.texture_name(TextureIndex(index as u32)).map(ToOwned::to_owned),
        width: image.map_or(0, |image| image.width),
        height: image.map_or(0, |image| image.height),
        bits: image.map_or(0, Image::bits),
        sampling: texture.sampler.to_string(),
        support: SUPPORTED,
    }
}

fn clips(scene: &Scene) -> Vec<ClipReport> {
    let report = |(index, clip): (usize, &rayframe::scene::Animation)| {
        let ignored_channels = scene.ignored_channels.get(index).copied().unwrap_or(0);
        ClipReport {
            name: clip.name.clone(),
            start_seconds: clip.start_seconds(),
            seconds: clip.duration_seconds(),
            channels: clip.channels.len(),
            ignored_channels,
            support: match (clip.channels.len(), ignored_channels) {
                (_, 0) => SUPPORTED,
                (0, _) => "not supported, left out",
                _ => "supported in part",
            },
        }
    };
    scene.animations.iter().enumerate().map(report).collect()
}

fn cameras(scene: &Scene) -> Vec<CameraReport> {
    let held: BTreeSet<_> = scene.nodes.iter().filter_map(|node| node.camera).collect();
    let report = |(index, camera): (usize, &rayframe::scene::Camera)| {
        let index = CameraIndex(index as u32);
        CameraReport {
            name: scene.camera_name(index).map(ToOwned::to_owned),
            kind: camera.projection.name(),
            is_placed: held.contains(&index),
            support: SUPPORTED,
        }
    };
    scene.cameras.iter().enumerate().map(report).collect()
}

fn lights(scene: &Scene) -> Vec<LightReport> {
    let held: BTreeSet<_> = scene.nodes.iter().filter_map(|node| node.light).collect();
    let report = |(index, light): (usize, &rayframe::scene::Light)| {
        let index = LightIndex(index as u32);
        LightReport {
            name: scene.light_name(index).map(ToOwned::to_owned),
            kind: light.kind.name(),
            is_placed: held.contains(&index),
            support: SUPPORTED,
        }
    };
    scene.lights.iter().enumerate().map(report).collect()
}

fn image_lights(scene: &Scene) -> Vec<ImageLightReport> {
    let asks = |index: usize| {
        scene.scenes.iter().any(|roots| roots.image_light.is_some_and(|light| light.index() == index))
    };
    let report = |(index, light): (usize, &rayframe::scene::ImageLight)| ImageLightReport {
        name: light.name.clone(),
        size: light.levels.first().map_or(0, |level| level.size),
        levels: light.levels.len(),
        is_used: asks(index),
        support: SUPPORTED,
    };
    scene.image_lights.iter().enumerate().map(report).collect()
}

fn extensions(scene: &Scene) -> Vec<ExtensionReport> {
    let named: BTreeSet<_> = scene.extensions_used.iter().chain(&scene.extensions_required).collect();
    let report = |name: &String| {
        let is_required = scene.extensions_required.contains(name);
        ExtensionReport {
            name: name.clone(),
            is_required,
            support: match extension_support(name, is_required) {
                ExtensionSupport::Supported => "supported",
                ExtensionSupport::Ignored => "not supported, left out",
                ExtensionSupport::Refused => "not supported",
            },
        }
    };
    named.into_iter().map(report).collect()
}

fn warnings(warnings: &[Warning]) -> Vec<WarningReport> {
    let unique: BTreeSet<_> = warnings.iter().collect();
    let report = |warning: &Warning| WarningReport {
        pointer: warning.pointer.clone(),
        message: option_names(&warning.message),
    };
    unique.into_iter().map(report).collect()
}
