//! Options of `rayframe farm`: those of `rayframe render`, and how the job is divided.

use std::path::PathBuf;

use clap::{ArgMatches, Args, Command, FromArgMatches};

use rayframe::error::Error;
use rayframe::settings::parse as options;

use super::super::render_options::{NamedShot, RenderOptions};
use super::engine::Engine;

/// Options of `rayframe render` that the short help lists.
const LISTED: [&str; 7] = ["scene", "config", "output", "frames", "resolution", "samples", "threads"];
/// Options that have no meaning here, and why.
const REFUSED: [(&str, &str); 4] = [
    ("dry_run", "farm renders nothing: look at the files of --out-dir instead"),
    ("show", "tasks have no terminal to show frames in"),
    ("resume", "tasks always keep the whole frames of an earlier run"),
    ("progress", "the engine decides how its tasks report"),
];

/// Settings whose files are made of all frames, which are refused.
pub(super) const OF_ALL_FRAMES: [&str; 4] = ["movie", "contact_sheet", "stats", "manifest"];
/// Help of options with other defaults.
const OWN_HELP: [(&str, &str); 3] = [
    ("output", "Output name: shot.####.exr, shot.png [default: <scene>.####.exr]"),
    ("threads", "Threads of a task, and cores that it requests [default: 4]"),
    ("max_memory", "Memory limit of a task, such as 8G [default: four fifths of --memory]"),
];

/// Options of `rayframe farm`: writes job files, and submits nothing.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct FarmArgs {
    /// The engine that the job is written for
    pub(super) engine: Engine,
    #[command(flatten)]
    pub(super) render: SharedOptions,
    /// Folder of the job files, on storage that the workers share; with several shots, of a folder for each
    #[arg(long, value_name = "DIR", help_heading = "Job")]
    pub(super) out_dir: PathBuf,
    /// Frames a task [default: 10, or what takes five minutes by --cost]
    #[arg(long, value_name = "N", value_parser = |text: &str| options::whole::<u32>(text, 1, 1_000_000), help_heading = "Job")]
    pub(super) chunk: Option<u32>,
    /// Make chunks of equal cost, from the --stats file of a run of some frames, at any resolution
    #[arg(long, value_name = "STATS.json", help_heading = "Job")]
    pub(super) cost: Option<PathBuf>,
    /// Give each of N tasks every Nth frame, instead of frames that follow each other
    #[arg(long, help_heading = "Job")]
    pub(super) interleaved: bool,
    /// Divide a still into tiles, and merge them
    #[arg(long, value_name = "XxY", value_parser = grid, conflicts_with_all = ["chunk", "cost", "interleaved", "sample_ranges"], help_heading = "Job")]
    pub(super) tiles: Option<(u32, u32)>,
    /// Divide the samples of a still into N ranges, and merge them
    #[arg(long, value_name = "N", value_parser = |text: &str| options::whole::<u32>(text, 1, 10_000), conflicts_with_all = ["chunk", "cost", "interleaved"], help_heading = "Job")]
    pub(super) sample_ranges: Option<u32>,
    /// Memory that a task requests [default: one and a half times the estimate, and 128 MiB]
    #[arg(long, value_name = "SIZE", value_parser = options::memory_size, help_heading = "Job")]
    pub(super) memory: Option<u64>,
    /// How often a task is repeated after a failure that may pass
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = |text: &str| options::whole::<u32>(text, 0, 1_000_000), help_heading = "Job")]
    pub(super) retries: u32,
    /// Most tasks that run at once [default: all]
    #[arg(long, value_name = "N", value_parser = |text: &str| options::whole::<u32>(text, 1, 1_000_000), help_heading = "Job")]
    pub(super) at_most: Option<u32>,
    /// Rayframe on the workers [default: rayframe, or for parallel the program that writes the job]
    #[arg(long, value_name = "PATH", help_heading = "Job")]
    pub(super) program: Option<String>,
    /// Kubernetes: image of the container [default: rayframe:<version>]
    #[arg(long, value_name = "IMAGE", help_heading = "Job")]
    pub(super) image: Option<String>,
    /// Kubernetes: mount a volume claim at a path
    #[arg(long = "claim", value_name = "NAME=PATH", value_parser = claim, help_heading = "Job")]
    pub(super) claims: Vec<(String, String)>,
}

