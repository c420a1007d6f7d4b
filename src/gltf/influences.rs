//! Skinning influences of vertices: joints and renormalized weights of any number of sets.
//!
//! Source: glTF 2.0 specification, section 3.7.3.3 (skinned mesh attributes).

use super::accessor::Data;
use super::attributes::Attributes;
use super::context::Context;
use super::formats;
use super::raw::without_rounding_below;
use crate::error::Result;
use crate::scene::SkinInfluences;

/// Influences per vertex in one set.
const SET_SIZE: usize = 4;

/// Reads all `JOINTS_n` and `WEIGHTS_n`.
pub(super) fn read(
    context: &mut Context,
    data: &Data,
    attributes: &Attributes,
    pointer: &str,
) -> Result<Option<SkinInfluences>> {
    let joint_sets = attributes.sets(context, "JOINTS_")?;
    let weight_sets = attributes.sets(context, "WEIGHTS_")?;
    if joint_sets.len() != weight_sets.len() {
        let message = format!(
            "has {} JOINTS sets but {} WEIGHTS sets; their numbers must be equal",
            joint_sets.len(),
            weight_sets.len()
        );
        return Err(context.invalid(format!("{pointer}/attributes"), message));
    }
    if joint_sets.is_empty() {
        return Ok(None);
    }
    let mut sets = Vec::new();
    for (joints, weights) in joint_sets.iter().zip(&weight_sets) {
        let joints: Vec<[u32; SET_SIZE]> = data.integers_as(context, joints, &formats::JOINTS)?;
        let weights: Vec<[f32; SET_SIZE]> = data.floats_as(context, weights, &formats::WEIGHTS)?;
        sets.push((joints, weights));
    }
    let vertex_count = sets.first().map_or(0, |(joints, _)| joints.len());
    let influences = interleave(context, &sets, (vertex_count, data.vertices), pointer)?;
    Ok(Some(influences))
}

/// Joints and weights of one set, four per vertex.
type InfluenceSet = (Vec<[u32; SET_SIZE]>, Vec<[f32; SET_SIZE]>);

fn interleave(
    context: &mut Context,
    sets: &[InfluenceSet],
    (vertex_count, indices): (usize, Option<&[u32]>),
    pointer: &str,
) -> Result<SkinInfluences> {
    let per_vertex = sets.len().saturating_mul(SET_SIZE);
    let total = (vertex_count as u64).saturating_mul(per_vertex as u64);
    let mut joints: Vec<u32> = context.allocate(total, pointer)?;
    let mut weights: Vec<f32> = context.allocate(total, pointer)?;
    let mut has_unweighted = false;
    for vertex in 0..vertex_count {
        let start = weights.len();
        for (set_joints, set_weights) in sets {
            joints.extend(set_joints.get(vertex).into_iter().flatten());
            weights.extend(set_weights.get(vertex).into_iter().flatten());
        }
        let own_joints = joints.get_mut(start..).unwrap_or_default();
        let own_weights = weights.get_mut(start..).unwrap_or_default();
        let Some(is_weighted) = normalize(own_joints, own_weights) else {
            let vertex =
                indices.and_then(|indices| indices.get(vertex)).map_or(vertex, |&index| index as usize);
            let message = format!("vertex {vertex} has weights that are negative or too large");
            return Err(context.invalid(format!("{pointer}/attributes"), message));
        };
        has_unweighted |= !is_weighted;
    }
    if has_unweighted {
        context.warn(
            format!("{pointer}/attributes/WEIGHTS_0"),
            "all weights of some vertices are zero; they follow their node",
        );
    }
    Ok(SkinInfluences { per_vertex, joints, weights })
}

/// Scales the weights of a vertex to a sum of one and sets the joints of zero weights to 0. Returns `Some(false)` if all
/// weights are zero, `None` if a weight is clearly negative or their sum is not finite.
fn normalize(joints: &mut [u32], weights: &mut [f32]) -> Option<bool> {
    for weight in weights.iter_mut() {
        *weight = without_rounding_below(*weight, 0.0);
    }
    let sum: f32 = weights.iter().sum();
    if !sum.is_finite() || weights.iter().any(|&weight| weight < 0.0) {
        return None;
    }
    for (joint, weight) in joints.iter_mut().zip(weights.iter_mut()) {
        if sum > 0.0 {
            *weight /= sum;
        }
        if *weight == 0.0 {
            *joint = 0;
        }
    }
    Some(sum > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one() {
        let (mut joints, mut weights) = ([3, 9, 2, 1], [1.0, 0.0, 2.0, 1.0]);
        assert_eq!(normalize(&mut joints, &mut weights), Some(true));
        assert_eq!(weights, [0.25, 0.0, 0.5, 0.25]);
        assert_eq!(joints, [3, 0, 2, 1]);
        // Rounding errors below zero are none.
        let mut weights = [0.5, -1e-9];
        assert_eq!(normalize(&mut [1, 2], &mut weights), Some(true));
        assert_eq!(weights, [1.0, 0.0]);
    }

    #[test]
    fn zero_and_invalid_weights_are_distinguished() {
        assert_eq!(normalize(&mut [7], &mut [0.0]), Some(false));
        assert_eq!(normalize(&mut [0, 0], &mut [2.0, -1.0]), None);
        assert_eq!(normalize(&mut [0, 0], &mut [f32::MAX, f32::MAX]), None);
    }
}
