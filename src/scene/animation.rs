//! Animation clips: keyframes and their targets. [`crate::frame`] evaluates them.

use std::collections::BTreeSet;

use super::{
    AnimationIndex, CameraIndex, CameraProperty, ImageLightIndex, ImageLightProperty, LightIndex,
    LightProperty, MaterialIndex, MaterialProperty, MeshIndex, NodeIndex,
};

/// Animation clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Channels, one for each target.
    pub channels: Vec<Channel>,
}

impl Animation {
    /// Time of the last keyframe, seconds; 0 if all keyframes are before time 0.
    pub fn duration_seconds(&self) -> f32 {
        self.channels
            .iter()
            .filter_map(|channel| channel.keyframes.times_seconds.last())
            .fold(0.0, |a, &b| if b > a { b } else { a })
    }

    /// Time of the first keyframe of all channels, seconds. Before it, properties have their first values.
    pub fn start_seconds(&self) -> f32 {
        let first_keys = self.channels.iter().filter_map(|channel| channel.keyframes.times_seconds.first());
        first_keys.copied().reduce(|a, b| if b < a { b } else { a }).unwrap_or(0.0)
    }

    /// Whether any property changes its value over time.
    pub fn moves(&self) -> bool {
        self.channels.iter().any(|channel| !channel.keyframes.are_constant())
    }
}

/// Time of the first keyframe of `clips`, seconds; 0 without clips.
pub(super) fn first_key_seconds(animations: &[Animation], clips: &[AnimationIndex]) -> f32 {
    let clips = clips.iter().filter_map(|clip| animations.get(clip.index()));
    clips.map(Animation::start_seconds).reduce(|a, b| if b < a { b } else { a }).unwrap_or(0.0)
}

/// Keyframes of one target.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The animated property.
    pub target: AnimationTarget,
    /// The keyframes.
    pub keyframes: Keyframes,
}

/// Animated property. No two channels of one clip have the same target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AnimationTarget {
    /// Translation of a node: 3 components.
    Translation(NodeIndex),
    /// Rotation of a node: 4 components, a quaternion x y z w.
    Rotation(NodeIndex),
    /// Scale of a node: 3 components.
    Scale(NodeIndex),
    /// Morph weights of a node: one component for each morph target.
    Weights(NodeIndex),
    /// Morph weights of a mesh, overridden by those of nodes: one component for each morph target.
    MeshWeights(MeshIndex),
    /// One of the morph weights of a node: 1 component.
    Weight(NodeIndex, u32),
    /// One of the morph weights of a mesh: 1 component.
    MeshWeight(MeshIndex, u32),
    /// Visibility of a node and its descendants: 0 hides.
    Visibility(NodeIndex),
    /// A property of a material.
    Material(MaterialIndex, MaterialProperty),
    /// A property of a light.
    Light(LightIndex, LightProperty),
    /// A property of a camera: 1 component.
    Camera(CameraIndex, CameraProperty),
    /// A property of an image-based light.
    ImageLight(ImageLightIndex, ImageLightProperty),
}

impl AnimationTarget {
    /// The node whose transform, weights or visibility this is.
    pub fn node(self) -> Option<NodeIndex> {
        match self {
            Self::Translation(node)
            | Self::Rotation(node)
            | Self::Scale(node)
            | Self::Weights(node)
            | Self::Weight(node, _)
            | Self::Visibility(node) => Some(node),
            _ => None,
        }
    }

    /// Whether one of the targets `held` animates this property or part of it.
    pub fn clashes(self, held: &BTreeSet<Self>) -> bool {
        let any = |first, last| held.range(first..=last).next().is_some();
        held.contains(&self)
            || match self {
                Self::Weights(node) => any(Self::Weight(node, 0), Self::Weight(node, u32::MAX)),
                Self::MeshWeights(mesh) => any(Self::MeshWeight(mesh, 0), Self::MeshWeight(mesh, u32::MAX)),
                Self::Weight(node, _) => held.contains(&Self::Weights(node)),
                Self::MeshWeight(mesh, _) => held.contains(&Self::MeshWeights(mesh)),
                _ => false,
            }
    }
}

/// Keyframe times and values.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyframes {
    /// Times in order; at least one. Equal times are a sudden change, negative ones are before the first frame.
    pub times_seconds: Vec<f32>,
    /// `width` values for each key. Cubic splines have `3 · width`: in-tangent, value, out-tangent.
    pub values: Vec<f32>,
    /// Number of components of one value.
    pub width: usize,
    /// Interpolation between keys.
    pub interpolation: Interpolation,
}

impl Keyframes {
    /// Whether the value is the same at all times.
    pub fn are_constant(&self) -> bool {
        let width = self.width;
        if self.interpolation != Interpolation::CubicSpline {
            return self.values.windows(width + 1).all(|pair| pair[0] == pair[width]);
        }
        let value = |key: usize| &self.values[(3 * key + 1) * width..(3 * key + 2) * width];
        let (first, keys) = (value(0), self.times_seconds.len());
        let tangents = |key: usize| {
            let [incoming, outgoing] =
                [3 * key, 3 * key + 2].map(|part| &self.values[part * width..][..width]);
            incoming.iter().chain(outgoing)
        };
        (0..keys).all(|key| value(key) == first && tangents(key).all(|slope| *slope == 0.0))
    }
}

/// Interpolation between keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Constant up to the next key.
    Step,
    /// Linear; rotations follow the shorter arc.
    Linear,
    /// Cubic Hermite splines with stored tangents.
    CubicSpline,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keyframes(interpolation: Interpolation, width: usize, values: &[f32]) -> Keyframes {
        let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let keys = values.len() / width / parts;
        Keyframes {
            times_seconds: (0..keys).map(|key| key as f32).collect(),
            values: values.to_vec(),
            width,
            interpolation,
        }
    }

    #[test]
    fn values_that_change_are_told_from_constant_ones() {
        for interpolation in [Interpolation::Step, Interpolation::Linear] {
            let are_constant = |values: &[f32]| keyframes(interpolation, 2, values).are_constant();
            assert!(are_constant(&[1.0, 2.0]) && are_constant(&[1.0, 2.0, 1.0, 2.0, 1.0, 2.0]));
            assert!(!are_constant(&[1.0, 2.0, 1.0, 3.0, 1.0, 2.0]));
            assert!(!are_constant(&[2.0, 2.0, 1.0, 2.0]));
        }
        let splines = |values: &[f32]| keyframes(Interpolation::CubicSpline, 1, values).are_constant();
        assert!(splines(&[0.0, 5.0, 0.0, 0.0, 5.0, 0.0]));
        assert!(!splines(&[0.0, 5.0, 0.0, 0.0, 6.0, 0.0]));
        assert!(!splines(&[0.0, 5.0, 1.0, 0.0, 5.0, 0.0]), "the tangent moves it between equal keys");
    }
}
