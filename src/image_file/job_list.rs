//! The list of the files of a farm's job, `job.json`: by it the program knows its own files.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::existing_output::{OutputKind, is_output};
use super::regular_file::read_regular_file;

/// Name of the list, in the folder of the job.
pub const JOB_LIST: &str = "job.json";
/// Largest list that is read.
const MAX_BYTES: u64 = 1 << 30;

/// The part that is read.
#[derive(Debug, Default, Deserialize)]
struct JobList {
    job_files: BTreeMap<String, Vec<String>>,
}

/// Names of the job files that `rayframe farm` wrote to `folder`, each with the SHA-256 of all contents that it may have; empty without a list.
pub fn job_files(folder: &Path) -> BTreeMap<String, Vec<String>> {
    let path = folder.join(JOB_LIST);
    if !is_output(&path, OutputKind::JobList) {
        return BTreeMap::new();
    }
    let text = read_regular_file(&path, MAX_BYTES).unwrap_or_default();
    serde_json::from_slice::<JobList>(&text).unwrap_or_default().job_files
}
