//! Tracing of single frames into a film: their shutter samples and pixel centres.

use std::sync::{Arc, OnceLock};

use crate::bvh::BuildStatistics;
use crate::cancel::CancelFlag;
use crate::denoise::{Denoiser, NoisyImage};
use crate::error::{Error, Result};
use crate::film::{AovFlags, Film};
use crate::image::{PartHashes, Plate, SceneContent};
use crate::image_file::{FrameAttributes, SAMPLE_RANGE};
use crate::output::{InstanceIds, frame_attributes};
use crate::render::{
    EnvironmentShares, Integrator, PathFrame, RenderSettings, RenderStatistics, SceneView, ShutterSample,
    render_frame_into,
};

use super::checkpoint::Checkpoint;
use super::environment_shares::environment_shares;
use super::exposure::exposure_ev;
use super::pass_clock::PassClock;
use super::posed_frames::PosedFrames;
use super::scene_content::scene_content;
use super::scene_parts::{StaticHashes, part_hashes};
use super::{FrameProgress, Phases, SequenceJob};

/// Denoises the colours of a film. Returns those before.
fn denoise_film(denoiser: &Denoiser, film: &mut Film, cancel: &CancelFlag) -> Result<Vec<[f32; 3]>> {
    let Some(guides) = &film.aovs.guides else {
        return Err(Error::Internal { message: "the guides of denoising were not recorded".to_owned() });
    };
    let noisy: Vec<_> = film.pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
    let albedos: Vec<_> = guides.iter().map(|guide| guide.albedo.to_array()).collect();
    let normals: Vec<_> = guides.iter().map(|guide| guide.normal.to_array()).collect();
    let size = film.window.size();
    let image = NoisyImage { size, colors: &noisy, albedos: &albedos, normals: &normals };
    store_denoised(&mut film.pixels, &denoiser.denoise(image, cancel)?);
    Ok(noisy)
}

/// Replaces the colours of covered pixels. The others show the background, exactly.
fn store_denoised(pixels: &mut [[f32; 4]], denoised: &[[f32; 3]]) {
    for (pixel, denoised) in pixels.iter_mut().zip(denoised).filter(|(pixel, _)| pixel[3] != 0.0) {
        // Filters may overshoot.
        pixel[..3].copy_from_slice(&denoised.map(|channel| if channel > 0.0 { channel } else { 0.0 }));
    }
}

/// Receiver of a frame's progress.
pub(crate) type OnProgress<'a> = &'a (dyn Fn(FrameProgress) + Sync);

/// Traces frames of one job. Poses, BVHs and memory of a frame serve the next.
pub(crate) struct FrameTracer<'a> {
    job: &'a SequenceJob,
    cancel: &'a CancelFlag,
    /// The film of one shutter sample.
    scratch: Option<Film>,
    /// Ids and names of the mesh instances of all frames.
    instance_ids: Option<Arc<InstanceIds>>,
    posed: PosedFrames,
    /// Hashes of vertices and texels, computed once.
    static_hashes: OnceLock<StaticHashes>,
    /// The value of [`PartHashes::ATTRIBUTE`] where no clip plays and no plate changes.
    still_parts: OnceLock<String>,
    /// The value of [`SceneContent::ATTRIBUTE`].
    content: OnceLock<String>,
    /// The plate behind a frame.
    plate: Option<(i64, Arc<Plate>)>,
    /// Time of the frame being rendered.
    frame_seconds: f64,
    /// The exposure of all frames, stops, once it is known.
    exposure_ev: Option<f32>,
    /// The shares of the environment's light that the frames trace, if all trace the same.
    environment_shares: Option<EnvironmentShares>,
}

/// Statistics of a traced frame.
#[derive(Default)]
pub(crate) struct FrameStatistics {
    /// Of the last shutter sample.
    pub(crate) tree: BuildStatistics,
    pub(crate) rays: RenderStatistics,
    /// Whether the BVH was reused at every shutter sample.
    pub(crate) is_reused: bool,
    pub(crate) phases: Phases,
    /// Seconds of tracing in earlier runs, from whose checkpoint the frame was continued. They are a part of those of `rays`.
    pub(crate) earlier_seconds: f64,
}

