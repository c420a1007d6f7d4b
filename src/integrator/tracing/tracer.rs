//! The tracer of batches of samples and its buffers.

use std::time::Instant;

use glam::Vec3;

use super::receiver_shadows::{ReceivedLight, ReceiverShadows};
use super::shading_order::ShadingOrder;
use super::shadow_queue::ShadowQueue;
use super::transmission_probes::TransmissionProbes;
use crate::bvh::{Hit, TraversalCounters};
use crate::integrator::albedo_slices::AlbedoSlices;
use crate::integrator::camera_samples::CameraRayBatch;
use crate::integrator::media::MediaCache;
use crate::integrator::path::PathBuffers;
use crate::integrator::sample_aovs::{InstanceCoverage, SampleAovFlags, SampleAovs};
use crate::integrator::surface_hit::SurfaceHit;
use crate::integrator::wavefront::Wavefront;
use crate::integrator::whitted::WhittedBuffers;
use crate::integrator::zsobol::SampleSequence;
use crate::integrator::{
    CameraRays, CameraSamples, GuideSample, IntegratorContext, IntegratorStatistics, LightPass, LightPasses,
};
use crate::interaction::{MaterialSample, SurfaceBlock};

/// Value of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleValue {
    /// Radiance, multiplied by coverage.
    pub radiance: Vec3,
    /// Share of the sample that surfaces or a visible background cover.
    pub coverage: f32,
}

impl SampleValue {
    /// Red, green, blue and coverage.
    #[inline]
    pub fn to_array(self) -> [f32; 4] {
        let [red, green, blue] = self.radiance.to_array();
        [red, green, blue, self.coverage]
    }
}

/// Traces batches of samples one after the other and keeps its buffers between them.
#[derive(Debug)]
pub struct Tracer<'w, 'a> {
    pub(in crate::integrator) context: &'w IntegratorContext<'a>,
    pub(in crate::integrator) values: Vec<SampleValue>,
    pub(super) camera_rays: CameraRayBatch,
    /// The closest hits of the camera rays.
    pub(super) camera_hits: Vec<Option<Hit>>,
    /// Indices of the samples whose camera rays see more than the background.
    pub(super) followed: Vec<u32>,
    /// The rays that are traced next.
    wavefront: Wavefront,
    /// The rays of the next depth.
    pub(in crate::integrator) children: Wavefront,
    pub(in crate::integrator) surface_hits: Vec<SurfaceHit>,
    /// Order in which the hits are shaded.
    pub(super) shading_order: ShadingOrder,
    /// The points of hits that are shaded one by one. Taken out while they are shaded.
    pub(super) surface_block: Option<Box<SurfaceBlock<'a>>>,
    /// Material values at those points.
    pub(super) block_materials: Vec<MaterialSample>,
    pub(in crate::integrator) shadows: ShadowQueue,
    /// Taken out while it is filled.
    pub(super) receiver_shadows: ReceiverShadows,
    /// The light on the first receiver of each ray that is followed; empty where nothing receives shadows.
    pub(super) first_receivers: Vec<Option<ReceivedLight>>,
    /// What rays that are followed see of the environment, where they hit nothing; empty where that is looked up ray by ray.
    pub(in crate::integrator) escaped_radiances: Vec<Option<Vec3>>,
    /// The sample points of each sample that is followed; empty where none are needed.
    pub(in crate::integrator) sequences: Vec<SampleSequence>,
    /// Surfaces that touch those of the shaded block.
    pub(super) probes: TransmissionProbes,
    pub(in crate::integrator) albedo_slices: AlbedoSlices,
    pub(super) media_cache: MediaCache,
    pub(in crate::integrator) aovs: SampleAovs,
    pub(in crate::integrator) counters: TraversalCounters,
    pub(in crate::integrator) statistics: IntegratorStatistics,
    /// What the shading of Whitted's tree keeps.
    pub(in crate::integrator) whitted: WhittedBuffers<'a>,
    /// What that of paths keeps.
    pub(in crate::integrator) path: PathBuffers,
}

