//! Options for the comparison of two scenes.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::Args;
use rayframe::asset_diff::{Change, GroupKind};
use rayframe::error::{Error, Provenance, Result};
use rayframe::settings::Settings;

/// Settings that are not given: a size that shows what a viewer shows, and AOVs that tell causes apart.
const DEFAULTS: [(&str, &str); 2] = [("resolution", "480x270"), ("aovs", "object_id,material_id,albedo")];
/// Groups whose items can be lost, with their names for `--allow-lost`.
const LOSSES: [(&str, GroupKind); 7] = [
    ("nodes", GroupKind::Nodes),
    ("morph-targets", GroupKind::Meshes),
    ("variants", GroupKind::Variants),
    ("clips", GroupKind::Clips),
    ("cameras", GroupKind::Cameras),
    ("lights", GroupKind::Lights),
    ("image-based-lights", GroupKind::ImageLights),
];

/// Options that apply where both arguments are scenes.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Two versions of an asset")]
pub(in crate::cli) struct AssetOptions {
    /// Size of the rendered images [default: 480x270]
    #[arg(short, long, value_name = "WxH")]
    resolution: Option<OsString>,
    /// Samples per pixel [default: 4]
    #[arg(long, value_name = "N")]
    samples: Option<OsString>,
    /// Light of both scenes, such as studio or an image [default: each scene's own, or the studio if the reference has none]
    #[arg(long, value_name = "ENV")]
    env: Option<OsString>,
    /// Kinds of content that may be lost: nodes, morph-targets, variants, clips, cameras, lights, image-based-lights
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = loss)]
    allow_lost: Vec<&'static str>,
    /// Permit files of the scenes in this folder, which is outside their own
    #[arg(long, value_name = "DIR")]
    allow_dir: Vec<OsString>,
}

impl AssetOptions {
    /// The settings of the renders.
    ///
    /// # Errors
    /// [`Error::Setting`] for a wrong value.
    pub(super) fn settings(&self) -> Result<Settings> {
        let mut settings = Settings::default();
        for (name, value) in DEFAULTS {
            settings.set(name, OsStr::new(value), &Provenance::Default)?;
        }
        for (name, value) in self.typed() {
            settings.set(name, value, &Provenance::CommandLine)?;
        }
        Ok(settings)
    }

    /// Whether a loss fails the comparison.
    pub(super) fn fails(&self, change: &Change) -> bool {
        let allowed = LOSSES.iter().filter(|(name, _)| self.allow_lost.contains(name));
        change.is_loss && !allowed.map(|(_, group)| *group).any(|group| group == change.group)
    }

    /// The options as they may be typed.
    pub(super) fn words(&self) -> Vec<String> {
        let typed = self.typed().into_iter();
        let mut words: Vec<_> = typed
            .flat_map(|(name, value)| [format!("--{}", name.replace('_', "-")), value.display().to_string()])
            .collect();
        if !self.allow_lost.is_empty() {
            words.extend(["--allow-lost".to_owned(), self.allow_lost.join(",")]);
        }
        words
    }

    /// Refuses options that images do not have.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub(super) fn refuse_for_images(&self) -> Result<()> {
        match self.words().first() {
            Some(option) => {
                Err(Error::usage(format!("{option} applies to two scenes (.glb, .gltf), not to images")))
            }
            None => Ok(()),
        }
    }

    fn typed(&self) -> Vec<(&'static str, &OsStr)> {
        let options = [("resolution", &self.resolution), ("samples", &self.samples), ("env", &self.env)];
        let single = options.into_iter().filter_map(|(name, value)| Some((name, value.as_deref()?)));
        single.chain(self.allow_dir.iter().map(|folder| ("allow_dir", folder.as_os_str()))).collect()
    }
}

/// Whether a path names a scene.
pub(super) fn is_scene(path: &Path) -> bool {
    let is_ending =
        |ending: &OsStr| ending.eq_ignore_ascii_case("glb") || ending.eq_ignore_ascii_case("gltf");
    !path.is_dir() && path.extension().is_some_and(is_ending)
}

fn loss(text: &str) -> std::result::Result<&'static str, String> {
    let names = LOSSES.map(|(name, _)| name);
    names.into_iter().find(|name| *name == text).ok_or_else(|| format!("write some of {}", names.join(", ")))
}
