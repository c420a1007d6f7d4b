//! Normalisation of vectors.

use glam::Vec3;

/// Normalises `v`; `None` if it is zero or not finite. Accurate for every finite length, subnormal ones included.
pub(crate) fn unit(v: Vec3) -> Option<Vec3> {
    has_direction(v).then(|| normalized(v))
}

/// Normalises `v`, as [`unit`] does; `fallback` if it is zero or not finite. For loops over lanes.
#[inline(always)]
pub(crate) fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let normalized = normalized(v);
    if has_direction(v) { normalized } else { fallback }
}

/// Normalises a vector whose square neither overflows nor underflows; `fallback` if it is zero. For loops over lanes.
#[inline(always)]
pub(crate) fn normalized_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let reciprocal = 1.0 / v.dot(v).sqrt();
    let has_length = reciprocal > 0.0 && reciprocal < f32::INFINITY;
    if has_length { v * reciprocal } else { fallback }
}

#[inline(always)]
fn has_direction(v: Vec3) -> bool {
    let largest = v.abs().max_element();
    largest > 0.0 && largest < f32::INFINITY
}

/// The unit vector of one that has a direction. Squares of components of at most one neither overflow nor all underflow.
#[inline(always)]
fn normalized(v: Vec3) -> Vec3 {
    let scaled = v / v.abs().max_element();
    scaled / scaled.dot(scaled).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_from_subnormal_to_huge_become_one() {
        for length in [1e-45_f32, 1e-38, 1e-20, 1.0, 1e20, 3e38] {
            assert_eq!(unit(Vec3::new(0.0, -length, 0.0)), Some(Vec3::NEG_Y));
        }
        for v in [Vec3::splat(3e38), Vec3::new(1e-42, -1e-42, 0.0), Vec3::new(1e30, 1e-30, 5.0)] {
            let length = unit(v).unwrap().length();
            assert!((length - 1.0).abs() < 1e-6, "{v} {length}");
        }
    }

    #[test]
    fn zero_and_infinite_vectors_have_no_direction() {
        for v in [Vec3::ZERO, Vec3::INFINITY, Vec3::new(f32::NEG_INFINITY, 1.0, 0.0)] {
            assert_eq!(unit(v), None);
        }
    }
}
