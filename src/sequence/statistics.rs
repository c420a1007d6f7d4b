//! Reports of a run: times, BVH, rays and files of each frame, as written by `--stats` (`schema/stats.schema.json`) and progress output.

use std::path::PathBuf;

use serde::Serialize;

use crate::bvh::{BuildKind, BuildStatistics, BuilderKind, RebuildReason};
use crate::cancel::Cancelled;
use crate::error::exit_code::permanence;
use crate::error::{Error, Result};
use crate::output::PreviewLook;
use crate::render::RenderStatistics;
use crate::settings::Named;

/// Seconds of each phase of a frame. The previous frame is written at the same time on the same machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[expect(missing_docs, reason = "each of the first fields is the phase of its name")]
pub struct Phases {
    pub pose: f64,
    /// Refitting of the previous frame's BVH, including attempts that were given up.
    pub refit: f64,
    /// Bounding boxes of triangles.
    pub bounds: f64,
    pub split: f64,
    /// Computing and sorting Morton codes.
    pub sort: f64,
    /// The binary tree.
    pub tree: f64,
    /// Collapse of the binary tree to the wide tree.
    #[serde(rename = "widen")]
    pub collapse: f64,
    /// Waiting for the frame before the previous one to be written.
    pub wait: f64,
    pub trace: f64,
    /// Encoding and writing, while the next frame is rendered.
    pub write: f64,
    /// From the start of the frame until it is on disk, and the tracing of earlier runs whose checkpoint it continues.
    pub total: f64,
    /// Time that the frame adds to the run: from the end of the previous frame, or its own start if later, until it is on disk.
    pub period: f64,
}

impl Phases {
    /// Seconds of posing, building and tracing.
    pub(super) fn render_seconds(&self) -> f64 {
        let Self { pose, refit, bounds, split, sort, tree, collapse, trace, .. } = self;
        pose + refit + bounds + split + sort + tree + collapse + trace
    }

    /// Adds the phases of another shutter sample of the same frame.
    pub(super) fn add(&mut self, other: &Self) {
        self.pose += other.pose;
        self.refit += other.refit;
        self.bounds += other.bounds;
        self.split += other.split;
        self.sort += other.sort;
        self.tree += other.tree;
        self.collapse += other.collapse;
    }
}

/// BVH of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TreeReport {
    /// Triangles that are neither hidden nor degenerate.
    pub triangles: usize,
    /// Triangle references after splitting.
    pub references: usize,
    /// Area above which boxes were split, square metres; `None` unless `--split AREA` sets one.
    pub sa_max: Option<f32>,
    /// Levels of the binary tree.
    pub depth: u32,
    /// Surface area heuristic cost of the binary tree.
    pub sah_cost: f32,
    /// Bytes of the traversal structure.
    pub bytes: usize,
    /// Bytes of the traversal structure a triangle.
    pub bytes_per_triangle: f64,
    /// Builder that built it: `lbvh`, `ploc`, `karras` or `brute`.
    pub builder: &'static str,
    /// Requested builder; `auto` decides by the number of rays and the triangles' sizes.
    #[serde(rename = "asked_for")]
    pub requested: &'static str,
    /// Whether it was `built`, `refitted` or `reused` unchanged.
    pub made: &'static str,
    /// The reason, as a text.
    pub why: &'static str,
    /// SAH cost of a refitted tree over the least since it was built.
    #[serde(rename = "decay")]
    pub cost_ratio: Option<f32>,
}

/// Rays of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the first four count rays of the kind of their name")]
pub struct RayReport {
    pub camera: u64,
    pub reflection: u64,
    pub refraction: u64,
    pub shadow: u64,
    /// Rays of all kinds per second of tracing and shading.
    pub per_second: f64,
    /// Seconds inside BVH queries, summed over threads.
    pub query_seconds: f64,
    /// Wide nodes visited a ray.
    pub nodes_per_ray: f64,
    /// Triangles tested a ray.
    pub triangles_per_ray: f64,
    /// Sample weight lost to the depth limit and the weight cut-off, in whole samples.
    pub dropped_weight: f64,
    /// Samples that hit more transparent surfaces than the limit.
    #[serde(rename = "pass_through_limit_reached")]
    pub transparency_limit_reached: u64,
    /// Pixels that were not finite and are black.
    pub non_finite_pixels: u64,
    /// Samples of paths that were not finite and are left out.
    pub non_finite_samples: u64,
}

/// Written file of a split AOV.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AovFileReport {
    /// The file.
    #[serde(serialize_with = "lossy_path")]
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Bytes of the file.
    pub bytes: usize,
}

/// Report of a written frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameReport {
    /// Frame number.
    pub frame: i64,
    /// Scene time, seconds.
    pub time_seconds: f64,
    /// The file; the movie, where the frame is a part of one.
    #[serde(serialize_with = "lossy_path")]
    pub path: PathBuf,
    /// SHA-256 of the file; of the pixels, where the frame is a part of a movie.
    pub sha256: String,
    /// Bytes of the file or of the pixels.
    pub bytes: usize,
    /// Files of split AOVs.
    #[serde(rename = "layers", skip_serializing_if = "Vec::is_empty")]
    pub aov_files: Vec<AovFileReport>,
    /// Seconds of each phase.
    pub seconds: Phases,
    /// The BVH.
    pub tree: TreeReport,
    /// The rays.
    pub rays: RayReport,
    /// Peak memory of the process, where the system reports it.
    pub peak_memory_bytes: Option<u64>,
}

/// A frame that failed.
#[derive(Debug)]
pub struct FailedFrame {
    /// Frame number.
    pub frame: i64,
    /// The error.
    pub error: Error,
}

