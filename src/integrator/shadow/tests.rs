//! Tests of shadow rays.

use glam::Vec2;

use super::*;
use crate::integrator::tracing::tests::with_context;
use crate::integrator::{CameraRays, Seed};
use crate::scene::Environment;

const RAYS: u32 = 768;
const SCENES: [&str; 3] = ["material/nested_glass", "material/alpha_blend_stack", "material/glass_shadow"];

/// A traced batch of camera rays of several lengths, in a fixed pattern, which serve as shadow rays. It keeps `most_hits` surfaces at once.
fn traced_batch(
    context: &IntegratorContext<'_>,
    camera: &CameraRays,
    most_hits: usize,
    counters: &mut TraversalCounters,
) -> ShadowBatch {
    let mut batch = ShadowBatch::default();
    batch.transparent_hits.most_hits = most_hits;
    for index in 0..RAYS {
        let pixel = Vec2::new((index % 32) as f32 * 0.5, (index / 32) as f32 * 0.5);
        let ray = camera.ray(pixel, Seed::default());
        batch.push(Ray { t_max: 1.0 + (index % 7) as f32, ..ray }, SurfaceMedia::default());
    }
    batch.trace(context, counters);
    batch
}

#[test]
fn collected_surfaces_equal_those_found_one_by_one() {
    for scene in SCENES {
        with_context(scene, &Environment::None, |context, camera| {
            let mut counters = TraversalCounters::default();
            let batch = traced_batch(context, camera, usize::MAX, &mut counters);
            let (mut tinted, mut cache) = (0, ShadowCache::default());
            for index in 0..RAYS {
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

#[test]
fn rays_with_too_many_surfaces_together_are_traced_in_parts() {
    for scene in SCENES {
        with_context(scene, &Environment::None, |context, camera| {
            let found = |most_hits: usize| {
                let mut counters = TraversalCounters::default();
                let batch = traced_batch(context, camera, most_hits, &mut counters);
                let traced = counters.rays;
                let transmittance = |index| batch.transmittance(context, index, &mut counters);
                let found: Vec<ShadowTransmittance> = (0..RAYS).map(transmittance).collect();
                // No surface takes a query of its own.
                assert_eq!(counters.rays, traced, "{scene}: {most_hits}");
                (found, batch.is_occluded, batch.found_in_parts.len(), traced)
            };
            let (together, occluded, in_parts, traced) = found(usize::MAX);
            assert_eq!((in_parts, traced), (0, u64::from(RAYS)));
            for most_hits in [1, 3, 8] {
                let (divided, also_occluded, in_parts, traced) = found(most_hits);
                assert!(divided == together && also_occluded == occluded, "{scene}: {most_hits}");
                assert_eq!(in_parts, RAYS as usize, "{scene}: {most_hits}");
                // Once together, and in parts of which some are divided again. Of fewer surfaces single rays have too many alone.
                let is_enough = most_hits == 8;
                assert!(!is_enough || traced <= 6 * u64::from(RAYS), "{scene}: {most_hits}: {traced} rays");
            }
        });
    }
}
