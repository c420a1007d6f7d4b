//! A sample's value does not depend on its batch.

use std::path::Path;

use glam::{Vec2, Vec3};

use super::{SampleValue, Tracer};
use crate::bvh::{BuildSettings, Builder, TraversalCounters};
use crate::cancel::CancelFlag;
use crate::error::Result;
use crate::frame::Frame;
use crate::framing::resolve_camera;
use crate::gltf::{ImportOptions, import};
use crate::integrator::context_build::traced_samples;
use crate::integrator::lookup_environment::LookupEnvironment;
use crate::integrator::{
    CameraRays, CameraSamples, EnvSamples, EnvironmentShares, Integrator, IntegratorContext,
    IntegratorSettings, LightSize, Seed,
};
use crate::interaction::{RayHit, SurfaceBlock, SurfacePoint};
use crate::scene::{
    BuiltInLight, Environment, EnvironmentImage, EnvironmentMap, Ground, Scene, Selection, SelectionRequest,
    ViewRequest, mark_shadow_catchers,
};
use crate::scene_view::SceneView;

const SIZE: (u32, u32) = (16, 12);
const SAMPLES: usize = (SIZE.0 * SIZE.1) as usize;

/// Traces the samples at the centres of the given pixels, in that order, as one batch.
fn trace(tracer: &mut Tracer<'_, '_>, camera: &CameraRays, pixels: &[usize]) -> Vec<SampleValue> {
    let pixels: Vec<(u32, u32)> =
        pixels.iter().map(|&pixel| (pixel as u32 % SIZE.0, pixel as u32 / SIZE.0)).collect();
    let offsets = [Vec2::splat(0.5)];
    let samples = CameraSamples { pixels: &pixels, offsets: &offsets, first_index: 0, may_hit: true };
    tracer.trace(camera, &samples).to_vec()
}

/// Calls `check` with the context of `scene` one second after its start.
pub(in crate::integrator) fn with_context(
    scene: &str,
    environment: &Environment,
    check: impl FnOnce(&IntegratorContext<'_>, &CameraRays),
) {
    with_edited_context(scene, |_| (), environment, check);
}

/// [`with_context`] of an edited scene.
fn with_edited_context(
    scene: &str,
    edit: impl FnOnce(&mut Scene),
    environment: &Environment,
    check: impl FnOnce(&IntegratorContext<'_>, &CameraRays),
) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene).with_extension("gltf");
    let mut scene = import(&path, &ImportOptions::default()).unwrap();
    edit(&mut scene);
    let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
    let aspect_ratio = SIZE.0 as f32 / SIZE.1 as f32;
    let selection = resolve_camera(&scene, selection, &ViewRequest::default(), aspect_ratio).selection;
    let frame = Frame::at(&scene, &selection, 1.0);
    let (build, cancel) = (BuildSettings::default(), CancelFlag::new());
    let bvh = Builder::default().build(&frame.triangles, &frame.flags, &build, &cancel, None).unwrap();
    let settings = IntegratorSettings { max_depth: 7, ..IntegratorSettings::default() };
    let view = SceneView { scene: &scene, frame: &frame, bvh: &bvh, environment };
    let context = IntegratorContext::new(view, settings);
    check(&context, &CameraRays::new(&frame.camera, SIZE, 1.0, None));
}

#[test]
fn samples_are_the_same_alone_and_in_batches() {
    for (scene, environment) in [
        // Mirrors and glass; nested volumes; transparent surfaces; several lights; the studio environment.
        ("demo/whitted_1980", Environment::None),
        ("material/nested_glass", Environment::BuiltIn(BuiltInLight::Studio)),
        ("material/alpha_blend_stack", Environment::None),
        ("light/two_lights_shadows", Environment::None),
        ("camera/orthographic", Environment::BuiltIn(BuiltInLight::Studio)),
        // Light that bounces
        ("material/metal_roughness_row", Environment::BuiltIn(BuiltInLight::Studio)),
    ] {
        with_context(scene, &environment, |context, camera| {
            let tracer = &mut Tracer::new(context);
            let all: Vec<usize> = (0..SAMPLES).collect();
            let together = trace(tracer, camera, &all);
            assert!(together.iter().any(|value| value.radiance != together[0].radiance), "{scene} is empty");

            let alone: Vec<SampleValue> = all.iter().map(|one| trace(tracer, camera, &[*one])[0]).collect();
            assert!(together == alone, "{scene}: one by one");

            let backwards: Vec<usize> = all.iter().rev().copied().collect();
            let mut reversed = trace(tracer, camera, &backwards);
            reversed.reverse();
            assert!(together == reversed, "{scene}: backwards");

            // 7 and 192 have no common factor: each pixel comes once, next to distant ones.
            let scattered: Vec<usize> = all.iter().map(|i| i * 7 % SAMPLES).collect();
            let mut values = vec![SampleValue::default(); SAMPLES];
            for chunk in scattered.chunks(50) {
                for (pixel, value) in chunk.iter().zip(trace(tracer, camera, chunk)) {
                    values[*pixel] = value;
                }
            }
            assert!(together == values, "{scene}: in scattered batches");
        });
    }
}

