//! The files that `rayframe diff` writes: FLIP as colours (`--heat-map`) or as numbers (`--flip-map`).

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use rayframe::error::{Error, Result};
use rayframe::image::{Channel, ColorEncoding, Image, PixelWindow, RenderedScene, Samples};
use rayframe::image_file::{
    ExrCompression, FLIP_MAP, FrameAttributes, HEAT_MAP, OutputKind, check_name, check_output, encode_exr,
    encode_png, probe_folder, remove_stale_temporaries, write_atomically,
};
use rayframe::regression::{FlipMap, PairedFiles, heat_map};
use rayframe::sequence::{OutputFormat, OutputPattern};

/// The names of the files of a map.
pub(super) struct MapPattern {
    option: &'static str,
    pattern: OutputPattern,
    format: OutputFormat,
    /// Folders in which files can be written.
    folders: BTreeSet<Option<PathBuf>>,
}

impl MapPattern {
    /// Of `--heat-map`.
    pub(super) fn heat_map(name: &OsStr, paired: &PairedFiles) -> Result<Self> {
        Self::new("--heat-map", name, OutputFormat::Png, paired)
    }

    /// Of `--flip-map`.
    pub(super) fn flip_map(name: &OsStr, paired: &PairedFiles) -> Result<Self> {
        Self::new("--flip-map", name, OutputFormat::Exr, paired)
    }

    fn new(option: &'static str, name: &OsStr, format: OutputFormat, paired: &PairedFiles) -> Result<Self> {
        let ending = if format == OutputFormat::Png { "png" } else { "exr" };
        let is_file = Path::new(name).file_name().is_some() && !name.as_encoded_bytes().ends_with(b"/");
        let has_ending = Path::new(name).extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
        if is_file && !has_ending {
            return Err(Error::usage(format!("{option} {}: end it with .{ending}", name.display())));
        }
        let pattern =
            OutputPattern::parse(name).map_err(|message| Error::usage(format!("{option}: {message}")))?;
        let paths: BTreeSet<_> =
            paired.pairs.iter().map(|pair| pattern.path(pair.frame.unwrap_or(0))).collect();
        if paths.len() < paired.pairs.len() {
            return Err(Error::usage(format!(
                "{option} {}: several images would share a name; add the frame number to it, such as heat.####.png, and \
                 compare one sequence at a time",
                name.display()
            )));
        }
        Ok(Self { option, pattern, format, folders: BTreeSet::new() })
    }

    /// The file of a frame.
    fn path(&self, frame: Option<i64>) -> PathBuf {
        self.pattern.path(frame.unwrap_or(0))
    }

    /// The option, and the files of all frames.
    pub(super) fn files(&self, paired: &PairedFiles) -> (&'static str, Vec<PathBuf>) {
        (self.option, paired.pairs.iter().map(|pair| self.path(pair.frame)).collect())
    }

    /// Checks that the files replace nothing but such maps.
    ///
    /// # Errors
    /// Those of [`check_output`].
    pub(super) fn check_files(&self, paired: &PairedFiles, overwrites: bool) -> Result<()> {
        let kind = if self.format == OutputFormat::Exr { OutputKind::FlipMap } else { OutputKind::HeatMap };
        paired.pairs.iter().try_for_each(|pair| check_output(&self.path(pair.frame), kind, overwrites))
    }

    /// Writes the file of a frame, by a map of an image with these display and data windows. Folders are looked at once, not for each of
    /// many files.
    ///
    /// # Errors
    /// Those of [`probe_folder`] and [`write_atomically`].
    pub(super) fn write(
        &mut self,
        paired: &PairedFiles,
        frame: Option<i64>,
        (map, windows): (&FlipMap, [PixelWindow; 2]),
    ) -> Result<()> {
        let path = self.path(frame);
        if self.folders.is_empty() {
            remove_stale_temporaries(&self.files(paired).1);
        }
        if self.folders.insert(path.parent().map(Path::to_owned)) {
            probe_folder(&path)?;
        }
        check_name(&path)?;
        write_atomically(&path, &self.encoded(map, windows)?)
    }

    /// The contents of the file.
    fn encoded(&self, map: &FlipMap, windows: [PixelWindow; 2]) -> Result<Vec<u8>> {
        match self.format {
            OutputFormat::Png | OutputFormat::Movie(_) => encode_png(map.size, &heat_map(map), HEAT_MAP),
            OutputFormat::Exr => encode_errors(map, windows),
        }
    }
}

fn encode_errors(map: &FlipMap, [display_window, data_window]: [PixelWindow; 2]) -> Result<Vec<u8>> {
    let image = Image {
        display_window,
        data_window,
        encoding: ColorEncoding::Linear,
        channels: vec![Channel { name: "Y".to_owned(), samples: Samples::Float(map.errors.clone()) }],
        scene: RenderedScene::default(),
    };
    let attributes = FrameAttributes { render_hash: FLIP_MAP.to_owned(), ..FrameAttributes::unknown() };
    encode_exr(image, ExrCompression::Zip, &attributes)
}

#[cfg(test)]
mod tests {
    use rayframe::regression::FilePair;

    use super::*;

    #[test]
    fn folders_are_made_with_their_first_map() {
        let folder = tempfile::tempdir().unwrap();
        let pair = |frame: i64| FilePair {
            frame: Some(frame),
            actual: format!("a.{frame}.exr").into(),
            reference: format!("b.{frame}.exr").into(),
        };
        let paired = PairedFiles { pairs: vec![pair(1), pair(2)], ..PairedFiles::default() };
        let name = folder.path().join("####/heat.png");
        let mut pattern = MapPattern::heat_map(name.as_os_str(), &paired).unwrap();
        let map = FlipMap { size: (1, 1), errors: vec![0.5], exposures: None };
        let windows = [PixelWindow::full(1, 1); 2];
        let mut write = |frame: i64| pattern.write(&paired, Some(frame), (&map, windows)).unwrap();
        let file = |frame: i64| folder.path().join(format!("{frame:04}/heat.png"));
        write(1);
        assert!(file(1).is_file() && !folder.path().join("0002").exists());
        write(2);
        write(2);
        assert!(file(2).is_file());
    }
}
