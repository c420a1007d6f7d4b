//! `rayframe accept --from DIR|ZIP`: accepts the images in the report of a build server.

use std::path::Path;

use super::accept::{AcceptArgs, done, refuse_in_ci};
use crate::progress::print_output;
use rayframe::error::{Error, Result};
use rayframe::regression::Verdict;
use rayframe::regression::suite::{
    self, Approval, RenderedChecks, RenderedImage, RenderedReport, Suite, SuiteShot, read_approvals,
    select_rendered,
};

/// Checks the selected images, and makes them references: all or none.
pub(super) fn accept_rendered(args: &AcceptArgs, report: &Path) -> Result<()> {
    refuse_in_ci("accept")?;
    let suite = args.which.suite.read()?;
    let shots = suite::discover(&suite)?;
    let report = RenderedReport::open(report)?;
    let images = report.images()?;
    let chosen = match &args.approvals {
        Some(file) => approved(&suite, images, file)?,
        None => chosen(args, images, (&suite, &shots))?,
    };
    let mut checks = RenderedChecks::new(&suite, &shots, &report);
    let checked: Vec<_> = chosen.iter().map(|image| checks.change(image)).collect();
    let changes: Vec<_> = all_or_none(checked)?.into_iter().flatten().collect();
    for change in &changes {
        change.apply(&suite)?;
        print_output(&done(change.kind, &change.reference));
    }
    if changes.is_empty() {
        let nothing_chosen =
            "the report has no such images; --changed selects those that changed within the limits";
        print_output(if chosen.is_empty() { nothing_chosen } else { "all images are references already" });
    }
    Ok(())
}

/// All results, or the first error with the number of others.
fn all_or_none<T>(checked: Vec<Result<T>>) -> Result<Vec<T>> {
    let count = checked.iter().filter(|checked| checked.is_err()).count();
    checked.into_iter().collect::<Result<_>>().map_err(|first| match first {
        Error::Different { message } => {
            let more = if count > 1 { format!(" (and {} more)", count - 1) } else { String::new() };
            Error::Different { message: format!("nothing was accepted: {message}{more}") }
        }
        // Missing and damaged files have exit codes of their own.
        error => error,
    })
}

/// The images that the options select. Only `--changed` or an exact name selects changes within the limits.
fn chosen(
    args: &AcceptArgs,
    images: Vec<RenderedImage>,
    (suite, shots): (&Suite, &[SuiteShot]),
) -> Result<Vec<RenderedImage>> {
    let word = &args.which.filter;
    let (mut images, is_by_name) = select_rendered(suite, images, shots, word)?;
    if args.changed {
        images.retain(|image| image.verdict == Verdict::Changed);
    } else if !is_by_name {
        images.retain(|image| image.verdict == Verdict::Failed);
    }
    Ok(images)
}

/// The approved images. Every approval must name an image of the report by its hash, or one that is the reference already.
fn approved(suite: &Suite, images: Vec<RenderedImage>, file: &Path) -> Result<Vec<RenderedImage>> {
    let approvals: Vec<_> =
        read_approvals(file)?.into_iter().filter(|approval| !approval.is_applied(suite)).collect();
    let fits = |image: &RenderedImage, approval: &Approval| {
        image.name == approval.name && image.hash == approval.hash
    };
    if let Some(missing) = approvals.iter().find(|approval| !images.iter().any(|image| fits(image, approval)))
    {
        let name = &missing.name;
        let message =
            format!("nothing was accepted: {name}: the image that was approved is not in the report");
        return Err(Error::Different { message });
    }
    let is_approved = |image: &RenderedImage| approvals.iter().any(|approval| fits(image, approval));
    Ok(images.into_iter().filter(is_approved).collect())
}
