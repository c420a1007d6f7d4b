//! Conversion of a film's AOVs to image channels.

use std::borrow::Cow;

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::film::{Film, GuideSample, LightPass, LightPasses, PixelCenterSample};
use crate::image::{Channel, Samples, finite_f32, halves_from_f32};

use super::instance_ids::InstanceIds;
use super::{Aov, LightSamples};

/// `Z` where the camera ray hits nothing, metres: a finite value beyond every scene, so that depth compositing and fog work.
pub const DEPTH_WITHOUT_HIT: f32 = 1e10;

/// Channels of the scene without the plate behind it. Files have them over display-referred plates, so that the scene can be
/// tone-mapped alone.
pub const SCENE_CHANNELS: [&str; 4] = ["scene.R", "scene.G", "scene.B", "scene.A"];

/// Channels of the colours before they were denoised.
const NOISY_CHANNELS: [&str; 3] = ["noisy.R", "noisy.G", "noisy.B"];

/// Pixels that are rounded to halves together.
const PIXELS_AT_ONCE: usize = 1024;

/// Channels of one AOV of `film`.
///
/// # Errors
/// [`Error::Internal`] when the film did not record the AOV.
pub(super) fn aov_channels(
    aov: Aov,
    film: &Film,
    samples: LightSamples,
    ids: &InstanceIds,
) -> Result<Vec<Channel>> {
    Ok(match aov {
        Aov::Beauty => {
            let mut channels = rgba_channels(["R", "G", "B", "A"], samples, &film.pixels_over_plate());
            if film.plate.as_ref().is_some_and(|plate| plate.is_display_referred) {
                channels.extend(rgba_channels(SCENE_CHANNELS, samples, &film.pixels));
            }
            if let Some(noisy) = film.noisy_over_plate() {
                let channel = |(c, name): (usize, &str)| light(name.to_owned(), samples, &noisy, |p| p[c]);
                channels.extend(NOISY_CHANNELS.into_iter().enumerate().map(channel));
            }
            channels
        }
        Aov::Light(pass) => {
            let passes = film.aovs.light.as_deref().ok_or_else(|| unrecorded(aov))?;
            let passes = with_plate(film, pass, passes);
            let name = |channel| format!("{}.{channel}", pass.name());
            let channel = |(c, channel)| light(name(channel), samples, &passes, |p| p[pass as usize][c]);
            ["R", "G", "B"].into_iter().enumerate().map(channel).collect()
        }
        Aov::CryptoObject | Aov::CryptoMaterial => {
            let coverage = film.aovs.coverage.as_deref().ok_or_else(|| unrecorded(aov))?;
            ids.matte(aov).ok_or_else(|| unrecorded(aov))?.channels(coverage)
        }
        Aov::Variance | Aov::SampleCount => noise_channels(aov, film)?,
        Aov::DenoisingAlbedo | Aov::DenoisingNormal => guide_channels(aov, film)?,
        Aov::ObjectId | Aov::MaterialId | Aov::NodeId => {
            let numbers = ids.numbers(aov);
            let number = |sample: &PixelCenterSample| {
                let instance = sample.instance.and_then(|instance| numbers.get(instance as usize));
                instance.copied().unwrap_or(0)
            };
            let samples = Samples::Uint(centers(aov, film)?.par_iter().map(number).collect());
            vec![Channel { name: aov.name().to_owned(), samples }]
        }
        _ => {
            let centers = centers(aov, film)?;
            let channel = |&(name, value): &(&str, Value)| Channel {
                name: name.to_owned(),
                samples: Samples::Float(centers.par_iter().map(|s| finite_f32(value(s))).collect()),
            };
            data_channels(aov).iter().map(channel).collect()
        }
    })
}

fn noise_channels(aov: Aov, film: &Film) -> Result<Vec<Channel>> {
    let noise = film.aovs.noise.as_deref().ok_or_else(|| unrecorded(aov))?;
    if aov == Aov::SampleCount {
        let samples = Samples::Uint(noise.iter().map(|noise| noise.samples).collect());
        return Ok(vec![Channel { name: aov.name().to_owned(), samples }]);
    }
    let channel = |(c, name): (usize, &str)| Channel {
        name: format!("{}.{name}", aov.name()),
        samples: Samples::Float(noise.iter().map(|noise| finite_f32(noise.variance[c])).collect()),
    };
    Ok(["R", "G", "B"].into_iter().enumerate().map(channel).collect())
}

fn guide_channels(aov: Aov, film: &Film) -> Result<Vec<Channel>> {
    let guides = film.aovs.guides.as_deref().ok_or_else(|| unrecorded(aov))?;
    let (channels, guide): (_, fn(&GuideSample) -> Vec3) = match aov {
        Aov::DenoisingAlbedo => (["R", "G", "B"], |guide| guide.albedo),
        _ => (["X", "Y", "Z"], |guide| guide.normal),
    };
    let channel = |(c, name): (usize, &str)| Channel {
        name: format!("{}.{name}", aov.name()),
        samples: Samples::Float(guides.iter().map(|sample| finite_f32(guide(sample)[c])).collect()),
    };
    Ok(channels.into_iter().enumerate().map(channel).collect())
}

