//! Quick refusal of scenes that are no interiors, without a hierarchy.
//!
//! A point lies inside where visible sides of surfaces cover most directions around it. The sum of the solid angles of all
//! triangles that turn a visible side to the point is at least what they cover. It is estimated from a sample of the triangles, each
//! taken with a probability in proportion to its area.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

use crate::bvh::{TriangleFlags, is_traced};
use crate::frame::Frame;
use crate::geometry::{Ray, Triangle};

/// Number of triangles of the sample, besides large ones.
const SAMPLES: usize = 2048;
/// Triangles of one task. Sums of areas are taken in blocks of this size, whatever the number of threads.
const BLOCK: usize = 8192;
/// Solid angle in steradians below which a point is not inside: half of all directions. Interiors cover three quarters, so that the
/// error of the estimate does not matter.
const LEAST_SOLID_ANGLE: f32 = 0.5 * 4.0 * PI;

/// Points of a horizontal grid: every one of `x` with every one of `z`, at one height.
pub(super) struct GridPoints {
    pub(super) x: Vec<f32>,
    pub(super) y: f32,
    pub(super) z: Vec<f32>,
}

impl GridPoints {
    /// The points, row by row.
    pub(super) fn points(&self) -> impl Iterator<Item = Vec3> {
        self.z.iter().flat_map(move |&z| self.x.iter().map(move |&x| Vec3::new(x, self.y, z)))
    }

    /// The height of the first surface straight below each of the points; `None` where there is none.
    ///
    /// Each triangle is tested against the few vertical lines through its bounds.
    pub(super) fn floors_below(&self, frame: &Frame) -> Vec<Option<f32>> {
        let none = || vec![f32::INFINITY; self.x.len() * self.z.len()];
        let nearest = |mut nearest: Vec<f32>, (triangle, flags): (&Triangle, &TriangleFlags)| {
            if is_traced(triangle, *flags) {
                self.intersect_lines(triangle, &mut nearest);
            }
            nearest
        };
        let triangles = frame.triangles.par_iter().zip(&frame.flags).with_min_len(BLOCK);
        let distances = triangles
            .fold(none, nearest)
            .reduce(none, |a, b| a.into_iter().zip(b).map(|(a, b)| a.min(b)).collect());
        let height = |(point, t): (Vec3, f32)| t.is_finite().then(|| below(point).at(t).y);
        self.points().zip(distances).map(height).collect()
    }

    /// Lowers the distances of the points above a triangle to it.
    fn intersect_lines(&self, triangle: &Triangle, nearest: &mut [f32]) {
        let bounds = triangle.bounds();
        let is_across = |x: &f32| bounds.min.x <= *x && *x <= bounds.max.x;
        let is_along = |z: &f32| bounds.min.z <= *z && *z <= bounds.max.z;
        if !(self.x.iter().any(is_across) && self.z.iter().any(is_along)) {
            return;
        }
        for (nearest, point) in nearest.iter_mut().zip(self.points()) {
            if is_across(&point.x)
                && is_along(&point.z)
                && let Some(hit) = triangle.intersect(&below(point))
            {
                *nearest = nearest.min(hit.t);
            }
        }
    }
}

fn below(point: Vec3) -> Ray {
    Ray::new(point, Vec3::NEG_Y)
}

/// Of `points`, the number that may lie inside.
pub(super) fn possibly_enclosed(frame: &Frame, points: &[Vec3]) -> usize {
    let sample = AreaSample::new(frame);
    points.par_iter().filter(|&&point| sample.solid_angle(point) >= LEAST_SOLID_ANGLE).count()
}

/// A sample of a frame's triangles.
struct AreaSample {
    /// Corners, weight in the sum, and whether only the front is seen.
    triangles: Vec<(Triangle, f32, bool)>,
}

