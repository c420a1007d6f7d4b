//! The report page of `rayframe diff`: the compared images, and commands that repeat the comparison.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::args::{DiffArgs, shown};
use super::result_files::{ResultFiles, title};
use rayframe::error::Result;
use rayframe::regression::suite::shell_word;
use rayframe::regression::{
    Comparison, EncodedImage, FilePair, FlipMap, FolderSummary, FrameCommands, FrameResult, FrameStatus,
    Image, ImageBudget, NamedCommand, PairedFiles, ReportPage, ShotResult, Verdict, VerdictCounts,
    frame_number,
};

/// A report page under construction.
pub(super) struct DiffPage {
    files: ResultFiles,
    names: FrameNames,
    frames: Vec<FrameResult>,
    image_budget: ImageBudget,
    /// Whether sequences are compared.
    is_sequence: bool,
}

impl DiffPage {
    /// A page without images.
    pub(super) fn new(files: ResultFiles, paired: &PairedFiles, is_sequence: bool) -> Self {
        let names = FrameNames::new(paired);
        Self { files, names, frames: Vec::new(), image_budget: ImageBudget::new(), is_sequence }
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
            name: self.names.of(&pair.actual),
            frame: pair.frame,
            status: if passes { FrameStatus::Passed } else { FrameStatus::Different },
            messages: if passes { largest_measure } else { comparison.failures() },
            comparison: Some(Comparison { flip_map: None, ..comparison.clone() }),
            expected,
            actual,
            reference_hash: None,
            actual_hash: None,
            value_hash: None,
        };
        self.push(frame);
    }

    /// Adds the files without a counterpart, and writes page and summary.
    pub(super) fn finish(mut self, args: &DiffArgs, paired: &PairedFiles) -> Result<()> {
        for file in &paired.only_in_actual {
            self.add_unpaired(args, file, FrameStatus::Missing)?;
        }
        for file in &paired.only_in_reference {
            self.add_unpaired(args, file, FrameStatus::Orphaned)?;
        }
        if self.frames.iter().all(|frame| frame.frame.is_some()) {
            self.frames.sort_by_key(|frame| frame.frame);
        }
        let counts: VerdictCounts = self.frames.iter().map(FrameResult::verdict).collect();
        let mut page = ReportPage {
            title: title(args),
            command: command(args, &args.actual, &args.reference, &["--report", &folder(args)]),
            folders: vec![FolderSummary { counts, ..FolderSummary::default() }],
            shots: Vec::new(),
            shot_commands: BTreeMap::new(),
            frame_commands: self.frame_commands(args, paired),
            asset: None,
            accept_command: String::new(),
        };
        if counts.worst() != Verdict::Identical {
            let name = shown(&args.actual);
            page.shot_commands.insert(name.clone(), self.commands(args, paired));
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
                is_unopened: false,
            });
        }
        self.files.write(&page)
    }

    fn add_unpaired(&mut self, args: &DiffArgs, file: &Path, status: FrameStatus) -> Result<()> {
        let image = EncodedImage::new(&Image::read_within(file, args.bytes_a_side())?);
        let is_missing = status == FrameStatus::Missing;
        let message = if is_missing { "has no reference" } else { "is a reference without an image" };
        let (actual, expected) = if is_missing { (image, None) } else { (None, image) };
        let message = format!("{} {message}", shown(file));
        let result = FrameResult::new(self.names.of(file), frame_number(file), status).because(message);
        self.push(FrameResult { expected, actual, ..result });
        Ok(())
    }

    fn push(&mut self, mut frame: FrameResult) {
        self.image_budget.admit(&mut frame);
        self.frames.push(frame);
    }

    /// Commands that repeat the comparison as JSON, for one frame, as a heat map and as a page.
    fn commands(&self, args: &DiffArgs, paired: &PairedFiles) -> Vec<NamedCommand> {
        let again = |options: &[&str]| command(args, &args.actual, &args.reference, options);
        let mut commands = Vec::new();
        if self.is_sequence
            && let Some(pair) = self.worst_pair(paired)
        {
            commands.push(NamedCommand("One frame alone, here the worst".to_owned(), alone(args, pair)));
        }
        commands.push(NamedCommand("All measures as JSON".to_owned(), again(&["--json"])));
        let heat_map = if self.is_sequence { "heat.####.png" } else { "heat.png" };
        commands.push(NamedCommand("The heat map as an image".to_owned(), again(&["--heat-map", heat_map])));
        commands.push(NamedCommand("This page again".to_owned(), again(&["--report", &folder(args)])));
        commands
    }

    /// Commands that show pairs whose images are omitted from this page. A pair without FLIP has no heat map.
    fn frame_commands(&self, args: &DiffArgs, paired: &PairedFiles) -> BTreeMap<String, FrameCommands> {
        let known = self.differing(paired).map(|(frame, pair)| {
            let has_flip = frame.comparison.as_ref().is_some_and(|comparison| comparison.flip.is_some());
            let heat_map = || command(args, &pair.actual, &pair.reference, &["--heat-map", "heat.png"]);
            let commands = FrameCommands {
                alone: self.is_sequence.then(|| alone(args, pair)),
                heat_map: has_flip.then(heat_map),
            };
            (frame.name.clone(), commands)
        });
        known.collect()
    }

    fn worst_pair<'a>(&self, paired: &'a PairedFiles) -> Option<&'a FilePair> {
        let severity = |frame: &FrameResult| {
            let tile = frame.comparison.as_ref()?.flip.map_or(0.0, |flip| flip.tile);
            Some((frame.verdict(), tile))
        };
        let worst = self.differing(paired).filter_map(|(frame, pair)| Some((severity(frame)?, pair)));
        let worst = worst.max_by(|(a, _), (b, _)| a.0.cmp(&b.0).then_with(|| a.1.total_cmp(&b.1)));
        worst.map(|(_, pair)| pair)
    }

    /// The pairs that are not identical, in the order of the files.
    fn differing<'a>(&self, paired: &'a PairedFiles) -> impl Iterator<Item = (&FrameResult, &'a FilePair)> {
        let frames: BTreeMap<_, _> = self.frames.iter().map(|frame| (frame.name.as_str(), frame)).collect();
        paired.pairs.iter().filter_map(move |pair| {
            let frame = *frames.get(self.names.of(&pair.actual).as_str())?;
            (frame.verdict() != Verdict::Identical).then_some((frame, pair))
        })
    }
}

/// A page of one frame, in a folder below this page's.
fn alone(args: &DiffArgs, pair: &FilePair) -> String {
    let folder = args.report.as_deref().unwrap_or(Path::new("report")).join("frame");
    command(args, &pair.actual, &pair.reference, &["--report", &shown(&folder)])
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

/// Names of frames: their paths without the ending, which is kept where several files differ in nothing else.
struct FrameNames {
    /// Paths without their endings that several files have.
    shared: BTreeSet<PathBuf>,
}

impl FrameNames {
    fn new(paired: &PairedFiles) -> Self {
        let actual = paired.pairs.iter().map(|pair| &pair.actual);
        let files = actual.chain(&paired.only_in_actual).chain(&paired.only_in_reference);
        let mut seen = BTreeSet::new();
        let stems = files.map(|file| file.with_extension(""));
        Self { shared: stems.filter(|stem| !seen.insert(stem.clone())).collect() }
    }

    fn of(&self, file: &Path) -> String {
        let stem = file.with_extension("");
        shown(if self.shared.contains(&stem) { file } else { &stem })
    }
}
