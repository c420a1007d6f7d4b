//! The command line of `rayframe diff`.

use std::path::{Path, PathBuf};

use clap::Args;
use rayframe::error::{Error, Result};
use rayframe::regression::{Preset, Verdict};
use rayframe::shot::memory_limit::default_max_memory_bytes;

use super::super::fail_on::FailOnOption;
use super::asset_options::AssetOptions;
use super::limits::LimitOptions;

/// Options of `rayframe diff`.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct DiffArgs {
    /// The image (.exr, .png, .hdr), sequence (shot.####.exr, shot.%04d.exr), folder or scene (.glb, .gltf) to check
    pub(super) actual: PathBuf,
    /// The reference, of the same kind; frames are matched by number
    pub(super) reference: PathBuf,
    /// Limits on differences: exact, strict, visual or noisy (docs/regression.md lists every limit)
    #[arg(long, value_name = "PRESET", default_value = "visual", value_parser = preset)]
    pub(super) preset: Preset,
    /// Compare only these AOVs: names separated by commas, such as beauty,depth, or light, data, crypto, all
    #[arg(long, alias = "layers", value_name = "LIST", default_value = "all")]
    pub(super) aovs: String,
    /// Write FLIP of every pixel as colours; for sequences a name with the frame number, such as heat.####.png
    #[arg(long, value_name = "FILE.png", value_parser = clap::value_parser!(std::ffi::OsString))]
    pub(super) heat_map: Option<std::ffi::OsString>,
    /// Write FLIP of every pixel as numbers, in a channel Y of floats
    #[arg(long, value_name = "FILE.exr", value_parser = clap::value_parser!(std::ffi::OsString))]
    pub(super) flip_map: Option<std::ffi::OsString>,
    /// Write DIR/index.html: both images with a slider, flicker, exposure, heat map, graph and all measures, in one file
    #[arg(long, value_name = "DIR")]
    pub(super) report: Option<PathBuf>,
    /// Write a summary in Markdown for pull requests, with thumbnails beside it in the folder FILE.md.files
    #[arg(long, value_name = "FILE.md")]
    pub(super) summary: Option<PathBuf>,
    #[command(flatten)]
    pub(super) fail_on: FailOnOption,
    /// Memory limit, such as 8G; half of it for each image or scene [default: 80 % of the available memory]
    #[arg(long, value_name = "SIZE", value_parser = rayframe::settings::parse::memory_size)]
    max_memory: Option<u64>,
    /// Replace files that this program did not write for the same purpose
    #[arg(long)]
    pub(super) overwrite: bool,
    /// Print JSON
    #[arg(long)]
    pub(super) json: bool,
    /// Print nothing where nothing fails
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    pub(super) limits: LimitOptions,
    #[command(flatten)]
    pub(super) assets: AssetOptions,
}

impl DiffArgs {
    /// Memory of one of the two images or scenes, bytes.
    pub(super) fn bytes_a_side(&self) -> u64 {
        self.max_memory.unwrap_or_else(default_max_memory_bytes) / 2
    }

    /// Whether warnings are printed before the verdict is known.
    pub(super) fn warns_first(&self) -> bool {
        !self.quiet
    }

    /// Whether a comparison with this verdict is printed as text.
    pub(super) fn prints(&self, verdict: Verdict) -> bool {
        !self.quiet || self.fail_on.value().fails(verdict)
    }
}

/// Refuses options that scenes do not have.
///
/// # Errors
/// [`Error::Usage`].
pub(super) fn refuse_for_assets(args: &DiffArgs) -> Result<()> {
    let options = [
        ("--aovs", args.aovs != "all"),
        ("--heat-map", args.heat_map.is_some()),
        ("--flip-map", args.flip_map.is_some()),
    ];
    match options.iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => Err(Error::usage(format!(
            "{option} applies to images, not to scenes; --report shows heat maps of both scenes"
        ))),
        None => Ok(()),
    }
}

fn preset(text: &str) -> std::result::Result<Preset, String> {
    Preset::of_name(text).ok_or_else(|| format!("write {}", Preset::NAMES))
}

/// A path as text, for messages and JSON.
pub(super) fn shown(path: &Path) -> String {
    path.display().to_string()
}
