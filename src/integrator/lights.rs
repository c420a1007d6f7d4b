//! Punctual lights (`KHR_lights_punctual`) and the environment's key light: direction, irradiance and shadow ray at a point.

use glam::{Vec2, Vec3};

use super::light_pass::LightPass;
use super::random::{Purpose, Seed};
use super::settings::{Integrator, IntegratorSettings, LightSize};
use crate::frame::{Frame, PosedLight};
use crate::geometry::{LANES, Ray, Vec3Lanes, concentric_disk_point, sin_cos_of_turn};
use crate::scene::{Environment, KeyLight, LightKind};

/// A light with everything precomputed that does not depend on the lit point.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PreparedLight {
    color: Vec3,
    intensity: f32,
    emitter: Emitter,
    size: LightSize,
    /// Whether the light is a peak of the environment, which rays see, too.
    is_peak: bool,
}

/// Geometry of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Emitter {
    /// Parallel light from the unit vector `wi`.
    Distant { wi: Vec3 },
    /// A spot light with its cone, or a point light, whose cone is everywhere. The range may be infinite.
    Point { position: Vec3, range: f32, cone: Cone },
}

/// The cone of a spot light. By the cosine of the angle from its axis, the falloff is 1 inside the inner cone, 0 outside the outer
/// one, and the square of a linear ramp in between.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cone {
    /// Unit vector of the light's direction.
    axis: Vec3,
    cos_outer: f32,
    /// Slope of the ramp over the cosine.
    slope: f32,
}

/// Unoccluded light at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Incidence {
    /// Unit vector towards the light.
    pub(super) wi: Vec3,
    /// Irradiance of a surface that faces the light; zero beyond its range and cone.
    pub(super) irradiance: Vec3,
    /// Vector from the start of a shadow ray to the point; zero for distant lights, whose shadow rays start at the point.
    pub(super) span: Vec3,
}

impl Incidence {
    /// No light.
    pub(super) const NONE: Self = Self { wi: Vec3::Z, irradiance: Vec3::ZERO, span: Vec3::ZERO };
}

/// A sampled point of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightSample {
    /// Unit vector towards it.
    pub(super) wi: Vec3,
    /// Irradiance of a surface that faces it, over the density of the sample.
    pub(super) irradiance: Vec3,
    /// The point; `None` for distant lights.
    position: Option<Vec3>,
}

impl LightSample {
    /// The light without the point.
    pub(super) fn incidence(self) -> Incidence {
        Incidence { wi: self.wi, irradiance: self.irradiance, span: Vec3::ZERO }
    }

    /// Whether the light is beyond all surfaces.
    pub(super) fn is_distant(&self) -> bool {
        self.position.is_none()
    }

    /// Vector from the start of a shadow ray to the lit point.
    pub(super) fn span(&self, point: Vec3) -> Vec3 {
        self.position.map_or(Vec3::ZERO, |position| point - position)
    }

    /// The shadow ray between `end`, just off the surface, and the point of the light.
    pub(super) fn shadow_ray(&self, end: Vec3) -> Ray {
        match self.position {
            Some(origin) => ray_between(origin, end),
            None => Ray::new(end, self.wi),
        }
    }
}

/// Unoccluded light at the points of a block.
#[derive(Debug, Default)]
pub(super) struct IncidenceLanes {
    wi: Vec3Lanes,
    irradiance: Vec3Lanes,
    span: Vec3Lanes,
}

impl IncidenceLanes {
    /// The light at a point.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> Incidence {
        Incidence { wi: self.wi.get(lane), irradiance: self.irradiance.get(lane), span: self.span.get(lane) }
    }

    /// Replaces the light at a point.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, incidence: Incidence) {
        self.wi.set(lane, incidence.wi);
        self.irradiance.set(lane, incidence.irradiance);
        self.span.set(lane, incidence.span);
    }
}

