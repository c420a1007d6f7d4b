//! JUnit XML of a result, for build servers: one test suite for each folder, one test case for each frame.

use std::time::Duration;

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use rayframe::error::{Error, Result};
use rayframe::regression::suite::folders;
use rayframe::regression::{FrameResult, FrameStatus, ShotResult, SuiteResult};

/// The XML of a result.
///
/// # Errors
/// [`Error::Internal`] when it cannot be written.
pub(super) fn junit_xml(result: &SuiteResult) -> Result<String> {
    let mut report = Report::new("rayframe test");
    report.set_time(Duration::from_secs_f64(result.seconds));
    for folder in folders(result) {
        let mut suite = TestSuite::new(if folder.name.is_empty() { "." } else { &folder.name });
        suite.set_time(Duration::from_secs_f64(folder.seconds));
        for shot in result.shots.iter().filter(|shot| shot.folder() == folder.name) {
            suite.add_test_cases(shot.frames.iter().map(|frame| case_of_shot(shot, frame)));
        }
        let orphaned = result.orphaned.iter().filter(|frame| frame.folder() == folder.name);
        suite.add_test_cases(orphaned.map(case));
        report.add_test_suite(suite);
    }
    report.to_string().map_err(|error| Error::Internal { message: format!("JUnit's XML: {error}") })
}

/// A test case of a shot. The seconds of the shot are divided among its frames.
fn case_of_shot(shot: &ShotResult, frame: &FrameResult) -> TestCase {
    let mut case = case(frame);
    case.set_time(Duration::from_secs_f64(shot.seconds / shot.frames.len() as f64));
    if !shot.warnings.is_empty() {
        case.set_system_err(shot.warnings.join("\n"));
    }
    case
}

fn case(frame: &FrameResult) -> TestCase {
    let status = match frame.status {
        FrameStatus::Passed => TestCaseStatus::success(),
        FrameStatus::Broken => failed(NonSuccessKind::Error, frame),
        FrameStatus::Different | FrameStatus::Missing | FrameStatus::Orphaned => {
            failed(NonSuccessKind::Failure, frame)
        }
    };
    let mut case = TestCase::new(frame.name.as_str(), status);
    case.set_classname(frame.folder().replace('/', "."));
    case
}

fn failed(kind: NonSuccessKind, frame: &FrameResult) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    let cause = frame.likely_cause().map(|cause| format!("likely {cause}"));
    let lines: Vec<&str> = frame.messages.iter().map(String::as_str).chain(cause.as_deref()).collect();
    status.set_type(frame.status.name());
    status.set_message(lines.first().copied().unwrap_or_default());
    status.set_description(lines.join("\n"));
    status
}
