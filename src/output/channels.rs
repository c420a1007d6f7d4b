//! From what a film has recorded to the channels of a file.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::film::{CentreSample, Film};
use crate::image_file::{ExrChannel, ExrSamples, finite_f32, half_from_f32};

use super::shape_ids::ShapeIds;
use super::{Layer, LightSamples};

/// `Z` where nothing is met, metres: further than anything, so that what is nearer wins and fog is thick, and yet a number.
pub const DEPTH_OF_NOTHING: f32 = 1e10;

/// The channels of one layer of `film`.
///
/// # Errors
/// [`Error::Internal`] when the film has not recorded what the layer shows.
pub(super) fn layer_channels(
    layer: Layer,
    film: &Film,
    samples: LightSamples,
    shapes: &ShapeIds,
) -> Result<Vec<ExrChannel>> {
    Ok(match layer {
        Layer::Beauty => {
            let channel = |(c, name): (usize, &str)| light(name.to_owned(), samples, &film.pixels, |p| p[c]);
            ["R", "G", "B", "A"].into_iter().enumerate().map(channel).collect()
        }
        Layer::Light(part) => {
            let parts = film.layers.light.as_deref().ok_or_else(|| unrecorded(layer))?;
            let name = |channel| format!("{}.{channel}", part.name());
            let channel = |(c, channel)| light(name(channel), samples, parts, |p| p[part as usize][c]);
            ["R", "G", "B"].into_iter().enumerate().map(channel).collect()
        }
        Layer::CryptoObject | Layer::CryptoMaterial => {
            let coverage = film.layers.coverage.as_deref().ok_or_else(|| unrecorded(layer))?;
            shapes.matte(layer).ok_or_else(|| unrecorded(layer))?.channels(coverage)
        }
        Layer::ObjectId | Layer::MaterialId | Layer::NodeId => {
            let numbers = shapes.numbers(layer);
            let number = |sample: &CentreSample| {
                let number = sample.instance.and_then(|instance| numbers.get(instance as usize));
                number.copied().unwrap_or(0)
            };
            let samples = ExrSamples::Uint(centres(layer, film)?.par_iter().map(number).collect());
            vec![ExrChannel { name: layer.name().to_owned(), samples }]
        }
        _ => {
            let centres = centres(layer, film)?;
            let channel = |&(name, value): &(&str, Value)| ExrChannel {
                name: name.to_owned(),
                samples: ExrSamples::Float(centres.par_iter().map(|s| finite_f32(value(s))).collect()),
            };
            data_channels(layer).iter().map(channel).collect()
        }
    })
}

/// What a channel says about the middle of a pixel.
type Value = fn(&CentreSample) -> f32;

/// The channels of a layer of data. Directions that grow downwards in the picture or the texture are turned, because
/// compositors count upwards.
fn data_channels(layer: Layer) -> &'static [(&'static str, Value)] {
    match layer {
        Layer::Depth => &[("Z", |s| if s.instance.is_some() { s.depth } else { DEPTH_OF_NOTHING })],
        Layer::Position => &[
            ("position.X", |s| s.position.x),
            ("position.Y", |s| s.position.y),
            ("position.Z", |s| s.position.z),
        ],
        Layer::Normal => &[
            ("normal.X", |s| s.shading_normal.x),
            ("normal.Y", |s| s.shading_normal.y),
            ("normal.Z", |s| s.shading_normal.z),
        ],
        Layer::GeometricNormal => &[
            ("geometric_normal.X", |s| s.geometric_normal.x),
            ("geometric_normal.Y", |s| s.geometric_normal.y),
            ("geometric_normal.Z", |s| s.geometric_normal.z),
        ],
        Layer::Albedo => {
            &[("albedo.R", |s| s.albedo.x), ("albedo.G", |s| s.albedo.y), ("albedo.B", |s| s.albedo.z)]
        }
        Layer::Uv => {
            &[("uv.U", |s| s.uv.x), ("uv.V", |s| if s.instance.is_some() { 1.0 - s.uv.y } else { 0.0 })]
        }
        Layer::Motion => &[
            ("forward.u", |s| s.motion_forward.x),
            ("forward.v", |s| -s.motion_forward.y),
            ("backward.u", |s| s.motion_back.x),
            ("backward.v", |s| -s.motion_back.y),
        ],
        _ => &[],
    }
}

