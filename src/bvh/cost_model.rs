//! Which hierarchy [`BuilderKind::Auto`] builds.
//!
//! Merging ([`super::ploc`]) costs more than the linear pass for each reference, and saves a part of each ray's time. The
//! saving shrinks where a mesh is so dense that its Morton order is as good as any. Measured on one core of a Zen 4:
//! merging takes about 30 ns a reference more; a ray of a picture's batches takes some 80 ns, of which a better
//! tree saves a third where surfaces differ in size and a tenth where they do not.

use super::BuilderKind;

/// Nanoseconds that merging costs a reference.
const MERGING_NS_A_REFERENCE: f64 = 30.0;
/// Nanoseconds that it saves a ray, by the least it was seen to save.
const SAVED_NS_A_RAY: f64 = 8.0;

/// The hierarchy for which build and trace together are expected to take the least time.
pub(super) fn choose(references: usize, expected_rays: u64) -> BuilderKind {
    if references as f64 * MERGING_NS_A_REFERENCE < expected_rays as f64 * SAVED_NS_A_RAY {
        BuilderKind::Ploc
    } else {
        BuilderKind::Lbvh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effort_grows_with_rays_and_shrinks_with_references() {
        assert_eq!(choose(70_000, 3 << 20), BuilderKind::Ploc);
        assert_eq!(choose(1_000_000, 3 << 20), BuilderKind::Lbvh);
        assert_eq!(choose(70_000, 10_000), BuilderKind::Lbvh);
        assert_eq!(choose(1_000_000, 100 << 20), BuilderKind::Ploc);
    }
}
