//! Printing to the standard streams. Failures of the error stream are ignored.

use std::io::Write as _;

use rayframe::terminal::misleads;

use super::option_names::option_names;
use super::standard_output::write_lines;

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

/// Prints requested text of one or more lines to the standard output, escaped as messages are.
pub(crate) fn print_output(text: &str) {
    write_lines(&escaped_lines(text));
}

/// Prints requested JSON to the standard output.
pub(crate) fn print_json(json: &str) {
    write_lines(&escaped_json(json));
}

/// Prints a generated file, in which no name comes from outside, to the standard output as it is.
pub(crate) fn print_generated(text: &str) {
    write_lines(text.trim_end());
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
        .map(|c| if misleads(c) { c.escape_default().to_string() } else { c.to_string() })
        .collect()
}

/// Text of several lines, each as [`one_line`] makes it.
pub(crate) fn escaped_lines(text: &str) -> String {
    text.split('\n').map(one_line).collect::<Vec<_>>().join("\n")
}

/// JSON text with `\u` escapes for characters that mislead on a terminal. They occur in strings alone.
pub(crate) fn escaped_json(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    for c in json.chars() {
        if c != '\n' && misleads(c) {
            let mut units = [0; 2];
            text.extend(c.encode_utf16(&mut units).iter().map(|unit| format!("\\u{unit:04x}")));
        } else {
            text.push(c);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_files_cannot_fake_lines() {
        assert_eq!(one_line("a\nb\u{1b}[2J → c"), "a\\nb\\u{1b}[2J → c");
    }

    #[test]
    fn lines_stay_lines() {
        assert_eq!(escaped_lines("a\n\tb\r\nc\u{1b}[2J\n"), "a\n\\tb\\r\nc\\u{1b}[2J\n");
    }

    #[test]
    fn names_cannot_reorder_or_hide_text() {
        assert_eq!(one_line("a\u{202e}b\u{200b}c\u{2066}é"), "a\\u{202e}b\\u{200b}c\\u{2066}é");
    }

    #[test]
    fn json_holds_no_raw_terminal_controls() {
        let name = "a\u{9b}2J\u{7f}\u{202e}\u{e0001}é";
        let json = escaped_json(&serde_json::json!({ "name": name }).to_string());
        assert_eq!(json, r#"{"name":"a\u009b2J\u007f\u202e\udb40\udc01é"}"#);
        let read: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(read["name"], name);
    }
}
