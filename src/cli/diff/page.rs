//! The report page of `rayframe diff`: the compared images, and commands that repeat the comparison.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::args::{DiffArgs, shown};
use rayframe::error::{Error, Result};
use rayframe::regression::suite::shell_word;
use rayframe::regression::{
    Comparison, EncodedImage, FilePair, FlipMap, FolderSummary, FrameCommands, FrameResult, FrameStatus,
    Image, ImageBudget, NamedCommand, PairedFiles, ReportPage, ShotResult, Verdict, VerdictCounts,
    check_report_place, frame_number, is_sequence, write_report,
};

/// A report page under construction.
pub(super) struct DiffPage {
    path: PathBuf,
    frames: Vec<FrameResult>,
    image_budget: ImageBudget,
}

impl DiffPage {
    /// Checks that the page can be written.
    pub(super) fn new(folder: &Path, overwrites: bool) -> Result<Self> {
        Ok(Self {
            path: report_file(folder, overwrites)?,
            frames: Vec::new(),
            image_budget: ImageBudget::new(),
        })
    }

    /// Adds two compared files. Images are kept where they are not identical.
    pub(super) fn add(
        &mut self,
        pair: &FilePair,
        images: [&Image; 2],
        comparison: &Comparison,
        map: Option<&FlipMap>,
    ) {
        let (passes, is_identical) = (comparison.passes(), comparison.verdict() == Verdict::Identical);
        let [actual, expected] =
            images.map(|image| if is_identical { None } else { EncodedImage::new(image) });
        let actual = match map {
            Some(map) => actual.map(|image| image.with_errors(map)),
            None => actual,
        };
        let largest_measure = comparison.largest_measure().into_iter().collect();
        let frame = FrameResult {
            name: stem(&pair.actual),
            frame: pair.frame,
            status: if passes { FrameStatus::Passed } else { FrameStatus::Different },
            messages: if passes { largest_measure } else { comparison.failures() },
            comparison: Some(Comparison { flip_map: None, ..comparison.clone() }),
            expected,
            actual,
            reference_hash: None,
            actual_hash: None,
        };
        self.push(frame);
    }

    /// Adds the files without a counterpart, and writes the page.
    pub(super) fn finish(mut self, args: &DiffArgs, paired: &PairedFiles) -> Result<()> {
        for file in &paired.only_in_actual {
            self.add_unpaired(file, FrameStatus::Missing)?;
        }
        for file in &paired.only_in_reference {
            self.add_unpaired(file, FrameStatus::Orphaned)?;
        }
        if self.frames.iter().all(|frame| frame.frame.is_some()) {
            self.frames.sort_by_key(|frame| frame.frame);
        }
        let counts: VerdictCounts = self.frames.iter().map(FrameResult::verdict).collect();
        let mut page = ReportPage {
            title: format!("{} against {}", shown(&args.actual), shown(&args.reference)),
            command: command(args, &args.actual, &args.reference, &["--report", &folder(args)]),
            folders: vec![FolderSummary { counts, ..FolderSummary::default() }],
            shots: Vec::new(),
            shot_commands: BTreeMap::new(),
            frame_commands: frame_commands(args, paired, &self.frames),
            asset: None,
            accept_command: String::new(),
        };
        if counts.worst() != Verdict::Identical {
            let name = shown(&args.actual);
            page.shot_commands.insert(name.clone(), commands(args, paired, &self.frames));
            page.shots.push(ShotResult {
                name,
                path: args.actual.clone(),
                preset: args.limits.preset_name(args.preset),
                limits: args.limits.limits(args.preset),
                frames: self.frames,
                warnings: Vec::new(),
                not_kept: Vec::new(),
                seconds: 0.0,
                is_cached: false,
            });
        }
        write_report(&page, &self.path)
    }

    fn add_unpaired(&mut self, file: &Path, status: FrameStatus) -> Result<()> {
        let image = EncodedImage::new(&Image::read(file)?);
        let is_missing = status == FrameStatus::Missing;
        let message = if is_missing { "has no reference" } else { "is a reference without an image" };
        let (actual, expected) = if is_missing { (image, None) } else { (None, image) };
        let message = format!("{} {message}", shown(file));
        let result = FrameResult::new(stem(file), frame_number(file), status, message);
        self.push(FrameResult { expected, actual, ..result });
        Ok(())
    }

    fn push(&mut self, mut frame: FrameResult) {
        self.image_budget.admit(&mut frame);
        self.frames.push(frame);
    }
}

