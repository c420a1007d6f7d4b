//! `rayframe test --init`: a folder becomes a suite.

use std::path::Path;

use super::super::suite_options::SuiteOption;
use crate::progress::print_output;
use rayframe::error::{Error, Result};
use rayframe::image_file::{probe_folder, write_atomically};
use rayframe::regression::suite::SUITE_FILE;

const SUITE_TEXT: &str = r#"# A suite: `rayframe test` renders what is here and compares it with the pictures in references/.
# Every scene (.glb, .gltf) is a shot, and every shot file (.toml) that names one; a scene that a shot file names is none by itself.
# docs/suites.md tells more.

references = "references"   # expected pictures, at the paths of the shots
report = "report"           # index.html goes here when something differs, or nothing
max_reference_kib = 1024    # what is larger is refused: references live in version control (or in Git LFS: git lfs track "*.exr")

[test]
preset = "visual"           # exact, strict, visual or noisy; a shot file may have a table [test] of its own

[shot]                      # settings of all shots, as in shot files; a shot's own come first
resolution = [320, 180]
samples = 4
frames = 0                  # of an animation: 0, [0, 12, 24], "1-10" or "all"
layers = ["object_id", "material_id"]   # few bytes that tell what moved from what looks otherwise; "albedo" and "depth" tell more
"#;

/// What version control leaves alone.
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
    if file.exists() {
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
        Ok(_) => format!("\nadd to {}: {}", ignore.display(), IGNORED.replace('\n', " ").trim()),
        Err(_) => {
            write_atomically(&ignore, IGNORED.as_bytes())?;
            format!("\n{} leaves the report and what waits out of version control", ignore.display())
        }
    };
    let suite = option.shown();
    print_output(&format!(
        "{} written; put a scene beside it, then:\n  rayframe test{suite}     renders it, and says that there is no reference yet\n  rayframe accept{suite}   makes what was rendered the reference\n  rayframe test{suite}     passes until the picture changes{hint}",
        file.display()
    ));
    Ok(())
}
