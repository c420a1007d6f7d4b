//! Telling the user what happens: bars on a terminal, plain lines in a pipe, JSON lines and a manifest for programs.
//!
//! The only room that names `indicatif`, and with `main` the only one that prints. People are told on the standard error
//! stream, programs on the standard output. A stream that is closed is no reason to stop: the files are the product.

mod bars;
mod eta;
mod json;
mod manifest;
mod openjd;
mod plain;
mod print;
mod suite;
mod terminal_picture;

use crate::sequence::SequenceEvent;

use bars::Bars;
use json::JsonLines;
use openjd::OpenJdLines;
use plain::PlainLines;

pub use manifest::Manifest;
pub use openjd::print_openjd_failure;
pub use plain::exposure_text;
pub use print::{one_line, print_error, print_note, print_output, print_raw, print_warning};
pub use suite::SuiteProgress;
pub use terminal_picture::TerminalPictures;

/// How progress is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProgressStyle {
    /// Bars on a terminal, plain lines elsewhere.
    #[default]
    Auto,
    /// Bars.
    Bar,
    /// One line a frame.
    Plain,
    /// One JSON object a line, on the standard output.
    Json,
    /// The lines that Open Job Description knows, on the standard output.
    OpenJd,
    /// Not at all.
    None,
}

/// How much is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verbosity {
    /// Only warnings and errors.
    pub is_quiet: bool,
    /// Also the phases of each frame, and frames that are kept.
    pub is_verbose: bool,
    /// Name each failed frame at once, because the run goes on after it.
    pub names_failures: bool,
}

/// Tells the events of one run.
#[derive(Debug)]
pub struct Reporter {
    form: Form,
    verbosity: Verbosity,
}

#[derive(Debug)]
enum Form {
    Bars(Bars),
    Plain(PlainLines),
    Json(JsonLines),
    OpenJd(OpenJdLines),
    Silent,
}

impl Reporter {
    /// A reporter for one run whose files are called `output`, with `####` for the frame number.
    pub fn new(style: ProgressStyle, verbosity: Verbosity, output: &str) -> Self {
        let form = match style {
            ProgressStyle::Json => Form::Json(JsonLines::default()),
            ProgressStyle::OpenJd => Form::OpenJd(OpenJdLines::new(output)),
            ProgressStyle::None => Form::Silent,
            _ if verbosity.is_quiet => Form::Silent,
            ProgressStyle::Plain => Form::Plain(PlainLines::new(verbosity, output)),
            ProgressStyle::Auto | ProgressStyle::Bar => {
                // Bars hide themselves in pipes and on terminals that cannot show them; lines do not.
                let bars = Bars::new(verbosity, output);
                if bars.is_hidden() {
                    Form::Plain(PlainLines::new(verbosity, output))
                } else {
                    Form::Bars(bars)
                }
            }
        };
        Self { form, verbosity }
    }

    /// Tells one event; may be called from any thread.
    pub fn tell(&self, event: SequenceEvent<'_>) {
        match &self.form {
            Form::Bars(bars) => bars.tell(event),
            Form::Plain(lines) => lines.tell(event),
            Form::Json(lines) => {
                self.tell_problems(event);
                lines.tell(event);
            }
            Form::OpenJd(lines) => {
                self.tell_problems(event);
                lines.tell(event);
            }
            Form::Silent => self.tell_problems(event),
        }
    }

    /// Writes characters that are a picture, above the bars where there are any.
    pub fn show(&self, picture: &str) {
        match &self.form {
            Form::Bars(bars) => bars.suspended(|| print_raw(picture)),
            Form::Plain(_) | Form::Json(_) | Form::OpenJd(_) | Form::Silent => print_raw(picture),
        }
    }

    /// What people should hear even without progress.
    fn tell_problems(&self, event: SequenceEvent<'_>) {
        match event {
            SequenceEvent::Warned(warning) => print_warning(&warning.to_string()),
            SequenceEvent::FrameFailed(frame, error) if self.verbosity.names_failures => {
                print_error(&format!("frame {}: {error}", frame.frame));
            }
            _ => {}
        }
    }
}
