//! `rayframe diff`: compares two images, two sequences or two versions of an asset within the limits of a preset.

mod args;
mod asset_options;
mod asset_page;
mod asset_text;
mod assets;
mod limits;
mod maps;
mod page;
mod report;
mod result_files;
mod text;

use std::path::PathBuf;

use crate::progress::{print_json, print_output, print_warning};
use rayframe::error::{Error, Result};
use rayframe::image::PixelWindow;
use rayframe::regression::{FilePair, FlipMap, Image, PairedFiles, compare, pair_files, pixel_hash};

pub(super) use args::DiffArgs;
use asset_options::is_scene;
use maps::MapPattern;
use page::DiffPage;
use rayframe::settings as layer_options;
use report::{FrameReport, Report};
use result_files::{ResultFiles, check_names};

/// Compares, prints, and returns whether no verdict is one that `--fail-on` names.
pub(super) fn run(args: &DiffArgs) -> Result<bool> {
    match [&args.actual, &args.reference].map(|path| is_scene(path)) {
        [true, true] => assets::run(args),
        [false, false] => run_images(args),
        _ => Err(Error::usage(format!(
            "{} and {}: one is a scene and the other is not; name two of a kind",
            args.actual.display(),
            args.reference.display()
        ))),
    }
}

fn run_images(args: &DiffArgs) -> Result<bool> {
    args.assets.refuse_for_images()?;
    let paired = pair_files(&args.actual, &args.reference)?;
    let heat_map = args.heat_map.as_deref().map(|name| MapPattern::heat_map(name, &paired)).transpose()?;
    let flip_map = args.flip_map.as_deref().map(|name| MapPattern::flip_map(name, &paired)).transpose()?;
    let mut patterns: Vec<_> = [heat_map, flip_map].into_iter().flatten().collect();
    let files: Vec<_> = patterns.iter().map(|pattern| pattern.files(&paired)).collect();
    check_names(args, &inputs(&paired), &files)?;
    for pattern in &patterns {
        pattern.check_files(&paired, args.overwrite)?;
    }
    let is_sequence = rayframe::regression::is_sequence(&args.actual)?;
    let mut page = ResultFiles::new(args)?.map(|files| DiffPage::new(files, &paired, is_sequence));
    let mut frames = Vec::with_capacity(paired.pairs.len());
    for pair in &paired.pairs {
        let (report, map) = compared(args, pair, page.as_mut())?;
        if let Some((map, windows)) = &map {
            for pattern in &mut patterns {
                pattern.write(&paired, pair.frame, (map, *windows))?;
            }
        } else if !patterns.is_empty() && args.prints(report.verdict) {
            print_warning(&text::no_map(pair, &report.comparison));
        }
        frames.push(report);
    }
    if let Some(page) = page {
        page.finish(args, &paired)?;
    }
    let report = Report::new(args, frames, &paired);
    if args.json {
        print_json(&report.json()?);
    } else if args.prints(report.verdict) {
        print_output(&text::text(args, &report, is_sequence));
    }
    Ok(!args.fail_on.value().fails(report.verdict))
}

/// All files that are compared or have no counterpart.
fn inputs(paired: &PairedFiles) -> Vec<PathBuf> {
    let pairs = paired.pairs.iter().flat_map(|pair| [&pair.actual, &pair.reference]);
    pairs.chain(&paired.only_in_actual).chain(&paired.only_in_reference).cloned().collect()
}

/// A map, and the display and the data window of its reference.
type WindowedMap = (FlipMap, [PixelWindow; 2]);

fn compared(
    args: &DiffArgs,
    pair: &FilePair,
    page: Option<&mut DiffPage>,
) -> Result<(FrameReport, Option<WindowedMap>)> {
    let read = |path: &std::path::Path| Image::read_within(path, args.bytes_a_side());
    let whole = (read(&pair.actual)?, read(&pair.reference)?);
    let layers = layer_options::aovs_in_files(&args.aovs, &[whole.0.layers(), whole.1.layers()].concat())
        .map_err(Error::usage)?;
    // The page shows colours even where other layers are compared.
    let kept = page.is_some().then(|| whole.clone());
    let (actual, reference) = (whole.0.with_layers(&layers), whole.1.with_layers(&layers));
    let mut comparison = compare(&actual, &reference, &args.limits.limits(args.preset));
    let map = comparison.flip_map.take();
    if let (Some(page), Some(whole)) = (page, kept) {
        page.add(pair, [&whole.0, &whole.1], &comparison, map.as_ref());
    }
    let hashes = [pixel_hash(&actual), pixel_hash(&reference)];
    let windows = [reference.display_window, reference.data_window];
    Ok((FrameReport::new(pair, comparison, hashes), map.map(|map| (map, windows))))
}
