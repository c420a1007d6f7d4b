//! Progress output of a run in one of its styles.

use rayframe::error::Warning;
use rayframe::sequence::SequenceEvent;
use rayframe::settings::ProgressStyle;

use super::bars::Bars;
use super::json::JsonLines;
use super::openjd::OpenJdLines;
use super::plain::PlainLines;
use super::print::{print_error, print_raw, print_warning};
use super::reported::ReportedSequence;
use super::verbosity::Verbosity;

/// Prints the events of one run.
#[derive(Debug)]
pub(crate) struct Reporter {
    form: Form,
    verbosity: Verbosity,
    sequence: ReportedSequence,
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
    /// A reporter of a run of `sequence`.
    pub(crate) fn new(style: ProgressStyle, verbosity: Verbosity, sequence: &ReportedSequence) -> Self {
        let form = match style {
            ProgressStyle::Json => Form::Json(JsonLines::new(sequence)),
            ProgressStyle::OpenJd => Form::OpenJd(OpenJdLines::new(sequence)),
            ProgressStyle::None => Form::Silent,
            _ if verbosity.is_quiet => Form::Silent,
            ProgressStyle::Plain => Form::Plain(PlainLines::new(verbosity, sequence)),
            ProgressStyle::Auto | ProgressStyle::Bar => {
                // Bars are hidden in pipes and on terminals that cannot show them; plain lines are not.
                let bars = Bars::new(verbosity, sequence);
                if bars.is_hidden() {
                    Form::Plain(PlainLines::new(verbosity, sequence))
                } else {
                    Form::Bars(bars)
                }
            }
        };
        Self { form, verbosity, sequence: sequence.clone() }
    }

    /// Prints one event. May be called from any thread.
    pub(crate) fn print(&self, event: SequenceEvent<'_>) {
        match &self.form {
            Form::Bars(bars) => bars.print(event),
            Form::Plain(lines) => lines.print(event),
            Form::Json(lines) => {
                self.print_problems(event);
                lines.print(event);
            }
            Form::OpenJd(lines) => {
                self.print_problems(event);
                lines.print(event);
            }
            Form::Silent => self.print_problems(event),
        }
    }

    /// Prints a warning about files that are made after the last frame.
    pub(crate) fn warn(&self, warning: &Warning) {
        print_warning(&warning.to_string());
        self.repeat(warning);
    }

    /// Gives programs a warning that people have read already.
    pub(crate) fn repeat(&self, warning: &Warning) {
        if let Form::Json(lines) = &self.form {
            lines.print(SequenceEvent::Warned(warning));
        }
    }

    /// Prints an image encoded as terminal text, above the bars if there are any.
    pub(crate) fn show(&self, image: &str) {
        match &self.form {
            Form::Bars(bars) => bars.suspended(|| print_raw(image)),
            Form::Plain(_) | Form::Json(_) | Form::OpenJd(_) | Form::Silent => print_raw(image),
        }
    }

    /// Prints warnings and failures.
    fn print_problems(&self, event: SequenceEvent<'_>) {
        match event {
            SequenceEvent::Warned(warning) => print_warning(&warning.to_string()),
            SequenceEvent::FrameFailed(frame, error) if self.verbosity.names_failures => {
                print_error(&self.sequence.failure_text(frame, error));
            }
            _ => {}
        }
    }
}
