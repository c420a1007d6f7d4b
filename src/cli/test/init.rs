//! `rayframe test --init`: writes the suite file of a folder.

use std::path::Path;

use super::super::suite_options::SuiteOption;
use crate::progress::print_output;
use rayframe::error::{Error, Result};
use rayframe::image_file::{probe_folder, write_atomically};
use rayframe::regression::suite::{SUITE_FILE, Suite};
use rayframe::sequence::canonical;

/// A suite file. `{references}` and `{report}` stand for its folders.
const SUITE_TEXT: &str = r#"# A suite: `rayframe test` renders the shots of this folder and compares them with the images in {references}/.
# Every scene (.glb, .gltf) and every shot file (.toml) is a shot; a scene that a shot file names is not a shot by itself.
# See docs/suites.md.

references = "{references}"   # folder of the reference images, named like the shots
report = "{report}"           # folder of index.html
max_reference_kib = 1024    # size limit: references live in version control (or in Git LFS: git lfs track "*.exr")

[test]
preset = "visual"           # exact, strict, visual or noisy; shot files may have a table [test], too

[shot]                      # settings of all shots, as in shot files, which replace them
resolution = [320, 180]
samples = 4
aovs = ["object_id", "material_id"]   # a few bytes that find objects that changed; "albedo" and "depth" find more
"#;

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
    let [references, report] = folder_names(&file, folder);
    let text = SUITE_TEXT.replace("{references}", &references).replace("{report}", &report);
    write_atomically(&file, text.as_bytes())?;
    let hint = ignore(folder, &report)?;
    let suite = option.shown();
    print_output(&format!(
        "{} written; put a scene beside it, then:\n  rayframe test{suite}     renders it, and reports that there is no reference yet\n  rayframe accept{suite}   makes the rendered image the reference\n  rayframe test{suite}     passes until the image changes{hint}",
        file.display()
    ));
    Ok(())
}

/// The names of the folders of references and report of a new suite file in `folder`: others than those of the suites that are there, which
/// would replace each other's files.
fn folder_names(file: &Path, folder: &Path) -> [String; 2] {
    let names = ["references", "report"];
    let others = Suite::of_folder(folder);
    let is_taken = |name: &str| {
        let path = canonical(&folder.join(name));
        others
            .iter()
            .any(|suite| [&suite.references, &suite.report].iter().any(|other| canonical(other) == path))
    };
    if !names.into_iter().any(is_taken) {
        return names.map(str::to_owned);
    }
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    let stem: String = stem.chars().map(|c| if is_plain(c) { c } else { '-' }).collect();
    names.map(|name| format!("{stem}-{name}"))
}

/// Writes `.gitignore` where there is none. Returns a line about it; an empty one where nothing is to be told.
fn ignore(folder: &Path, report: &str) -> Result<String> {
    let ignored = format!("/{report}/\n*.new\n");
    let file = folder.join(".gitignore");
    match std::fs::read_to_string(&file) {
        Ok(text) if ignored.lines().all(|line| text.lines().any(|found| found.trim() == line)) => {
            Ok(String::new())
        }
        Err(_) if file.symlink_metadata().is_err() => {
            write_atomically(&file, ignored.as_bytes())?;
            Ok(format!("\n{} excludes the report and pending images from version control", file.display()))
        }
        // What lacks a line, cannot be read or leads nowhere is not ours to replace.
        _ => Ok(format!("\nadd to {}: {}", file.display(), ignored.replace('\n', " ").trim())),
    }
}
