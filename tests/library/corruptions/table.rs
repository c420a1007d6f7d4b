//! A table of corruptions and presets.

use std::fmt::Write as _;
use std::path::Path;

use rayframe::error::Result;
use rayframe::regression::{Comparison, Image, Preset, Samples, compare_with_each};

use super::corruption::{Corruption, all};
use super::images::display;

/// Limit of Blender's render tests on the difference of a channel, in display values.
const IDIFF_FAIL: f32 = 0.016;
/// Limit of Blender's render tests on the share of such pixels.
const IDIFF_SHARE: f64 = 0.01;

/// One corruption in one kind of file.
pub(crate) struct Row {
    pub(crate) corruption: &'static str,
    pub(crate) scene: &'static str,
    /// `EXR` or `PNG`.
    pub(crate) kind: &'static str,
    /// Whether the corruption is hard to find.
    pub(crate) is_small: bool,
    /// In the order of [`Preset::ALL`].
    pub(crate) comparisons: [Comparison; 4],
    /// Whether the limits of Blender's tests catch it.
    pub(crate) is_caught_by_idiff: bool,
    /// Share of pixels beyond the first of these limits.
    pub(crate) idiff_share: f64,
}

/// Renders and compares everything.
pub(crate) fn rows(scenes: &Path) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for corruption in all(scenes)? {
        let displays = [display(&corruption.corrupted), display(&corruption.intact)];
        let idiff_share = share_beyond(&displays, IDIFF_FAIL);
        let lights = [&corruption.corrupted, &corruption.intact].map(Clone::clone);
        rows.push(row(&corruption, "EXR", &lights, idiff_share));
        rows.push(row(&corruption, "PNG", &displays, idiff_share));
    }
    Ok(rows)
}

fn row(corruption: &Corruption, kind: &'static str, images: &[Image; 2], idiff_share: f64) -> Row {
    let [corrupted, intact] = images;
    let limits = Preset::ALL.map(Preset::limits);
    Row {
        corruption: corruption.name,
        scene: corruption.scene,
        kind,
        is_small: corruption.is_small,
        comparisons: compare_with_each(corrupted, intact, limits.each_ref()),
        is_caught_by_idiff: idiff_share > IDIFF_SHARE,
        idiff_share,
    }
}

fn share_beyond([a, b]: &[Image; 2], limit: f32) -> f64 {
    let mut is_beyond = vec![false; a.data_window.pixel_count()];
    for (a, b) in a.channels.iter().zip(&b.channels) {
        if let (Samples::Float(a), Samples::Float(b)) = (&a.samples, &b.samples) {
            for (beyond, (a, b)) in is_beyond.iter_mut().zip(a.iter().zip(b)) {
                *beyond |= (a - b).abs() > limit;
            }
        }
    }
    is_beyond.iter().filter(|beyond| **beyond).count() as f64 / is_beyond.len() as f64
}

/// The table, with measures.
pub(crate) fn text(rows: &[Row]) -> String {
    let mut text = format!("{:<28} {:<29} {:<5}", "corruption", "scene", "file");
    for preset in Preset::ALL {
        let _ = write!(text, "{:<8}", preset.name());
    }
    text.push_str("idiff 0.016, 1 %   mean FLIP  worst tile  brightness  likely\n");
    for row in rows {
        let name = format!("{}{}", row.corruption, if row.is_small { " *" } else { "" });
        let _ = write!(text, "{name:<28} {:<29} {:<5}", row.scene, row.kind);
        let word = |is_caught: bool| if is_caught { "CAUGHT" } else { "passes" };
        for comparison in &row.comparisons {
            let _ = write!(text, "{:<8}", word(!comparison.passes()));
        }
        let share = row.idiff_share * 100.0;
        let _ = write!(text, "{:<7}({share:>6.2} %)  ", word(row.is_caught_by_idiff));
        let [exact, ..] = &row.comparisons;
        let flip = exact.flip.unwrap_or_default();
        let brightness = exact.checks.iter().find(|check| check.measure.contains("brightness"));
        let brightness = brightness.map_or(0.0, |check| check.measured);
        let cause = exact.cause.as_ref().map_or_else(String::new, ToString::to_string);
        let _ = writeln!(text, "{:>9.4}  {:>10.4}  {brightness:>10.4}  {cause}", flip.mean, flip.tile);
    }
    text.push_str("* hard to find: visual and noisy let it pass\n");
    text
}
