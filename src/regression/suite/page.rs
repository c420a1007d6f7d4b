//! The report page of a suite: its failures and changes, and commands for them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::Suite;
use super::names::{changed_path, pending_path, reference_path};
use super::shell::{name_and_options, shell_word};
use crate::regression::report_page::{FolderSummary, NamedCommand, ReportPage};
use crate::regression::result::{FrameResult, ShotResult, SuiteResult};
use crate::regression::{Preset, Verdict};

/// What the commands of a page repeat.
#[derive(Clone, Copy, Debug)]
pub struct PageCommands<'a> {
    /// The command that ran the suite.
    pub test: &'a str,
    /// Folders of `--allow-dir`, for references, report and cache outside the suite's folder.
    pub allowed: &'a [PathBuf],
    /// Whether there are pending images. Without them the page has no commands that accept or reject them.
    pub keeps_pending: bool,
}

/// The page of `result`, into which the images of failures and changes move.
pub fn report_page(suite: &Suite, result: SuiteResult, page: &PageCommands<'_>) -> ReportPage {
    let keeps_pending = page.keeps_pending;
    let options = suite_options(&suite.file, page.allowed.iter().map(PathBuf::as_path));
    let folders = folders(&result);
    // Identical images are there only where they were asked for.
    let has_images = |shot: &ShotResult| shot.frames.iter().any(|frame| frame.expected.is_some());
    let is_shown = |shot: &ShotResult| shot.verdict() != Verdict::Identical || has_images(shot);
    let mut shots: Vec<ShotResult> = result.shots.into_iter().filter(is_shown).collect();
    let mut shot_commands: BTreeMap<_, _> = shots
        .iter()
        .map(|shot| (shot.name.clone(), commands(suite, shot, (&options, keeps_pending))))
        .collect();
    for frame in result.orphaned {
        if keeps_pending {
            shot_commands.insert(frame.name.clone(), vec![removal_command(&options, &frame)]);
        }
        shots.push(orphaned(suite, frame));
    }
    shots.sort_by(|a, b| b.verdict().cmp(&a.verdict()).then_with(|| a.name.cmp(&b.name)));
    // Without pending images, approvals are accepted on another machine, where absolute paths would be wrong.
    let absolute =
        |path: &Path| path.canonicalize().ok().filter(|_| keeps_pending).unwrap_or_else(|| path.to_owned());
    let allowed: Vec<_> = page.allowed.iter().map(|folder| absolute(folder)).collect();
    let options_anywhere = suite_options(&absolute(&suite.file), allowed.iter().map(PathBuf::as_path));
    ReportPage {
        title: suite_title(suite),
        command: page.test.to_owned(),
        folders,
        shots,
        shot_commands,
        frame_commands: BTreeMap::new(),
        asset: None,
        accept_command: format!(
            "rayframe accept{} --approvals approvals.json {options_anywhere}",
            // A page of a build server is read where it was unpacked.
            if keeps_pending { "" } else { " --from FOLDER_OF_THIS_PAGE" },
        ),
    }
}

/// The name of the suite's folder, which is the title of its report.
pub fn suite_title(suite: &Suite) -> String {
    let folder = suite.file.canonicalize().ok().and_then(|file| Some(file.parent()?.to_owned()));
    let name = folder.as_deref().and_then(Path::file_name).unwrap_or_default();
    name.display().to_string()
}

/// Counts of each folder, sorted by name.
pub fn folders(result: &SuiteResult) -> Vec<FolderSummary> {
    let mut folders = BTreeMap::<&str, FolderSummary>::new();
    let mut count = |folder, frame: &FrameResult| {
        let summary = folders.entry(folder).or_default();
        summary.counts.add(frame.verdict());
    };
    for shot in &result.shots {
        shot.frames.iter().for_each(|frame| count(shot.folder(), frame));
    }
    result.orphaned.iter().for_each(|frame| count(frame.folder(), frame));
    for shot in &result.shots {
        folders.entry(shot.folder()).or_default().seconds += shot.seconds;
    }
    folders.into_iter().map(|(name, summary)| FolderSummary { name: name.to_owned(), ..summary }).collect()
}

fn commands(suite: &Suite, shot: &ShotResult, (options, keeps_pending): (&str, bool)) -> Vec<NamedCommand> {
    let command = |verb: &str| command_of(verb, &shot.name, options);
    let mut commands = vec![NamedCommand("Test again".to_owned(), command("test"))];
    let first_of = |kind| shot.frames.iter().find(|frame| frame.kind() == kind);
    let [different, changed, missing] = ["different", "changed", "missing"].map(first_of);
    // `rayframe diff` takes presets only, no single limits.
    if let (Some(frame), Some(preset), true) =
        (different.or(changed), Preset::of_name(&shot.preset), keeps_pending)
    {
        let pending = if frame.passes() { changed_path } else { pending_path };
        let (new, old) =
            (pending(&suite.references, &frame.name), reference_path(&suite.references, &frame.name));
        let which = if shot.frames.len() > 1 { format!(", here {}", frame.name) } else { String::new() };
        commands.push(NamedCommand(
            format!("Compare in numbers{which}"),
            format!("rayframe diff {} {} --preset {}", quoted(&new), quoted(&old), preset.name()),
        ));
    }
    if keeps_pending && different.or(changed).or(missing).is_some() {
        commands.push(NamedCommand("Accept".to_owned(), command("accept")));
        commands.push(NamedCommand("Reject".to_owned(), command("reject")));
    }
    commands
}

/// An orphaned reference as a shot of its own.
fn orphaned(suite: &Suite, frame: FrameResult) -> ShotResult {
    ShotResult {
        name: frame.name.clone(),
        path: reference_path(&suite.references, &frame.name),
        preset: suite.limits.name(),
        limits: suite.limits.limits,
        frames: vec![frame],
        warnings: Vec::new(),
        not_kept: Vec::new(),
        seconds: 0.0,
        is_cached: false,
        is_unopened: false,
    }
}

fn removal_command(options: &str, frame: &FrameResult) -> NamedCommand {
    NamedCommand("Remove it".to_owned(), command_of("accept", &format!("{}.exr", frame.name), options))
}

/// A command about a shot or image of the suite that these options name.
fn command_of(verb: &str, name: &str, options: &str) -> String {
    format!("rayframe {verb} {}", name_and_options(name, options))
}

/// The options that name a suite, quoted for a shell.
fn suite_options<'a>(suite: &'a Path, allowed: impl Iterator<Item = &'a Path>) -> String {
    let allowed = allowed.map(|folder| ("--allow-dir", folder));
    let options = std::iter::once(("--suite", suite)).chain(allowed);
    let words: Vec<_> = options.map(|(option, path)| format!("{option} {}", quoted(path))).collect();
    words.join(" ")
}

fn quoted(path: &Path) -> String {
    shell_word(&path.display().to_string())
}
