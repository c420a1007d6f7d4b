//! Settings from three places: options, `-D KEY=VALUE` and a shot file, of which the first that says something wins.
//!
//! Every setting becomes the option of its name and is parsed as such, so that there is one definition of each, and none
//! is left out. See docs/shots.md for the form of the file.

mod choices;
pub mod environment;
mod file;
mod form;
mod idle_options;
mod job;
pub mod layer_options;
pub mod memory_limit;
mod nearest;
pub mod options;
mod plan;
pub mod render_args;
pub mod render_job;
mod render_settings;
mod setting;

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::parser::ValueSource;
use clap::{ArgMatches, Command, FromArgMatches};

use crate::error::{Error, Result};

use render_args::RenderArgs;

use setting::{Origin, Setting, Value, arg_of, argument_list, excludes, is_setting};

pub use job::{ShotFiles, ShotJob, ShotRequest, check_suite_settings, scene_of_shot, shot_job};
pub use plan::{plan_json, plan_text};

/// The options that were typed, before anything else is taken into account.
#[derive(Clone, Debug)]
pub struct GivenOptions(ArgMatches);

/// The options that are meant.
#[derive(Debug)]
pub struct MeantOptions {
    /// All of them.
    pub args: RenderArgs,
    /// The shot file that was read.
    pub shot: Option<PathBuf>,
    matches: ArgMatches,
    settings: Vec<Setting>,
}

impl FromArgMatches for GivenOptions {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        Ok(Self(matches.clone()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> std::result::Result<(), clap::Error> {
        self.0 = matches.clone();
        Ok(())
    }
}

impl clap::Args for GivenOptions {
    fn augment_args(command: Command) -> Command {
        RenderArgs::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        RenderArgs::augment_args_for_update(command)
    }
}

/// All options, for parsing lists of arguments without a program's name.
fn options() -> Command {
    let command = Command::new("render").no_binary_name(true).disable_help_flag(true);
    <RenderArgs as clap::Args>::augment_args(command)
}

impl GivenOptions {
    /// The shot file that is named, whether it can be read or not.
    pub fn shot(&self) -> Option<PathBuf> {
        let path = |id| self.0.get_one::<PathBuf>(id).cloned();
        path("config").or_else(|| path("scene").filter(|scene| is_shot(scene)))
    }

    /// Reads the shot file, if there is one, and puts all settings together.
    ///
    /// # Errors
    /// [`Error::Usage`] for what was typed; [`Error::Missing`], [`Error::Refused`] and [`Error::Invalid`] for the shot file.
    pub fn meant(&self) -> Result<MeantOptions> {
        let command = options();
        let shot = self.shot();
        let mut layers = vec![self.typed(&command)?, self.defined(&command)?];
        if let Some(shot) = &shot {
            layers.push(file::read_shot(shot, &command)?);
        }
        put_together(&command, shot, layers)
    }

    /// What was typed as options and as the scene.
    fn typed(&self, command: &Command) -> Result<Vec<Setting>> {
        let mut settings = Vec::new();
        for arg in command.get_arguments().filter(|arg| is_setting(arg) || arg.get_id() == "dry_run") {
            let key = arg.get_id().as_str();
            if self.0.value_source(key) != Some(ValueSource::CommandLine) {
                continue;
            }
            let raw: Vec<OsString> =
                self.0.get_raw(key).map(|raw| raw.map(OsStr::to_owned).collect()).unwrap_or_default();
            if key == "scene" && raw.iter().any(|scene| is_shot(Path::new(scene))) {
                if self.0.value_source("config").is_some() {
                    let message = "--config: the scene is a shot file already; name one of the two";
                    return Err(Error::usage(message));
                }
                continue;
            }
            let value = if arg.get_action().takes_values() { Value::Texts(raw) } else { Value::Flag(true) };
            settings.push(Setting { key: key.to_owned(), value, origin: Origin::Typed });
        }
        Ok(settings)
    }

    /// What was typed as `-D KEY=VALUE`.
    fn defined(&self, command: &Command) -> Result<Vec<Setting>> {
        defined_by(command, self.0.get_many::<String>("set").unwrap_or_default())
    }
}

/// What the texts `KEY=VALUE` set, of which the last counts, unless they add up.
fn defined_by<'a>(command: &Command, texts: impl IntoIterator<Item = &'a String>) -> Result<Vec<Setting>> {
    let mut settings: Vec<Setting> = Vec::new();
    for text in texts {
        let setting = setting::defined(command, text)?;
        let earlier = settings.iter_mut().find(|earlier| earlier.key == setting.key);
        match (earlier, arg_of(command, &setting.key)) {
            (Some(earlier), Some(arg)) if form::Form::of(arg).is_repeated => {
                earlier.value.extend(setting.value);
            }
            (Some(earlier), _) => *earlier = setting,
            (None, _) => settings.push(setting),
        }
    }
    Ok(settings)
}

/// The settings that are left where those of earlier layers come before those of later ones.
fn put_together(
    command: &Command,
    shot: Option<PathBuf>,
    layers: impl IntoIterator<Item = Vec<Setting>>,
) -> Result<MeantOptions> {
    let mut settings: Vec<Setting> = Vec::new();
    for mut layer in layers {
        for setting in layer.iter().filter(|setting| setting.origin != Origin::Typed) {
            check_alone(command, setting)?;
        }
        layer.retain(|lower| !settings.iter().any(|higher| excludes(command, higher, lower)));
        settings.extend(layer);
    }
    if !settings.iter().any(|setting| setting.key == "scene") {
        return Err(no_scene(shot.as_deref()));
    }
    let matches = parse(command, &settings).map_err(|error| blamed(command, &settings, &error))?;
    let args = RenderArgs::from_arg_matches(&matches).map_err(|error| blamed(command, &settings, &error))?;
    Ok(MeantOptions { args, shot, matches, settings })
}

impl MeantOptions {
    /// Whether a setting was typed, as an option or with `-D`.
    pub fn is_typed(&self, key: &str) -> bool {
        self.settings
            .iter()
            .any(|setting| setting.key == key && !matches!(setting.origin, Origin::File { .. }))
    }

