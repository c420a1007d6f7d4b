//! The report of a suite: which of its results the page shows, and with which commands.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::{FolderSummary, FrameStatus, Preset, ReportPage, ReportedFrame, ReportedShot};
use super::names::{pending_path, reference_path};
use super::result::{folder_of, is_passed};
use super::shell::shell_word;
use super::{ShotResult, Suite, SuiteResult};

/// What the page of `result` shows; the pictures of failures move there. `command` made it. Where nothing is kept, no command says how to
/// accept it.
pub fn report_page(suite: &Suite, result: SuiteResult, command: &str, keeps_pending: bool) -> ReportPage {
    let folders = folders(&result);
    let failed = result.shots.into_iter().filter(|shot| !shot.passes());
    let mut shots: Vec<ReportedShot> = failed.map(|shot| reported(suite, shot, keeps_pending)).collect();
    shots.extend(result.orphaned.into_iter().map(|picture| orphaned(suite, picture, keeps_pending)));
    shots.sort_by(|a, b| a.name.cmp(&b.name));
    // Where nothing is kept, it is accepted elsewhere, in another folder.
    let whole_path = suite.file.canonicalize().ok().filter(|_| keeps_pending);
    let suite_path = whole_path.as_deref().unwrap_or(&suite.file);
    ReportPage {
        title: title(suite),
        command: command.to_owned(),
        folders,
        shots,
        accept_command: format!("rayframe accept --approvals approvals.json --suite {}", file(suite_path)),
        frame_commands: BTreeMap::new(),
    }
}

/// The name of the suite's folder.
fn title(suite: &Suite) -> String {
    let folder = suite.file.canonicalize().ok().and_then(|file| Some(file.parent()?.to_owned()));
    let name = folder.as_deref().and_then(Path::file_name).unwrap_or_default();
    name.display().to_string()
}

/// How each folder did, in the order of names.
pub fn folders(result: &SuiteResult) -> Vec<FolderSummary> {
    let mut folders = BTreeMap::<&str, FolderSummary>::new();
    let mut count = |folder, picture: &ReportedFrame| {
        let summary = folders.entry(folder).or_default();
        *if is_passed(picture) { &mut summary.passed } else { &mut summary.failed } += 1;
    };
    for shot in &result.shots {
        shot.pictures.iter().for_each(|picture| count(shot.folder(), picture));
    }
    result.orphaned.iter().for_each(|picture| count(folder_of(&picture.name), picture));
    for shot in &result.shots {
        folders.entry(shot.folder()).or_default().seconds += shot.seconds;
    }
    folders.into_iter().map(|(name, summary)| FolderSummary { name: name.to_owned(), ..summary }).collect()
}

fn reported(suite: &Suite, shot: ShotResult, keeps_pending: bool) -> ReportedShot {
    let command =
        |verb: &str| format!("rayframe {verb} {} --suite {}", shell_word(&shot.name), file(&suite.file));
    let mut commands = vec![("Test again".to_owned(), command("test"))];
    let is = |status| shot.pictures.iter().find(|picture| picture.status == status);
    // Limits of its own are nothing that diff can be told.
    if let (Some(picture), Some(preset), true) =
        (is(FrameStatus::Different), Preset::of_name(&shot.preset), keeps_pending)
    {
        let (new, old) = (
            pending_path(&suite.references, &picture.name),
            reference_path(&suite.references, &picture.name),
        );
        let which = if shot.pictures.len() > 1 { format!(", here {}", picture.name) } else { String::new() };
        commands.push((
            format!("Compare in numbers{which}"),
            format!("rayframe diff {} {} --preset {}", file(&new), file(&old), preset.name()),
        ));
    }
    if keeps_pending && (is(FrameStatus::Different).is_some() || is(FrameStatus::Missing).is_some()) {
        commands.push(("Accept".to_owned(), command("accept")));
        commands.push(("Reject".to_owned(), command("reject")));
    }
    ReportedShot {
        commands,
        name: shot.name,
        preset: shot.preset,
        limits: shot.limits,
        frames: shot.pictures,
    }
}

fn orphaned(suite: &Suite, picture: ReportedFrame, keeps_pending: bool) -> ReportedShot {
    let word = shell_word(&format!("{}.exr", picture.name));
    let accept = format!("rayframe accept {word} --suite {}", file(&suite.file));
    ReportedShot {
        name: picture.name.clone(),
        preset: suite.limits.name(),
        limits: suite.limits.limits,
        frames: vec![picture],
        commands: if keeps_pending { vec![("Remove it".to_owned(), accept)] } else { Vec::new() },
    }
}

fn file(path: &Path) -> String {
    shell_word(&path.display().to_string())
}
