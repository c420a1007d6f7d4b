//! `rayframe test --init`: writes the suite file of a folder.

use std::path::Path;

use super::super::suite_options::SuiteOption;
use crate::progress::print_output;
use rayframe::error::{Error, Result};
use rayframe::image_file::{probe_folder, write_atomically};
use rayframe::regression::suite::SUITE_FILE;

const SUITE_TEXT: &str = r#"# A suite: `rayframe test` renders the shots of this folder and compares them with the images in references/.
# Every scene (.glb, .gltf) and every shot file (.toml) is a shot; a scene that a shot file names is not a shot by itself.
# See docs/suites.md.

references = "references"   # folder of the reference images, named like the shots
report = "report"           # folder of index.html
max_reference_kib = 1024    # size limit: references live in version control (or in Git LFS: git lfs track "*.exr")

[test]
preset = "visual"           # exact, strict, visual or noisy; shot files may have a table [test], too

[shot]                      # settings of all shots, as in shot files, which replace them
resolution = [320, 180]
samples = 4
aovs = ["object_id", "material_id"]   # a few bytes that find objects that changed; "albedo" and "depth" find more
"#;

/// The patterns of `.gitignore`.
const IGNORED: &str = "/report/\n*.new\n";

/// Writes `suite.toml`, and `.gitignore` where there is none.
///
/// # Errors
/// [`Error::CannotCreate`] when there is a suite already or the folder cannot be written to.
pub(super) fn init(option: &SuiteOption) -> Result<()> {
    let folder = option.folder();
    let is_file = folder.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let file = if is_file { folder.to_owned() } else { folder.join(SUITE_FILE) };
    let folder = file.parent().unwrap_or(Path::new(""));
    if file.symlink_metadata().is_ok() {
        let message = "is there already; edit it, or name another folder with --suite".to_owned();
        return Err(Error::CannotCreate { path: file, message });
    }
    probe_folder(&file)?;
    write_atomically(&file, SUITE_TEXT.as_bytes())?;
    let ignore = folder.join(".gitignore");
    let hint = match std::fs::read_to_string(&ignore) {
        Ok(text) if IGNORED.lines().all(|line| text.lines().any(|found| found.trim() == line)) => {
            String::new()
        }
        Err(_) if ignore.symlink_metadata().is_err() => {
            write_atomically(&ignore, IGNORED.as_bytes())?;
            format!("\n{} excludes the report and pending images from version control", ignore.display())
        }
        // What lacks a line, cannot be read or leads nowhere is not ours to replace.
        _ => format!("\nadd to {}: {}", ignore.display(), IGNORED.replace('\n', " ").trim()),
    };
    let suite = option.shown();
    print_output(&format!(
        "{} written; put a scene beside it, then:\n  rayframe test{suite}     renders it, and reports that there is no reference yet\n  rayframe accept{suite}   makes the rendered image the reference\n  rayframe test{suite}     passes until the image changes{hint}",
        file.display()
    ));
    Ok(())
}
