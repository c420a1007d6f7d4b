//! Which of a file's scenes, clips and cameras are shown.

use super::{AnimationIndex, NodeIndex, Scene};
use crate::error::{Error, Warning};

/// One of several things in a file, as a user names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// By name.
    Name(String),
    /// By position in the file, from 0.
    Index(usize),
}

/// Which clips play, as a user asks for them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum ClipChoice {
    /// All whose targets no earlier clip holds.
    #[default]
    All,
    /// None: the scene stands still.
    None,
    /// One.
    One(Choice),
}

/// What a user asks to see.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SelectionRequest {
    /// Which set of roots; `None` is the file's default.
    pub scene: Option<Choice>,
    /// Which clips.
    pub clips: ClipChoice,
    /// Which camera; `None` is the first that the scene places, else automatic framing.
    pub camera: Option<CameraRequest>,
}

/// Which camera a user asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraRequest {
    /// Frame the whole scene.
    Auto,
    /// One of the file's.
    Placed(Choice),
}

/// Which camera looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraChoice {
    /// One that frames the whole scene over the selected clips.
    Auto,
    /// The camera of this node.
    Node(NodeIndex),
    /// One that stands still, such as an automatic one that was resolved.
    Fixed {
        /// Rotation and translation; columns are right, up, backward, position.
        world_from_camera: Mat4,
        /// Its projection.
        projection: Projection,
    },
}

/// What is shown, resolved against one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Roots that are drawn.
    pub roots: Vec<NodeIndex>,
    /// Clips that play together; their targets are disjoint.
    pub clips: Vec<AnimationIndex>,
    /// The camera.
    pub camera: CameraChoice,
}

impl Selection {
    /// Finds what `request` names in `scene`.
    pub fn resolve(request: &SelectionRequest, scene: &Scene) -> Result<(Self, Vec<Warning>), Error> {
        let _ = request;
        let roots = scene.scenes.first().map(|s| s.roots.clone()).unwrap_or_default();
        Ok((
            Self {
                roots,
                clips: Vec::new(),
                camera: CameraChoice::Auto,
            },
            Vec::new(),
        ))
    }
}
