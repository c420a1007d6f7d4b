//! What each frame cost, in a form that can be stored.

use std::path::PathBuf;

use serde::Serialize;

use crate::bvh::{BuildKind, BuildStatistics, BuilderKind, RebuildReason};
use crate::cancel::Cancelled;
use crate::error::{Error, Result};
use crate::render::RenderStatistics;

/// Seconds of each phase of a frame. Phases share the machine with the writing of the frame before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[expect(missing_docs, reason = "each of the first fields is the phase of its name")]
pub struct Phases {
    pub pose: f64,
    /// Fitting the last frame's hierarchy to this one, also where it came to nothing.
    pub refit: f64,
    /// Boxes of triangles.
    pub bounds: f64,
    pub split: f64,
    /// Morton codes and their order.
    pub sort: f64,
    /// The binary tree.
    pub tree: f64,
    /// The collapse to the tree that rays walk.
    pub widen: f64,
    /// Waiting until the frame before the last was written.
    pub wait: f64,
    pub trace: f64,
    /// Encoding this frame and writing it, beside the frame after it.
    pub write: f64,
    /// From the frame's beginning until it was on disk.
    pub total: f64,
    /// What the frame added to the run: from the end of the frame before, or its own beginning, until it was on disk.
    pub period: f64,
}

impl Phases {
    /// Seconds in which the frame was made, without waiting and writing.
    pub(super) fn of_making(&self) -> f64 {
        let Self { pose, refit, bounds, split, sort, tree, widen, trace, .. } = self;
        pose + refit + bounds + split + sort + tree + widen + trace
    }

    /// Adds the phases of another time of the same frame.
    pub(super) fn add(&mut self, other: &Self) {
        self.pose += other.pose;
        self.refit += other.refit;
        self.bounds += other.bounds;
        self.split += other.split;
        self.sort += other.sort;
        self.tree += other.tree;
        self.widen += other.widen;
    }
}

/// The hierarchy of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TreeReport {
    /// Triangles that are not hidden.
    pub triangles: usize,
    /// Boxes after splitting.
    pub references: usize,
    /// Area beyond which boxes were split, square metres; none unless `--split AREA` asked for one.
    pub sa_max: Option<f32>,
    /// Levels of the binary tree.
    pub depth: u32,
    /// Surface area heuristic cost of the binary tree.
    pub sah_cost: f32,
    /// Bytes of the traversal structure.
    pub bytes: usize,
    /// The same over the number of triangles.
    pub bytes_per_triangle: f64,
    /// Which hierarchy it is: `lbvh`, `ploc`, `karras` or `brute`.
    pub builder: &'static str,
    /// Which one was asked for; `auto` leaves it to the number of rays and the triangles' sizes.
    pub asked_for: &'static str,
    /// How it came to fit the frame: `built`, `refitted`, or `reused` as it was.
    pub made: &'static str,
    /// Why, in words.
    pub why: &'static str,
    /// For a refitted tree, its SAH cost over the least since it was built.
    pub decay: Option<f32>,
}

/// The rays of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the first four count rays of the kind of their name")]
pub struct RayReport {
    pub camera: u64,
    pub reflection: u64,
    pub refraction: u64,
    pub shadow: u64,
    /// Rays of all kinds a second of tracing and shading.
    pub per_second: f64,
    /// Seconds inside the hierarchy's batch queries, summed over threads.
    pub query_seconds: f64,
    /// Wide nodes visited a ray.
    pub nodes_per_ray: f64,
    /// Triangles tested a ray.
    pub triangles_per_ray: f64,
    /// Sample weight lost to the depth limit and the cut-off, in whole samples.
    pub dropped_weight: f64,
    /// Samples that met too many see-through surfaces.
    pub pass_through_limit_reached: u64,
    /// Pixels that were not finite and became black.
    pub non_finite_pixels: u64,
}

/// A file of one layer that was written.
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

/// A frame that was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameReport {
    /// Frame number.
    pub frame: i64,
    /// What it shows, seconds.
    pub time_seconds: f64,
    /// The file.
    #[serde(serialize_with = "lossy_path")]
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Bytes of the file.
    pub bytes: usize,
    /// The files of layers that are not in it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<AovFileReport>,
    /// Seconds of each phase.
    pub seconds: Phases,
    /// The hierarchy.
    pub tree: TreeReport,
    /// The rays.
    pub rays: RayReport,
    /// Most memory that the process ever used, where the system tells.
    pub peak_memory_bytes: Option<u64>,
}

