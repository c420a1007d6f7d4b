//! Merging of the reports of shards: results and images of all machines become one result, without rendering.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::str::FromStr as _;

use serde::Deserialize;

use super::names::reference_path;
use super::orphans::{Orphans, add_reference};
use super::rendered_images::{check_names, image_path, reference_hash, remove_rendered, write_list};
use super::retimed::explain_unpaired;
use super::test_shot::{FrameId, TestedFrame, keep_rendered, test_frame};
use super::told_content::ToldContent;
use super::{RunOptions, Shard, Suite, discover};
use crate::error::{Error, Result, json_error_text};
use crate::image_file::{OutputKind, check_output};
use crate::regression::comparison::Comparison;
use crate::regression::report_page::ImageBudget;
use crate::regression::result::{FrameResult, FrameStatus, ShotResult, SuiteResult};
use crate::regression::verdict::Verdict;
use crate::regression::{Cause, Limits};
use crate::settings::read_text;

/// The file beside `index.html` that holds what `rayframe test --json` prints.
pub const RESULT_FILE: &str = "result.json";

/// Largest number of seconds of a report, thirty years.
const MAX_SECONDS: f64 = 1e9;

/// What merging needs of [`RESULT_FILE`]: its names are those of `schema/test.schema.json`.
#[derive(Debug, Deserialize)]
struct ShardReport {
    shard: Option<String>,
    seconds: f64,
    shots: Vec<ReportedShot>,
    dangling: Vec<String>,
    /// Shots that the shard left out, as none of their files changed.
    not_tested: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct ReportedShot {
    name: String,
    seconds: f64,
    cached: bool,
    warnings: Vec<String>,
    #[serde(rename = "pictures")]
    frames: Vec<ReportedFrame>,
}

#[derive(Debug, Deserialize)]
struct ReportedFrame {
    name: String,
    frame: Option<i64>,
    status: FrameStatus,
    verdict: Verdict,
    messages: Vec<String>,
    hash: Option<String>,
    reference: Option<String>,
    cause: Option<ReportedCause>,
}

/// What of a likely cause the images alone do not tell.
#[derive(Debug, Deserialize)]
struct ReportedCause {
    #[serde(default)]
    materials: Vec<String>,
}

/// The result of a suite from the report folders of all its shards, which keep the images that changed or failed. They are compared
/// again, which gives the same measures.
///
/// # Errors
/// [`Error::Missing`] for a folder without a report, [`Error::Usage`] where a shard is missing or given twice, [`Error::Invalid`] for a
/// damaged report, and [`Error::Different`] where references changed since.
pub fn merge_reports(suite: &Suite, folders: &[PathBuf], options: &RunOptions) -> Result<SuiteResult> {
    let reports: Vec<ShardReport> =
        folders.iter().map(|folder| read_report(folder)).collect::<Result<_>>()?;
    check_shards(folders, &reports)?;
    if let Some(target) = &options.images {
        if let Some(folder) = folders.iter().find(|folder| same_folder(folder, target)) {
            let path = folder.display();
            return Err(Error::usage(format!(
                "{path}: is to be merged and cannot hold the merged report; name another folder with --report"
            )));
        }
        remove_rendered(target);
    }
    let shots = discover(suite)?;
    let paths: BTreeMap<_, _> = shots.iter().map(|shot| (shot.name.clone(), shot.path.clone())).collect();
    check_shots(&paths, &reports)?;
    let merging = Merging {
        suite,
        paths,
        images: options.images.as_deref(),
        image_budget: ImageBudget::new(),
        reports_passing: options.reports_passing,
    };
    let mut result = SuiteResult::default();
    let mut orphaned = BTreeSet::new();
    for (folder, report) in folders.iter().zip(reports) {
        result.seconds = result.seconds.max(report.seconds);
        orphaned.extend(report.dangling);
        result.not_tested.extend(report.not_tested);
        for shot in report.shots {
            result.shots.push(merging.shot(folder, shot)?);
        }
    }
    result.shots.sort_by(|a, b| a.name.cmp(&b.name));
    result.not_tested.sort_unstable();
    let mut orphans = Orphans::new(suite, &shots);
    result.orphaned = orphaned.iter().map(|name| orphans.failure(name)).collect();
    explain_unpaired(suite, &mut result.shots, &mut result.orphaned);
    if let Some(folder) = options.images.as_ref().filter(|_| result.counts().worst() != Verdict::Identical) {
        result.not_kept.extend(write_list(&result, folder).err());
    }
    Ok(result)
}

fn read_report(folder: &Path) -> Result<ShardReport> {
    let file = folder.join(RESULT_FILE);
    let text = read_text(&file)?;
    let report: ShardReport = serde_json::from_str(&text).map_err(|error| {
        Error::invalid(&file, "", format!("no report of this version: {}", json_error_text(&error)))
    })?;
    let frames = report.shots.iter().flat_map(|shot| &shot.frames);
    check_names(&file, "/shots", frames.map(|frame| &frame.name))?;
    check_names(&file, "/dangling", report.dangling.iter())?;
    let mut seconds = report.shots.iter().map(|shot| shot.seconds).chain([report.seconds]);
    if seconds.any(|seconds| !(0.0..=MAX_SECONDS).contains(&seconds)) {
        return Err(Error::invalid(&file, "", "a time is no number of seconds"));
    }
    Ok(report)
}

/// Checks that [`RESULT_FILE`] of a report folder is missing, or one that an earlier run wrote.
///
/// # Errors
/// [`Error::CannotCreate`] where it is another program's file.
pub fn check_result_place(folder: &Path, overwrites: bool) -> Result<()> {
    check_output(&folder.join(RESULT_FILE), OutputKind::SuiteResult, overwrites)
}

/// Refuses reports that are not all parts of one suite, once each.
fn check_shards(folders: &[PathBuf], reports: &[ShardReport]) -> Result<()> {
    let mut parts = BTreeSet::new();
    let mut count = None;
    for (folder, report) in folders.iter().zip(reports) {
        let refused = |why: String| Err(Error::usage(format!("{}: {why}", folder.display())));
        let Some(shard) = report.shard.as_deref().and_then(|shard| Shard::from_str(shard).ok()) else {
            return refused("the report is not that of a shard; test with --shard I/N".to_owned());
        };
        let shards = *count.get_or_insert(shard.count);
        if shards != shard.count {
            return refused(format!(
                "the report is that of shard {shard}, and others are of {shards} shards"
            ));
        }
        if !parts.insert(shard.index) {
            return refused(format!("the report of shard {shard} is given twice"));
        }
    }
    let count = count.unwrap_or(0);
    match (1..=count).find(|index| !parts.contains(index)) {
        Some(index) => Err(Error::usage(format!("the report of shard {index}/{count} is missing"))),
        None => Ok(()),
    }
}

/// Refuses reports that do not have each shot of the suite once, tested or left out as unchanged, such as those of filtered runs and of other
/// revisions.
fn check_shots<'a>(paths: &BTreeMap<String, PathBuf>, reports: &'a [ShardReport]) -> Result<()> {
    let mut names = BTreeSet::new();
    let of_report =
        |report: &'a ShardReport| report.shots.iter().map(|shot| &shot.name).chain(&report.not_tested);
    for name in reports.iter().flat_map(of_report) {
        if !paths.contains_key(name) || !names.insert(name) {
            let name = name.escape_debug();
            return Err(Error::usage(format!(
                "the reports have the shot {name} that the suite has not, or have it twice; test again"
            )));
        }
    }
    match paths.keys().find(|name| !names.contains(name)) {
        Some(name) => {
            let name = name.escape_debug();
            Err(Error::usage(format!(
                "no report has the shot {name}; test all shards of one revision without a name"
            )))
        }
        None => Ok(()),
    }
}

