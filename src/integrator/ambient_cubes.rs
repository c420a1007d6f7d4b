//! Irradiance in a box, by position and normal: a grid of ambient cubes.

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use crate::geometry::Aabb;

/// Cosine between the normal of a surface and the axis that it faces, at least.
const FACING_COSINE: f32 = 0.5;
/// Share of the positions at either end of each axis that may be beyond the grid: far ones that are seen through windows.
const OUTLIERS: f32 = 0.05;

/// A grid of ambient cubes. Points beyond it have the light at its edge.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AmbientCubes {
    bounds: Aabb,
    /// Cells along each axis.
    cells: [usize; 3],
    cells_a_metre: Vec3,
    /// Of the corners of the cells, x first.
    cubes: Vec<AmbientCube>,
}

/// Irradiance of surfaces that face the negative and the positive direction of each axis (McTaggart 2004).
type AmbientCube = [[Vec3A; 2]; 3];

impl AmbientCubes {
    /// A grid in the box of most `samples` of a surface, of which there must be one, with `most_cells` along its longest axis. `position_and_normal` are those of a
    /// sample. `light_at` is the irradiance at a point by the samples that face one direction of an axis, or by all where none does.
    pub(super) fn new<T: Copy + Sync>(
        samples: &[T],
        most_cells: usize,
        position_and_normal: impl Fn(&T) -> (Vec3, Vec3),
        light_at: impl Fn(Vec3, &[T]) -> Vec3A + Sync,
    ) -> Self {
        let positions: Vec<Vec3> = samples.iter().map(|sample| position_and_normal(sample).0).collect();
        let bounds = bounds_of(&positions);
        let extent = bounds.extent();
        let cell = (extent.max_element() / most_cells as f32).max(f32::MIN_POSITIVE);
        let cells = extent.to_array().map(|length| ((length / cell).round() as usize).clamp(1, most_cells));
        let cells_a_metre =
            Vec3::from_array(cells.map(|count| count as f32)) / extent.max(Vec3::splat(f32::MIN_POSITIVE));

        let facing = facing_samples(samples, |sample| position_and_normal(sample).1);
        let [width, height, depth] = cells.map(|count| count + 1);
        let cubes = (0..width * height * depth).into_par_iter().map(|index| {
            let corner = [index % width, index / width % height, index / (width * height)];
            let point = bounds.min + Vec3::from_array(corner.map(|count| count as f32)) / cells_a_metre;
            facing.each_ref().map(|sides| sides.each_ref().map(|samples| light_at(point, samples)))
        });
        Self { bounds, cells, cells_a_metre, cubes: cubes.collect() }
    }

    /// Irradiance on a surface with this normal: trilinear between the corners of a cell.
    pub(super) fn irradiance(&self, position: Vec3, normal: Vec3) -> Vec3 {
        let Self { bounds, cells, .. } = self;
        let at = (position.clamp(bounds.min, bounds.max) - bounds.min) * self.cells_a_metre;
        let strides = [1, cells[0] + 1, (cells[0] + 1) * (cells[1] + 1)];
        let (mut first, mut fractions) = (0, [0.0; 3]);
        for axis in 0..3 {
            let cell = (at[axis] as usize).min(cells[axis] - 1);
            first += cell * strides[axis];
            fractions[axis] = at[axis] - cell as f32;
        }
        let squares = normal * normal;
        let sides = normal.to_array().map(|component| usize::from(component > 0.0));
        let mut sum = Vec3A::ZERO;
        for corner in 0..8 {
            let (mut index, mut share) = (first, 1.0);
            for axis in 0..3 {
                let is_far = corner >> axis & 1;
                index += is_far * strides[axis];
                share *= if is_far == 1 { fractions[axis] } else { 1.0 - fractions[axis] };
            }
            let [x, y, z] = &self.cubes[index];
            sum += (x[sides[0]] * squares.x + y[sides[1]] * squares.y + z[sides[2]] * squares.z) * share;
        }
        sum.into()
    }

    /// The grid that is `share` of the way from `self` to `other`, of the same cells.
    pub(super) fn towards(&self, other: &Self, share: f32) -> Self {
        let mut mixed = self.clone();
        let sides = mixed.cubes.iter_mut().flatten().flatten();
        for (light, other) in sides.zip(other.cubes.iter().flatten().flatten()) {
            *light += (*other - *light) * share;
        }
        mixed
    }