/// The frame's lights, scaled, then the environment's key light. Whitted's tree also gets the environment's peaks, which its lookups do not
/// contain; rays of paths find them.
pub(super) fn gather(
    frame: &Frame,
    environment: &Environment,
    settings: &IntegratorSettings,
) -> Vec<PreparedLight> {
    let scaled = frame.lights.iter().map(|light| PreparedLight::new(light, settings));
    let peaks = match settings.integrator {
        Integrator::Whitted => peak_lights(environment, settings),
        Integrator::Path => Vec::new(),
    };
    let key = environment.key_light().map(|key| PreparedLight::distant(key, settings));
    scaled.chain(key).chain(peaks).collect()
}

/// The peaks of an environment.
pub(super) fn peak_lights(environment: &Environment, settings: &IntegratorSettings) -> Vec<PreparedLight> {
    let light = |peak| PreparedLight { is_peak: true, ..PreparedLight::distant(peak, settings) };
    environment.peaks().into_iter().map(light).collect()
}

impl PreparedLight {
    fn distant(key: KeyLight, settings: &IntegratorSettings) -> Self {
        Self {
            color: key.irradiance,
            intensity: 1.0,
            emitter: Emitter::Distant { wi: key.direction_to_light },
            size: settings.light_size,
            is_peak: false,
        }
    }

    fn new(posed: &PosedLight, settings: &IntegratorSettings) -> Self {
        let PosedLight { position, direction, ref light } = *posed;
        let range = light.range.unwrap_or(f32::INFINITY);
        let point = |cone| Emitter::Point { position, range, cone };
        let emitter = match light.kind {
            LightKind::Directional => Emitter::Distant { wi: -direction },
            LightKind::Point => point(Cone::EVERYWHERE),
            LightKind::Spot { inner_cone_radians, outer_cone_radians } => {
                point(Cone::new(direction, inner_cone_radians, outer_cone_radians))
            }
        };
        let intensity = light.intensity * settings.light_scale;
        Self { color: light.color, intensity, emitter, size: settings.light_size, is_peak: false }
    }

    /// Where the light is; `None` for distant lights.
    pub(super) fn position(&self) -> Option<Vec3> {
        match self.emitter {
            Emitter::Distant { .. } => None,
            Emitter::Point { position, .. } => Some(position),
        }
    }

    /// The pass of light that a surface receives without a detour: the environment's lamps belong to the environment.
    pub(super) fn light_pass(&self) -> LightPass {
        if self.is_peak { LightPass::Environment } else { LightPass::Direct }
    }

    /// Whether the light is a peak of the environment, which rays see, too.
    pub(super) fn is_peak(&self) -> bool {
        self.is_peak
    }

    /// Whether [`PreparedLight::sample`] samples more than one point of the light.
    pub(super) fn is_sized(&self) -> bool {
        match self.emitter {
            Emitter::Distant { .. } => self.size.sun_angle_radians > 0.0,
            Emitter::Point { .. } => self.size.radius > 0.0,
        }
    }

    /// Unoccluded light at `point`; `None` where it is zero.
    pub(super) fn incidence(&self, point: Vec3) -> Option<Incidence> {
        let incidence = match self.emitter {
            Emitter::Distant { wi } => self.distant_incidence(wi),
            Emitter::Point { position, range, cone } => self.point_incidence((position, range, cone), point),
        };
        (incidence.irradiance.max_element() > 0.0).then_some(incidence)
    }

    /// Samples a point of the light for a lit `point`; `None` where no light arrives. Point and spot lights with a radius are spheres, distant
    /// lights with an angle are disks, both of uniform radiance; directions are uniform in the cone that they fill.
    pub(super) fn sample(&self, point: Vec3, u: Vec2) -> Option<LightSample> {
        let Incidence { wi, irradiance, span } = self.incidence(point)?;
        let distance = span.length();
        let sin_max = match self.emitter {
            Emitter::Distant { .. } => libm::sinf(0.5 * self.size.sun_angle_radians),
            // The light does not reach the surface that it lights.
            Emitter::Point { .. } => (self.size.radius / distance).min(0.5),
        };
        let is_sized = sin_max > 0.0;
        let (wi, scale) = if is_sized { in_cone(wi, sin_max, u) } else { (wi, 1.0) };
        let position = match self.emitter {
            Emitter::Distant { .. } => None,
            Emitter::Point { position, .. } if !is_sized => Some(position),
            Emitter::Point { .. } => Some(point + wi * distance),
        };
        Some(LightSample { wi, irradiance: irradiance * scale, position })
    }

