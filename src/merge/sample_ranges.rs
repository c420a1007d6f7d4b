//! Merging of sample ranges: files whose exact sums add up to the image that one run gives.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use crate::error::{Error, Result};
use crate::film::{AovFlags, Film, PixelWindow, SampleSums, SumFlags};
use crate::image::{Image, Samples};
use crate::image_file::{ExrTile, SAMPLE_RANGE, SUM_LAYER, decode_exr, encode_exr_like, join_encoded_tiles};
use crate::output::{LightSamples, sum_flags, summed_channels, sums_of_image};

/// What to do with sample ranges beside crops of all samples.
const MERGE_ORDER: &str = "merge the sample ranges of each crop first, and then the crops";

/// The samples that a file holds.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Part {
    samples: RangeInclusive<u32>,
    of: u32,
}

/// Whether the files are sample ranges. Files of crops are not.
///
/// # Errors
/// [`Error::Invalid`], which names the file: one with all samples among sample ranges, or a sample range among files of all samples.
pub(super) fn are_sample_ranges(tiles: &[ExrTile]) -> Result<bool> {
    let is_range = |tile: &&ExrTile| tile.header.text(SAMPLE_RANGE).is_some();
    let (ranges, whole): (Vec<&ExrTile>, Vec<&ExrTile>) = tiles.iter().partition(is_range);
    let (Some(range), Some(other)) = (ranges.first(), whole.first()) else {
        return Ok(whole.is_empty() && !ranges.is_empty());
    };
    if whole.len() > ranges.len() {
        let why = format!("holds only some samples, but {} has all; {MERGE_ORDER}", other.path.display());
        return Err(invalid(range, why));
    }
    Err(invalid(
        other,
        format!("has all samples, but {} holds only some; {MERGE_ORDER}", range.path.display()),
    ))
}

/// The files of each crop, from the top left.
pub(super) fn by_crop(tiles: &[ExrTile]) -> Vec<Vec<ExrTile>> {
    let mut crops = BTreeMap::<_, Vec<ExrTile>>::new();
    for tile in tiles {
        let window = tile.header.data_window;
        crops.entry((window.y0, window.x0, window.y1, window.x1)).or_default().push(tile.clone());
    }
    crops.into_values().collect()
}

/// Checks that sample ranges of one crop have each sample once.
///
/// # Errors
/// [`Error::Invalid`], which names the file: samples that are missing or there twice.
pub(super) fn check_sample_ranges(tiles: &[ExrTile]) -> Result<()> {
    let mut parts = Vec::new();
    for tile in tiles {
        if let Some(text) = tile.header.text(SAMPLE_RANGE) {
            parts.push((parse(tile, &text)?, tile));
        }
    }

    // Every sample once
    parts.sort_by_key(|(part, _)| *part.samples.start());
    let mut next = 0;
    for (part, tile) in &parts {
        let (first, last) = (*part.samples.start(), *part.samples.end());
        if first > next {
            return Err(without_samples(tile, next, first - 1));
        }
        if first < next {
            return Err(invalid(tile, format!("has sample {first}, which another file has as well")));
        }
        next = last + 1;
    }
    match parts.last() {
        Some((part, tile)) if next < part.of => Err(without_samples(tile, next, part.of - 1)),
        _ => Ok(()),
    }
}

/// No file has the samples from `first` to `last`.
fn without_samples(tile: &ExrTile, first: u32, last: u32) -> Error {
    let (missing, them) = if first == last {
        (format!("sample {first}"), "it")
    } else {
        (format!("the samples {first} to {last}"), "them")
    };
    invalid(tile, format!("cannot be merged: no file has {missing}; --sample-range renders {them}"))
}

/// Merges sample ranges of one crop, or of crops that cover the image.
///
/// # Errors
/// Those of [`join_sample_ranges`] and of joining the crops.
pub(super) fn join_sample_ranges_of_crops(tiles: &[ExrTile], max_memory_bytes: u64) -> Result<Vec<u8>> {
    let crops = by_crop(tiles);
    if let [crop] = crops.as_slice() {
        return join_sample_ranges(crop, max_memory_bytes);
    }
    let mut joined = Vec::new();
    for crop in &crops {
        let path = crop.first().map(|tile| tile.path.clone()).unwrap_or_default();
        joined.push((path, join_sample_ranges(crop, max_memory_bytes)?));
    }
    join_encoded_tiles(joined)
}

/// Adds up sample ranges of one crop and encodes the image as a run of all samples does.
///
/// # Errors
/// Those of reading the files; [`Error::Invalid`] for a file without sums.
fn join_sample_ranges(tiles: &[ExrTile], max_memory_bytes: u64) -> Result<Vec<u8>> {
    let mut joined: Option<(Image, SampleSums)> = None;
    for tile in tiles {
        let (image, sums) = read_sums(tile, max_memory_bytes)?;
        match &mut joined {
            None => joined = Some((image, sums)),
            Some((_, all)) => all.merge(&sums),
        }
    }
    let (Some((image, sums)), Some(first)) = (joined, tiles.first()) else {
        return Err(Error::Internal { message: "there are no sample ranges to merge".to_owned() });
    };
    encode_exr_like(first, resolved(image, sums)?)
}

/// The image with means of all samples.
fn resolved(mut image: Image, sums: SampleSums) -> Result<Image> {
    let SumFlags { light, moments: noise, guides, .. } = sums.flags();
    let aovs = AovFlags { light, noise, guides, ..AovFlags::NONE };
    let mut film = Film::with_aovs(image.display_window.size(), image.data_window, aovs);
    sums.resolve_into(&mut film);
    drop(sums);
    let samples = match image.channel("R").map(|channel| &channel.samples) {
        Some(Samples::Half(_)) => LightSamples::Half,
        _ => LightSamples::Float,
    };
    for summed in summed_channels(&film, samples)? {
        if let Some(channel) = image.channels.iter_mut().find(|channel| channel.name == summed.name) {
            channel.samples = summed.samples;
        }
    }
    Ok(image)
}

fn read_sums(tile: &ExrTile, max_memory_bytes: u64) -> Result<(Image, SampleSums)> {
    let bytes = std::fs::read(&tile.path).map_err(Error::missing(&tile.path))?;
    let mut image = decode_exr(&tile.path, &bytes, max_memory_bytes)?;
    drop(bytes);
    let flags = sum_flags(image.channels.iter().map(|channel| channel.name.as_str()));
    let sums = flags.and_then(|flags| sums_of_image(&image, flags));
    // A file that was changed since planning may be of another crop.
    let expected: Option<PixelWindow> =
        tile.header.data_window.relative_to(&tile.header.display_window).to_unsigned();
    let sums = sums.filter(|sums| Some(sums.window) == expected);
    let sums = sums.ok_or_else(|| invalid(tile, "has a sample range, but not its sums".to_owned()))?;
    image.channels.retain(|channel| !channel.name.starts_with(SUM_LAYER));
    Ok((image, sums))
}

/// Parses `0-63/256`.
fn parse(tile: &ExrTile, text: &str) -> Result<Part> {
    let parsed = || {
        let (samples, of) = text.split_once('/')?;
        let (first, last) = samples.split_once('-')?;
        let (first, last, of) = (first.parse().ok()?, last.parse().ok()?, of.parse().ok()?);
        (first <= last && last < of).then_some(Part { samples: first..=last, of })
    };
    parsed()
        .ok_or_else(|| invalid(tile, format!("has no readable sample range: \"{}\"", text.escape_debug())))
}

fn invalid(tile: &ExrTile, why: String) -> Error {
    Error::invalid(&tile.path, "", why)
}
