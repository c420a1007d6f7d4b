//! `rayframe completions`: scripts for the completion of arguments in shells.

use clap::{Args, ValueEnum as _};
use clap_complete::{Shell, generate};

use crate::progress::{print_error, print_generated};

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
    let Some(shell) = args.shell.or_else(Shell::from_env) else {
        let names: Vec<_> = Shell::value_variants().iter().map(Shell::to_string).collect();
        let shell = std::env::var_os("SHELL").unwrap_or_default();
        print_error(&format!(
            "SHELL={}: there are scripts for {}; name one: rayframe completions bash",
            shell.display(),
            names.join(", ")
        ));
        return ExitStatus::Code(2);
    };
    let name = program.get_name().to_owned();
    let mut script = Vec::new();
    generate(shell, &mut program, name, &mut script);
    print_generated(&String::from_utf8_lossy(&script));
    ExitStatus::Code(0)
}
