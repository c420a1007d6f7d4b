//! Nodes of light trees, whose children are weighed together.

use glam::Vec3;

use super::light_bounds::{CompactLightBounds, ImportanceWeights, LitPoint, larger};
use super::light_node::LightNode;

/// Most children of a node.
pub(super) const WIDTH: usize = 8;

/// No child that may light a point weighs less than this share of the largest weight.
const LEAST_SHARE: f32 = 1e-9;

/// The largest number below one.
pub(super) const BELOW_ONE: f64 = 1.0_f64.next_down();

/// The bounds of up to eight children, component by component, so that their importances are computed in lanes.
#[derive(Clone, Debug)]
pub(super) struct WideLightNode {
    center: [[f32; WIDTH]; 3],
    radius: [f32; WIDTH],
    axis: [[f32; WIDTH]; 3],
    cos_theta_o: [f32; WIDTH],
    sin_theta_o: [f32; WIDTH],
    /// Below zero where there is no child.
    power: [f32; WIDTH],
    /// One for emitters of which any is two-sided, else zero.
    two_sided: [f32; WIDTH],
    /// The index of the child's node or emitter.
    indices: [u32; WIDTH],
    /// A bit for each child that is an emitter.
    emitters: u8,
    importance_weights: ImportanceWeights,
}

/// What children of a node may send to a point.
pub(super) struct ChildWeights {
    weights: [f32; WIDTH],
    /// The sums of the weights up to each one.
    sums: [f64; WIDTH],
}

/// A child that was chosen.
pub(super) struct ChosenChild {
    pub(super) lane: usize,
    /// The probability of the choice, above zero.
    pub(super) probability: f64,
    /// A number in [0, 1) for the next choice.
    pub(super) u: f64,
}

impl WideLightNode {
    /// A node without children.
    pub(super) const EMPTY: Self = Self {
        center: [[0.0; WIDTH]; 3],
        radius: [0.0; WIDTH],
        axis: [[0.0; WIDTH]; 3],
        cos_theta_o: [1.0; WIDTH],
        sin_theta_o: [0.0; WIDTH],
        power: [-1.0; WIDTH],
        two_sided: [0.0; WIDTH],
        indices: [0; WIDTH],
        emitters: 0,
        importance_weights: ImportanceWeights::OF_EMITTERS,
    };

    /// Makes a node, or an emitter, of this index a child.
    pub(super) fn set(&mut self, lane: usize, child: &LightNode, index: u32, is_emitter: bool) {
        let CompactLightBounds { center, radius, axis, cos_theta_o, sin_theta_o, power } = child.bounds;
        for (component, (center, axis)) in center.to_array().into_iter().zip(axis.to_array()).enumerate() {
            self.center[component][lane] = center;
            self.axis[component][lane] = axis;
        }
        self.radius[lane] = radius;
        self.cos_theta_o[lane] = cos_theta_o;
        self.sin_theta_o[lane] = sin_theta_o;
        self.power[lane] = power;
        self.two_sided[lane] = f32::from(u8::from(child.is_two_sided));
        self.indices[lane] = index;
        self.emitters |= u8::from(is_emitter) << lane;
        if !is_emitter {
            self.importance_weights = ImportanceWeights::OF_SETS;
        }
    }

    /// The index of a child's node or emitter.
    #[inline(always)]
    pub(super) fn index(&self, lane: usize) -> u32 {
        self.indices[lane]
    }

    /// Whether a child is an emitter.
    #[inline(always)]
    pub(super) fn is_emitter(&self, lane: usize) -> bool {
        self.emitters >> lane & 1 != 0
    }

    /// See [`CompactLightBounds::importance`]; zero where there is no child.
    #[inline(always)]
    pub(super) fn importance(&self, lane: usize, at: LitPoint) -> f32 {
        let [x, y, z] = &self.center;
        let [axis_x, axis_y, axis_z] = &self.axis;
        let bounds = CompactLightBounds {
            center: Vec3::new(x[lane], y[lane], z[lane]),
            radius: self.radius[lane],
            axis: Vec3::new(axis_x[lane], axis_y[lane], axis_z[lane]),
            cos_theta_o: self.cos_theta_o[lane],
            sin_theta_o: self.sin_theta_o[lane],
            power: self.power[lane],
        };
        let importance = bounds.importance(at, self.two_sided[lane] > 0.0, self.importance_weights);
        if self.power[lane] < 0.0 { 0.0 } else { importance }
    }

    /// The weights of the children; `None` if none may light the point.
    #[inline(always)]
    pub(super) fn weights(&self, at: LitPoint) -> Option<ChildWeights> {
        let mut weights = [0.0; WIDTH];
        // A loop is vectorised where a condition is known.
        if let LitPoint { point, normal: Some(normal) } = at {
            for (lane, weight) in weights.iter_mut().enumerate() {
                *weight = self.importance(lane, LitPoint { point, normal: Some(normal) });
            }
        } else {
            for (lane, weight) in weights.iter_mut().enumerate() {
                *weight = self.importance(lane, LitPoint { point: at.point, normal: None });
            }
        }
        let least = LEAST_SHARE * weights.iter().fold(0.0, |most: f32, &weight| larger(most, weight));
        let mut sums = [0.0; WIDTH];
        let mut sum = 0.0;
        for (weight, sum_to) in weights.iter_mut().zip(&mut sums) {
            *weight = if *weight > 0.0 { larger(*weight, least) } else { 0.0 };
            sum += f64::from(*weight);
            *sum_to = sum;
        }
        (sum > 0.0).then_some(ChildWeights { weights, sums })
    }
}

impl ChildWeights {
    /// The child at `u`, in [0, 1).
    #[inline(always)]
    pub(super) fn choose(&self, u: f64) -> ChosenChild {
        let [.., sum] = self.sums;
        let at = u * sum;
        // The first child whose sum is beyond. There is one: `u` times the sum is below it, also rounded.
        let lane = self.sums.iter().map(|&to| usize::from(to <= at)).sum::<usize>().min(WIDTH - 1);
        let before = if lane == 0 { 0.0 } else { self.sums[lane - 1] };
        let u = ((at - before) / f64::from(self.weights[lane])).clamp(0.0, BELOW_ONE);
        ChosenChild { lane, probability: self.probability(lane), u }
    }

    /// The probability of a child.
    #[inline(always)]
    pub(super) fn probability(&self, lane: usize) -> f64 {
        let [.., sum] = self.sums;
        f64::from(self.weights[lane]) / sum
    }
}
