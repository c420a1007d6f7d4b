//! `rayframe accept` and `rayframe reject`: what happens to pictures that wait beside the references.

use std::path::PathBuf;

use clap::Args;

use super::suite_options::SuiteOption;
use crate::error::{Error, Result};
use crate::progress::print_output;
use crate::regression::suite::{self, Approval, Pending, PendingKind, Suite};

/// Options of `rayframe reject`.
#[derive(Clone, Debug, Args)]
pub(super) struct RejectArgs {
    /// Only the shot or picture of this name, or all whose names contain it
    #[arg(default_value = "", hide_default_value = true)]
    filter: String,
    #[command(flatten)]
    suite: SuiteOption,
}

/// Options of `rayframe accept`.
#[derive(Clone, Debug, Args)]
pub(super) struct AcceptArgs {
    #[command(flatten)]
    which: RejectArgs,
    /// Accept what this file approves, which a report exported, and nothing else
    #[arg(long, value_name = "FILE")]
    approvals: Option<PathBuf>,
}

/// Makes pending pictures references.
pub(super) fn accept(args: &AcceptArgs) -> Result<()> {
    refuse_in_ci("accept")?;
    let suite = args.which.suite.read()?;
    let waiting = waiting(&suite, &args.which.filter)?;
    let chosen = match &args.approvals {
        Some(file) => approved(&suite::read_approvals(file)?, waiting)?,
        None => waiting,
    };
    for pending in &chosen {
        suite::accept(&suite, pending)?;
        print_output(&format!("{} {}", done(pending.kind), pending.reference.display()));
    }
    Ok(())
}

/// Forgets pending pictures.
pub(super) fn reject(args: &RejectArgs) -> Result<()> {
    let suite = args.suite.read()?;
    for pending in waiting(&suite, &args.filter)? {
        suite::reject(&pending)?;
        print_output(&format!("rejected {}", pending.name));
    }
    Ok(())
}

/// Where nobody looks, nothing becomes a reference.
pub(super) fn refuse_in_ci(command: &str) -> Result<()> {
    if suite::is_ci() {
        let message = format!(
            "{command}: CI is set, and references are written where somebody looks at them; accept them at home and commit them"
        );
        return Err(Error::usage(message));
    }
    Ok(())
}

/// What happened to the reference.
pub(super) fn done(kind: PendingKind) -> &'static str {
    match kind {
        PendingKind::Add => "added",
        PendingKind::Replace => "replaced",
        PendingKind::Remove => "removed",
    }
}

/// What waits; a filter that fits nothing is a mistake.
pub(super) fn waiting(suite: &Suite, filter: &str) -> Result<Vec<Pending>> {
    let waiting = suite::pending(suite, filter)?;
    if waiting.is_empty() {
        if !filter.is_empty() {
            let message = format!(
                "nothing that waits is called \"{}\"; rayframe test finds what differs",
                filter.escape_debug()
            );
            return Err(Error::usage(message));
        }
        print_output("nothing waits; rayframe test finds what differs");
    }
    Ok(waiting)
}

/// Those of `waiting` that are approved; all approvals must fit, or nothing is accepted.
fn approved(approvals: &[Approval], waiting: Vec<Pending>) -> Result<Vec<Pending>> {
    let mut contradictions = Vec::new();
    for approval in approvals {
        match waiting.iter().find(|pending| pending.name == approval.name) {
            Some(pending) => contradictions.extend(approval.contradiction(pending)?),
            None => contradictions
                .push(format!("{}: nothing of this name waits; run rayframe test first", approval.name)),
        }
    }
    if let Some(first) = contradictions.first() {
        let more = match contradictions.len() - 1 {
            0 => String::new(),
            more => format!(" (and {more} more)"),
        };
        return Err(Error::Different { message: format!("nothing was accepted: {first}{more}") });
    }
    let is_approved = |pending: &Pending| approvals.iter().any(|approval| approval.name == pending.name);
    Ok(waiting.into_iter().filter(is_approved).collect())
}
