//! A grid of cubes over points of surfaces, each cube once for each axis of normals.

use glam::Vec3;

use super::entry::VisibleEntry;
use super::reached_points::ReachedPoint;
use crate::geometry::Aabb;
use crate::integrator::path::normal_axis::{AXES, nearest_axis};

/// Cubes along the longest axis.
const CELLS: f32 = 12.0;

/// No entry.
const NONE: VisibleEntry = VisibleEntry::MAX;

// Each cube and axis may have an entry of its own.
const _: () = assert!((CELLS as usize + 1).pow(3) * AXES < NONE as usize);

/// Entries by position and normal.
#[derive(Clone, Debug)]
pub(super) struct PointGrid {
    origin: Vec3,
    cells_per_unit: f32,
    size: [usize; 3],
    entries: Vec<VisibleEntry>,
}

/// Points of one cube and axis.
#[derive(Debug)]
pub(super) struct PointGroup {
    pub(super) key: usize,
    /// Indices, ascending.
    pub(super) points: Vec<u32>,
}

impl PointGrid {
    /// A grid around points, at least one, without entries, and the points by groups.
    pub(super) fn new(points: &[ReachedPoint]) -> (Self, Vec<PointGroup>) {
        let bounds = points.iter().fold(Aabb::EMPTY, |bounds, point| bounds.union_point(point.position));
        // Not below the rounding of coordinates
        let largest = bounds.max.abs().max(bounds.min.abs()).max_element();
        let extent = (bounds.max - bounds.min).max_element().max(1e-5 * largest).max(1e-30);
        let cells_per_unit = CELLS / (extent * 1.001);
        // Points on the bounds are inside.
        let origin = bounds.min - extent * 0.0005;
        let size = ((bounds.max - origin) * cells_per_unit).to_array().map(|cells| cells as usize + 1);
        let entries = vec![NONE; size.iter().product::<usize>() * AXES];
        let grid = Self { origin, cells_per_unit, size, entries };

        let mut keys: Vec<(usize, u32)> = (0..)
            .zip(points)
            .filter_map(|(index, point)| Some((grid.key(point.position, point.normal)?, index)))
            .collect();
        keys.sort_unstable();
        let groups = keys.chunk_by(|a, b| a.0 == b.0);
        let group = |keys: &[(usize, u32)]| PointGroup {
            key: keys[0].0,
            points: keys.iter().map(|(_, point)| *point).collect(),
        };
        (grid, groups.map(group).collect())
    }

    pub(super) fn set(&mut self, key: usize, entry: VisibleEntry) {
        self.entries[key] = entry;
    }

    /// Gives cubes without an entry that of the nearest cube with one, for the same axis.
    pub(super) fn fill(&mut self) {
        // One layer of neighbours at a time
        loop {
            let before = self.entries.clone();
            for key in (0..before.len()).filter(|&key| before[key] == NONE) {
                if let Some(neighbor) = self.neighbors(key).find(|&neighbor| before[neighbor] != NONE) {
                    self.entries[key] = before[neighbor];
                }
            }
            if self.entries == before {
                return;
            }
        }
    }

    /// Keys of the cubes that share a face with that of a key.
    fn neighbors(&self, key: usize) -> impl Iterator<Item = usize> + use<> {
        let [columns, rows, layers] = self.size;
        let cell = key / AXES;
        let cube = [cell % columns, cell / columns % rows, cell / (columns * rows)];
        let strides = [1, columns, columns * rows].map(|stride| stride * AXES);
        [0, 1, 2].into_iter().flat_map(move |dimension| {
            let before = (cube[dimension] > 0).then(|| key - strides[dimension]);
            let is_last = cube[dimension] + 1 == [columns, rows, layers][dimension];
            [before, (!is_last).then(|| key + strides[dimension])].into_iter().flatten()
        })
    }

    pub(super) fn get(&self, position: Vec3, normal: Vec3) -> Option<VisibleEntry> {
        let entry = self.entries[self.key(position, normal)?];
        (entry != NONE).then_some(entry)
    }

    /// `None` outside of the grid.
    fn key(&self, position: Vec3, normal: Vec3) -> Option<usize> {
        let scaled = (position - self.origin) * self.cells_per_unit;
        let [x, y, z] = scaled.to_array().map(|coordinate| coordinate as usize);
        let [columns, rows, layers] = self.size;
        let is_inside = scaled.cmpge(Vec3::ZERO).all() && x < columns && y < rows && z < layers;
        is_inside.then(|| ((z * rows + y) * columns + x) * AXES + nearest_axis(normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(positions: &[Vec3]) -> Vec<ReachedPoint> {
        positions.iter().map(|&position| ReachedPoint { position, normal: Vec3::Y }).collect()
    }

    #[test]
    fn all_points_are_in_the_group_of_their_cube() {
        let positions: Vec<Vec3> = (0..1000_u32)
            .map(|i| Vec3::new((i % 10) as f32 * 3.0, (i / 10 % 10) as f32 - 40.0, (i / 100) as f32 * 1e-3))
            .collect();
        let points = points(&positions);
        let (grid, groups) = PointGrid::new(&points);
        let mut found: Vec<u32> = Vec::new();
        for group in &groups {
            for &index in &group.points {
                assert_eq!(grid.key(positions[index as usize], Vec3::Y), Some(group.key));
            }
            found.extend(&group.points);
        }
        found.sort_unstable();
        assert!(found.into_iter().eq(0..1000));
        assert_eq!(grid.get(positions[0], Vec3::Y), None);
        for outside in [Vec3::new(-1.0, -40.0, 0.0), Vec3::new(28.0, -40.0, 0.0), Vec3::NAN] {
            assert_eq!(grid.key(outside, Vec3::Y), None);
        }
    }

    #[test]
    fn one_point_is_a_grid() {
        let (grid, groups) = PointGrid::new(&points(&[Vec3::splat(7.0)]));
        assert_eq!(groups.len(), 1);
        assert_eq!(grid.key(Vec3::splat(7.0), Vec3::Y), Some(groups[0].key));
    }

    #[test]
    fn empty_cubes_get_the_nearest_entry_of_their_axis() {
        let points = points(&[Vec3::ZERO, Vec3::new(12.0, 0.0, 0.0)]);
        let (mut grid, groups) = PointGrid::new(&points);
        for (group, entry) in groups.iter().zip(0..) {
            grid.set(group.key, entry);
        }
        assert_eq!(grid.get(Vec3::new(3.0, 0.0, 0.0), Vec3::Y), None);
        grid.fill();
        let at = |x: f32| grid.get(Vec3::new(x, 0.0, 0.0), Vec3::Y);
        assert_eq!([at(0.0), at(3.0), at(9.0), at(12.0)], [Some(0), Some(0), Some(1), Some(1)]);
        assert_eq!(grid.get(Vec3::ZERO, Vec3::NEG_Y), None);
    }
}