impl<'w, 'a> Tracer<'w, 'a> {
    /// A tracer without rays.
    pub fn new(context: &'w IntegratorContext<'a>) -> Self {
        Self {
            context,
            values: Vec::new(),
            camera_rays: CameraRayBatch::default(),
            camera_hits: Vec::new(),
            followed: Vec::new(),
            wavefront: Wavefront::default(),
            children: Wavefront::default(),
            surface_hits: Vec::new(),
            shading_order: ShadingOrder::default(),
            surface_block: Some(Box::default()),
            block_materials: Vec::new(),
            shadows: ShadowQueue::new(context.shadow_passages()),
            receiver_shadows: ReceiverShadows::default(),
            first_receivers: Vec::new(),
            escaped_radiances: Vec::new(),
            sequences: Vec::new(),
            probes: TransmissionProbes::default(),
            albedo_slices: AlbedoSlices::default(),
            media_cache: MediaCache::default(),
            aovs: SampleAovs::default(),
            counters: TraversalCounters::default(),
            statistics: IntegratorStatistics::default(),
            whitted: WhittedBuffers::new(context.lights.len()),
            path: PathBuffers::default(),
        }
    }

    /// The same tracer, which also records light passes, instance coverage or guides.
    #[must_use]
    pub fn recording(self, flags: SampleAovFlags) -> Self {
        Self { aovs: SampleAovs::new(flags), ..self }
    }

    /// The values of the samples of the last batch.
    pub fn values(&self) -> &[SampleValue] {
        &self.values
    }

    /// The light passes of each sample of the last batch; empty unless they are recorded.
    pub fn light_passes(&self) -> &[LightPasses] {
        self.aovs.light()
    }

    /// The instances that the camera rays of the last batch see, in the order of the samples; empty unless they are
    /// recorded.
    pub fn coverage(&self) -> &[InstanceCoverage] {
        self.aovs.coverage()
    }

    /// The guides of each sample of the last batch; empty unless they are recorded.
    pub fn guides(&self) -> &[GuideSample] {
        self.aovs.guides()
    }

    /// Traces the camera rays of a batch of samples and all their descendants, and returns the values of the samples.
    pub fn trace(&mut self, camera: &CameraRays, samples: &CameraSamples<'_>) -> &[SampleValue] {
        let wavefront = self.trace_camera(camera, samples);
        self.trace_wavefronts(wavefront);
        &self.values
    }

    /// Begins a batch: traces its camera rays.
    pub(in crate::integrator) fn trace_camera(
        &mut self,
        camera: &CameraRays,
        samples: &CameraSamples<'_>,
    ) -> Wavefront {
        self.values.clear();
        self.values.resize(samples.len(), SampleValue::default());
        self.aovs.clear(samples.len());
        if self.context.sample_points.is_some() {
            self.sequences.resize(samples.len(), SampleSequence::default());
        }
        let mut wavefront = std::mem::take(&mut self.wavefront);
        self.find_camera_hits(camera, samples, &mut wavefront);
        wavefront
    }

    /// Traces the rays of the next depth, one for each sample, and all their descendants.
    pub(in crate::integrator) fn trace_children(&mut self) {
        self.values.clear();
        self.values.resize(self.sequences.len(), SampleValue::default());
        let mut wavefront = std::mem::take(&mut self.children);
        self.find_surface_hits(&mut wavefront);
        self.trace_wavefronts(wavefront);
    }

    fn trace_wavefronts(&mut self, mut wavefront: Wavefront) {
        while !wavefront.is_empty() {
            self.shade_surface_hits(&wavefront);
            wavefront.clear();
            std::mem::swap(&mut wavefront, &mut self.children);
            self.find_surface_hits(&mut wavefront);
        }
        self.wavefront = wavefront;
    }

    /// Returns the counters of all batches since the last call.
    pub fn take_statistics(&mut self) -> IntegratorStatistics {
        let TraversalCounters { nodes, triangles, .. } = std::mem::take(&mut self.counters);
        IntegratorStatistics { nodes, triangles, ..std::mem::take(&mut self.statistics) }
    }

    pub(in crate::integrator) fn add(&mut self, sample: u32, light_pass: LightPass, radiance: Vec3) {
        self.values[sample as usize].radiance += radiance;
        self.aovs.add(sample, light_pass, radiance);
    }
}

pub(in crate::integrator) fn seconds_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64()
}
