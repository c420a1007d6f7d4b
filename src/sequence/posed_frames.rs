//! The posed scene and its BVH, which take over memory and trees from the previous frame.

use std::time::Instant;

use rayon::prelude::*;

use crate::bvh::{BuildSettings, Builder, Bvh};
use crate::cancel::CancelFlag;
use crate::error::Result;
use crate::film::Film;
use crate::frame::{Frame, PosedCamera};
use crate::geometry::Triangle;
use crate::render::{AdjacentFrames, SceneView, expected_rays, render_pixel_centers};

use super::memory::reference_budget;
use super::{Phases, SequenceJob};

/// Triangles of one task of a comparison.
const TRIANGLES_PER_TASK: usize = 16_384;

/// The current and the previous pose, and the BVH of the current one.
#[derive(Default)]
pub(super) struct PosedFrames {
    pub(super) current: Frame,
    previous: Frame,
    builder: Builder,
    pub(super) bvh: Option<Bvh>,
    /// Poses at the previous and the next frame number, where motion vectors are recorded.
    adjacent: [Frame; 2],
}

impl PosedFrames {
    /// The camera at `time_seconds`, which may differ from the time of the current pose.
    pub(super) fn camera_at(&self, job: &SequenceJob, time_seconds: f64) -> PosedCamera {
        if self.current.time_seconds == time_seconds {
            return self.current.camera;
        }
        Frame::camera_at(&job.scene, &job.selection, time_seconds)
    }

    /// Poses the scene and builds or refits the BVH. Returns whether the BVH is reused unchanged.
    pub(super) fn advance(
        &mut self,
        job: &SequenceJob,
        time_seconds: f64,
        cancel: &CancelFlag,
        seconds: &mut Phases,
    ) -> Result<bool> {
        let posing = Instant::now();
        if self.bvh.is_some() && job.selection.clips.is_empty() {
            self.current.pose_again(&job.scene, &job.selection, time_seconds);
            *seconds = Phases { pose: posing.elapsed().as_secs_f64(), ..Phases::default() };
            return Ok(true);
        }
        std::mem::swap(&mut self.current, &mut self.previous);
        match job.first_pose.take(&job.scene, &job.selection, time_seconds) {
            Some(posed) => self.current = posed,
            None => pose_next(&mut self.current, job, time_seconds),
        }
        *seconds = Phases { pose: posing.elapsed().as_secs_f64(), ..Phases::default() };

        if self.bvh.is_some() && has_same_triangles(&self.current, &self.previous) {
            return Ok(true);
        }
        let recycled = self.bvh.take();
        let Frame { triangles, flags, .. } = &self.current;
        let shutter_samples = job.shutter.time_samples;
        let settings = BuildSettings {
            reference_budget: reference_budget(job),
            expected_rays: expected_rays(&job.render, shutter_samples, &self.current, &job.environment),
            ..job.build
        };
        let bvh = self.builder.build(triangles, flags, &settings, cancel, recycled)?;
        *seconds = Phases::of_build(seconds.pose, &bvh.statistics());
        self.bvh = Some(bvh);
        if !job.poses_again() {
            self.free_builder();
        }
        Ok(false)
    }

    /// Frees the memory of the builder after the last tree, of which it may hold several times the bytes.
    fn free_builder(&mut self) {
        let builder = std::mem::take(&mut self.builder);
        // A pool of one thread would not start the task before the run ends.
        if rayon::current_num_threads() > 1 {
            rayon::spawn(move || drop(builder));
        }
    }

    /// Records the pixel-centre samples at the frame's own time, with motion vectors.
    pub(super) fn record_pixel_centers(
        &mut self,
        job: &SequenceJob,
        frame: i64,
        film: &mut Film,
        cancel: &CancelFlag,
    ) -> Result<Phases> {
        // The last shutter sample may be of another time.
        let time_seconds = job.rate.time_seconds(frame);
        let mut phases = Phases::default();
        if self.current.time_seconds != time_seconds {
            self.advance(job, time_seconds, cancel, &mut phases)?;
        }

        let posing = Instant::now();
        let [before, after] = &mut self.adjacent;
        for (pose, step) in [(&mut *before, -1), (&mut *after, 1)] {
            let time_seconds = job.rate.time_seconds(frame.saturating_add(step));
            pose_next(pose, job, time_seconds);
        }
        phases.pose += posing.elapsed().as_secs_f64();

        let tracing = Instant::now();
        if let Some(bvh) = &self.bvh {
            let (scene, frame, environment) = (&job.scene, &self.current, &job.environment);
            let view = SceneView { scene, frame, bvh, environment };
            render_pixel_centers(film, &view, AdjacentFrames { before, after }, cancel)?;
        }
        phases.trace += tracing.elapsed().as_secs_f64();
        Ok(phases)
    }
}

/// Poses a frame of `job`, which may have been posed at another time.
fn pose_next(frame: &mut Frame, job: &SequenceJob, time_seconds: f64) {
    if frame.instances.is_empty() {
        frame.pose(&job.scene, &job.selection, time_seconds);
    } else {
        frame.pose_again(&job.scene, &job.selection, time_seconds);
    }
}

/// Whether both frames have bitwise equal triangles.
fn has_same_triangles(a: &Frame, b: &Frame) -> bool {
    let bits = |triangle: &Triangle| triangle.vertices.map(|v| v.to_array().map(f32::to_bits));
    a.flags == b.flags
        && a.triangles.len() == b.triangles.len()
        && a.triangles
            .par_iter()
            .zip(&b.triangles)
            .with_min_len(TRIANGLES_PER_TASK)
            .all(|(a, b)| bits(a) == bits(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_zero_of_the_other_sign_is_another_triangle() {
        let frame = |x: f32| {
            let mut frame = Frame::default();
            frame.triangles.push(Triangle { vertices: [Vec3::new(x, 0.0, 0.0), Vec3::X, Vec3::Y] });
            frame
        };
        assert!(has_same_triangles(&frame(0.0), &frame(0.0)));
        assert!(!has_same_triangles(&frame(0.0), &frame(-0.0)));
        assert!(!has_same_triangles(&frame(0.0), &Frame::default()));
    }
}
