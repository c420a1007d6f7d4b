//! A frame of the path integrator, rendered pass by pass. Its sums are exact, so that the passes do not change the image.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use super::pixel_noise::{display_error, stopping_error};
use super::sample_plan::path_samples;
use super::settings::RenderSettings;
use super::shutter_sample::ShutterSample;
use super::statistics::RenderStatistics;
use super::tile_loop::render_tiles;
use crate::cancel::{CancelFlag, Cancelled};
use crate::color::exposure_scale;
use crate::film::{AovFlags, PixelWindow, SampleSums, SumFlags};
use crate::integrator::{Integrator, PathSettings, SampleRange};
use crate::scene_view::SceneView;

/// Samples after which pixels first decide whether they are done; later decisions come at twice the number.
pub(crate) const FIRST_DECISION: u32 = 32;

/// Samples that are traced for all unfinished pixels: indices among those of each shutter sample.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pass(Range<u32>);

impl Pass {
    /// Number of samples of each shutter sample.
    pub fn samples(&self) -> u32 {
        self.0.end - self.0.start
    }
}

/// The sums of a frame, and how far it is.
#[derive(Clone, Debug, PartialEq)]
pub struct PathFrame {
    sums: SampleSums,
    /// Pixels that take no more samples, where [`crate::render::PathSettings::noise`] is set.
    finished: Vec<bool>,
    /// Samples of each shutter sample that are done.
    taken: u32,
    /// Samples after which pixels decide next.
    decision: u32,
    /// Samples of each shutter sample.
    samples: Range<u32>,
    /// Samples of the frame that are rendered.
    range: Range<u32>,
    noise: Option<f32>,
    /// Factor of the exposure at which the noise is measured.
    exposure_scale: f32,
}

/// How far a frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathProgress {
    /// Samples that unfinished pixels have.
    pub samples: u32,
    /// Most samples of a pixel.
    pub most_samples: u32,
    /// Share of the pixels that are finished.
    pub finished_share: f32,
    /// Root mean square over the pixels of the standard error of display values from 0 to 1, where it is estimated.
    pub noise: Option<f32>,
}

impl PathFrame {
    /// What the frame sums; `None` for another integrator.
    pub fn sum_flags(integrator: Integrator, path: &PathSettings, aovs: AovFlags) -> Option<SumFlags> {
        // The noise is also shown while a time limit runs.
        let moments = aovs.noise || path.noise.is_some() || path.time_limit_seconds.is_some();
        let flags = SumFlags { moments, light: aovs.light, coverage: aovs.coverage, guides: aovs.guides };
        (integrator == Integrator::Path).then_some(flags)
    }

    /// A frame of `shutter_samples` without samples.
    pub fn new(settings: &RenderSettings, shutter_samples: u32) -> Self {
        let share = ShutterSample { index: 0, count: shutter_samples }.share_of(settings.samples);
        let noise = settings.path.noise;
        let flags = Self::sum_flags(settings.integrator, &settings.path, settings.aovs).unwrap_or_default();
        let all = 0..share.saturating_mul(shutter_samples);
        let range = settings.path.sample_range.map_or(all.clone(), |SampleRange { first, last }| {
            first.min(all.end)..last.saturating_add(1).min(all.end)
        });
        // With one shutter sample, the range is that of its samples.
        let samples = if shutter_samples == 1 { range.clone() } else { 0..share };
        Self {
            sums: SampleSums::new(settings.window, flags),
            finished: vec![false; settings.window.pixel_count()],
            taken: samples.start,
            decision: FIRST_DECISION.div_ceil(shutter_samples).max(2).min(samples.end),
            samples,
            range,
            noise,
            exposure_scale: exposure_scale(settings.exposure_ev),
        }
    }

    /// The samples to trace next, at most `most` of each shutter sample; `None` when the frame is done.
    pub fn next_pass(&self, most: u32) -> Option<Pass> {
        if self.taken >= self.samples.end || self.finished.iter().all(|&is_finished| is_finished) {
            return None;
        }
        let end = if self.noise.is_some() { self.decision } else { self.samples.end };
        let end = end.min(self.taken.saturating_add(most.max(1)));
        Some(Pass(self.taken..end))
    }

    /// Samples of a pass that belong to `shutter_sample`, by their indices among those of it. There are none where the frame's range has none.
    pub fn samples_of(
        &self,
        settings: &RenderSettings,
        (Pass(pass), shutter_sample): (&Pass, ShutterSample),
    ) -> Range<u32> {
        let count = shutter_sample.share_of(settings.samples);
        let before = shutter_sample.index * count;
        let first = pass.start.max(self.range.start.saturating_sub(before));
        first..pass.end.min(self.range.end.saturating_sub(before)).min(count)
    }

