//! The text of a comparison of two assets: their names, the changes of the file by group, one line an image, the worst
//! failure and what is lost.

use std::fmt::Write as _;

use rayframe::asset_diff::AssetDifference;
use rayframe::regression::{ChangeGroup, ChangeRow};

use super::args::{DiffArgs, shown};
use super::report::{FrameReport, Report};
use super::text::{details, names, outcome, verdicts};
use crate::cli::summary::counted;
use crate::progress::one_line;

/// Rows of a group that are printed.
const MOST_ROWS: usize = 24;
/// Widest column of names.
const WIDEST_NAME: usize = 36;

/// The whole text, without a line end.
pub(super) fn text(
    args: &DiffArgs,
    report: &Report<'_>,
    difference: &AssetDifference,
    losses: &[String],
) -> String {
    let mut text = format!("{}\n", names(&shown(&args.actual), &shown(&args.reference)));
    let groups = difference.table();
    if groups.is_empty() {
        text.push_str("no change of the file's structure\n");
    }
    for group in &groups {
        group_text(&mut text, group);
    }
    images(&mut text, report);
    if let Some(frame) = worst(report) {
        let _ = writeln!(text, "worst, {}:", one_line(&title(frame)));
        details(&mut text, frame);
    }
    for loss in losses {
        let _ = writeln!(text, "  FAIL {}", one_line(loss));
    }
    let lost = match losses.len() {
        0 => "nothing lost".to_owned(),
        count => format!("{count} lost"),
    };
    let _ = writeln!(text, "{}, {lost}", verdicts(report, "image"));
    text.trim_end().to_owned()
}

fn group_text(text: &mut String, group: &ChangeGroup) {
    let width = |column: fn(&ChangeRow) -> &str| {
        group.rows.iter().map(|row| one_line(column(row)).chars().count()).max().unwrap_or(0)
    };
    let names = width(|row| &row.name).min(WIDEST_NAME);
    let properties = width(|row| &row.property);
    let _ = writeln!(text, "{}", group.title);
    for row in group.rows.iter().take(MOST_ROWS) {
        let ChangeRow { mark, name, property, values } = row;
        let mark = if name.is_empty() { ' ' } else { *mark };
        let [name, property, values] = [name, property, values].map(|part| one_line(part));
        let line = format!("  {mark} {name:names$}  {property:properties$}  {values}");
        let _ = writeln!(text, "{}", line.trim_end());
    }
    if group.rows.len() > MOST_ROWS {
        let _ = writeln!(
            text,
            "  and {}, which --json lists",
            counted((group.rows.len() - MOST_ROWS) as u64, "more line")
        );
    }
}

fn images(text: &mut String, report: &Report<'_>) {
    let width =
        report.frames.iter().map(|frame| one_line(&title(frame)).chars().count()).max().unwrap_or(0).max(6);
    let _ = writeln!(text, "{:width$}    mean FLIP  worst tile  result", "images");
    for frame in &report.frames {
        let flip = frame.comparison.flip;
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.4}"));
        let (mean, tile) = (number(flip.map(|flip| flip.mean)), number(flip.map(|flip| flip.tile)));
        let _ =
            writeln!(text, "  {:width$}  {mean:>9}  {tile:>10}  {}", one_line(&title(frame)), outcome(frame));
    }
}

/// The image that fails with the worst tile.
fn worst<'a>(report: &'a Report<'_>) -> Option<&'a FrameReport> {
    let tile = |frame: &FrameReport| frame.comparison.flip.map_or(0.0, |flip| flip.tile);
    let failed = report.frames.iter().filter(|frame| !frame.same);
    // Of equal ones the first.
    failed.rev().max_by(|a, b| tile(a).total_cmp(&tile(b)))
}

/// The view, with its frame in a clip.
fn title(frame: &FrameReport) -> String {
    let view = frame.view.as_deref().unwrap_or_default();
    frame.frame.map_or_else(|| view.to_owned(), |number| format!("{view} frame {number}"))
}
