//! Normalization of normals and tangents, with substitutes for stored zeros.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::context::Context;
use crate::geometry::unit;
use crate::scene::{INSIDE_OUT_COSINE, Primitive};

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

/// Triangles by which a primitive is found to be inside out.
const SAMPLED_TRIANGLES: usize = 4096;

/// Whether most of the surface of a primitive is inside out, by [`INSIDE_OUT_COSINE`].
pub(super) fn are_inside_out(primitive: &Primitive) -> bool {
    let Some(normals) = &primitive.normals else { return false };
    let corners = |list: &[Vec3], triangle: &[u32; 3]| {
        triangle.map(|vertex| list.get(vertex as usize).copied().unwrap_or(Vec3::ZERO))
    };
    let step = primitive.triangles.len().div_ceil(SAMPLED_TRIANGLES).max(1);
    let (mut reversed, mut all) = (0.0, 0.0);
    for (index, triangles) in (0_u32..).zip(primitive.triangles.chunks(step)) {
        // Triangles may alternate, so that the same of every chunk would be a wrong sample.
        let hash = (index.wrapping_mul(0x9e37_79b9) >> 16) as usize;
        let Some(triangle) = triangles.get(hash.checked_rem(triangles.len()).unwrap_or(0)) else { continue };
        let [a, b, c] = corners(&primitive.positions, triangle);
        let area = (b - a).cross(c - a).length();
        let mean = unit(corners(normals, triangle).into_iter().sum()).unwrap_or(Vec3::ZERO);
        if area.is_finite() {
            all += area;
            let cosine = mean.dot(face_normal(&primitive.positions, triangle));
            reversed += if cosine < -INSIDE_OUT_COSINE { area } else { 0.0 };
        }
    }
    2.0 * reversed > all
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

    #[test]
    fn meshes_with_reversed_normals_are_inside_out() {
        let with_normals = |normals: Vec<Vec3>| Primitive {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO, Vec3::X, Vec3::Z],
            normals: Some(normals),
            triangles: vec![[0, 1, 2], [4, 3, 5]],
            ..Primitive::default()
        };
        // The triangles face +Z and +Y; their vertices at the edge share a normal.
        let reversed = [Vec3::new(0.0, -1.0, -1.0), Vec3::new(0.0, -1.0, -1.0), Vec3::NEG_Z];
        let other = [Vec3::new(0.0, -1.0, -1.0), Vec3::new(0.0, -1.0, -1.0), Vec3::NEG_Y];
        let both = [reversed, other].concat().into_iter().map(Vec3::normalize).collect::<Vec<_>>();
        assert!(are_inside_out(&with_normals(both.clone())));
        assert!(!are_inside_out(&with_normals(both.iter().map(|normal| -*normal).collect())));
        // Half of it, upright normals, and normals 40° from the reversed ones
        let half = both.iter().take(3).copied().chain([Vec3::Y; 3]).collect();
        assert!(!are_inside_out(&with_normals(half)));
        assert!(!are_inside_out(&with_normals(vec![Vec3::new(0.0, 0.7, -0.7).normalize(); 6])));
        let (sin, cos) = libm::sincosf(40.0_f32.to_radians());
        let leaning = [[Vec3::new(sin, 0.0, -cos); 3], [Vec3::new(sin, -cos, 0.0); 3]].concat();
        assert!(!are_inside_out(&with_normals(leaning)));
        // Cards stored as pairs of a back and a front
        let pairs = |count: u32| Primitive {
            triangles: (0..count).flat_map(|_| [[1, 0, 2], [0, 1, 2]]).collect(),
            ..with_normals(vec![Vec3::Z; 6])
        };
        assert!(!are_inside_out(&pairs(20_000)));
        assert!(!are_inside_out(&Primitive { normals: None, ..with_normals(Vec::new()) }));
    }
}