/// A frame that could not be made.
#[derive(Debug)]
pub struct FailedFrame {
    /// Frame number.
    pub frame: i64,
    /// Why.
    pub error: Error,
}

/// A whole run.
#[derive(Debug, Default)]
pub struct Summary {
    /// Frames written, in order.
    pub written: Vec<FrameReport>,
    /// Frames that were there already.
    pub kept: Vec<i64>,
    /// Previews written beside frames that were there already.
    pub previews: usize,
    /// Frames that could not be made.
    pub failed: Vec<FailedFrame>,
    /// Whether the run was stopped.
    pub is_interrupted: bool,
    /// Wall-clock seconds.
    pub seconds: f64,
}

impl Summary {
    /// Nothing, when all that was asked for is there; else the interruption, or the worst failure.
    ///
    /// # Errors
    /// As said; of several failures the one whose exit code is the most permanent.
    pub fn outcome(self) -> Result<()> {
        if self.is_interrupted {
            return Err(Error::Interrupted(Cancelled));
        }
        let worst = self.failed.into_iter().max_by_key(|failed| permanence(&failed.error));
        worst.map_or(Ok(()), |failed| Err(failed.error))
    }
}

/// How little another try would help: a bug most, a full disk less.
fn permanence(error: &Error) -> u8 {
    match error.exit_code() {
        70 => 4,
        65 | 66 => 3,
        77 => 2,
        _ => 1,
    }
}

impl TreeReport {
    pub(super) fn new(statistics: &BuildStatistics, asked_for: BuilderKind, is_reused: bool) -> Self {
        let (made, why, decay) = match statistics.kind {
            _ if is_reused => ("reused", "no triangle moved", None),
            BuildKind::Refitted { cost_ratio } => {
                ("refitted", "the rays pay less for a worn tree than for a new one", Some(cost_ratio))
            }
            BuildKind::Built(reason) => ("built", why_built(reason), None),
        };
        Self {
            triangles: statistics.triangles,
            references: statistics.references,
            sa_max: statistics.sa_max.is_finite().then_some(statistics.sa_max),
            depth: statistics.depth,
            sah_cost: statistics.sah_cost,
            bytes: statistics.bytes,
            bytes_per_triangle: statistics.bytes as f64 / statistics.triangles.max(1) as f64,
            builder: builder_name(statistics.builder),
            asked_for: builder_name(asked_for),
            made,
            why,
            decay,
        }
    }
}

impl Phases {
    /// What building or refitting took.
    pub(super) fn of_build(pose: f64, statistics: &BuildStatistics) -> Self {
        Self {
            pose,
            refit: statistics.refit_seconds,
            bounds: statistics.bounds_seconds,
            split: statistics.split_seconds,
            sort: statistics.sort_seconds,
            tree: statistics.tree_seconds,
            widen: statistics.collapse_seconds,
            ..Self::default()
        }
    }
}

fn why_built(reason: RebuildReason) -> &'static str {
    match reason {
        RebuildReason::NoPreviousTree => "there was none that may be refitted",
        RebuildReason::OtherTriangles => "other triangles take part, or some are split",
        RebuildReason::CostRatioTooHigh => "refitted it would cost the rays more",
        RebuildReason::Pausing => "refitting has not paid lately",
    }
}

/// As `--bvh` calls it.
fn builder_name(builder: BuilderKind) -> &'static str {
    match builder {
        BuilderKind::Auto => "auto",
        BuilderKind::Lbvh => "lbvh",
        BuilderKind::Karras => "karras",
        BuilderKind::Ploc => "ploc",
        BuilderKind::BruteForce => "brute",
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
            pass_through_limit_reached: statistics.integrator.transparency_limit_reached,
            non_finite_pixels: statistics.non_finite_pixels,
        }
    }
}

/// Most memory that this process ever used (`VmHWM` of Linux).
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
    fn the_worst_frame_decides() {
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
