//! Joining crops of a picture, or of the pictures of a sequence, into what one machine would have written.
//!
//! [`MergePlan::new`] looks at the headers of all tiles and finds whatever keeps them from being one picture before anything
//! is written; [`merge_frame`] joins and writes one. Which files are tiles, and the terminal, are the command line's business.

mod cover;
mod foreign;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::error::{Error, Result, readable_bytes};
use crate::image::PixelWindow;
use crate::image_file::{
    ExrHeader, ExrTile, check_name, inspect_exr, join_exr_tiles, probe_folder, remove_stale_temporaries,
    write_atomically,
};
use crate::sequence::{OutputFormat, OutputPattern};

use cover::{Fault, first_fault};
use foreign::refuse_foreign_tiles;

/// Copies of a picture's pixels in memory: the tiles, the whole, and what is being packed.
const COPIES: u64 = 3;

/// A picture that is made from tiles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MergedFrame {
    /// Its parts, which fill it.
    pub tiles: Vec<ExrTile>,
    /// The file.
    pub path: PathBuf,
    /// Whether the file is there already, whole, and says that it is this picture.
    pub is_done: bool,
}

/// Everything that is to be merged, in the order of frame numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MergePlan {
    /// The pictures.
    pub frames: Vec<MergedFrame>,
}

impl MergePlan {
    /// Reads the headers of `tiles`, deals them out to frames if `output` has a place for the frame number, and checks
    /// everything that can be known; creates nothing. Files that are in the way are replaced if `may_replace`.
    ///
    /// # Errors
    /// [`Error::Missing`] and [`Error::Invalid`] for files that are no tiles, foreign tiles, gaps and overlaps;
    /// [`Error::Usage`] for output names that make no sense; [`Error::CannotCreate`] when another file is in the way;
    /// [`Error::Refused`] when a picture needs more than `max_memory_bytes`.
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
            refuse_foreign_tiles(&tiles, !output.is_numbered())?;
            check_cover(&tiles, &path)?;
            check_memory(&tiles, max_memory_bytes)?;
            if path.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
                return Err(Error::usage(format!(
                    "--output: \"{}\" is one of the tiles and cannot be written to as well; choose another name",
                    path.display()
                )));
            }
            check_name(&path)?;
            let is_done = !may_replace && is_there(&path, &tiles)?;
            frames.push(MergedFrame { tiles, path, is_done });
        }
        Ok(Self { frames })
    }

    /// Creates the folders, makes sure that files can be written there, and removes what dead runs left half written.
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

/// Joins the tiles of a frame and writes it.
///
/// # Errors
/// Those of [`join_exr_tiles`] and of [`write_atomically`].
pub fn merge_frame(frame: &MergedFrame) -> Result<()> {
    write_atomically(&frame.path, &join_exr_tiles(&frame.tiles)?)
}

fn check_output(output: &OutputPattern) -> Result<()> {
    if output.format() != OutputFormat::Exr {
        return Err(Error::usage("--output: tiles are merged into EXR files; end the name with .exr"));
    }
    if output.has_layer_place() {
        return Err(Error::usage(
            "--output: layers with files of their own are merged one by one; leave {layer} out",
        ));
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
            format!(
                "{compression} has changed the pixels, and would change them again; render tiles with --exr zip"
            ),
        ));
    }
    let (part, picture) = (header.data_window, header.display_window);
    let is_inside =
        picture.x0 <= part.x0 && part.x1 <= picture.x1 && picture.y0 <= part.y0 && part.y1 <= picture.y1;
    if !is_inside {
        let (width, height) = picture.size();
        let message =
            format!("its pixels {} reach beyond the picture of {width}x{height}", corners(part, picture));
        return Err(Error::invalid(path, "", message));
    }
    Ok(ExrTile { path: path.to_owned(), header })
}

/// The tiles of each frame; of one frame where names have no place for a number.
fn by_frame(tiles: Vec<ExrTile>, output: &OutputPattern) -> Result<BTreeMap<i64, Vec<ExrTile>>> {
    let mut frames = BTreeMap::<i64, Vec<ExrTile>>::new();
    for tile in tiles {
        let frame = match tile.header.frame() {
            _ if !output.is_numbered() => 0,
            Some(frame) => frame,
            None => {
                let message =
                    "does not say its frame number; merge each frame by itself, into a name without ####";
                return Err(Error::invalid(&tile.path, "", message));
            }
        };
        frames.entry(frame).or_default().push(tile);
    }
    Ok(frames)
}

fn check_cover(tiles: &[ExrTile], path: &Path) -> Result<()> {
    let Some(first) = tiles.first() else {
        return Err(Error::usage("there are no tiles to merge"));
    };
    let picture = first.header.display_window;
    let windows: Vec<_> = tiles.iter().map(|tile| tile.header.data_window).collect();
    match first_fault(picture, &windows) {
        None => Ok(()),
        Some(Fault::Gap(gap)) => {
            let gap = corners(gap, picture);
            let message =
                format!("cannot be merged: no tile has the pixels {gap}; --crop {gap} renders them");
            Err(Error::invalid(path, "", message))
        }
        Some(Fault::Overlap(a, b, both)) => {
            let message = format!(
                "has the pixels {} that {} has as well",
                corners(both, picture),
                tiles[a].path.display()
            );
            Err(Error::invalid(&tiles[b].path, "", message))
        }
    }
}

/// As `--crop` takes them.
fn corners(part: PixelWindow<i64>, picture: PixelWindow<i64>) -> String {
    let (x, y) = (picture.x0, picture.y0);
    format!("{},{},{},{}", part.x0 - x, part.y0 - y, part.x1 - x, part.y1 - y)
}

fn check_memory(tiles: &[ExrTile], max_memory_bytes: u64) -> Result<()> {
    let Some(tile) = tiles.first() else {
        return Ok(());
    };
    let (width, height) = tile.header.display_window.size();
    let needed = u128::from(width) * u128::from(height) * u128::from(tile.header.pixel_bytes() * COPIES);
    if needed <= u128::from(max_memory_bytes) {
        return Ok(());
    }
    let message = format!(
        "merging {width}x{height} pixels takes {}, but only {} may be used; raise --max-memory",
        readable_bytes(needed),
        readable_bytes(u128::from(max_memory_bytes))
    );
    Err(Error::refused(&tile.path, "", message))
}

/// Whether the whole picture is there already; an error when something else is.
fn is_there(path: &Path, tiles: &[ExrTile]) -> Result<bool> {
    let (true, Some(tile)) = (path.exists(), tiles.first()) else {
        return Ok(false);
    };
    let is_this_picture = ExrHeader::read(path).is_ok_and(|there| {
        there.data_window == there.display_window
            && there.render_hash().is_some()
            && there.shared() == tile.header.shared()
    });
    if is_this_picture && inspect_exr(path).is_ok() {
        return Ok(true);
    }
    Err(Error::CannotCreate {
        path: path.to_owned(),
        message: "the file is there and is not the whole picture of these tiles; --overwrite replaces it"
            .to_owned(),
    })
}

#[cfg(test)]
mod tests;
