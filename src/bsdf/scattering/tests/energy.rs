//! Furnace tests: what white surfaces return of uniform light.

use super::*;
use crate::bsdf::FacetSample;

const ROUGHNESSES: [f32; 7] = [0.0, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0];
const COSINES: [f32; 5] = [0.05, 0.2, 0.5, 0.8, 1.0];
const SAMPLES: u32 = 1 << 14;

/// The greatest difference of a surface's mean weight from its albedo, by statistical error and by that of its tables. With 65,536 samples it
/// is below 2e-3 where it is below 5e-3 here.
const TOLERANCE: f32 = 5e-3;

#[test]
fn white_surfaces_return_what_they_receive() {
    let mut failures = Vec::new();
    for roughness in ROUGHNESSES {
        let mut surfaces = white_surfaces(roughness);
        // Most roughnesses blur no light that passes so little a step of the index.
        let inside = surfaces.iter().find(|surface| surface.name == "volume from inside").copied();
        surfaces.extend(inside.map(|volume| Surface {
            name: "volume of an index near 1 from inside",
            ior_outside: 1.05,
            ..volume
        }));
        for surface in surfaces {
            for cosine in COSINES {
                let scattering = surface.scattering(direction(cosine, 0.3));
                let (mean, all) = (mean_weight(&scattering, SAMPLES), albedo(&scattering));
                let error = (mean - all).abs().max_element();
                let is_colored = surface.material.iridescence.is_some();
                if error > TOLERANCE || (all - 1.0).abs().max_element() > 1e-5 && !is_colored {
                    failures.push(format!("{} {roughness} {cosine}: {mean} for {all}", surface.name));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn facets_reflect_and_refract_the_albedos_of_their_lobes() {
    let mut volumes = 0;
    for roughness in [0.3, 0.6, 1.0] {
        for surface in white_surfaces(roughness) {
            let bsdf = Bsdf::new(&surface.material, surface.ior_outside, surface.ior_inside);
            if surface.material.transmission == 0.0 || surface.material.thin || bsdf.is_refraction_smooth() {
                continue;
            }
            volumes += 1;
            for cosine in COSINES {
                let scattering = surface.scattering(direction(cosine, 0.3));
                let mut sums = [glam::DVec3::ZERO; 2];
                for (_, u) in points(SAMPLES) {
                    let FacetSample { reflected, refracted, .. } = scattering.sample_both_at_facet(u);
                    for (side, sampled) in [reflected, refracted].into_iter().enumerate() {
                        let Some((wi, weight)) = sampled else { continue };
                        assert!(weight.min_element() >= 0.0 && (wi.z < 0.0) == (side == 1));
                        sums[side] += weight.as_dvec3();
                    }
                }
                let [reflected, refracted] = sums.map(|sum| (sum / f64::from(SAMPLES)).as_vec3());
                let Albedos { specular, transmission, .. } = scattering.albedos();
                let error = (reflected - specular).abs().max((refracted - transmission).abs()).max_element();
                assert!(error < TOLERANCE, "{} {roughness} {cosine}: {error}", surface.name);
            }
        }
    }
    assert_eq!(volumes, 27);
}
