//! The renders at different times whose mean is a frame.

/// One of several renders of a frame, at different times, whose mean is the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShutterSample {
    /// From 0.
    pub index: u32,
    /// Number of shutter samples of the frame.
    pub count: u32,
}

impl ShutterSample {
    /// The only shutter sample of a frame without motion blur.
    pub const ONLY: Self = Self { index: 0, count: 1 };

    /// Samples of this shutter sample, at least one, where the frame has `samples` of them.
    pub(super) fn share_of(self, samples: u32) -> u32 {
        samples.div_ceil(self.count)
    }
}
