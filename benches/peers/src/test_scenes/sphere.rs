//! Even meshes.

use glam::Vec3;
use rayframe::geometry::Triangle;

/// Depth of the dents, in units of the radius.
const DENT: f32 = 0.05;
/// Half the side of the wide ground, metres.
const GROUND: f32 = 2000.0;

/// Dented sphere around the origin with a radius of about one and 8f² triangles, for the largest f that does not exceed `size`.
pub(super) fn dented(size: usize) -> Vec<Triangle> {
    let cuts = ((size as f64 / 8.0).sqrt() as usize).max(1);
    let corners = [Vec3::X, Vec3::Y, Vec3::Z];
    let mut triangles = Vec::with_capacity(8 * cuts * cuts);
    for octant in 0..8_u32 {
        let sign = |axis: u32| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let signs = Vec3::new(sign(0), sign(1), sign(2));
        // Mirroring flips the winding.
        let [a, b, c] = corners.map(|corner| corner * signs);
        let face = if octant.count_ones() % 2 == 0 { [a, b, c] } else { [a, c, b] };
        cut(face, cuts, &mut triangles);
    }
    triangles
}

/// [`dented`] on a ground four kilometres wide.
pub(super) fn on_wide_ground(size: usize) -> Vec<Triangle> {
    let mut triangles = dented(size);
    let corner = |x: f32, z: f32| Vec3::new(x * GROUND, -1.1, z * GROUND);
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    triangles.extend([Triangle { vertices: [a, b, c] }, Triangle { vertices: [a, c, d] }]);
    triangles
}

/// Divides a face into `cuts`² triangles, row by row.
fn cut([a, b, c]: [Vec3; 3], cuts: usize, triangles: &mut Vec<Triangle>) {
    let step = 1.0 / cuts as f32;
    let point = |i: usize, j: usize| {
        let (u, v) = (i as f32 * step, j as f32 * step);
        displaced(a * (1.0 - u - v) + b * u + c * v)
    };
    for j in 0..cuts {
        for i in 0..cuts - j {
            triangles.push(Triangle { vertices: [point(i, j), point(i + 1, j), point(i, j + 1)] });
            if i + j + 1 < cuts {
                triangles
                    .push(Triangle { vertices: [point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)] });
            }
        }
    }
}

/// Projects a point of the octahedron to the dented sphere.
fn displaced(point: Vec3) -> Vec3 {
    let direction = point.normalize();
    let [x, y, z] = (direction * 13.0).to_array().map(libm::sinf);
    direction * (1.0 + DENT * (x * y + z))
}
