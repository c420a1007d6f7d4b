//! Options of the command line in messages of the library.

use rayframe::settings::Definition;

/// The text with the option of every setting that stands in backquotes: `` `max_memory` `` becomes `--max-memory`.
pub(crate) fn option_names(text: &str) -> String {
    let mut named = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('`') {
        named.push_str(before);
        let setting = after.split_once('`').and_then(|(name, tail)| Some((Definition::of(name)?, tail)));
        if let Some((definition, tail)) = setting {
            named.push_str("--");
            named.push_str(&definition.option_name());
            rest = tail;
        } else {
            named.push('`');
            rest = after;
        }
    }
    named.push_str(rest);
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_become_options_and_other_quotes_stay() {
        assert_eq!(option_names("raise `max_memory`"), "raise --max-memory");
        assert_eq!(option_names("`scene_choice`: `refs`, `"), "--scene: `refs`, `");
    }
}
