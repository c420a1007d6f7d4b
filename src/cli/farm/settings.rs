//! The settings of a shot that its tasks share, and those that each task has of its own.

use std::ffi::OsStr;

use rayframe::error::{Error, Provenance, Result};
use rayframe::image_file::ExrCompression;
use rayframe::settings::{DenoiserKind, Integrator, OutputFormat, OutputPattern, Settings};
use rayframe::shot::{RenderJob, ShotSettings, resolved_settings};

use super::asset_folders::{AssetFolder, take_asset_folders};
use super::not_unicode::not_unicode;
use super::options::{Division, OF_ALL_FRAMES};
use super::parts::{sample_ranges, tiles};

/// Settings that each task has of its own, that shot files may not have, or that only matter to a terminal.
const OF_TASKS: [&str; 17] = [
    "output",
    "show",
    "resume",
    "overwrite",
    "all",
    "start",
    "end",
    "step",
    "frames",
    "threads",
    "max_memory",
    "oidn",
    "asset_cache",
    "asset_cache_size",
    "progress",
    "quiet",
    "verbose",
];

/// Refuses files that every task would write, and `show`.
///
/// # Errors
/// [`Error::Setting`] with the first of them.
pub(super) fn check_shared(shot: &ShotSettings) -> Result<()> {
    if shot.values.show {
        let why = "has no meaning for farms, as tasks have no terminal; leave it out";
        return Err(shot.settings.error("show", why));
    }
    let refused = |name: &str, remedy: &str| {
        let why = "is one file of all frames, which the tasks of a farm cannot write together";
        Err(shot.settings.error(name, format!("{why}; {remedy}")))
    };
    let is_given = |name: &&&str| shot.settings.origin_of(name).is_some();
    if let Some(name) = OF_ALL_FRAMES.iter().find(is_given) {
        return refused(name, "leave it out");
    }
    if shot.values.output.as_ref().is_some_and(OutputPattern::is_movie) {
        return refused("output", "name frames such as shot.####.exr, and make the movie of them");
    }
    Ok(())
}

/// The shot as tasks render it: without write-behind unless it is asked for, so that a killed worker loses one frame at most, and within
/// `limit_bytes` where these are less than its own limit.
pub(super) fn of_tasks(shot: &ShotSettings, limit_bytes: Option<u64>) -> Result<ShotSettings> {
    let mut settings = shot.settings.clone();
    if settings.origin_of("write_behind").is_none() {
        settings.set("write_behind", OsStr::new("off"), &Provenance::Default).map_err(Error::from)?;
    }
    if let Some(limit) = limit_bytes {
        let limit = limit.to_string();
        settings.set("max_memory", OsStr::new(&limit), &Provenance::Default).map_err(Error::from)?;
    }
    ShotSettings::merge([settings], shot.shot_file.clone())
}

/// A shot file of what all tasks have in common, and the folders of files that settings name, which are left out of it.
pub(super) fn shot_file(shot: &ShotSettings, job: &RenderJob) -> Result<(String, Vec<AssetFolder>)> {
    let mut settings = resolved_settings(shot, std::slice::from_ref(job));
    for name in OF_TASKS {
        settings.clear(name);
    }
    let asset_folders = take_asset_folders(&mut settings)?;
    let toml = settings.to_toml();
    match toml.lines().find(|line| line.starts_with('#') && line.ends_with("for it is not Unicode")) {
        Some(line) => Err(not_unicode(line.split_whitespace().nth(1).unwrap_or_default())),
        None => Ok((format!("{toml}\n"), asset_folders)),
    }
}

/// The shot with the settings of its first part, so that what cannot be divided is refused with the reason of `render`.
pub(super) fn of_first_part(shot: &ShotSettings, division: Division) -> Result<ShotSettings> {
    let Division::Samples(count) = division else { return Ok(shot.clone()) };
    refuse_own_division(&shot.settings, "sample_range", "--sample-ranges")?;
    if shot.values.integrator != Integrator::Path {
        return Err(Error::usage(
            "--sample-ranges divides the samples of paths; add --integrator path, or use --tiles",
        ));
    }
    let samples = shot.values.samples;
    let (first, last) = sample_ranges(samples, count).first().copied().unwrap_or_default();
    let mut part = shot.clone();
    let mut outcome = Ok(());
    part.change(|settings| {
        let range = format!("{first}-{last}");
        outcome = settings.set("sample_range", OsStr::new(&range), &Provenance::Default);
    });
    outcome.map_err(Error::from)?;
    Ok(part)
}

/// Refuses a crop or a sample range of the whole job where its tasks have their own.
fn refuse_own_division(settings: &Settings, name: &str, option: &str) -> Result<()> {
    match settings.origin_of(name) {
        None => Ok(()),
        Some(_) => Err(settings.error(name, format!("cannot be combined with {option}, which makes them"))),
    }
}

/// Refuses a time limit of tiles. Sample ranges exclude it as `render` does.
fn refuse_time_limit(settings: &Settings) -> Result<()> {
    if settings.origin_of("time_limit").is_none() {
        return Ok(());
    }
    let why = "cannot be combined with --tiles, each of which would end with another number of samples; \
        --noise makes them end alike";
    Err(settings.error("time_limit", why))
}

/// Name for people and options of each part of a still; empty where tasks render whole frames.
///
/// # Errors
/// [`Error::Usage`] for what `rayframe merge` cannot join.
pub(super) fn parts(
    shot: &ShotSettings,
    job: &RenderJob,
    division: Division,
) -> Result<Vec<(String, String)>> {
    let refuse_others = |option| {
        refuse_own_division(&shot.settings, "crop", option)?;
        check_merge(shot, job, option)
    };
    match division {
        Division::Frames => Ok(Vec::new()),
        Division::Tiles(columns, rows) => {
            refuse_others("--tiles")?;
            refuse_time_limit(&shot.settings)?;
            let tiles = tiles(job.sequence.render.resolution, (columns, rows)).into_iter();
            let crops = tiles.map(|[x0, y0, x1, y1]| format!("{x0},{y0},{x1},{y1}"));
            Ok(crops.map(|crop| (format!("tile {crop}"), format!("--crop={crop}"))).collect())
        }
        Division::Samples(count) => {
            refuse_others("--sample-ranges")?;
            let ranges = sample_ranges(shot.values.samples, count).into_iter();
            let ranges = ranges.map(|(first, last)| format!("{first}-{last}"));
            Ok(ranges.map(|range| (format!("samples {range}"), format!("--sample-range={range}"))).collect())
        }
    }
}

fn check_merge(shot: &ShotSettings, job: &RenderJob, option: &str) -> Result<()> {
    let refuse = |why: &str| Err(Error::usage(format!("{option} {why}")));
    let sequence = &job.sequence;
    if sequence.frames.len() != 1 {
        return refuse("divides a still; choose one frame with -f, or divide the sequence with --chunk");
    }
    if sequence.output.format() != OutputFormat::Exr || sequence.preview {
        return refuse("makes EXR files only; leave previews and other formats out");
    }
    if sequence.exr.is_split
        || matches!(sequence.exr.compression, ExrCompression::Dwaa | ExrCompression::Dwab)
    {
        return refuse("needs one lossless EXR file a frame; leave --split-aovs, dwaa and dwab out");
    }
    if shot.values.denoise != DenoiserKind::None {
        return refuse("cannot be denoised, as pixels depend on their neighbours; denoise the merged image");
    }
    Ok(())
}