    /// Unoccluded light at the points of a block.
    #[inline(always)]
    pub(super) fn incidences(&self, points: &Vec3Lanes, out: &mut IncidenceLanes) {
        match self.emitter {
            Emitter::Distant { wi } => {
                for lane in 0..LANES {
                    out.set(lane, self.distant_incidence(wi));
                }
            }
            Emitter::Point { position, range, cone } => {
                for lane in 0..LANES {
                    out.set(lane, self.point_incidence((position, range, cone), points.get(lane)));
                }
            }
        }
    }

    #[inline(always)]
    fn distant_incidence(&self, wi: Vec3) -> Incidence {
        Incidence { wi, irradiance: self.color * self.intensity, span: Vec3::ZERO }
    }

    /// Light of a point or spot light: 1/d² with the fade-outs of its range and its cone.
    #[inline(always)]
    fn point_incidence(&self, (position, range, cone): (Vec3, f32, Cone), point: Vec3) -> Incidence {
        let to_light = position - point;
        let distance_squared = to_light.dot(to_light);
        let ratio = distance_squared / (range * range);
        let fade = 1.0 - ratio * ratio;
        let wi = to_light / distance_squared.sqrt();
        let strength = fade / distance_squared * cone.falloff(-cone.axis.dot(wi));
        let reaches = distance_squared > 0.0 && distance_squared < f32::INFINITY && fade > 0.0;
        let irradiance = self.color * (self.intensity * if reaches { strength } else { 0.0 });
        Incidence { wi, irradiance, span: point - position }
    }

    /// The shadow ray between `end`, just off the surface, and the light with the given index.
    ///
    /// Rays of point and spot lights start at the light, so that rays of many surface points share their origin. On a light that
    /// has a size, each sample takes another point. Irradiance and direction are those of the light's centre.
    #[inline(always)]
    pub(super) fn shadow_ray(&self, end: Vec3, seed: Seed, index: usize) -> Ray {
        let LightSize { radius, sun_angle_radians } = self.size;
        match self.emitter {
            Emitter::Distant { wi } => {
                let is_disk = sun_angle_radians > 0.0;
                let towards_disk = || distant_disk_direction((wi, sun_angle_radians), (seed, index));
                Ray::new(end, if is_disk { towards_disk() } else { wi })
            }
            Emitter::Point { position, .. } => {
                let on_disk = || point_of_disk((position, radius), end, (seed, index));
                ray_between(if radius > 0.0 { on_disk() } else { position }, end)
            }
        }
    }
}

/// A point of the unit disk for a sample of a light.
fn disk_point(seed: Seed, light: usize) -> Vec2 {
    concentric_disk_point(seed.point(Purpose::Light(light as u32)))
}

/// The direction to a point of the disk that a distant light fills. Not part of [`PreparedLight::shadow_ray`], whose result stays in registers then.
#[inline(never)]
fn distant_disk_direction((wi, angle_radians): (Vec3, f32), (seed, light): (Seed, usize)) -> Vec3 {
    let radius = libm::tanf(angle_radians * 0.5);
    (wi + across(wi, disk_point(seed, light)) * radius).normalize()
}

/// A point of the disk of a light that faces `end`.
#[inline(never)]
fn point_of_disk((center, radius): (Vec3, f32), end: Vec3, (seed, light): (Seed, usize)) -> Vec3 {
    let span = end - center;
    let distance = span.length();
    if distance > 0.0 {
        // The light does not reach the surface that it lights.
        let radius = if radius < 0.5 * distance { radius } else { 0.5 * distance };
        center + across(span / distance, disk_point(seed, light)) * radius
    } else {
        center
    }
}

#[inline]
fn ray_between(origin: Vec3, end: Vec3) -> Ray {
    Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 }
}

