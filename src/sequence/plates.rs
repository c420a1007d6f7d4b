//! Image plates behind the frames of a job: their files, and the pixels behind a frame.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use sha2::{Digest as _, Sha256};

use crate::error::{Error, Result};
use crate::image::{PixelWindow, Plate, PlateFit, resample};
use crate::image_file::{PlateHeader, plate_header, read_plate, read_regular_file};
use crate::settings::PlatePattern;

/// Bytes of a linear pixel.
const BYTES_A_PIXEL: u128 = 16;

/// The plates of the frames of a job. Their files are checked, and read again when a frame needs them.
#[derive(Clone, Debug, PartialEq)]
pub struct Plates {
    pattern: PlatePattern,
    fit: PlateFit,
    max_memory_bytes: u64,
    files: BTreeMap<PathBuf, PlateFile>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct PlateFile {
    content_hash: [u8; 32],
    header: PlateHeader,
}

impl Plates {
    /// Reads the plates of `frames` once: whether they are there, what they are, and their hashes.
    ///
    /// # Errors
    /// [`Error::Missing`] with the name and the frame of a plate, and those of [`plate_header`].
    pub fn open(
        pattern: &PlatePattern,
        fit: PlateFit,
        frames: &[i64],
        max_memory_bytes: u64,
    ) -> Result<Self> {
        let of_frames = frames.iter().map(|&frame| (pattern.path(frame), frame));
        let first_frames: BTreeMap<PathBuf, i64> = of_frames.rev().collect();
        let files: Vec<Result<(PathBuf, PlateFile)>> = first_frames
            .into_par_iter()
            .map(|(path, frame)| {
                let bytes = read_regular_file(&path, max_memory_bytes)
                    .map_err(|error| for_frame(error, pattern.is_numbered().then_some(frame)))?;
                let header = plate_header(&path, &bytes, max_memory_bytes)?;
                let content_hash = Sha256::digest(&bytes).into();
                Ok((path, PlateFile { content_hash, header }))
            })
            .collect();
        // Of several errors, that of the first file, whatever thread was the fastest.
        let files = files.into_iter().collect::<Result<_>>()?;
        Ok(Self { pattern: pattern.clone(), fit, max_memory_bytes, files })
    }

    /// The names of all plates, of other frames, too.
    pub(super) fn pattern(&self) -> &PlatePattern {
        &self.pattern
    }

    /// The files.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.files.keys().map(PathBuf::as_path)
    }

    /// Whether frames have different plates.
    pub fn differ(&self) -> bool {
        let mut hashes = self.files.values().map(|file| file.content_hash);
        let first = hashes.next();
        hashes.any(|hash| Some(hash) != first)
    }

    /// Hash of the content of a frame's plate, and how it is fitted.
    pub(super) fn content_key(&self, frame: i64) -> (Option<[u8; 32]>, &'static str) {
        let fit = match self.fit {
            PlateFit::Fill => "fill",
            PlateFit::Fit => "fit",
            PlateFit::Stretch => "stretch",
        };
        (self.files.get(&self.pattern.path(frame)).map(|file| file.content_hash), fit)
    }

    /// Most bytes that reading and resampling a plate takes.
    pub(super) fn working_bytes(&self, window: PixelWindow) -> u128 {
        let of_file = |file: &PlateFile| {
            let rows = u128::from(file.header.size.1);
            u128::from(file.header.decoded_bytes) + rows * u128::from(window.width()) * BYTES_A_PIXEL
        };
        self.files.values().map(of_file).max().unwrap_or(0)
    }

    /// Whether the same plate is behind both frames.
    pub(super) fn is_same(&self, a: i64, b: i64) -> bool {
        a == b || !self.pattern.is_numbered()
    }

    /// The pixels behind a frame.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the file is damaged, or has changed since it was opened.
    pub fn plate(&self, frame: i64, resolution: (u32, u32), window: PixelWindow) -> Result<Plate> {
        let path = self.pattern.path(frame);
        let bytes = read_regular_file(&path, self.max_memory_bytes)?;
        let content_hash: [u8; 32] = Sha256::digest(&bytes).into();
        if self.files.get(&path).is_none_or(|file| file.content_hash != content_hash) {
            return Err(Error::invalid(&path, "", "has changed since the run began; start it again"));
        }
        let plate = read_plate(&path, &bytes, self.max_memory_bytes)?;
        let pixels = resample(&plate.image, plate.pixel_aspect, resolution, window, self.fit);
        Ok(Plate { pixels, is_display_referred: plate.is_display_referred })
    }
}

/// Adds what needs the file to the error of a missing one.
fn for_frame(error: Error, frame: Option<i64>) -> Error {
    let Error::Missing { path, pointer, source } = error else { return error };
    let needed = match frame {
        Some(frame) => format!("{source}; `background` needs it as the plate of frame {frame}"),
        None => format!("{source}; `background` names it as a plate"),
    };
    Error::Missing { path, pointer, source: std::io::Error::new(source.kind(), needed) }
}