impl FrameStatistics {
    /// Adds another band of the same frame.
    pub(super) fn add(&mut self, other: &Self) {
        self.tree = other.tree;
        self.rays.add(&other.rays);
        self.is_reused &= other.is_reused;
        self.phases.add(&other.phases);
        self.earlier_seconds += other.earlier_seconds;
    }
}

impl<'a> FrameTracer<'a> {
    pub(crate) fn new(job: &'a SequenceJob, cancel: &'a CancelFlag) -> Self {
        Self {
            job,
            cancel,
            scratch: None,
            instance_ids: None,
            posed: PosedFrames::default(),
            static_hashes: OnceLock::new(),
            still_parts: OnceLock::new(),
            content: OnceLock::new(),
            plate: None,
            frame_seconds: 0.0,
            exposure_ev: None,
            environment_shares: None,
        }
    }

    /// The same where the exposure of the job may be known.
    pub(super) fn with_exposure(self, exposure_ev: Option<f32>) -> Self {
        Self { exposure_ev, ..self }
    }

    /// Forgets the poses of earlier frames, which a panic may have left inconsistent.
    pub(super) fn reset(&mut self) {
        self.posed = PosedFrames::default();
    }

    /// A film with the AOVs of the job.
    pub(crate) fn empty_film(job: &SequenceJob) -> Film {
        let settings = &job.render;
        Film::with_aovs(settings.resolution, settings.window, settings.aovs)
    }

    /// Renders the window of `film` of a frame: the mean of its shutter samples, then the pixel centres. Passes of paths are kept in
    /// `checkpoint`.
    /// `on_progress` is called from worker threads.
    pub(crate) fn render(
        &mut self,
        frame: i64,
        film: &mut Film,
        checkpoint: Option<&Checkpoint<'_>>,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStatistics> {
        let time_seconds = self.job.rate.time_seconds(frame);
        self.frame_seconds = time_seconds;
        self.find_exposure()?;
        let SequenceJob { selection, render, .. } = self.job;
        self.environment_shares = environment_shares(self.job, selection, render, self.cancel)?;
        let times = self.job.shutter.times(time_seconds, self.job.rate);
        let mut rendered = match self.job.render.integrator {
            Integrator::Whitted => self.render_trees(&times, film, on_progress)?,
            Integrator::Path => self.render_paths(&times, film, checkpoint, on_progress)?,
        };
        if film.aovs.centers.is_some() {
            let phases = self.posed.record_pixel_centers(self.job, frame, film, self.cancel)?;
            rendered.phases.add(&phases);
            rendered.rays.trace_seconds += phases.trace;
        }
        film.noisy = match &self.job.denoiser {
            Some(denoiser) => Some(denoise_film(denoiser, film, self.cancel)?),
            None => None,
        };
        film.plate = self.plate(frame)?;
        Ok(rendered)
    }

    /// Finds the exposure where frames are rendered by it.
    fn find_exposure(&mut self) -> Result<()> {
        if self.job.renders_by_exposure() && self.exposure_ev.is_none() {
            self.exposure_ev = Some(exposure_ev(self.job, self.cancel)?);
        }
        Ok(())
    }

