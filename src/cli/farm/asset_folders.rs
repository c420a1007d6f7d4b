//! Folders of files that settings name, which may be elsewhere on a worker: environment images, plates and camera paths.

use std::ffi::OsString;

use rayframe::error::Result;
use rayframe::regression::suite::shell_quoted;
use rayframe::settings::{BackgroundSource, EnvironmentSource, Settings};

use super::not_unicode::not_unicode;

/// Settings that name files, each with the name of its folder in templates.
const NAMES: [(&str, &str); 3] =
    [("env", "EnvFolder"), ("background", "BackgroundFolder"), ("camera_path", "CameraPathFolder")];
/// What stands before names of plates.
const PLATE: &str = "plate:";

/// A setting that names files in a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct AssetFolder {
    /// The setting.
    pub(super) setting: &'static str,
    /// Name of the folder in templates.
    pub(super) parameter: &'static str,
    /// The folder on this machine.
    pub(super) folder: String,
    /// What the value of the setting has before the folder and after it.
    pub(super) around: (String, String),
    /// Whether the value is a pattern.
    pub(super) is_pattern: bool,
}

impl AssetFolder {
    /// The environment variable that replaces the folder.
    pub(super) fn variable(&self) -> String {
        format!("RAYFRAME_{}_FOLDER", self.setting.to_uppercase())
    }

    /// Lines of a shell script that set a variable to the folder.
    pub(super) fn shell_lines(&self) -> String {
        let Self { setting, .. } = self;
        let line = format!("{setting}_folder=${{{}:-{}}}\n", self.variable(), shell_quoted(&self.folder));
        if !self.is_pattern {
            return line;
        }
        format!(
            "{line}{setting}_folder=$(printf '%s.' \"${setting}_folder\" | sed 's/[%#{{]/%&/g')\n\
             {setting}_folder=${{{setting}_folder%.}}\n"
        )
    }

    /// The option with its value, as words of a shell script.
    pub(super) fn shell_option(&self) -> String {
        let Self { setting, around: (before, after), .. } = self;
        let option = setting.replace('_', "-");
        format!(" --{option}={}\"${setting}_folder\"/{}", shell_quoted(before), shell_quoted(after))
    }
}

/// Takes the settings that name files out of `settings`, with their folders.
///
/// # Errors
/// [`Error::Usage`](rayframe::error::Error::Usage) for names that are not Unicode.
pub(super) fn take_asset_folders(settings: &mut Settings) -> Result<Vec<AssetFolder>> {
    let values = settings.values();
    let of_env = values.env.as_ref().and_then(environment_name);
    let of_background = match &values.background {
        background @ BackgroundSource::Plate(_) => Some((background.to_text(), None)),
        background => background.environment().and_then(environment_name),
    };
    let of_camera_path =
        values.camera_path.map(|source| (source.to_text(), Some(source.file.as_os_str().len())));

    let mut taken = Vec::new();
    for ((setting, parameter), named) in NAMES.into_iter().zip([of_env, of_background, of_camera_path]) {
        let Some((text, file_length)) = named else { continue };
        let text = text.to_str().ok_or_else(|| not_unicode(&text.to_string_lossy()))?;
        let before = if file_length.is_none() && text.starts_with(PLATE) { PLATE } else { "" };
        let name = &text[before.len()..];
        // Of a pattern the folder, as far as it is the same for all frames.
        let fixed = file_length.or_else(|| name.find(['#', '%', '{'])).unwrap_or(name.len());
        let Some(slash) = name.get(..fixed).and_then(|fixed| fixed.rfind('/')) else { continue };
        let folder = if slash == 0 { "/" } else { &name[..slash] };
        taken.push(AssetFolder {
            setting,
            parameter,
            folder: folder.to_owned(),
            around: (before.to_owned(), name[slash + 1..].to_owned()),
            is_pattern: file_length.is_none(),
        });
        settings.clear(setting);
    }
    Ok(taken)
}

/// The text of an environment that names a file, and the length of that name: what follows may hold slashes, too.
fn environment_name(source: &EnvironmentSource) -> Option<(OsString, Option<usize>)> {
    let EnvironmentSource::File(file, _) = source else { return None };
    Some((source.to_text(), Some(file.as_os_str().len())))
}

#[cfg(test)]
mod tests {
    use std::ffi::OsStr;

    use rayframe::error::Provenance;

    use super::*;

    fn taken(setting: &str, text: &str) -> Option<AssetFolder> {
        let mut settings = Settings::default();
        settings.set(setting, OsStr::new(text), &Provenance::Default).unwrap();
        let taken = take_asset_folders(&mut settings).unwrap().pop();
        assert_eq!(settings.origin_of(setting).is_none(), taken.is_some(), "{text}");
        taken
    }

    #[test]
    fn folders_are_split_from_names_and_what_surrounds_them() {
        for (setting, text, folder, before, after) in [
            ("env", "/a/b/sky.hdr", "/a/b", "", "sky.hdr"),
            ("env", "/a/50%/it's@.exr@-90", "/a/50%", "", "it's@.exr@-90"),
            ("env", "/sky.hdr", "/", "", "sky.hdr"),
            ("background", "/a/sky.hdr@12.5", "/a", "", "sky.hdr@12.5"),
            ("background", "/a/b/plate.####.png", "/a/b", "", "plate.####.png"),
            ("background", "plate:/a/b/plate.exr", "/a/b", "plate:", "plate.exr"),
            ("background", "/a/100%%/s####/p.png", "/a", "", "100%%/s####/p.png"),
            ("camera_path", "/a/walk.toml", "/a", "", "walk.toml"),
            ("camera_path", "/a/cams.glb#left/eye", "/a", "", "cams.glb#left/eye"),
        ] {
            let found = taken(setting, text).unwrap();
            assert_eq!(
                (&*found.folder, &*found.around.0, &*found.around.1),
                (folder, before, after),
                "{text}"
            );
        }
        for (setting, text) in
            [("env", "studio"), ("env", "1,2,3"), ("background", "white"), ("background", "none")]
        {
            assert_eq!(taken(setting, text), None);
        }
    }

    #[cfg(unix)]
    #[test]
    fn shells_put_the_folder_of_the_worker_in_place() {
        let run = |found: &AssetFolder, folder: Option<&str>| {
            let script = format!("set -u\n{}printf '<%s>'{}", found.shell_lines(), found.shell_option());
            let mut shell = std::process::Command::new("sh");
            shell.args(["-c", &script]);
            if let Some(folder) = folder {
                shell.env(found.variable(), folder);
            }
            String::from_utf8(shell.output().unwrap().stdout).unwrap()
        };
        let env = taken("env", "/it's \"a\"/sky.hdr@90").unwrap();
        assert_eq!(run(&env, None), "<--env=/it's \"a\"/sky.hdr@90>");
        assert_eq!(run(&env, Some("/mnt/$x #1")), "<--env=/mnt/$x #1/sky.hdr@90>");
        let plate = taken("background", "plate:/a/p.exr").unwrap();
        assert_eq!(run(&plate, Some("/mnt/50% #1")), "<--background=plate:/mnt/50%% %#1/p.exr>");
        let path = taken("camera_path", "/a/cams.glb#eye").unwrap();
        assert_eq!(path.variable(), "RAYFRAME_CAMERA_PATH_FOLDER");
        assert_eq!(run(&path, Some("/b")), "<--camera-path=/b/cams.glb#eye>");
    }
}
