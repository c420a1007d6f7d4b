//! Deformation of one primitive: morph targets, then skinning or a rigid transform to world space (glTF 2.0, sections 3.7.2.2
//! and 3.7.3).

use glam::{Mat3, Mat4, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::transform::SurfaceMap;
use crate::scene::{MorphTarget, Primitive};

/// Vertices of one parallel task.
const VERTICES_PER_TASK: usize = 4096;

/// A vertex in world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PosedVertex {
    /// Metres.
    pub position: Vec3,
    /// Unit shading normal; zero for flat shading.
    pub normal: Vec3,
    /// Unit tangent, and the sign of the bitangent in w; zero without a tangent.
    pub tangent: Vec4,
}

/// Transform of a primitive's vertices from mesh space to world space.
#[derive(Clone, Copy, Debug)]
pub(super) enum VertexTransform<'a> {
    /// The node's matrix.
    Rigid(&'a Mat4),
    /// Joint matrices, and the node's matrix for vertices that no joint influences.
    Skinned {
        /// World from mesh space, one for each joint.
        joint_matrices: &'a [Mat4],
        /// The node's matrix.
        world_from_node: &'a Mat4,
    },
}

/// What of vertices is posed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum VertexParts {
    /// Everything.
    #[default]
    All,
    /// Positions; normals and tangents are zero.
    Positions,
}

impl VertexTransform<'_> {
    /// The node's matrix.
    fn world_from_node(&self) -> &Mat4 {
        match self {
            Self::Rigid(matrix) => matrix,
            Self::Skinned { world_from_node, .. } => world_from_node,
        }
    }
}

/// The posed vertices of `primitive`, computed in parallel.
pub(super) fn posed_vertices(
    primitive: &Primitive,
    weights: &[f32],
    transform: VertexTransform<'_>,
    parts: VertexParts,
) -> impl IndexedParallelIterator<Item = PosedVertex> {
    let active = active_targets(primitive, weights);
    let rigid = match transform {
        VertexTransform::Rigid(matrix) => Some((matrix, SurfaceMap::new(Mat3::from_mat4(*matrix)))),
        VertexTransform::Skinned { .. } => None,
    };
    let posed = move |index: usize| {
        if parts == VertexParts::Positions {
            let skinned = match transform {
                VertexTransform::Rigid(_) => None,
                VertexTransform::Skinned { joint_matrices, .. } => {
                    skin_matrix(primitive, index, joint_matrices)
                }
            };
            let position = morphed_position(primitive, &active, index);
            let position = skinned.as_ref().unwrap_or(transform.world_from_node()).transform_point3(position);
            return PosedVertex { position, ..PosedVertex::default() };
        }
        let local = morphed(primitive, &active, index);
        match (&rigid, transform) {
            (Some((matrix, map)), _) => transformed(&local, matrix, map),
            (None, VertexTransform::Skinned { joint_matrices, world_from_node }) => {
                let matrix = skin_matrix(primitive, index, joint_matrices).unwrap_or(*world_from_node);
                transformed(&local, &matrix, &SurfaceMap::new(Mat3::from_mat4(matrix)))
            }
            (None, VertexTransform::Rigid(_)) => local,
        }
    };
    (0..primitive.positions.len()).into_par_iter().with_min_len(VERTICES_PER_TASK).map(posed)
}

/// Morph targets with a weight other than zero.
fn active_targets<'a>(primitive: &'a Primitive, weights: &[f32]) -> Vec<(&'a MorphTarget, f32)> {
    let weighted = primitive.targets.iter().zip(weights.iter().copied());
    weighted.filter(|&(_, weight)| weight != 0.0).collect()
}

fn morphed_position(primitive: &Primitive, active: &[(&MorphTarget, f32)], index: usize) -> Vec3 {
    let mut position = primitive.positions[index];
    for &(target, weight) in active {
        if let Some(deltas) = &target.positions {
            position += deltas[index] * weight;
        }
    }
    position
}

