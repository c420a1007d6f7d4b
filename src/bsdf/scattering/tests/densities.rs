//! Values, densities and samples of rough lobes agree, and smooth lobes are exact.

use std::f32::consts::PI;

use super::*;

const RINGS: u32 = 480;
const AZIMUTHS: u32 = 240;

/// Surfaces whose lobes a grid resolves.
fn rough_surfaces() -> impl Iterator<Item = Surface> {
    [0.5, 0.8, 1.0].into_iter().flat_map(white_surfaces)
}

/// The points of a grid over the sphere; each stands for 4π / (`RINGS` · `AZIMUTHS`).
fn sphere() -> impl Iterator<Item = (usize, Vec3)> {
    (0..RINGS * AZIMUTHS).map(|point| {
        let cosine = ((point / AZIMUTHS) as f32 + 0.5) / RINGS as f32 * 2.0 - 1.0;
        let azimuth = ((point % AZIMUTHS) as f32 + 0.5) / AZIMUTHS as f32 * 2.0 * PI;
        let wi = direction(cosine, azimuth);
        (bin_of(wi), wi)
    })
}

const BINS: usize = 16 * 12;

fn bin_of(wi: Vec3) -> usize {
    let ring = ((wi.z * 0.5 + 0.5) * 16.0) as usize;
    let turn = (libm::atan2f(wi.y, wi.x) / (2.0 * PI) + 1.0).fract();
    ring.min(15) * 12 + ((turn * 12.0) as usize).min(11)
}

#[test]
fn values_integrate_to_albedos() {
    let step = 4.0 * PI / (RINGS * AZIMUTHS) as f32;
    for surface in rough_surfaces() {
        for cosine in [0.3, 0.8] {
            let scattering = surface.scattering(direction(cosine, 0.3));
            let sum: glam::DVec3 = sphere().map(|(_, wi)| scattering.eval(wi).as_dvec3()).sum();
            let error = (sum.as_vec3() * step - albedo(&scattering)).abs().max_element();
            let tolerance = match surface.name {
                // The lobe is sharper than the grid.
                "volume of low index" => 2e-2,
                // Half of the light passes up to the critical angle, none beyond it: an edge within cells of the grid.
                "the same from inside" => 1e-2,
                _ => 3e-3,
            };
            assert!(error < tolerance, "{surface:?} {cosine}: {error}");
        }
    }
}

#[test]
fn samples_follow_their_densities() {
    let step = 4.0 * std::f64::consts::PI / f64::from(RINGS * AZIMUTHS);
    let count = 1 << 15;
    for surface in rough_surfaces() {
        let scattering = surface.scattering(direction(0.6, 0.3));
        let mut expected = [0.0; BINS];
        for (bin, wi) in sphere() {
            expected[bin] += f64::from(scattering.pdf(wi)) * step;
        }
        let mut found = [0.0; BINS];
        for (u_lobe, u) in points(count) {
            if let Some(sample) = scattering.sample(u_lobe, u) {
                assert_consistent(&scattering, &sample);
                found[bin_of(sample.wi)] += 1.0 / f64::from(count);
            }
        }
        // Masked samples are missing from both.
        assert!(expected.iter().sum::<f64>() < 1.002, "{surface:?}");
        for (bin, (expected, found)) in expected.into_iter().zip(found).enumerate() {
            let difference = (expected - found).abs();
            assert!(difference < 1.5e-3 + 0.02 * expected, "{surface:?} {bin}: {found} for {expected}");
        }
    }
}

fn assert_consistent(scattering: &Scattering, sample: &ScatterSample) {
    let (value, pdf) = scattering.eval_and_pdf(sample.wi);
    assert!((pdf - sample.pdf).abs() <= 1e-5 * pdf && !sample.is_smooth, "{sample:?}");
    assert!((sample.weight * pdf - value).abs().max_element() <= 1e-5 * value.max_element(), "{sample:?}");
    assert_eq!(value, scattering.eval(sample.wi));
    let through = matches!(sample.lobe, ScatterLobe::Transmission | ScatterLobe::DiffuseTransmission);
    assert_eq!(through, sample.wi.z < 0.0);
}

#[test]
fn rough_refraction_is_reciprocal() {
    // Walter et al. 2007, section 5: f(o, i) / n_i² = f(i, o) / n_o². Both sides here are without that factor and the compensation.
    let material = MaterialSample { transmission: 1.0, thin: false, roughness: 0.5, ..Default::default() };
    let value = |outside, inside, wo: Vec3, wi: Vec3| {
        let scattering = Scattering::new(Bsdf::new(&material, outside, inside), wo, None);
        let TransmissionLobe::Refracted { scale } = scattering.transmission else { panic!("no lobe") };
        scattering.eval(wi).x / scale.x / wi.z.abs()
    };
    for (wo, wi) in [(direction(0.9, 0.1), -direction(0.8, 0.4)), (direction(0.3, 1.0), -direction(0.7, 1.3))]
    {
        let (entering, leaving) = (value(1.0, 1.5, wo, wi), value(1.5, 1.0, -wi, -wo));
        assert!(
            entering > 1e-3 && (entering - 2.25 * leaving).abs() < 1e-4 * entering,
            "{entering} {leaving}"
        );
    }
}

