//! What a run found.

use std::path::PathBuf;

use crate::error::Error;

use super::super::{FrameStatus, Limits, ReportedFrame};

/// One shot.
#[derive(Debug)]
pub struct ShotResult {
    /// Its name.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
    /// The preset's name, with a word where limits were changed.
    pub preset: String,
    /// What passes.
    pub limits: Limits,
    /// Its pictures in the order of frames; one broken one where the shot could not be opened.
    pub pictures: Vec<ReportedFrame>,
    /// What the scene asks for and is not honoured.
    pub warnings: Vec<String>,
    /// Why pictures could not be kept beside the references.
    pub not_kept: Vec<Error>,
    /// Rendering and comparing.
    pub seconds: f64,
}

/// All that was tested.
#[derive(Debug, Default)]
pub struct SuiteResult {
    /// In the order of their names.
    pub shots: Vec<ShotResult>,
    /// References that no shot asks for.
    pub orphaned: Vec<ReportedFrame>,
    /// Why what waits could not be changed after the last shot.
    pub not_kept: Vec<Error>,
    /// Wall-clock seconds.
    pub seconds: f64,
}

impl ShotResult {
    /// Whether every picture is as its reference.
    pub fn passes(&self) -> bool {
        self.pictures.iter().all(is_passed)
    }

    /// What is wrong, one line each, with the name of the picture.
    pub fn failures(&self) -> Vec<String> {
        failures_of(self.pictures.iter())
    }

    /// The folder of the shot, empty for the suite's own.
    pub fn folder(&self) -> &str {
        folder_of(&self.name)
    }
}

impl SuiteResult {
    /// Whether every picture is as its reference, and every reference has a picture.
    pub fn passes(&self) -> bool {
        self.orphaned.is_empty() && self.shots.iter().all(ShotResult::passes)
    }

    /// Why pictures, or that references are over, could not be kept to be accepted.
    pub fn not_kept(&self) -> impl Iterator<Item = &Error> {
        self.shots.iter().flat_map(|shot| &shot.not_kept).chain(&self.not_kept)
    }

    /// All pictures, and the references without one.
    pub fn pictures(&self) -> impl Iterator<Item = &ReportedFrame> {
        self.shots.iter().flat_map(|shot| &shot.pictures).chain(&self.orphaned)
    }

    /// What is wrong, one line each, with the name of the picture.
    pub fn failures(&self) -> Vec<String> {
        failures_of(self.pictures())
    }

    /// How many pictures pass, and how many do not.
    pub fn counts(&self) -> (usize, usize) {
        let passed = self.pictures().filter(|picture| is_passed(picture)).count();
        (passed, self.pictures().count() - passed)
    }
}

fn failures_of<'a>(pictures: impl Iterator<Item = &'a ReportedFrame>) -> Vec<String> {
    let lines = pictures
        .flat_map(|picture| picture.messages.iter().map(|message| format!("{}: {message}", picture.name)));
    lines.collect()
}

pub(super) fn is_passed(picture: &ReportedFrame) -> bool {
    picture.status == FrameStatus::Passed
}

/// The folder of a name, empty where there is none.
pub(super) fn folder_of(name: &str) -> &str {
    name.rsplit_once('/').map_or("", |(folder, _)| folder)
}
