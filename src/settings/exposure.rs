//! Exposure of tone-mapped images.

/// Exposure of tone-mapped images.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Exposure {
    /// Computed from a few small renders, once for the whole animation.
    Auto,
    /// Stops.
    Ev(f32),
}
