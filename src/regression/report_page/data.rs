//! What the page's script reads: the report as JSON, with pictures by number.

use serde::Serialize;

use super::super::comparison_text::short;
use super::super::{Check, ColorEncoding, Comparison, LayerDifference, PooledErrors, magma};
use super::page_images::{PageImages, worst_first};
use super::{EncodedImage, FrameStatus, ReportPage, ReportedFrame, ReportedShot};

/// All of it. Numbers that are not finite are `null`; those that people read are texts.
#[derive(Serialize)]
pub(super) struct PageData<'a> {
    schema: u32,
    title: &'a str,
    command: &'a str,
    can_approve: bool,
    /// Empty where nothing can be approved.
    accept_command: &'a str,
    folders: Vec<FolderData<'a>>,
    shots: Vec<ShotData<'a>>,
    budget_mebibytes: usize,
    /// Frames whose pictures had no room.
    left_out: usize,
    /// 256 colours of the heat map.
    magma: Vec<[u8; 3]>,
}

#[derive(Serialize)]
struct FolderData<'a> {
    name: &'a str,
    passed: usize,
    failed: usize,
    seconds: f64,
}

#[derive(Serialize)]
struct ShotData<'a> {
    name: &'a str,
    preset: &'a str,
    mean_limit: f64,
    tile_limit: f64,
    commands: &'a [(String, String)],
    frames: Vec<FrameData<'a>>,
    /// The index of the frame to begin with.
    worst: usize,
}

#[derive(Serialize)]
struct FrameData<'a> {
    name: &'a str,
    frame: Option<i64>,
    status: &'static str,
    messages: &'a [String],
    hash: Option<&'a str>,
    expected: Option<ImageData>,
    actual: Option<ImageData>,
    /// The number of the packed errors.
    errors: Option<usize>,
    /// Why its pictures had no room, if so.
    left_out: Option<LeftOutData<'a>>,
    comparison: Option<ComparisonData<'a>>,
}

#[derive(Serialize)]
struct LeftOutData<'a> {
    why: LeftOut,
    /// What shows it, if there is something.
    command: Option<&'a str>,
}

/// Why pictures are not on the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum LeftOut {
    /// They take more than the page has for all, so that no other page shows them either.
    TooLarge,
    /// Those of other frames came first.
    NoRoom,
}

#[derive(Serialize)]
struct ImageData {
    width: u32,
    height: u32,
    is_light: bool,
    /// The number of the packed colours.
    picture: usize,
}

#[derive(Serialize)]
struct ComparisonData<'a> {
    is_identical: bool,
    cause: Option<String>,
    rmse: Option<String>,
    psnr: Option<String>,
    flip: Option<PooledErrors>,
    checks: Vec<CheckData<'a>>,
    layers: &'a [LayerDifference],
}

#[derive(Serialize)]
struct CheckData<'a> {
    measure: &'a str,
    measured: String,
    limit: String,
    /// Measured as a share of the limit.
    share: f64,
    at: Option<(u32, u32)>,
    passes: bool,
}

impl<'a> PageData<'a> {
    pub(super) fn new(page: &'a ReportPage, places: &PageImages<'_>, budget_bytes: usize) -> Self {
        let shots = page.shots.iter().zip(&places.shots);
        Self {
            schema: 1,
            title: &page.title,
            command: &page.command,
            can_approve: !page.accept_command.is_empty(),
            accept_command: &page.accept_command,
            folders: page
                .folders
                .iter()
                .map(|folder| FolderData {
                    name: &folder.name,
                    passed: folder.passed,
                    failed: folder.failed,
                    seconds: folder.seconds,
                })
                .collect(),
            shots: shots.map(|(shot, places)| shot_data(page, shot, places)).collect(),
            budget_mebibytes: budget_bytes >> 20,
            left_out: places.shots.iter().flatten().filter(|place| place.left_out.is_some()).count(),
            magma: (0..=255).map(|step| magma(step as f32 / 255.0)).collect(),
        }
    }
}

/// Where the pictures of a frame are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct FrameImages {
    pub(super) expected: Option<usize>,
    pub(super) actual: Option<usize>,
    pub(super) errors: Option<usize>,
    pub(super) left_out: Option<LeftOut>,
}

fn shot_data<'a>(page: &'a ReportPage, shot: &'a ReportedShot, places: &[FrameImages]) -> ShotData<'a> {
    let frames = shot.frames.iter().zip(places);
    ShotData {
        name: &shot.name,
        preset: &shot.preset,
        mean_limit: shot.limits.mean_flip,
        tile_limit: shot.limits.tile_flip,
        commands: &shot.commands,
        frames: frames.map(|(frame, places)| frame_data(page, frame, *places)).collect(),
        worst: worst_first(&shot.frames).first().copied().unwrap_or_default(),
    }
}

fn frame_data<'a>(page: &'a ReportPage, frame: &'a ReportedFrame, places: FrameImages) -> FrameData<'a> {
    let picture = |picture: &Option<EncodedImage>, place: Option<usize>| {
        let (picture, place) = (picture.as_ref()?, place?);
        let (width, height) = picture.size;
        Some(ImageData { width, height, is_light: picture.encoding == ColorEncoding::Linear, picture: place })
    };
    FrameData {
        name: &frame.name,
        frame: frame.frame,
        status: status(frame.status),
        messages: &frame.messages,
        hash: frame.actual_hash.as_deref(),
        expected: picture(&frame.expected, places.expected),
        actual: picture(&frame.actual, places.actual),
        errors: places.errors,
        left_out: places.left_out.map(|why| left_out_data(page, &frame.name, why)),
        comparison: frame.comparison.as_ref().map(comparison_data),
    }
}

fn left_out_data<'a>(page: &'a ReportPage, name: &str, why: LeftOut) -> LeftOutData<'a> {
    let commands = page.frame_commands.get(name);
    let command = commands.and_then(|commands| match why {
        LeftOut::TooLarge => commands.heat_map.as_deref(),
        LeftOut::NoRoom => commands.alone.as_deref(),
    });
    LeftOutData { why, command }
}

fn comparison_data(comparison: &Comparison) -> ComparisonData<'_> {
    let square = comparison.root_mean_square;
    ComparisonData {
        is_identical: comparison.is_identical,
        cause: comparison.cause.as_ref().map(ToString::to_string),
        rmse: square.map(|found| short(found.error)),
        psnr: square.map(|found| format!("{:.1} dB", found.peak_ratio_decibels)),
        flip: comparison.flip,
        checks: comparison.checks.iter().map(check_data).collect(),
        layers: &comparison.layers,
    }
}

fn check_data(check: &Check) -> CheckData<'_> {
    CheckData {
        measure: &check.measure,
        measured: short(check.measured),
        limit: short(check.limit),
        share: check.measured / check.limit,
        at: check.at,
        passes: check.passes,
    }
}

/// As the script knows it.
pub(super) fn status(status: FrameStatus) -> &'static str {
    match status {
        FrameStatus::Passed => "passed",
        FrameStatus::Different => "different",
        FrameStatus::Missing => "missing",
        FrameStatus::Orphaned => "orphaned",
        FrameStatus::Broken => "broken",
    }
}
