//! Settings to the options of the import.

use crate::gltf::{ImageLoading, ImportOptions};
use crate::settings::SettingValues;

use super::memory_limit::max_memory_bytes;

/// The options for importing the scene and what settings name beside it.
pub(super) fn import_options(values: &SettingValues, images: ImageLoading) -> ImportOptions {
    let allowed_folders = values.allow_dir.clone();
    ImportOptions { max_memory_bytes: max_memory_bytes(values), images, allowed_folders }
}
