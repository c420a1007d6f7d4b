//! Settings of a render: one typed definition each, for the command line, shot files, suites and library users.
//!
//! [`DEFINITIONS`] is the table of all settings: name, type, unit, default, help. [`Settings`] holds what is given, with the
//! [`Provenance`](crate::error::Provenance) of each value; levels merge with [`Settings::fill_from`]. [`Settings::values`] applies the
//! defaults. What settings mean for a scene is decided by [`crate::shot`]; options of the terminal are unknown here.

mod choices;
mod definition;
mod definitions;
mod environment_source;
mod file_types;
mod keys;
mod layers;
mod lists;
mod named;
mod nearest;
pub mod parse;
mod read;
mod setting_type;
mod suggest;
mod table;
mod text_file;
mod toml_value;
mod types;
mod write;

pub use choices::{FocusRequest, Integrator, PreviewFormat, ProgressStyle};
pub use definition::{Assigned, DefinitionOf, Group};
pub use definitions::{DEFINITIONS, Definition, SettingValues, Settings};
pub use environment_source::EnvironmentSource;
pub use lists::aovs_in_files;
pub use named::Named;
pub use setting_type::{NamedChoice, SettingType, Single, ValueForm};
pub(crate) use suggest::choices as suggest;
pub(crate) use text_file::{not_toml, read_text};

#[cfg(test)]
mod tests;
