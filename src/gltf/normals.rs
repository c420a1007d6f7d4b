//! Normalization of normals and tangents, with substitutes for stored zeros.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::context::Context;
use crate::geometry::unit;

/// Normals of one parallel task.
const NORMALS_PER_TASK: usize = 16_384;

/// Normalizes `normals`. A zero normal is replaced by the average normal of the adjacent triangles.
pub(super) fn normalize(
    context: &mut Context,
    normals: &mut [Vec3],
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    pointer: &str,
) {
    let normalize = |normal: &mut Vec3| *normal = unit(*normal).unwrap_or(Vec3::ZERO);
    normals.par_iter_mut().with_min_len(NORMALS_PER_TASK).for_each(normalize);
    if !normals.contains(&Vec3::ZERO) {
        return;
    }
    context.warn(pointer, "some normals have length zero; the normals of the adjacent triangles are used");
    let mut sums = vec![Vec3::ZERO; normals.len()];
    for triangle in triangles {
        let normal = face_normal(positions, triangle);
        for &vertex in triangle {
            if let Some(sum) = sums.get_mut(vertex as usize) {
                *sum += normal;
            }
        }
    }
    for (normal, sum) in normals.iter_mut().zip(sums) {
        if *normal == Vec3::ZERO {
            *normal = unit(sum).unwrap_or(Vec3::Z);
        }
    }
}

/// Normalizes tangents and sets their signs to ±1. A zero tangent is replaced by any vector perpendicular to its normal.
pub(super) fn normalize_tangents(tangents: &mut [Vec4], normals: &[Vec3]) {
    tangents.par_iter_mut().zip(normals).with_min_len(NORMALS_PER_TASK).for_each(|(tangent, normal)| {
        let sign = if tangent.w < 0.0 { -1.0 } else { 1.0 };
        let direction = unit(tangent.truncate()).unwrap_or_else(|| normal.any_orthonormal_vector());
        *tangent = direction.extend(sign);
    });
}

/// Unit normal of a triangle; zero if the triangle has no area.
pub(super) fn face_normal(positions: &[Vec3], triangle: &[u32; 3]) -> Vec3 {
    let corner = |i: u32| positions.get(i as usize).copied().unwrap_or(Vec3::ZERO);
    let [a, b, c] = triangle.map(corner);
    // Normalize the edges first, so that the product of very long or very short ones stays finite and non-zero.
    let (ab, ac) = (unit(b - a), unit(c - a));
    match (ab, ac) {
        (Some(ab), Some(ac)) => unit(ab.cross(ac)).unwrap_or(Vec3::ZERO),
        _ => Vec3::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_normals_are_replaced_by_triangle_normals() {
        let path = std::path::Path::new("test.gltf");
        let mut context = Context::new(path, 1 << 20);
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::splat(9.0)];
        let mut normals = [Vec3::ZERO, Vec3::X * 2.0, Vec3::ZERO, Vec3::ZERO];
        normalize(&mut context, &mut normals, &positions, &[[0, 1, 2]], "/x");
        // The triangle lies in the xy plane. No triangle uses the last vertex.
        assert_eq!(normals, [Vec3::Z, Vec3::X, Vec3::Z, Vec3::Z]);
        assert_eq!(context.into_warnings().len(), 1);
    }
}