impl AreaSample {
    /// Systematic sampling: a triangle is taken where a multiple of a step lies in its part of the summed areas. Triangles larger
    /// than the step are always taken and count once, smaller ones count for others of their size.
    fn new(frame: &Frame) -> Self {
        let blocks = || frame.triangles.par_chunks(BLOCK).zip(frame.flags.par_chunks(BLOCK));
        let area_of_block = |(triangles, flags): (&[Triangle], &[TriangleFlags])| -> f64 {
            triangles.iter().zip(flags).map(|(triangle, flags)| visible_area(triangle, *flags)).sum()
        };
        let areas: Vec<f64> = blocks().map(area_of_block).collect();
        let step = areas.iter().sum::<f64>() / SAMPLES as f64;
        let starts = areas.iter().scan(0.0, |sum, area| Some(std::mem::replace(sum, *sum + area)));
        let starts: Vec<f64> = starts.collect();

        let sample_block = |((triangles, flags), &start): ((&[Triangle], &[TriangleFlags]), &f64)| {
            let mut sum = start;
            let mut taken = Vec::new();
            for (triangle, &flags) in triangles.iter().zip(flags) {
                let area = visible_area(triangle, flags);
                let before = (sum / step).floor();
                sum += area;
                if area >= step || (sum / step).floor() > before {
                    let weight = (step / area).max(1.0) as f32;
                    taken.push((*triangle, weight, flags.has(TriangleFlags::SINGLE_SIDED)));
                }
            }
            taken
        };
        let taken: Vec<Vec<_>> = blocks().zip(&starts).map(sample_block).collect();
        Self { triangles: taken.concat() }
    }

    /// Estimate of the summed solid angle of visible sides around `point`.
    fn solid_angle(&self, point: Vec3) -> f32 {
        let angles = self.triangles.iter().map(|(triangle, weight, is_single_sided)| {
            let angle = triangle.signed_solid_angle(point);
            if *is_single_sided { angle.max(0.0) * weight } else { angle.abs() * weight }
        });
        angles.sum()
    }
}

/// Twice the area of a triangle; zero for one that no ray hits.
fn visible_area(triangle: &Triangle, flags: TriangleFlags) -> f64 {
    let [a, b, c] = triangle.vertices.map(Vec3::as_dvec3);
    let area = (b - a).cross(c - a).length();
    if flags.has(TriangleFlags::HIDDEN) || !area.is_finite() { 0.0 } else { area }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The twelve triangles of a cube around the origin, seen from outside, cut into `cells`² quads a side.
    fn cube(half: f32, cells: u32) -> Frame {
        let mut frame = Frame::default();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let corner = |u: u32, v: u32| {
                    let mut corner = Vec3::ZERO;
                    let [u, v] = [u, v].map(|step| (step as f32 / cells as f32 * 2.0 - 1.0) * half);
                    (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (sign * half, u, v);
                    corner
                };
                for (u, v) in (0..cells).flat_map(|u| (0..cells).map(move |v| (u, v))) {
                    let [a, b, c, d] =
                        [(u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)].map(|(u, v)| corner(u, v));
                    let quad = if sign > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                    frame.triangles.extend(quad.map(|vertices| Triangle { vertices }));
                }
            }
        }
        frame.flags = vec![TriangleFlags::SINGLE_SIDED; frame.triangles.len()];
        frame
    }

    #[test]
    fn a_cube_covers_all_directions_inside_where_its_backs_are_seen() {
        for cells in [1, 60] {
            let mut frame = cube(1.0, cells);
            // From inside, only backs are seen.
            assert_eq!(possibly_enclosed(&frame, &[Vec3::ZERO]), 0);
            // From outside: a face of the half size r at the distance r covers a sixth of all directions.
            let outside = AreaSample::new(&frame).solid_angle(Vec3::new(0.0, 2.0, 0.0));
            assert!((outside - 4.0 * PI / 6.0).abs() < 0.05, "{outside}");
            // Both sides: all directions.
            frame.flags.fill(TriangleFlags::default());
            let inside = AreaSample::new(&frame).solid_angle(Vec3::splat(0.1));
            assert!((inside - 4.0 * PI).abs() < 0.05, "{inside}");
            assert_eq!(possibly_enclosed(&frame, &[Vec3::ZERO, Vec3::splat(9.0)]), 1);
        }
    }

    #[test]
    fn floors_are_the_first_surfaces_below() {
        let grid = GridPoints { x: vec![-0.9, 0.3, 1.1], y: 0.5, z: vec![0.2] };
        assert_eq!(grid.floors_below(&cube(1.0, 7)), [Some(-1.0), Some(-1.0), None]);
        let above = GridPoints { y: 3.0, ..grid };
        assert_eq!(above.floors_below(&cube(1.0, 7)), [Some(1.0), Some(1.0), None]);
    }
}
