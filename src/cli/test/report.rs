//! The JSON that `rayframe test --json` prints (`schema/test.schema.json`). The schema number grows when a field is removed or changes
//! its meaning.

use std::path::Path;

use serde::Serialize;

use rayframe::error::{Error, Result};
use rayframe::regression::SuiteResult;
use rayframe::regression::suite::Suite;

const SCHEMA: u32 = 1;

#[derive(Debug, Serialize)]
struct SuiteReport<'a> {
    schema: u32,
    suite: String,
    report: String,
    passes: bool,
    passed: usize,
    failed: usize,
    #[serde(flatten)]
    result: &'a SuiteResult,
}

/// The result as JSON.
pub(super) fn json(suite: &Suite, result: &SuiteResult, page: &Path) -> Result<String> {
    let (passed, failed) = result.counts();
    let report = SuiteReport {
        schema: SCHEMA,
        suite: suite.file.display().to_string(),
        report: page.display().to_string(),
        passes: result.passes(),
        passed,
        failed,
        result,
    };
    serde_json::to_string_pretty(&report).map_err(|error| Error::Internal { message: error.to_string() })
}