    /// Traces the samples of a pass that belong to `shutter_sample`. All shutter samples of a pass come before the next pass.
    pub fn add(
        &mut self,
        view: &SceneView<'_>,
        settings: &RenderSettings,
        (pass, shutter_sample): (&Pass, ShutterSample),
        cancel: &CancelFlag,
        on_progress: &(dyn Fn(f32) + Sync),
    ) -> Result<RenderStatistics, Cancelled> {
        let samples = self.samples_of(settings, (pass, shutter_sample));
        if samples.is_empty() {
            return Ok(RenderStatistics::default());
        }
        let first_index = shutter_sample.index * shutter_sample.share_of(settings.samples) + samples.start;
        let set = &path_samples(settings, shutter_sample, samples);

        let flags = self.sums.flags();
        let (window, finished) = (self.sums.window, &self.finished);
        let is_active = |(x, y): (u32, u32)| {
            !finished[(y - window.y0) as usize * window.width() as usize + (x - window.x0) as usize]
        };
        let sums = Mutex::new(&mut self.sums);
        render_tiles(view, settings, settings.aovs, on_progress, |renderer, tile: PixelWindow| {
            if !pixels_of(tile).any(is_active) {
                return Ok(RenderStatistics::default());
            }
            let mut part = SampleSums::new(tile, flags);
            let (non_finite_samples, integrator) =
                renderer.add_exact_samples(&mut part, set, first_index, is_active, cancel)?;
            sums.lock().unwrap_or_else(PoisonError::into_inner).merge(&part);
            Ok(RenderStatistics { integrator, non_finite_samples, ..RenderStatistics::default() })
        })
    }

    /// Ends a pass, all of whose shutter samples are added. Pixels with little noise take no more samples. A pixel decides by its own
    /// samples alone, so that crops decide alike.
    pub fn finish(&mut self, Pass(pass): &Pass) {
        self.taken = pass.end;
        let (Some(noise), Some(moments)) = (self.noise, &self.sums.moments) else { return };
        if self.taken < self.decision {
            return;
        }
        self.decision = self.samples.end.min(self.taken.saturating_mul(2));
        for ((is_finished, moments), sums) in self.finished.iter_mut().zip(moments).zip(&self.sums.pixels) {
            *is_finished = *is_finished || stopping_error(moments, sums.count, self.exposure_scale) <= noise;
        }
    }

    /// How far the frame is.
    pub fn progress(&self) -> PathProgress {
        let shutter_samples = self.range.len() / self.samples.len().max(1);
        let finished = self.finished.iter().filter(|&&is_finished| is_finished).count();
        PathProgress {
            samples: self.samples_taken() * shutter_samples as u32,
            most_samples: self.range.len() as u32,
            finished_share: finished as f32 / self.finished.len() as f32,
            noise: self.mean_noise(),
        }
    }

    fn mean_noise(&self) -> Option<f32> {
        let moments = self.sums.moments.as_ref()?;
        let squares = moments.iter().zip(&self.sums.pixels).map(|(moments, sums)| {
            let error = f64::from(display_error(moments, sums.count, self.exposure_scale));
            error * error
        });
        let mean = squares.sum::<f64>() / moments.len() as f64;
        mean.is_finite().then(|| mean.sqrt() as f32)
    }

    /// The same frame continued: with the sums of its samples up to `taken` of each shutter sample, and the pixels that take no more.
    /// `None` where these are of another frame.
    #[must_use]
    pub fn resumed(self, sums: SampleSums, finished: Vec<bool>, taken: u32) -> Option<Self> {
        let is_same = sums.window == self.sums.window
            && sums.flags() == self.sums.flags()
            && finished.len() == self.finished.len()
            && (self.samples.start..=self.samples.end).contains(&taken);
        let mut decision = self.decision;
        while decision <= taken && decision < self.samples.end {
            decision = self.samples.end.min(decision.saturating_mul(2));
        }
        is_same.then_some(Self { sums, finished, taken, decision, ..self })
    }

    /// Which pixels take no more samples.
    pub fn finished(&self) -> &[bool] {
        &self.finished
    }

    /// Samples of each shutter sample that are done.
    pub fn taken(&self) -> u32 {
        self.taken
    }

    /// Number of samples of each shutter sample that are done.
    pub fn samples_taken(&self) -> u32 {
        self.taken - self.samples.start
    }

    /// The sums, where nothing else is needed.
    pub fn into_sums(self) -> SampleSums {
        self.sums
    }

    /// The sums.
    pub fn sums(&self) -> &SampleSums {
        &self.sums
    }
}

fn pixels_of(tile: PixelWindow) -> impl Iterator<Item = (u32, u32)> {
    (tile.y0..tile.y1).flat_map(move |y| (tile.x0..tile.x1).map(move |x| (x, y)))
}