fn morphed(primitive: &Primitive, active: &[(&MorphTarget, f32)], index: usize) -> PosedVertex {
    let position = morphed_position(primitive, active, index);
    let mut normal = primitive.normals.as_ref().map_or(Vec3::ZERO, |normals| normals[index]);
    let mut tangent = primitive.tangents.as_ref().map_or(Vec4::ZERO, |tangents| tangents[index]);
    for &(target, weight) in active {
        if let (Some(deltas), Some(_)) = (&target.normals, &primitive.normals) {
            normal += deltas[index] * weight;
        }
        if let (Some(deltas), Some(_)) = (&target.tangents, &primitive.tangents) {
            tangent += (deltas[index] * weight).extend(0.0);
        }
    }
    PosedVertex { position, normal, tangent }
}

fn transformed(local: &PosedVertex, matrix: &Mat4, map: &SurfaceMap) -> PosedVertex {
    let tangent = map.tangent(local.tangent.truncate());
    PosedVertex {
        position: matrix.transform_point3(local.position),
        normal: map.normal(local.normal),
        tangent: tangent.extend(local.tangent.w * map.handedness),
    }
}

/// Skinning matrix Σ wᵢ Jᵢ; `None` if all weights are zero.
fn skin_matrix(primitive: &Primitive, index: usize, joint_matrices: &[Mat4]) -> Option<Mat4> {
    let influences = primitive.influences.as_ref()?;
    let range = index * influences.per_vertex..(index + 1) * influences.per_vertex;
    let pairs = influences.joints[range.clone()].iter().zip(&influences.weights[range]);
    let mut is_influenced = false;
    let mut sum = Mat4::ZERO;
    for (&joint, &weight) in pairs.filter(|&(_, &weight)| weight != 0.0) {
        is_influenced = true;
        sum += joint_matrices[joint as usize] * weight;
    }
    is_influenced.then_some(sum)
}

/// Texture coordinates and colours after morphing; `None` for attributes that morphing leaves alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MorphedAttributes {
    /// All sets of texture coordinates.
    pub(super) uvs: Option<Vec<Vec<Vec2>>>,
    /// Linear colours, clamped to 0..1.
    pub(super) colors: Option<Vec<Vec4>>,
}

/// Morphs texture coordinates and colours. Copies nothing unless an active target changes them.
pub(super) fn morph_attributes(primitive: &Primitive, weights: &[f32]) -> MorphedAttributes {
    let active = active_targets(primitive, weights);
    let mut morphed = MorphedAttributes::default();
    for &(target, weight) in &active {
        for (set, deltas) in &target.uvs {
            let uvs = morphed.uvs.get_or_insert_with(|| primitive.uvs.clone());
            if let Some(values) = uvs.get_mut(*set) {
                values.iter_mut().zip(deltas).for_each(|(value, &delta)| *value += delta * weight);
            }
        }
        if let (Some(deltas), Some(base)) = (&target.colors, &primitive.colors) {
            let colors = morphed.colors.get_or_insert_with(|| base.clone());
            colors.iter_mut().zip(deltas).for_each(|(value, &delta)| *value += delta * weight);
        }
    }
    for color in morphed.colors.iter_mut().flatten() {
        *color = color.clamp(Vec4::ZERO, Vec4::ONE);
    }
    morphed
}

