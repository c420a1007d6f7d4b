//! Detection of tiles that belong to another image.

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use crate::image_file::{ExrHeader, ExrSampleType, ExrTile, SharedAttributes};

/// Channels that an error lists: as many as a file of colours has.
const LISTED_CHANNELS: usize = 4;

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
    if differs("channels")
        && let Some(difference) = difference_of_channels(foreign, usual)
    {
        return difference;
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

/// The channels that only one of the files has, in that type. `None` where they differ in other ways.
fn difference_of_channels(foreign: &ExrHeader, usual: &ExrHeader) -> Option<String> {
    let only_in = |header: &ExrHeader, other: &ExrHeader| {
        let only = header.channels.iter().filter(|channel| !other.channels.contains(channel));
        channels_text(&only.collect::<Vec<_>>())
    };
    match (only_in(foreign, usual), only_in(usual, foreign)) {
        (Some(theirs), Some(ours)) => Some(format!("has the channels {theirs}, not {ours} as ")),
        (Some(theirs), None) => Some(format!("has the channels {theirs} besides those of ")),
        (None, Some(ours)) => Some(format!("lacks the channels {ours} of ")),
        (None, None) => None,
    }
}

/// The first channels with their types, and the number of others. `None` without channels.
fn channels_text(channels: &[&(String, ExrSampleType)]) -> Option<String> {
    let channel =
        |(name, kind): &&(String, ExrSampleType)| format!("{name} {}", format!("{kind:?}").to_lowercase());
    let listed: Vec<_> = channels.iter().take(LISTED_CHANNELS).map(channel).collect();
    let more = channels.len() - listed.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!listed.is_empty()).then(|| listed.join(", ") + &more)
}
