//! Progress output: bars on a terminal, plain lines in a pipe, JSON lines and a manifest for programs.
//!
//! Only this module uses `indicatif`, and only it and `main` print. Text for people goes to the standard error stream, text
//! for programs to the standard output. A stream that fails does not end a run: the files are the product. Data that was lost makes the
//! exit code 74, unless its reader closed the pipe.

mod bars;
mod eta;
mod json;
mod manifest;
mod openjd;
mod option_names;
mod percent_path;
mod plain;
mod pretty_json;
mod print;
mod reported;
mod reporter;
mod standard_output;
mod suite;
mod terminal_image;
mod total;
mod verbosity;

pub(crate) use manifest::Manifest;
pub(crate) use openjd::print_openjd_failure;
pub(crate) use option_names::option_names;
pub(crate) use pretty_json::pretty_json;
pub(crate) use print::{
    escaped_json, escaped_lines, one_line, print_error, print_generated, print_json, print_note,
    print_output, print_raw, print_warning,
};
pub(crate) use reported::{Part, ReportedSequence, RunKind};
pub(crate) use reporter::Reporter;
pub(crate) use standard_output::{note_failure as note_output_failure, take_failure as take_output_failure};
pub(crate) use suite::SuiteProgress;
pub(crate) use terminal_image::TerminalImages;
pub(crate) use total::{Total, print_scene_failure};
pub(crate) use verbosity::Verbosity;
