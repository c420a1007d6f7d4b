//! A picture in memory, and as an OpenEXR file.

use std::path::Path;

use crate::error::{Error, Result};
use crate::film::Film;
use crate::image_file::{self, FrameAttributes, RgbaPixels};

/// Bytes that a decoded reference may take.
const MAX_MEMORY_BYTES: u64 = 1 << 28;

/// Linear RGBA pixels with premultiplied alpha, row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns and rows.
    pub size: (u32, u32),
    /// `size.0 · size.1` pixels.
    pub pixels: Vec<[f32; 4]>,
}

impl Picture {
    /// The pixels of a film.
    pub fn of_film(film: Film) -> Self {
        Self { size: (film.window.width(), film.window.height()), pixels: film.pixels }
    }

    /// Pixels with a value that is infinite or not a number.
    pub fn non_finite_pixels(&self) -> usize {
        self.pixels.iter().filter(|pixel| !pixel.iter().all(|value| value.is_finite())).count()
    }

    /// The picture that an EXR file of it holds: each value becomes the nearest half-float. What is not finite stays,
    /// so that a comparison sees it.
    #[must_use]
    pub fn as_stored(&self) -> Self {
        let store = |value: f32| {
            if value.is_finite() { image_file::half_from_f32(value).to_f32() } else { value }
        };
        Self { size: self.size, pixels: self.pixels.iter().map(|pixel| pixel.map(store)).collect() }
    }

    /// Reads an OpenEXR file.
    ///
    /// # Errors
    /// [`Error::Missing`] when it cannot be read, [`Error::Invalid`] when it is not a picture.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(Error::missing(path))?;
        let image = image_file::decode_exr(path, &bytes, MAX_MEMORY_BYTES)?;
        Ok(Self { size: image.size, pixels: image.pixels })
    }

    /// Writes an OpenEXR file of half-floats; folders are created. `frame` and `time_seconds` become attributes.
    ///
    /// The file says nothing of the program's version, so that it changes only when its pixels do.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] or [`Error::WriteFailed`].
    pub fn write(&self, path: &Path, frame: i32, time_seconds: f64) -> Result<()> {
        let pixels =
            RgbaPixels { picture_size: self.size, origin: (0, 0), size: self.size, pixels: &self.pixels };
        let bytes = image_file::encode_exr(&pixels, &attributes(frame, time_seconds))?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|error| Error::CannotCreate {
                path: folder.to_owned(),
                message: error.to_string(),
            })?;
        }
        image_file::write_atomically(path, &bytes)
    }
}

/// What a file says that is not rendered on the command line.
pub(super) fn attributes(frame: i32, time_seconds: f64) -> FrameAttributes {
    let identity = glam::Mat4::IDENTITY.to_cols_array();
    FrameAttributes {
        software: "rayframe".to_owned(),
        render_hash: String::new(),
        frame,
        time_seconds,
        frames_per_second: (super::FRAMES_PER_SECOND, 1),
        world_to_camera: identity,
        world_to_ndc: identity,
        time_code: None,
        texts: Vec::new(),
        stamp: None,
    }
}
