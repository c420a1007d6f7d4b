//! Where photons start: on emissive triangles.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use crate::bsdf::cosine_direction;
use crate::bvh::{Hit, TriangleFlags};
use crate::color::luminance;
use crate::geometry::{Facing, Ray, Triangle};
use crate::integrator::IntegratorContext;
use crate::integrator::local_frame::local_frame;
use crate::integrator::path::emissive_triangles::EmissiveTriangles;
use crate::integrator::path::visible_environment::random_point;
use crate::interaction::SurfacePoint;
use crate::scene::prefix_sums;
use crate::scene_view::SceneView;

/// Independent numbers of a photon.
const EMITTER: u32 = 1 << 16;
const POINT: u32 = EMITTER + 1;
const DIRECTION: u32 = EMITTER + 2;

/// What emissive triangles emit light in a frame, by power.
pub(super) struct PhotonSources<'c, 'a> {
    view: SceneView<'a>,
    lights: &'c EmissiveTriangles,
    /// Prefix sums of the shares of the power, from 0 to 1.
    sums: Vec<f32>,
    /// Luminance of the power of all.
    power: f32,
}

/// A photon where it starts.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmittedPhoton {
    pub(super) ray: Ray,
    /// Such that the mean luminance of all photons is near 1.
    pub(super) power: Vec3,
    /// Luminance of the radiance of its source.
    pub(super) luminance: f32,
}

impl<'c, 'a> PhotonSources<'c, 'a> {
    /// The sources of a frame; `None` if there are none.
    pub(super) fn new(context: &'c IntegratorContext<'a>) -> Option<Self> {
        let lights = context.emissive_triangles.as_ref().filter(|lights| !lights.is_empty())?;
        let mut sums = vec![0.0; lights.powers().len() + 1];
        let power = prefix_sums(lights.powers().iter().map(|&power| f64::from(power)), &mut sums) as f32;
        Some(Self { view: context.view, lights, sums, power })
    }

    /// The photon of an index; `None` where the source is dark.
    pub(super) fn emit(&self, index: u32) -> Option<EmittedPhoton> {
        // A part of a triangle by its power, and a side
        let Vec2 { x: u_emitter, y: u_side } = random_point(index, EMITTER);
        let parts = self.lights.parts();
        let last = parts.len() - 1;
        let emitter = self.sums[1..].partition_point(|&sum| sum <= u_emitter).min(last);
        let probability = self.sums[emitter + 1] - self.sums[emitter];
        let part = parts[emitter];
        let triangle = part.triangle;
        let is_two_sided = !self.view.frame.flags[triangle as usize].has(TriangleFlags::SINGLE_SIDED);
        let is_front = !is_two_sided || u_side < 0.5;
        let (facing, sign) = if is_front { (Facing::Front, 1.0) } else { (Facing::Back, -1.0) };

        // A point, uniform over the area
        let u_point = random_point(index, POINT);
        let root = u_point.x.sqrt();
        let (u, v) = (root * (1.0 - u_point.y), root * u_point.y);
        let Triangle { vertices } = self.view.frame.triangles[triangle as usize];
        let [a, b, c] = part.corners(vertices);
        let cross = (b - a).cross(c - a);
        let normal = cross.try_normalize()? * sign;
        let position = a + (b - a) * u + (c - a) * v;

        // A direction by its cosine
        let direction = local_frame(normal) * cosine_direction(random_point(index, DIRECTION));
        let Vec2 { x: u, y: v } = part.in_triangle(Vec2::new(u, v));
        let hit = Hit { t: 1.0, triangle, u, v, facing };
        let point = SurfacePoint::flat(self.view, &Ray::new(position + direction, -direction), &hit);
        let radiance = self.lights.radiance(self.view, &hit);
        let sides = if is_two_sided { 2.0 } else { 1.0 };
        let power = radiance * (0.5 * cross.length() * sides * PI / (probability * self.power));
        let brightness = luminance(power);
        let is_lit = brightness > 0.0 && brightness < f32::INFINITY;
        is_lit.then(|| EmittedPhoton {
            ray: Ray::new(point.origin_outside(), direction),
            power,
            luminance: luminance(radiance),
        })
    }

    /// Luminance of the power of all sources.
    pub(super) fn power(&self) -> f32 {
        self.power
    }
}
