//! The forms of a result for build servers and pull requests: JUnit XML, Markdown, and annotations.

use std::path::{Path, PathBuf};

use clap::Args;

use super::annotations::{code_quality, github_commands};
use super::junit::junit_xml;
use crate::cli::findings::findings_of_suite;
use crate::cli::markdown::{MarkdownSummary, write_summary};
use crate::progress::{escaped_lines, print_raw};
use rayframe::error::{Error, Result};
use rayframe::image_file::{OutputKind, check_output, is_output, probe_folder, write_single_file};
use rayframe::regression::suite::{Suite, input_files, is_report_image, report_files, suite_title};
use rayframe::regression::{FailOn, SuiteResult, all_files_below};
use rayframe::sequence::{UsedNames, canonical};

/// What is said of a name that another output has.
const OTHER: &str = "will hold something else";

/// Options that write a result for build servers and pull requests.
#[derive(Clone, Debug, Args)]
#[group(id = "files", multiple = true)]
pub(super) struct OutputFiles {
    /// Write the result as JUnit XML, for build servers
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write a summary in Markdown for pull requests, with thumbnails beside it in the folder FILE.md.files
    #[arg(long, value_name = "FILE.md")]
    summary: Option<PathBuf>,
    /// Write a report of GitLab's Code Quality
    #[arg(long, value_name = "FILE.json")]
    code_quality: Option<PathBuf>,
    /// Print annotations of GitHub Actions to the standard error stream
    #[arg(long)]
    github_annotations: bool,
}

impl OutputFiles {
    /// The named files, each with its option.
    fn named(&self) -> Vec<(&'static str, &Path, OutputKind)> {
        let files = [
            ("--junit", &self.junit, OutputKind::JUnit),
            ("--summary", &self.summary, OutputKind::Summary),
            ("--code-quality", &self.code_quality, OutputKind::CodeQuality),
        ];
        files.into_iter().filter_map(|(option, file, kind)| Some((option, file.as_deref()?, kind))).collect()
    }

    /// Checks that all files can be written and replace nothing but such files, and no input of the suite or of `merged` reports even where
    /// `overwrites` permits other files. `report` is the folder of the report.
    ///
    /// # Errors
    /// [`Error::Usage`] for a name of an input, of a file of the report or of two files, and [`Error::CannotCreate`].
    pub(super) fn check(
        &self,
        suite: &Suite,
        (report, merged): (&Path, &[PathBuf]),
        overwrites: bool,
    ) -> Result<()> {
        let files = self.named();
        if files.is_empty() {
            return Ok(());
        }
        let mut names = UsedNames::new(&self.replaceable_inputs(suite, (report, merged))?);
        for file in report_files(report) {
            // What is wrong with these is told by their own checks.
            let _ = names.add(&file, OTHER, |_| None);
        }
        let image = |file: &Path| is_report_image(report, file).then_some(OTHER);
        for (option, file, _) in &files {
            names.add(file, OTHER, image).map_err(|why| Error::usage(format!("{option}: {why}")))?;
        }
        for (_, file, kind) in files {
            check_output(file, kind, overwrites)?;
            probe_folder(file)?;
        }
        Ok(())
    }

    /// The inputs of the run; none where no file would replace one. Scenes are opened to know what they load.
    fn replaceable_inputs(
        &self,
        suite: &Suite,
        (report, merged): (&Path, &[PathBuf]),
    ) -> Result<Vec<PathBuf>> {
        let there = self.named().into_iter().filter(|(_, file, _)| file.symlink_metadata().is_ok());
        // Those of earlier runs may be in the folder of references.
        let (own, others): (Vec<_>, Vec<_>) = there.partition(|(_, file, kind)| is_output(file, *kind));
        if others.is_empty() {
            return Ok(Vec::new());
        }
        let mut inputs = input_files(suite, report)?;
        inputs.extend(merged.iter().flat_map(|folder| all_files_below(folder).unwrap_or_default()));
        let own: Vec<_> = own.into_iter().map(|(_, file, _)| canonical(file)).collect();
        inputs.retain(|input| !own.contains(&canonical(input)));
        Ok(inputs)
    }

    /// Writes the files, and prints annotations. A file that cannot be written does not keep the others from it.
    ///
    /// # Errors
    /// The first one of writing files.
    pub(super) fn write(&self, suite: &Suite, result: &SuiteResult, fail_on: FailOn) -> Result<()> {
        let findings = findings_of_suite(suite, result, fail_on);
        let junit = |file: &PathBuf| write_single_file(file, junit_xml(result, fail_on)?.as_bytes());
        let summary = |file: &PathBuf| {
            let (title, counts) = (&*suite_title(suite), result.counts());
            write_summary(file, MarkdownSummary { title, counts, losses: &[], findings: &findings })
        };
        let quality = |file: &PathBuf| write_single_file(file, code_quality(&findings)?.as_bytes());
        let written = [
            self.junit.as_ref().map(junit),
            self.summary.as_ref().map(summary),
            self.code_quality.as_ref().map(quality),
        ];
        if self.github_annotations {
            print_raw(&escaped_lines(&github_commands(&findings)));
        }
        written.into_iter().flatten().collect()
    }
}