    /// Numbers that tell one grid from any other.
    pub(super) fn bits(&self) -> impl Iterator<Item = u32> {
        let light = self.cubes.iter().flatten().flatten().map(|light| Vec3::from(*light));
        let numbers = [self.bounds.min, self.bounds.max].into_iter().chain(light);
        numbers.flat_map(|vector| vector.to_array()).map(f32::to_bits)
    }
}

/// The weights of samples around a point by their squared distances: a smooth function of the distance, 0 from `reach` times that of the sample after the `nearest` first ones
/// on.
pub(super) fn kernel_weights(
    squared_distances: Vec<f32>,
    nearest: usize,
    reach: f32,
) -> impl Iterator<Item = f32> {
    let mut sorted = squared_distances.clone();
    let nearest = nearest.min(sorted.len().saturating_sub(1));
    let distance =
        if sorted.is_empty() { 0.0 } else { *sorted.select_nth_unstable_by(nearest, f32::total_cmp).1 };
    let scale = 1.0 / (distance * (reach * reach)).max(f32::MIN_POSITIVE);
    squared_distances.into_iter().map(move |squared| {
        let kernel = (1.0 - squared * scale).max(0.0);
        kernel * kernel
    })
}

/// The box that contains most positions.
fn bounds_of(positions: &[Vec3]) -> Aabb {
    let mut bounds = Aabb { min: Vec3::ZERO, max: Vec3::ZERO };
    let last = positions.len() - 1;
    let outliers = (last as f32 * OUTLIERS) as usize;
    for axis in 0..3 {
        let mut coordinates: Vec<f32> = positions.iter().map(|position| position[axis]).collect();
        coordinates.sort_unstable_by(f32::total_cmp);
        (bounds.min[axis], bounds.max[axis]) = (coordinates[outliers], coordinates[last - outliers]);
    }
    bounds
}

/// The samples that face the negative and positive direction of each axis; all of them where none does.
fn facing_samples<T: Copy>(samples: &[T], normal: impl Fn(&T) -> Vec3) -> [[Vec<T>; 2]; 3] {
    std::array::from_fn(|axis| {
        [-1.0, 1.0].map(|side| {
            let faces = |sample: &&T| normal(sample)[axis] * side > FACING_COSINE;
            let facing: Vec<T> = samples.iter().filter(faces).copied().collect();
            if facing.is_empty() { samples.to_vec() } else { facing }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_end_at_the_reach() {
        let squared = [0.0, 1.0, 4.0, 9.0, 16.0, 25.0];
        let weights: Vec<f32> = kernel_weights(squared.to_vec(), 2, 2.0).collect();
        // The third one is 2 away, so that the reach is 4.
        let expected = squared.map(|squared: f32| (1.0 - squared / 16.0).max(0.0).powi(2));
        assert_eq!(weights, expected);
        assert_eq!(kernel_weights(squared[..2].to_vec(), 6, 2.0).collect::<Vec<_>>(), [1.0, 0.5625]);
        assert_eq!(kernel_weights(Vec::new(), 6, 2.0).count(), 0);
        // All in one point
        assert_eq!(kernel_weights(vec![0.0; 3], 6, 2.0).collect::<Vec<_>>(), [1.0; 3]);
    }

    #[test]
    fn the_light_is_trilinear_between_corners() {
        let samples: Vec<Vec3> = (0..100).map(|index| Vec3::new(index as f32, 0.0, 2.0)).collect();
        let light_at = |point: Vec3, samples: &[Vec3]| Vec3A::new(point.x, point.z, samples.len() as f32);
        let cubes = AmbientCubes::new(&samples, 4, |position| (*position, Vec3::Y), light_at);
        // 5 % at either end are beyond the grid.
        for (x, expected) in [(50.0, 50.0), (31.7, 31.7), (-3.0, 4.0), (1e30, 95.0)] {
            let found = cubes.irradiance(Vec3::new(x, 7.0, 0.0), Vec3::new(0.6, 0.8, 0.0));
            assert!((found - Vec3::new(expected, 2.0, 100.0)).length() < 1e-3, "{x}: {found}");
        }
    }
}
