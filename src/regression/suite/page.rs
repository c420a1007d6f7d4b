//! The report of a suite: which of its results the page shows, and with which commands.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::{FolderSummary, FrameStatus, ReportPage, ReportedFrame, ReportedShot};
use super::names::{pending_path, reference_path};
use super::result::{folder_of, is_passed};
use super::shell::shell_word;
use super::{ShotResult, Suite, SuiteResult};

/// What the page of `result` shows. `command` made it.
pub fn report_page(suite: &Suite, result: &SuiteResult, command: &str) -> ReportPage {
    let failed = result.shots.iter().filter(|shot| !shot.passes());
    let mut shots: Vec<ReportedShot> = failed.map(|shot| reported(suite, shot)).collect();
    shots.extend(result.dangling.iter().map(|picture| dangling(suite, picture)));
    shots.sort_by(|a, b| a.name.cmp(&b.name));
    ReportPage {
        title: title(suite),
        command: command.to_owned(),
        folders: folders(result),
        shots,
        can_approve: true,
        accept_command: String::new(),
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
    result.dangling.iter().for_each(|picture| count(folder_of(&picture.name), picture));
    for shot in &result.shots {
        folders.entry(shot.folder()).or_default().seconds += shot.seconds;
    }
    folders.into_iter().map(|(name, summary)| FolderSummary { name: name.to_owned(), ..summary }).collect()
}

fn reported(suite: &Suite, shot: &ShotResult) -> ReportedShot {
    let command =
        |verb: &str| format!("rayframe {verb} {} --suite {}", shell_word(&shot.name), file(&suite.file));
    let mut commands = vec![("Test again".to_owned(), command("test"))];
    let is = |status| shot.pictures.iter().find(|picture| picture.status == status);
    if let Some(picture) = is(FrameStatus::Different) {
        let (new, old) = (
            pending_path(&suite.references, &picture.name),
            reference_path(&suite.references, &picture.name),
        );
        let preset = shot.preset.split(',').next().unwrap_or_default();
        commands.push((
            "Compare in numbers".to_owned(),
            format!("rayframe diff {} {} --preset {preset}", file(&new), file(&old)),
        ));
    }
    if is(FrameStatus::Different).is_some() || is(FrameStatus::Missing).is_some() {
        commands.push(("Accept".to_owned(), command("accept")));
        commands.push(("Reject".to_owned(), command("reject")));
    }
    ReportedShot {
        name: shot.name.clone(),
        preset: shot.preset.clone(),
        limits: shot.limits,
        frames: shot.pictures.clone(),
        commands,
    }
}

fn dangling(suite: &Suite, picture: &ReportedFrame) -> ReportedShot {
    let accept = format!("rayframe accept {} --suite {}", shell_word(&picture.name), file(&suite.file));
    ReportedShot {
        name: picture.name.clone(),
        preset: suite.limits.name(),
        limits: suite.limits.limits,
        frames: vec![picture.clone()],
        commands: vec![("Remove it".to_owned(), accept)],
    }
}

fn file(path: &Path) -> String {
    shell_word(&path.display().to_string())
}
