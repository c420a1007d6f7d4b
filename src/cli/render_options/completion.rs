//! What shells complete after an option: the names that a setting takes, or files.

use std::ffi::{OsStr, OsString};

use clap::builder::{OsStringValueParser, PossibleValue, TypedValueParser};
use clap::{Arg, Command, ValueHint};

use rayframe::settings::Definition;

/// Accepts any text, which the setting's definition parses, and names the choices.
#[derive(Clone)]
struct Offered(Vec<PossibleValue>);

impl TypedValueParser for Offered {
    type Value = OsString;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<OsString, clap::Error> {
        OsStringValueParser::new().parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        (!self.0.is_empty()).then(|| Box::new(self.0.iter().cloned()) as Box<dyn Iterator<Item = _>>)
    }
}

/// Gives the option of a setting its value. The help names the choices already.
pub(super) fn with_value(arg: Arg, definition: &Definition) -> Arg {
    let choice = |(name, help): (&'static str, &'static str)| match help {
        "" => PossibleValue::new(name),
        help => PossibleValue::new(name).help(help),
    };
    let hint = match definition.value_name {
        "SCENE" | "FILE" | "FILE.png" | "PATTERN" | "PATH" | "SOURCE" => ValueHint::FilePath,
        "DIR" => ValueHint::DirPath,
        _ => ValueHint::Other,
    };
    arg.value_name(definition.value_name)
        .value_parser(Offered(definition.choices().into_iter().map(choice).collect()))
        .hide_possible_values(true)
        .value_hint(hint)
}
