//! Command line: one file per subcommand, from typed arguments to the run.

mod accept;
mod accept_rendered;
mod arguments;
mod camera_text;
mod check;
mod completions;
mod diff;
mod exit_status;
mod fail_on;
mod farm;
mod findings;
mod info;
mod man;
mod markdown;
mod merge;
mod outcome;
mod output_folders;
mod plan;
mod presenter;
mod render;
mod render_options;
mod review;
mod signals;
mod suite_options;
mod summary;
mod test;
mod warnings;
mod watch;

use std::ffi::{OsStr, OsString};
use std::io::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory as _, Parser, Subcommand};

use crate::progress::{note_output_failure, option_names, print_error, take_output_failure};
use rayframe::error::Error;
use rayframe::settings::synonym;

use exit_status::exit_status;
use render_options::RenderOptions;

pub(crate) use exit_status::ExitStatus;

/// Arguments of the program.
#[derive(Debug, Parser)]
#[command(name = "rayframe", version, about, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a glTF scene (.glb, .gltf) or a shot file (.toml) to an image sequence
    Render(RenderOptions),
    /// Merge crops and sample ranges into whole frames
    Merge(merge::MergeArgs),
    /// Write job files for a render farm (Open Job Description, Slurm, Kubernetes, GNU parallel), and submit nothing
    Farm(farm::FarmArgs),
    /// Verify that rendered files are whole, and a delivery complete; exit code 0: all are, 1: not
    Check(check::CheckArgs),
    /// Show the contents of a file, what is rendered, and what is not supported
    Info(info::InfoArgs),
    /// Compare two images, two sequences or two versions of an asset; exit code 0: within the limits of the preset, 1: not
    Diff(diff::DiffArgs),
    /// Render a suite of shots and compare them with their references; exit code 1: something fails
    Test(test::TestArgs),
    /// Accept pending images as the new references
    Accept(accept::AcceptArgs),
    /// Discard pending images
    Reject(accept::RejectArgs),
    /// Show pending images one by one, and accept or reject each
    Review(accept::RejectArgs),
    /// Render one frame, coarse first, and again after every change of the scene or the shot file
    Watch(watch::WatchOptions),
    /// Print a script by which a shell completes verbs and options
    Completions(completions::CompletionsArgs),
    /// Print a manual page, or write all of them into a folder
    Man(man::ManArgs),
}

/// Parses `arguments` (the program's name first), runs the command, and prints an error in one line.
pub(crate) fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitStatus {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let command = arguments.get(1).cloned();
    let panic_place = note_panics();
    signals::end_failed_allocations();
    let ran = catch_unwind(AssertUnwindSafe(|| {
        let cli = match arguments::parse::<Cli>(arguments) {
            Ok(cli) => cli,
            Err(error) => return parse_failure(&error, command.as_deref()),
        };
        match cli.command {
            Command::Render(given) => render::run(&given),
            Command::Watch(given) => watch::run(&given),
            Command::Merge(args) => merge::run(&args),
            Command::Farm(args) => exit_status(farm::run(&args)),
            Command::Test(args) => test::run(&args),
            Command::Accept(args) => exit_status(match args.from() {
                Some(report) => accept_rendered::accept_rendered(&args, report),
                None => accept::accept(&args),
            }),
            Command::Reject(args) => exit_status(accept::reject(&args)),
            Command::Review(args) => exit_status(review::run(&args)),
            Command::Info(args) => exit_status(info::run(&args)),
            Command::Diff(args) => verdict(in_threads(|| diff::run(&args))),
            Command::Completions(args) => completions::run(&args, Cli::command()),
            Command::Man(args) => exit_status(man::run(&args, Cli::command())),
            Command::Check(args) => verdict(in_threads(|| check::run(&args))),
        }
    }));
    delivered(ran.unwrap_or_else(|_| {
        let place = panic_place.lock().map(|place| place.clone()).unwrap_or_default();
        print_error(&format!("internal error: the program panicked{place}; this is a bug worth reporting"));
        ExitStatus::Code(70)
    }))
}

/// The status, unless data for the standard output was lost. Other failures come first.
fn delivered(status: ExitStatus) -> ExitStatus {
    match (status, take_output_failure()) {
        (ExitStatus::Code(0 | 1), Some(source)) => {
            exit_status(Err(Error::WriteFailed { path: "standard output".into(), source }))
        }
        _ => status,
    }
}

/// Runs a command in threads of its own, one a core. Those of others panic where they cannot be started.
fn in_threads<T: Send>(command: impl FnOnce() -> Result<T, Error> + Send) -> Result<T, Error> {
    let pool = rayon::ThreadPoolBuilder::new().build().map_err(Error::no_threads)?;
    pool.install(command)
}

