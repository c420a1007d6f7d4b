//! `rayframe test`: renders the shots of a suite and compares them with their references.

mod annotations;
mod init;
mod junit;
mod list;
mod open;
mod output_files;
mod report;
mod selection;
mod text;

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::exit_status::{ExitStatus, exit_status};
use super::fail_on::FailOnOption;
use super::signals;
use super::suite_options::SuiteOption;
use super::summary::counted;
use crate::progress::{
    SuiteProgress, escaped_json, one_line, print_json, print_note, print_output, print_warning,
};
use rayframe::cancel::CancelFlag;
use rayframe::error::{Error, Result};
use rayframe::image_file::write_single_file;
use rayframe::regression::suite::{self, PageCommands, RunOptions, Suite};
use rayframe::regression::{SuiteResult, Verdict, check_report_place, write_report};
use rayframe::settings::parse as options;

use open::open_in_browser;
use output_files::OutputFiles;
use selection::SelectionOptions;

/// Options of `rayframe test`.
#[derive(Clone, Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is one flag of the command line")]
pub(super) struct TestArgs {
    /// Only the shot of this name, or all whose names contain it
    #[arg(default_value = "", hide_default_value = true)]
    filter: String,
    #[command(flatten)]
    suite: SuiteOption,
    /// Write suite.toml in the current folder, or in the one that --suite names
    #[arg(long, conflicts_with_all = ["filter", "list", "list_images", "json", "files", "report", "threads", "max_memory", "quiet", "selection", "no_cache", "slowest", "merge"])]
    init: bool,
    /// Print the names of the shots, without rendering
    #[arg(long, conflicts_with_all = ["json", "files", "report", "threads", "max_memory", "quiet", "no_cache", "slowest", "merge"])]
    list: bool,
    /// Print the names of the shots, and below each those of its images, without rendering
    #[arg(long, conflicts_with_all = ["list", "json", "files", "report", "threads", "max_memory", "quiet", "no_cache", "slowest", "merge"])]
    list_images: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    files: OutputFiles,
    /// Folder of the report, instead of the suite's
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Number of threads, and of shots at a time [default: one a core]
    #[arg(short, long, value_name = "N", value_parser = |text: &str| options::whole::<u32>(text, 1, 1024))]
    threads: Option<u32>,
    /// Show images that are identical to their references in the report, too, as far as it has space for them
    #[arg(long, conflicts_with_all = ["init", "list", "list_images"])]
    report_passing: bool,
    /// Memory limit of all shots that are tested at a time, such as 8G [default: 80 % of the available memory]
    #[arg(long, value_name = "SIZE", value_parser = options::memory_size)]
    max_memory: Option<u64>,
    #[command(flatten)]
    selection: SelectionOptions,
    /// Render all shots, and keep no verdicts. Without it, shots are not rendered that were identical and have not changed since
    #[arg(long)]
    no_cache: bool,
    /// Merge the reports of all shards of a suite, without rendering
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["filter", "selection", "threads", "max_memory", "no_cache"])]
    merge: Vec<PathBuf>,
    /// Print the N slowest shots
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true, value_parser = |text: &str| options::whole::<usize>(text, 0, 1_000_000))]
    slowest: usize,
    #[command(flatten)]
    fail_on: FailOnOption,
    /// Open the report in a browser where an image changed or failed
    #[arg(long, conflicts_with_all = ["init", "list", "list_images"])]
    open: bool,
    /// Other programs' option that replaces references
    #[arg(long, hide = true, aliases = ["update-snapshots", "update-references", "bless"])]
    update: bool,
    /// Replace files that this program did not write for the same purpose; references and other inputs never
    #[arg(long, conflicts_with_all = ["init", "list", "list_images"])]
    overwrite: bool,
    /// Print failures only
    #[arg(short, long)]
    quiet: bool,
}

/// Tests and prints. The exit code is 1 when a verdict is one that `--fail-on` names, and 0 otherwise.
pub(super) fn run(args: &TestArgs) -> ExitStatus {
    let cancel = CancelFlag::new();
    let caught = match signals::watch(&cancel) {
        Ok(caught) => caught,
        Err(error) => {
            let message = format!("signals cannot be watched: {error}");
            return exit_status(Err(Error::Internal { message }));
        }
    };
    match (test(args, &cancel), caught.number()) {
        (Err(Error::Interrupted(_)), Some(signal)) => ExitStatus::Signal(signal),
        (Err(error), _) => exit_status(Err(error)),
        (Ok(passes), _) => ExitStatus::Code(u8::from(!passes)),
    }
}