#[test]
fn short_queues_of_shadow_rays_leave_samples_as_they_are() {
    let studio = Environment::BuiltIn(BuiltInLight::Studio);
    for (scene, environment) in [
        ("demo/whitted_1980", &Environment::None),
        ("material/nested_glass", &studio),
        ("material/alpha_blend_stack", &Environment::None),
        ("light/two_lights_shadows", &Environment::None),
        ("material/metal_roughness_row", &studio),
    ] {
        with_context(scene, environment, |context, camera| {
            let all: Vec<usize> = (0..SAMPLES).collect();
            let traced = |most_tasks: usize| {
                let mut tracer = Tracer::new(context);
                tracer.shadows.most_tasks = most_tasks;
                let values = trace(&mut tracer, camera, &all);
                (values, tracer.take_statistics().shadow_rays)
            };
            let long = traced(usize::MAX);
            for most_tasks in [1, 7, 50] {
                assert!(traced(most_tasks) == long, "{scene}: {most_tasks}");
            }
        });
    }
}

#[test]
fn thousands_of_lights_share_a_short_queue() {
    const LIGHTS: usize = 2000;
    with_context("light/two_lights_shadows", &Environment::None, |context, camera| {
        let mut context = context.clone();
        context.lights = context.lights.iter().cycle().take(LIGHTS).cloned().collect();
        context.lamp_volumes.resize(LIGHTS, None);
        let all: Vec<usize> = (0..SAMPLES).collect();
        let traced = |most_tasks: usize| {
            let mut tracer = Tracer::new(&context);
            tracer.shadows.most_tasks = most_tasks;
            (trace(&mut tracer, camera, &all), tracer.shadows.tasks.capacity())
        };
        let (values, capacity) = traced(4 * LIGHTS);
        // A vector grows to the next power of two.
        assert!(capacity <= (4 * LIGHTS).next_power_of_two(), "{capacity}");
        let (together, all_at_once) = traced(usize::MAX);
        assert!(all_at_once > 8 * capacity, "{all_at_once}");
        assert!(values == together);
    });
}

#[test]
fn every_batch_is_counted_once() {
    let check = |context: &IntegratorContext<'_>, camera: &CameraRays| {
        let tracer = &mut Tracer::new(context);
        let all: Vec<usize> = (0..SAMPLES).collect();
        trace(tracer, camera, &all);
        let once = tracer.take_statistics();
        assert_eq!(once.camera_rays, SAMPLES as u64);
        assert!(once.reflection_rays > 0 && once.shadow_rays > 0);
        assert!(once.query_seconds > 0.0);

        for one in all {
            trace(tracer, camera, &[one]);
        }
        let alone = tracer.take_statistics();
        let rays = |of: crate::integrator::IntegratorStatistics| {
            (of.camera_rays, of.reflection_rays, of.refraction_rays, of.shadow_rays)
        };
        assert_eq!(rays(once), rays(alone));
        assert_eq!(rays(tracer.take_statistics()), (0, 0, 0, 0));
        once
    };
    with_context("demo/whitted_1980", &Environment::None, |context, camera| {
        assert!(check(context, camera).refraction_rays > 0);
    });
    // With what stops the shadow rays to the environment, and without
    let environment = Environment::BuiltIn(BuiltInLight::Studio);
    with_context("material/metal_roughness_row", &environment, |context, camera| {
        let once = check(context, camera);
        let mut without_bounces = context.clone();
        without_bounces.bounce_share = 0.0;
        assert!(once.shadow_rays > check(&without_bounces, camera).shadow_rays);
    });
}

#[test]
fn half_of_the_occluders_reflect_half_of_the_light_on_average() {
    let environment = Environment::BuiltIn(BuiltInLight::Studio);
    with_context("showcase/apartment", &environment, |context, camera| {
        let sum = |bounce_share: f32| {
            let mut context = context.clone();
            context.bounce_share = bounce_share;
            let values = trace(&mut Tracer::new(&context), camera, &(0..SAMPLES).collect::<Vec<_>>());
            values.iter().map(|value| value.radiance.element_sum()).sum::<f32>()
        };
        let [none, half, all] = [0.0, 0.5, 1.0].map(sum);
        let share = (half - none) / (all - none);
        assert!((share - 0.5).abs() < 0.15, "{share} of {}", all - none);
    });
}