fn same_folder(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

struct Merging<'a> {
    suite: &'a Suite,
    /// Shot files and scenes by name.
    paths: BTreeMap<String, PathBuf>,
    images: Option<&'a Path>,
    image_budget: ImageBudget,
    reports_passing: bool,
}

impl Merging<'_> {
    fn shot(&self, folder: &Path, shot: ReportedShot) -> Result<ShotResult> {
        let path = self.paths.get(&shot.name).cloned().unwrap_or_default();
        let limits = self.suite.limits_of(&path).unwrap_or(self.suite.limits);
        let mut not_kept = Vec::new();
        let mut frames = Vec::new();
        let mut told = ToldContent::default();
        for frame in shot.frames {
            let mut tested = self.frame(folder, frame, &limits.limits, &mut told)?;
            if self.reports_passing && tested.result.verdict() == Verdict::Identical {
                add_reference(self.suite, &mut tested.result);
            }
            self.image_budget.admit(&mut tested.result);
            if let Some(target) = self.images {
                not_kept.extend(keep_rendered(target, &tested).err());
            }
            frames.push(tested.result);
        }
        Ok(ShotResult {
            name: shot.name,
            path,
            preset: limits.name(),
            limits: limits.limits,
            frames,
            warnings: shot.warnings,
            not_kept,
            seconds: shot.seconds,
            is_cached: shot.cached,
            is_unopened: false,
        })
    }

    fn frame(
        &self,
        folder: &Path,
        frame: ReportedFrame,
        limits: &Limits,
        told: &mut ToldContent,
    ) -> Result<TestedFrame> {
        let ReportedFrame { name, frame, status, verdict, messages, hash, reference, cause } = frame;
        let file = image_path(folder, &name);
        let reported = FrameResult {
            messages,
            comparison: (verdict == Verdict::Identical).then(Comparison::identical),
            actual_hash: hash,
            value_hash: None,
            reference_hash: reference,
            ..FrameResult::new(name.clone(), frame, status)
        };
        if reference_hash(self.suite, &reported.name) != reported.reference_hash
            && status != FrameStatus::Broken
        {
            let reference = reference_path(&self.suite.references, &reported.name);
            let message =
                format!("{}: changed since {} was tested; test again", reference.display(), folder.display());
            return Err(Error::Different { message });
        }
        // Broken frames have no image.
        if verdict == Verdict::Identical || (status == FrameStatus::Broken && !file.exists()) {
            told.keep(&name, &reported.messages);
            return Ok(TestedFrame { result: reported, file: None, was_rendered: true });
        }
        let id = FrameId { name, frame, scene: None };
        let mut tested = test_frame(self.suite, limits, id, &file, told)?;
        if (tested.result.status, &tested.result.actual_hash) != (status, &reported.actual_hash) {
            let message = format!("{}: is not the image that was tested; test again", file.display());
            return Err(Error::Different { message });
        }
        let found = tested.result.comparison.as_mut().and_then(|comparison| comparison.cause.as_mut());
        if let (Some(Cause::Material { materials, .. }), Some(cause)) = (found, cause) {
            *materials = cause.materials;
        }
        Ok(tested)
    }
}
