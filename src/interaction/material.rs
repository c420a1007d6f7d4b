//! Material values at a hit: factors times textures times vertex colours (glTF 2.0, section 3.9).

use std::cell::RefCell;

use glam::{Vec2, Vec3, Vec4};

use super::surface::corner_indices;
use super::texture_lookup::{self, Lookups, TextureProbes};
use super::{ClearCoatSample, MaterialSample, RayDifferential, SurfacePoint, material_extensions};
use crate::bvh::Hit;
use crate::frame::MeshInstance;
use crate::geometry::Ray;
use crate::scene::{AlphaMode, Encoding, Material, TextureRef};
use crate::scene_view::SceneView;

/// The surface point of a hit (see [`SurfacePoint::new`]) and all material values there.
pub fn surface_at<'a>(
    view: SceneView<'a>,
    ray: &Ray,
    hit: &Hit,
    differential: &RayDifferential,
) -> (SurfacePoint<'a>, MaterialSample) {
    let probes = RefCell::default();
    let textures = Lookups::new(view, &probes);
    let point = SurfacePoint::with_lookups(&textures, ray, hit, differential);
    let material = material_at(&textures, &point);
    (point, material)
}

/// All material values at a point.
pub fn material_values(
    view: SceneView<'_>,
    point: &SurfacePoint<'_>,
    probes: &RefCell<TextureProbes>,
) -> MaterialSample {
    material_at(&Lookups::new(view, probes), point)
}

/// Whether a material has the same values at all points without vertex colours.
pub fn is_constant(material: &Material) -> bool {
    let is_untextured = material.texture_refs().next().is_none();
    is_untextured && material.anisotropy.is_none() && material.clear_coat.is_none()
}

/// Base colour of a hit on a material without textures.
pub fn untextured_color(view: SceneView<'_>, hit: &Hit) -> Vec3 {
    let instance = view.frame.instance(hit.triangle);
    let material = &view.frame.materials[instance.material.index()];
    let corners = corner_indices(view, instance, hit.triangle);
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    (material.base_color * vertex_color(view, instance, corners, weights)).truncate()
}

pub(super) fn material_at(textures: &Lookups<'_, '_>, point: &SurfacePoint<'_>) -> MaterialSample {
    let view = textures.view();
    let material = &view.frame.materials[point.instance.material.index()];
    let lookup =
        |reference: &Option<TextureRef>, encoding| textures.value(point, reference.as_ref(), encoding);
    let base = material.base_color
        * lookup(&material.base_color_texture, base_encoding(material))
        * vertex_color(view, point.instance, point.corners, point.weights);
    let metallic_roughness = lookup(&material.metallic_roughness_texture, Encoding::Linear);
    let occlusion = material.occlusion_texture.map_or(1.0, |occlusion| {
        // Both are often channels of one image.
        let is_same = material.metallic_roughness_texture == Some(occlusion.texture);
        let texel =
            if is_same { metallic_roughness } else { lookup(&Some(occlusion.texture), Encoding::Linear) };
        let value = texel.x;
        1.0 + occlusion.strength * (value - 1.0)
    });
    let transmission = match &material.transmission {
        Some(transmission) => transmission.factor * lookup(&transmission.texture, Encoding::Linear).x,
        None => 0.0,
    };
    let mut sample = MaterialSample {
        base_color: base.truncate(),
        metallic: material.metallic * metallic_roughness.z,
        roughness: material.roughness * metallic_roughness.y,
        occlusion,
        emission: if material.unlit {
            Vec3::ZERO
        } else {
            material.emissive * lookup(&material.emissive_texture, Encoding::Srgb).truncate()
        },
        unlit: material.unlit,
        ior: material.ior,
        transmission: if material.transmits() { transmission } else { 0.0 },
        thin: !material.is_glass_volume(),
        ..MaterialSample::default()
    };
    if !material.unlit {
        material_extensions::add(textures, point, material, &mut sample);
    }
    sample
}

/// Emitted radiance of a hit below its coat, times its coverage. Textures are looked up in the full image.
pub fn emission_at(view: SceneView<'_>, hit: &Hit) -> Vec3 {
    let instance = view.frame.instance(hit.triangle);
    let material = &view.frame.materials[instance.material.index()];
    if material.unlit || material.emissive == Vec3::ZERO {
        return Vec3::ZERO;
    }
    let texture = texel_at_hit(view, hit, material.emissive_texture.as_ref(), Encoding::Srgb).truncate();
    material.emissive * texture * alpha_at(view, hit)
}

