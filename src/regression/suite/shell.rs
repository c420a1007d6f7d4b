//! Shell quoting, for commands that users copy and for job files.

/// Quotes `word` for a POSIX shell, if necessary.
pub fn shell_word(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@%,".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    shell_quoted(word)
}

/// The words of a command after its verb: a name and options. A name that begins with `-` would be an option, unless it comes last after `--`.
pub fn name_and_options(name: &str, options: &str) -> String {
    let word = if name.is_empty() { String::new() } else { shell_word(name) };
    let words = if name.starts_with('-') { [options, "--", &word] } else { [&word, options, ""] };
    words.into_iter().filter(|words| !words.is_empty()).collect::<Vec<_>>().join(" ")
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

    #[test]
    fn names_that_look_like_options_come_last() {
        let command = |name| name_and_options(name, "--suite s.toml");
        assert_eq!(command("a/x"), "a/x --suite s.toml");
        assert_eq!(command("my shot"), "'my shot' --suite s.toml");
        assert_eq!(command("-x"), "--suite s.toml -- -x");
        assert_eq!(command("--quiet y"), "--suite s.toml -- '--quiet y'");
        assert_eq!(command(""), "--suite s.toml");
        assert_eq!([name_and_options("x", ""), name_and_options("-x", "")], ["x", "-- -x"]);
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
