//! Inherited visibility, the nodes of a selection, and the transform of normals.

use glam::{Mat3, Vec3};

use crate::geometry::unit;
use crate::scene::{NodeIndex, Scene, Selection};

/// Hides the descendants of hidden nodes. On entry, `hidden` tells for each node whether the node itself is hidden.
pub(super) fn inherit_hidden(scene: &Scene, hidden: &mut [bool]) {
    for &node in &scene.node_order {
        if let Some(parent) = scene.nodes[node.index()].parent {
            hidden[node.index()] |= hidden[parent.index()];
        }
    }
}

/// All nodes under the selected roots, depth first in the order of the file.
pub(super) fn selected_nodes(scene: &Scene, selection: &Selection) -> Vec<NodeIndex> {
    let mut selected = Vec::new();
    let mut pending: Vec<NodeIndex> = selection.roots.iter().rev().copied().collect();
    while let Some(node) = pending.pop() {
        selected.push(node);
        pending.extend(scene.nodes[node.index()].children.iter().rev());
    }
    selected
}

/// A linear map of surfaces: tangents transform by the map, normals by its inverse transpose.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceMap {
    linear: Mat3,
    cofactors: Mat3,
    /// −1 if the map mirrors, else 1.
    pub(super) handedness: f32,
}

impl SurfaceMap {
    pub(super) fn new(linear: Mat3) -> Self {
        // The cofactor matrix is det · inverse transpose. It exists for singular maps as well.
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let cofactors = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let determinant = x.dot(cofactors.x_axis);
        Self { linear, cofactors, handedness: if determinant < 0.0 { -1.0 } else { 1.0 } }
    }

    /// Whether the map mirrors; `None` for one that is flat but for rounding, whose determinant has no meaningful sign.
    pub(super) fn mirrors(&self) -> Option<bool> {
        /// Errors of matrix products, over the largest element.
        const ROUNDING: f32 = 1e-5;
        let largest = |matrix: &Mat3| matrix.to_cols_array().iter().fold(0.0, |max: f32, x| max.max(x.abs()));
        // The cofactors are the derivatives of the determinant by the elements.
        let determinant = self.linear.x_axis.dot(self.cofactors.x_axis);
        let error = ROUNDING * largest(&self.linear) * largest(&self.cofactors);
        (determinant.abs() > error).then_some(determinant < 0.0)
    }

    /// A unit normal, or zero if the map collapses the surface.
    pub(super) fn normal(&self, normal: Vec3) -> Vec3 {
        unit(self.cofactors * normal * self.handedness).unwrap_or(Vec3::ZERO)
    }

    /// A unit tangent, or zero.
    pub(super) fn tangent(&self, tangent: Vec3) -> Vec3 {
        unit(self.linear * tangent).unwrap_or(Vec3::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_stay_perpendicular_under_non_uniform_and_negative_scale() {
        let map = SurfaceMap::new(Mat3::from_diagonal(Vec3::new(-2.0, 1.0, 1.0)));
        // The plane through (1, 0, 0) and (0, 1, 0) along z has normal (1, 1, 0); scaled by (−2, 1, 1) it runs
        // through (−2, 0, 0) and (0, 1, 0), whose outward normal is (−1, 2, 0).
        let normal = map.normal(Vec3::new(1.0, 1.0, 0.0));
        assert!(normal.abs_diff_eq(Vec3::new(-1.0, 2.0, 0.0).normalize(), 1e-6), "{normal}");
        assert_eq!(map.handedness, -1.0);
    }

    #[test]
    fn singular_and_tiny_maps_give_no_nan() {
        assert_eq!(SurfaceMap::new(Mat3::ZERO).normal(Vec3::Y), Vec3::ZERO);
        let tiny = SurfaceMap::new(Mat3::from_diagonal(Vec3::splat(1e-18)));
        assert!(tiny.normal(Vec3::Y).abs_diff_eq(Vec3::Y, 1e-6));
    }
}
