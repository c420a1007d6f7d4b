//! Files beside the frames: movie, contact sheet, statistics and manifest.

use std::path::Path;

use crate::error::Result;
use crate::image_file::{OutputKind, check_new_names, check_output, probe_folder, remove_stale_temporaries};

/// Checks that files beside the frames, each with the setting that names it, replace nothing but such files.
///
/// # Errors
/// Those of [`check_output`].
pub fn check_other_files<'a>(
    files: impl IntoIterator<Item = (&'a Path, &'static str)>,
    overwrites: bool,
) -> Result<()> {
    files.into_iter().try_for_each(|(path, setting)| {
        if let Some(kind) = OutputKind::of_setting(setting) {
            check_output(path, kind, overwrites)?;
        }
        check_new_names(path)
    })
}

/// Creates the folders of files beside the frames, checks that they can be written there, and removes temporary files of ended runs.
///
/// # Errors
/// Those of [`probe_folder`].
pub fn prepare_other_files(files: &[(&Path, &'static str)]) -> Result<()> {
    for (path, _) in files {
        probe_folder(path)?;
        remove_stale_temporaries(&[path.to_path_buf()]);
    }
    Ok(())
}