#[test]
fn a_share_of_the_shadows_takes_fewer_rays_and_is_that_share_on_average() {
    let environment = Environment::BuiltIn(BuiltInLight::Studio);
    with_context("showcase/apartment", &environment, |context, camera| {
        let render = |occluded_share: f32| {
            let mut context = context.clone();
            (context.occluded_share, context.bounce_share) = (occluded_share, 0.0);
            context.lookups = LookupEnvironment::new(context.view.environment, &EnvironmentShares::ALL);
            context.traced_samples = traced_samples(occluded_share, &context.settings);
            let tracer = &mut Tracer::new(&context);
            let values = trace(tracer, camera, &(0..SAMPLES).collect::<Vec<_>>());
            let light = values.iter().map(|value| value.radiance.element_sum()).sum::<f32>();
            (light, tracer.take_statistics().shadow_rays as f32)
        };
        let [(light, rays), (shadowed, all_rays)] = [0.0, 1.0].map(render);
        for (share, of_samples) in [(0.2, 0.25), (0.25, 0.25), (0.4, 0.5), (0.6, 1.0)] {
            let (found, found_rays) = render(share);
            let found_share = (found - light) / (shadowed - light);
            assert!((found_share - share).abs() < 0.05, "{found_share} for {share}");
            // Those of lamps, and a quarter of those of the environment, are among the rays of no share.
            let lamp_rays = rays - (all_rays - rays) / 3.0;
            let of_rays = (found_rays - lamp_rays) / (all_rays - lamp_rays);
            assert!((of_rays - of_samples).abs() < 0.05, "{of_rays} for {of_samples}");
        }
    });
}

#[test]
fn fewer_samples_trace_shadows_only_where_each_pixel_has_its_part() {
    let of = |samples: u32, max_samples: u32, occluded_share: f32| {
        let settings = IntegratorSettings { samples, max_samples, ..IntegratorSettings::default() };
        traced_samples(occluded_share, &settings)
    };
    assert_eq!(
        [0.0, 0.25, 0.3, 0.5, 0.6, 1.0].map(|share| of(4, 4, share)),
        [0.25, 0.25, 0.5, 0.5, 1.0, 1.0]
    );
    assert_eq!([1, 2, 3, 6, 8].map(|samples| of(samples, samples, 0.1)), [1.0, 0.5, 1.0, 0.5, 0.25]);
    assert_eq!(of(4, 16, 0.1), 1.0);
}

#[test]
fn the_light_on_first_receivers_is_that_of_single_ones() {
    let environment = Environment::BuiltIn(BuiltInLight::Studio);
    let check = |ground: Option<Ground>| {
        move |context: &IntegratorContext<'_>, camera: &CameraRays| {
            let render = |settings: &IntegratorSettings, has_receivers: bool| {
                let mut context = IntegratorContext::new(context.view, settings.clone());
                context.has_receivers = has_receivers;
                let tracer = &mut Tracer::new(&context);
                let values = trace(tracer, camera, &(0..SAMPLES).collect::<Vec<_>>());
                (values, tracer.take_statistics().shadow_rays)
            };
            // More rays than are traced together, lights with a size, and paths
            let plain = IntegratorSettings { ground, show_background: false, ..context.settings.clone() };
            let light_size = LightSize { radius: 0.2, sun_angle_radians: 0.1 };
            let env_samples = EnvSamples::Fixed(30);
            for settings in [
                IntegratorSettings { light_size, env_samples, ..plain.clone() },
                IntegratorSettings { integrator: Integrator::Path, ..plain.clone() },
                plain,
            ] {
                let together = render(&settings, true);
                assert!(together == render(&settings, false), "{settings:?}");
                let is_shadow = |value: &SampleValue| value.coverage > 0.0 && value.coverage < 1.0;
                let shows_shadows = match ground {
                    // The ground lies over a floor.
                    Some(_) => {
                        together.0 != render(&IntegratorSettings { ground: None, ..settings }, false).0
                    }
                    None => together.0.iter().any(is_shadow),
                };
                assert!(shows_shadows);
            }
        }
    };
    // Seen in mirrors and through glass, behind transparent surfaces, and a surface of the scene
    let ground = |height: f32| Some(Ground { up: Vec3::Y, height, is_mirror: true });
    with_context("demo/whitted_1980", &environment, check(ground(0.1)));
    with_context("material/alpha_blend_stack", &environment, check(ground(0.1)));
    let catch = |scene: &mut Scene| assert!(mark_shadow_catchers(scene, "floor") > 0);
    with_edited_context("material/glass_sphere", catch, &environment, check(None));
}

