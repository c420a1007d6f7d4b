//! The whole material model: energy, reciprocity, and values of the lobes.

use std::f32::consts::PI;

use glam::Vec3;

use super::*;
use crate::interaction::{AnisotropySample, SheenSample};

mod albedo_accuracy;
mod quadrature;
mod specification;

fn material(metallic: f32, roughness: f32, transmission: f32, thin: bool) -> MaterialSample {
    MaterialSample {
        base_color: Vec3::ONE,
        metallic,
        roughness,
        occlusion: 1.0,
        emission: Vec3::ZERO,
        unlit: false,
        ior: 1.5,
        transmission,
        thin,
        ..MaterialSample::default()
    }
}

/// f(wo, wi) as the specifications give it: by single scattering.
fn single_scattering(bsdf: &Bsdf, wo: Vec3, wi: Vec3) -> Vec3 {
    bsdf.eval_by(wo, wi, AlbedoTerms { total: 1.0, ..AlbedoTerms::default() })
}

fn direction(cosine: f32, azimuth: f32) -> Vec3 {
    let (sine, azimuth) = ((1.0 - cosine * cosine).sqrt(), libm::sincosf(azimuth));
    Vec3::new(sine * azimuth.1, sine * azimuth.0, cosine)
}

/// Plastic, metal, a mix of both, thin glass and solid glass, smooth and rough.
fn materials() -> Vec<MaterialSample> {
    let mut all = Vec::new();
    for roughness in [0.4, 0.6, 1.0] {
        all.push(material(0.0, roughness, 0.0, true));
        all.push(material(1.0, roughness, 0.0, true));
        all.push(material(0.4, roughness, 0.5, true));
        all.push(material(0.0, roughness, 1.0, true));
        all.push(material(0.0, roughness, 1.0, false));
    }
    let anisotropy = Some(AnisotropySample { strength: 0.7, direction: Vec3::X });
    all.push(MaterialSample { anisotropy, ..material(0.3, 0.6, 0.4, true) });
    for sample in &mut all {
        sample.base_color = Vec3::new(0.9, 0.5, 0.1);
    }
    all
}

/// The same materials and some with sheen, diffuse transmission or tinted reflection.
fn extended_materials() -> Vec<MaterialSample> {
    let sheen = Some(SheenSample { color: Vec3::new(0.3, 0.8, 0.6), roughness: 0.6 });
    let mut all = materials();
    all.push(MaterialSample { sheen, ..all[0] });
    all.push(MaterialSample { diffuse_transmission: 0.6, sheen, ..all[2] });
    all.push(MaterialSample { specular: 0.5, specular_color: Vec3::new(4.0, 0.1, 1.0), ..all[0] });
    all
}

/// ∫ g(wi) dω over the sphere, on a fine grid.
fn integrate(g: impl Fn(Vec3) -> Vec3) -> Vec3 {
    let (rings, azimuths) = (800, 200);
    let mut sum = glam::DVec3::ZERO;
    for ring in 0..rings {
        let cosine = (ring as f32 + 0.5) / rings as f32 * 2.0 - 1.0;
        for step in 0..azimuths {
            let azimuth = (step as f32 + 0.5) / azimuths as f32 * 2.0 * PI;
            sum += g(direction(cosine, azimuth)).as_dvec3();
        }
    }
    (sum * 4.0 * std::f64::consts::PI / f64::from(rings * azimuths)).as_vec3()
}

#[test]
fn a_white_surface_returns_at_most_what_it_receives() {
    for (transmission, thin) in [(0.0, true), (0.5, true), (1.0, true), (0.7, false)] {
        for roughness in [0.0, 0.1, 0.4, 1.0] {
            for step in 0..=20 {
                let cosine = step as f32 / 20.0;
                let bsdf = Bsdf::new(&material(0.0, roughness, transmission, thin), 1.0, 1.5);
                let sum = bsdf.specular_albedo(direction(cosine, 0.3))
                    + bsdf.diffuse_albedo(direction(cosine, 0.3))
                    + bsdf.transmission_albedo(direction(cosine, 0.3));
                assert!((sum - Vec3::ONE).abs().max_element() < 1e-5, "{roughness} {cosine}: {sum}");
                // A perfect white metal reflects all of it.
                let metal = Bsdf::new(&material(1.0, roughness, transmission, thin), 1.0, 1.5);
                let reflected = metal.specular_albedo(direction(cosine, 0.3)).x;
                assert!((reflected - 1.0).abs() < 1e-5, "{roughness} {cosine}: {reflected}");
                assert_eq!(
                    metal.diffuse_albedo(direction(cosine, 0.3))
                        + metal.transmission_albedo(direction(cosine, 0.3)),
                    Vec3::ZERO
                );
            }
        }
    }
}

