//! The `rayframe` program.

use std::process::ExitCode;

mod cli;
mod progress;

use cli::{ExitStatus, run};

fn main() -> ExitCode {
    match run(std::env::args_os()) {
        ExitStatus::Code(code) => ExitCode::from(code),
        ExitStatus::Signal(signal) => {
            // Does not return where the signal's default is to end the program.
            let _ = signal_hook::low_level::emulate_default_handler(signal);
            ExitCode::from(75)
        }
    }
}