    /// Renders the mean of the shutter samples at `times` by Whitted's tree.
    fn render_trees(
        &mut self,
        times: &[f64],
        film: &mut Film,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStatistics> {
        let mut rendered = FrameStatistics { is_reused: true, ..FrameStatistics::default() };
        for (index, &time_seconds) in times.iter().enumerate() {
            self.pose(time_seconds, &mut rendered)?;
            let sample = ShutterSample { index: index as u32, count: times.len() as u32 };
            let rays = if index == 0 {
                self.trace(film, sample, on_progress)?
            } else {
                let scratch = self.scratch.take().filter(|scratch| scratch.window == film.window);
                let mut scratch = scratch.unwrap_or_else(|| {
                    let summed = AovFlags { centers: false, ..film.aovs.flags() };
                    Film::with_aovs(film.resolution, film.window, summed)
                });
                let traced = self.trace(&mut scratch, sample, on_progress);
                film.add(&scratch);
                self.scratch = Some(scratch);
                traced?
            };
            rendered.rays.add(&rays);
        }
        if times.len() > 1 {
            film.resolve_mean(times.len() as u32);
        }
        Ok(rendered)
    }

    /// Renders the samples of the shutter samples at `times` by paths, pass by pass.
    fn render_paths(
        &mut self,
        times: &[f64],
        film: &mut Film,
        checkpoint: Option<&Checkpoint<'_>>,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStatistics> {
        let (job, cancel, settings) = (self.job, self.cancel, &self.settings_of(film));
        let count = times.len() as u32;
        let stored = match checkpoint {
            Some(checkpoint) => checkpoint.load(settings, count)?,
            None => None,
        };
        let new = || (PathFrame::new(settings, count), RenderStatistics::default());
        let (mut frame, rays) = stored.unwrap_or_else(new);
        let mut clock = PassClock::new(job, count, frame.samples_taken());
        let earlier_seconds = rays.trace_seconds;
        let mut rendered =
            FrameStatistics { rays, earlier_seconds, is_reused: true, ..FrameStatistics::default() };
        while let Some(most) = clock.most_samples()
            && let Some(pass) = frame.next_pass(most)
        {
            let before = frame.progress();
            let after = before.samples + pass.samples() * count;
            for (index, &time_seconds) in times.iter().enumerate() {
                let sample = ShutterSample { index: index as u32, count };
                if frame.samples_of(settings, (&pass, sample)).is_empty() {
                    continue;
                }
                self.pose(time_seconds, &mut rendered)?;
                let view = self.view()?;
                let share = |share: f32| {
                    let of_pass = (index as f32 + share) / count as f32;
                    let samples = before.samples as f32 + of_pass * (after - before.samples) as f32;
                    let share = (samples / before.most_samples as f32).min(1.0);
                    on_progress(FrameProgress { share, path: Some(before) });
                };
                let rays = frame.add(&view, settings, (&pass, sample), cancel, &share)?;
                rendered.rays.add(&rays);
            }
            frame.finish(&pass);
            clock.finish(&pass);
            if let Some(checkpoint) = checkpoint {
                let saved = checkpoint.save(&frame, &rendered.rays);
                // Nothing continues a finished frame.
                let is_last = clock.most_samples().is_none_or(|most| frame.next_pass(most).is_none());
                if !(is_last && matches!(saved, Err(Error::Refused { .. }))) {
                    saved?;
                }
            }
        }
        // A complete checkpoint leaves no pass that poses the scene.
        if let (None, Some(&time_seconds)) = (&self.posed.bvh, times.last()) {
            self.pose(time_seconds, &mut rendered)?;
        }
        frame.sums().resolve_into(film);
        film.sums = settings.path.sample_range.is_some().then(|| Box::new(frame.into_sums()));
        Ok(rendered)
    }

    /// Poses the scene and builds its BVH, unless no triangle moved.
    fn pose(&mut self, time_seconds: f64, rendered: &mut FrameStatistics) -> Result<()> {
        let mut phases = Phases::default();
        rendered.is_reused &= self.posed.advance(self.job, time_seconds, self.cancel, &mut phases)?;
        rendered.phases.add(&phases);
        if let Some(bvh) = &self.posed.bvh {
            rendered.tree = bvh.statistics();
        }
        Ok(())
    }

    /// The plate behind a frame.
    fn plate(&mut self, frame: i64) -> Result<Option<Arc<Plate>>> {
        let Some(plates) = &self.job.plates else { return Ok(None) };
        if let Some((of_frame, plate)) = &self.plate
            && plates.is_same(*of_frame, frame)
        {
            return Ok(Some(plate.clone()));
        }
        let settings = &self.job.render;
        let plate = Arc::new(plates.plate(frame, settings.resolution, settings.window)?);
        self.plate = Some((frame, plate.clone()));
        Ok(Some(plate))
    }

    /// The posed scene.
    fn view(&self) -> Result<SceneView<'_>> {
        let Some(bvh) = &self.posed.bvh else {
            return Err(Error::Internal { message: "there is no BVH to trace".to_owned() });
        };
        let SequenceJob { scene, environment, .. } = self.job;
        Ok(SceneView { scene, frame: &self.posed.current, bvh, environment })
    }

