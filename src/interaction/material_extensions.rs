//! Values of glTF material extensions at a point.

use glam::{Vec2, Vec3, Vec4};

use super::texture_lookup::Lookups;
use super::{
    AnisotropySample, ClearCoatSample, IridescenceSample, MaterialSample, SheenSample, SurfacePoint, normal,
};
use crate::geometry::Facing;
use crate::scene::Encoding;
use crate::scene::{Anisotropy, ClearCoat, Iridescence, Material, TextureRef};
use crate::scene_view::SceneView;

/// Sets the values of the extensions that `material` has; other values stay as they are.
pub(super) fn add(
    textures: &Lookups<'_, '_>,
    point: &SurfacePoint<'_>,
    material: &Material,
    sample: &mut MaterialSample,
) {
    let linear = |reference: &Option<TextureRef>| textures.value(point, reference.as_ref(), Encoding::Linear);
    let srgb = |reference: &Option<TextureRef>| textures.value(point, reference.as_ref(), Encoding::Srgb);
    let colour = |reference: &Option<TextureRef>| srgb(reference).truncate();
    if let Some(specular) = &material.specular {
        sample.is_tinted = true;
        sample.specular = specular.factor * linear(&specular.texture).w;
        sample.specular_color = specular.color * colour(&specular.color_texture);
    }
    if let Some(glossiness) = &material.glossiness {
        // The texture also holds the specular colour.
        sample.roughness = 1.0 - glossiness.factor * srgb(&glossiness.texture).w;
    }
    if let Some(transmission) = &material.diffuse_transmission {
        sample.diffuse_transmission = transmission.factor * linear(&transmission.texture).w;
        sample.diffuse_transmission_color = transmission.color * colour(&transmission.color_texture);
    }
    if let Some(sheen) = &material.sheen {
        let color = sheen.color * colour(&sheen.color_texture);
        let roughness = sheen.roughness * linear(&sheen.roughness_texture).w;
        sample.sheen = (color != Vec3::ZERO).then_some(SheenSample { color, roughness });
    }
    // From within a body without glass nothing is reflected that a film could change.
    let is_within_wax = material.is_volume() && sample.thin && point.facing == Facing::Back;
    if let Some(film) = material.iridescence.as_ref().filter(|_| !is_within_wax) {
        sample.iridescence = iridescence(
            film,
            linear(&film.texture).x,
            film.thickness_texture.map(|_| linear(&film.thickness_texture).y),
        );
    }
    if let Some(anisotropy) = &material.anisotropy {
        sample.anisotropy =
            anisotropy_at(textures.view(), point, (material, anisotropy), linear(&anisotropy.texture));
    }
    if let Some(coat) = &material.clear_coat {
        let factor = coat.factor * linear(&coat.texture).x;
        let roughness = coat.roughness * linear(&coat.roughness_texture).y;
        sample.clear_coat = clear_coat(textures, point, (material, coat), factor, roughness);
    }
}

fn iridescence(film: &Iridescence, amount: f32, thickness_texel: Option<f32>) -> Option<IridescenceSample> {
    let (minimum, maximum) = (film.thickness_minimum_nm, film.thickness_maximum_nm);
    let thickness_nm = thickness_texel.map_or(maximum, |texel| minimum + (maximum - minimum) * texel);
    let factor = film.factor * amount;
    (factor > 0.0).then_some(IridescenceSample { factor, ior: film.ior, thickness_nm })
}

/// Anisotropy with its world-space direction: that of the texture, rotated counter-clockwise from the tangent. `None` where no
/// tangent is defined.
fn anisotropy_at(
    view: SceneView<'_>,
    point: &SurfacePoint<'_>,
    (material, anisotropy): (&Material, &Anisotropy),
    texel: Vec4,
) -> Option<AnisotropySample> {
    let strength = anisotropy.strength * if anisotropy.texture.is_some() { texel.z } else { 1.0 };
    if strength <= 0.0 {
        return None;
    }
    let uv_set = material.tangent_uv_set().unwrap_or(0);
    let (tangent, bitangent) = normal::tangent_frame(view, point, uv_set)?;
    let along = match anisotropy.texture {
        Some(_) => Vec2::new(2.0 * texel.x - 1.0, 2.0 * texel.y - 1.0).normalize_or(Vec2::X),
        None => Vec2::X,
    };
    let (sin, cos) = libm::sincosf(anisotropy.rotation_radians);
    let rotated = Vec2::new(along.x * cos - along.y * sin, along.x * sin + along.y * cos);
    let direction = tangent * rotated.x + bitangent * rotated.y;
    Some(AnisotropySample { strength, direction })
}

/// The clear coat at a point. Volumes are coated on their outside only.
fn clear_coat(
    textures: &Lookups<'_, '_>,
    point: &SurfacePoint<'_>,
    (material, coat): (&Material, &ClearCoat),
    factor: f32,
    roughness: f32,
) -> Option<ClearCoatSample> {
    if factor <= 0.0 || (material.is_volume() && point.facing == Facing::Back) {
        return None;
    }
    let normal = if coat.normal_texture == material.normal_texture {
        point.shading_normal
    } else {
        normal::mapped_by(textures, point, coat.normal_texture.as_ref())
    };
    Some(ClearCoatSample { factor, roughness, normal })
}

#[cfg(test)]
mod tests;
