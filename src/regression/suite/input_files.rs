//! The files that a run of a suite reads and those of its report, which no other output may replace.

use std::path::{Path, PathBuf};

use super::covered_jobs::files_of;
use super::merge_reports::RESULT_FILE;
use super::names::{LIST, images_folder, same_file};
use super::{Suite, discover};
use crate::canonical_path::canonical;
use crate::error::Result;
use crate::regression::folder_files::all_files_below;

/// Files that a run of a suite reads: the suite file, shot files, scenes, what they load, and all files in the folder of references.
/// Files in `report` and in the cache are none, wherever these are. Of a shot that cannot be opened, the shot file and the scene count.
///
/// # Errors
/// Those of [`discover`].
pub fn input_files(suite: &Suite, report: &Path) -> Result<Vec<PathBuf>> {
    let mut inputs = vec![suite.file.clone()];
    for shot in discover(suite)? {
        inputs.extend(files_of(suite, &shot).map(|files| files.inputs).unwrap_or_default());
        inputs.extend([shot.path, shot.scene]);
    }
    let results = [report, &suite.report, &suite.cache].map(same_file);
    let root = same_file(&suite.references);
    let results: Vec<_> = results.into_iter().filter(|folder| *folder != root).collect();
    let mut references = all_files_below(&suite.references).unwrap_or_default();
    references.retain(|file| !results.iter().any(|folder| same_file(file).starts_with(folder)));
    inputs.extend(references);
    Ok(inputs)
}

/// The files that a run writes to the folder of its report, besides [images](is_report_image).
pub fn report_files(report: &Path) -> [PathBuf; 3] {
    ["index.html", RESULT_FILE, LIST].map(|name| report.join(name))
}

/// Whether the canonical name `file` may be that of a rendered image in the folder of a report.
pub fn is_report_image(report: &Path, file: &Path) -> bool {
    let images = canonical(&images_folder(report));
    file.starts_with(images) && file.extension().is_some_and(|extension| extension == "exr")
}
