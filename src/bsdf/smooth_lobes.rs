//! How lobes without a density count.

/// Whether smooth reflection and smooth thin walls count as the sharpest rough lobes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum SmoothLobes {
    Without,
    Sharpest,
}