/// The file of a page in `folder`, after a check that it can be written.
///
/// # Errors
/// [`Error::Usage`] for an empty name, and those of [`check_report_place`].
pub(super) fn report_file(folder: &Path, overwrites: bool) -> Result<PathBuf> {
    if folder.as_os_str().is_empty() {
        return Err(Error::usage("--report: name a folder"));
    }
    let path = folder.join("index.html");
    check_report_place(&path, overwrites)?;
    Ok(path)
}

/// Commands that repeat the comparison as JSON, for one frame, as a heat map and as a page.
fn commands(args: &DiffArgs, paired: &PairedFiles, frames: &[FrameResult]) -> Vec<NamedCommand> {
    let again = |options: &[&str]| command(args, &args.actual, &args.reference, options);
    let mut commands = Vec::new();
    if is_sequence(&args.actual)
        && let Some(pair) = worst_pair(paired, frames)
    {
        commands.push(NamedCommand("One frame alone, here the worst".to_owned(), alone(args, pair)));
    }
    commands.push(NamedCommand("All measures as JSON".to_owned(), again(&["--json"])));
    let heat_map = if is_sequence(&args.actual) { "heat.####.png" } else { "heat.png" };
    commands.push(NamedCommand("The heat map as an image".to_owned(), again(&["--heat-map", heat_map])));
    commands.push(NamedCommand("This page again".to_owned(), again(&["--report", &folder(args)])));
    commands
}

/// Commands that show pairs whose images are omitted from this page. A pair without FLIP has no heat map.
fn frame_commands(
    args: &DiffArgs,
    paired: &PairedFiles,
    frames: &[FrameResult],
) -> BTreeMap<String, FrameCommands> {
    let pairs: BTreeMap<_, _> = paired.pairs.iter().map(|pair| (stem(&pair.actual), pair)).collect();
    let differing = frames.iter().filter(|frame| frame.verdict() != Verdict::Identical);
    let known = differing.filter_map(|frame| {
        let pair = pairs.get(&frame.name)?;
        let has_flip = frame.comparison.as_ref().is_some_and(|comparison| comparison.flip.is_some());
        let heat_map = || command(args, &pair.actual, &pair.reference, &["--heat-map", "heat.png"]);
        let commands = FrameCommands {
            alone: is_sequence(&args.actual).then(|| alone(args, pair)),
            heat_map: has_flip.then(heat_map),
        };
        Some((frame.name.clone(), commands))
    });
    known.collect()
}

/// A page of one frame, in a folder below this page's.
fn alone(args: &DiffArgs, pair: &FilePair) -> String {
    let folder = args.report.as_deref().unwrap_or(Path::new("report")).join("frame");
    command(args, &pair.actual, &pair.reference, &["--report", &shown(&folder)])
}

fn worst_pair<'a>(paired: &'a PairedFiles, frames: &[FrameResult]) -> Option<&'a FilePair> {
    let severity = |pair: &FilePair| {
        let name = stem(&pair.actual);
        let frame =
            frames.iter().find(|frame| frame.name == name && frame.verdict() != Verdict::Identical)?;
        let tile = frame.comparison.as_ref()?.flip.map_or(0.0, |flip| flip.tile);
        Some((frame.verdict(), tile))
    };
    let worst = paired.pairs.iter().filter_map(|pair| Some((severity(pair)?, pair)));
    let worst = worst.max_by(|(a, _), (b, _)| a.0.cmp(&b.0).then_with(|| a.1.total_cmp(&b.1)));
    worst.map(|(_, pair)| pair)
}

/// The command that compares two files by the same limits, quoted for a shell.
pub(super) fn command(args: &DiffArgs, actual: &Path, reference: &Path, options: &[&str]) -> String {
    let (actual, reference) = (shown(actual), shown(reference));
    let own = [args.limits.words(), args.assets.words()].concat();
    let mut words = vec!["rayframe", "diff", &actual, &reference, "--preset", args.preset.name()];
    words.extend(own.iter().map(String::as_str));
    if args.aovs != "all" {
        words.extend(["--aovs", &args.aovs]);
    }
    words.extend(args.fail_on.words());
    words.extend(options);
    words.into_iter().map(shell_word).collect::<Vec<_>>().join(" ")
}

fn folder(args: &DiffArgs) -> String {
    args.report.as_deref().map(shown).unwrap_or_default()
}

/// A path without its ending.
fn stem(path: &Path) -> String {
    shown(&path.with_extension(""))
}
