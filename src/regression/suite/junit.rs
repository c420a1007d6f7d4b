//! Results in the form that build servers read: JUnit's XML, a suite for each folder and a case for each picture.

use std::time::Duration;

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::super::{FrameStatus, ReportedFrame};
use super::page::folders;
use super::result::folder_of;
use super::{ShotResult, SuiteResult};
use crate::error::{Error, Result};

/// The XML of a result.
///
/// # Errors
/// [`Error::Internal`] when it cannot be written.
pub fn junit_xml(result: &SuiteResult) -> Result<String> {
    let mut report = Report::new("rayframe test");
    report.set_time(Duration::from_secs_f64(result.seconds));
    for folder in folders(result) {
        let mut suite = TestSuite::new(if folder.name.is_empty() { "." } else { &folder.name });
        suite.set_time(Duration::from_secs_f64(folder.seconds));
        for shot in result.shots.iter().filter(|shot| shot.folder() == folder.name) {
            suite.add_test_cases(shot.pictures.iter().map(|picture| case_of_shot(shot, picture)));
        }
        let orphaned = result.orphaned.iter().filter(|picture| folder_of(&picture.name) == folder.name);
        suite.add_test_cases(orphaned.map(case));
        report.add_test_suite(suite);
    }
    report.to_string().map_err(|error| Error::Internal { message: format!("JUnit's XML: {error}") })
}

/// The time of a shot is shared by its pictures.
fn case_of_shot(shot: &ShotResult, picture: &ReportedFrame) -> TestCase {
    let mut case = case(picture);
    case.set_time(Duration::from_secs_f64(shot.seconds / shot.pictures.len() as f64));
    if !shot.warnings.is_empty() {
        case.set_system_err(shot.warnings.join("\n"));
    }
    case
}

fn case(picture: &ReportedFrame) -> TestCase {
    let status = match picture.status {
        FrameStatus::Passed => TestCaseStatus::success(),
        FrameStatus::Broken => failed(NonSuccessKind::Error, "broken", picture),
        FrameStatus::Different => failed(NonSuccessKind::Failure, "different", picture),
        FrameStatus::Missing => failed(NonSuccessKind::Failure, "missing", picture),
        FrameStatus::Orphaned => failed(NonSuccessKind::Failure, "orphaned", picture),
    };
    let mut case = TestCase::new(picture.name.as_str(), status);
    case.set_classname(folder_of(&picture.name).replace('/', "."));
    case
}

fn failed(kind: NonSuccessKind, kind_name: &str, picture: &ReportedFrame) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    let cause = picture.comparison.as_ref().and_then(|comparison| comparison.cause.as_ref());
    let cause = cause.map(|cause| format!("likely {cause}"));
    let lines: Vec<&str> = picture.messages.iter().map(String::as_str).chain(cause.as_deref()).collect();
    status.set_type(kind_name);
    status.set_message(lines.first().copied().unwrap_or_default());
    status.set_description(lines.join("\n"));
    status
}
