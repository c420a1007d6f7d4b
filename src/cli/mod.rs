//! The command line: one file a subcommand, each from what was typed to what is meant to running it.

mod accept;
mod audience;
mod diff;
mod info;
mod merge;
mod outcome;
mod plan;
mod render;
mod render_options;
mod review;
mod signals;
mod suite_options;
mod test;
mod understood;
mod watch;

use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Parser, Subcommand};

use crate::progress::{print_error, print_warning};
use rayframe::error::{Result, Warning};
use rayframe::shot::refusal;

use render_options::{RenderOptions, message, option_names};

/// What was typed.
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
    /// Join crops into what one machine would have written
    Merge(merge::MergeArgs),
    /// Show what is in a file, what will be rendered, and what is not supported
    Info(info::InfoArgs),
    /// Compare two pictures or two sequences; exit code 0: same within the preset, 1: different
    Diff(diff::DiffArgs),
    /// Render a suite of shots and compare them with their references; exit code 1: something differs
    Test(test::TestArgs),
    /// Make pictures that rayframe test kept the references
    Accept(accept::AcceptArgs),
    /// Forget pictures that rayframe test kept
    Reject(accept::RejectArgs),
    /// Look at pictures that rayframe test kept, one by one, and accept or reject each
    Review(accept::RejectArgs),
    /// Render one frame, coarse first, and again whenever the scene, a file it names or the shot file changes
    Watch(RenderOptions),
}

/// How a program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// With this exit code.
    Code(u8),
    /// By this signal, as if it had not been caught.
    Signal(i32),
}

/// Parses `arguments` (the program's name first), runs what they say, and prints what went wrong in one line.
pub(crate) fn run(arguments: impl IntoIterator<Item = OsString>) -> Ending {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let panic_place = note_panics();
    let ran = catch_unwind(AssertUnwindSafe(|| {
        let cli = match Cli::try_parse_from(arguments) {
            Ok(cli) => cli,
            Err(error) => return not_understood(&error),
        };
        match cli.command {
            Command::Render(given) => render::run(&given),
            Command::Watch(given) => watch::run(&given),
            Command::Merge(args) => merge::run(&args),
            Command::Test(args) => test::run(&args),
            Command::Accept(args) => ending(accept::accept(&args)),
            Command::Reject(args) => ending(accept::reject(&args)),
            Command::Review(args) => ending(review::run(&args)),
            Command::Info(args) => ending(info::run(&args)),
            Command::Diff(args) => match diff::run(&args) {
                Ok(is_same) => Ending::Code(u8::from(!is_same)),
                Err(error) => ending(Err(error)),
            },
        }
    }));
    ran.unwrap_or_else(|_| {
        let place = panic_place.lock().map(|place| place.clone()).unwrap_or_default();
        print_error(&format!("internal error: the program panicked{place}; this is a bug worth reporting"));
        Ending::Code(70)
    })
}

/// Has panics noted instead of printed, for decoders may panic over broken input, which is told in one line of its own. Gives
/// where the last one was, in words. With `RUST_BACKTRACE` set they are printed as ever.
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

/// Prints why the command line does not parse: in one line, except for help and version, which come this way too.
fn not_understood(error: &clap::Error) -> Ending {
    match error.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
        }
        _ => print_error(&parse_error_text(error)),
    }
    Ending::Code(u8::try_from(error.exit_code()).unwrap_or(2))
}

/// The message and its tip, without the usage that follows.
fn parse_error_text(error: &clap::Error) -> String {
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

fn ending(result: Result<()>) -> Ending {
    match result {
        Ok(()) => Ending::Code(0),
        Err(error) => {
            print_error(&message(&error));
            Ending::Code(error.exit_code())
        }
    }
}

/// Names every warning once; under `--strict` the first one is an error that counts the others.
fn settle_warnings(path: &std::path::Path, warnings: &[Warning], is_strict: bool) -> Result<()> {
    let unique: std::collections::BTreeSet<_> = warnings.iter().collect();
    // Under --strict the error says the first one.
    for warning in unique.iter().skip(usize::from(is_strict)) {
        print_warning(&option_names(&format!("{}: {warning}", path.display())));
    }
    match refusal(path, warnings) {
        Some(error) if is_strict => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory as _, Parser as _};

    use super::Cli;

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
