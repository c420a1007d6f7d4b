//! Furnace tests: what white surfaces return of uniform light.

use super::*;

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
        for surface in white_surfaces(roughness) {
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
