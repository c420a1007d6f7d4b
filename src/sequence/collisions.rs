//! Files of a run that have the name of another file of the run, or of an input.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::canonical_path::canonical;
use crate::error::{Error, Result};
use crate::settings::PlatePattern;

use super::{Plan, PlannedFrame};

/// Names of the files that a run reads and writes. None may be written twice.
#[derive(Debug)]
pub struct UsedNames {
    /// What each canonical name is used for.
    names: BTreeMap<PathBuf, &'static str>,
    /// Canonical forms of folders. A folder is looked up once: on shared storage each call takes a message.
    folders: BTreeMap<PathBuf, PathBuf>,
}

impl UsedNames {
    /// The names of `inputs`, and those that links of these names lead to.
    pub fn new(inputs: &[PathBuf]) -> Self {
        let names = inputs.iter().flat_map(|path| [Some(canonical(path)), path.canonicalize().ok()]);
        Self { names: names.flatten().map(|path| (path, "is an input")).collect(), folders: BTreeMap::new() }
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
        let reserved = reserved(&real);
        match self.names.insert(real, purpose).or(reserved) {
            Some(other) => {
                let path = path.display();
                Err(format!("\"{path}\" {other} and cannot be written to as well; choose another name"))
            }
            None => Ok(()),
        }
    }
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
