//! `rayframe completions`: scripts for the completion of arguments in shells.

use clap::Args;
use clap_complete::{Shell, generate};

use crate::progress::print_generated;

use super::exit_status::ExitStatus;

/// Options of `rayframe completions`.
#[derive(Clone, Debug, Args)]
pub(super) struct CompletionsArgs {
    /// The shell; without it, the one that SHELL names
    #[arg(value_name = "SHELL")]
    shell: Option<Shell>,
}

/// Prints the script.
pub(super) fn run(args: &CompletionsArgs, mut program: clap::Command) -> ExitStatus {
    let shell = args.shell.or_else(Shell::from_env).unwrap_or(Shell::Bash);
    let name = program.get_name().to_owned();
    let mut script = Vec::new();
    generate(shell, &mut program, name, &mut script);
    print_generated(&String::from_utf8_lossy(&script));
    ExitStatus::Code(0)
}
