//! Files of a run that have the name of another file of the run, or of an input.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::canonical_path::canonical;
use crate::error::{Error, Result};
use crate::settings::PlatePattern;

use super::{Plan, PlannedFrame};

impl Plan {
    /// Refuses two files of one name, and files that would replace one of `inputs` or have the name of a plate, whatever its frame. `others`
    /// are the files beside the frames, each with the setting that names it.
    ///
    /// # Errors
    /// [`Error::Setting`] with the setting that names the second file.
    pub fn check_collisions(&self, others: &[(&Path, &'static str)], inputs: &[PathBuf]) -> Result<()> {
        let mut names: BTreeMap<PathBuf, &str> =
            inputs.iter().map(|path| (canonical(path), "is an input")).collect();
        // Frames with one name make one movie; other names of frames differ.
        let frames: BTreeSet<&Path> = self.frames.iter().flat_map(PlannedFrame::paths).collect();
        let frames = frames.into_iter().map(|path| (path, "will hold a frame", "output"));
        let others = others.iter().map(|&(path, setting)| (path, "will hold something else", setting));
        // A folder is looked up once: on shared storage each call takes a message.
        let mut folders = BTreeMap::new();
        for (path, purpose, setting) in frames.chain(others) {
            let folder = path.parent().unwrap_or(Path::new(""));
            let real = folders.entry(folder).or_insert_with(|| canonical(&folder.join("x")));
            let real = real.with_file_name(path.file_name().unwrap_or_default());
            let plate = self.plates.as_ref().filter(|plates| is_plate(plates, &real)).map(|_| "is a plate");
            if let Some(other) = names.insert(real, purpose).or(plate) {
                let path = path.display();
                let why = format!("\"{path}\" {other} and cannot be written to as well; choose another name");
                return Err(Error::setting(setting, why));
            }
        }
        Ok(())
    }
}

/// Whether the canonical name `file` is that of a plate of any frame.
pub fn is_plate(plates: &PlatePattern, file: &Path) -> bool {
    plates.names_like(file).iter().any(|name| canonical(name) == file)
}
