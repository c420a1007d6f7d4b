//! `rayframe test --list` and `--list-images`: the shots of a suite and their images, without rendering.

use crate::progress::{one_line, print_output};
use rayframe::error::Result;
use rayframe::regression::suite::{RunOptions, Suite, chosen_shots, discover, image_names};

/// Prints the shots that `options` select, each followed by its images if `has_images`.
///
/// # Errors
/// Those of reading the suite. The first error of a shot that cannot be opened, after all others are printed.
pub(super) fn list(suite: &Suite, options: &RunOptions, has_images: bool) -> Result<()> {
    let mut lines = Vec::new();
    let mut first_error = None;
    for shot in chosen_shots(suite, &discover(suite)?, options)? {
        lines.push(one_line(&shot.name));
        if !has_images {
            continue;
        }
        match image_names(suite, &shot) {
            Ok(names) => lines.extend(names.iter().map(|name| format!("  {}", one_line(name)))),
            Err(error) => {
                lines.push("  cannot be rendered".to_owned());
                first_error.get_or_insert(error);
            }
        }
    }
    if !lines.is_empty() {
        print_output(&lines.join("\n"));
    }
    first_error.map_or(Ok(()), Err)
}
