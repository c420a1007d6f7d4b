//! Animation clips: keyframes and what they move. Evaluation is in [`crate::frame`].

use std::collections::BTreeSet;

use super::{
    CameraIndex, CameraProperty, ImageLightIndex, ImageLightProperty, LightIndex, LightProperty,
    MaterialIndex, MaterialProperty, MeshIndex, NodeIndex,
};

/// A clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// One a target.
    pub channels: Vec<Channel>,
}

impl Animation {
    /// Time of the last keyframe, seconds.
    pub fn duration_seconds(&self) -> f32 {
        self.channels
            .iter()
            .filter_map(|channel| channel.keyframes.times_seconds.last())
            .fold(0.0, |a, &b| if b > a { b } else { a })
    }
}

/// Keyframes and what they move.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// What is moved.
    pub target: AnimationTarget,
    /// How.
    pub keyframes: Keyframes,
}

/// What a channel moves. No two channels of one clip have the same target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AnimationTarget {
    /// Translation of a node: 3 components.
    Translation(NodeIndex),
    /// Rotation of a node: 4 components, a quaternion x y z w.
    Rotation(NodeIndex),
    /// Scale of a node: 3 components.
    Scale(NodeIndex),
    /// Morph weights of a node: one component a morph target.
    Weights(NodeIndex),
    /// Morph weights of a mesh, which those of nodes replace: one component a morph target.
    MeshWeights(MeshIndex),
    /// One of the morph weights of a node: 1 component.
    Weight(NodeIndex, u32),
    /// One of the morph weights of a mesh: 1 component.
    MeshWeight(MeshIndex, u32),
    /// Whether a node and all below it are shown: 0 hides.
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
    /// Whether one of `held` moves this, too, or part of it.
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

/// Values over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyframes {
    /// Strictly increasing, at least one.
    pub times_seconds: Vec<f32>,
    /// `width` values a key; with cubic splines `3 · width`: in-tangent, value, out-tangent.
    pub values: Vec<f32>,
    /// Components of one value.
    pub width: usize,
    /// How values between keys are found.
    pub interpolation: Interpolation,
}

/// How values between keyframes are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The last key holds.
    Step,
    /// Straight lines; rotations follow the shorter arc.
    Linear,
    /// Hermite splines with stored tangents.
    CubicSpline,
}
