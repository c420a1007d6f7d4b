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

use rayframe::sequence::SequenceEvent;
use rayframe::settings::ProgressStyle;

use bars::Bars;
use json::JsonLines;
use openjd::OpenJdLines;
use plain::PlainLines;

pub(crate) use manifest::Manifest;
pub(crate) use openjd::print_openjd_failure;
pub(crate) use plain::exposure_text;
pub(crate) use print::{one_line, print_error, print_note, print_output, print_raw, print_warning};
pub(crate) use suite::SuiteProgress;
pub(crate) use terminal_picture::TerminalPictures;

/// How much is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Verbosity {
    /// Only warnings and errors.
    pub(crate) is_quiet: bool,
    /// Also the phases of each frame, and frames that are kept.
    pub(crate) is_verbose: bool,
    /// Name each failed frame at once, because the run goes on after it.
    pub(crate) names_failures: bool,
}

/// Tells the events of one run.
#[derive(Debug)]
pub(crate) struct Reporter {
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
    pub(crate) fn new(style: ProgressStyle, verbosity: Verbosity, output: &str) -> Self {
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
    pub(crate) fn tell(&self, event: SequenceEvent<'_>) {
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
    pub(crate) fn show(&self, picture: &str) {
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
