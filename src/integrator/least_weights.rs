//! What is too faint to be traced.

/// Rays of a lower weight are not followed and count as black.
pub(in crate::integrator) const MIN_WEIGHT: f32 = 1.0 / 1024.0;

/// Where no more than this share of a light's irradiance, by steradian, would reach the camera from a surface, it gets no shadow ray and the light counts
/// as black: a hundred-thousandth of a white surface. Clear glass and mirrors scatter less nearly everywhere.
pub(super) const MIN_SCATTERED: f32 = 1.0 / 262_144.0;
