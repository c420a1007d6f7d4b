//! `rayframe accept` and `rayframe reject`: apply or discard pending images.

use std::path::{Path, PathBuf};

use clap::Args;

use super::render_options::message;
use super::suite_options::SuiteOption;
use super::summary::counted;
use crate::progress::{one_line, print_error, print_output};
use rayframe::error::exit_code::permanence;
use rayframe::error::{Error, Result};
use rayframe::regression::suite::{
    self, Acceptance, Approval, Pending, PendingKind, PendingSelection, Suite, Unopened,
};

/// The message where nothing is pending of what `filter` selects.
pub(super) fn nothing_pending(filter: &str) -> String {
    let of = if filter.is_empty() { String::new() } else { format!(" of {}", filter.escape_debug()) };
    format!("no pending images{of}; rayframe test finds differences")
}

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
    pub(super) which: RejectArgs,
    /// Accept the images that changed within the limits, and no others
    #[arg(long)]
    pub(super) changed: bool,
    /// Accept only what this file approves, which a report exported
    #[arg(long, value_name = "FILE", conflicts_with_all = ["filter", "changed"])]
    pub(super) approvals: Option<PathBuf>,
    /// Accept images that a build server rendered: the folder of its report, which has images.json, or a zip archive of it
    #[arg(long, value_name = "DIR|ZIP")]
    from: Option<PathBuf>,
}

impl AcceptArgs {
    /// The folder or archive of `--from`.
    pub(super) fn from(&self) -> Option<&Path> {
        self.from.as_deref()
    }
}

/// Accepts pending images as the new references.
pub(super) fn accept(args: &AcceptArgs) -> Result<()> {
    refuse_in_ci("accept")?;
    let (suite, selection) = pending_changes(&args.which)?;
    let (chosen, left_changed) = match &args.approvals {
        Some(file) => (approved(&suite, &suite::read_approvals(file)?, &selection.changes)?, 0),
        None => chosen(args, selection),
    };
    let mut acceptance = Acceptance::new(&suite);
    // Without a name, those that can be accepted; otherwise all or none.
    let is_of_all = args.which.filter.is_empty() && args.approvals.is_none();
    let (chosen, left) = if is_of_all {
        let (opened, unopened) = acceptance.opened(chosen);
        let (permitted, refused) = acceptance.permitted(opened);
        (permitted, NotAccepted { unopened, refused })
    } else {
        chosen.iter().try_for_each(|pending| acceptance.check(pending))?;
        (chosen, NotAccepted::default())
    };
    for pending in &chosen {
        acceptance.accept(pending)?;
        print_output(&done(pending.kind, &pending.reference));
    }
    if left_changed > 0 {
        print_output(&format!(
            "{} still pending; rayframe accept --changed{} accepts {}",
            if left_changed == 1 {
                "1 change within the limits is".to_owned()
            } else {
                format!("{left_changed} changes within the limits are")
            },
            args.which.suite.shown(),
            if left_changed == 1 { "it" } else { "them" }
        ));
    } else if chosen.is_empty() && left.is_empty() {
        print_output(&match (&args.approvals, args.changed) {
            (Some(_), _) => "all approved changes are applied already".to_owned(),
            (None, true) => "no pending images that changed within the limits".to_owned(),
            (None, false) => nothing_pending(&args.which.filter),
        });
    }
    left.result()
}

/// What stays pending, as it cannot be accepted.
#[derive(Debug, Default)]
struct NotAccepted {
    unopened: Vec<Unopened>,
    refused: Vec<(Pending, Error)>,
}

impl NotAccepted {
    fn is_empty(&self) -> bool {
        self.unopened.is_empty() && self.refused.is_empty()
    }

    /// Tells which changes stay pending.
    ///
    /// # Errors
    /// The last of the most permanent errors, after the others are printed.
    fn result(self) -> Result<()> {
        for (pending, _) in &self.refused {
            print_output(&one_line(&format!("not accepted: {}", pending.file.display())));
        }
        for Unopened { shot, changes, .. } in &self.unopened {
            let images = counted(*changes as u64, "pending image");
            print_output(&format!("not accepted: {images} of {shot}, which cannot be opened"));
        }
        let refused = self.refused.into_iter().map(|(_, error)| error);
        let mut errors: Vec<Error> =
            refused.chain(self.unopened.into_iter().map(|unopened| unopened.error)).collect();
        errors.sort_by_key(|error| permanence(error.exit_code()));
        let last = errors.pop();
        for error in &errors {
            print_error(&message(error));
        }
        last.map_or(Ok(()), Err)
    }
}

/// The changes that the options select, and the number of changes within the limits that they leave. Only `--changed` or an exact name
/// selects those.
fn chosen(args: &AcceptArgs, selection: PendingSelection) -> (Vec<Pending>, usize) {
    let is_changed = |pending: &Pending| pending.kind == PendingKind::ReplaceWithinLimits;
    let (changed, others): (Vec<_>, Vec<_>) = selection.changes.into_iter().partition(is_changed);
    match (args.changed, selection.is_by_name) {
        (true, _) => (changed, 0),
        (false, true) => (others.into_iter().chain(changed).collect(), 0),
        (false, false) => (others, changed.len()),
    }
}

/// Discards pending images.
pub(super) fn reject(args: &RejectArgs) -> Result<()> {
    let (suite, PendingSelection { changes, .. }) = pending_changes(args)?;
    for pending in &changes {
        suite::reject(&suite, pending)?;
        print_output(&rejected(pending));
    }
    if changes.is_empty() {
        print_output(&nothing_pending(&args.filter));
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
        PendingKind::Remove | PendingKind::Keep => format!("kept {}", pending.reference.display()),
        PendingKind::Add | PendingKind::Replace | PendingKind::ReplaceWithinLimits => {
            format!("rejected {}", pending.name)
        }
    }
}

/// The message for an accepted change of `reference`.
pub(super) fn done(kind: PendingKind, reference: &Path) -> String {
    let reference = reference.display();
    match kind {
        PendingKind::Add => format!("added {reference}"),
        PendingKind::Replace | PendingKind::ReplaceWithinLimits => format!("replaced {reference}"),
        PendingKind::Remove => format!("removed {reference}"),
        PendingKind::Keep => {
            format!("kept {reference}, which rayframe did not write; move it out of the folder of references")
        }
    }
}

/// The suite, and its selected pending changes.
pub(super) fn pending_changes(args: &RejectArgs) -> Result<(Suite, PendingSelection)> {
    let suite = args.suite.read()?;
    let shots = suite::discover(&suite)?;
    suite::discard_stray_comparisons(&suite, &shots, &args.filter)?;
    let selection = suite::pending(&suite, &shots, &args.filter)?;
    Ok((suite, selection))
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
                "{}: no pending image has this name; run rayframe test, which stores pending images, or name a build server's report with --from",
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
