//! Findings as annotations of build servers: workflow commands of GitHub Actions, and reports of GitLab's Code Quality.
//!
//! Formats: docs.github.com, "Workflow commands for GitHub Actions"; docs.gitlab.com, "Code Quality", section "Code Quality report format".

use serde::Serialize;
use sha2::{Digest as _, Sha256};

use crate::cli::findings::Finding;
use rayframe::error::{Error, Result};
use rayframe::sequence::hex;

/// One workflow command a finding: errors for what fails, warnings for changes that do not. GitHub shows the first ten of either kind.
pub(super) fn github_commands(findings: &[Finding<'_>]) -> String {
    let lines = findings.iter().map(|finding| {
        format!(
            "::{} file={},title={}::{}\n",
            if finding.fails { "error" } else { "warning" },
            escaped_property(&finding.repository_path()),
            escaped_property(&format!("{} {}", finding.frame.name, finding.title())),
            escaped_data(&finding.lines().join("\n"))
        )
    });
    lines.collect()
}

/// Escapes the text of a workflow command.
fn escaped_data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// Escapes a property of a workflow command.
fn escaped_property(text: &str) -> String {
    escaped_data(text).replace(':', "%3A").replace(',', "%2C")
}

#[derive(Serialize)]
struct Issue {
    description: String,
    check_name: String,
    /// Equal in every run for the same kind of failure of the same image.
    fingerprint: String,
    severity: &'static str,
    location: Location,
}

#[derive(Serialize)]
struct Location {
    path: String,
    lines: Lines,
}

#[derive(Serialize)]
struct Lines {
    begin: u32,
}

/// The report of Code Quality: a JSON array of issues.
///
/// # Errors
/// [`Error::Internal`] when it cannot be written.
pub(super) fn code_quality(findings: &[Finding<'_>]) -> Result<String> {
    let issues: Vec<Issue> = findings.iter().map(issue).collect();
    let json = serde_json::to_string_pretty(&issues);
    json.map(|json| json + "\n").map_err(|error| Error::Internal { message: error.to_string() })
}

fn issue(finding: &Finding<'_>) -> Issue {
    let frame = finding.frame;
    let check_name = format!("rayframe-{}", frame.kind());
    let fingerprint = hex(&Sha256::digest(format!("{check_name}\n{}", frame.name)));
    Issue {
        description: format!("{} {}: {}", frame.name, finding.title(), finding.lines().join("; ")),
        check_name,
        fingerprint,
        severity: if finding.fails { "major" } else { "minor" },
        location: Location { path: finding.repository_path(), lines: Lines { begin: 1 } },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workflow_commands_are_escaped() {
        assert_eq!(escaped_data("100 % of a:b,\r\nand more"), "100 %25 of a:b,%0D%0Aand more");
        assert_eq!(escaped_property("a,b: 1 %\n"), "a%2Cb%3A 1 %25%0A");
    }
}
