//! What splits gain against the overlap of a scene's boxes, in the product: evidence for the overlap D of sparse boxes from which it splits.

use std::fmt::Write as _;

use serde::Serialize;

use super::measure::{Row, SceneTable};
use super::systems::BUDGETS;

/// Gains of a scene: time without splits over time with them.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Gain {
    pub(crate) scene: String,
    pub(crate) triangles: usize,
    /// Areas of the triangles' boxes over that of the scene's.
    pub(crate) overlap: f64,
    /// The same of sparse boxes alone.
    pub(crate) sparse_overlap: f64,
    /// Rays' time, for each number of references a triangle, and for the product's choice.
    pub(crate) of_rays: [f64; BUDGETS.len() + 1],
    /// Time of building and of all rays.
    pub(crate) of_frame: [f64; BUDGETS.len() + 1],
    /// References a triangle of the product's choice.
    pub(crate) chosen: f64,
}

/// The gains of scenes, by overlap of sparse boxes. Each table has the rows of [`super::systems::splits`].
pub(crate) fn gains(tables: &[SceneTable]) -> Vec<Gain> {
    let mut gains: Vec<_> = tables.iter().filter_map(gain).collect();
    gains.sort_by(|a, b| a.sparse_overlap.total_cmp(&b.sparse_overlap));
    gains
}

fn gain(table: &SceneTable) -> Option<Gain> {
    let (unsplit, others) = table.rows.split_first()?;
    let others: &[Row; BUDGETS.len() + 1] = others.try_into().ok()?;
    let of_rays = |row: &Row| row.frame.microseconds;
    let of_frame = |row: &Row| row.build_milliseconds * 1e3 + row.frame.microseconds * table.rays as f64;
    Some(Gain {
        scene: table.scene.clone(),
        triangles: table.triangles,
        overlap: table.overlap,
        sparse_overlap: table.sparse_overlap,
        of_rays: others.each_ref().map(|row| of_rays(unsplit) / of_rays(row)),
        of_frame: others.each_ref().map(|row| of_frame(unsplit) / of_frame(row)),
        chosen: others[BUDGETS.len()].references_a_triangle,
    })
}

fn cells(gain: &Gain) -> Vec<String> {
    let mut cells = vec![gain.scene.clone(), gain.triangles.to_string()];
    cells.extend([gain.overlap, gain.sparse_overlap].map(|overlap| format!("{overlap:.1}")));
    cells.extend(gain.of_rays.iter().chain(&gain.of_frame).map(|gain| format!("{gain:.2}")));
    cells.push(format!("{:.2}", gain.chosen));
    cells
}

fn headings() -> Vec<String> {
    let mut headings = ["scene", "triangles", "E", "D"].map(str::to_owned).to_vec();
    for what in ["rays", "frame"] {
        headings.extend(BUDGETS.iter().map(|budget| format!("{what}, R {budget}")));
        headings.push(format!("{what}, automatic"));
    }
    headings.push("automatic R".to_owned());
    headings
}

/// Markdown.
pub(crate) fn markdown(gains: &[Gain]) -> String {
    let headings = headings();
    let rule = "--:|".repeat(headings.len() - 1);
    let mut text = format!("| {} |\n|---|{rule}\n", headings.join(" | "));
    for gain in gains {
        let _ = writeln!(text, "| {} |", cells(gain).join(" | "));
    }
    text
}

/// CSV.
pub(crate) fn csv(gains: &[Gain]) -> String {
    let headings: Vec<_> = headings().iter().map(|heading| heading.replace(", ", " ")).collect();
    let mut text = headings.join(",") + "\n";
    for gain in gains {
        text += &(cells(gain).join(",") + "\n");
    }
    text
}