    /// Traces the posed scene.
    fn trace(
        &self,
        film: &mut Film,
        sample: ShutterSample,
        on_progress: OnProgress<'_>,
    ) -> Result<RenderStatistics> {
        let on_share = |share: f32| {
            let share = (sample.index as f32 + share) / sample.count as f32;
            on_progress(FrameProgress { share, path: None });
        };
        let settings = self.settings_of(film);
        Ok(render_frame_into(film, &self.view()?, &settings, sample, self.cancel, &on_share)?)
    }

    /// The settings of the job for the window of `film`.
    fn settings_of(&self, film: &Film) -> RenderSettings {
        RenderSettings {
            window: film.window,
            noise_time: Some(self.frame_seconds),
            exposure_ev: self.exposure_ev.unwrap_or_default(),
            environment_shares: self.environment_shares.clone(),
            ..self.job.render.clone()
        }
    }

    /// The exposure of all frames, stops; `None` where none was needed so far.
    pub(crate) fn exposure_ev(&self) -> Option<f32> {
        self.exposure_ev
    }

    /// EXR attributes of a frame, without a stamp.
    pub(crate) fn attributes(&self, frame: i64, render_hash: &str) -> FrameAttributes {
        let time_seconds = self.job.rate.time_seconds(frame);
        let camera = &self.posed.camera_at(self.job, time_seconds);
        let resolution = self.job.render.resolution;
        let mut attributes = frame_attributes(
            frame,
            time_seconds,
            self.job.rate.as_exr_rational(),
            render_hash,
            (camera, resolution),
        );
        attributes.texts.push((PartHashes::ATTRIBUTE.to_owned(), self.parts_text(frame)));
        if self.job.exr.lists_content {
            let content =
                self.content.get_or_init(|| scene_content(&self.job.scene, &self.job.selection.clips).text());
            attributes.texts.push((SceneContent::ATTRIBUTE.to_owned(), content.clone()));
        }
        let range = self.job.render.sample_range_text();
        attributes.texts.extend(range.map(|range| (SAMPLE_RANGE.to_owned(), range)));
        attributes
    }

    /// The hashes of the parts of the scene at the time of a frame, which are those of any other where no clip plays and no plate changes.
    fn parts_text(&self, frame: i64) -> String {
        let statics = || self.static_hashes.get_or_init(|| StaticHashes::of(&self.job.scene));
        let text = || part_hashes(self.job, statics(), frame).text();
        let is_still = self.job.selection.clips.is_empty()
            && self.job.plates.as_ref().is_none_or(|plates| !plates.differ());
        if is_still { self.still_parts.get_or_init(text).clone() } else { text() }
    }

    /// Ids and names of the mesh instances, computed once and only for AOVs that need them.
    pub(crate) fn instance_ids(&mut self) -> Arc<InstanceIds> {
        let exr = &self.job.exr;
        let frame = &self.posed.current;
        let compute = || {
            if exr.needs_instances() {
                Arc::new(InstanceIds::new(&self.job.scene, &frame.instances, &exr.aovs))
            } else {
                Arc::default()
            }
        };
        self.instance_ids.get_or_insert_with(compute).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn denoising_changes_covered_pixels_alone() {
        let mut pixels = [[0.0; 4], [0.2, 0.3, 0.4, 0.5], [0.25, 0.25, 0.25, 0.0], [1.0; 4]];
        store_denoised(&mut pixels, &[[0.1; 3], [0.3, -0.1, 0.5], [0.2; 3], [f32::NAN, 0.5, 2.0]]);
        assert_eq!(pixels, [[0.0; 4], [0.3, 0.0, 0.5, 0.5], [0.25, 0.25, 0.25, 0.0], [0.0, 0.5, 2.0, 1.0]]);
    }
}
