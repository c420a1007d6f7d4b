//! The report page of two versions of an asset: the changes of the file, then the images of both.

use std::collections::BTreeMap;

use super::args::{DiffArgs, shown};
use super::page::command;
use super::result_files::{ResultFiles, title};
use rayframe::asset_diff::{AssetDifference, View};
use rayframe::error::Result;
use rayframe::regression::{
    AssetChanges, Comparison, EncodedImage, FolderSummary, FrameResult, FrameStatus, Image, ImageBudget,
    NamedCommand, ReportPage, ShotResult,
};

/// A page under construction.
pub(super) struct AssetPage {
    files: ResultFiles,
    shots: Vec<ShotResult>,
    image_budget: ImageBudget,
}

impl AssetPage {
    /// A page without images.
    pub(super) fn new(files: ResultFiles) -> Self {
        Self { files, shots: Vec::new(), image_budget: ImageBudget::new() }
    }

    /// The result of a frame with both of its images, whether they differ or not.
    pub(super) fn frame(
        &self,
        view: &View,
        frame: i64,
        [actual, expected]: &[Image; 2],
        comparison: Comparison,
    ) -> FrameResult {
        let is_sequence = view.frames.len() > 1;
        let mut result = FrameResult {
            name: if is_sequence { format!("{} frame {frame}", view.name) } else { view.name.clone() },
            frame: is_sequence.then_some(frame),
            status: if comparison.passes() { FrameStatus::Passed } else { FrameStatus::Different },
            messages: if comparison.passes() {
                comparison.largest_measure().into_iter().collect()
            } else {
                comparison.failures()
            },
            comparison: Some(comparison),
            expected: EncodedImage::new(expected),
            actual: EncodedImage::new(actual),
            reference_hash: None,
            actual_hash: None,
            value_hash: None,
        };
        self.image_budget.admit(&mut result);
        result
    }

    /// Adds the frames of a view.
    pub(super) fn push(&mut self, shot: ShotResult) {
        self.shots.push(shot);
    }

    /// Writes page and summary.
    pub(super) fn finish(
        self,
        args: &DiffArgs,
        difference: &AssetDifference,
        losses: Vec<String>,
    ) -> Result<()> {
        let counts = self.shots.iter().flat_map(|shot| &shot.frames).map(FrameResult::verdict).collect();
        let again = |options: &[&str]| command(args, &args.actual, &args.reference, options);
        let folder = args.report.as_deref().map(shown).unwrap_or_default();
        let commands = vec![
            NamedCommand("All measures and all facts as JSON".to_owned(), again(&["--json"])),
            NamedCommand("This page again".to_owned(), again(&["--report", &folder])),
        ];
        let page = ReportPage {
            title: title(args),
            command: again(&["--report", &folder]),
            folders: vec![FolderSummary { counts, ..FolderSummary::default() }],
            shot_commands: self.shots.iter().map(|shot| (shot.name.clone(), commands.clone())).collect(),
            frame_commands: BTreeMap::new(),
            asset: Some(AssetChanges { losses, groups: difference.table() }),
            accept_command: String::new(),
            shots: self.shots,
        };
        self.files.write(&page)
    }
}
