//! What a run tells while it works.

use crate::error::{Error, Warning};

use super::{FrameReport, PlannedFrame, Summary};

/// One thing that happened.
///
/// The last event of a frame (kept, written or failed) comes in the order of frames. It may come while the next frame is
/// under way, and then from another thread.
#[derive(Clone, Copy, Debug)]
pub enum SequenceEvent<'a> {
    /// Work begins.
    Started {
        /// Frames that will be rendered.
        to_render: usize,
        /// Frames that are there already.
        kept: usize,
    },
    /// The exposure of all tone-mapped files is known.
    ExposureFound {
        /// Stops.
        ev: f32,
        /// Whether it was found by looking at the animation.
        is_automatic: bool,
    },
    /// A frame that was there already stays.
    FrameKept(&'a PlannedFrame),
    /// A frame begins.
    FrameStarted(&'a PlannedFrame),
    /// A share of a frame's picture is finished, 0 to 1. Comes from worker threads.
    FrameProgress(&'a PlannedFrame, f32),
    /// A frame is on disk.
    FrameWritten(&'a FrameReport),
    /// A frame could not be made.
    FrameFailed(&'a PlannedFrame, &'a Error),
    /// Something about the picture is not as asked for.
    Warned(&'a Warning),
    /// Nothing more will happen.
    Finished(&'a Summary),
}