/// Channels of all AOVs that sums give and `film` has recorded.
///
/// # Errors
/// None, for a film of such AOVs.
pub fn summed_channels(film: &Film, samples: LightSamples) -> Result<Vec<Channel>> {
    let mut channels = Vec::new();
    for aov in Aov::ALL {
        let is_recorded = match aov {
            Aov::Beauty => true,
            Aov::Light(_) => film.aovs.light.is_some(),
            Aov::Variance | Aov::SampleCount => film.aovs.noise.is_some(),
            Aov::DenoisingAlbedo | Aov::DenoisingNormal => film.aovs.guides.is_some(),
            _ => false,
        };
        if is_recorded {
            channels.extend(aov_channels(aov, film, samples, &InstanceIds::default())?);
        }
    }
    Ok(channels)
}

/// Value of a channel for a pixel-centre sample.
type Value = fn(&PixelCenterSample) -> f32;

/// Channels of a data AOV. Vertical directions of images and textures are flipped, because compositors count upwards.
fn data_channels(aov: Aov) -> &'static [(&'static str, Value)] {
    match aov {
        Aov::Depth => &[("Z", |s| if s.instance.is_some() { s.depth } else { DEPTH_WITHOUT_HIT })],
        Aov::Position => &[
            ("position.X", |s| s.position.x),
            ("position.Y", |s| s.position.y),
            ("position.Z", |s| s.position.z),
        ],
        Aov::Normal => &[
            ("normal.X", |s| s.shading_normal.x),
            ("normal.Y", |s| s.shading_normal.y),
            ("normal.Z", |s| s.shading_normal.z),
        ],
        Aov::GeometricNormal => &[
            ("geometric_normal.X", |s| s.geometric_normal.x),
            ("geometric_normal.Y", |s| s.geometric_normal.y),
            ("geometric_normal.Z", |s| s.geometric_normal.z),
        ],
        Aov::Albedo => {
            &[("albedo.R", |s| s.albedo.x), ("albedo.G", |s| s.albedo.y), ("albedo.B", |s| s.albedo.z)]
        }
        Aov::Uv => {
            &[("uv.U", |s| s.uv.map_or(0.0, |uv| uv.x)), ("uv.V", |s| s.uv.map_or(0.0, |uv| 1.0 - uv.y))]
        }
        Aov::Motion => &[
            ("forward.u", |s| s.motion_forward.x),
            ("forward.v", |s| -s.motion_forward.y),
            ("backward.u", |s| s.motion_back.x),
            ("backward.v", |s| -s.motion_back.y),
        ],
        _ => &[],
    }
}

fn rgba_channels(names: [&str; 4], samples: LightSamples, pixels: &[[f32; 4]]) -> Vec<Channel> {
    let channel = |(c, name): (usize, &str)| light(name.to_owned(), samples, pixels, |p| p[c]);
    names.into_iter().enumerate().map(channel).collect()
}

/// The light passes with the light of the plate, which is seen as an environment is.
fn with_plate<'f>(film: &Film, pass: LightPass, passes: &'f [LightPasses]) -> Cow<'f, [LightPasses]> {
    let Some(plate) = film.plate.as_ref().filter(|_| pass == LightPass::Environment) else {
        return Cow::Borrowed(passes);
    };
    let pixels = passes.iter().zip(&film.pixels).zip(&plate.pixels);
    let added = pixels.map(|((passes, pixel), plate)| {
        let mut passes = *passes;
        let light = passes[pass.index()].iter_mut().zip(plate);
        light.for_each(|(sum, channel)| *sum += channel * (1.0 - pixel[3]));
        passes
    });
    Cow::Owned(added.collect())
}

fn light<T: Sync>(
    name: String,
    samples: LightSamples,
    pixels: &[T],
    value: impl Fn(&T) -> f32 + Sync,
) -> Channel {
    let samples = match samples {
        LightSamples::Half => {
            let mut halves = vec![f16::ZERO; pixels.len()];
            let rows = halves.par_chunks_mut(PIXELS_AT_ONCE).zip(pixels.par_chunks(PIXELS_AT_ONCE));
            rows.for_each(|(halves, pixels)| {
                let mut values = [0.0; PIXELS_AT_ONCE];
                values.iter_mut().zip(pixels).for_each(|(stored, pixel)| *stored = value(pixel));
                halves_from_f32(&values[..pixels.len()], halves);
            });
            Samples::Half(halves)
        }
        LightSamples::Float => {
            Samples::Float(pixels.par_iter().map(|pixel| finite_f32(value(pixel))).collect())
        }
    };
    Channel { name, samples }
}

fn centers(aov: Aov, film: &Film) -> Result<&[PixelCenterSample]> {
    film.aovs.centers.as_deref().ok_or_else(|| unrecorded(aov))
}

