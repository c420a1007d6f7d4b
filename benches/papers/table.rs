//! Tables as aligned text, CSV and Markdown.

use std::fmt::Write as _;

use super::measure::{Row, SceneTable};

/// Headings, with what each means in the papers.
const HEADINGS: [&str; 13] = [
    "R",
    "T_build ms",
    "N_node",
    "N_triangle",
    "T_ray us",
    "S",
    "S_lbvh",
    "frame us",
    "SAH",
    "EPO",
    "depth",
    "nodes",
    "B/tri",
];

/// The cells of a row.
fn cells(row: &Row) -> [String; 13] {
    let of = |value: f64, digits: usize| format!("{value:.digits$}");
    [
        of(row.references_a_triangle, 2),
        of(row.build_milliseconds, 1),
        of(row.primary.nodes, 1),
        of(row.primary.triangles, 2),
        of(row.primary.microseconds, 2),
        of(row.speed_up[0], 2),
        of(row.speed_up[1], 2),
        of(row.frame.microseconds, 2),
        of(row.sah_cost, 1),
        row.end_point_overlap.map_or("-".to_owned(), |overlap| of(overlap, 2)),
        row.depth.to_string(),
        if row.nodes == 0 { "-".to_owned() } else { row.nodes.to_string() },
        of(row.bytes_a_triangle, 0),
    ]
}

/// Aligned text.
pub(crate) fn text(table: &SceneTable) -> String {
    let mut text = title(table) + "\n";
    let line = |name: &str, cells: &[String]| {
        let cells: Vec<_> = cells.iter().map(|cell| format!("{cell:>11}")).collect();
        format!("{name:<32}{}\n", cells.concat())
    };
    text += &line("", &HEADINGS.map(str::to_owned));
    for row in &table.rows {
        text += &line(&name(row), &cells(row));
    }
    for system in &table.left_out {
        let _ = writeln!(text, "{system:<32} has too many references");
    }
    text
}

/// Markdown.
pub(crate) fn markdown(table: &SceneTable) -> String {
    let mut text = format!(
        "### {}\n\n| system | {} |\n|---|{}\n",
        title(table),
        HEADINGS.join(" | "),
        "--:|".repeat(HEADINGS.len())
    );
    for row in &table.rows {
        let _ = writeln!(text, "| {} | {} |", name(row), cells(row).join(" | "));
    }
    for system in &table.left_out {
        let _ = writeln!(text, "\n{system}: too many references");
    }
    text
}

/// CSV of all scenes.
pub(crate) fn csv(tables: &[SceneTable]) -> String {
    let mut text = format!("scene,triangles,E,D,system,{}\n", HEADINGS.join(","));
    for table in tables {
        for row in &table.rows {
            let cells = cells(row).join(",");
            let _ = writeln!(
                text,
                "{},{},{:.2},{:.2},\"{}\",{cells}",
                table.scene, table.triangles, table.overlap, table.sparse_overlap, row.system
            );
        }
    }
    text
}

fn title(table: &SceneTable) -> String {
    let SceneTable { scene, triangles, overlap, sparse_overlap, rays, .. } = table;
    format!("{scene}: {triangles} triangles, E = {overlap:.1}, D = {sparse_overlap:.1}, {rays} rays")
}

fn name(row: &Row) -> String {
    if row.is_automatic { format!("{} *", row.system) } else { row.system.clone() }
}
