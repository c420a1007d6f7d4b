//! The rays of a picture of a scene: camera, shadow, mirror and diffuse rays.

use std::f32::consts::TAU;

use glam::Vec3;
use rayframe::bvh::{Bvh, Hit, TraversalCounters};
use rayframe::geometry::Ray;

use crate::ray_set::RaySet;
use crate::soup::Soup;
use crate::surface::Surface;

/// Where every scene is looked at from.
const EYE: Vec3 = Vec3::new(2.6, 1.2, 2.2);
/// What is in the middle of the picture.
const TARGET: Vec3 = Vec3::ZERO;
/// The lamp.
const LIGHT: Vec3 = Vec3::new(6.0, 9.0, 3.0);
/// Half the picture's height at distance one.
const HALF_HEIGHT: f32 = 0.32;
/// Shadow rays end this much before the light, in units of its distance.
const SHORT_OF_LIGHT: f32 = 1.0e-4;

/// The rays of a square picture of `side` pixels, a power of two. Camera rays are in Z order of pixels, so that consecutive ones
/// form square tiles, and what follows from them keeps that order; diffuse rays go anywhere.
pub(crate) fn ray_sets(soup: &Soup, bvh: &Bvh, side: u32) -> [RaySet; 4] {
    let camera = camera_rays(side);
    let mut counters = TraversalCounters::default();
    let met: Vec<(Ray, Surface)> = camera
        .iter()
        .filter_map(|ray| {
            let hit: Hit = bvh.closest_hit(ray, None, |_| true, &mut counters)?;
            Some((*ray, Surface::new(&soup.triangles, ray, &hit)))
        })
        .collect();
    let shadow = met.iter().filter_map(|(_, surface)| shadow_ray(surface, LIGHT)).collect();
    let mirror = met.iter().map(|(ray, surface)| {
        let direction = ray.direction - surface.normal * (2.0 * surface.normal.dot(ray.direction));
        Ray::new(surface.position, direction)
    });
    let diffuse = (0..).zip(&met).map(|(i, (_, surface))| {
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
    let ray = |place: u32| {
        let [x, y] = [even_bits(place), even_bits(place >> 1)]
            .map(|pixel| HALF_HEIGHT * (2.0 * (pixel as f32 + 0.5) / side as f32 - 1.0));
        Ray::new(EYE, (forward + right * x - up * y).normalize())
    };
    (0..side * side).map(ray).collect()
}

/// From the surface to just before the light; `None` where the light is behind it.
fn shadow_ray(surface: &Surface, light: Vec3) -> Option<Ray> {
    let to_light = light - surface.position;
    let distance = to_light.length();
    let t_max = distance * (1.0 - SHORT_OF_LIGHT);
    let ray = Ray { direction: to_light / distance, t_max, ..Ray::new(surface.position, Vec3::X) };
    (to_light.dot(surface.normal) > 0.0).then_some(ray)
}

/// A direction of the half-space of `normal`, as dense as its cosine (Malley's method).
fn diffuse_direction(normal: Vec3, [first, second]: [f32; 2]) -> Vec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (sin, cos) = libm::sincosf(TAU * first);
    let radius = libm::sqrtf(second);
    tangent * (cos * radius) + bitangent * (sin * radius) + normal * libm::sqrtf((1.0 - second).max(1.0e-4))
}

/// Every other bit of a number, moved together: a coordinate of a place in Z order.
fn even_bits(number: u32) -> u32 {
    (0..16).fold(0, |bits, i| bits | (number >> (2 * i) & 1) << i)
}

/// A number from 0 to 1 without pattern (the finalizer of Appleby's MurmurHash3).
fn uniform(number: u32) -> f32 {
    let mut bits = number;
    bits = (bits ^ bits >> 16).wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ bits >> 13).wrapping_mul(0xc2b2_ae35);
    ((bits ^ bits >> 16) >> 8) as f32 / (1 << 24) as f32
}
