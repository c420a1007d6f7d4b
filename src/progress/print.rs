//! Printing to the standard streams. Failures are ignored.

use std::io::Write as _;

use super::option_names::option_names;

/// Prints `rayframe: error: …` to the standard error stream, with the message as it is.
pub(crate) fn print_error(message: &str) {
    to_stderr(&format!("rayframe: error: {}", one_line(message)));
}

/// Prints `rayframe: warning: …` to the standard error stream.
pub(crate) fn print_warning(message: &str) {
    to_stderr(&format!("rayframe: warning: {}", one_line(&option_names(message))));
}

/// Prints a line to the standard error stream.
pub(crate) fn print_note(message: &str) {
    to_stderr(&one_line(message));
}

/// Prints requested text of one or more lines to the standard output.
pub(crate) fn print_output(text: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "{}", text.trim_end_matches('\n')).and_then(|()| stdout.flush());
}

/// Prints text without escaping to the standard error stream.
pub(crate) fn print_raw(text: &str) {
    let mut stderr = std::io::stderr().lock();
    let _ = stderr.write_all(text.as_bytes()).and_then(|()| stderr.flush());
}

fn to_stderr(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// The message with escaped control characters, so that names from files cannot move the cursor or fake a second line.
pub(crate) fn one_line(message: &str) -> String {
    message
        .chars()
        .map(|c| if c.is_control() { c.escape_default().to_string() } else { c.to_string() })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_files_cannot_fake_lines() {
        assert_eq!(one_line("a\nb\u{1b}[2J → c"), "a\\nb\\u{1b}[2J → c");
    }
}
