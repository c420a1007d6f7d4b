//! `rayframe diff`: compares two images or two sequences within the limits of a preset.

mod maps;
mod page;
mod report;
mod text;

use std::path::{Path, PathBuf};

use clap::Args;

use crate::progress::{print_output, print_warning};
use rayframe::error::{Error, Result};
use rayframe::image_file::write_atomically;
use rayframe::regression::{FilePair, Image, PairedFiles, Preset, compare, pair_files, pixel_hash};

use maps::MapPattern;
use page::DiffPage;
use rayframe::settings as layer_options;
use report::{FrameReport, Report};

/// Options of `rayframe diff`.
#[derive(Clone, Debug, Args)]
pub(super) struct DiffArgs {
    /// The image (.exr, .png, .hdr), sequence (shot.####.exr, shot.%04d.exr) or folder to check
    actual: PathBuf,
    /// The reference, of the same kind; frames are matched by number
    reference: PathBuf,
    /// Limits on differences: exact, strict, visual or noisy (docs/regression.md lists every limit)
    #[arg(long, value_name = "PRESET", default_value = "visual", value_parser = preset)]
    preset: Preset,
    /// Compare only these layers: names between commas, such as beauty,depth, or light, data, crypto, all
    #[arg(long, value_name = "LIST", default_value = "all")]
    layers: String,
    /// Write FLIP of every pixel as colours; for sequences a name with the frame number, such as heat.####.png
    #[arg(long, value_name = "FILE.png", value_parser = clap::value_parser!(std::ffi::OsString))]
    heat_map: Option<std::ffi::OsString>,
    /// Write FLIP of every pixel as numbers, in a channel Y of floats
    #[arg(long, value_name = "FILE.exr", value_parser = clap::value_parser!(std::ffi::OsString))]
    flip_map: Option<std::ffi::OsString>,
    /// Write DIR/index.html: both images with a slider, flicker, exposure, heat map, graph and all measures, in one file
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Compares, prints, and returns whether everything is within the limits.
pub(super) fn run(args: &DiffArgs) -> Result<bool> {
    let paired = pair_files(&args.actual, &args.reference)?;
    let heat_map = args.heat_map.as_deref().map(|name| MapPattern::heat_map(name, &paired)).transpose()?;
    let flip_map = args.flip_map.as_deref().map(|name| MapPattern::flip_map(name, &paired)).transpose()?;
    let mut page = args.report.as_deref().map(DiffPage::new).transpose()?;
    let is_sequence = rayframe::regression::is_sequence(&args.actual);
    let mut frames = Vec::with_capacity(paired.pairs.len());
    for pair in &paired.pairs {
        let (report, map) = compared(args, pair, page.as_mut())?;
        for pattern in [&heat_map, &flip_map].into_iter().flatten() {
            match &map {
                Some(map) => write_atomically(&pattern.path(pair.frame), &pattern.encoded(map)?)?,
                None => print_warning(&format!(
                    "{} and {}: no map, because their sizes differ or they have no colours",
                    pair.actual.display(),
                    pair.reference.display()
                )),
            }
        }
        frames.push(report);
    }
    if let Some(page) = page {
        page.finish(args, &paired)?;
    }
    let report = Report::new(args.preset, frames, &paired);
    if args.json {
        let json = serde_json::to_string_pretty(&report)
            .map_err(|error| Error::Internal { message: error.to_string() })?;
        print_output(&json);
    } else {
        print_output(&text::text(&report, is_sequence));
    }
    Ok(report.same)
}

fn compared(
    args: &DiffArgs,
    pair: &FilePair,
    page: Option<&mut DiffPage>,
) -> Result<(FrameReport, Option<rayframe::regression::FlipMap>)> {
    let whole = (Image::read(&pair.actual)?, Image::read(&pair.reference)?);
    let layers = layer_options::aovs_in_files(&args.layers, &[whole.0.layers(), whole.1.layers()].concat())
        .map_err(Error::usage)?;
    // The page shows colours even where other layers are compared.
    let kept = page.is_some().then(|| whole.clone());
    let (actual, reference) = (whole.0.with_layers(&layers), whole.1.with_layers(&layers));
    let mut comparison = compare(&actual, &reference, &args.preset.limits());
    let map = comparison.flip_map.take();
    if let (Some(page), Some(whole)) = (page, kept) {
        page.add(pair, [&whole.0, &whole.1], &comparison, map.as_ref());
    }
    let hashes = [pixel_hash(&actual), pixel_hash(&reference)];
    Ok((FrameReport::new(pair, comparison, hashes), map))
}

fn preset(text: &str) -> std::result::Result<Preset, String> {
    Preset::of_name(text).ok_or_else(|| format!("write {}", Preset::NAMES))
}

/// A path for people and for JSON.
fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// Files that have no counterpart: those missing in `actual`, those missing in `reference`.
fn missing(paired: &PairedFiles) -> (Vec<String>, Vec<String>) {
    let list = |files: &[PathBuf]| files.iter().map(|file| shown(file)).collect();
    (list(&paired.only_in_reference), list(&paired.only_in_actual))
}