fn unrecorded(aov: Aov) -> Error {
    Error::Internal { message: format!("the AOV {} was not recorded", aov.name()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{AovFlags, PixelWindow};
    use crate::image::Plate;
    use glam::Vec2;
    use std::sync::Arc;

    /// Two pixels: the first hits instance 0, the second nothing.
    fn film() -> Film {
        let all = AovFlags { light: true, centers: true, coverage: true, noise: true, guides: true };
        let mut film = Film::with_aovs((2, 1), PixelWindow::full(2, 1), all);
        film.pixels = vec![[1.0, 2.0, 70000.0, 1.0], [0.0; 4]];
        film.aovs.light.as_mut().unwrap()[0][LightPass::Direct as usize] = [0.25, 0.5, 0.75];
        film.aovs.centers.as_mut().unwrap()[0] = PixelCenterSample {
            instance: Some(0),
            depth: 3.0,
            position: Vec3::new(1.0, 2.0, 3.0),
            uv: Some(Vec2::new(0.25, 0.125)),
            motion_forward: Vec2::new(5.0, 2.0),
            motion_back: Vec2::new(-5.0, -2.0),
            ..PixelCenterSample::default()
        };
        film
    }

    fn values(aov: Aov, samples: LightSamples) -> Vec<(String, Vec<f32>)> {
        let ids = InstanceIds::default();
        let channels = aov_channels(aov, &film(), samples, &ids).unwrap();
        let floats = |samples| match samples {
            Samples::Half(halves) => halves.into_iter().map(half::f16::to_f32).collect(),
            Samples::Float(floats) => floats,
            Samples::Uint(_) => panic!("integers"),
        };
        channels.into_iter().map(|channel| (channel.name, floats(channel.samples))).collect()
    }

    fn named(values: &[(&str, [f32; 2])]) -> Vec<(String, Vec<f32>)> {
        values.iter().map(|(name, pair)| ((*name).to_owned(), pair.to_vec())).collect()
    }

    #[test]
    fn light_is_half_or_float() {
        let beauty = values(Aov::Beauty, LightSamples::Half);
        assert_eq!(beauty[2], ("B".to_owned(), vec![65504.0, 0.0]));
        assert_eq!(values(Aov::Beauty, LightSamples::Float)[2].1, [70000.0, 0.0]);
        let direct = values(Aov::Light(LightPass::Direct), LightSamples::Half);
        let expected =
            named(&[("direct.R", [0.25, 0.0]), ("direct.G", [0.5, 0.0]), ("direct.B", [0.75, 0.0])]);
        assert_eq!(direct, expected);
    }

    #[test]
    fn noisy_colours_lie_over_the_plate_as_denoised_ones_do() {
        let mut film = film();
        film.pixels[1] = [0.5, 0.25, 0.0, 0.75];
        // A denoiser that changes nothing.
        film.noisy = Some(film.pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect());
        for is_display_referred in [false, true] {
            let pixels = vec![[0.5, 1.0, 2.0, 1.0]; 2];
            film.plate = Some(Arc::new(Plate { pixels, is_display_referred }));
            let ids = InstanceIds::default();
            let channels = aov_channels(Aov::Beauty, &film, LightSamples::Float, &ids).unwrap();
            let samples = |name: &str| &channels.iter().find(|channel| channel.name == name).unwrap().samples;
            assert_eq!(samples("noisy.R"), &Samples::Float(vec![1.0, 0.625]));
            for name in ["R", "G", "B"] {
                assert_eq!(samples(&format!("noisy.{name}")), samples(name), "{name}");
            }
        }
    }

    #[test]
    fn vertical_directions_grow_upwards() {
        let half = LightSamples::Half;
        // 2 rows downwards are −2; an eighth below the top is seven eighths above the bottom.
        let expected = named(&[
            ("forward.u", [5.0, 0.0]),
            ("forward.v", [-2.0, 0.0]),
            ("backward.u", [-5.0, 0.0]),
            ("backward.v", [2.0, 0.0]),
        ]);
        assert_eq!(values(Aov::Motion, half), expected);
        assert_eq!(values(Aov::Uv, half), named(&[("uv.U", [0.25, 0.0]), ("uv.V", [0.875, 0.0])]));
        assert_eq!(values(Aov::Depth, half), named(&[("Z", [3.0, DEPTH_WITHOUT_HIT])]));
    }

    #[test]
    fn a_surface_without_texture_coordinates_has_zeros() {
        let mut film = film();
        film.aovs.centers.as_mut().unwrap()[0].uv = None;
        for channel in aov_channels(Aov::Uv, &film, LightSamples::Half, &InstanceIds::default()).unwrap() {
            assert_eq!(channel.samples, Samples::Float(vec![0.0, 0.0]), "{}", channel.name);
        }
    }

    #[test]
    fn aovs_that_were_not_recorded_are_errors() {
        let film = Film::new((2, 1), PixelWindow::full(2, 1));
        for aov in Aov::ALL {
            let channels = aov_channels(aov, &film, LightSamples::Half, &InstanceIds::default());
            assert_eq!(channels.is_ok(), aov == Aov::Beauty, "{}", aov.name());
        }
    }
}
