//! Comparison of two versions of an asset: their contents, and renders of both.

use rayframe::asset_diff::{AssetPair, MaterialNames, View};
use rayframe::cancel::CancelFlag;
use rayframe::error::{Provenance, Result};
use rayframe::regression::{
    Comparison, FilePair, Image, Limits, PairedFiles, Preset, ShotResult, Verdict, compare, pixel_hash,
};

use super::args::{DiffArgs, refuse_for_assets};
use super::asset_page::AssetPage;
use super::asset_text;
use super::report::{AssetReport, FrameReport, Report};
use super::result_files::{ResultFiles, check_names};
use crate::cli::warnings::report_warnings;
use crate::progress::{print_json, print_output};

/// Compares, prints, and returns whether all images are within the limits and no content is lost.
pub(super) fn run(args: &DiffArgs) -> Result<bool> {
    refuse_for_assets(args)?;
    check_names(args, &[args.actual.clone(), args.reference.clone()], &[])?;
    let mut page = ResultFiles::new(args)?.map(AssetPage::new);
    let mut settings = args.assets.settings()?;
    settings.set("max_memory", args.bytes_a_side().to_string().as_ref(), &Provenance::CommandLine)?;
    let pair = AssetPair::open(&args.actual, &args.reference, &settings, &CancelFlag::new())?;
    check_names(args, &pair.files(), &[])?;
    if args.warns_first() {
        warn(args, &pair)?;
    }
    let difference = pair.difference();
    let losses: Vec<_> = difference.losses().filter(|change| args.assets.fails(change)).collect();
    let losses: Vec<_> = losses.into_iter().map(rayframe::asset_diff::Change::loss_text).collect();
    let mut frames = Vec::new();
    for view in pair.views() {
        let mut shot = page.is_some().then(|| shot(args, view));
        pair.render(view, |frame, images, names| {
            let (report, comparison) = compared(args, (&pair, names), (view, frame), &images);
            if let (Some(page), Some(shot)) = (&page, &mut shot) {
                shot.frames.push(page.frame(view, frame, &images, comparison));
            }
            frames.push(report);
            Ok(())
        })?;
        if let (Some(page), Some(shot)) = (&mut page, shot) {
            page.push(shot);
        }
    }
    if let Some(page) = page {
        page.finish(args, difference, losses.clone())?;
    }
    let mut report = Report::new(args, frames, &PairedFiles::default());
    report.limits = limits(args);
    if !losses.is_empty() {
        report.same = false;
        report.verdict = Verdict::Failed;
    }
    if !args.warns_first() && args.prints(report.verdict) {
        warn(args, &pair)?;
    }
    if args.json {
        let [actual, reference] = pair.facts();
        report.asset = Some(AssetReport { losses, changes: &difference.changes, actual, reference });
        print_json(&report.json()?);
    } else if args.prints(report.verdict) {
        print_output(&asset_text::text(args, &report, difference, &losses));
    }
    Ok(!args.fail_on.value().fails(report.verdict))
}

/// Prints what of the scenes is not honoured.
fn warn(args: &DiffArgs, pair: &AssetPair) -> Result<()> {
    let mut scenes = [&args.actual, &args.reference].into_iter().zip(pair.warnings());
    scenes.try_for_each(|(path, warnings)| report_warnings(path, warnings, false))
}

fn compared(
    args: &DiffArgs,
    (assets, names): (&AssetPair, &MaterialNames<'_>),
    (view, frame): (&View, i64),
    images: &[Image; 2],
) -> (FrameReport, Comparison) {
    let [actual, reference] = images;
    let mut comparison = comparison(actual, reference, args);
    comparison.name_materials(actual, reference, &|id| names.of_id(id));
    comparison.tell_hidden_changes(actual, reference);
    // Told once a clip.
    if view.frames.first() == Some(&frame) {
        comparison.scene_changes.extend(assets.motion_change(view));
    }
    let pair = FilePair {
        frame: (view.frames.len() > 1).then_some(frame),
        actual: args.actual.clone(),
        reference: args.reference.clone(),
    };
    let hashes = [pixel_hash(actual), pixel_hash(reference)];
    let told = Comparison { flip_map: None, ..comparison.clone() };
    let mut report = FrameReport::new(&pair, told, hashes);
    report.view = Some(view.name.clone());
    (report, comparison)
}

/// Compares two renders by [`limits`]. What explains a failure are also the layers beyond the preset's limits on data.
fn comparison(actual: &Image, reference: &Image, args: &DiffArgs) -> Comparison {
    let comparison = compare(actual, reference, &limits(args));
    if comparison.passes() || args.preset == Preset::Exact {
        return comparison;
    }
    let cause = compare(actual, reference, &args.limits.limits(args.preset)).cause;
    Comparison { cause, ..comparison }
}

/// The limits of the preset. Ids and albedo explain differences and do not fail by themselves, but for the preset `exact`: other
/// vertices and smaller textures change them along edges where nobody sees it.
fn limits(args: &DiffArgs) -> Limits {
    let limits = args.limits.limits(args.preset);
    if args.preset == Preset::Exact { limits } else { Limits { data_share: f64::INFINITY, ..limits } }
}

/// The result of a view without its frames.
fn shot(args: &DiffArgs, view: &View) -> ShotResult {
    ShotResult {
        name: view.name.clone(),
        path: args.actual.clone(),
        preset: args.limits.preset_name(args.preset),
        limits: limits(args),
        frames: Vec::new(),
        warnings: Vec::new(),
        not_kept: Vec::new(),
        seconds: 0.0,
        is_cached: false,
        is_unopened: false,
    }
}
