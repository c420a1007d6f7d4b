//! Files of a run that have the name of another file of the run, or of an input.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::canonical_path::canonical;
use crate::error::{Error, Result};
use crate::settings::PlatePattern;

use super::{Plan, PlannedFrame};

/// Names of the files that a run reads and writes. None may be written twice.
///
/// Written names that differ only in case are the same, because they are on many file systems. Inputs are compared as they are called: names of other case may be other files, which exist.
#[derive(Debug)]
pub struct UsedNames {
    /// Canonical names.
    inputs: BTreeSet<PathBuf>,
    /// Files that are written, by their names [`without_case`].
    written: BTreeMap<OsString, WrittenFile>,
    /// Canonical forms of folders. A folder is looked up once: on shared storage each call takes a message.
    folders: BTreeMap<PathBuf, PathBuf>,
}

#[derive(Debug)]
struct WrittenFile {
    /// Its canonical name.
    real: PathBuf,
    /// Its name for messages.
    shown: PathBuf,
    purpose: &'static str,
}

impl UsedNames {
    /// The names of `inputs`, and those that links of these names lead to.
    pub fn new(inputs: &[PathBuf]) -> Self {
        let names = inputs.iter().flat_map(|path| [Some(canonical(path)), path.canonicalize().ok()]);
        let inputs = names.flatten().collect();
        Self { inputs, written: BTreeMap::new(), folders: BTreeMap::new() }
    }

    /// Adds a file that is written, with what it is for later ones: `will hold a frame`. `reserved` tells what else a canonical name
    /// is used for.
    ///
    /// # Errors
    /// What is wrong with a name that is used already.
    pub fn add(
        &mut self,
        path: &Path,
        purpose: &'static str,
        reserved: impl FnOnce(&Path) -> Option<&'static str>,
    ) -> std::result::Result<(), String> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let real = match self.folders.get(folder) {
            Some(real) => real,
            None => self.folders.entry(folder.to_owned()).or_insert_with(|| canonical(&folder.join("x"))),
        };
        let real = real.with_file_name(path.file_name().unwrap_or_default());
        let reserved = || self.inputs.contains(&real).then_some("is an input").or_else(|| reserved(&real));
        let other = match self.written.get(&without_case(&real)) {
            Some(WrittenFile { real: other, shown, purpose }) if *other != real => {
                let [path, other] = [path, shown].map(Path::display);
                return Err(format!(
                    "\"{path}\" differs in case only from \"{other}\", which {purpose}; choose another name"
                ));
            }
            Some(other) => Some(other.purpose),
            None => reserved(),
        };
        self.written.insert(without_case(&real), WrittenFile { real, shown: path.to_owned(), purpose });
        let path = path.display();
        other.map_or(Ok(()), |other| {
            Err(format!("\"{path}\" {other} and cannot be written to as well; choose another name"))
        })
    }
}

/// A canonical name without its case, where it is Unicode: many file systems take such names for one.
pub fn without_case(canonical: &Path) -> OsString {
    canonical.to_str().map_or_else(|| canonical.as_os_str().to_owned(), |name| name.to_lowercase().into())
}

impl Plan {
    /// Refuses two files of one name, and files that would replace one of `inputs` or have the name of a plate, whatever its frame. `others`
    /// are the files beside the frames, each with the setting that names it.
    ///
    /// # Errors
    /// [`Error::Setting`] with the setting that names the second file.
    pub fn check_collisions(&self, others: &[(&Path, &'static str)], inputs: &[PathBuf]) -> Result<()> {
        let mut names = UsedNames::new(inputs);
        // Frames with one name make one movie; other names of frames differ.
        let frames: BTreeSet<&Path> = self.frames.iter().flat_map(PlannedFrame::paths).collect();
        let frames = frames.into_iter().map(|path| (path, "will hold a frame", "output"));
        let others = others.iter().map(|&(path, setting)| (path, "will hold something else", setting));
        let plate =
            |file: &Path| self.plates.as_ref().filter(|plates| is_plate(plates, file)).map(|_| "is a plate");
        for (path, purpose, setting) in frames.chain(others) {
            names.add(path, purpose, plate).map_err(|why| Error::setting(setting, why))?;
        }
        Ok(())
    }
}

/// Whether the canonical name `file` is that of a plate of any frame.
pub fn is_plate(plates: &PlatePattern, file: &Path) -> bool {
    plates.names_like(file).iter().any(|name| canonical(name) == file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_names_that_differ_in_case_only_are_the_same_and_inputs_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("Sky.exr"), "").unwrap();
        let mut names = UsedNames::new(&[at("Sky.exr")]);
        let mut add = |name: &str| {
            let added = names.add(&at(name), "will hold a frame", |real| {
                real.ends_with("plate.png").then_some("is a plate")
            });
            added.err().unwrap_or_default()
        };
        assert!(add("Sky.exr").contains("is an input and cannot be written"));
        assert!(add("plate.png").contains("is a plate and cannot be written"));
        assert_eq!(add("É/a.exr"), "");
        assert!(add("É/a.exr").contains("will hold a frame and cannot be written"));
        let other_case = add("é/A.exr");
        let words = ["é/A.exr\" differs in case only from", "É/a.exr\", which will hold a frame; choose"];
        assert!(words.iter().all(|word| other_case.contains(word)), "{other_case}");
        assert_eq!(add("b.exr"), "");
        let mut names = UsedNames::new(&[at("gone.exr")]);
        assert_eq!(names.add(&at("Gone.exr"), "will hold a frame", |_| None), Ok(()));
    }
}
