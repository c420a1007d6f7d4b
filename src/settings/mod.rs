//! Settings of a render: one typed definition each, for the command line, shot files, suites and library users.
//!
//! [`DEFINITIONS`] is the table of all settings: name, type, unit, default, help. [`Settings`] holds what is given, with the
//! [`Provenance`](crate::error::Provenance) of each value; levels merge with [`Settings::fill_from`]. [`Settings::values`] applies the
//! defaults. What settings mean for a scene is decided by [`crate::shot`]; options of the terminal are unknown here.

mod camera_path_source;
mod camera_values;
mod choices;
mod conflicts;
mod definition;
mod definitions;
mod environment_source;
mod existing_files;
mod exposure;
mod file_types;
mod frame_rate;
mod frame_spec;
mod home_folder;
mod image_size;
mod keys;
mod layers;
mod lists;
mod name_parts;
mod named;
mod nearest;
mod os_text;
mod output_pattern;
#[doc(hidden)]
pub mod parse;
mod placeholder;
mod plate_pattern;
mod read;
mod sample_range;
mod sequence_pattern;
mod setting_type;
mod shutter;
mod suggest;
mod synonyms;
mod table;
mod text_file;
mod toml_file;
mod toml_value;
mod types;
mod write;

#[doc(inline)]
pub use crate::color::ToneCurve;
#[doc(inline)]
pub use crate::film::PixelWindow;
#[doc(inline)]
pub use crate::image_file::ExrCompression;
#[doc(inline)]
pub use crate::render::{Aperture, GlassShadows, Integrator, PixelFilter};
pub use camera_path_source::CameraPathSource;
pub(crate) use camera_values::field_of_view_of;
pub use choices::{DenoiserKind, FocusRequest, GroundKind, LookAt, PreviewFormat, ProgressStyle, Switch};
pub(crate) use conflicts::{OF_INTEGRATORS, OfIntegrator};
pub use definition::{Assigned, DefinitionOf, Group};
pub use definitions::{DEFINITIONS, Definition, SettingValues, Settings};
pub(crate) use environment_source::ENVIRONMENT_FORMS;
pub use environment_source::{BackgroundSource, EnvironmentSource};
pub use existing_files::ExistingFiles;
pub use exposure::Exposure;
pub use frame_rate::FrameRate;
pub(crate) use frame_spec::stored_frame;
pub use frame_spec::{FrameSpec, NamedFrame, first_middle_last, frames_text};
pub use home_folder::check_expanded;
pub(crate) use image_size::DEFAULT_RESOLUTION;
pub(crate) use keys::is_setting;
pub use lists::aovs_in_files;
pub use named::Named;
pub(crate) use nearest::nearest;
pub use output_pattern::{OutputFormat, OutputPattern};
pub use placeholder::{OutputNames, Placeholder, file_name_part};
pub use plate_pattern::PlatePattern;
pub use sequence_pattern::SequencePattern;
pub use setting_type::{NamedChoice, SettingType, Single, ValueForm};
pub use shutter::Shutter;
pub(crate) use suggest::choices as suggest;
pub use synonyms::synonym;
pub(crate) use text_file::read_text;
pub(crate) use toml_file::{TomlEntry, TomlFile, entries};
pub(crate) use toml_value::number;

#[cfg(test)]
mod tests;
