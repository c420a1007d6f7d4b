//! The report page and the summary of a comparison, which show the same images.

use std::path::{Path, PathBuf};

use super::args::{DiffArgs, shown};
use crate::cli::findings::findings;
use crate::cli::markdown::{MarkdownSummary, write_summary};
use rayframe::error::{Error, Result};
use rayframe::image_file::{OutputKind, check_output, probe_folder};
use rayframe::regression::{FailOn, FrameResult, ReportPage, check_report_place, write_report};
use rayframe::sequence::UsedNames;

/// The name of the report page in its folder.
const PAGE: &str = "index.html";

/// The files that are asked for.
#[derive(Clone, Debug)]
pub(super) struct ResultFiles {
    page: Option<PathBuf>,
    summary: Option<PathBuf>,
    fail_on: FailOn,
}

impl ResultFiles {
    /// The files that `args` name, after a check that they can be written. `None` where it names none.
    ///
    /// # Errors
    /// [`Error::Usage`] for an empty name, and [`Error::CannotCreate`].
    pub(super) fn new(args: &DiffArgs) -> Result<Option<Self>> {
        let page = args.report.as_deref().map(|folder| report_file(folder, args.overwrite)).transpose()?;
        if let Some(file) = &args.summary {
            check_output(file, OutputKind::Summary, args.overwrite)?;
            probe_folder(file)?;
        }
        let files = Self { page, summary: args.summary.clone(), fail_on: args.fail_on.value() };
        Ok(Some(files).filter(|files| files.page.is_some() || files.summary.is_some()))
    }

    /// Writes the page, and a summary of its images.
    ///
    /// # Errors
    /// Those of writing files.
    pub(super) fn write(&self, page: &ReportPage) -> Result<()> {
        if let Some(file) = &self.summary {
            let frames: Vec<(&FrameResult, PathBuf)> = page
                .shots
                .iter()
                .flat_map(|shot| shot.frames.iter().map(|frame| (frame, shot.path.clone())))
                .collect();
            let findings = findings(frames.into_iter(), self.fail_on);
            let counts = page.folders.first().map(|folder| folder.counts).unwrap_or_default();
            let losses = page.asset.as_ref().map_or(&[][..], |asset| &asset.losses);
            write_summary(file, MarkdownSummary { title: &page.title, counts, losses, findings: &findings })?;
        }
        match &self.page {
            Some(file) => write_report(page, file),
            None => Ok(()),
        }
    }
}

/// The file of a page in `folder`, after a check that it can be written.
fn report_file(folder: &Path, overwrites: bool) -> Result<PathBuf> {
    if folder.as_os_str().is_empty() {
        return Err(Error::usage("--report: name a folder"));
    }
    let path = folder.join(PAGE);
    check_report_place(&path, overwrites)?;
    Ok(path)
}

/// Refuses to write a file twice, or to replace one of `inputs`, even where `--overwrite` is given. `maps` are other files, each with its
/// option.
///
/// # Errors
/// [`Error::Usage`] with the option.
pub(super) fn check_names(
    args: &DiffArgs,
    inputs: &[PathBuf],
    maps: &[(&'static str, Vec<PathBuf>)],
) -> Result<()> {
    let mut names = UsedNames::new(inputs);
    let page = args.report.iter().map(|folder| ("--report", folder.join(PAGE)));
    let summary = args.summary.iter().map(|file| ("--summary", file.clone()));
    let maps = maps.iter().flat_map(|(option, files)| files.iter().map(|file| (*option, file.clone())));
    for (option, file) in page.chain(maps).chain(summary) {
        let added = names.add(&file, "will hold something else", |_| None);
        added.map_err(|why| Error::usage(format!("{option}: {why}")))?;
    }
    Ok(())
}

/// The title of page and summary.
pub(super) fn title(args: &DiffArgs) -> String {
    format!("{} against {}", shown(&args.actual), shown(&args.reference))
}
