//! How far what is framed reaches in given directions, over all measured times.
//!
//! Boxes of blocks bound it. Times are posed from the one that may reach farthest on, until no other can reach beyond those that were, and of each time only triangles of
//! blocks that may are looked at. The results are those of looking at everything, to the bit.

use glam::Vec3;
use rayon::prelude::*;

use super::blocks::reach;
use super::subject::{Subject, TimePoses};
use crate::bvh::TriangleFlags;
use crate::geometry::{Aabb, Triangle};

/// Blocks of one parallel task.
const BLOCKS_PER_TASK: usize = 64;

impl Subject<'_> {
    /// The largest product of any framed corner with each of `directions`, over the times. Negative infinity without any.
    pub(super) fn supports(&self, directions: &[Vec3]) -> Vec<f32> {
        let is_framed = self.framed_blocks();
        let times: Vec<usize> = self.visited_times(self.stride(directions.len())).collect();
        let bounds = |time: usize| (time, self.blocks.reaches(time, &is_framed, directions));
        let mut open: Vec<(usize, Vec<f32>)> = times.into_par_iter().map(bounds).collect();
        let mut supports = vec![f32::NEG_INFINITY; directions.len()];
        let mut poses = TimePoses::new(self);
        while let Some(next) = farthest(&open, &supports) {
            let (time, _) = open.remove(next);
            let (triangles, flags) = poses.at(time);
            supports =
                self.raised(&supports, (triangles, flags), (self.blocks.at(time), &is_framed), directions);
        }
        supports
    }

    /// The larger ones of `supports` and those of framed triangles that are posed like this, whose blocks have the given boxes.
    pub(super) fn raised(
        &self,
        supports: &[f32],
        (triangles, flags): (&[Triangle], &[TriangleFlags]),
        (boxes, is_framed): (&[Aabb], &[bool]),
        directions: &[Vec3],
    ) -> Vec<f32> {
        let size = self.blocks.size();
        let raise = |mut largest: Vec<f32>, (block, bounds): (usize, &Aabb)| {
            let first = block * size;
            let end = triangles.len().min(first + size);
            for (largest, direction) in largest.iter_mut().zip(directions) {
                if !is_framed[block] || reach(bounds, *direction) <= *largest {
                    continue;
                }
                for index in first..end {
                    if self.frames_triangle(index, &triangles[index], flags[index]) {
                        let [a, b, c] = triangles[index].vertices.map(|corner| corner.dot(*direction));
                        *largest = largest.max(a).max(b).max(c);
                    }
                }
            }
            largest
        };
        let blocks = boxes.par_iter().enumerate().with_min_len(BLOCKS_PER_TASK);
        let raised = blocks.fold(|| supports.to_vec(), raise);
        raised.reduce(|| supports.to_vec(), |a, b| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect())
    }

    /// Whether a block holds a framed triangle, by its index.
    pub(super) fn framed_blocks(&self) -> Vec<bool> {
        let size = self.blocks.size();
        let count = self.frame.triangles.len();
        let blocks = (0..count.div_ceil(size)).into_par_iter().with_min_len(BLOCKS_PER_TASK);
        let is_framed = |block: usize| {
            let first = block * size;
            (first..count.min(first + size)).any(|index| self.may_frame_triangle(index))
        };
        blocks.map(is_framed).collect()
    }
}

/// The open time that may exceed one of `supports` by most, the first of equal ones; `None` where none exceeds any.
fn farthest(open: &[(usize, Vec<f32>)], supports: &[f32]) -> Option<usize> {
    let excess = |(_, bounds): &(usize, Vec<f32>)| {
        let pairs = bounds.iter().zip(supports);
        let excesses = pairs.map(|(bound, support)| if bound > support { bound - support } else { 0.0 });
        excesses.fold(0.0, f32::max)
    };
    let mut largest = (0.0, None);
    for (index, time) in open.iter().enumerate() {
        let excess = excess(time);
        if excess > largest.0 {
            largest = (excess, Some(index));
        }
    }
    largest.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::{ImportOptions, import};
    use crate::scene::{CameraRequest, Selection, SelectionRequest};

    /// All framed triangles at all times that are visited.
    fn supports_of_all(subject: &Subject<'_>, directions: &[Vec3]) -> Vec<f32> {
        let mut supports = vec![f32::NEG_INFINITY; directions.len()];
        subject.visit(subject.stride(directions.len()), |triangles, flags| {
            for (index, triangle) in triangles.iter().enumerate() {
                if subject.frames_triangle(index, triangle, flags[index]) {
                    for (support, direction) in supports.iter_mut().zip(directions) {
                        let products = triangle.vertices.map(|corner| corner.dot(*direction));
                        *support = products.into_iter().fold(*support, f32::max);
                    }
                }
            }
        });
        supports
    }

    #[test]
    fn supports_are_those_of_all_triangles_at_all_times() {
        let directions: Vec<Vec3> = (0..8)
            .map(|index| crate::geometry::spiral_direction(index, 8) * (1.0 + index as f32))
            .chain([Vec3::ZERO])
            .collect();
        for path in ["animation/hierarchy.gltf", "animation/visibility.gltf", "demo/whitted_1980.gltf"] {
            let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(path);
            let scene = import(&path, &ImportOptions::default()).unwrap();
            let request =
                SelectionRequest { camera: Some(CameraRequest::Auto), ..SelectionRequest::default() };
            let (selection, _) = Selection::resolve(&request, &scene).unwrap();
            let still = Selection { clips: Vec::new(), ..selection.clone() };
            for (selection, clips) in [(&selection, &[][..]), (&selection, &selection.clips), (&still, &[])] {
                let mut subject = Subject::measure(&scene, selection, None, clips);
                assert_eq!(subject.supports(&directions), supports_of_all(&subject, &directions));
                // Posed anew instead of kept
                subject.kept = None;
                assert_eq!(subject.supports(&directions), supports_of_all(&subject, &directions));
                // Without some of the instances
                for (index, is_framed) in subject.is_framed.iter_mut().enumerate() {
                    *is_framed = index % 3 == 1;
                }
                assert_eq!(subject.supports(&directions), supports_of_all(&subject, &directions));
                subject.is_framed.fill(false);
                assert_eq!(subject.supports(&directions), vec![f32::NEG_INFINITY; directions.len()]);
            }
        }
    }
}