/// What the tasks of a job have of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Division {
    /// Frames of a sequence.
    Frames,
    /// Columns and rows of a still.
    Tiles(u32, u32),
    /// Ranges of the samples of a still.
    Samples(u32),
}

impl FarmArgs {
    /// Refuses options without a meaning here, and those that the engine's job files have no place for.
    ///
    /// # Errors
    /// [`Error::Usage`] with the first of them.
    pub(super) fn check(&self) -> Result<(), Error> {
        if let Some((name, why)) = REFUSED.into_iter().find(|(name, _)| self.render.is_typed(name)) {
            return Err(Error::usage(format!("--{} has no meaning here: {why}", name.replace('_', "-"))));
        }
        let given = [("--image", self.image.is_some()), ("--claim", !self.claims.is_empty())];
        match given.into_iter().find(|(_, is_given)| *is_given && self.engine != Engine::K8s) {
            Some((option, _)) => {
                let engine = self.engine.name();
                Err(Error::usage(format!("{option} applies to k8s only; leave it out for {engine}")))
            }
            None => Ok(()),
        }
    }

    /// What the tasks have of their own.
    pub(super) fn division(&self) -> Division {
        match (self.tiles, self.sample_ranges) {
            (Some((columns, rows)), _) => Division::Tiles(columns, rows),
            (None, Some(count)) => Division::Samples(count),
            (None, None) => Division::Frames,
        }
    }
}

/// `4x2`.
fn grid(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|side| (1..=100).contains(side));
    let sides = text.split_once('x').and_then(|(columns, rows)| Some((side(columns)?, side(rows)?)));
    sides.ok_or_else(|| "write columns and rows from 1 to 100, such as 4x2".to_owned())
}

/// `NAME=/PATH`.
fn claim(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, path)) if !name.is_empty() && path.starts_with('/') => {
            Ok((name.to_owned(), path.to_owned()))
        }
        _ => Err("write the name of the claim and an absolute path, such as projects=/projects".to_owned()),
    }
}

/// The typed options of `rayframe render`.
#[derive(Clone, Debug)]
pub(super) struct SharedOptions(RenderOptions);

impl SharedOptions {
    /// Every scene and shot file that was typed.
    pub(super) fn shots(&self) -> Vec<NamedShot> {
        self.0.shots()
    }

    /// The folders that are typed as permitted.
    pub(super) fn allowed_folders(&self) -> Vec<PathBuf> {
        self.0.allowed_folders()
    }

    /// Whether the option of the argument `name` was given.
    fn is_typed(&self, name: &str) -> bool {
        self.0.is_typed(name)
    }
}

impl FromArgMatches for SharedOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        RenderOptions::from_arg_matches(matches).map(Self)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.0.update_from_arg_matches(matches)
    }
}

impl Args for SharedOptions {
    fn augment_args(command: Command) -> Command {
        let names = RenderOptions::augment_args(Command::new("render"));
        let names: Vec<String> = names.get_arguments().map(|arg| arg.get_id().to_string()).collect();
        let command = names.into_iter().fold(RenderOptions::augment_args(command), |command, name| {
            let is_listed = LISTED.contains(&name.as_str());
            let is_refused =
                REFUSED.iter().any(|(refused, _)| *refused == name) || OF_ALL_FRAMES.contains(&name.as_str());
            command.mut_arg(name, |arg| arg.hide_short_help(!is_listed).hide(is_refused))
        });
        OWN_HELP.into_iter().fold(command, |command, (name, help)| {
            command.mut_arg(name, |arg| arg.help(help).long_help(help))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}
