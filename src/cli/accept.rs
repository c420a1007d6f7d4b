//! `rayframe accept` and `rayframe reject`: what happens to pictures that wait beside the references.

use std::path::PathBuf;

use clap::Args;

use super::suite_options::SuiteOption;
use crate::progress::print_output;
use rayframe::error::{Error, Result};
use rayframe::regression::suite::{self, Approval, Pending, PendingKind, Suite};
use rayframe::shot::ShotFiles;

/// What is said where nothing waits.
pub(super) const NOTHING: &str = "nothing waits; rayframe test finds what differs";

/// Which pending pictures are meant; all options of `rayframe reject` and `rayframe review`.
#[derive(Clone, Debug, Args)]
pub(super) struct RejectArgs {
    /// Only the shot or picture of this name, or all whose names contain it
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
    /// Accept what this file approves, which a report exported, and nothing else
    #[arg(long, value_name = "FILE", conflicts_with = "filter")]
    approvals: Option<PathBuf>,
}

/// Makes pending pictures references.
pub(super) fn accept(args: &AcceptArgs) -> Result<()> {
    refuse_in_ci("accept")?;
    let (suite, waiting) = waiting(&args.which)?;
    let chosen = match &args.approvals {
        Some(file) => approved(&suite, &suite::read_approvals(file)?, &waiting)?,
        None => waiting,
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
            Some(_) => "all that was approved is settled already",
            None => NOTHING,
        });
    }
    Ok(())
}

/// Forgets pending pictures.
pub(super) fn reject(args: &RejectArgs) -> Result<()> {
    let (_, waiting) = waiting(args)?;
    for pending in &waiting {
        suite::reject(pending)?;
        print_output(&rejected(pending));
    }
    if waiting.is_empty() {
        print_output(NOTHING);
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

/// What is said about a change that was not made.
pub(super) fn rejected(pending: &Pending) -> String {
    match pending.kind {
        PendingKind::Remove => format!("kept {}", pending.reference.display()),
        PendingKind::Add | PendingKind::Replace => format!("rejected {}", pending.name),
    }
}

/// What happened to the reference.
pub(super) fn done(kind: PendingKind) -> &'static str {
    match kind {
        PendingKind::Add => "added",
        PendingKind::Replace => "replaced",
        PendingKind::Remove => "removed",
    }
}

/// The suite, and what waits in it.
pub(super) fn waiting(args: &RejectArgs) -> Result<(Suite, Vec<Pending>)> {
    let suite = args.suite.read()?;
    let shots = suite::discover(&suite, &ShotFiles)?;
    let waiting = suite::pending(&suite, &shots, &args.filter)?;
    Ok((suite, waiting))
}

/// Those of `waiting` that are approved; what is already as it was approved counts as done. All others must fit, or nothing is
/// accepted.
fn approved(suite: &Suite, approvals: &[Approval], waiting: &[Pending]) -> Result<Vec<Pending>> {
    let mut contradictions = Vec::new();
    let mut chosen = Vec::new();
    for approval in approvals {
        match waiting.iter().find(|pending| pending.name == approval.name) {
            Some(pending) => match approval.contradiction(pending)? {
                None => chosen.push(pending.clone()),
                Some(contradiction) => contradictions.push(contradiction),
            },
            None if approval.is_applied(suite) => {}
            None => contradictions.push(format!(
                "{}: nothing of this name waits; run rayframe test, which keeps what can become a reference",
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