#[test]
fn surfaces_that_scatter_next_to_nothing_of_a_light_get_no_shadow_rays() {
    // The key light of the studio; the glass ball is in the middle of the image, the floor at its bottom.
    let [glass, floor] = [6 * 16 + 8, 11 * 16 + 8];
    with_context("material/glass_sphere", &Environment::BuiltIn(BuiltInLight::Studio), |context, camera| {
        let mut context = context.clone();
        context.settings.max_depth = 0;
        let tracer = &mut Tracer::new(&context);
        for (pixel, is_lit) in [(glass, false), (floor, true)] {
            let value = trace(tracer, camera, &[pixel])[0];
            assert_eq!(value.coverage, 1.0);
            assert_eq!(tracer.take_statistics().shadow_rays > 0, is_lit, "{pixel}");
            assert_eq!(value.radiance.max_element() > 0.0, is_lit, "{pixel}");
        }
    });
}

/// Light of radiance 1 within 30° of the zenith, so that many surfaces look up nothing.
fn light_from_above() -> Result<Environment> {
    let pixels = (0..64 * 32).map(|index| [f32::from(u8::from(index / 64 < 5)); 3]).collect();
    let image = EnvironmentImage { width: 64, height: 32, pixels, content_hash: [0; 32] };
    Ok(Environment::Map(EnvironmentMap::new("above.hdr".as_ref(), image, 0.0)?))
}

#[test]
fn blocks_of_opaque_surfaces_give_the_values_of_single_hits() {
    let one_sided = light_from_above().unwrap();
    for scene in [
        "light/two_lights_shadows",
        "light/spot",
        "light/range",
        "texture/normal_map_mirrored_uv",
        "texture/occlusion",
        "material/metal_roughness_row",
        "material/diffuse",
        "material/mirror",
        "skin/two_bone_strip",
        "geometry/negative_scale",
    ] {
        let check = |context: &IntegratorContext<'_>, camera: &CameraRays| {
            assert!(context.opaque_materials.iter().all(|is_opaque| *is_opaque), "{scene}");
            let all: Vec<usize> = (0..SAMPLES).collect();
            let in_blocks = trace(&mut Tracer::new(context), camera, &all);
            let mut context = context.clone();
            context.opaque_materials.fill(false);
            let one_by_one = trace(&mut Tracer::new(&context), camera, &all);
            assert!(in_blocks == one_by_one, "{scene}");
        };
        with_context(scene, &Environment::BuiltIn(BuiltInLight::Studio), check);
        with_context(scene, &one_sided, check);
    }
}

#[test]
fn points_of_blocks_reflect_and_refract_as_single_points() {
    for scene in [
        "demo/whitted_1980",
        "material/nested_glass",
        "texture/normal_map_mirrored_uv",
        "skin/two_bone_strip",
    ] {
        with_context(scene, &Environment::None, |context, camera| {
            let (view, mut block) = (context.view, SurfaceBlock::default());
            let mut seen = 0;
            for pixel in 0..SAMPLES {
                let ray = camera
                    .ray(Vec2::new((pixel % 16) as f32 + 0.5, (pixel / 16) as f32 + 0.5), Seed::default());
                let differential = camera.differential(&ray);
                let Some(hit) = view.bvh.closest_hit(&ray, None, |_| true, &mut TraversalCounters::default())
                else {
                    continue;
                };
                let material = &view.frame.materials[view.frame.instance(hit.triangle).material.index()];
                let hits = [RayHit { ray: &ray, differential: &differential, hit: &hit }];
                block.fill(view, material, hits.into_iter());
                block.compute_normal_steps(view, material);
                let in_block = &block.points[0];
                let alone = SurfacePoint::new(view, &ray, &hit, &differential);
                assert_eq!(in_block.shading_normal, alone.shading_normal, "{scene}");
                let reflected = alone.reflected_differential(view.frame, &differential);
                assert_eq!(in_block.reflected_differential(view.frame, &differential), reflected, "{scene}");
                let refracted = |point: &SurfacePoint<'_>| {
                    let direction = (ray.direction - point.shading_normal * 0.1).normalize();
                    point.refracted_differential(view.frame, &differential, direction, 1.25)
                };
                assert_eq!(refracted(in_block), refracted(&alone), "{scene}");
                seen += 1;
            }
            assert!(seen > 10, "{scene}: {seen}");
        });
    }
}

#[test]
fn values_of_constant_materials_are_those_of_single_hits() {
    for scene in
        ["demo/whitted_1980", "material/nested_glass", "material/glass_shadow", "material/alpha_blend_stack"]
    {
        with_context(scene, &Environment::BuiltIn(BuiltInLight::Studio), |context, camera| {
            assert!(context.constant_materials.iter().any(|is_constant| *is_constant), "{scene}");
            let all: Vec<usize> = (0..SAMPLES).collect();
            let by_material = trace(&mut Tracer::new(context), camera, &all);
            let mut context = context.clone();
            context.constant_materials.fill(false);
            let one_by_one = trace(&mut Tracer::new(&context), camera, &all);
            assert!(by_material == one_by_one, "{scene}");
        });
    }
}
