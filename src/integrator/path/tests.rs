//! A path does not depend on its batch.

use glam::Vec2;

use crate::integrator::tracing::tests::with_context;
use crate::integrator::tracing::{SampleValue, Tracer};
use crate::integrator::{
    CameraRays, CameraSamples, Integrator, IntegratorContext, IntegratorSettings, LightSize, PathSettings,
};
use crate::scene::{BuiltInLight, Environment};

const SIZE: (u32, u32) = (16, 12);

fn trace(tracer: &mut Tracer<'_, '_>, camera: &CameraRays, pixels: &[(u32, u32)]) -> Vec<SampleValue> {
    let offsets = [Vec2::new(0.25, 0.5), Vec2::new(0.75, 0.5)];
    let samples = CameraSamples { pixels, offsets: &offsets, first_index: 0, may_hit: true };
    tracer.trace(camera, &samples).to_vec()
}

#[test]
fn paths_are_the_same_alone_and_in_batches() {
    for (scene, environment) in [
        ("demo/whitted_1980", Environment::None),
        ("material/nested_glass", Environment::BuiltIn(BuiltInLight::Studio)),
        ("material/alpha_blend_stack", Environment::BuiltIn(BuiltInLight::Outdoor)),
        ("light/two_lights_shadows", Environment::None),
        ("path/box", Environment::None),
        ("showcase/apartment", Environment::BuiltIn(BuiltInLight::Outdoor)),
    ] {
        with_context(scene, &environment, |context, camera| {
            let settings = IntegratorSettings { integrator: Integrator::Path, ..context.settings.clone() };
            let context = IntegratorContext::new(context.view, settings);
            let tracer = &mut Tracer::new(&context);
            let pixels: Vec<_> = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))).collect();
            let together = trace(tracer, camera, &pixels);
            assert!(together.iter().any(|value| value.radiance != together[0].radiance), "{scene} is empty");
            let alone: Vec<_> = pixels.iter().flat_map(|&pixel| trace(tracer, camera, &[pixel])).collect();
            assert!(together == alone, "{scene}: one by one");
        });
    }
}

#[test]
fn lanes_shade_paths_as_surfaces_one_by_one_do() {
    let studio = Environment::BuiltIn(BuiltInLight::Studio);
    let sized = LightSize { radius: 0.2, sun_angle_radians: 0.1 };
    for (scene, light_size, regularize) in [
        ("light/two_lights_shadows", LightSize::default(), false),
        ("light/two_lights_shadows", sized, true),
        ("material/alpha_blend_stack", sized, false),
        ("path/box", LightSize::default(), false),
        ("showcase/apartment", LightSize::default(), true),
    ] {
        with_context(scene, &studio, |context, camera| {
            let path = PathSettings { regularize, ..context.settings.path };
            let settings = IntegratorSettings {
                integrator: Integrator::Path,
                light_size,
                path,
                ..context.settings.clone()
            };
            let context = IntegratorContext::new(context.view, settings);
            let pixels: Vec<_> = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))).collect();
            let traced = |is_one_by_one: bool| {
                let mut tracer = Tracer::new(&context);
                tracer.path.block.as_mut().unwrap().is_one_by_one = is_one_by_one;
                trace(&mut tracer, camera, &pixels)
            };
            assert!(traced(false) == traced(true), "{scene}");
        });
    }
}
