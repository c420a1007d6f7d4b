//! Steps of world coordinates, which are 32-bit floats: far from the origin they round vertices, cameras and rays visibly.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat4, DVec3, Mat4};
use rayon::prelude::*;

use crate::error::Warning;
use crate::geometry::Aabb;
use crate::scene::{Mesh, MeshIndex, Node, NodeIndex, Scene, Skin, SkinIndex};

/// Largest step over the width of a mesh that images do not show.
const LARGEST_SHARE: f64 = 1e-3;
/// The width of a smaller mesh counts as this share of the scene's: images that show the whole scene do not show it.
const LEAST_WIDTH: f64 = 0.01;

/// Box as centre and half extent.
#[derive(Clone, Copy, Debug)]
struct CenteredBox {
    center: DVec3,
    half: DVec3,
}

impl CenteredBox {
    /// Box of the triangles' vertices; `None` where the mesh has none.
    fn of_mesh(mesh: &Mesh) -> Option<Self> {
        let of_parts = mesh.primitives.iter().map(|part| Aabb::from_points(&part.positions));
        let bounds = of_parts.fold(Aabb::EMPTY, Aabb::union);
        (!bounds.is_empty()).then(|| Self::between(bounds.min.as_dvec3(), bounds.max.as_dvec3()))
    }

    fn between(min: DVec3, max: DVec3) -> Self {
        Self { center: (min + max) * 0.5, half: (max - min) * 0.5 }
    }

    fn transformed(self, matrix: &DMat4) -> Self {
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate().abs());
        let half = x * self.half.x + y * self.half.y + z * self.half.z;
        Self { center: matrix.transform_point3(self.center), half }
    }

    fn union(self, other: Self) -> Self {
        let min = (self.center - self.half).min(other.center - other.half);
        Self::between(min, (self.center + self.half).max(other.center + other.half))
    }

    fn largest_coordinate(&self) -> f64 {
        (self.center.abs() + self.half).max_element()
    }

    fn width(&self) -> f64 {
        self.half.max_element() * 2.0
    }

    /// Distance of neighbouring 32-bit floats at the largest coordinate.
    fn step(&self) -> f64 {
        let largest = self.largest_coordinate() as f32;
        f64::from(largest.next_up()) - f64::from(largest)
    }

    /// The step over the width, or over `least_width` where that is more; 0 for a point, and where coordinates overflow.
    fn share(&self, least_width: f64) -> f64 {
        let share = self.step() / self.width().max(least_width);
        if share.is_finite() { share } else { 0.0 }
    }
}

/// The boxes of a mesh in world space: one for each instance.
fn world_boxes(of_mesh: CenteredBox, node: &Node, world: &Mat4) -> Vec<CenteredBox> {
    let transformed = |matrix: Mat4| of_mesh.transformed(&matrix.as_dmat4());
    match &node.instances {
        Some(instances) => instances.iter().map(|instance| transformed(*world * *instance)).collect(),
        None => vec![transformed(*world)],
    }
}

/// World matrices of the joints of a skin, from the space of its mesh.
fn joint_matrices(skin: &Skin, world: &[Mat4]) -> Vec<Mat4> {
    let joints = skin.joints.iter().zip(&skin.inverse_bind_matrices);
    joints.filter_map(|(joint, bind)| Some(*world.get(joint.index())? * *bind)).collect()
}

/// A warning about the mesh in any scene that the steps of its coordinates change most, if that is visible.
pub(super) fn coordinate_steps(scene: &Scene) -> Option<Warning> {
    let of_meshes: Vec<_> = scene.meshes.par_iter().map(CenteredBox::of_mesh).collect();
    let at_rest: Vec<_> = scene.nodes.iter().map(|node| node.local).collect();
    let mut world = Vec::new();
    scene.world_matrices(&at_rest, &mut world);
    let of_joints: Vec<_> = scene.skins.iter().map(|skin| joint_matrices(skin, &world)).collect();
    // Many nodes may show a mesh by one skin: one box around all joints.
    let mut of_skinned = BTreeMap::<(MeshIndex, SkinIndex), Option<CenteredBox>>::new();
    let mut boxes_of = |index: NodeIndex| {
        let node = scene.nodes.get(index.index())?;
        let mesh = node.mesh?;
        let of_mesh = (*of_meshes.get(mesh.index())?)?;
        let boxes = match node.skin.and_then(|skin| Some((skin, of_joints.get(skin.index())?))) {
            Some((skin, joints)) => {
                let transformed = |matrix: &Mat4| of_mesh.transformed(&matrix.as_dmat4());
                let around = || joints.iter().map(transformed).reduce(CenteredBox::union);
                of_skinned.entry((mesh, skin)).or_insert_with(around).iter().copied().collect()
            }
            None => world_boxes(of_mesh, node, world.get(index.index())?),
        };
        Some(boxes.into_iter().map(|world_box| (world_box, of_mesh, mesh, index)).collect::<Vec<_>>())
    };
    let of_nodes: Vec<_> = (0..scene.nodes.len() as u32).map(|index| boxes_of(NodeIndex(index))).collect();
    let of_scene = |roots: &[NodeIndex]| {
        let nodes = scene.nodes_below(roots);
        let boxes: Vec<_> =
            nodes.iter().filter_map(|node| of_nodes.get(node.index())?.as_ref()).flatten().copied().collect();
        let whole = boxes.iter().map(|(world_box, ..)| *world_box).reduce(CenteredBox::union)?;
        let least_width = LEAST_WIDTH * whole.width();
        let shares = boxes.into_iter().map(|found| (found.0.share(least_width), found));
        shares.max_by(|(a, _), (b, _)| a.total_cmp(b))
    };
    let distinct: BTreeSet<_> = scene.scenes.iter().map(|shown| &shown.roots).collect();
    let of_scenes = distinct.iter().filter_map(|roots| of_scene(roots));
    let (share, (worst, of_mesh, mesh, node)) = of_scenes.max_by(|(a, _), (b, _)| a.total_cmp(b))?;
    let is_rounded_itself = of_mesh.share(0.0) > LARGEST_SHARE;
    let pointer =
        if is_rounded_itself { format!("/meshes/{}", mesh.0) } else { format!("/nodes/{}", node.0) };
    let [largest, step, width] = [worst.largest_coordinate(), worst.step(), worst.width()].map(two_digits);
    let message = format!(
        "world coordinates near {largest} have steps of {step}, and the mesh is {width} wide; move it near the origin"
    );
    (share > LARGEST_SHARE).then_some(Warning { pointer, message })
}

/// A number with two significant digits, without exponent.
fn two_digits(number: f64) -> String {
    let text = format!("{number:.1e}");
    text.parse().map_or(text, |rounded: f64| rounded.to_string())
}
