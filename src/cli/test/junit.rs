//! JUnit XML of a result, for build servers: one test suite for each folder, one test case for each frame.

use std::time::Duration;

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use rayframe::error::{Error, Result};
use rayframe::regression::suite::folders;
use rayframe::regression::{FailOn, FrameResult, FrameStatus, ShotResult, SuiteResult, Verdict};

/// Class name of the test cases of the suite's top folder, as Jenkins names a package without a name. Servers group test cases by it.
const TOP_FOLDER: &str = "(root)";

/// The XML of a result.
///
/// # Errors
/// [`Error::Internal`] when it cannot be written.
pub(super) fn junit_xml(result: &SuiteResult, fail_on: FailOn) -> Result<String> {
    let mut report = Report::new("rayframe test");
    report.set_time(Duration::from_secs_f64(result.seconds));
    for folder in folders(result) {
        let mut suite = TestSuite::new(if folder.name.is_empty() { "." } else { &folder.name });
        suite.set_time(Duration::from_secs_f64(folder.seconds));
        for shot in result.shots.iter().filter(|shot| shot.folder() == folder.name) {
            suite.add_test_cases(shot.frames.iter().map(|frame| case_of_shot(shot, frame, fail_on)));
        }
        let orphaned = result.orphaned.iter().filter(|frame| frame.folder() == folder.name);
        suite.add_test_cases(orphaned.map(|frame| case(frame, fail_on)));
        report.add_test_suite(suite);
    }
    let xml = report.to_string();
    let xml = xml.map_err(|error| Error::Internal { message: format!("JUnit's XML: {error}") })?;
    Ok(without_noncharacters(&xml))
}

/// `xml` without U+FFFE and U+FFFF, which no XML file may have (XML 1.0, 2.2). Control characters are gone already.
fn without_noncharacters(xml: &str) -> String {
    xml.replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}")
}

/// A test case of a shot. The seconds of the shot are divided among its frames.
fn case_of_shot(shot: &ShotResult, frame: &FrameResult, fail_on: FailOn) -> TestCase {
    let mut case = case(frame, fail_on);
    case.set_time(Duration::from_secs_f64(shot.seconds / shot.frames.len() as f64));
    if !shot.warnings.is_empty() {
        case.set_system_err(shot.warnings.join("\n"));
    }
    case
}

/// A test case with its verdict as a property. Changes within the limits pass, unless `fail_on` names them; most build servers show the
/// output of a test case that passes.
fn case(frame: &FrameResult, fail_on: FailOn) -> TestCase {
    let verdict = frame.verdict();
    let status = match frame.status {
        FrameStatus::Passed if fail_on.fails(verdict) => failed(NonSuccessKind::Failure, frame),
        FrameStatus::Passed => TestCaseStatus::success(),
        FrameStatus::Broken => failed(NonSuccessKind::Error, frame),
        FrameStatus::Different | FrameStatus::Missing | FrameStatus::Orphaned => {
            failed(NonSuccessKind::Failure, frame)
        }
    };
    let mut case = TestCase::new(frame.name.as_str(), status);
    let folder = frame.folder();
    case.set_classname(if folder.is_empty() { TOP_FOLDER.to_owned() } else { folder.replace('/', ".") });
    case.add_property(("verdict", verdict.name()));
    if verdict == Verdict::Changed {
        let lines = [&[verdict.words().to_owned()], &*lines(frame)].concat();
        case.set_system_out(lines.join("\n"));
    }
    case
}

fn failed(kind: NonSuccessKind, frame: &FrameResult) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    let lines = lines(frame);
    status.set_type(frame.kind());
    status.set_message(lines.first().map(String::as_str).unwrap_or_default());
    status.set_description(lines.join("\n"));
    status
}

/// The messages and the likely cause.
fn lines(frame: &FrameResult) -> Vec<String> {
    let cause = frame.likely_cause().map(|cause| format!("likely {cause}"));
    frame.messages.iter().cloned().chain(cause).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_only_characters_of_xml() {
        let name = "robot@a\u{fffe}b\u{ffff}c\u{1}d\u{fffd}\u{1f600}";
        let orphaned =
            FrameResult::new(name.to_owned(), None, FrameStatus::Orphaned).because(name.to_owned());
        let result = SuiteResult { orphaned: vec![orphaned], ..SuiteResult::default() };
        let xml = junit_xml(&result, FailOn::default()).unwrap();
        assert!(xml.contains("<testcase name=\"robot@a\u{fffd}b\u{fffd}c"), "{xml}");
        let is_allowed =
            |c: char| !matches!(c, '\u{fffe}' | '\u{ffff}') && (c >= ' ' || "\t\n\r".contains(c));
        assert!(xml.chars().all(is_allowed), "{xml}");
    }
}
