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
pub struct Form {
    /// A single value.
    pub single: Single,
    /// An array, whose elements the option takes with this between them.
    pub separator: Option<&'static str>,
    /// An array of values for an option that may be given more than once.
    pub is_repeated: bool,
    /// How the text names files.
    pub path: PathForm,
}

/// What a single value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Single {
    /// `true` or `false`.
    Flag,
    /// A number.
    Number,
    /// A text in quotes.
    Text,
    /// Either of these.
    NumberOrText,
}

/// How a text names files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathForm {
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
    pub fn of(arg: &Arg) -> Self {
        let name = value_name(arg);
        let alternatives: Vec<&str> = name.split('|').collect();
        let is_number = alternatives.iter().any(|name| NUMBERS.contains(name));
        let has_letters = alternatives.len() > 1 || NUMBERS_OR_TEXTS.contains(&name.as_str());
        Self {
            single: match (arg.get_action().takes_values(), is_number, has_letters) {
                (false, ..) => Single::Flag,
                (true, true, false) => Single::Number,
                (true, true, true) => Single::NumberOrText,
                (true, false, _) => Single::Text,
            },
            separator: match name.as_str() {
                "WxH" => Some("x"),
                "LIST" | "SPEC" => Some(","),
                _ if name.contains(',') => Some(","),
                _ => None,
            },
            is_repeated: matches!(arg.get_action(), ArgAction::Append),
            path: match name.as_str() {
                _ if arg.get_id() == "scene" => PathForm::File,
                // Also such as FILE.png.
                name if name.starts_with("FILE") && !name.contains('|') => PathForm::File,
                "PATTERN" => PathForm::Pattern,
                name if name.contains("FILE") => PathForm::Picture,
                _ => PathForm::None,
            },
        }
    }

    /// Whether it is there or not.
    pub fn is_flag(self) -> bool {
        self.single == Single::Flag
    }

    /// Whether a number will do.
    pub fn takes_number(self) -> bool {
        matches!(self.single, Single::Number | Single::NumberOrText)
    }

    /// Whether a text will do.
    pub fn takes_text(self) -> bool {
        matches!(self.single, Single::Text | Single::NumberOrText)
    }

    /// What is expected, in words.
    pub fn expected(self) -> String {
        let single = match self.single {
            Single::Flag => "true or false",
            Single::Number => "a number",
            Single::Text => "a text in quotes",
            Single::NumberOrText => "a number or a text in quotes",
        };
        match (self.separator, self.is_repeated) {
            (Some(_), _) => format!("{single} or an array"),
            (None, true) => format!("{single} or an array of texts"),
            (None, false) => single.to_owned(),
        }
    }
}

fn value_name(arg: &Arg) -> String {
    arg.get_value_names().and_then(|names| names.first()).map(ToString::to_string).unwrap_or_default()
}
