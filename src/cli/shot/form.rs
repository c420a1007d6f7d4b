//! In which forms a setting is written, as the name of the option's value tells.

use clap::{Arg, ArgAction};

/// Names of values that are numbers.
const NUMBERS: [&str; 14] = [
    "N", "X", "PIXELS", "FRAME", "FRAMES", "METRES", "DEG", "EV", "RATE", "SIZE", "AREA", "FACTOR",
    "PERCENT", "SPEC",
];
/// Those among them that can also be said in letters, such as `auto`, `8G` or `1-10`.
const NUMBERS_OR_TEXTS: [&str; 4] = ["EV", "RATE", "SIZE", "SPEC"];

/// How the value of an option can be written in a shot file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Form {
    /// `true` or `false`, and nothing else.
    pub(super) is_flag: bool,
    /// A number.
    pub(super) takes_number: bool,
    /// A text in quotes.
    pub(super) takes_text: bool,
    /// An array, whose elements the option takes with this between them.
    pub(super) separator: Option<&'static str>,
    /// An array of values for an option that may be given more than once.
    pub(super) is_repeated: bool,
    /// How the text names files.
    pub(super) path: PathForm,
}

/// How a text names files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathForm {
    /// Not at all.
    None,
    /// As it stands.
    File,
    /// With places for the frame number.
    Pattern,
    /// Unless it is a word or a colour.
    Picture,
}

impl Form {
    /// The form of `arg`.
    pub(super) fn of(arg: &Arg) -> Self {
        let name = value_name(arg);
        let alternatives: Vec<&str> = name.split('|').collect();
        let is_flag = !arg.get_action().takes_values();
        let takes_number = !is_flag && alternatives.iter().any(|name| NUMBERS.contains(name));
        let is_number_alone =
            takes_number && alternatives.len() == 1 && !NUMBERS_OR_TEXTS.contains(&name.as_str());
        Self {
            is_flag,
            takes_number,
            takes_text: !is_flag && !is_number_alone,
            separator: match name.as_str() {
                "WxH" => Some("x"),
                "LIST" | "SPEC" => Some(","),
                _ if name.contains(',') => Some(","),
                _ => None,
            },
            is_repeated: matches!(arg.get_action(), ArgAction::Append),
            path: match name.as_str() {
                "FILE" => PathForm::File,
                _ if arg.get_id() == "scene" => PathForm::File,
                "PATTERN" => PathForm::Pattern,
                _ if name.contains("FILE") => PathForm::Picture,
                _ => PathForm::None,
            },
        }
    }

    /// What is expected, in words.
    pub(super) fn expected(self) -> String {
        let array = |of: &str| format!("an array of {of}");
        let mut forms = Vec::new();
        if self.is_flag {
            forms.push("true or false".to_owned());
        }
        if self.takes_number {
            forms.push("a number".to_owned());
        }
        if self.takes_text {
            forms.push("a text in quotes".to_owned());
        }
        if self.separator.is_some() {
            forms.push("an array".to_owned());
        } else if self.is_repeated {
            forms.push(array("texts"));
        }
        forms.join(" or ")
    }
}

fn value_name(arg: &Arg) -> String {
    arg.get_value_names().and_then(|names| names.first()).map(ToString::to_string).unwrap_or_default()
}
