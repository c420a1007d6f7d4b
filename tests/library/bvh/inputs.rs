//! Triangles and rays that are hard cases for builders and traversal.

use glam::Vec3;
use rayframe::geometry::{Aabb, Ray, Triangle};

/// A small permuted congruential generator.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 22 ^ self.0) >> (22 + (self.0 >> 61))) as u32
    }

    /// In [-1, 1).
    pub(crate) fn signed(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        self.bits() as usize % n
    }
}

pub(crate) fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Triangle {
    Triangle { vertices: [a, b, c] }
}

pub(crate) fn soup(n: usize, size: f32, random: &mut Random) -> Vec<Triangle> {
    (0..n)
        .map(|_| {
            let a = random.point();
            triangle(a, a + random.point() * size, a + random.point() * size)
        })
        .collect()
}

/// Slivers with aspect ratios of 10³ to 10⁵, in all directions.
pub(crate) fn slivers(n: usize, random: &mut Random) -> Vec<Triangle> {
    (0..n)
        .map(|i| {
            let (a, b) = (random.point(), random.point());
            let width = [1.0e-3, 1.0e-4, 1.0e-5][i % 3];
            triangle(a, b, (a + b) * 0.5 + random.point() * width)
        })
        .collect()
}

/// Stacked sheets, many at exactly the same height.
pub(crate) fn stacked(n: usize) -> Vec<Triangle> {
    (0..n)
        .map(|i| {
            let z = (i % 7) as f32 * 0.125;
            let x = if i % 2 == 0 { 1.0 } else { -1.0 };
            triangle(Vec3::new(-x, -1.0, z), Vec3::new(x, -1.0, z), Vec3::new(0.0, 1.0, z))
        })
        .collect()
}

/// Chain of triangles whose distances and sizes grow by a factor.
pub(crate) fn chain(n: usize) -> Vec<Triangle> {
    (0..n)
        .map(|i| {
            let scale = libm::powf(1.02, i as f32) * 1.0e-3;
            let a = Vec3::new(scale, scale * 0.5, scale * 0.25);
            triangle(a, a + Vec3::X * scale * 0.1, a + Vec3::Y * scale * 0.1)
        })
        .collect()
}

pub(crate) fn scaled(triangles: &[Triangle], scale: f32) -> Vec<Triangle> {
    triangles.iter().map(|t| Triangle { vertices: t.vertices.map(|p| p * scale) }).collect()
}

/// Triangles with integer coordinates in the plane x = 3 y, for rays that lie in it exactly.
pub(crate) fn in_one_plane(n: usize, random: &mut Random) -> Vec<Triangle> {
    let mut point = || {
        let [y, z] = [0; 2].map(|_| (random.below(128) as f32) - 64.0);
        Vec3::new(3.0 * y, y, z)
    };
    (0..n).map(|_| triangle(point(), point(), point())).collect()
}

pub(crate) fn moved(triangles: &[Triangle], by: Vec3) -> Vec<Triangle> {
    triangles.iter().map(|t| Triangle { vertices: t.vertices.map(|p| p + by) }).collect()
}

pub(crate) fn inputs() -> Vec<(&'static str, Vec<Triangle>)> {
    let mut random = Random(1);
    let flat = soup(300, 0.5, &mut random)
        .into_iter()
        .map(|t| Triangle { vertices: t.vertices.map(|p| Vec3::new(p.x, 0.25, p.z)) })
        .collect();
    let collinear = (0..50)
        .map(|i| {
            let p = Vec3::splat(i as f32 * 0.01);
            triangle(p, p * 2.0, p * 3.0)
        })
        .collect();
    let mut with_degenerate = soup(100, 0.5, &mut random);
    for i in (0..100).step_by(3) {
        with_degenerate[i].vertices[2] = with_degenerate[i].vertices[i % 2];
    }
    with_degenerate[5].vertices[1].y = f32::NAN;
    with_degenerate[7].vertices[0].x = f32::INFINITY;
    let one = soup(1, 1.0, &mut random);
    vec![
        ("none", Vec::new()),
        ("two", soup(2, 1.0, &mut random)),
        ("identical", vec![one[0]; 500]),
        ("one", one),
        ("small triangles", soup(3000, 0.05, &mut random)),
        ("large triangles", soup(400, 2.0, &mut random)),
        ("flat", flat),
        ("collinear", collinear),
        ("degenerate among others", with_degenerate),
        ("huge", scaled(&soup(300, 0.5, &mut random), 1.0e30)),
        // Near the limits of packets, and of single rays with vectors.
        ("large", scaled(&soup(300, 0.5, &mut random), 1.0e17)),
        ("very large", scaled(&soup(300, 0.5, &mut random), 1.0e27)),
        ("tiny", scaled(&soup(300, 0.5, &mut random), 1.0e-30)),
        ("far away", moved(&soup(300, 0.5, &mut random), Vec3::new(1.0e4, -2.0e4, 0.5))),
        ("slivers", slivers(600, &mut random)),
        ("slivers far away", moved(&slivers(300, &mut random), Vec3::splat(700.0))),
        ("in one plane", in_one_plane(200, &mut random)),
        ("stacked", stacked(200)),
        ("chain", chain(400)),
    ]
}

