//! Photons: light that is followed from its sources to the surfaces where it lands.

use glam::Vec3;
use rayon::prelude::*;

use super::photon_sources::{EmittedPhoton, PhotonSources};
use crate::integrator::path::LastScatter;
use crate::integrator::random::Seed;
use crate::integrator::whitted::Tracer;
use crate::integrator::zsobol::ZSobol;
use crate::integrator::{ColorChannels, IntegratorContext, LightPass, RayKind, RayState};
use crate::interaction::RayDifferential;

/// Photons for each sample of a pixel. They take about the time of as many pixels.
const PHOTONS_PER_SAMPLE: u32 = 4096;
/// The least and the most photons.
const PHOTON_LIMITS: [u32; 2] = [1 << 14, 1 << 19];

/// Photons that are followed together.
const BATCH: u32 = 1024;

/// The first photons decide whether others are followed.
const FIRST_BATCHES: u32 = 8;
/// Where smooth surfaces focus less than this share of the light that lands, paths find it well enough.
const LEAST_FOCUSED_SHARE: f32 = 0.01;

/// What a photon met between its source and the surface where it lands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::integrator) enum PhotonPath {
    /// Nothing that bends it. Shadow rays find this light.
    Straight,
    /// Mirrors and clear glass.
    Focused,
    /// Some surface that scatters light.
    Scattered,
}

/// A photon at a diffuse surface.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct LandedPhoton {
    pub(in crate::integrator) position: Vec3,
    /// Unit vector, on the side where the photon lands.
    pub(in crate::integrator) normal: Vec3,
    /// Unit vector to where it came from.
    pub(in crate::integrator) direction: Vec3,
    pub(in crate::integrator) path: PhotonPath,
    /// Luminance of its power.
    pub(in crate::integrator) power: f32,
    /// Luminance of the radiance of its source.
    pub(in crate::integrator) source_luminance: f32,
    /// Index in its batch.
    pub(in crate::integrator) index: u32,
}

/// The photons of a frame that land after a surface turned them; `None` where smooth surfaces focus little light.
pub(super) fn indirect_photons(context: &IntegratorContext<'_>) -> Option<Vec<LandedPhoton>> {
    let sources = PhotonSources::new(context)?;
    let [least, most] = PHOTON_LIMITS;
    let count = context.settings.max_samples.saturating_mul(PHOTONS_PER_SAMPLE).clamp(least, most);
    let points = ZSobol::new(count, 0);
    let batches = |numbers: std::ops::Range<u32>| {
        let landed = numbers.into_par_iter().map(|number| batch(context, &sources, &points, (number, count)));
        landed.collect::<Vec<Vec<LandedPhoton>>>().concat()
    };

    let mut photons = batches(0..FIRST_BATCHES);
    let power = |is_counted: &dyn Fn(&LandedPhoton) -> bool| -> f32 {
        photons.iter().filter(|photon| is_counted(photon)).map(|photon| photon.power).sum()
    };
    let focused = power(&|photon| photon.path == PhotonPath::Focused);
    if focused <= LEAST_FOCUSED_SHARE * power(&|_| true) {
        return None;
    }
    photons.extend(batches(FIRST_BATCHES..count / BATCH));
    photons.retain(|photon| photon.path != PhotonPath::Straight);
    Some(photons)
}

/// Follows the photons of a batch.
fn batch(
    context: &IntegratorContext<'_>,
    sources: &PhotonSources<'_, '_>,
    points: &ZSobol,
    (number, count): (u32, u32),
) -> Vec<LandedPhoton> {
    let indices = number * BATCH..(number + 1) * BATCH;
    let emitted: Vec<(u32, EmittedPhoton)> =
        indices.filter_map(|index| Some((index, sources.emit(index)?))).collect();
    let rays = (0..).zip(&emitted).map(|(sample, (index, photon))| {
        let state = RayState {
            differential: RayDifferential::ZERO,
            media: context.media_at(photon.ray.origin),
            touching: None,
            weight: photon.power,
            kind: RayKind::Reflection,
            channels: ColorChannels::White,
            light_pass: Some(LightPass::Direct),
            guide_share: 1.0,
            unguided_ratio: 1.0,
            sees_peaks: true,
            depth: 0,
            sample,
            seed: Seed::default(),
        };
        let last = LastScatter { pdf: 1.0, position: photon.ray.origin, normal: None, visible: None };
        (photon.ray, state, last, points.sequence((0, 0), *index))
    });
    let mut landed = Tracer::new(context).follow_photons(rays);
    let unit = sources.power() / count as f32;
    for photon in &mut landed {
        photon.power *= unit;
        photon.source_luminance = emitted[photon.index as usize].1.luminance;
    }
    landed
}
