//! The choice of one of many emissive triangles.

use glam::Vec3;

use super::emitter::Emitter;
use super::light_node::LightNode;
use super::light_tree_build::build;

/// Where two nodes may both light a point, neither is chosen more seldom.
const LEAST_PROBABILITY: f64 = 1e-9;

/// A binary tree over emissive triangles, which chooses one by the light that it may send to a point.
///
/// After Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018, and
/// `BVHLightSampler` in Pharr, Jakob and Humphreys, "Physically Based Rendering", 2023, section 12.6.3. Departures: nodes are
/// bounded by spheres; light from below a surface's horizon has no importance; nodes are not split adaptively.
#[derive(Clone, Debug)]
pub(crate) struct LightTree {
    /// The root first; then pairs of siblings.
    nodes: Vec<LightNode>,
    /// For each emitter, the path to its leaf: a bit for each choice of a second child, the highest level in the lowest bit, then
    /// a one. Zero: it is not in the tree, as it emits nothing.
    paths: Vec<u64>,
}

impl LightTree {
    /// The tree over `emitters`. Those without power or area or with coordinates that are not finite are never chosen.
    pub(crate) fn new(emitters: &[Emitter]) -> Self {
        let (nodes, paths) = build(emitters);
        Self { nodes, paths }
    }

    /// The index of an emitter that may light `point`, on the side that `normal` points to if there is one, and its probability.
    /// `u` is in [0, 1). `None` where no emitter or only ones that cannot light the point are found.
    pub(crate) fn sample(&self, point: Vec3, normal: Option<Vec3>, u: f32) -> Option<(u32, f32)> {
        let mut node = self.lit_root(point, normal)?;
        let mut u = refined(u, point);
        let mut probability = 1.0;
        while !node.is_leaf() {
            let first = self.first_child_probability(node, point, normal)?;
            // Rescale the number for the next choice.
            let is_second = u >= first;
            let (chosen, start) = if is_second { (1.0 - first, first) } else { (first, 0.0) };
            u = ((u - start) / chosen).min(BELOW_ONE);
            probability *= chosen;
            node = &self.nodes[node.index() + usize::from(is_second)];
        }
        Some((node.index() as u32, to_f32(probability)))
    }

    /// The probability with which [`LightTree::sample`] chooses an emitter.
    pub(crate) fn probability(&self, point: Vec3, normal: Option<Vec3>, emitter: u32) -> f32 {
        let (Some(&path), Some(root)) = (self.paths.get(emitter as usize), self.lit_root(point, normal))
        else {
            return 0.0;
        };
        if path == 0 {
            return 0.0;
        }
        let (mut node, mut path, mut probability) = (root, path, 1.0);
        while path > 1 {
            let Some(first) = self.first_child_probability(node, point, normal) else { return 0.0 };
            let is_second = path & 1 == 1;
            let chosen = if is_second { 1.0 - first } else { first };
            if chosen <= 0.0 {
                return 0.0;
            }
            probability *= chosen;
            node = &self.nodes[node.index() + usize::from(is_second)];
            path >>= 1;
        }
        to_f32(probability)
    }

    /// The root, unless nothing lights the point.
    fn lit_root(&self, point: Vec3, normal: Option<Vec3>) -> Option<&LightNode> {
        self.nodes.first().filter(|root| root.importance(point, normal) > 0.0)
    }

    /// The probability of the first child of an inner node; `None` if neither lights the point.
    #[inline]
    fn first_child_probability(&self, node: &LightNode, point: Vec3, normal: Option<Vec3>) -> Option<f64> {
        let first = f64::from(self.nodes[node.index()].importance(point, normal));
        let second = f64::from(self.nodes[node.index() + 1].importance(point, normal));
        if first > 0.0 && second > 0.0 {
            Some((first / (first + second)).clamp(LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY))
        } else if first > 0.0 {
            Some(1.0)
        } else {
            (second > 0.0).then_some(0.0)
        }
    }
}

/// The largest number below one.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// `u` with more digits, from a hash of the point: its own 24 bits do not tell a million emitters apart.
fn refined(u: f32, point: Vec3) -> f64 {
    let steps = f64::from(1 << 24);
    let mut hash = u64::from(u.to_bits());
    for coordinate in point.to_array() {
        hash = (hash ^ hash >> 32 ^ u64::from(coordinate.to_bits())).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
    let fraction =
        ((hash ^ hash >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 32) as f64 / f64::from(u32::MAX);
    (((f64::from(u) * steps).floor() + fraction.min(0.999_999_999)) / steps).clamp(0.0, BELOW_ONE)
}

/// The probability of a choice, above zero.
fn to_f32(probability: f64) -> f32 {
    (probability as f32).max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests;