/// 0 where all is well, and 1 where it is not.
fn verdict(ran: Result<bool, Error>) -> ExitStatus {
    match ran {
        Ok(is_well) => ExitStatus::Code(u8::from(!is_well)),
        Err(error) => exit_status(Err(error)),
    }
}

/// Records the place of panics instead of printing them: decoders may panic on broken input, which has an error message of its
/// own. With `RUST_BACKTRACE` set, panics are printed as usual.
fn note_panics() -> Arc<Mutex<String>> {
    let place = Arc::new(Mutex::new(String::new()));
    let noted = Arc::clone(&place);
    if std::env::var_os("RUST_BACKTRACE").is_none() {
        std::panic::set_hook(Box::new(move |panic| {
            if let (Some(location), Ok(mut noted)) = (panic.location(), noted.lock()) {
                *noted = format!(" at {location}");
            }
        }));
    }
    place
}

/// Prints a parse error in one line. Help and version also come as errors.
fn parse_failure(error: &clap::Error, command: Option<&OsStr>) -> ExitStatus {
    match error.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let printed = error.print().and_then(|()| std::io::stdout().flush());
            if !error.use_stderr() {
                note_output_failure(printed);
            }
        }
        _ => print_error(&parse_error_text(error, command)),
    }
    ExitStatus::Code(u8::try_from(error.exit_code()).unwrap_or(2))
}

/// The message and its tip, without the usage text.
fn parse_error_text(error: &clap::Error, command: Option<&OsStr>) -> String {
    let takes_settings = command.is_some_and(|command| command == "render" || command == "watch");
    if let (true, ErrorKind::UnknownArgument, Some(ContextValue::String(word))) =
        (takes_settings, error.kind(), error.get(ContextKind::InvalidArg))
        && let Some(hint) = synonym(word)
    {
        return option_names(&format!("{word} is no option; {hint}"));
    }
    if let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand)
        && [".glb", ".gltf", ".toml"].iter().any(|end| word.to_ascii_lowercase().ends_with(end))
    {
        return format!("\"{word}\" is a scene, not a command; write: rayframe render {word}");
    }
    let rendered = error.render().to_string();
    let lines = rendered.lines().map(str::trim).filter(|line| !line.is_empty());
    let mut text = String::new();
    for line in lines.take_while(|line| !line.starts_with("Usage: ") && !line.starts_with("For more")) {
        let (separator, line) = match (line.strip_prefix("tip: "), text.is_empty()) {
            (Some(tip), _) => ("; ", tip),
            (None, true) => ("", line.strip_prefix("error: ").unwrap_or(line)),
            (None, false) => (" ", line),
        };
        text.push_str(separator);
        text.push_str(line);
    }
    text
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory as _, Parser as _};

    use super::Cli;

    #[test]
    fn the_short_help_fits_on_a_screen() {
        let mut command = Cli::command().term_width(100);
        command.build();
        for name in ["render", "farm"] {
            let help = command.find_subcommand_mut(name).unwrap().render_help().to_string();
            assert!(help.lines().count() <= 50, "{help}");
        }
    }

    #[test]
    fn the_help_of_watch_states_its_own_defaults() {
        let mut command = Cli::command().term_width(200);
        command.build();
        let watch = command.find_subcommand_mut("watch").unwrap();
        for help in [watch.render_help().to_string(), watch.render_long_help().to_string()] {
            assert!(
                help.contains("NAME.watch.png") && help.contains("Frame to render [default: 0]"),
                "{help}"
            );
            assert!(
                !help.contains("--dry-run") && !help.contains("--end") && !help.contains("####"),
                "{help}"
            );
        }
    }

    #[test]
    fn the_help_of_exposure_names_what_it_measures() {
        let mut command = Cli::command().term_width(1000);
        command.build();
        let help = command.find_subcommand_mut("render").unwrap().render_long_help().to_string();
        let exposure = help.lines().find(|line| line.contains("Exposure of previews")).unwrap();
        for measured in ["built-in light", "emissive surfaces", "base colours"] {
            assert!(exposure.contains(measured), "{exposure}");
        }
    }

    #[test]
    fn both_commands_take_the_same_options() {
        Cli::command().debug_assert();
        for command in ["render", "watch"] {
            assert!(Cli::try_parse_from(["rayframe", command, "a.glb", "-D", "samples=1"]).is_ok());
            assert!(Cli::try_parse_from(["rayframe", command]).is_err());
            assert!(Cli::try_parse_from(["rayframe", command, "--config", "a.toml"]).is_ok());
        }
    }
}
