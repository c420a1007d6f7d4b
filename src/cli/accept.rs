//! `rayframe accept` and `rayframe reject`: apply or discard pending images.

use std::path::PathBuf;

use clap::Args;

use super::suite_options::SuiteOption;
use crate::progress::print_output;
use rayframe::error::{Error, Result};
use rayframe::regression::suite::{self, Approval, Pending, PendingKind, Suite};

/// The message where nothing is pending.
pub(super) const NOTHING: &str = "no pending images; rayframe test finds differences";

/// The selection of pending images; the options of `rayframe reject` and `rayframe review`.
#[derive(Clone, Debug, Args)]
pub(super) struct RejectArgs {
    /// Only the shot or image of this name, or all whose names contain it
    #[arg(default_value = "", hide_default_value = true)]
    pub(super) filter: String,
    #[command(flatten)]
    pub(super) suite: SuiteOption,
}

/// Options of `rayframe accept`.
#[derive(Clone, Debug, Args)]
pub(super) struct AcceptArgs {
    #[command(flatten)]
    which: RejectArgs,
    /// Accept only what this file approves, which a report exported
    #[arg(long, value_name = "FILE", conflicts_with = "filter")]
    approvals: Option<PathBuf>,
}

/// Accepts pending images as the new references.
pub(super) fn accept(args: &AcceptArgs) -> Result<()> {
    refuse_in_ci("accept")?;
    let (suite, pending_changes) = pending_changes(&args.which)?;
    let chosen = match &args.approvals {
        Some(file) => approved(&suite, &suite::read_approvals(file)?, &pending_changes)?,
        None => pending_changes,
    };
    // All or nothing.
    for pending in &chosen {
        suite::check_acceptable(&suite, pending)?;
    }
    for pending in &chosen {
        suite::accept(&suite, pending)?;
        print_output(&format!("{} {}", done(pending.kind), pending.reference.display()));
    }
    if chosen.is_empty() {
        print_output(match args.approvals {
            Some(_) => "all approved changes are applied already",
            None => NOTHING,
        });
    }
    Ok(())
}

/// Discards pending images.
pub(super) fn reject(args: &RejectArgs) -> Result<()> {
    let (_, pending_changes) = pending_changes(args)?;
    for pending in &pending_changes {
        suite::reject(pending)?;
        print_output(&rejected(pending));
    }
    if pending_changes.is_empty() {
        print_output(NOTHING);
    }
    Ok(())
}

/// Refuses to write references on build servers.
pub(super) fn refuse_in_ci(command: &str) -> Result<()> {
    if suite::is_ci() {
        let message = format!(
            "{command}: CI is set, and references are not written on build servers; accept them on your machine and commit them"
        );
        return Err(Error::usage(message));
    }
    Ok(())
}

/// The message for a rejected change.
pub(super) fn rejected(pending: &Pending) -> String {
    match pending.kind {
        PendingKind::Remove => format!("kept {}", pending.reference.display()),
        PendingKind::Add | PendingKind::Replace => format!("rejected {}", pending.name),
    }
}

/// The verb for an accepted change.
pub(super) fn done(kind: PendingKind) -> &'static str {
    match kind {
        PendingKind::Add => "added",
        PendingKind::Replace => "replaced",
        PendingKind::Remove => "removed",
    }
}

/// The suite, and its selected pending changes.
pub(super) fn pending_changes(args: &RejectArgs) -> Result<(Suite, Vec<Pending>)> {
    let suite = args.suite.read()?;
    let shots = suite::discover(&suite)?;
    let pending_changes = suite::pending(&suite, &shots, &args.filter)?;
    Ok((suite, pending_changes))
}

/// The approved changes among `pending_changes`. Approvals that are applied already are skipped; every other approval must fit a pending change,
/// or nothing is accepted.
fn approved(suite: &Suite, approvals: &[Approval], pending_changes: &[Pending]) -> Result<Vec<Pending>> {
    let mut contradictions = Vec::new();
    let mut chosen = Vec::new();
    for approval in approvals {
        match pending_changes.iter().find(|pending| pending.name == approval.name) {
            Some(pending) => match approval.contradiction(pending)? {
                None => chosen.push(pending.clone()),
                Some(contradiction) => contradictions.push(contradiction),
            },
            None if approval.is_applied(suite) => {}
            None => contradictions.push(format!(
                "{}: no pending image has this name; run rayframe test, which stores pending images",
                approval.name
            )),
        }
    }
    if let Some(first) = contradictions.first() {
        let more = match contradictions.len() - 1 {
            0 => String::new(),
            more => format!(" (and {more} more)"),
        };
        return Err(Error::Different { message: format!("nothing was accepted: {first}{more}") });
    }
    Ok(chosen)
}
