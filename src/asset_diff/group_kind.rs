//! The kinds of items of an asset.

use serde::Serialize;

/// What the items of a group are. The order is that of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum GroupKind {
    /// The file as a whole: one item without a name.
    File,
    /// Extensions that the file declares.
    Extensions,
    /// Sets of root nodes.
    Scenes,
    /// Nodes, by their path of names.
    Nodes,
    /// Meshes.
    Meshes,
    /// Materials, with the default one where a primitive has none.
    Materials,
    /// Textures that materials use.
    Textures,
    /// Material variants.
    Variants,
    /// Animation clips.
    Clips,
    /// Skins.
    Skins,
    /// Cameras.
    Cameras,
    /// Punctual lights.
    Lights,
    /// Image-based lights.
    ImageLights,
}

impl GroupKind {
    /// The title of the group.
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Extensions => "extensions",
            Self::Scenes => "scenes",
            Self::Nodes => "nodes",
            Self::Meshes => "meshes",
            Self::Materials => "materials",
            Self::Textures => "textures",
            Self::Variants => "variants",
            Self::Clips => "clips",
            Self::Skins => "skins",
            Self::Cameras => "cameras",
            Self::Lights => "lights",
            Self::ImageLights => "image-based lights",
        }
    }
}
