//! Requested scene, clips, camera and variant of a file, by name or index.

/// Reference to a named item of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NameOrIndex {
    /// By name.
    Name(String),
    /// By index in the file, from 0.
    Index(usize),
}

impl NameOrIndex {
    /// `#2` is the third, anything else a name.
    pub fn parse(text: &str) -> Self {
        match text.strip_prefix('#').and_then(|digits| digits.parse().ok()) {
            Some(index) => Self::Index(index),
            None => Self::Name(text.to_owned()),
        }
    }
}

/// Requested animation clips.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ClipSelection {
    /// All clips whose targets no earlier clip animates.
    #[default]
    All,
    /// No clip: the scene is static.
    None,
    /// One clip.
    One(NameOrIndex),
    /// Several clips that play together: names and indices, separated by commas. A clip that has the whole text as its
    /// name is the only one.
    Together(String),
    /// Each clip alone, in a sequence of its own. [`super::Selection::resolve_each`] resolves it.
    Each,
}

/// Requested part of a file, before it is resolved.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SelectionRequest {
    /// Set of root nodes; `None` is the default of the file.
    pub scene: Option<NameOrIndex>,
    /// Animation clips.
    pub clips: ClipSelection,
    /// Camera; `None` is the first camera of the selected scene, or an automatic one.
    pub camera: Option<CameraRequest>,
    /// Material variant; `None` keeps the primitives' own materials.
    pub variant: Option<VariantRequest>,
}

/// Requested camera.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CameraRequest {
    /// Automatic camera that frames the whole scene.
    Auto,
    /// A camera of the file, by its name, its node's name or its index.
    Camera(NameOrIndex),
    /// Each camera of the selected scene, in a sequence of its own. [`super::Selection::resolve_each`] resolves it.
    Each,
}

/// Requested material variant.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VariantRequest {
    /// A variant of the file, by its name or index.
    Variant(NameOrIndex),
    /// No variant, as without a request. In a file with a variant of this name, that one.
    None,
    /// Each variant of the file, in a sequence of its own. [`super::Selection::resolve_each`] resolves it.
    Each,
}
