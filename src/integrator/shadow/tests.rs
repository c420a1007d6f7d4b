//! Tests of shadow rays.

use glam::Vec2;

use super::*;
use crate::integrator::Seed;
use crate::integrator::tracing::tests::with_context;
use crate::scene::Environment;

#[test]
fn collected_surfaces_equal_those_found_one_by_one() {
    for scene in ["material/nested_glass", "material/alpha_blend_stack", "material/glass_shadow"] {
        with_context(scene, &Environment::None, |context, camera| {
            // Camera rays of several lengths, in a fixed pattern, serve as shadow rays.
            let (mut batch, mut counters) = (ShadowBatch::default(), TraversalCounters::default());
            for index in 0..768_u32 {
                let pixel = Vec2::new((index % 32) as f32 * 0.5, (index / 32) as f32 * 0.5);
                let ray = camera.ray(pixel, Seed::default());
                batch.push(Ray { t_max: 1.0 + (index % 7) as f32, ..ray }, SurfaceMedia::default());
            }
            batch.trace(context, &mut counters);
            let (mut tinted, mut cache) = (0, ShadowCache::default());
            for index in 0..768_u32 {
                let ray = batch.rays[index as usize];
                let found = batch.transmittance(context, index, &mut counters).transmittance;
                if batch.is_occluded[index as usize] {
                    assert_eq!(found, Vec3::ZERO);
                    continue;
                }
                let ray = (&ray, GlassPassage::Straight);
                let one_by_one = |after| next_surface(context, ray, after, &mut counters);
                let reference =
                    through_surfaces(context, ray, (MediaStack::default(), &mut cache), one_by_one)
                        .transmittance;
                assert_eq!(found, reference, "{scene}: ray {index}");
                tinted += u32::from(found != Vec3::ONE);
            }
            assert!(tinted > 10, "{scene}: {tinted}");
        });
    }
}
