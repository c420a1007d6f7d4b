//! Where files may lead that a shot file or a suite file names as outputs: into its own folder, or into those of `--allow-dir`.

use std::path::{Path, PathBuf};

use rayframe::error::{Error, Provenance, Result};
use rayframe::sequence::canonical;
use rayframe::settings::Settings;

/// The settings that name outputs.
const OUTPUTS: [&str; 6] = ["output", "movie", "contact_sheet", "stats", "manifest", "asset_cache"];

/// Checks the outputs that shot files name, before anything is read. Names with placeholders are checked again where these are filled.
///
/// # Errors
/// [`Error::Refused`] for a path outside the folder of its file and of all `allowed` folders: those of the command line, since a shot file
/// permits itself nothing but to read.
pub(super) fn check_outputs(settings: &Settings, allowed: &[PathBuf]) -> Result<()> {
    let values = settings.values();
    for setting in OUTPUTS {
        let Some(Provenance::File { path: file, .. }) = settings.origin_of(setting) else { continue };
        let path = match setting {
            "output" => values.output.as_ref().map(|pattern| PathBuf::from(pattern.shown())),
            "movie" => values.movie.clone(),
            "contact_sheet" => values.contact_sheet.clone(),
            "stats" => values.stats.clone(),
            "asset_cache" => values.asset_cache.clone(),
            _ => values.manifest.clone(),
        };
        if let Some(path) = path {
            check_inside(file, setting, &path, allowed)?;
        }
    }
    Ok(())
}

/// Checks that `path`, which `file` names by the key `key`, is inside the folder of `file` or one of `allowed`.
///
/// # Errors
/// [`Error::Refused`].
pub(super) fn check_inside(file: &Path, key: &str, path: &Path, allowed: &[PathBuf]) -> Result<()> {
    let real = |path: &Path| canonical(&path.join("x")).parent().map(Path::to_owned).unwrap_or_default();
    let target = canonical(path);
    let own = real(file.parent().unwrap_or(Path::new("")));
    if target.starts_with(own) || allowed.iter().any(|folder| target.starts_with(real(folder))) {
        return Ok(());
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let message = format!(
        "{key}: \"{}\" leads outside the folder of this file; --allow-dir \"{}\" permits it",
        path.display(),
        folder.display()
    );
    Err(Error::refused(file, "", message))
}
