//! What the hash of a frame holds about sampling.

use serde_json::json;

use crate::render::{Adaptive, Aperture, EnvSamples, Focus, Lens, LightSize, RenderSettings};
use crate::sequence::Shutter;

/// Sampling of the image, its lens, its lights and its shutter. Floats are given by their bits.
pub(super) fn sampling_key(render: &RenderSettings, shutter: Shutter) -> serde_json::Value {
    let RenderSettings { adaptive, filter, lens, light_size, glossy_samples, env_samples, .. } = render;
    let LightSize { radius, sun_angle_radians } = light_size;
    let Shutter { open, time_samples } = shutter;
    let adaptive =
        adaptive.map(|Adaptive { max_samples, threshold }| json!([max_samples, threshold.to_bits()]));
    json!({
        "filter": filter.name(),
        "adaptive": adaptive,
        "lens": lens.map(lens_key),
        "glossy": glossy_samples,
        "env_samples": env_samples_key(*env_samples),
        "light_radius": radius.to_bits(),
        "sun_angle": sun_angle_radians.to_bits(),
        "shutter": (open.to_bits(), time_samples),
    })
}

fn env_samples_key(env_samples: EnvSamples) -> serde_json::Value {
    match env_samples {
        EnvSamples::Auto => json!("auto"),
        EnvSamples::Fixed(rays) => json!(rays),
    }
}

fn lens_key(Lens { aperture, focus }: Lens) -> serde_json::Value {
    let aperture = match aperture {
        Aperture::Radius(radius) => json!({ "radius": radius.to_bits() }),
        Aperture::FNumber(number) => json!({ "f_number": number.to_bits() }),
    };
    let focus = match focus {
        Focus::Metres(distance) => json!(distance.to_bits()),
        Focus::Node(node) => json!({ "node": node.0 }),
        // The name that the setting had first.
        Focus::Center => json!("middle"),
    };
    json!([aperture, focus])
}
