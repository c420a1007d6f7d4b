//! Rays of an image of a scene: camera, shadow, mirror and diffuse rays.

use std::f32::consts::TAU;

use glam::Vec3;
use rayframe::bvh::{Bvh, Hit, TraversalCounters};
use rayframe::geometry::Ray;

use peers::ray_set::RaySet;
use peers::soup::Soup;
use peers::surface::Surface;

/// Camera position.
const EYE: Vec3 = Vec3::new(2.6, 1.2, 2.2);
/// Point at the image centre.
const TARGET: Vec3 = Vec3::ZERO;
/// Light position.
const LIGHT: Vec3 = Vec3::new(6.0, 9.0, 3.0);
/// Half the image's height at distance one.
const HALF_HEIGHT: f32 = 0.32;
/// Shadow rays end this much before the light, in units of its distance.
const SHORT_OF_LIGHT: f32 = 1.0e-4;

/// Rays of a square image of `side` pixels, a power of two. Camera rays are in Z order of pixels, so that consecutive ones form
/// square tiles; secondary rays keep that order. Diffuse rays have random directions.
pub(crate) fn ray_sets(soup: &Soup, bvh: &Bvh, side: u32) -> [RaySet; 4] {
    let camera = camera_rays(side);
    let mut counters = TraversalCounters::default();
    let hits: Vec<(Ray, Surface)> = camera
        .iter()
        .filter_map(|ray| {
            let hit: Hit = bvh.closest_hit(ray, None, |_| true, &mut counters)?;
            Some((*ray, Surface::new(&soup.triangles, ray, &hit)))
        })
        .collect();
    let shadow = hits.iter().filter_map(|(_, surface)| shadow_ray(surface, LIGHT)).collect();
    let mirror = hits.iter().map(|(ray, surface)| {
        let direction = ray.direction - surface.normal * (2.0 * surface.normal.dot(ray.direction));
        Ray::new(surface.position, direction)
    });
    let diffuse = (0..).zip(&hits).map(|(i, (_, surface))| {
        Ray::new(surface.position, diffuse_direction(surface.normal, [uniform(2 * i), uniform(2 * i + 1)]))
    });
    [
        RaySet::closest("reflect", mirror.collect()),
        RaySet::closest("diffuse", diffuse.collect()),
        RaySet::shadow(shadow, LIGHT),
        RaySet::closest("primary", camera),
    ]
}

fn camera_rays(side: u32) -> Vec<Ray> {
    let forward = (TARGET - EYE).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let ray = |code: u32| {
        let [x, y] = [even_bits(code), even_bits(code >> 1)]
            .map(|pixel| HALF_HEIGHT * (2.0 * (pixel as f32 + 0.5) / side as f32 - 1.0));
        Ray::new(EYE, (forward + right * x - up * y).normalize())
    };
    (0..side * side).map(ray).collect()
}

/// Ray from the surface to just before the light; `None` if the light is on the other side.
fn shadow_ray(surface: &Surface, light: Vec3) -> Option<Ray> {
    let to_light = light - surface.position;
    let distance = to_light.length();
    let t_max = distance * (1.0 - SHORT_OF_LIGHT);
    let ray = Ray { direction: to_light / distance, t_max, ..Ray::new(surface.position, Vec3::X) };
    (to_light.dot(surface.normal) > 0.0).then_some(ray)
}

/// Cosine-weighted direction of the hemisphere of `normal` (Malley's method).
fn diffuse_direction(normal: Vec3, [first, second]: [f32; 2]) -> Vec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (sin, cos) = libm::sincosf(TAU * first);
    let radius = libm::sqrtf(second);
    tangent * (cos * radius) + bitangent * (sin * radius) + normal * libm::sqrtf((1.0 - second).max(1.0e-4))
}

/// Even bits of a Morton code: one coordinate.
fn even_bits(number: u32) -> u32 {
    (0..16).fold(0, |bits, i| bits | (number >> (2 * i) & 1) << i)
}

/// Hash of a number, from 0 to 1 (the finalizer of Appleby's MurmurHash3).
fn uniform(number: u32) -> f32 {
    let mut bits = number;
    bits = (bits ^ bits >> 16).wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ bits >> 13).wrapping_mul(0xc2b2_ae35);
    ((bits ^ bits >> 16) >> 8) as f32 / (1 << 24) as f32
}
