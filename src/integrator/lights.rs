//! Punctual lights: which direction they shine from, how strongly, and the ray that asks what is in between
//! (`KHR_lights_punctual`).

use glam::Vec3;

use crate::frame::{Frame, PosedLight};
use crate::geometry::Ray;
use crate::scene::{Environment, Light, LightKind};

/// Light that arrives at a point if nothing is in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Incidence {
    /// Unit vector towards the light.
    pub(super) wi: Vec3,
    /// Irradiance on a surface that faces the light.
    pub(super) irradiance: Vec3,
}

/// The frame's lights times `light_scale`, then the environment's key light.
pub(super) fn gather(frame: &Frame, environment: &Environment, light_scale: f32) -> Vec<PosedLight> {
    let scaled = frame.lights.iter().cloned().map(|mut posed| {
        posed.light.intensity *= light_scale;
        posed
    });
    let key = environment.key_light().map(|key| PosedLight {
        position: Vec3::ZERO,
        direction: -key.direction_to_light,
        light: Light {
            name: None,
            color: key.irradiance,
            intensity: 1.0,
            range: None,
            kind: LightKind::Directional,
        },
    });
    scaled.chain(key).collect()
}

/// What `posed` sends to `point`; `None` where that is nothing.
pub(super) fn incidence(posed: &PosedLight, point: Vec3) -> Option<Incidence> {
    let light = &posed.light;
    let (wi, strength) = match light.kind {
        LightKind::Directional => (-posed.direction, 1.0),
        LightKind::Point => towards(posed, point)?,
        LightKind::Spot { inner_cone_radians, outer_cone_radians } => {
            let (wi, strength) = towards(posed, point)?;
            let cos = -posed.direction.dot(wi);
            (wi, strength * cone_falloff(cos, inner_cone_radians, outer_cone_radians))
        }
    };
    let irradiance = light.color * (light.intensity * strength);
    (irradiance.max_element() > 0.0).then_some(Incidence { wi, irradiance })
}

/// Direction to a light at a place, and 1/d² with the fade-out of its range.
fn towards(posed: &PosedLight, point: Vec3) -> Option<(Vec3, f32)> {
    let to_light = posed.position - point;
    let distance_squared = to_light.dot(to_light);
    if !(distance_squared > 0.0 && distance_squared.is_finite()) {
        return None;
    }
    let fade = match posed.light.range {
        Some(range) => {
            let ratio = distance_squared / (range * range);
            let fade = 1.0 - ratio * ratio;
            if fade > 0.0 { fade } else { return None }
        }
        None => 1.0,
    };
    Some((to_light / libm::sqrtf(distance_squared), fade / distance_squared))
}

/// 1 inside the inner cone, 0 outside the outer one, squared ramp of the cosine in between.
fn cone_falloff(cos: f32, inner_radians: f32, outer_radians: f32) -> f32 {
    let (cos_inner, cos_outer) = (libm::cosf(inner_radians), libm::cosf(outer_radians));
    let width = cos_inner - cos_outer;
    let scale = 1.0 / if width > 0.001 { width } else { 0.001 };
    let ramp = ((cos - cos_outer) * scale).clamp(0.0, 1.0);
    ramp * ramp
}

/// What a shadow ray of the light reaches over to end at `point`; zero where it starts there.
pub(super) fn shadow_span(posed: &PosedLight, point: Vec3) -> Vec3 {
    match posed.light.kind {
        LightKind::Directional => Vec3::ZERO,
        LightKind::Point | LightKind::Spot { .. } => point - posed.position,
    }
}

/// The ray between `end`, just off the surface, and the light. It starts at the light where the light has a place, so that
/// rays of many points share their origin.
pub(super) fn shadow_ray(posed: &PosedLight, end: Vec3) -> Ray {
    match posed.light.kind {
        LightKind::Directional => Ray::new(end, -posed.direction),
        LightKind::Point | LightKind::Spot { .. } => {
            Ray { origin: posed.position, direction: end - posed.position, t_min: 0.0, t_max: 1.0 }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(kind: LightKind, range: Option<f32>) -> PosedLight {
        let light = Light { name: None, color: Vec3::new(1.0, 0.5, 0.0), intensity: 8.0, range, kind };
        PosedLight { position: Vec3::new(0.0, 2.0, 0.0), direction: Vec3::NEG_Y, light }
    }

    #[test]
    fn a_point_light_falls_off_with_the_square() {
        // 8 cd at 2 m: 8 / 4 = 2 lux.
        let arriving = incidence(&light(LightKind::Point, None), Vec3::ZERO).unwrap();
        assert_eq!(arriving, Incidence { wi: Vec3::Y, irradiance: Vec3::new(2.0, 1.0, 0.0) });
    }

    #[test]
    fn the_range_fades_smoothly_to_nothing() {
        // d / range = 1/2: 1 − 1/16 = 15/16.
        let arriving = incidence(&light(LightKind::Point, Some(4.0)), Vec3::ZERO).unwrap();
        assert!((arriving.irradiance.x - 2.0 * 15.0 / 16.0).abs() < 1e-6);
        assert_eq!(incidence(&light(LightKind::Point, Some(2.0)), Vec3::ZERO), None);
    }

    #[test]
    fn a_spot_is_full_inside_dark_outside_and_squared_between() {
        let (inner, outer) = (0.3_f32, 0.8_f32);
        assert_eq!(cone_falloff(libm::cosf(0.2), inner, outer), 1.0);
        assert_eq!(cone_falloff(libm::cosf(0.9), inner, outer), 0.0);
        let middle = f32::midpoint(libm::cosf(inner), libm::cosf(outer));
        assert!((cone_falloff(middle, inner, outer) - 0.25).abs() < 1e-5);
        // Equal angles make a hard edge, never a division by zero.
        assert_eq!(cone_falloff(0.99, 0.5, 0.5), 1.0);
    }

    #[test]
    fn a_point_at_the_light_receives_nothing_rather_than_infinity() {
        assert_eq!(incidence(&light(LightKind::Point, None), Vec3::new(0.0, 2.0, 0.0)), None);
    }
}
