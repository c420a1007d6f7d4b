//! Merging of rendered crops, or of sample ranges, into whole images, equal to those that one machine would have written.
//!
//! [`MergePlan::new`] checks the headers of all tiles before anything is written. [`join_frame`] joins one frame, and
//! [`write_joined_frame`] writes it.
//! Nothing is printed here, and the caller lists the files.

mod coverage;
mod foreign;
mod sample_ranges;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::cancel::CancelFlag;
use crate::error::{Error, Result, readable_bytes};
use crate::image::PixelWindow;
use crate::image_file::{
    ExrHeader, ExrTile, SAMPLE_RANGE, check_name, inspect_exr, is_empty_file, join_exr_tiles, probe_folder,
    remove_stale_temporaries, write_atomically_unless,
};
use crate::sequence::{OutputFormat, OutputPattern};
use crate::settings::Placeholder;

use coverage::{CoverageError, first_error};
use foreign::refuse_foreign_tiles;
use sample_ranges::{are_sample_ranges, by_crop, check_sample_ranges, join_sample_ranges_of_crops};

/// Copies of an image's pixels in memory: the tiles, the whole image, and the data being compressed.
const COPIES: u64 = 3;
/// The same of sample ranges: the first image, the sums, the next file, its image and sums, and the data being compressed.
const RANGE_COPIES: u64 = 6;

/// A frame that is merged from tiles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MergedFrame {
    /// Tiles that cover the frame, or sample ranges of it or of each of its crops.
    pub tiles: Vec<ExrTile>,
    /// Whether the files hold some of the samples of the same pixels each, not all samples of some pixels.
    pub are_sample_ranges: bool,
    /// Memory limit, bytes.
    pub max_memory_bytes: u64,
    /// Path of the merged file.
    pub path: PathBuf,
    /// Whether the merged file exists and is complete.
    pub is_done: bool,
}

/// Frames to merge, in the order of their numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MergePlan {
    /// The frames.
    pub frames: Vec<MergedFrame>,
}

impl MergePlan {
    /// Reads the headers of `tiles`, groups them by frame if `output` has a field for the frame number, and checks them. Creates
    /// nothing. Existing files are replaced if `may_replace`.
    ///
    /// # Errors
    /// [`Error::Missing`] and [`Error::Invalid`] for files that are not tiles, tiles of other images, gaps and overlaps;
    /// [`Error::Unsupported`] for tiles of lossy compression;
    /// [`Error::Usage`] for unusable output names; [`Error::CannotCreate`] when another file has the name;
    /// [`Error::Refused`] when an image needs more than `max_memory_bytes`.
    pub fn new(
        tiles: &[PathBuf],
        output: &OutputPattern,
        may_replace: bool,
        max_memory_bytes: u64,
    ) -> Result<Self> {
        check_output(output)?;
        let tiles: Vec<ExrTile> = tiles.par_iter().map(|path| read_tile(path)).collect::<Result<_>>()?;
        let inputs: BTreeSet<PathBuf> =
            tiles.iter().filter_map(|tile| tile.path.canonicalize().ok()).collect();
        let mut frames = Vec::new();
        for (frame, tiles) in by_frame(tiles, output)? {
            let path = output.path(frame);
            // A mixture differs in its channels, too, which would tell less.
            let are_sample_ranges = are_sample_ranges(&tiles)?;
            refuse_foreign_tiles(&tiles, !output.is_numbered())?;
            if are_sample_ranges {
                check_ranges_of_crops(&tiles, &path)?;
            } else {
                check_coverage(&tiles, &path)?;
            }
            check_memory(&tiles, are_sample_ranges, max_memory_bytes)?;
            if path.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
                return Err(Error::usage(format!(
                    "--output: \"{}\" is one of the tiles and cannot be written to as well; choose another name",
                    path.display()
                )));
            }
            check_name(&path)?;
            let is_done = !may_replace && is_merged(&path, &tiles, are_sample_ranges)?;
            frames.push(MergedFrame { tiles, are_sample_ranges, max_memory_bytes, path, is_done });
        }
        Ok(Self { frames })
    }

    /// Creates the folders, checks that files can be written there, and removes temporary files of ended runs.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] with the folder and the reason.
    pub fn prepare(&self) -> Result<()> {
        let paths: Vec<PathBuf> = self.frames.iter().map(|frame| frame.path.clone()).collect();
        let mut folders = BTreeSet::new();
        for path in &paths {
            if folders.insert(path.parent().map(Path::to_owned)) {
                probe_folder(path)?;
            }
        }
        remove_stale_temporaries(&paths);
        Ok(())
    }
}

/// Joins the tiles of a frame. Returns its file, and writes nothing.
///
/// # Errors
/// Those of reading the tiles.
pub fn join_frame(frame: &MergedFrame) -> Result<Vec<u8>> {
    if frame.are_sample_ranges {
        join_sample_ranges_of_crops(&frame.tiles, frame.max_memory_bytes)
    } else {
        join_exr_tiles(&frame.tiles)
    }
}

/// Writes the file of a joined frame as a whole or, where `cancel` is raised before, not at all.
///
/// # Errors
/// Those of [`write_atomically`](crate::image_file::write_atomically), and [`Error::Interrupted`].
pub fn write_joined_frame(frame: &MergedFrame, joined: &[u8], cancel: &CancelFlag) -> Result<()> {
    write_atomically_unless(cancel, &frame.path, joined)
}