/// Whether the transform mirrors the surface, so that the winding of triangles must be reversed.
///
/// The determinant of the node defines the winding, of skins as well (glTF 2.0, section 3.7.4, "Instantiation"), though the node does not move
/// them: Blender writes the skin of a mirrored rig in world space, wound inward, and its joint matrices do not mirror. Beyond the
/// specification, the skin of a node that does not mirror is reversed if all joints mirror it, as Blender shows bones of negative scale.
/// If both mirror, the node decides. That suits a mirrored node above a whole rig, but not negative bones in a mirrored armature of
/// Blender, which give the same signs.
pub(super) fn mirrors(transform: VertexTransform<'_>) -> bool {
    let map = |matrix: &Mat4| SurfaceMap::new(Mat3::from_mat4(*matrix));
    match transform {
        VertexTransform::Rigid(matrix) => map(matrix).handedness < 0.0,
        VertexTransform::Skinned { joint_matrices, world_from_node } => {
            // Joints that are scaled to zero flatten what they move, and do not count.
            let mut joints = joint_matrices.iter().filter_map(|matrix| map(matrix).mirrors());
            map(world_from_node).mirrors() == Some(true)
                || (joints.next() == Some(true) && joints.all(|mirrors| mirrors))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{MaterialIndex, SkinInfluences};

    fn one_vertex(position: Vec3) -> Primitive {
        Primitive {
            positions: vec![position],
            normals: Some(vec![Vec3::Y]),
            material: MaterialIndex(0),
            ..Primitive::default()
        }
    }

    fn posed(primitive: &Primitive, weights: &[f32], transform: VertexTransform<'_>) -> PosedVertex {
        let [whole, alone] = [VertexParts::All, VertexParts::Positions].map(|parts| {
            let vertices: Vec<_> = posed_vertices(primitive, weights, transform, parts).collect();
            vertices[0]
        });
        assert_eq!(alone, PosedVertex { position: whole.position, ..PosedVertex::default() });
        whole
    }

    #[test]
    fn a_two_bone_strip_bends_by_the_weighted_sum_of_its_joints() {
        // Joint 0 rests, joint 1 moves up by 2. A vertex with weights 1/4 and 3/4 rises by 3/4 · 2 = 1.5.
        let mut strip = one_vertex(Vec3::new(1.0, 0.0, 0.0));
        strip.influences =
            Some(SkinInfluences { per_vertex: 2, joints: vec![0, 1], weights: vec![0.25, 0.75] });
        let joints = [Mat4::IDENTITY, Mat4::from_translation(Vec3::new(0.0, 2.0, 0.0))];
        // The node's own matrix must have no effect.
        let node = Mat4::from_translation(Vec3::new(100.0, 0.0, 0.0));
        let transform = VertexTransform::Skinned { joint_matrices: &joints, world_from_node: &node };
        assert_eq!(posed(&strip, &[], transform).position, Vec3::new(1.0, 1.5, 0.0));
    }

    #[test]
    fn a_vertex_without_influences_follows_its_node() {
        let mut strip = one_vertex(Vec3::ZERO);
        strip.influences = Some(SkinInfluences { per_vertex: 1, joints: vec![0], weights: vec![0.0] });
        let node = Mat4::from_translation(Vec3::X);
        let transform =
            VertexTransform::Skinned { joint_matrices: &[Mat4::IDENTITY], world_from_node: &node };
        assert_eq!(posed(&strip, &[], transform).position, Vec3::X);
    }

    #[test]
    fn morphing_comes_before_skinning() {
        // Morph adds 0.5 · (2, 0, 0) = (1, 0, 0); the joint then rotates X to Y (90° about Z).
        let mut strip = one_vertex(Vec3::ZERO);
        strip.targets =
            vec![MorphTarget { positions: Some(vec![Vec3::new(2.0, 0.0, 0.0)]), ..Default::default() }];
        strip.influences = Some(SkinInfluences { per_vertex: 1, joints: vec![0], weights: vec![1.0] });
        let rotation = Mat4::from_cols(Vec4::Y, -Vec4::X, Vec4::Z, Vec4::W);
        let transform =
            VertexTransform::Skinned { joint_matrices: &[rotation], world_from_node: &Mat4::IDENTITY };
        let vertex = posed(&strip, &[0.5], transform);
        assert_eq!(vertex.position, Vec3::new(0.0, 1.0, 0.0));
        assert!(vertex.normal.abs_diff_eq(Vec3::NEG_X, 1e-6), "{}", vertex.normal);
    }

    #[test]
    fn morph_weights_add_up_and_may_leave_the_unit_interval() {
        let mut primitive = one_vertex(Vec3::ZERO);
        let target = |delta| MorphTarget { positions: Some(vec![delta]), ..Default::default() };
        primitive.targets = vec![target(Vec3::X), target(Vec3::Y), MorphTarget::default()];
        let vertex = posed(&primitive, &[1.5, -1.0, 7.0], VertexTransform::Rigid(&Mat4::IDENTITY));
        assert_eq!(vertex.position, Vec3::new(1.5, -1.0, 0.0));
    }

    #[test]
    fn a_mirrored_tangent_keeps_its_bitangent_in_the_world() {
        // B = (N × T) · w. Mirroring x: N = Y stays, T = X becomes −X, B = Y × X · 1 = −Z must stay −Z,
        // and Y × (−X) = Z, so w must flip.
        let mut primitive = one_vertex(Vec3::ZERO);
        primitive.tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0)]);
        let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        let vertex = posed(&primitive, &[], VertexTransform::Rigid(&mirror));
        assert_eq!(vertex.tangent, Vec4::new(-1.0, 0.0, 0.0, -1.0));
        assert!(mirrors(VertexTransform::Rigid(&mirror)));
    }

    #[test]
    fn the_node_of_a_skin_mirrors_it_whatever_its_joints_do() {
        let (identity, mirror) = (Mat4::IDENTITY, Mat4::from_scale(Vec3::new(1.0, -1.0, 1.0)));
        let flat = Mat4::from_scale(Vec3::new(-1.0, 1.0, 0.0));
        for (world_from_node, joint, expected) in [
            (identity, identity, false),
            (identity, mirror, true),
            (mirror, identity, true),
            (mirror, mirror, true),
            // A flat node does not flatten its skin.
            (flat, identity, false),
            (flat, mirror, true),
        ] {
            let skin =
                VertexTransform::Skinned { joint_matrices: &[joint], world_from_node: &world_from_node };
            assert_eq!(mirrors(skin), expected, "{world_from_node} {joint}");
        }
    }

    #[test]
    fn joints_that_are_scaled_to_zero_do_not_decide_whether_a_skin_is_mirrored() {
        let (mirror, zero) = (Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)), Mat4::from_scale(Vec3::ZERO));
        for (joints, expected) in [
            ([mirror, zero], true),
            ([zero, mirror], true),
            ([mirror, mirror], true),
            ([mirror, Mat4::IDENTITY], false),
            ([Mat4::IDENTITY, zero], false),
            ([zero, zero], false),
        ] {
            let skin = VertexTransform::Skinned { joint_matrices: &joints, world_from_node: &Mat4::IDENTITY };
            assert_eq!(mirrors(skin), expected);
        }
    }

    #[test]
    fn joints_that_are_flat_below_rotations_do_not_decide_either() {
        let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        for degrees in (0..360).step_by(5) {
            let angle = (degrees as f32).to_radians();
            for axis in [Vec3::X, Vec3::Y, Vec3::ONE.normalize(), Vec3::new(0.6, -0.8, 0.0)] {
                let turn = Mat4::from_axis_angle(axis, angle);
                let flat = turn * Mat4::from_scale(Vec3::new(100.0, 100.0, 0.0)) * turn.transpose();
                for joints in [[mirror, flat], [flat, mirror], [mirror, mirror * flat]] {
                    let skin = VertexTransform::Skinned {
                        joint_matrices: &joints,
                        world_from_node: &Mat4::IDENTITY,
                    };
                    assert!(mirrors(skin), "{axis} {degrees}");
                }
            }
        }
        // Thin is not flat.
        let thin = [mirror * Mat4::from_scale(Vec3::new(1.0, 1e-3, 1e-3)), Mat4::IDENTITY];
        for (joints, expected) in [(&thin[..1], true), (&thin[..], false)] {
            let skin = VertexTransform::Skinned { joint_matrices: joints, world_from_node: &Mat4::IDENTITY };
            assert_eq!(mirrors(skin), expected);
        }
    }

    #[test]
    fn morphed_colours_are_clamped() {
        let mut primitive = one_vertex(Vec3::ZERO);
        primitive.colors = Some(vec![Vec4::splat(0.75)]);
        primitive.targets = vec![MorphTarget { colors: Some(vec![Vec4::ONE]), ..Default::default() }];
        assert_eq!(morph_attributes(&primitive, &[0.5]).colors, Some(vec![Vec4::ONE]));
        assert_eq!(morph_attributes(&primitive, &[0.0]), MorphedAttributes::default());
    }
}
