//! Corrupted images against the presets of comparisons and, beside them, the limits that Blender's tests give `idiff`.
//!
//! `cargo test --test library corruptions -- --nocapture` prints the table. Each corruption is compared as light (as in EXR
//! files) and as display values (8-bit PNG files). `CAUGHT` is a preset that fails, as it should for all
//! but a little noise or exposure.

mod corruption;
mod images;
mod table;

use std::path::Path;

use rayframe::regression::{Cause, Preset};

#[test]
fn strict_catches_all_corruptions_and_visual_all_visible_ones() {
    let rows = table::rows(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")).unwrap();
    assert_eq!(rows.len(), 2 * (3 + 2 * 4));
    let text = table::text(&rows);
    print_table(&text);
    for row in &rows {
        for (preset, comparison) in Preset::ALL.into_iter().zip(&row.comparisons) {
            let must_catch = match preset {
                Preset::Exact | Preset::Strict => true,
                Preset::Visual => !row.is_small,
                // Wide limits promise only to let small things pass.
                Preset::Noisy if row.is_small => false,
                Preset::Noisy => continue,
            };
            let (corruption, kind) = (row.corruption, row.kind);
            assert_eq!(!comparison.passes(), must_catch, "{corruption}, {kind}, {}:\n{text}", preset.name());
        }
    }
    // The limits of Blender's tests let a lost object pass.
    assert!(rows.iter().any(|row| row.corruption == "speck of 6x6 pixels" && !row.is_caught_by_idiff));
    causes_are_inferred_from_colours_alone(&rows);
}

fn causes_are_inferred_from_colours_alone(rows: &[table::Row]) {
    for row in rows {
        let [exact, ..] = &row.comparisons;
        let is_right = match row.corruption {
            "shift by one pixel" => matches!(exact.cause, Some(Cause::Camera { .. })),
            "noise of sigma 0.01" => matches!(exact.cause, Some(Cause::Noise)),
            // In eight bits 2 % are about one step, and rounding explains as much as a factor.
            "exposure +2 %" => {
                row.kind == "PNG" || matches!(exact.cause, Some(Cause::Light { factors: Some(_) }))
            }
            _ => true,
        };
        assert!(is_right, "{} of {} as {}: {:?}", row.corruption, row.scene, row.kind, exact.cause);
    }
}

#[expect(clippy::print_stdout, reason = "the table that docs/regression.md refers to")]
fn print_table(text: &str) {
    print!("{text}");
}
