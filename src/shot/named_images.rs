//! The images that the settings of a shot name. Neither its scene nor any image is read.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::error::Result;
use crate::settings::{BackgroundSource, PlatePattern};

use super::environment::environment_request;
use super::job::{ShotRequest, shot_settings};

/// Environments and plates of shots.
#[derive(Debug, Default)]
pub struct NamedImages {
    /// Canonical paths of environments.
    environments: BTreeSet<PathBuf>,
    plates: Vec<PlatePattern>,
}

impl NamedImages {
    /// Adds the images of a shot.
    ///
    /// # Errors
    /// Those of reading its settings.
    pub fn add(&mut self, request: &ShotRequest<'_>) -> Result<()> {
        let values = shot_settings(request)?.values;
        let files = environment_request(&values);
        self.environments.extend(files.files().filter_map(|file| file.canonicalize().ok()));
        if let BackgroundSource::Plate(plates) = values.background
            && !self.plates.contains(&plates)
        {
            self.plates.push(plates);
        }
        Ok(())
    }

    /// Whether `file` is an environment, or the plate of any frame.
    pub fn contains(&self, file: &Path) -> bool {
        let Ok(file) = file.canonicalize() else { return false };
        let is_plate = |plate: &PathBuf| plate.canonicalize().is_ok_and(|plate| plate == file);
        self.environments.contains(&file)
            || self.plates.iter().any(|plates| plates.names_like(&file).iter().any(is_plate))
    }
}