/// Summary of a run.
#[derive(Debug, Default)]
pub struct Summary {
    /// Frames written, in order.
    pub written: Vec<FrameReport>,
    /// Existing frames that were kept.
    pub kept: Vec<i64>,
    /// Number of previews written for kept frames.
    pub previews: usize,
    /// Frames that failed.
    pub failed: Vec<FailedFrame>,
    /// Whether the run was cancelled.
    pub is_interrupted: bool,
    /// Whether the frames make one movie. It exists only where all of them were written.
    pub is_movie: bool,
    /// Tone mapping of the run, where anything was tone-mapped.
    pub look: Option<PreviewLook>,
    /// Wall-clock seconds.
    pub seconds: f64,
}

impl Summary {
    /// Success when all frames exist.
    ///
    /// # Errors
    /// [`Error::Interrupted`] when the run was cancelled, or else the failure whose exit code is the most permanent.
    pub fn outcome(self) -> Result<()> {
        if self.is_interrupted {
            return Err(Error::Interrupted(Cancelled));
        }
        let worst = self.failed.into_iter().max_by_key(|failed| permanence(failed.error.exit_code()));
        worst.map_or(Ok(()), |failed| Err(failed.error))
    }
}

impl TreeReport {
    pub(super) fn new(statistics: &BuildStatistics, requested: BuilderKind, is_reused: bool) -> Self {
        let (made, why, cost_ratio) = match statistics.kind {
            _ if is_reused => ("reused", "no triangle moved", None),
            BuildKind::Refitted { cost_ratio } => {
                ("refitted", "a refit costs less than a rebuild would save", Some(cost_ratio))
            }
            BuildKind::Built(reason) => ("built", rebuild_reason_text(reason), None),
        };
        Self {
            triangles: statistics.triangles,
            references: statistics.references,
            sa_max: statistics.sa_max.is_finite().then_some(statistics.sa_max),
            depth: statistics.depth,
            sah_cost: statistics.sah_cost,
            bytes: statistics.bytes,
            bytes_per_triangle: statistics.bytes as f64 / statistics.triangles.max(1) as f64,
            builder: statistics.builder.choice_name(),
            requested: requested.choice_name(),
            made,
            why,
            cost_ratio,
        }
    }
}

impl Phases {
    /// Phases of building or refitting.
    pub(super) fn of_build(pose: f64, statistics: &BuildStatistics) -> Self {
        Self {
            pose,
            refit: statistics.refit_seconds,
            bounds: statistics.bounds_seconds,
            split: statistics.split_seconds,
            sort: statistics.sort_seconds,
            tree: statistics.tree_seconds,
            collapse: statistics.collapse_seconds,
            ..Self::default()
        }
    }
}

fn rebuild_reason_text(reason: RebuildReason) -> &'static str {
    match reason {
        RebuildReason::NoPreviousTree => "no previous tree with nodes to refit",
        RebuildReason::RefittingOff => "refitting is off",
        RebuildReason::OtherTriangles => "the set of triangles changed",
        RebuildReason::SplitTriangles => "split triangles are faster to build",
        RebuildReason::CostRatioTooHigh => "a refitted tree would cost the rays more",
        RebuildReason::Pausing => "refitting did not pay recently",
    }
}

impl RayReport {
    pub(super) fn new(statistics: &RenderStatistics) -> Self {
        let rays = statistics.integrator.camera_rays
            + statistics.integrator.reflection_rays
            + statistics.integrator.refraction_rays
            + statistics.integrator.shadow_rays;
        let per_ray = |count: u64| {
            if rays == 0 { 0.0 } else { count as f64 / rays as f64 }
        };
        let seconds = statistics.trace_seconds;
        Self {
            camera: statistics.integrator.camera_rays,
            reflection: statistics.integrator.reflection_rays,
            refraction: statistics.integrator.refraction_rays,
            shadow: statistics.integrator.shadow_rays,
            per_second: if seconds > 0.0 { rays as f64 / seconds } else { 0.0 },
            query_seconds: statistics.integrator.query_seconds,
            nodes_per_ray: per_ray(statistics.integrator.nodes),
            triangles_per_ray: per_ray(statistics.integrator.triangles),
            dropped_weight: statistics.integrator.dropped_weight,
            transparency_limit_reached: statistics.integrator.transparency_limit_reached,
            non_finite_pixels: statistics.non_finite_pixels,
            non_finite_samples: statistics.non_finite_samples,
        }
    }
}

/// Peak memory of this process (`VmHWM` of Linux).
pub(super) fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

#[expect(clippy::ptr_arg, reason = "serde passes the field's own type")]
fn lossy_path<S: serde::Serializer>(path: &PathBuf, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_str(&path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failed(frame: i64, error: Error) -> FailedFrame {
        FailedFrame { frame, error }
    }

    #[test]
    fn the_most_permanent_failure_decides_the_outcome() {
        let full_disk =
            || Error::WriteFailed { path: "a".into(), source: std::io::ErrorKind::StorageFull.into() };
        let bug = Error::Internal { message: "x".to_owned() };
        let summary = Summary {
            failed: vec![failed(1, full_disk()), failed(2, bug), failed(3, full_disk())],
            ..Summary::default()
        };
        assert_eq!(summary.outcome().unwrap_err().exit_code(), 70);
        assert!(Summary::default().outcome().is_ok());
        let stopped = Summary { is_interrupted: true, ..Summary::default() };
        assert_eq!(stopped.outcome().unwrap_err().exit_code(), 75);
    }
}
