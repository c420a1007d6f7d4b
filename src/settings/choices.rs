//! Enums that only settings use.

use glam::Vec3;

use crate::scene::NameOrIndex;

/// Format of previews.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PreviewFormat {
    /// PNG.
    #[default]
    Png,
}

/// The ground below the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum GroundKind {
    /// There is none.
    #[default]
    None,
    /// It catches shadows.
    Shadow,
    /// It catches shadows and shows mirror images.
    Reflection,
}

/// Denoiser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum DenoiserKind {
    /// None.
    #[default]
    None,
    /// Intel's Open Image Denoise.
    Oidn,
}

/// On or off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Switch {
    /// On.
    #[default]
    On,
    /// Off.
    Off,
}

/// Progress output style.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProgressStyle {
    /// Bars on a terminal, plain lines elsewhere.
    #[default]
    Auto,
    /// Bars.
    Bar,
    /// One line per frame.
    Plain,
    /// One JSON object per line, on the standard output.
    Json,
    /// Lines of Open Job Description, on the standard output.
    OpenJd,
    /// No output.
    None,
}

/// Centre of the image.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LookAt {
    /// A point in world space, metres.
    Point(Vec3),
    /// Centre of a node's bounds.
    Node(NameOrIndex),
}

/// Focus of the lens.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FocusRequest {
    /// Whatever the centre of the image shows.
    Center,
    /// Distance along the camera's axis.
    Metres(f32),
    /// A node.
    Node(NameOrIndex),
}
