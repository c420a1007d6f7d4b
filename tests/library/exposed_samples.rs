//! Samples by the noise and the edges that the exposed image shows.

use rayframe::image::Samples;
use rayframe::output::Aov;
use rayframe::settings::EnvironmentSource;
use rayframe::{RenderedFrame, Renderer};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/light/two_lights_shadows.gltf");
/// A power of two: sums of light scale with it exactly.
const SCALE: f32 = 1024.0;
const STOPS: f32 = 10.0;

#[expect(clippy::unwrap_used, reason = "a helper of tests")]
fn frame(light_scale: f32, settings: &[(&str, &str)]) -> RenderedFrame {
    let mut renderer = Renderer::open(SCENE)
        .unwrap()
        .size(48, 32)
        .environment(EnvironmentSource::None)
        .set("light_scale", light_scale.to_string())
        .unwrap();
    for (name, value) in settings {
        renderer = renderer.set(name, value).unwrap();
    }
    if settings.contains(&("integrator", "path")) {
        renderer = renderer.aovs([Aov::SampleCount]);
    }
    renderer.frame(0).unwrap()
}

#[test]
fn edges_of_bright_scenes_take_more_samples_as_those_of_others() {
    let edges = [("samples", "1"), ("max_samples", "16"), ("exposure", "auto")];
    let dim = frame(1.0, &edges);
    assert!(dim.pixels() != frame(1.0, &edges[..1]).pixels());
    let scaled = |frame: &RenderedFrame| -> Vec<_> {
        frame.pixels().iter().map(|[r, g, b, a]| [r * SCALE, g * SCALE, b * SCALE, *a]).collect()
    };
    assert!(scaled(&dim) == frame(SCALE, &edges).pixels());

    // Without the exposure, all that is lit is white.
    let [samples, max_samples, _] = edges;
    let at = |ev: f32, scale: f32| frame(scale, &[samples, max_samples, ("exposure", &ev.to_string())]);
    assert!(scaled(&at(0.0, 1.0)) == at(-STOPS, SCALE).pixels());
    assert!(scaled(&at(0.0, 1.0)) != at(0.0, SCALE).pixels());
}

#[test]
fn noise_of_bright_scenes_ends_as_that_of_others() {
    let noise = [("integrator", "path"), ("samples", "512"), ("noise", "0.02")];
    let counts = |scale: f32| {
        let image = frame(scale, &noise).image().unwrap();
        let Samples::Uint(counts) = &image.channel("sample_count").unwrap().samples else {
            panic!("counts are whole numbers");
        };
        counts.clone()
    };
    let dim = counts(1.0);
    assert!(dim.iter().any(|count| *count != dim[0]));
    let differ = dim.iter().zip(counts(SCALE)).filter(|(dim, bright)| **dim != *bright).count();
    assert!(differ < dim.len() / 100, "{differ}");
}
