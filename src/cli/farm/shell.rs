//! Text of job files: quoting for POSIX shells, and names that have no text.

use rayframe::error::Error;

/// The text as one word of a shell command: between apostrophes nothing has a meaning but the apostrophe itself.
pub(super) fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// Error about a name that job files cannot hold.
pub(super) fn not_unicode(name: &str) -> Error {
    Error::usage(format!(
        "{name}: the name is not Unicode (UTF-8), which job files are written in; rename it"
    ))
}

#[cfg(test)]
mod tests {
    #[cfg(unix)]
    #[test]
    fn the_shell_reads_what_was_quoted() {
        for text in
            ["", "plain", "two words", "it's", "'", "$HOME `id` \\ \"x\"", "a\nb\n", "*?[x]", "-n", "é→😀"]
        {
            let script = format!("printf '<%s>' {}", super::quoted(text));
            let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
            assert_eq!(String::from_utf8(output.stdout).unwrap(), format!("<{text}>"));
        }
    }
}
