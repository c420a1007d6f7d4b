//! Closed bodies that light enters by diffuse transmission alone.

use std::f32::consts::{FRAC_1_PI, LN_2};

use glam::Vec3;
use rayframe::integrator::{EnvSamples, Integrator};
use rayframe::scene::{
    DiffuseTransmission, Environment, Iridescence, LightKind, Material, Transmission, Volume,
};

use super::path::stage;
use crate::stage::{Stage, assert_close, cuboid, lambert};

/// A volume of which half of the light is left after a metre.
const HALVING: Volume =
    Volume { thickness: 1.0, attenuation_distance: 1.0, attenuation_color: Vec3::splat(0.5) };

fn wax(factor: f32, volume: Volume, base: Material) -> Material {
    let through = DiffuseTransmission { factor, texture: None, color: Vec3::ONE, color_texture: None };
    Material { diffuse_transmission: Some(through), volume: Some(volume), ..base }
}

/// A slab, one metre thick and so wide that no light leaves it at the sides.
fn slab(integrator: Integrator, samples: u32, material: Material) -> Stage {
    let mut stage = stage(samples);
    stage.settings.integrator = integrator;
    stage.add(cuboid(Vec3::ZERO, Vec3::new(400.0, 0.5, 400.0)), material);
    stage
}

/// The radiance of the slab's middle from above.
fn seen(stage: &Stage) -> glam::Vec4 {
    stage.look(Vec3::Y * 3.0, Vec3::ZERO)
}

/// Share of a metre's uniform light that reaches the other side of a slab: ∫ 2 μ e^(−σ / μ) dμ with σ = ln 2.
fn uniform_light_after_a_metre() -> f32 {
    let steps = 10_000_u16;
    let mean: f32 = (0..steps)
        .map(|step| (f32::from(step) + 0.5) / f32::from(steps))
        .map(|cosine| 2.0 * cosine * libm::expf(-LN_2 / cosine))
        .sum();
    mean / f32::from(steps)
}

#[test]
fn bodies_absorb_the_light_that_diffuse_transmission_lets_in() {
    // With an index of 1 and a factor of 1, both faces scatter all light to their other side.
    let material = wax(1.0, HALVING, lambert(Vec3::ZERO));
    let mut stage = slab(Integrator::Path, 4096, material.clone());
    stage.environment = Environment::Constant(Vec3::ONE);
    let share = uniform_light_after_a_metre();
    assert!((share - 0.335).abs() < 1e-3, "{share}");
    assert_close(seen(&stage), Vec3::splat(share), 0.01);
    // Lookups without shadow rays are absorbed along the middle of their lobe.
    let mut stage = slab(Integrator::Whitted, 1, material);
    stage.environment = Environment::Constant(Vec3::ONE);
    stage.settings.env_samples = EnvSamples::Fixed(0);
    assert_close(seen(&stage), Vec3::splat(0.5), 1e-4);
}

#[test]
fn clear_bodies_lose_no_light_to_total_reflection() {
    let white = Material { roughness: 0.0, ior: 1.5, ..lambert(Vec3::ONE) };
    let mut stage = slab(Integrator::Path, 4096, wax(0.6, Volume::CLEAR, white));
    stage.settings.max_depth = 128;
    stage.environment = Environment::Constant(Vec3::ONE);
    assert_close(seen(&stage), Vec3::ONE, 0.01);
}

#[test]
fn black_bodies_are_black_inside_also_below_films() {
    let film = Iridescence {
        factor: 1.0,
        texture: None,
        ior: 1.8,
        thickness_minimum_nm: 100.0,
        thickness_maximum_nm: 400.0,
        thickness_texture: None,
    };
    let through = DiffuseTransmission { factor: 0.5, texture: None, color: Vec3::ZERO, color_texture: None };
    let black = Material {
        ior: 1.5,
        iridescence: Some(film),
        diffuse_transmission: Some(through),
        volume: Some(Volume::CLEAR),
        ..lambert(Vec3::ZERO)
    };
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let mut stage = slab(integrator, 16, black.clone());
        stage.environment = Environment::Constant(Vec3::ONE);
        assert!(seen(&stage).truncate().min_element() > 0.01, "the film reflects outside");
        let within = stage.look(Vec3::ZERO, Vec3::new(1.0, 0.3, 0.0));
        assert_eq!(within.truncate(), Vec3::ZERO, "{integrator:?}");
    }
}

#[test]
fn bodies_show_lamps_behind_them_whether_double_sided_or_not() {
    // The face below has the radiance E / π inside, of which the upper one scatters what arrives.
    let see = |double_sided| {
        let material = Material { double_sided, ..wax(1.0, HALVING, lambert(Vec3::ZERO)) };
        let mut stage = slab(Integrator::Path, 4096, material);
        stage.add_light(LightKind::Directional, 3.0, Vec3::ZERO, Vec3::Y);
        seen(&stage)
    };
    let single_sided = see(false);
    assert_close(single_sided, Vec3::splat(3.0 * FRAC_1_PI * uniform_light_after_a_metre()), 0.01);
    assert_eq!(single_sided, see(true));
}

#[test]
fn bodies_without_transmission_are_the_limit_of_those_with_little() {
    // An index bends light, and reflects it from within, only where some is transmitted.
    let base = Material { roughness: 0.6, ior: 1.0, ..lambert(Vec3::splat(0.8)) };
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let see = |transmission: Option<f32>| {
            let transmission = transmission.map(|factor| Transmission { factor, texture: None });
            let material = Material { transmission, ..wax(0.6, HALVING, base.clone()) };
            let mut stage = slab(integrator, 1024, material);
            stage.environment = Environment::Constant(Vec3::splat(0.5));
            // Shadow rays of lookups find what is opaque, which glass never is.
            stage.settings.env_samples = EnvSamples::Fixed(0);
            stage.add_light(LightKind::Directional, 1.0, Vec3::ZERO, Vec3::new(0.2, 1.0, 0.0));
            seen(&stage)
        };
        let without = see(None);
        assert_close(see(Some(1e-6)), without.truncate(), 1e-3);
        assert_eq!(see(Some(0.0)), without);
    }
}
