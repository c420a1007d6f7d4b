//! Types of settings: one conversion from and to text each, for the command line, TOML and JSON alike.

use std::ffi::{OsStr, OsString};
use std::fmt::Debug;
use std::path::Path;

/// What a single value is in TOML.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Single {
    /// `true` or `false`.
    Flag,
    /// A number.
    Number,
    /// A string.
    Text,
    /// A number or a string.
    NumberOrText,
    /// `true`, `false` or a string.
    FlagOrText,
}

/// How values of a setting are written in TOML.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ValueForm {
    /// A single value.
    pub single: Single,
    /// Separator of list elements in text. Such a setting also takes an array.
    pub separator: Option<&'static str>,
    /// Whether several values add up.
    pub is_repeated: bool,
}

impl ValueForm {
    /// `true` or `false`.
    pub const FLAG: Self = Self::single(Single::Flag);
    /// A number.
    pub const NUMBER: Self = Self::single(Single::Number);
    /// A string.
    pub const TEXT: Self = Self::single(Single::Text);
    /// A number or a string.
    pub const NUMBER_OR_TEXT: Self = Self::single(Single::NumberOrText);

    /// `true`, `false` or a string.
    pub const FLAG_OR_TEXT: Self = Self::single(Single::FlagOrText);

    const fn single(single: Single) -> Self {
        Self { single, separator: None, is_repeated: false }
    }

    /// The same, or an array whose elements text separates by `separator`.
    #[must_use]
    pub const fn or_list(self, separator: &'static str) -> Self {
        Self { separator: Some(separator), ..self }
    }

    /// Whether a TOML number is accepted.
    pub fn takes_number(self) -> bool {
        matches!(self.single, Single::Number | Single::NumberOrText)
    }

    /// Whether a TOML string is accepted.
    pub fn takes_text(self) -> bool {
        matches!(self.single, Single::Text | Single::NumberOrText | Single::FlagOrText)
    }

    /// The accepted values in words.
    pub fn expected(self) -> String {
        let single = match self.single {
            Single::Flag => "true or false",
            Single::Number => "a number",
            Single::Text => "a text in quotes",
            Single::NumberOrText => "a number or a text in quotes",
            Single::FlagOrText => "true, false or a text in quotes",
        };
        match (self.separator, self.is_repeated) {
            (Some(_), _) => format!("{single} or an array"),
            (None, true) => format!("{single} or an array of texts"),
            (None, false) => single.to_owned(),
        }
    }
}

/// A name that a setting accepts, with its help; hidden where the help is empty.
pub type NamedChoice = (&'static str, &'static str);

/// Type of a setting.
pub trait SettingType {
    /// Its values.
    type Value: Clone + Debug + PartialEq;
    /// How they are written in TOML.
    const FORM: ValueForm;

    /// The value of a text.
    ///
    /// # Errors
    /// One line that says what to write.
    fn parse(text: &OsStr) -> Result<Self::Value, String>;

    /// The texts of a value: one, or any number for a repeated setting. [`SettingType::parse`] gives the same value.
    fn write(value: &Self::Value) -> Vec<OsString>;

    /// Checks a value that was not read from text. Types of numbers have values that no text gives.
    ///
    /// # Errors
    /// One line that says what to write.
    fn check(_: &Self::Value) -> Result<(), String> {
        Ok(())
    }

    /// The text with files relative to `folder`.
    fn rebase(text: OsString, _folder: &Path) -> OsString {
        text
    }

    /// Adds a later value on the same level: it replaces the earlier one unless values add up.
    fn add(earlier: &mut Self::Value, later: Self::Value) {
        *earlier = later;
    }

    /// The accepted names, where the type is an enum.
    fn choices() -> Vec<NamedChoice> {
        Vec::new()
    }
}

/// Checks a value as its text is.
///
/// # Errors
/// Those of [`SettingType::parse`].
pub(super) fn check_text<T: SettingType>(value: &T::Value) -> Result<(), String> {
    let texts = T::write(value);
    // An empty list has no text.
    texts.iter().filter(|text| !text.is_empty()).try_for_each(|text| T::parse(text).map(drop))
}

/// The text as Unicode.
///
/// # Errors
/// For other text.
pub(super) fn unicode(text: &OsStr) -> Result<&str, String> {
    text.to_str().ok_or_else(|| "is no Unicode text".to_owned())
}
