//! The EXR files of a frame that is rendered in bands of rows.

use std::path::PathBuf;

use crate::cancel::CancelFlag;
use crate::error::Result;
use crate::film::{Film, PixelWindow};
use crate::image_file::{ExrBands, FrameAttributes, WrittenExr};

use super::files::{aovs_image, attributes_of_file};
use super::{Aov, ExrOutput, InstanceIds};

/// The EXR files of a frame, which take films of its bands from top to bottom. They have the bytes of [`super::exr_files`] of the whole film.
#[derive(Debug)]
pub struct ExrBandFiles {
    window: PixelWindow,
    output: ExrOutput,
    /// The files of split AOVs, then the main file.
    files: Vec<BandFile>,
}

#[derive(Debug)]
struct BandFile {
    path: PathBuf,
    aovs: Vec<Aov>,
    /// `None` before the first band.
    bands: Option<ExrBands>,
}

impl ExrBandFiles {
    /// The files of a frame of `window`: the main file, and one for each of [`ExrOutput::split_aovs`].
    pub fn new(window: PixelWindow, output: &ExrOutput, main: PathBuf, aov_paths: &[PathBuf]) -> Self {
        let split = output.split_aovs().iter().zip(aov_paths).map(|(&aov, path)| (path.clone(), vec![aov]));
        let files = split.chain([(main, output.main_aovs().to_vec())]);
        let files = files.map(|(path, aovs)| BandFile { path, aovs, bands: None }).collect();
        Self { window, output: output.clone(), files }
    }

    /// Rows of the chunks of all files. All bands but the last have a multiple of them.
    pub fn rows_of_chunks(output: &ExrOutput) -> u32 {
        let split = output.split_aovs().iter().map(|&aov| output.compression_of(&[aov]));
        let rows = split.chain([output.compression_of(output.main_aovs())]).map(ExrBands::rows_of_chunks);
        // All are powers of two.
        rows.max().unwrap_or(1)
    }

    /// Writes the next band to all files.
    ///
    /// # Errors
    /// Those of [`ExrBands`]; [`crate::error::Error::Internal`] when the film did not record an AOV.
    pub fn write(&mut self, film: &Film, attributes: &FrameAttributes, ids: &InstanceIds) -> Result<()> {
        for BandFile { path, aovs, bands } in &mut self.files {
            let image = aovs_image(film, &self.output, aovs, ids)?;
            let begun = if let Some(begun) = bands {
                begun
            } else {
                let attributes = attributes_of_file(attributes.clone(), aovs, ids);
                let compression = self.output.compression_of(aovs);
                bands.insert(ExrBands::begin(path, self.window, &image, compression, &attributes)?)
            };
            begun.write(image)?;
        }
        Ok(())
    }

    /// Completes the files, the main one last, and gives them their names. Returns what was written to the main file and to the others.
    ///
    /// # Errors
    /// Those of [`ExrBands::finish`].
    pub fn finish(
        self,
        attributes: &FrameAttributes,
        ids: &InstanceIds,
        cancel: &CancelFlag,
    ) -> Result<(Option<WrittenExr>, Vec<WrittenExr>)> {
        let mut written = Vec::new();
        for BandFile { aovs, bands, .. } in self.files {
            let attributes = attributes_of_file(attributes.clone(), &aovs, ids);
            written.extend(bands.map(|bands| bands.finish(&attributes, cancel)).transpose()?);
        }
        Ok((written.pop(), written))
    }
}
