//! A k-d tree over points of surfaces, by the axes of their normals: cells of about equal numbers of points.

use glam::Vec3;

use crate::geometry::Aabb;
use crate::integrator::path::normal_axis::{AXES, nearest_axis};

/// Cells by position and normal.
#[derive(Clone, Debug)]
pub(super) struct PointTree {
    nodes: Vec<Node>,
    /// The first node for each axis of normals; `None` where there are no points.
    roots: [Option<u32>; AXES],
}

#[derive(Clone, Copy, Debug)]
enum Node {
    /// Points with a coordinate below `at` are in the next node, others in the node `above`.
    Split {
        dimension: u8,
        at: f32,
        above: u32,
    },
    Cell(u32),
}

/// A position and a normal.
type Point = (Vec3, Vec3);

impl PointTree {
    /// A tree, and the indices of the points of each cell. A cell with more than `most` points has all of them at one position.
    pub(super) fn new(points: &[Point], most: usize) -> (Self, Vec<Vec<u32>>) {
        let mut by_axis: [Vec<u32>; AXES] = Default::default();
        for (index, (_, normal)) in (0..).zip(points) {
            by_axis[nearest_axis(*normal)].push(index);
        }
        let mut build = Build { points, most, nodes: Vec::new(), cells: Vec::new() };
        let roots = by_axis.map(|mut indices| (!indices.is_empty()).then(|| build.add(&mut indices)));
        (Self { nodes: build.nodes, roots }, build.cells)
    }

    /// The cell of a point; `None` where no point has such a normal.
    pub(super) fn cell(&self, position: Vec3, normal: Vec3) -> Option<u32> {
        let mut node = self.roots[nearest_axis(normal)]?;
        loop {
            match self.nodes[node as usize] {
                Node::Split { dimension, at, above } => {
                    node = if position[usize::from(dimension)] < at { node + 1 } else { above };
                }
                Node::Cell(cell) => return Some(cell),
            }
        }
    }
}

struct Build<'p> {
    points: &'p [Point],
    most: usize,
    nodes: Vec<Node>,
    cells: Vec<Vec<u32>>,
}

impl Build<'_> {
    /// Adds the nodes of some points, and returns the first.
    fn add(&mut self, indices: &mut [u32]) -> u32 {
        let node = self.nodes.len() as u32;
        let Some((dimension, at)) = self.split(indices) else {
            self.nodes.push(Node::Cell(self.cells.len() as u32));
            self.cells.push(indices.to_vec());
            return node;
        };
        // Filled in as soon as it is known where the nodes of the lower half end
        self.nodes.push(Node::Cell(0));
        indices.sort_by_key(|&index| self.points[index as usize].0[dimension] >= at);
        let middle = indices.partition_point(|&index| self.points[index as usize].0[dimension] < at);
        let (below, rest) = indices.split_at_mut(middle);
        self.add(below);
        let above = self.add(rest);
        self.nodes[node as usize] = Node::Split { dimension: dimension as u8, at, above };
        node
    }

    /// The median along the longest axis, which leaves points on both of its sides; `None` for a cell.
    fn split(&self, indices: &[u32]) -> Option<(usize, f32)> {
        if indices.len() <= self.most {
            return None;
        }
        let positions = || indices.iter().map(|&index| self.points[index as usize].0);
        let bounds = positions().fold(Aabb::EMPTY, Aabb::union_point);
        let extent = bounds.max - bounds.min;
        let dimension = extent.max_position();
        let mut coordinates: Vec<f32> = positions().map(|position| position[dimension]).collect();
        let middle = coordinates.len() / 2;
        let (_, &mut median, _) = coordinates.select_nth_unstable_by(middle, f32::total_cmp);
        // Where more than half of the coordinates are the least one, the others are on the other side.
        let least = bounds.min[dimension];
        let next = || coordinates.iter().copied().filter(|&at| at > least).min_by(f32::total_cmp);
        let at = if median > least { median } else { next()? };
        Some((dimension, at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::spiral_direction;

    /// Points of a flattened sphere, with normals along all axes.
    fn points(count: u32) -> Vec<Point> {
        let point = |index: u32| {
            let position = spiral_direction(index, count) * Vec3::new(1.0, 0.01, 0.3);
            (position, Vec3::AXES[index as usize % 3] * if index.is_multiple_of(2) { 1.0 } else { -1.0 })
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn each_point_is_in_one_cell_and_found_there() {
        let points = points(5000);
        let (tree, cells) = PointTree::new(&points, 100);
        let mut found = vec![0; points.len()];
        for (cell, indices) in (0..).zip(&cells) {
            assert!(!indices.is_empty() && indices.len() <= 100);
            for &index in indices {
                let (position, normal) = points[index as usize];
                assert_eq!(tree.cell(position, normal), Some(cell));
                found[index as usize] += 1;
            }
        }
        assert!(found.iter().all(|&count| count == 1));
        // Medians halve them.
        assert!(cells.iter().all(|indices| indices.len() >= 50));
    }

    #[test]
    fn points_at_one_position_are_one_cell() {
        let mut points = vec![(Vec3::ONE, Vec3::Y); 50];
        points.push((Vec3::new(1.0, 1.0, 2.0), Vec3::Y));
        let (tree, cells) = PointTree::new(&points, 10);
        assert_eq!(cells.iter().map(Vec::len).collect::<Vec<_>>(), [50, 1]);
        assert_eq!(tree.cell(Vec3::ZERO, Vec3::Y), Some(0));
        assert_eq!(tree.cell(Vec3::splat(9.0), Vec3::new(0.1, 0.9, 0.0)), Some(1));
        assert_eq!(tree.cell(Vec3::ONE, Vec3::NEG_Y), None);
        assert!(PointTree::new(&[], 10).1.is_empty());
    }
}
