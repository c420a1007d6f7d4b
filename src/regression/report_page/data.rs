//! The JSON that the page's script reads: the result tree, commands, and the indices of images on the page.

use serde::Serialize;

use super::page::{AssetChanges, FolderSummary, NamedCommand, ReportPage};
use super::page_images::{FrameImages, Omission, PageImages, worst_first};
use crate::regression::ColorEncoding;
use crate::regression::encoded_image::EncodedImage;
use crate::regression::heat_map::magma;
use crate::regression::presets::Limits;
use crate::regression::result::{FrameResult, ShotResult};

/// The whole of it. Numbers that are not finite are `null`.
#[derive(Serialize)]
pub(super) struct PageData<'a> {
    schema: u32,
    title: &'a str,
    command: &'a str,
    can_approve: bool,
    /// Empty where nothing can be approved.
    accept_command: &'a str,
    asset: Option<&'a AssetChanges>,
    folders: &'a [FolderSummary],
    shots: Vec<ShotData<'a>>,
    budget_mebibytes: usize,
    /// Frames whose images are omitted.
    omitted: usize,
    /// The 256 colours of the heat map.
    magma: Vec<[u8; 3]>,
}

#[derive(Serialize)]
struct ShotData<'a> {
    name: &'a str,
    preset: &'a str,
    limits: &'a Limits,
    commands: &'a [NamedCommand],
    frames: Vec<FrameData<'a>>,
    /// Index of the frame that is shown first.
    worst: usize,
}

/// A frame's result, and where its images are.
#[derive(Serialize)]
struct FrameData<'a> {
    #[serde(flatten)]
    result: &'a FrameResult,
    expected: Option<ImageData>,
    actual: Option<ImageData>,
    /// Index of the packed errors among the page's images.
    errors: Option<usize>,
    omitted: Option<OmissionData<'a>>,
}

/// Why images are omitted, and a command that shows them.
#[derive(Serialize)]
struct OmissionData<'a> {
    why: Omission,
    command: Option<&'a str>,
}

#[derive(Serialize)]
struct ImageData {
    width: u32,
    height: u32,
    is_light: bool,
    /// Index of the packed colours among the page's images.
    index: usize,
}

impl<'a> PageData<'a> {
    pub(super) fn new(page: &'a ReportPage, images: &PageImages<'_>, budget_bytes: usize) -> Self {
        let shots = page.shots.iter().zip(&images.shots);
        Self {
            schema: 1,
            title: &page.title,
            command: &page.command,
            can_approve: !page.accept_command.is_empty(),
            accept_command: &page.accept_command,
            asset: page.asset.as_ref(),
            folders: &page.folders,
            shots: shots.map(|(shot, images)| shot_data(page, shot, images)).collect(),
            budget_mebibytes: budget_bytes >> 20,
            omitted: images.shots.iter().flatten().filter(|frame| frame.omission.is_some()).count(),
            magma: (0..=255).map(|step| magma(step as f32 / 255.0)).collect(),
        }
    }
}

fn shot_data<'a>(page: &'a ReportPage, shot: &'a ShotResult, images: &[FrameImages]) -> ShotData<'a> {
    let frames = shot.frames.iter().zip(images);
    ShotData {
        name: &shot.name,
        preset: &shot.preset,
        limits: &shot.limits,
        commands: page.shot_commands.get(&shot.name).map_or(&[], Vec::as_slice),
        frames: frames.map(|(frame, images)| frame_data(page, frame, *images)).collect(),
        worst: worst_first(&shot.frames).first().copied().unwrap_or_default(),
    }
}

fn frame_data<'a>(page: &'a ReportPage, frame: &'a FrameResult, images: FrameImages) -> FrameData<'a> {
    let image = |image: &Option<EncodedImage>, index: Option<usize>| {
        let (image, index) = (image.as_ref()?, index?);
        let (width, height) = image.size;
        Some(ImageData { width, height, is_light: image.encoding == ColorEncoding::Linear, index })
    };
    FrameData {
        result: frame,
        expected: image(&frame.expected, images.expected),
        actual: image(&frame.actual, images.actual),
        errors: images.errors,
        omitted: images.omission.map(|why| omission_data(page, &frame.name, why)),
    }
}

fn omission_data<'a>(page: &'a ReportPage, name: &str, why: Omission) -> OmissionData<'a> {
    let commands = page.frame_commands.get(name);
    let command = commands.and_then(|commands| match why {
        Omission::TooLarge => commands.heat_map.as_deref(),
        Omission::NoSpace => commands.alone.as_deref(),
    });
    OmissionData { why, command }
}