fn check_output(output: &OutputPattern) -> Result<()> {
    if output.format() != OutputFormat::Exr {
        return Err(Error::usage("--output: tiles are merged into EXR files; end the name with .exr"));
    }
    if output.has_layer_place() {
        return Err(Error::usage("--output: split AOVs are merged one at a time; leave {layer} out"));
    }
    if let Some(name) = Placeholder::ALL.into_iter().find(|name| output.has_name(*name)) {
        let name = name.text();
        return Err(Error::usage(format!(
            "--output: tiles do not tell what {name} is; write the name itself, or %{name} for this text"
        )));
    }
    Ok(())
}

fn read_tile(path: &Path) -> Result<ExrTile> {
    let header = ExrHeader::read(path)?;
    if header.is_lossy() {
        let compression = header.compression_name();
        return Err(Error::unsupported(
            path,
            "",
            format!("{compression} is lossy and would change the pixels again; render tiles with --exr zip"),
        ));
    }
    let (data, display) = (header.data_window, header.display_window);
    if !display.contains(&data) {
        let (width, height) = display.size();
        let message = format!(
            "its pixels {} reach beyond the image of {width}x{height}",
            crop_text(&data.relative_to(&display))
        );
        return Err(Error::invalid(path, "", message));
    }
    Ok(ExrTile::new(path.to_owned(), header))
}

/// Groups tiles by frame number; all of them are one frame where `output` has no field for the number.
fn by_frame(tiles: Vec<ExrTile>, output: &OutputPattern) -> Result<BTreeMap<i64, Vec<ExrTile>>> {
    let mut frames = BTreeMap::<i64, Vec<ExrTile>>::new();
    for tile in tiles {
        let frame = match tile.header.frame() {
            _ if !output.is_numbered() => 0,
            Some(frame) => frame,
            None => {
                let message = "has no frame number; merge each frame separately, into a name without ####";
                return Err(Error::invalid(&tile.path, "", message));
            }
        };
        frames.entry(frame).or_default().push(tile);
    }
    Ok(frames)
}

/// Checks the sample ranges of each crop, and that several crops cover the image.
fn check_ranges_of_crops(tiles: &[ExrTile], path: &Path) -> Result<()> {
    let crops = by_crop(tiles);
    if crops.len() > 1 {
        let first_of_each: Vec<ExrTile> = crops.iter().filter_map(|crop| crop.first().cloned()).collect();
        check_coverage(&first_of_each, path)?;
    }
    crops.iter().try_for_each(|crop| check_sample_ranges(crop))
}

fn check_coverage(tiles: &[ExrTile], path: &Path) -> Result<()> {
    let Some(first) = tiles.first() else {
        return Err(Error::usage("there are no tiles to merge"));
    };
    let display = first.header.display_window;
    let windows: Vec<_> = tiles.iter().map(|tile| tile.header.data_window).collect();
    match first_error(display, &windows) {
        None => Ok(()),
        Some(CoverageError::Gap(gap)) => {
            let gap = crop_text(&gap.relative_to(&display));
            let message =
                format!("cannot be merged: no tile has the pixels {gap}; --crop {gap} renders them");
            Err(Error::invalid(path, "", message))
        }
        Some(CoverageError::Overlap(a, b, both)) => {
            let message = format!(
                "has the pixels {} that {} has as well",
                crop_text(&both.relative_to(&display)),
                tiles[a].path.display()
            );
            Err(Error::invalid(&tiles[b].path, "", message))
        }
    }
}

/// The window in the form of `--crop`.
fn crop_text(window: &PixelWindow<i64>) -> String {
    format!("{},{},{},{}", window.x0, window.y0, window.x1, window.y1)
}

/// The pixels of the merged image: the whole image, or the crop that all sample ranges share. `first` is one of the tiles.
fn merged_window(first: &ExrTile, tiles: &[ExrTile], are_sample_ranges: bool) -> PixelWindow<i64> {
    let crop = first.header.data_window;
    let is_one_crop = are_sample_ranges && tiles.iter().all(|tile| tile.header.data_window == crop);
    if is_one_crop { crop } else { first.header.display_window }
}

fn check_memory(tiles: &[ExrTile], are_sample_ranges: bool, max_memory_bytes: u64) -> Result<()> {
    let Some(tile) = tiles.first() else {
        return Ok(());
    };
    let copies = if are_sample_ranges { RANGE_COPIES } else { COPIES };
    let (width, height) = merged_window(tile, tiles, are_sample_ranges).size();
    let needed = u128::from(width) * u128::from(height) * u128::from(tile.header.pixel_bytes() * copies);
    if needed <= u128::from(max_memory_bytes) {
        return Ok(());
    }
    let message = format!(
        "merging {width}x{height} pixels takes {}, but only {} may be used",
        readable_bytes(needed),
        readable_bytes(u128::from(max_memory_bytes))
    );
    Err(Error::over_memory(&tile.path, "", message, None))
}

/// Whether the merged file exists and is complete; an error when another file has its name.
fn is_merged(path: &Path, tiles: &[ExrTile], are_sample_ranges: bool) -> Result<bool> {
    let is_there = path.symlink_metadata().is_ok() && !is_empty_file(path);
    let (true, Some(tile)) = (is_there, tiles.first()) else {
        return Ok(false);
    };
    let window = merged_window(tile, tiles, are_sample_ranges);
    let is_this_image = ExrHeader::read(path).is_ok_and(|header| {
        header.data_window == window
            && header.text(SAMPLE_RANGE).is_none()
            && header.render_hash().is_some()
            && header.is_same_image(&tile.header)
    });
    if is_this_image && inspect_exr(path).is_ok() {
        return Ok(true);
    }
    Err(Error::CannotCreate {
        path: path.to_owned(),
        message: "the file exists and is not the merged image of these tiles; --overwrite replaces it"
            .to_owned(),
    })
}

#[cfg(test)]
mod tests;
