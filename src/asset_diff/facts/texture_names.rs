//! Names of textures that survive a change of the file format.

use crate::scene::{Scene, TextureIndex};

/// The name of a texture without folder and ending.
pub(super) fn texture_name(scene: &Scene, texture: TextureIndex) -> Option<&str> {
    let name = scene.texture_name(texture)?;
    let file = name.rsplit('/').next().unwrap_or(name);
    let is_ending =
        |ending: &str| ["png", "jpg", "jpeg", "webp", "ktx2"].contains(&ending.to_ascii_lowercase().as_str());
    Some(file.rsplit_once('.').filter(|(_, ending)| is_ending(ending)).map_or(file, |(stem, _)| stem))
}
