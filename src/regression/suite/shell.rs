//! Shell quoting, for commands that users copy and for job files.

/// Quotes `word` for a POSIX shell, if necessary.
pub fn shell_word(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@%,".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    shell_quoted(word)
}

/// `text` as one word of a POSIX shell: between apostrophes nothing has a meaning but the apostrophe itself.
pub fn shell_quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_necessary() {
        assert_eq!(shell_word("light/point.0012"), "light/point.0012");
        assert_eq!(shell_word("my shot"), "'my shot'");
        assert_eq!(shell_word("it's $HOME"), r"'it'\''s $HOME'");
        assert_eq!(shell_word(""), "''");
    }

    #[cfg(unix)]
    #[test]
    fn the_shell_reads_what_was_quoted() {
        for text in
            ["", "plain", "two words", "it's", "'", "$HOME `id` \\ \"x\"", "a\nb\n", "*?[x]", "-n", "é→😀"]
        {
            let script = format!("printf '<%s>' {}", shell_quoted(text));
            let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
            assert_eq!(String::from_utf8(output.stdout).unwrap(), format!("<{text}>"));
        }
    }
}