fn test(args: &TestArgs, cancel: &CancelFlag) -> Result<bool> {
    if args.update {
        return Err(Error::usage(
            "rayframe test never replaces references; look at the report, then run rayframe accept",
        ));
    }
    if args.init {
        return init::init(&args.suite).map(|()| true);
    }
    let suite = args.suite.read()?;
    warn_of_excluded(&suite);
    if args.list || args.list_images {
        return list::list(&suite, &args.run_options(&suite), args.list_images).map(|()| true);
    }

    // Check output files before rendering.
    let folder = args.report.as_ref().unwrap_or(&suite.report);
    let page = folder.join("index.html");
    args.files.check(&suite, (folder, &args.merge), args.overwrite)?;
    suite::check_result_place(folder, args.overwrite)?;
    if args.run_options(&suite).images.is_some() {
        suite::check_images_place(&suite, folder, args.overwrite)?;
    }
    check_report_place(&page, args.overwrite)?;

    let result = match &*args.merge {
        [] => {
            // A run that ends early leaves no result of an earlier one.
            let _ = std::fs::remove_file(folder.join(suite::RESULT_FILE));
            tested(args, &suite, cancel)?
        }
        reports => suite::merge_reports(&suite, reports, &args.run_options(&suite))?,
    };
    let fail_on = args.fail_on.value();
    let passes = !result.fails(fail_on);
    let differs = result.counts().worst() != Verdict::Identical;
    for error in result.not_kept() {
        print_warning(&format!("pending images cannot be stored: {error}"));
    }
    for file in &result.stray {
        let file = one_line(&file.display().to_string());
        print_warning(&format!(
            "{file}: is skipped, as no key in it is a setting of a shot; `exclude` of the suite silences this"
        ));
    }
    if let Some(error) = &result.not_cached {
        print_warning(&format!("verdicts cannot be kept for the next run: {error}"));
    }
    let files_written = args.files.write(&suite, &result, fail_on);
    let json = escaped_json(&report::json(&suite, &result, &page, (fail_on, args.selection.shard()))?);
    // Print the result before errors of writing files end the run.
    if args.json {
        print_json(&json);
    } else {
        let text = text::text(&result, &page, &args.suite.shown(), args.text_style());
        if !text.is_empty() {
            print_output(&text);
        }
    }
    write_page(args, &suite, result, &page)?;
    write_single_file(&folder.join(suite::RESULT_FILE), json.as_bytes())?;
    files_written?;
    if args.open && differs {
        open_in_browser(&page);
    }
    Ok(passes)
}

fn write_page(args: &TestArgs, suite: &Suite, result: SuiteResult, page: &Path) -> Result<()> {
    let commands = PageCommands {
        test: &command(args, suite),
        allowed: args.suite.allowed(),
        keeps_pending: !suite::is_ci(),
    };
    write_report(&suite::report_page(suite, result, &commands), page)
}

/// Warns of paths of `exclude` that do not exist: a misspelled one excludes nothing.
fn warn_of_excluded(suite: &Suite) {
    for path in &suite.missing_excluded {
        let (file, path) = [&suite.file, path].map(|path| one_line(&path.display().to_string())).into();
        print_warning(&format!(
            "{file}: exclude: there is no {path}, neither in the suite's folder nor in that of its scenes"
        ));
    }
}

fn tested(args: &TestArgs, suite: &Suite, cancel: &CancelFlag) -> Result<SuiteResult> {
    let options = args.run_options(suite);
    let progress = SuiteProgress::new(!args.quiet && std::io::stderr().is_terminal());
    let result = suite::run(suite, &options, cancel, &|count, shot| {
        progress.tell(count, &shot.name, shot.passes());
    });
    if matches!(result, Err(Error::Interrupted(_))) {
        let tested = counted(progress.finished() as u64, "shot");
        print_note(&format!("stopped after {tested}; no report was written"));
    }
    result
}

/// The command line, quoted for a shell.
fn command(args: &TestArgs, suite: &Suite) -> String {
    let mut words = vec!["--suite".to_owned(), suite.file.display().to_string()];
    for folder in args.suite.allowed() {
        words.extend(["--allow-dir".to_owned(), folder.display().to_string()]);
    }
    words.extend(args.selection.words());
    if let Some(folder) = &args.report {
        words.extend(["--report".to_owned(), folder.display().to_string()]);
    }
    words.extend(args.report_passing.then(|| "--report-passing".to_owned()));
    words.extend(args.fail_on.words().iter().copied().map(str::to_owned));
    let options: Vec<_> = words.iter().map(|word| suite::shell_word(word)).collect();
    format!("rayframe test {}", suite::name_and_options(&args.filter, &options.join(" ")))
}

impl TestArgs {
    fn text_style(&self) -> text::TextStyle {
        text::TextStyle { is_quiet: self.quiet, fail_on: self.fail_on.value(), slowest: self.slowest }
    }

    fn run_options(&self, suite: &Suite) -> RunOptions {
        let is_ci = suite::is_ci();
        // Build servers and shards keep the rendered images beside the report, from where they are accepted or merged.
        let keeps_images = is_ci || self.selection.shard().is_some() || !self.merge.is_empty();
        RunOptions {
            filter: self.filter.clone(),
            shard: self.selection.shard(),
            changed_since: self.selection.changed_since(),
            uses_cache: !self.no_cache,
            keeps_pending: !is_ci && self.merge.is_empty(),
            images: keeps_images.then(|| self.report.clone().unwrap_or_else(|| suite.report.clone())),
            reports_passing: self.report_passing,
            threads: self.threads.map_or(0, |threads| threads as usize),
            max_memory_bytes: self.max_memory,
        }
    }
}
