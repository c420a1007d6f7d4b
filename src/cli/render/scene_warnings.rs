//! Warnings about a scene and its sequences, told before the first frame.

use rayframe::error::{Result, Warning};
use rayframe::sequence::{Plan, ReplacedFile, triangle_count};
use rayframe::shot::RenderJob;

use crate::cli::warnings::{report_warnings, unique_warnings};
use crate::progress::print_warning;

/// Prints the warnings of all jobs of a scene, and returns them.
pub(super) fn report_scene(jobs: &[RenderJob]) -> Result<Vec<Warning>> {
    let Some(first) = jobs.first() else { return Ok(Vec::new()) };
    let choices: Vec<_> = jobs.iter().flat_map(|job| job.choices.iter().cloned()).collect();
    let scene = &first.sequence.scene;
    report_warnings(&scene.path, &choices, false)?;
    report_warnings(&scene.path, &first.warnings, first.sequence.strict)?;
    let mut told = unique_warnings(&choices);
    told.extend(unique_warnings(&first.warnings));
    if triangle_count(scene, &first.sequence.selection.roots) == 0 {
        let warning = Warning::of_file("the scene draws no triangles; only the environment is visible");
        print_warning(&format!("{}: {warning}", scene.path.display()));
        told.push(warning);
    }
    Ok(told)
}

/// Prints the warning about files that the sequences of a scene replace, and returns it.
pub(super) fn report_replaced(planned: &[(&RenderJob, &Plan)]) -> Option<Warning> {
    let replaced: Vec<_> = planned.iter().flat_map(|(_, plan)| plan.replaced.iter().cloned()).collect();
    let warning = Warning::of_file(replacing_text(&replaced)?);
    print_warning(&warning.to_string());
    Some(warning)
}

/// Warning about files that `--resume` replaces; `None` without any.
fn replacing_text(replaced: &[ReplacedFile]) -> Option<String> {
    let first = replaced.first()?;
    let example = format!("\"{}\" is {}", first.path.display(), first.why);
    Some(match replaced.len() {
        1 => format!("--resume: 1 file made from something else will be replaced: {example}"),
        count => {
            format!("--resume: {count} files made from something else will be replaced; the first, {example}")
        }
    })
}
