//! The JSON that `rayframe test --json` prints (`schema/test.schema.json`). The schema number grows when a field is removed or changes
//! its meaning.

use std::path::Path;

use serde::Serialize;

use rayframe::error::{Error, Result};
use rayframe::regression::suite::{Shard, Suite};
use rayframe::regression::{FailOn, SuiteResult, VerdictCounts};

const SCHEMA: u32 = 1;

#[derive(Debug, Serialize)]
struct SuiteReport<'a> {
    schema: u32,
    suite: String,
    report: String,
    /// Whether the exit code is 0.
    passes: bool,
    passed: usize,
    #[serde(flatten)]
    counts: VerdictCounts,
    /// The part of the suite, `I/N`.
    shard: Option<String>,
    #[serde(flatten)]
    result: &'a SuiteResult,
}

/// The result as JSON.
pub(super) fn json(
    suite: &Suite,
    result: &SuiteResult,
    page: &Path,
    (fail_on, shard): (FailOn, Option<Shard>),
) -> Result<String> {
    let counts = result.counts();
    let report = SuiteReport {
        schema: SCHEMA,
        suite: suite.file.display().to_string(),
        report: page.display().to_string(),
        passes: !result.fails(fail_on),
        passed: counts.identical + counts.changed,
        counts,
        shard: shard.map(|shard| shard.to_string()),
        result,
    };
    serde_json::to_string_pretty(&report).map_err(|error| Error::Internal { message: error.to_string() })
}