#[test]
fn smooth_glass_reflects_and_refracts_by_fresnel() {
    let material = MaterialSample { transmission: 1.0, thin: false, roughness: 0.0, ..Default::default() };
    let bsdf = Bsdf::new(&material, 1.0, 1.5);
    let wo = direction(0.6, 0.5);
    let scattering = Scattering::new(bsdf, wo, None);
    let reflectance = fresnel::exact(0.6, 1.5);
    let reflected = scattering.sample(0.5 * reflectance, Vec2::splat(0.5)).unwrap();
    assert_eq!(
        (reflected.lobe, reflected.pdf, reflected.is_smooth),
        (ScatterLobe::SpecularReflection, 0.0, true)
    );
    assert_eq!(reflected.wi, Vec3::new(-wo.x, -wo.y, wo.z));
    let refracted = scattering.sample(0.5, Vec2::splat(0.5)).unwrap();
    assert_eq!((refracted.lobe, refracted.is_unbent), (ScatterLobe::Transmission, false));
    assert_eq!(Some(refracted.wi), bsdf.refract(wo));
    for weight in [reflected.weight, refracted.weight] {
        assert!((weight - 1.0).abs().max_element() < 1e-5);
    }
    assert!(scattering.is_smooth() && scattering.eval_and_pdf(reflected.wi) == (Vec3::ZERO, 0.0));
    // The sharpest lobe stands for the mirror.
    assert!(scattering.eval_with_smooth(reflected.wi).x > 100.0);
    // Total reflection takes everything.
    let inside = Scattering::new(Bsdf::new(&material, 1.5, 1.0), wo, None);
    for u_lobe in [0.0, 0.5, 1.0] {
        let sample = inside.sample(u_lobe, Vec2::ZERO).unwrap();
        assert_eq!((sample.lobe, sample.weight), (ScatterLobe::SpecularReflection, Vec3::ONE));
    }
}

#[test]
fn clear_walls_and_equal_media_leave_light_unbent() {
    let wo = direction(0.3, 0.5);
    for (thin, ior) in [(true, 1.5), (false, 1.0)] {
        let material = MaterialSample { transmission: 1.0, thin, roughness: 0.0, ..Default::default() };
        let sample = Scattering::new(Bsdf::new(&material, 1.0, ior), wo, None).sample(0.99, Vec2::ZERO);
        let sample = sample.unwrap();
        assert_eq!((sample.wi, sample.is_unbent, sample.lobe), (-wo, true, ScatterLobe::Transmission));
    }
}

#[test]
fn a_smooth_coat_is_a_mirror_about_its_own_normal() {
    let wo = direction(0.8, 0.0);
    let coat_from_local = Mat3::from_rotation_y(0.2);
    let bsdf = Bsdf::new(&MaterialSample::default(), 1.0, 1.5);
    let coat = OrientedCoat { coat: Coat::new(1.0, 0.0), coat_from_local, geometric_normal: Vec3::Z };
    let scattering = Scattering::new(bsdf, wo, Some(coat));
    let sample = scattering.sample(0.0, Vec2::splat(0.3)).unwrap();
    let normal = coat_from_local.transpose() * Vec3::Z;
    assert!((sample.wi - (normal * (2.0 * wo.dot(normal)) - wo)).length() < 1e-6 && sample.is_smooth);
    assert!((mean_weight(&scattering, 4096) - albedo(&scattering)).abs().max_element() < 5e-3);
}

#[test]
fn coats_reflect_light_from_below_a_base_whose_normal_leans() {
    // Seen at 80° to the geometric normal and the coat, from 50° to the base's: the mirror direction is below the base.
    let lean = Mat3::from_rotation_y(30.0_f32.to_radians());
    let cosine = libm::sinf(10.0_f32.to_radians());
    let (normal, wo) = (lean * Vec3::Z, lean * direction(cosine, PI));
    let black = MaterialSample { base_color: Vec3::ZERO, specular: 0.0, ..Default::default() };
    let reflectance = fresnel::exact(cosine, 1.5);
    assert!(
        (reflectance - 0.3877).abs() < 1e-4 && wo.z > 0.0 && (normal * (2.0 * wo.dot(normal)) - wo).z < 0.0
    );
    for roughness in [0.0, 0.3, 0.6] {
        let coat_from_local = lean.transpose();
        let coat =
            OrientedCoat { coat: Coat::new(1.0, roughness), coat_from_local, geometric_normal: normal };
        let scattering = Scattering::new(Bsdf::new(&black, 1.0, 1.5), wo, Some(coat));
        let mean = mean_weight(&scattering, 4096);
        assert!((mean - reflectance).abs().max_element() < 5e-3, "{roughness}: {mean}");
    }
}

#[test]
fn extreme_directions_and_materials_stay_finite() {
    for surface in [0.0, 0.046, 0.05, 1.0].into_iter().flat_map(white_surfaces) {
        for wo in [Vec3::Z, Vec3::X, Vec3::NEG_Z, direction(1e-6, 0.0), direction(1e-30, 1.0)] {
            let scattering = surface.scattering(wo);
            for wi in [Vec3::Z, Vec3::X, Vec3::NEG_X, Vec3::NEG_Z, -wo, direction(1e-6, PI)] {
                let (value, pdf) = scattering.eval_and_pdf(wi);
                assert!(value.is_finite() && pdf.is_finite(), "{surface:?} {wo} {wi}");
                assert!(scattering.eval_with_smooth(wi).is_finite(), "{surface:?} {wo} {wi}");
            }
            for u in [Vec2::ZERO, Vec2::ONE, Vec2::splat(0.5)] {
                for u_lobe in [0.0, 0.5, 1.0] {
                    if let Some(sample) = scattering.sample(u_lobe, u) {
                        let length = sample.wi.length();
                        assert!((length - 1.0).abs() < 1e-4, "{surface:?} {wo} {u_lobe} {u}: {sample:?}");
                        assert!(sample.weight.is_finite() && sample.weight.max_element() < 1e3, "{sample:?}");
                    }
                }
            }
        }
    }
}