#[test]
fn white_materials_lose_only_what_colours_absorb() {
    let white = MaterialSample::default();
    let sum = |sample: &MaterialSample, wo| {
        let albedos = Bsdf::new(sample, 1.0, 1.5).albedos(wo);
        albedos.specular
            + albedos.diffuse
            + albedos.transmission
            + albedos.diffuse_transmission
            + albedos.sheen
    };
    for step in 1..=20 {
        let wo = direction(step as f32 / 20.0, 0.3);
        for roughness in [0.0, 0.3, 1.0] {
            // Light that a dielectric does not reflect reaches a white base: nothing is lost, whatever the lobe.
            let base = MaterialSample { roughness, ..white };
            let anisotropy = Some(AnisotropySample { strength: 0.8, direction: Vec3::X });
            for sample in [
                MaterialSample { specular: 0.4, ..base },
                MaterialSample { anisotropy, ..base },
                MaterialSample { diffuse_transmission: 0.7, transmission: 0.2, ..base },
            ] {
                assert!((sum(&sample, wo) - 1.0).abs().max_element() < 1e-5, "{sample:?}");
            }
            // Below a coloured reflection the base receives 1 − E_max: E_max − E is lost.
            let tinted = MaterialSample { specular_color: Vec3::new(1.0, 0.5, 0.2), ..base };
            let specular = Bsdf::new(&tinted, 1.0, 1.5).specular_albedo(wo);
            let expected = 1.0 - specular.max_element() + specular;
            assert!((sum(&tinted, wo) - expected).abs().max_element() < 1e-5);
            // The same holds for coloured sheen: with colour c, E c + (1 − E c_max).
            let color = Vec3::new(1.0, 0.6, 0.2);
            for sheen_roughness in [0.2, 0.6, 1.0] {
                let sheen = SheenSample { color, roughness: sheen_roughness };
                let cloth = MaterialSample { sheen: Some(sheen), ..base };
                let albedo = Sheen::new(Vec3::ONE, sheen_roughness).albedo(wo.z).x;
                let expected = color * albedo + (1.0 - albedo);
                assert!((sum(&cloth, wo) - expected).abs().max_element() < 1e-5);
            }
            // A coat reflects what it does not transmit.
            let coat = Coat::new(0.8, roughness);
            assert!((coat.albedo(wo.z) + coat.transmittance(wo.z) - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn specular_albedo_is_the_integral_of_the_lobe() {
    for sample in materials() {
        // A black base leaves only the specular lobe of dielectrics.
        let mut sample = sample;
        sample.base_color *= sample.metallic;
        if sample.metallic < 1.0 {
            sample.metallic = 0.0;
            sample.base_color = Vec3::ZERO;
        }
        let bsdf = Bsdf::new(&sample, 1.0, 1.5);
        for cosine in [0.2, 0.6, 1.0] {
            let wo = direction(cosine, 0.3);
            let terms = bsdf.albedo_terms(wo);
            let expected = integrate(|wi| bsdf.eval_by(wo, wi, terms) * wi.z.abs());
            let found = bsdf.specular_albedo(wo);
            assert!((found - expected).abs().max_element() < 4e-3, "{cosine}: {found} for {expected}");
        }
    }
}

#[test]
fn thin_transmission_is_the_integral_of_its_lobe() {
    // Head on, F varies little over the lobe, so the lobe passes about (1 − 0.04) of what it would with F = 1.
    let bsdf = Bsdf::new(&material(0.0, 0.4, 1.0, true), 1.0, 1.5);
    let below = |wi: Vec3| {
        if wi.z < 0.0 { bsdf.eval(Vec3::Z, wi) * -wi.z } else { Vec3::ZERO }
    };
    let passed = integrate(below).x;
    assert!(passed < bsdf.transmission_albedo(Vec3::Z).x + 1e-3 && passed > 0.92, "{passed}");
    assert!((bsdf.transmission_albedo(Vec3::Z).x - 0.96).abs() < 0.01);
}

#[test]
fn diffuse_head_on_is_lambert_under_fresnel() {
    // wo = wi = n: (1 − 0.04) base / π, plus the specular peak F D V = 0.04 · 1/π · 1/4 at α = 1.
    let bsdf = Bsdf::new(&material(0.0, 1.0, 0.0, true), 1.0, 1.5);
    let expected = 0.96 / PI + 0.04 / PI / 4.0;
    assert!((single_scattering(&bsdf, Vec3::Z, Vec3::Z).x - expected).abs() < 1e-6);
    // Single scattering at α = 1 reflects E = 1 − ln 2: the lobe is multiplied by 1 + 0.04 (1/E − 1).
    let lost = std::f32::consts::LN_2 / (1.0 - std::f32::consts::LN_2);
    let compensated = 0.96 / PI + 0.04 / PI / 4.0 * (1.0 + 0.04 * lost);
    assert!((bsdf.eval(Vec3::Z, Vec3::Z).x - compensated).abs() < 1e-5);
}

#[test]
fn rough_total_reflection_loses_nothing() {
    // From inside, beyond the critical angle of every facet that reflects upwards
    for roughness in [0.1, 0.15] {
        let bsdf = Bsdf::new(&material(0.0, roughness, 1.0, false), 1.5, 1.0);
        let reflected = bsdf.specular_albedo(direction(0.2, 0.0)).x;
        assert!((reflected - 1.0).abs() < 4e-3, "{roughness}: {reflected}");
    }
}

#[test]
fn single_scattering_is_reciprocal() {
    for sample in extended_materials() {
        let bsdf = Bsdf::new(&sample, 1.0, 1.5);
        for (a, b) in [(direction(0.9, 0.1), direction(0.2, 2.0)), (direction(0.5, 1.0), direction(0.7, 4.0))]
        {
            let forward = single_scattering(&bsdf, a, b);
            let difference = forward - single_scattering(&bsdf, b, a);
            assert!(difference.abs().max_element() <= 1e-6 * forward.max_element().max(1.0));
        }
    }
}

#[test]
fn refraction_follows_snell() {
    let bsdf = Bsdf::new(&material(0.0, 0.0, 1.0, false), 1.0, 1.5);
    // sin 30° / 1.5 = 1/3.
    let wt = bsdf.refract(Vec3::new(0.5, 0.0, 0.75_f32.sqrt())).unwrap();
    assert!((wt - Vec3::new(-1.0 / 3.0, 0.0, -(8.0_f32 / 9.0).sqrt())).length() < 1e-6);
    assert_eq!(bsdf.refract(Vec3::Z), Some(Vec3::NEG_Z));
    // From inside, beyond the critical angle (sin θ = 2/3).
    let leaving = Bsdf::new(&material(0.0, 0.0, 1.0, false), 1.5, 1.0);
    let steep = Vec3::new(0.7, 0.0, 0.51_f32.sqrt());
    assert_eq!(leaving.refract(steep), None);
    assert_eq!(leaving.transmission_albedo(steep), Vec3::ZERO);
    assert!((leaving.specular_albedo(steep).x - 1.0).abs() < 1e-6);
    assert!(leaving.refract(Vec3::new(0.6, 0.0, 0.8)).is_some());
    // A thin wall does not bend.
    let wall = Bsdf::new(&material(0.0, 0.0, 1.0, true), 1.0, 1.5);
    assert_eq!(wall.refract(steep), Some(-steep));
}

#[test]
fn only_thin_walls_have_a_transmission_lobe() {
    let (wo, straight_on) = (direction(0.6, 0.0), -direction(0.6, 0.0));
    let thin = Bsdf::new(&material(0.0, 0.5, 1.0, true), 1.0, 1.5);
    let solid = Bsdf::new(&material(0.0, 0.5, 1.0, false), 1.0, 1.5);
    let metal = Bsdf::new(&material(1.0, 0.5, 1.0, true), 1.0, 1.5);
    assert!(thin.eval(wo, straight_on).x > 1.0);
    assert_eq!(solid.eval(wo, straight_on), Vec3::ZERO);
    assert_eq!(metal.eval(wo, straight_on), Vec3::ZERO);
}

#[test]
fn an_index_of_zero_reflects_everything() {
    let mut sample = material(0.0, 0.0, 0.5, true);
    sample.ior = 0.0;
    let bsdf = Bsdf::new(&sample, 1.0, 1.0);
    for cosine in [0.0, 0.4, 1.0] {
        assert_eq!(bsdf.specular_albedo(direction(cosine, 0.3)), Vec3::ONE);
        assert_eq!(
            bsdf.diffuse_albedo(direction(cosine, 0.3)) + bsdf.transmission_albedo(direction(cosine, 0.3)),
            Vec3::ZERO
        );
    }
}

#[test]
fn extreme_directions_and_materials_stay_finite() {
    for roughness in [0.0, 0.02, 1.0] {
        for thin in [false, true] {
            let bsdf = Bsdf::new(&material(0.3, roughness, 0.5, thin), 1.0, 1.5);
            for wo in [Vec3::Z, Vec3::X, Vec3::NEG_Z, direction(1e-6, 0.0), direction(1e-30, 1.0)] {
                for wi in [Vec3::Z, Vec3::X, Vec3::NEG_X, Vec3::NEG_Z, -wo, direction(1e-6, PI)] {
                    assert!(bsdf.eval(wo, wi).is_finite(), "{roughness} {wo} {wi}");
                }
            }
        }
    }
}
