//! The command line: one file a subcommand, each from what was typed to what is meant to running it.

mod environment;
mod info;
mod memory_limit;
mod options;
mod render;
mod render_args;
mod render_job;
mod signals;
mod understood;

use std::ffi::OsString;
use std::panic::catch_unwind;

use clap::{Parser, Subcommand};

use crate::error::{Error, Result, Warning};
use crate::progress::{print_error, print_warning};

/// What was typed.
#[derive(Debug, Parser)]
#[command(name = "rayframe", version, about, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a glTF scene (.glb, .gltf) to an image sequence
    Render(Box<render_args::RenderArgs>),
    /// Show what is in a file, what will be rendered, and what is not supported
    Info(info::InfoArgs),
}

/// How a program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// With this exit code.
    Code(u8),
    /// By this signal, as if it had not been caught.
    Signal(i32),
}

/// Parses `arguments` (the program's name first), runs what they say, and prints what went wrong in one line.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> Ending {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let ran = catch_unwind(|| {
        let cli = match Cli::try_parse_from(arguments) {
            Ok(cli) => cli,
            Err(error) => {
                // Help and version come this way too, and end with 0.
                let _ = error.print();
                return Ending::Code(u8::try_from(error.exit_code()).unwrap_or(2));
            }
        };
        match cli.command {
            Command::Render(args) => render::run(&args),
            Command::Info(args) => ending(info::run(&args)),
        }
    });
    ran.unwrap_or_else(|_| {
        print_error("internal error: the program panicked; this is a bug worth reporting");
        Ending::Code(70)
    })
}

fn ending(result: Result<()>) -> Ending {
    match result {
        Ok(()) => Ending::Code(0),
        Err(error) => {
            print_error(&error.to_string());
            Ending::Code(error.exit_code())
        }
    }
}

/// Names every warning once; under `--strict` the first one is an error that counts the others.
fn settle_warnings(path: &std::path::Path, warnings: &[Warning], is_strict: bool) -> Result<()> {
    let unique: std::collections::BTreeSet<_> = warnings.iter().collect();
    for warning in &unique {
        print_warning(&format!("{}: {warning}", path.display()));
    }
    match unique.first() {
        Some(first) if is_strict => Err(Error::unsupported(
            path,
            first.pointer.clone(),
            format!("{} (--strict refuses {} warnings)", first.message, unique.len()),
        )),
        _ => Ok(()),
    }
}