fn light<T: Sync>(
    name: String,
    samples: LightSamples,
    pixels: &[T],
    value: impl Fn(&T) -> f32 + Sync,
) -> ExrChannel {
    let samples = match samples {
        LightSamples::Half => {
            ExrSamples::Half(pixels.par_iter().map(|pixel| half_from_f32(value(pixel))).collect())
        }
        LightSamples::Float => {
            ExrSamples::Float(pixels.par_iter().map(|pixel| finite_f32(value(pixel))).collect())
        }
    };
    ExrChannel { name, samples }
}

fn centres(layer: Layer, film: &Film) -> Result<&[CentreSample]> {
    film.layers.centres.as_deref().ok_or_else(|| unrecorded(layer))
}

fn unrecorded(layer: Layer) -> Error {
    Error::Internal { message: format!("the layer {} was not recorded", layer.name()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{LayerRequest, LightPart, PixelWindow};
    use glam::{Vec2, Vec3};

    /// Two pixels: the first shows instance 0, the second nothing.
    fn film() -> Film {
        let all = LayerRequest { light: true, centres: true, coverage: true };
        let mut film = Film::with_layers((2, 1), PixelWindow::full(2, 1), all);
        film.pixels = vec![[1.0, 2.0, 70000.0, 1.0], [0.0; 4]];
        film.layers.light.as_mut().unwrap()[0][LightPart::Direct as usize] = [0.25, 0.5, 0.75];
        film.layers.centres.as_mut().unwrap()[0] = CentreSample {
            instance: Some(0),
            depth: 3.0,
            position: Vec3::new(1.0, 2.0, 3.0),
            uv: Vec2::new(0.25, 0.125),
            motion_forward: Vec2::new(5.0, 2.0),
            motion_back: Vec2::new(-5.0, -2.0),
            ..CentreSample::default()
        };
        film
    }

    fn values(layer: Layer, samples: LightSamples) -> Vec<(String, Vec<f32>)> {
        let shapes = ShapeIds::default();
        let channels = layer_channels(layer, &film(), samples, &shapes).unwrap();
        let floats = |samples| match samples {
            ExrSamples::Half(halves) => halves.into_iter().map(half::f16::to_f32).collect(),
            ExrSamples::Float(floats) => floats,
            ExrSamples::Uint(_) => panic!("whole numbers"),
        };
        channels.into_iter().map(|channel| (channel.name, floats(channel.samples))).collect()
    }

    fn named(values: &[(&str, [f32; 2])]) -> Vec<(String, Vec<f32>)> {
        values.iter().map(|(name, pair)| ((*name).to_owned(), pair.to_vec())).collect()
    }

    #[test]
    fn light_is_half_or_float() {
        let beauty = values(Layer::Beauty, LightSamples::Half);
        assert_eq!(beauty[2], ("B".to_owned(), vec![65504.0, 0.0]));
        assert_eq!(values(Layer::Beauty, LightSamples::Float)[2].1, [70000.0, 0.0]);
        let direct = values(Layer::Light(LightPart::Direct), LightSamples::Half);
        let expected =
            named(&[("direct.R", [0.25, 0.0]), ("direct.G", [0.5, 0.0]), ("direct.B", [0.75, 0.0])]);
        assert_eq!(direct, expected);
    }

    #[test]
    fn directions_grow_as_compositors_count() {
        let half = LightSamples::Half;
        // From 2 rows down to 2 units up less; from an eighth below the top to seven eighths above the bottom.
        let expected = named(&[
            ("forward.u", [5.0, 0.0]),
            ("forward.v", [-2.0, 0.0]),
            ("backward.u", [-5.0, 0.0]),
            ("backward.v", [2.0, 0.0]),
        ]);
        assert_eq!(values(Layer::Motion, half), expected);
        assert_eq!(values(Layer::Uv, half), named(&[("uv.U", [0.25, 0.0]), ("uv.V", [0.875, 0.0])]));
        assert_eq!(values(Layer::Depth, half), named(&[("Z", [3.0, DEPTH_OF_NOTHING])]));
    }

    #[test]
    fn what_is_not_recorded_is_not_made_up() {
        let film = Film::new((2, 1), PixelWindow::full(2, 1));
        for layer in Layer::ALL {
            let channels = layer_channels(layer, &film, LightSamples::Half, &ShapeIds::default());
            assert_eq!(channels.is_ok(), layer == Layer::Beauty, "{}", layer.name());
        }
    }
}
