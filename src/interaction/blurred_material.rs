//! Material values around a hit, for light that many points of a surface bring together.

use glam::{Vec2, Vec3, Vec4};

use super::material::{base_encoding, vertex_color};
use super::surface::corner_indices;
use super::texture_lookup;
use crate::bvh::Hit;
use crate::scene::{Encoding, TextureRef};
use crate::scene_view::SceneView;

/// Highest mip level that is looked up.
const MAX_LEVEL: usize = 3;
/// Texels along the shorter side of that level, unless the image has fewer: the colours of palettes do not mix.
const MIN_SIDE: u32 = 16;

/// The base of a metallic-roughness material. Textures are looked up in a mip level of an eighth of their size, but of at least 16 texels a side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlurredMaterial {
    pub color: Vec3,
    pub metallic: f32,
    pub roughness: f32,
}

impl BlurredMaterial {
    /// The values around a hit.
    pub fn at(view: SceneView<'_>, hit: &Hit) -> Self {
        let instance = view.frame.instance(hit.triangle);
        let material = &view.frame.materials[instance.material.index()];
        let corners = corner_indices(view, instance, hit.triangle);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let lookup = |texture: &Option<TextureRef>, encoding| {
            texture.as_ref().map_or(Vec4::ONE, |reference| {
                let [a, b, c] = instance.uvs(view.scene, reference.uv_set as usize, corners);
                sample(view, reference, encoding, a * weights[0] + b * weights[1] + c * weights[2])
            })
        };
        let color = lookup(&material.base_color_texture, base_encoding(material));
        let metallic_roughness = lookup(&material.metallic_roughness_texture, Encoding::Linear);
        let color = material.base_color * color * vertex_color(view, instance, corners, weights);
        Self {
            color: color.truncate(),
            metallic: material.metallic * metallic_roughness.z,
            roughness: material.roughness * metallic_roughness.y,
        }
    }
}

fn sample(view: SceneView<'_>, reference: &TextureRef, encoding: Encoding, uv: Vec2) -> Vec4 {
    let image = &view.scene.images[view.scene.textures[reference.texture.index()].image.index()];
    let halvings = (image.width.min(image.height) / MIN_SIDE).checked_ilog2().unwrap_or(0);
    let level = MAX_LEVEL.min(halvings as usize);
    texture_lookup::sample_in_level(view.scene, reference, encoding, (uv, level))
}
