//! The choice of one of many emissive triangles.

use arrayvec::ArrayVec;
use fearless_simd::Level;
use glam::Vec3;

use super::emitter::Emitter;
use super::light_bounds::LitPoint;
use super::light_tree_build::{MAX_LEVELS, build};
use super::light_tree_collapse::{NO_SLOT, WideLightTree, collapse};
use super::wide_light_node::{BELOW_ONE, WIDTH};
use crate::geometry::vectorized;

/// A tree over emissive triangles, which chooses one by the light that it may send to a point.
///
/// After Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018, and
/// `BVHLightSampler` in Pharr, Jakob and Humphreys, "Physically Based Rendering", 2023, section 12.6.3. Departures: nodes have up to
/// eight children, of which one is chosen at once; they are bounded by spheres; light from below a surface's horizon has no importance; nodes
/// are not split adaptively.
#[derive(Clone, Debug)]
pub(crate) struct LightTree {
    tree: WideLightTree,
    level: Level,
}

impl LightTree {
    /// The tree over `emitters`. Those without power or area or with coordinates that are not finite are never chosen.
    pub(crate) fn new(emitters: &[Emitter], level: Level) -> Self {
        Self { tree: collapse(&build(emitters), emitters.len()), level }
    }

    /// The index of an emitter that may light `point`, on the side that `normal` points to if there is one, and its probability.
    /// `u` is in [0, 1). `None` where no emitter or only ones that cannot light the point are found.
    pub(crate) fn sample(&self, point: Vec3, normal: Option<Vec3>, u: f32) -> Option<(u32, f32)> {
        vectorized!(self.level, self.sample_in_lanes(LitPoint { point, normal }, u))
    }

    #[inline(always)]
    fn sample_in_lanes(&self, at: LitPoint, u: f32) -> Option<(u32, f32)> {
        let mut node = self.tree.nodes.first()?;
        let mut u = refined(u, at.point);
        let mut probability = 1.0;
        loop {
            let chosen = node.weights(at)?.choose(u);
            probability *= chosen.probability;
            u = chosen.u;
            let index = node.index(chosen.lane);
            if node.is_emitter(chosen.lane) {
                return Some((index, to_f32(probability)));
            }
            node = &self.tree.nodes[index as usize];
        }
    }

    /// The probability with which [`LightTree::sample`] chooses an emitter.
    pub(crate) fn probability(&self, point: Vec3, normal: Option<Vec3>, emitter: u32) -> f32 {
        vectorized!(self.level, self.probability_in_lanes(LitPoint { point, normal }, emitter))
    }

    #[inline(always)]
    fn probability_in_lanes(&self, at: LitPoint, emitter: u32) -> f32 {
        // The choices, the last one first
        let mut slots = ArrayVec::<u32, MAX_LEVELS>::new();
        let mut slot = self.tree.leaves.get(emitter as usize).copied().unwrap_or(NO_SLOT);
        while slot != NO_SLOT {
            slots.push(slot);
            slot = self.tree.parents[slot as usize / WIDTH];
        }
        if slots.is_empty() {
            return 0.0;
        }
        let mut probability = 1.0;
        for slot in slots.into_iter().rev() {
            let node = &self.tree.nodes[slot as usize / WIDTH];
            let Some(weights) = node.weights(at) else { return 0.0 };
            let chosen = weights.probability(slot as usize % WIDTH);
            if chosen <= 0.0 {
                return 0.0;
            }
            probability *= chosen;
        }
        to_f32(probability)
    }
}

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
