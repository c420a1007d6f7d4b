//! Detection of tiles that belong to another image.

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use crate::image_file::{ExrHeader, ExrTile, SharedAttributes};

/// Refuses the first tile whose attributes differ from those of most tiles. `is_one_image` says that all tiles are merged into
/// one image, whatever their frame numbers.
///
/// # Errors
/// [`Error::Invalid`] that names the tile and the first difference.
pub(super) fn refuse_foreign_tiles(tiles: &[ExrTile], is_one_image: bool) -> Result<()> {
    let mut counts = BTreeMap::<SharedAttributes<'_>, usize>::new();
    for tile in tiles {
        *counts.entry(tile.header.shared()).or_default() += 1;
    }
    if counts.len() <= 1 {
        return Ok(());
    }
    let most = counts.values().max().copied().unwrap_or(0);
    let is_usual = |tile: &&ExrTile| counts.get(&tile.header.shared()) == Some(&most);
    let Some(usual) = tiles.iter().find(is_usual) else {
        return Ok(());
    };
    let shared = usual.header.shared();
    match tiles.iter().find(|tile| tile.header.shared() != shared) {
        None => Ok(()),
        Some(foreign) => {
            let mut message = difference(&foreign.header, &usual.header);
            message.push_str(&usual.path.display().to_string());
            if is_one_image && foreign.header.frame() != usual.header.frame() {
                message.push_str("; put #### into -o to merge a sequence");
            }
            Err(Error::invalid(&foreign.path, "", message))
        }
    }
}

/// The most informative difference, to be read before the name of the usual tile.
fn difference(foreign: &ExrHeader, usual: &ExrHeader) -> String {
    let (theirs, ours) = (foreign.shared(), usual.shared());
    let differs = |name: &str| theirs.get(name) != ours.get(name);
    if differs("displayWindow") {
        let [theirs, ours] = [foreign, usual].map(|header| {
            let (width, height) = header.display_window.size();
            format!("{width}x{height}")
        });
        return format!("is part of an image of {theirs} pixels, not {ours} as ");
    }
    if differs("channels") {
        let [theirs, ours] = [foreign, usual].map(channels_text);
        return format!("has the channels {theirs}, not {ours} as ");
    }
    if differs("compression") {
        let [theirs, ours] = [foreign, usual].map(ExrHeader::compression_name);
        return format!("is compressed as {theirs}, not {ours} as ");
    }
    if let (true, Some(theirs), Some(ours)) = (differs("frame"), foreign.frame(), usual.frame()) {
        return format!("shows frame {theirs}, not {ours} as ");
    }
    if differs("renderHash") {
        return "was rendered from another scene, with other settings or by another version than ".to_owned();
    }
    let names = theirs.keys().chain(ours.keys());
    let name = names.copied().find(|name| differs(name)).unwrap_or_default();
    format!("has another attribute \"{name}\" than ")
}

fn channels_text(header: &ExrHeader) -> String {
    let channel = |(name, kind): &(String, _)| format!("{name} {}", format!("{kind:?}").to_lowercase());
    header.channels.iter().map(channel).collect::<Vec<_>>().join(", ")
}
