//! What no shot of a run asked for: references without a picture, and what earlier runs kept.

use std::collections::BTreeSet;

use super::super::{EncodedPicture, FrameStatus, LayeredPicture, ReportedFrame};
use super::names::{
    ReferenceFile, pending_path, reference_files, reference_path, removal_path, shots_of_picture,
};
use super::pending::remove_file;
use super::run::fitting;
use super::test_shot::broken;
use super::{RunOptions, ShotResult, Suite, SuiteShot};
use crate::error::Result;

/// What is left after all shots: gives the references that no shot asks for, and removes what earlier runs left pending.
///
/// `shots` are all of the suite, `results` those that were tested.
///
/// # Errors
/// When the references cannot be read, or what waits beside them cannot be written.
pub fn finish(
    suite: &Suite,
    shots: &[SuiteShot],
    results: &[ShotResult],
    options: &RunOptions,
) -> Result<Vec<ReportedFrame>> {
    let asked: BTreeSet<&str> =
        results.iter().flat_map(|shot| &shot.pictures).map(|picture| picture.name.as_str()).collect();
    // A shot that was not tested, or could not be opened, may ask for any frame.
    let is_known =
        |shot: &SuiteShot| results.iter().any(|result| result.name == shot.name && !is_unopened(result));
    let unknown: BTreeSet<&str> =
        shots.iter().filter(|shot| !is_known(shot)).map(|shot| shot.name.as_str()).collect();
    let is_settled = |name: &str| !shots_of_picture(name).any(|shot| unknown.contains(shot));
    let fits = fitting(&options.filter, shots.iter().map(|shot| shot.name.as_str()));
    let is_meant = |name: &str| shots_of_picture(name).any(&fits);
    let files = reference_files(&suite.references)?;
    let mut dangling = Vec::new();
    for file in &files {
        match file {
            ReferenceFile::Reference(name) => {
                if !asked.contains(name.as_str()) && is_settled(name) && is_meant(name) {
                    dangling.push(without_shot(suite, name));
                    if options.keeps_pending {
                        keep_removal(suite, name)?;
                    }
                }
            }
            ReferenceFile::Pending(name) => {
                let is_stale = !asked.contains(name.as_str()) && is_settled(name) && is_meant(name);
                if options.keeps_pending && is_stale {
                    remove_file(&pending_path(&suite.references, name))?;
                }
            }
            ReferenceFile::Removal(name) => {
                let is_stale =
                    asked.contains(name.as_str()) || !files.contains(&ReferenceFile::Reference(name.clone()));
                if options.keeps_pending && is_stale {
                    remove_file(&removal_path(&suite.references, name))?;
                }
            }
        }
    }
    Ok(dangling)
}

fn is_unopened(result: &ShotResult) -> bool {
    result.pictures.iter().any(|picture| picture.status == FrameStatus::Broken && picture.frame.is_none())
}

fn without_shot(suite: &Suite, name: &str) -> ReportedFrame {
    let mut reported = broken(name.to_owned(), None, "no shot asks for this reference".to_owned());
    reported.status = FrameStatus::Dangling;
    let expected = LayeredPicture::read(&reference_path(&suite.references, name));
    reported.expected = expected.ok().as_ref().and_then(EncodedPicture::new);
    reported
}

fn keep_removal(suite: &Suite, name: &str) -> Result<()> {
    crate::image_file::write_atomically(&removal_path(&suite.references, name), b"")
}