/// A uniform direction of the cone around `axis` of half angle asin(`sin_max`), and the irradiance of the sample over that of the cone's light
/// on a surface that faces it: 2 (1 − cos) / sin².
fn in_cone(axis: Vec3, sin_max: f32, u: Vec2) -> (Vec3, f32) {
    let cos_max = libm::sqrtf(1.0 - sin_max * sin_max);
    // 1 − cos, without cancellation
    let height = sin_max * sin_max / (1.0 + cos_max);
    let drop = height * u.x;
    let sine = libm::sqrtf(drop * (2.0 - drop));
    let (sin_azimuth, cos_azimuth) = sin_cos_of_turn(u.y * std::f32::consts::TAU);
    let around = across(axis, Vec2::new(cos_azimuth, sin_azimuth));
    ((axis * (1.0 - drop) + around * sine).normalize(), 2.0 / (1.0 + cos_max))
}

/// A point of the disk perpendicular to a unit vector.
fn across(axis: Vec3, point: Vec2) -> Vec3 {
    let (u, v) = axis.any_orthonormal_pair();
    u * point.x + v * point.y
}

impl Cone {
    /// The cone of a light that shines everywhere alike.
    const EVERYWHERE: Self = Self { axis: Vec3::Y, cos_outer: -2.0, slope: 1.0 };

    fn new(axis: Vec3, inner_radians: f32, outer_radians: f32) -> Self {
        let cos_outer = libm::cosf(outer_radians);
        let width = libm::cosf(inner_radians) - cos_outer;
        // Equal cones have a hard edge; for others the extension has this least width.
        let least = if inner_radians >= outer_radians { 1e-6 } else { 0.001 };
        Self { axis, cos_outer, slope: 1.0 / if width > least { width } else { least } }
    }

    #[inline(always)]
    fn falloff(&self, cos: f32) -> f32 {
        let ramp = ((cos - self.cos_outer) * self.slope).clamp(0.0, 1.0);
        ramp * ramp
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Light;

    fn light(kind: LightKind, range: Option<f32>) -> PreparedLight {
        let light = Light { name: None, color: Vec3::new(1.0, 0.5, 0.0), intensity: 8.0, range, kind };
        let posed = PosedLight { position: Vec3::new(0.0, 2.0, 0.0), direction: Vec3::NEG_Y, light };
        PreparedLight::new(&posed, &IntegratorSettings::default())
    }

    #[test]
    fn point_lights_fall_off_with_the_squared_distance() {
        // 8 cd at 2 m: 8 / 4 = 2 lux.
        let arriving = light(LightKind::Point, None).incidence(Vec3::ZERO).unwrap();
        assert_eq!((arriving.wi, arriving.irradiance), (Vec3::Y, Vec3::new(2.0, 1.0, 0.0)));
    }

    #[test]
    fn lights_fade_to_zero_at_their_range() {
        // d / range = 1/2: 1 − 1/16 = 15/16.
        let arriving = light(LightKind::Point, Some(4.0)).incidence(Vec3::ZERO).unwrap();
        assert!((arriving.irradiance.x - 2.0 * 15.0 / 16.0).abs() < 1e-6);
        assert_eq!(light(LightKind::Point, Some(2.0)).incidence(Vec3::ZERO), None);
    }

    #[test]
    fn spot_falloff_is_one_inside_zero_outside_and_a_squared_ramp_between() {
        let (inner, outer) = (0.3_f32, 0.8_f32);
        let cone = Cone::new(Vec3::NEG_Y, inner, outer);
        assert_eq!(cone.falloff(libm::cosf(0.2)), 1.0);
        assert_eq!(cone.falloff(libm::cosf(0.9)), 0.0);
        let halfway = f32::midpoint(libm::cosf(inner), libm::cosf(outer));
        assert!((cone.falloff(halfway) - 0.25).abs() < 1e-5);
        // Equal angles make a hard edge and no division by zero.
        assert_eq!(Cone::new(Vec3::NEG_Y, 0.5, 0.5).falloff(0.99), 1.0);
        // However narrow they are.
        let narrow = Cone::new(Vec3::NEG_Y, 0.02, 0.02);
        assert_eq!([0.0, 0.018, 0.022].map(|angle| narrow.falloff(libm::cosf(angle))), [1.0, 1.0, 0.0]);
    }

    #[test]
    fn a_point_at_the_light_receives_nothing() {
        assert_eq!(light(LightKind::Point, None).incidence(Vec3::new(0.0, 2.0, 0.0)), None);
    }
}
