//! `rayframe review`: shows pending images one by one beside their references, and asks what to do.

use std::io::BufRead;
use std::path::Path;

use super::accept::{RejectArgs, done, nothing_pending, pending_changes, refuse_in_ci, rejected};
use crate::progress::{TerminalImages, one_line, print_output, print_raw};
use rayframe::error::{Error, Result};
use rayframe::output::{PreviewLook, display_image};
use rayframe::regression::suite::{self, Acceptance, Pending, PendingKind, Suite, compare_pending};
use rayframe::regression::{Comparison, Image, pixel_hash};

/// The answer of the user.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Decision {
    Accept,
    Reject,
    Skip,
    Quit,
}

/// Asks about each pending change.
pub(super) fn run(args: &RejectArgs) -> Result<()> {
    refuse_in_ci("review")?;
    let (suite, selection) = pending_changes(args)?;
    let pending_changes = selection.changes;
    if pending_changes.is_empty() {
        print_output(&nothing_pending(&args.filter));
    }
    let mut acceptance = Acceptance::new(&suite);
    let mut answers = std::io::stdin().lock();
    let mut left = 0;
    for (at, pending) in pending_changes.iter().enumerate() {
        let shown = show(&suite, pending, (at + 1, pending_changes.len()));
        match ask(&mut answers)? {
            Decision::Accept if hash_of(&pending.file) != shown => {
                let message = format!("{} was rendered anew meanwhile and is still pending", pending.name);
                print_output(&one_line(&message));
                left += 1;
            }
            Decision::Accept => {
                acceptance.accept(pending)?;
                print_output(&done(pending.kind, &pending.reference));
            }
            Decision::Reject => {
                suite::reject(&suite, pending)?;
                print_output(&rejected(pending));
            }
            Decision::Skip => left += 1,
            Decision::Quit => {
                left += pending_changes.len() - at;
                break;
            }
        }
    }
    if left > 0 {
        print_output(&format!("{left} still pending"));
    }
    Ok(())
}

/// The hash of an image, by which a later change is noticed.
fn hash_of(file: &Path) -> Option<String> {
    Image::read(file).ok().as_ref().map(pixel_hash)
}

/// Asks until the answer is valid. The end of the input quits.
fn ask(answers: &mut impl BufRead) -> Result<Decision> {
    loop {
        print_raw("  [a]ccept, [r]eject, [s]kip, [q]uit? ");
        let mut line = String::new();
        let length = answers.read_line(&mut line).map_err(|source| Error::Missing {
            path: "standard input".into(),
            pointer: String::new(),
            source,
        })?;
        let word = line.trim().to_ascii_lowercase();
        match word.as_str() {
            _ if length == 0 => return Ok(Decision::Quit),
            "a" | "accept" | "y" | "yes" => return Ok(Decision::Accept),
            "r" | "reject" | "n" | "no" => return Ok(Decision::Reject),
            "s" | "skip" => return Ok(Decision::Skip),
            "q" | "quit" => return Ok(Decision::Quit),
            _ => print_raw("  a, r, s or q, and then the enter key\n"),
        }
    }
}

/// Shows a pending change, its measures, and on capable terminals the images. Returns the hash of the pending image. An unreadable image
/// is reported, and the change can still be decided.
fn show(suite: &Suite, pending: &Pending, (at, count): (usize, usize)) -> Option<String> {
    let what = match pending.kind {
        PendingKind::Add => "has no reference yet",
        PendingKind::Replace => "differs from its reference",
        PendingKind::ReplaceWithinLimits => "changed within the limits of its reference",
        PendingKind::Remove => "is a reference that no shot renders",
        PendingKind::Keep => "is no image of a shot, and rayframe did not write it",
    };
    print_output(&format!("{at}/{count} {} {what}", one_line(&pending.name)));
    let expected = image(&pending.reference, pending.kind != PendingKind::Add);
    let is_removal = matches!(pending.kind, PendingKind::Remove | PendingKind::Keep);
    let actual = image(&pending.file, !is_removal);
    if let (Some(actual), Some(expected)) = (&actual, &expected) {
        match compare_pending(suite, pending, actual, expected) {
            Ok(comparison) => print_output(&described(&comparison)),
            Err(error) => print_output(&format!("  {}", one_line(&error.to_string()))),
        }
    }
    if let Some(terminal) = TerminalImages::of_stderr() {
        for (title, image) in [("reference", &expected), ("new", &actual)] {
            if let Some(text) = image.as_ref().and_then(|image| terminal_text(terminal, image)) {
                print_raw(&format!("  {title}\n{text}"));
            }
        }
    }
    actual.as_ref().map(pixel_hash)
}

fn image(path: &Path, is_there: bool) -> Option<Image> {
    if !is_there {
        return None;
    }
    let read = Image::read(path);
    read.inspect_err(|error| print_output(&format!("  {}", one_line(&error.to_string())))).ok()
}

fn described(comparison: &Comparison) -> String {
    let likely = comparison.cause.as_ref().map(|cause| format!("likely {cause}"));
    let mut lines = comparison.failures();
    if lines.is_empty() {
        lines.push(comparison.largest_measure().unwrap_or_else(|| "it is identical now".to_owned()));
    }
    let lines = lines.into_iter().chain(likely).map(|line| format!("  {}", one_line(&line)));
    lines.collect::<Vec<_>>().join("\n")
}

fn terminal_text(terminal: TerminalImages, image: &Image) -> Option<String> {
    let colors = image.clone().into_linear().colors()?;
    let pixels: Vec<[f32; 4]> = colors.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
    Some(terminal.text(&display_image(image.size(), &pixels, None, PreviewLook::default())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_words_or_their_first_letters() {
        let decided = |text: &str| ask(&mut text.as_bytes()).unwrap();
        assert_eq!(decided("a\n"), Decision::Accept);
        assert_eq!(decided("what?\n\nReject\n"), Decision::Reject);
        assert_eq!(decided(" s \n"), Decision::Skip);
        assert_eq!(decided("q\n"), Decision::Quit);
        assert_eq!(decided("maybe\n"), Decision::Quit);
    }
}
