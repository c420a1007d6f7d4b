//! Animation clips: keyframes and their targets. [`crate::frame`] evaluates them.

use std::collections::BTreeSet;

use super::{
    CameraIndex, CameraProperty, ImageLightIndex, ImageLightProperty, LightIndex, LightProperty,
    MaterialIndex, MaterialProperty, MeshIndex, NodeIndex,
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
