//! `rayframe test`: the shots of a suite against their references.

mod init;
mod report;
mod text;

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::suite_options::{ShotFiles, SuiteOption, shown_suite};
use super::{Ending, ending, options, signals};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::image_file::{probe_folder, write_atomically};
use crate::progress::{SuiteProgress, print_output};
use crate::regression::suite::{self, RunOptions, Suite, SuiteResult};
use crate::regression::write_report;

/// Options of `rayframe test`.
#[derive(Clone, Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is one flag of the command line")]
pub(super) struct TestArgs {
    /// Only the shot of this name, or all whose names contain it
    #[arg(default_value = "", hide_default_value = true)]
    filter: String,
    #[command(flatten)]
    suite: SuiteOption,
    /// Make a suite of the folder, the current one unless --suite names another
    #[arg(long, conflicts_with_all = ["filter", "list", "json", "junit", "report"])]
    init: bool,
    /// Print the names of the shots and do nothing
    #[arg(long, conflicts_with_all = ["json", "junit", "report"])]
    list: bool,
    /// Print what was found as JSON
    #[arg(long)]
    json: bool,
    /// Write what was found as JUnit XML, which build servers show
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Where the report goes, instead of the suite's own place
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Shots rendered at once [default: as many as there are cores]
    #[arg(short, long, value_name = "N", value_parser = options::count)]
    threads: Option<u32>,
    /// Print failures alone
    #[arg(short, long)]
    quiet: bool,
}

/// Tests, prints, and ends with 0 when everything is as its reference, with 1 when anything is not.
pub(super) fn run(args: &TestArgs) -> Ending {
    let cancel = CancelFlag::new();
    let caught = match signals::watch(&cancel) {
        Ok(caught) => caught,
        Err(error) => {
            let message = format!("signals cannot be watched: {error}");
            return ending(Err(Error::Internal { message }));
        }
    };
    match (test(args, &cancel), caught.number()) {
        (Err(Error::Interrupted(_)), Some(signal)) => Ending::Signal(signal),
        (Err(error), _) => ending(Err(error)),
        (Ok(passes), _) => Ending::Code(u8::from(!passes)),
    }
}

fn test(args: &TestArgs, cancel: &CancelFlag) -> Result<bool> {
    if args.init {
        return init::init(args.suite.folder()).map(|()| true);
    }
    let mut suite = args.suite.read()?;
    if let Some(report) = &args.report {
        suite.report.clone_from(report);
    }
    if args.list {
        let shots = suite::discover(&suite, &ShotFiles)?;
        let names = shots.iter().map(|shot| shot.name.as_str());
        let names: Vec<&str> = names.filter(|name| name.contains(&args.filter)).collect();
        print_output(&names.join("\n"));
        return Ok(true);
    }
    let page = suite.report.join("index.html");
    for file in [Some(page.as_path()), args.junit.as_deref()].into_iter().flatten() {
        probe_folder(file)?;
    }
    let result = tested(args, &suite, cancel)?;
    write_report(&suite::report_page(&suite, &result, &command(args, &suite)), &page)?;
    if let Some(file) = &args.junit {
        write_atomically(file, suite::junit_xml(&result)?.as_bytes())?;
    }
    let text = if args.json {
        report::json(&suite, &result, &page)?
    } else {
        text::text(&result, &page, &shown_suite(&args.suite), args.quiet)
    };
    if !text.is_empty() {
        print_output(&text);
    }
    Ok(result.passes())
}

fn tested(args: &TestArgs, suite: &Suite, cancel: &CancelFlag) -> Result<SuiteResult> {
    let options = RunOptions {
        filter: args.filter.clone(),
        // Where nobody looks, nothing waits to be looked at; the report holds the pictures.
        keeps_pending: !suite::is_ci(),
        threads: args.threads.map_or(0, |threads| threads as usize),
    };
    let progress = SuiteProgress::new(!args.quiet && std::io::stderr().is_terminal());
    suite::run(suite, &ShotFiles, &options, cancel, &|shot| progress.tell(&shot.name, shot.passes()))
}

/// The command that was given, to be typed again.
fn command(args: &TestArgs, suite: &Suite) -> String {
    let mut command = "rayframe test".to_owned();
    for word in [&args.filter].into_iter().filter(|word| !word.is_empty()) {
        command.push(' ');
        command.push_str(&suite::shell_word(word));
    }
    let file: &Path = &suite.file;
    format!("{command} --suite {}", suite::shell_word(&file.display().to_string()))
}