/// Rays from all positions: many aimed at corners, edges and faces, some along axes, some grazing.
pub(crate) fn rays(triangles: &[Triangle], n: usize, random: &mut Random) -> Vec<Ray> {
    let finite = triangles.iter().filter(|t| t.vertices.iter().all(|p| p.is_finite()));
    let bounds = finite.clone().fold(Aabb::EMPTY, |all, t| all.union(t.bounds()));
    let finite: Vec<&Triangle> = finite.collect();
    let (center, reach) =
        if bounds.is_empty() { (Vec3::ZERO, 1.0) } else { (bounds.center(), bounds.extent().max_element()) };
    (0..n)
        .map(|i| {
            let mut origin = center + random.point() * reach * [0.5, 1.0, 20.0][i % 3];
            let mut direction = random.point();
            if let (false, kind @ 0..8) = (finite.is_empty(), i % 9) {
                let [a, b, c] = finite[random.below(finite.len())].vertices;
                let target = match kind {
                    0 => a,
                    1 => a * 0.5 + b * 0.5,
                    2..=4 => a * 0.5 + b * 0.25 + c * 0.25,
                    // Nearly in the triangle's plane.
                    5 => {
                        origin = a + (a - b) * 0.7 + (b - a).cross(c - a) / reach * 1.0e-3;
                        b * 0.5 + c * 0.5
                    }
                    6 => {
                        let axis = random.below(3);
                        let mut along = a * 0.25 + b * 0.25 + c * 0.5;
                        along[axis] += reach * random.signed();
                        origin = along;
                        along[axis] += if i % 16 < 8 { reach } else { -reach };
                        along
                    }
                    // Along an edge, up to rounding.
                    _ => {
                        origin = a * 2.0 - b;
                        if i % 2 == 0 { c } else { a * 0.5 + b * 0.25 + c * 0.25 }
                    }
                };
                direction = (target - origin) / [1.0, reach][i % 2];
            }
            let mut ray = Ray::new(origin, direction);
            if i % 5 == 0 {
                (ray.t_min, ray.t_max) = (0.25, 0.75);
            }
            ray
        })
        .filter(|ray| ray.direction != Vec3::ZERO && ray.direction.is_finite())
        .collect()
}

/// Sphere of 2 · `rings`² triangles whose vertices are shared exactly.
pub(crate) fn sphere(rings: usize) -> Vec<Triangle> {
    let vertex = |i: usize, j: usize| {
        let theta = std::f32::consts::PI * i as f32 / rings as f32;
        let phi = 2.0 * std::f32::consts::PI * (j % rings) as f32 / rings as f32;
        if i == 0 || i == rings {
            return Vec3::Y * if i == 0 { 1.0 } else { -1.0 };
        }
        let (s, c) = (libm::sinf(theta), libm::cosf(theta));
        Vec3::new(s * libm::cosf(phi), c, s * libm::sinf(phi))
    };
    let mut triangles = Vec::new();
    for i in 0..rings {
        for j in 0..rings {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| vertex(i, j));
            triangles.push(triangle(a, b, c));
            triangles.push(triangle(a, c, d));
        }
    }
    triangles
}
