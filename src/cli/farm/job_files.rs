//! Writing of job files. `job.json` lists them with their hashes: by it a later run knows which files it may replace.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use sha2::{Digest as _, Sha256};

use crate::progress::pretty_json;
use rayframe::error::{Error, Result};
use rayframe::image_file::{JOB_LIST, OutputKind, check_output, job_files, write_single_file};
use rayframe::sequence::{hex, sha256_of_file};

use super::job_plan::JobPlan;

/// Raised when a field changes its meaning.
const SCHEMA: u32 = 1;

/// A file of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct JobFile {
    /// Name in the folder of the job.
    pub(super) name: &'static str,
    /// Content.
    pub(super) content: String,
}

/// `job.json`.
#[derive(Debug, Serialize)]
struct JobList<'a> {
    software: &'a str,
    schema: u32,
    engine: &'a str,
    /// SHA-256 of each job file; of what it was, too, while files are being written.
    job_files: BTreeMap<String, Vec<String>>,
    name: &'a str,
    render_hash: &'a str,
    threads: u16,
    memory_bytes: u64,
    retries: u32,
    tasks: Vec<&'a str>,
    assets: &'a [String],
}

/// Checks that the files may be written: nothing is there, or what an earlier run wrote and nobody has changed since.
///
/// # Errors
/// [`Error::CannotCreate`] with the first file that is in the way.
pub(super) fn check_files(folder: &Path, files: &[JobFile], overwrites: bool) -> Result<()> {
    check_output(&folder.join(JOB_LIST), OutputKind::JobList, overwrites)?;
    if overwrites {
        return Ok(());
    }
    let listed = job_files(folder);
    for file in files {
        let path = folder.join(file.name);
        let Ok(metadata) = path.symlink_metadata() else { continue };
        let is_own = || {
            let hash = sha256_of_file(&path).unwrap_or_default();
            hash == sha256(&file.content)
                || listed.get(file.name).is_some_and(|hashes| hashes.contains(&hash))
        };
        if !metadata.is_file() || metadata.len() > 0 && !is_own() {
            let message = "is there already and is not a job file of this program, or was changed since; \
                           choose another folder, or `overwrite` replaces it";
            return Err(Error::CannotCreate { path, message: message.to_owned() });
        }
    }
    Ok(())
}

/// Writes the files of a job.
///
/// # Errors
/// Those of writing files.
pub(super) fn write_files(folder: &Path, engine: &str, plan: &JobPlan, files: &[JobFile]) -> Result<()> {
    // A run that ends in between leaves files of which the list knows both states. Files of other engines stay listed.
    let mut both = job_files(folder);
    let mut new = both.clone();
    for file in files {
        let hash = sha256(&file.content);
        both.entry(file.name.to_owned()).or_default().push(hash.clone());
        new.insert(file.name.to_owned(), vec![hash]);
    }
    let path = folder.join(JOB_LIST);
    write_single_file(&path, &list(engine, plan, both)?)?;
    for file in files {
        write_single_file(&folder.join(file.name), file.content.as_bytes())?;
    }
    write_single_file(&path, &list(engine, plan, new)?)
}

fn list(engine: &str, plan: &JobPlan, job_files: BTreeMap<String, Vec<String>>) -> Result<Vec<u8>> {
    pretty_json(&JobList {
        software: &plan.version,
        schema: SCHEMA,
        engine,
        job_files,
        name: &plan.name,
        render_hash: &plan.pin.render_hash,
        threads: plan.resources.threads,
        memory_bytes: plan.resources.memory_bytes,
        retries: plan.retries,
        tasks: plan.tasks.iter().map(|task| &*task.name).collect(),
        assets: &plan.assets,
    })
}

/// The digits of the SHA-256 of a text.
pub(super) fn sha256(text: &str) -> String {
    hex(&Sha256::digest(text.as_bytes()))
}
