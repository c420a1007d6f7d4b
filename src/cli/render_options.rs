//! Options of `rayframe render` and `rayframe watch`, built from the definitions of the settings.

mod completion;

use std::ffi::{OsStr, OsString};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::builder::OsStringValueParser;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command, FromArgMatches};

use super::output_folders::check_outputs;
use crate::progress::option_names;
use rayframe::error::{Error, Provenance, Result, SettingError};
use rayframe::settings::{DEFINITIONS, Definition, Named as _, ProgressStyle, Settings};
use rayframe::shot::{ShotSettings, is_shot};

use completion::with_value;

/// The typed options.
#[derive(Clone, Debug)]
pub(super) struct RenderOptions(ArgMatches);

/// A scene or a shot file that was typed.
#[derive(Debug)]
pub(super) struct NamedShot {
    /// As it was typed.
    pub(super) path: PathBuf,
    /// Its settings; an error where they are wrong or the shot file cannot be read.
    pub(super) settings: Result<ShotSettings>,
}

impl FromArgMatches for RenderOptions {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        Ok(Self(matches.clone()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> std::result::Result<(), clap::Error> {
        self.0 = matches.clone();
        Ok(())
    }
}

impl clap::Args for RenderOptions {
    fn augment_args(command: Command) -> Command {
        let command = DEFINITIONS.iter().fold(command, |command, definition| command.arg(arg(definition)));
        let config =
            Arg::new("config").long("config").value_name("FILE").value_parser(OsStringValueParser::new());
        let set = Arg::new("set").short('D').long("set").value_name("KEY=VALUE").action(ArgAction::Append);
        let dry_run = Arg::new("dry_run").short('n').long("dry-run").action(ArgAction::SetTrue);
        command
            .arg(config.help("Shot file with settings; options and -D override them"))
            .arg(set.help("Sets any setting by its key in shot files; options override it"))
            .arg(
                dry_run
                    .help("Print the settings as a shot file, list the frames, and stop")
                    .help_heading("Run"),
            )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The option of a setting. Its value is parsed by its definition.
fn arg(definition: &'static Definition) -> Arg {
    let arg = Arg::new(definition.name);
    if definition.name == "scene" {
        let scene = with_value(arg, definition).num_args(1..);
        return scene.help(help(definition, false)).required_unless_present_any(["config", "set"]);
    }
    let action = match (definition.is_flag(), definition.form.is_repeated) {
        (true, _) => ArgAction::SetTrue,
        (false, true) => ArgAction::Append,
        (false, false) => ArgAction::Set,
    };
    let mut arg = arg.long(definition.option_name()).action(action).help_heading(definition.group.heading());
    if !definition.is_flag() {
        arg = with_value(arg, definition).allow_hyphen_values(true);
    }
    if let Some(value) = definition.value_alone {
        arg = arg.num_args(0..=1).require_equals(true).default_missing_value(value);
    }
    if let Some(short) = definition.short {
        arg = arg.short(short);
    }
    arg.visible_aliases(definition.aliases)
        .aliases(definition.hidden_aliases)
        .hide_short_help(!definition.is_common)
        .help(help(definition, false))
        .long_help(help(definition, true))
}

/// One line, or everything.
fn help(definition: &Definition, is_long: bool) -> String {
    let lines = if is_long { definition.help } else { &definition.help[..1] };
    let mut text = String::new();
    for line in lines {
        // Continuation lines begin with their punctuation.
        let line = line.trim();
        if !text.is_empty() && !line.starts_with([':', ',', '.', ';']) {
            text.push(' ');
        }
        text.push_str(line);
    }
    if let Some(default) = definition.default_text() {
        let _ = write!(text, " [default: {default}]");
    }
    let choices: Vec<_> = definition.choices().into_iter().filter(|(_, help)| !help.is_empty()).collect();
    if is_long && !choices.is_empty() {
        text.push_str("\n\nPossible values:");
        for (name, help) in choices {
            let _ = write!(text, "\n- {name}: {help}");
        }
    } else if !choices.is_empty() {
        let names: Vec<_> = choices.into_iter().map(|(name, _)| name).collect();
        let _ = write!(text, " [{}]", names.join(", "));
    }
    option_names(&text)
}

/// The message of an error, with options for settings. Files and `-D` name settings by their keys, and so do messages about them.
pub(super) fn message(error: &Error) -> String {
    match error {
        Error::Setting(SettingError { origin: Provenance::File { .. } | Provenance::Define(_), .. }) => {
            error.to_string()
        }
        Error::Setting(SettingError { setting, why, .. }) if !setting.is_empty() => {
            option_names(&format!("`{setting}`: {why}"))
        }
        error => option_names(&error.to_string()),
    }
}

impl RenderOptions {
    /// The shot file that is named, whether it can be read or not.
    pub(super) fn shot_file(&self) -> Option<PathBuf> {
        self.shot_file_of(self.scenes().first().copied())
    }

    fn shot_file_of(&self, scene: Option<&OsStr>) -> Option<PathBuf> {
        let config = self.0.get_one::<OsString>("config").map(PathBuf::from);
        config.or_else(|| scene.map(PathBuf::from).filter(|scene| is_shot(scene)))
    }

    /// The scenes and shot files as they were typed.
    fn scenes(&self) -> Vec<&OsStr> {
        let typed = self.0.get_many::<OsString>("scene").unwrap_or_default();
        typed.map(OsString::as_os_str).collect()
    }

    /// Whether other scenes are rendered after one fails whose own settings cannot be read.
    pub(super) fn keeps_going(&self) -> bool {
        let definitions = Settings::read_definitions(self.0.get_many::<String>("set").unwrap_or_default());
        self.0.get_flag("keep_going") || definitions.is_ok_and(|settings| settings.values().keep_going)
    }

    /// The folders that are typed as permitted; none where an option is wrong, which is an error of every scene.
    pub(super) fn allowed_folders(&self) -> Vec<PathBuf> {
        let definitions = self.0.get_many::<String>("set").unwrap_or_default();
        let levels = [self.typed(None), Settings::read_definitions(definitions)];
        levels.into_iter().flatten().flat_map(|level| level.values().allow_dir).collect()
    }

    /// Whether nothing is to be rendered.
    pub(super) fn is_dry_run(&self) -> bool {
        self.0.get_flag("dry_run")
    }

    /// Whether the option of the argument `name` was given.
    pub(super) fn is_typed(&self, name: &str) -> bool {
        self.0.value_source(name) == Some(ValueSource::CommandLine)
    }

    /// The progress style that was typed, whatever is wrong with other settings.
    pub(super) fn typed_progress(&self) -> ProgressStyle {
        let typed = self.0.get_one::<OsString>("progress").and_then(|style| style.to_str());
        typed.and_then(ProgressStyle::of_name).unwrap_or_default()
    }

    /// Reads the shot file, if there is one, and merges all settings.
    ///
    /// # Errors
    /// Wrong settings, and a shot file that cannot be read.
    pub(super) fn settings(&self) -> Result<ShotSettings> {
        self.settings_of(self.scenes().first().copied())
    }

    /// Every scene and shot file that was typed, with its settings; one without a name where the settings name it.
    pub(super) fn shots(&self) -> Vec<NamedShot> {
        let scenes = self.scenes();
        if scenes.is_empty() {
            return vec![NamedShot { path: PathBuf::new(), settings: self.settings_of(None) }];
        }
        let named = |scene| NamedShot { path: PathBuf::from(scene), settings: self.settings_of(Some(scene)) };
        scenes.into_iter().map(named).collect()
    }

    fn settings_of(&self, scene: Option<&OsStr>) -> Result<ShotSettings> {
        let shot_file = self.shot_file_of(scene);
        let definitions = self.0.get_many::<String>("set").unwrap_or_default();
        // Errors of the file come first: it is wrong whatever overrides it.
        let file = shot_file.as_deref().map(Settings::read_shot).transpose()?;
        let typed = [self.typed(scene)?, Settings::read_definitions(definitions)?];
        let allowed: Vec<_> = typed.iter().flat_map(|level| level.values().allow_dir).collect();
        let levels = typed.into_iter().chain([file.unwrap_or_default()]);
        let shot = ShotSettings::merge(levels, shot_file)?;
        check_outputs(&shot.settings, &allowed)?;
        Ok(shot)
    }

    /// The settings that were typed as options, and the scene unless it is a shot file.
    fn typed(&self, scene: Option<&OsStr>) -> Result<Settings> {
        let mut settings = Settings::default();
        for definition in DEFINITIONS {
            let id = definition.name;
            if !self.is_typed(id) {
                continue;
            }
            let raw: Vec<&OsStr> = if definition.is_flag() {
                vec![OsStr::new("true")]
            } else if id == "scene" {
                scene.into_iter().collect()
            } else {
                self.0.get_raw(id).map(Iterator::collect).unwrap_or_default()
            };
            if id == "scene" && scene.is_some_and(|scene| is_shot(Path::new(scene))) {
                if self.0.value_source("config").is_some() {
                    let message = "--config: the scene is a shot file already; name one of the two";
                    return Err(Error::usage(message));
                }
                continue;
            }
            if id == "scene"
                && let Some(scene) = scene
            {
                self.check_no_value(scene)?;
            }
            for text in raw {
                definition.parse(&mut settings, text, &Provenance::CommandLine).map_err(|why| {
                    SettingError { setting: id.to_owned(), origin: Provenance::CommandLine, why }
                })?;
            }
        }
        settings.check_exclusions()?;
        Ok(settings)
    }

    /// Refuses a scene that is the value of an option whose value stands behind an equals sign.
    fn check_no_value(&self, scene: &OsStr) -> Result<()> {
        let is_typed =
            |definition: &&Definition| definition.value_alone.is_some() && self.is_typed(definition.name);
        let takes = |definition: &&Definition| definition.choices().iter().any(|(name, _)| scene == *name);
        match DEFINITIONS.iter().filter(is_typed).find(takes) {
            Some(definition) if !Path::new(scene).exists() => {
                let (option, value) = (definition.option_name(), scene.display());
                let why = format!("\"{value}\" would be a scene; write --{option}={value}");
                Err(Error::setting(definition.name, why))
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