    /// The error with the line of the shot file, where one of its settings is at fault.
    pub fn explained(&self, error: Error) -> Error {
        let Error::Usage { message } = &error else { return error };
        let Some(rest) = message.strip_prefix("--") else { return error };
        let length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '-').unwrap_or(rest.len());
        let (long, why) = rest.split_at(length);
        let command = options();
        let at_fault = self.settings.iter().find(|setting| {
            let arg = arg_of(&command, &setting.key);
            matches!(setting.origin, Origin::File { .. })
                && arg.is_some_and(|arg| arg.get_long() == Some(long))
        });
        match at_fault {
            Some(setting) => setting.error(why.trim_start_matches([':', ' '])),
            None => error,
        }
    }
}

fn is_shot(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

fn no_scene(shot: Option<&Path>) -> Error {
    let example = "scene = \"robot.glb\"";
    match shot {
        Some(shot) => Error::invalid(shot, "", format!("names no scene; write {example}")),
        None => Error::usage("no scene is named; write its file, or -D scene=FILE"),
    }
}

fn parse<'a>(
    command: &Command,
    settings: impl IntoIterator<Item = &'a Setting>,
) -> std::result::Result<ArgMatches, clap::Error> {
    command.clone().try_get_matches_from(argument_list(command, settings))
}

/// Whether the option takes the value, whatever it needs beside it.
fn check_alone(command: &Command, setting: &Setting) -> Result<()> {
    let Err(error) = parse(command, [setting]) else { return Ok(()) };
    if error.kind() == ErrorKind::MissingRequiredArgument {
        return Ok(());
    }
    let source = std::error::Error::source(&error).map(ToString::to_string);
    Err(setting.error(&source.unwrap_or_else(|| parse_error_text(&error))))
}

/// The setting without which the others would do, the last in the last file first, and why.
fn blamed(command: &Command, settings: &[Setting], error: &clap::Error) -> Error {
    let why = parse_error_text(error);
    // What counts least first.
    let suspects = settings.iter().rev().filter(|setting| setting.origin != Origin::Typed);
    let is_at_fault = |suspect: &Setting| {
        parse(command, settings.iter().filter(|setting| setting.key != suspect.key)).is_ok()
    };
    match suspects.clone().find(|suspect| suspect.key != "scene" && is_at_fault(suspect)) {
        Some(setting) => setting.error(&why),
        None => Error::usage(why),
    }
}

/// The message and its tip, without the usage that follows.
pub fn parse_error_text(error: &clap::Error) -> String {
    if let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand)
        && [".glb", ".gltf", ".toml"].iter().any(|end| word.to_ascii_lowercase().ends_with(end))
    {
        return format!("what to do with \"{word}\"? Write: rayframe render {word}");
    }
    let rendered = error.render().to_string();
    let lines = rendered.lines().map(str::trim).filter(|line| !line.is_empty());
    let mut text = String::new();
    for line in lines.take_while(|line| !line.starts_with("Usage: ") && !line.starts_with("For more")) {
        let (separator, line) = match (line.strip_prefix("tip: "), text.is_empty()) {
            (Some(tip), _) => ("; ", tip),
            (None, true) => ("", line.strip_prefix("error: ").unwrap_or(line)),
            (None, false) => (" ", line),
        };
        text.push_str(separator);
        text.push_str(line);
    }
    text
}

/// What `--strict` says of the warnings: the first one, and how many there are.
pub fn refusal(path: &Path, warnings: &[crate::error::Warning]) -> Option<Error> {
    let unique: std::collections::BTreeSet<_> = warnings.iter().collect();
    let first = unique.first()?;
    let count = match unique.len() {
        1 => "1 warning".to_owned(),
        count => format!("{count} warnings"),
    };
    let message = format!("{} (--strict refuses {count})", first.message);
    Some(Error::unsupported(path, first.pointer.clone(), message))
}

/// The message with control characters made visible.
fn one_line(message: &str) -> String {
    message
        .chars()
        .map(|c| if c.is_control() { c.escape_default().to_string() } else { c.to_string() })
        .collect()
}

#[cfg(test)]
mod tests;