/// Emitted radiance around a hit, where halving the edges of the triangle so often leaves a part of it. Textures are looked up in a mip
/// level whose texels are at least as wide, and coverage by its mean.
pub(crate) fn emission_around(view: SceneView<'_>, hit: &Hit, halvings: u32) -> Vec3 {
    let instance = view.frame.instance(hit.triangle);
    let material = &view.frame.materials[instance.material.index()];
    let corners = corner_indices(view, instance, hit.triangle);
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    let lookup = |reference: &TextureRef, encoding| {
        let texels = longest_edge_texels(view, instance, corners, reference);
        let level = libm::log2f((texels / (1_u64 << halvings) as f32).max(1.0)).ceil() as usize;
        let [a, b, c] = instance.uvs(view.scene, reference.uv_set as usize, corners);
        let uv = a * weights[0] + b * weights[1] + c * weights[2];
        texture_lookup::sample_in_level(view.scene, reference, encoding, (uv, level))
    };
    let [color, alpha] = emission_textures(material);
    let color = color.map_or(Vec3::ONE, |reference| lookup(reference, Encoding::Srgb).truncate());
    let alpha = alpha.map_or_else(
        || alpha_at(view, hit),
        |reference| {
            let image = view.scene.textures[reference.texture.index()].image.index();
            let has_levels = !view.scene.mips[image].levels(Encoding::CoveredSrgb).is_empty();
            // Points of the full image could miss all that is visible.
            let texel = if has_levels { lookup(reference, Encoding::CoveredSrgb).w } else { 1.0 };
            let alpha = material.base_color.w * texel * vertex_color(view, instance, corners, weights).w;
            mean_coverage(material, alpha)
        },
    );
    material.emissive * color * alpha
}

/// Texels along the longest edge of a triangle, in that of the textures behind its emission which has most of them; zero without textures.
pub(crate) fn emission_texels(view: SceneView<'_>, triangle: u32) -> f32 {
    let instance = view.frame.instance(triangle);
    let material = &view.frame.materials[instance.material.index()];
    let corners = corner_indices(view, instance, triangle);
    let texels = |reference| longest_edge_texels(view, instance, corners, reference);
    emission_textures(material).into_iter().flatten().map(texels).fold(0.0, f32::max)
}

/// The textures behind the emission of a material: of its colour, and of its coverage.
fn emission_textures(material: &Material) -> [Option<&TextureRef>; 2] {
    let covering = material.base_color_texture.as_ref().filter(|_| material.alpha_mode != AlphaMode::Opaque);
    [material.emissive_texture.as_ref(), covering]
}

fn longest_edge_texels(
    view: SceneView<'_>,
    instance: &MeshInstance,
    corners: [u32; 3],
    reference: &TextureRef,
) -> f32 {
    let image = &view.scene.images[view.scene.textures[reference.texture.index()].image.index()];
    let size = Vec2::new(image.width as f32, image.height as f32);
    let [a, b, c] = instance.uvs(view.scene, reference.uv_set as usize, corners);
    let texels = |edge: Vec2| (reference.transform.of_vector(edge) * size).length();
    texels(b - a).max(texels(c - b)).max(texels(a - c))
}

/// The encoding of a material's base colour texture.
pub(super) fn base_encoding(material: &Material) -> Encoding {
    if material.alpha_mode == AlphaMode::Opaque { Encoding::Srgb } else { Encoding::CoveredSrgb }
}

/// The coat of a point.
pub fn clear_coat_at(view: SceneView<'_>, point: &SurfacePoint<'_>) -> Option<ClearCoatSample> {
    let material = &view.frame.materials[point.instance.material.index()];
    material.clear_coat.as_ref()?;
    material_values(view, point, &RefCell::default()).clear_coat
}

/// Whether a hit is on a shadow catcher.
pub fn catches_shadows(view: SceneView<'_>, hit: &Hit) -> bool {
    let instance = view.frame.instance(hit.triangle);
    view.frame.materials[instance.material.index()].is_shadow_catcher
}

