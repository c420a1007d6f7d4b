//! `rayframe review`: pending pictures one by one, each shown beside its reference, each with a question.

use std::io::BufRead;
use std::path::Path;

use super::accept::{NOTHING, RejectArgs, done, refuse_in_ci, rejected, waiting};
use crate::progress::{TerminalImages, one_line, print_output, print_raw};
use rayframe::color::ToneCurve;
use rayframe::error::{Error, Result};
use rayframe::output::{PreviewLook, display_image};
use rayframe::regression::suite::{self, Pending, PendingKind, Suite, compare_pending};
use rayframe::regression::{Comparison, Image, pixel_hash};

/// What somebody decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Decision {
    Accept,
    Reject,
    Skip,
    Quit,
}

/// Asks about everything that waits.
pub(super) fn run(args: &RejectArgs) -> Result<()> {
    refuse_in_ci("review")?;
    let (suite, waiting) = waiting(args)?;
    if waiting.is_empty() {
        print_output(NOTHING);
    }
    let mut answers = std::io::stdin().lock();
    let mut left = 0;
    for (at, pending) in waiting.iter().enumerate() {
        let shown = show(&suite, pending, (at + 1, waiting.len()));
        match ask(&mut answers)? {
            Decision::Accept if hash_of(&pending.file) != shown => {
                let message = format!("{} was rendered anew meanwhile and is still waiting", pending.name);
                print_output(&one_line(&message));
                left += 1;
            }
            Decision::Accept => {
                suite::accept(&suite, pending)?;
                print_output(&format!("{} {}", done(pending.kind), pending.reference.display()));
            }
            Decision::Reject => {
                suite::reject(pending)?;
                print_output(&rejected(pending));
            }
            Decision::Skip => left += 1,
            Decision::Quit => {
                left += waiting.len() - at;
                break;
            }
        }
    }
    if left > 0 {
        print_output(&format!("{left} still waiting"));
    }
    Ok(())
}

/// What somebody looks at, to be known again.
fn hash_of(file: &Path) -> Option<String> {
    Image::read(file).ok().as_ref().map(pixel_hash)
}

/// Asks until the answer is understood; the end of the input is the wish to stop.
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

/// What waits, how it differs, and, where the terminal can, the pictures. Gives the hash of the one that waits. What cannot be read is
/// told of, and can still be decided about.
fn show(suite: &Suite, pending: &Pending, (at, count): (usize, usize)) -> Option<String> {
    let what = match pending.kind {
        PendingKind::Add => "has no reference yet",
        PendingKind::Replace => "differs from its reference",
        PendingKind::Remove => "is a reference that no shot asks for",
    };
    print_output(&format!("{at}/{count} {} {what}", one_line(&pending.name)));
    let expected = picture(&pending.reference, pending.kind != PendingKind::Add);
    let actual = picture(&pending.file, pending.kind != PendingKind::Remove);
    if let (Some(actual), Some(expected)) = (&actual, &expected) {
        match compare_pending(suite, pending, actual, expected) {
            Ok(comparison) => print_output(&described(&comparison)),
            Err(error) => print_output(&format!("  {}", one_line(&error.to_string()))),
        }
    }
    if let Some(terminal) = TerminalImages::of_stderr() {
        for (title, picture) in [("reference", &expected), ("new", &actual)] {
            if let Some(text) = picture.as_ref().and_then(|picture| drawn(terminal, picture)) {
                print_raw(&format!("  {title}\n{text}"));
            }
        }
    }
    actual.as_ref().map(pixel_hash)
}

fn picture(path: &Path, is_there: bool) -> Option<Image> {
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
        lines.push("it passes now".to_owned());
    }
    let lines = lines.into_iter().chain(likely).map(|line| format!("  {}", one_line(&line)));
    lines.collect::<Vec<_>>().join("\n")
}

fn drawn(terminal: TerminalImages, picture: &Image) -> Option<String> {
    let colors = picture.clone().into_linear().colors()?;
    let pixels: Vec<[f32; 4]> = colors.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
    Some(terminal.text(&display_image(
        picture.size(),
        &pixels,
        PreviewLook { exposure_ev: 0.0, tone: ToneCurve::Standard },
    )))
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
