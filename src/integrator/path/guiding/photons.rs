//! Photons: light that is followed from its sources to the diffuse surfaces that it reaches.

use std::ops::Range;

use rayon::prelude::*;

use super::focusing_materials::may_focus_light;
use super::photon::{BATCH, Photon, PhotonPath, PhotonRay, PhotonStore, STORED_BY_BATCH};
use super::photon_sources::{EmittedPhoton, PhotonSources};
use crate::integrator::last_scatter::LastScatter;
use crate::integrator::random::Seed;
use crate::integrator::tracing::Tracer;
use crate::integrator::zsobol::ZSobol;
use crate::integrator::{IntegratorContext, LightPass, RayKind, RayState};
use crate::interaction::RayDifferential;

/// Photons for each sample of a pixel. They take about the time of as many pixels.
const PHOTONS_PER_SAMPLE: u32 = 4096;
/// The least and the most photons.
const PHOTON_LIMITS: [u32; 2] = [1 << 14, 1 << 18];

/// The first photons decide whether others are traced.
const FIRST_BATCHES: u32 = 8;
/// Where smooth surfaces focus less than this share of the light that arrives, paths find it well enough.
const LEAST_CAUSTIC_SHARE: f32 = 0.01;

/// The photons of a frame.
pub(super) struct PhotonTracing<'c, 'a> {
    context: &'c IntegratorContext<'a>,
    sources: PhotonSources<'c, 'a>,
    points: ZSobol,
    count: u32,
}

impl<'c, 'a> PhotonTracing<'c, 'a> {
    /// `None` where nothing emits photons, or nothing can focus them.
    pub(super) fn new(context: &'c IntegratorContext<'a>) -> Option<Self> {
        if !context.view.frame.materials.iter().any(may_focus_light) {
            return None;
        }
        let sources = PhotonSources::new(context)?;
        let count = photon_count(context.settings.max_samples);
        Some(Self { context, sources, points: ZSobol::new(count, 0), count })
    }

    /// The first stored photons; `None` where smooth surfaces focus little light.
    pub(super) fn first(&self) -> Option<Vec<Photon>> {
        let PhotonStore { photons, direct_power } = self.trace(0..FIRST_BATCHES);
        let power: f32 = photons.iter().map(|photon| photon.power).sum();
        let caustics = photons.iter().filter(|photon| photon.path == PhotonPath::Caustic);
        let caustic_power: f32 = caustics.map(|photon| photon.power).sum();
        (caustic_power > LEAST_CAUSTIC_SHARE * (power + direct_power)).then_some(photons)
    }

    /// The share of the first ones.
    pub(super) fn first_share(&self) -> f32 {
        (FIRST_BATCHES * BATCH) as f32 / self.count as f32
    }

    /// All others.
    pub(super) fn rest(&self) -> Vec<Photon> {
        self.trace(FIRST_BATCHES..self.count / BATCH).photons
    }

    fn trace(&self, batches: Range<u32>) -> PhotonStore {
        let stores: Vec<PhotonStore> = batches.into_par_iter().map(|number| self.batch(number)).collect();
        let mut all = PhotonStore::default();
        for store in stores {
            all.direct_power += store.direct_power;
            all.photons.extend(store.photons);
        }
        all
    }

    fn batch(&self, number: u32) -> PhotonStore {
        let indices = number * BATCH..(number + 1) * BATCH;
        let emitted: Vec<(u32, EmittedPhoton)> =
            indices.filter_map(|index| Some((index, self.sources.emit(index)?))).collect();
        let rays = (0..).zip(&emitted).map(|(sample, (index, photon))| {
            let ray = photon.ray;
            let media = self.context.media_at(ray.origin);
            let state = RayState {
                weight: photon.power,
                kind: RayKind::Reflection,
                light_pass: Some(LightPass::Direct),
                ..RayState::primary(RayDifferential::ZERO, media, sample, Seed::default())
            };
            let last = LastScatter { pdf: 1.0, position: ray.origin, depth: 0, normal: None, visible: None };
            PhotonRay { ray, state, last, sequence: self.points.sequence((0, 0), *index) }
        });
        let mut store = Tracer::new(self.context).trace_photons(rays);
        let unit = self.sources.power() / self.count as f32;
        store.direct_power *= unit;
        for photon in &mut store.photons {
            photon.power *= unit;
            photon.source_luminance = emitted[photon.index as usize].1.luminance;
        }
        store
    }
}

fn photon_count(samples: u32) -> u32 {
    let [least, most] = PHOTON_LIMITS;
    samples.saturating_mul(PHOTONS_PER_SAMPLE).clamp(least, most)
}

/// Bytes of the photons of a frame with some samples for each pixel, at most.
pub(crate) fn most_photon_bytes(samples: u32) -> usize {
    photon_count(samples) as usize / BATCH as usize * STORED_BY_BATCH * size_of::<Photon>()
}
