//! Accepts images that a build server rendered, without rendering them again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::covered_jobs::jobs_of;
use super::filter::Filter;
use super::names::reference_path;
use super::orphans::OrphanedReferences;
use super::pending::{discard_image, discard_removal};
use super::render::reference_job;
use super::rendered_images::{RenderedImage, reference_hash};
use super::stored_reference::{check_link, check_replaceable, is_there};
use super::{Approval, PendingKind, RenderedReport, Suite, SuiteShot};
use crate::error::{Error, Result};
use crate::image_file::{ExrHeader, probe_folder, write_atomically};
use crate::regression::{Image, pixel_hash};
use crate::sequence::RenderHashes;
use crate::shot::memory_limit::default_max_memory_bytes;

/// A checked change of a reference.
#[derive(Debug)]
pub struct RenderedChange {
    /// The path of the reference.
    pub reference: PathBuf,
    /// The kind of change.
    pub kind: PendingKind,
    name: String,
    /// The new file. `None` where the reference is removed or kept.
    bytes: Option<Vec<u8>>,
}

/// Checks changes against the present references and shots. Render hashes are computed once for each shot.
#[derive(Debug)]
pub struct RenderedChecks<'a> {
    suite: &'a Suite,
    shots: &'a [SuiteShot],
    report: &'a RenderedReport,
    /// Bytes that are left for images, which are kept until they are applied.
    bytes_left: u64,
    /// Render hashes by name of image, for each shot that was opened.
    render_hashes: BTreeMap<String, BTreeMap<String, String>>,
    /// References that no shot renders, once they are asked for.
    orphaned: Option<OrphanedReferences<'a>>,
}

/// The images that `filter` selects, and whether it is the exact name of a shot or image.
///
/// # Errors
/// [`Error::Usage`] for a filter that selects neither an image nor a shot.
pub fn select_rendered(
    suite: &Suite,
    images: Vec<RenderedImage>,
    shots: &[SuiteShot],
    filter: &str,
) -> Result<(Vec<RenderedImage>, bool)> {
    let names: Vec<String> = images.iter().map(|image| image.name.clone()).collect();
    let selection = Filter::new(suite, filter, shots, names.iter().map(String::as_str));
    let selected: Vec<_> = images.into_iter().filter(|image| selection.matches_image(&image.name)).collect();
    let is_known = filter.is_empty() || shots.iter().any(|shot| selection.matches_shot(&shot.name));
    if selected.is_empty() && !is_known {
        let word = filter.escape_debug();
        return Err(Error::usage(format!("no image of the report has the name \"{word}\", or contains it")));
    }
    Ok((selected, selection.is_name()))
}

impl<'a> RenderedChecks<'a> {
    /// Checks of the images in a report. `shots` are all shots of the suite.
    pub fn new(suite: &'a Suite, shots: &'a [SuiteShot], report: &'a RenderedReport) -> Self {
        let bytes_left = default_max_memory_bytes();
        Self { suite, shots, report, bytes_left, render_hashes: BTreeMap::new(), orphaned: None }
    }

    /// The change that makes `image` the reference; `None` where it is the reference already.
    ///
    /// # Errors
    /// [`Error::Different`] where the image, its reference or its shot is not that of the list, [`Error::CannotCreate`] where the reference
    /// is a link, and errors of opening the shot that renders it.
    pub fn change(&mut self, image: &RenderedImage) -> Result<Option<RenderedChange>> {
        let RenderedImage { name, hash, .. } = image;
        let refused = |why: &str| Err(Error::Different { message: format!("{name}: {why}") });
        if (Approval { name: name.clone(), hash: hash.clone() }).is_applied(self.suite) {
            return Ok(None);
        }
        let reference = reference_path(&self.suite.references, name);
        if hash.is_some() {
            check_link(&reference)?;
        }
        if reference_hash(self.suite, name) != image.reference {
            return refused("its reference is not the one that it was compared with; test again");
        }
        let Some(hash) = hash else {
            if !self.is_orphaned(name)? {
                return refused("a shot renders this reference now; test again");
            }
            let kind = PendingKind::of_removal(&reference);
            return Ok(Some(RenderedChange { reference, kind, name: name.clone(), bytes: None }));
        };
        check_replaceable(&reference)?;
        let (file, bytes) = self.report.image(name, self.suite.max_reference_bytes)?;
        let size = bytes.len() as u64;
        if let Some(message) = self.suite.too_large(size) {
            return Err(Error::refused(&file, "", message));
        }
        let Some(bytes_left) = self.bytes_left.checked_sub(size) else {
            let message =
                "with the images before it, it needs more than the memory; accept fewer at a time, by NAME";
            return Err(Error::refused(&file, "", message));
        };
        self.bytes_left = bytes_left;
        if pixel_hash(&Image::decode(&file, &bytes)?) != *hash {
            return refused("its file is not the image that was tested");
        }
        let header = ExrHeader::parse(&mut bytes.as_slice()).map_err(|why| Error::invalid(&file, "", why))?;
        let rendered = header.render_hash();
        if rendered.is_none() || self.render_hash(name)? != rendered {
            return refused(
                "its shot, scene or version of rayframe is not the one that rendered it; test again",
            );
        }
        let kind = if is_there(&reference) { PendingKind::Replace } else { PendingKind::Add };
        Ok(Some(RenderedChange { reference, kind, name: name.clone(), bytes: Some(bytes) }))
    }

    fn is_orphaned(&mut self, name: &str) -> Result<bool> {
        let orphaned = match self.orphaned.take() {
            Some(orphaned) => orphaned,
            None => OrphanedReferences::find(self.suite, self.shots)?,
        };
        self.orphaned.insert(orphaned).contains(name)
    }

    /// The render hash that the image has here. `None` where no shot renders it.
    fn render_hash(&mut self, name: &str) -> Result<Option<String>> {
        let filter = Filter::all(self.shots);
        let owner = filter.owner(name).and_then(|owner| self.shots.iter().find(|shot| shot.name == owner));
        let Some(shot) = owner else { return Ok(None) };
        if !self.render_hashes.contains_key(&shot.name) {
            let hashes = render_hashes(self.suite, shot)?;
            self.render_hashes.insert(shot.name.clone(), hashes);
        }
        Ok(self.render_hashes.get(&shot.name).and_then(|hashes| hashes.get(name)).cloned())
    }
}

/// The render hashes of all frames of a shot, by name of image.
fn render_hashes(suite: &Suite, shot: &SuiteShot) -> Result<BTreeMap<String, String>> {
    let mut hashes = BTreeMap::new();
    for covered in jobs_of(suite, shot, &[], 1)?.jobs {
        let job = reference_job(covered.job.sequence.clone(), Path::new(""))?;
        let of_job = RenderHashes::new(&job);
        let frames = job.frames.iter();
        hashes.extend(frames.map(|&frame| (covered.image_name(&shot.name, frame), of_job.of(frame))));
    }
    Ok(hashes)
}

impl RenderedChange {
    /// Writes, removes or keeps the reference, and discards pending changes of its name.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] or [`Error::WriteFailed`].
    pub fn apply(&self, suite: &Suite) -> Result<()> {
        let reference = &self.reference;
        match &self.bytes {
            Some(bytes) => {
                probe_folder(reference)?;
                write_atomically(reference, bytes)?;
            }
            None if self.kind == PendingKind::Keep => {}
            None => std::fs::remove_file(reference)
                .map_err(|source| Error::WriteFailed { path: reference.clone(), source })?,
        }
        discard_image(suite, &self.name)?;
        discard_removal(suite, &self.name)
    }
}