/// Coverage of a hit by its alpha mode. Textures are looked up in the full image, so that camera and shadow rays agree.
pub fn alpha_at(view: SceneView<'_>, hit: &Hit) -> f32 {
    let instance = view.frame.instance(hit.triangle);
    let material = &view.frame.materials[instance.material.index()];
    if material.alpha_mode == AlphaMode::Opaque {
        return 1.0;
    }
    let corners = corner_indices(view, instance, hit.triangle);
    coverage(material, alpha_at_corners(view, instance, corners, [1.0 - hit.u - hit.v, hit.u, hit.v]))
}

/// Whether a hit stops light whatever finds it: its surface is neither glass nor partly transparent.
pub(crate) fn is_opaque_at(view: SceneView<'_>, hit: &Hit) -> bool {
    alpha_at(view, hit) >= 1.0 && !transmits_at(view, hit)
}

/// Whether the surface of a hit transmits light there: a material may be glass where its texture says so. Textures are looked up in the full image.
pub(crate) fn transmits_at(view: SceneView<'_>, hit: &Hit) -> bool {
    let material = &view.frame.materials[view.frame.instance(hit.triangle).material.index()];
    let texture = material.transmission.and_then(|transmission| transmission.texture);
    let texel = || texel_at_hit(view, hit, texture.as_ref(), Encoding::Linear);
    material.transmits() && texel().x > 0.0
}

/// The value of a texture at a hit, looked up in the full image; ones without a texture.
fn texel_at_hit(view: SceneView<'_>, hit: &Hit, texture: Option<&TextureRef>, encoding: Encoding) -> Vec4 {
    let Some(reference) = texture else { return Vec4::ONE };
    let instance = view.frame.instance(hit.triangle);
    let corners = corner_indices(view, instance, hit.triangle);
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    texel_at_corners(view, instance, (corners, weights), reference, encoding)
}

fn texel_at_corners(
    view: SceneView<'_>,
    instance: &MeshInstance,
    (corners, weights): ([u32; 3], [f32; 3]),
    reference: &TextureRef,
    encoding: Encoding,
) -> Vec4 {
    let [a, b, c] = instance.uvs(view.scene, reference.uv_set as usize, corners);
    let uv = a * weights[0] + b * weights[1] + c * weights[2];
    texture_lookup::sample_at(view.scene, reference, encoding, uv)
}

/// An estimate of the covered share of an area with this mean of alpha; positive where any of it is covered.
fn mean_coverage(material: &Material, alpha: f32) -> f32 {
    match material.alpha_mode {
        // Alpha of masks is mostly 0 or far above the cutoff.
        AlphaMode::Mask { cutoff } if cutoff > 0.0 => (alpha / (2.0 * cutoff)).clamp(0.0, 1.0),
        AlphaMode::Mask { .. } | AlphaMode::Opaque => 1.0,
        AlphaMode::Blend => alpha.clamp(0.0, 1.0),
    }
}

fn coverage(material: &Material, alpha: f32) -> f32 {
    match material.alpha_mode {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask { cutoff } => {
            // Rounding of interpolated values does not open holes.
            if alpha >= cutoff * (1.0 - 1e-6) { 1.0 } else { 0.0 }
        }
        AlphaMode::Blend => alpha.clamp(0.0, 1.0),
    }
}

fn alpha_at_corners(
    view: SceneView<'_>,
    instance: &MeshInstance,
    corners: [u32; 3],
    weights: [f32; 3],
) -> f32 {
    let material = &view.frame.materials[instance.material.index()];
    let texture = match &material.base_color_texture {
        Some(reference) => {
            texel_at_corners(view, instance, (corners, weights), reference, Encoding::Linear).w
        }
        None => 1.0,
    };
    material.base_color.w * texture * vertex_color(view, instance, corners, weights).w
}

#[inline(always)]
pub(super) fn vertex_color(
    view: SceneView<'_>,
    instance: &MeshInstance,
    corners: [u32; 3],
    weights: [f32; 3],
) -> Vec4 {
    match instance.colors(view.scene, corners) {
        Some([a, b, c]) => a * weights[0] + b * weights[1] + c * weights[2],
        None => Vec4::ONE,
    }
}
