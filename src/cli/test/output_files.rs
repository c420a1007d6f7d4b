//! The forms of a result for build servers and pull requests: JUnit XML, Markdown, and annotations.

use std::path::PathBuf;

use clap::Args;

use super::annotations::{code_quality, github_commands};
use super::junit::junit_xml;
use crate::cli::findings::findings_of_suite;
use crate::cli::markdown::{MarkdownSummary, write_summary};
use crate::progress::{escaped_lines, print_raw};
use rayframe::error::Result;
use rayframe::image_file::{OutputKind, check_output, probe_folder, write_single_file};
use rayframe::regression::suite::{Suite, suite_title};
use rayframe::regression::{FailOn, SuiteResult};

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
    /// Checks that all files can be written and replace nothing but such files.
    ///
    /// # Errors
    /// [`Error::CannotCreate`](rayframe::error::Error::CannotCreate).
    pub(super) fn check(&self, overwrites: bool) -> Result<()> {
        let files = [
            (&self.junit, OutputKind::JUnit),
            (&self.summary, OutputKind::Summary),
            (&self.code_quality, OutputKind::CodeQuality),
        ];
        for (file, kind) in files {
            if let Some(file) = file {
                check_output(file, kind, overwrites)?;
                probe_folder(file)?;
            }
        }
        Ok(())
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
