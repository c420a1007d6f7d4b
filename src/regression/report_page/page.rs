//! The contents of a report page, as plain data.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::regression::VerdictCounts;
use crate::regression::result::ShotResult;

/// The contents of a report page.
#[derive(Debug, Default)]
pub struct ReportPage {
    /// What was compared: the suite's folder, or the two sides of a comparison.
    pub title: String,
    /// The command that made the page, quoted for a shell.
    pub command: String,
    /// Counts of each folder of shots.
    pub folders: Vec<FolderSummary>,
    /// Shots with a failure, sorted by name, then those that only changed within the limits, and last identical ones whose images are shown.
    pub shots: Vec<ShotResult>,
    /// Commands for each shot, by the shot's name.
    pub shot_commands: BTreeMap<String, Vec<NamedCommand>>,
    /// Commands that show a frame whose images are omitted, by the frame's name.
    pub frame_commands: BTreeMap<String, FrameCommands>,
    /// What changed between the two versions of an asset that the images show; `None` for other images. A page of an asset opens
    /// with its changes and lists the images that pass, too.
    pub asset: Option<AssetChanges>,
    /// The command that accepts the exported `approvals.json`, quoted for a shell. Empty where nothing can be approved; the page
    /// then has no tick boxes.
    pub accept_command: String,
}

/// A command and its purpose: `("Test again", "rayframe test …")`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NamedCommand(pub String, pub String);

/// Commands that show one frame of a shot, quoted for a shell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameCommands {
    /// Makes a page of this frame alone. For frames whose images do not fit beside those of other frames.
    pub alone: Option<String>,
    /// Writes the heat map as an image file. For frames that are too large for any page.
    pub heat_map: Option<String>,
}

/// Counts of a folder of shots.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FolderSummary {
    /// The folder below the suite's; empty for the suite's own.
    pub name: String,
    /// Numbers of frames by verdict.
    #[serde(flatten)]
    pub counts: VerdictCounts,
    /// Seconds spent rendering and comparing.
    pub seconds: f64,
}

/// The changes of an asset.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct AssetChanges {
    /// Content that is lost, one line each, which fails the comparison.
    pub losses: Vec<String>,
    /// All changes by kind of thing.
    pub groups: Vec<ChangeGroup>,
}

/// Changes of one kind of thing, such as materials.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ChangeGroup {
    /// The title.
    pub title: &'static str,
    /// The changes, those of one item together.
    pub rows: Vec<ChangeRow>,
}

/// A change of one property, or of an item as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ChangeRow {
    /// `-` removed, `+` added, `~` changed.
    pub mark: char,
    /// The item; empty where it is that of the row above.
    pub name: String,
    /// The property; empty for an item that is removed or added.
    pub property: String,
    /// The values before and after.
    pub values: String,
}
