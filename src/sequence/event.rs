//! Events of a run, for progress output.

use crate::error::{Error, Warning};
use crate::image_file::DisplayImage;
use crate::render::PathProgress;

use super::{FrameReport, PlannedFrame, Summary};

/// How far a frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameProgress {
    /// Finished share of its samples, 0 to 1.
    pub share: f32,
    /// Samples and noise after the last pass of paths.
    pub path: Option<PathProgress>,
}

/// Event of a run.
///
/// The last event of a frame (kept, written or failed) comes in the order of frames, but for frames that other runs rendered. It may come while the next frame is
/// rendered, and then from another thread.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum SequenceEvent<'a> {
    /// The run starts.
    Started {
        /// Number of frames to render.
        to_render: usize,
        /// Number of frames that exist already.
        kept: usize,
    },
    /// The exposure of all tone-mapped files is computed.
    ExposureFound {
        /// Stops.
        ev: f32,
        /// Whether it is automatic.
        is_automatic: bool,
    },
    /// An existing frame is kept, or one that another run has written meanwhile.
    FrameKept(&'a PlannedFrame),
    /// A frame starts.
    FrameStarted(&'a PlannedFrame),
    /// A part of a frame is finished. Comes from worker threads.
    FrameProgress(&'a PlannedFrame, FrameProgress),
    /// A frame is on disk, or part of the movie.
    FrameWritten(&'a FrameReport),
    /// A frame of a movie is rendered. Sent before it is written, where frames are shown.
    FrameImage(&'a DisplayImage),
    /// A frame failed.
    FrameFailed(&'a PlannedFrame, &'a Error),
    /// A warning about the rendered frames or their movie.
    Warned(&'a Warning),
    /// The run is over; no event follows but warnings about a movie beside the frames.
    Finished(&'a Summary),
}
