//! Orphaned references, and pending images of earlier runs that no longer apply.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::covered_jobs::image_names;
use super::discover::{ExcludedPaths, NamedScenes};
use super::filter::Filter;
use super::names::{
    ReferenceFile, images_folder, paths_of_image, possible_shots, reference_files, reference_path, same_file,
};
use super::pending::{discard_image, discard_removal, discard_stray_comparison, store_removal};
use super::referenced_inputs::ReferencedInputs;
use super::rendered_images::file_hash;
use super::{RunOptions, Suite, SuiteShot};
use crate::error::{Error, Result};
use crate::image_file::{read_regular_file, remove_stale_temporaries};
use crate::regression::Image;
use crate::regression::encoded_image::EncodedImage;
use crate::regression::result::{FrameResult, FrameStatus, ShotResult};
use crate::shot::is_shot;

/// References of a suite that no shot renders.
#[derive(Debug)]
pub(super) struct OrphanedReferences<'a> {
    filter: Filter<'a>,
    /// Those that no shot that was opened renders.
    names: BTreeSet<String>,
    /// Shots that cannot be opened, each with its error.
    unopened: BTreeMap<&'a str, String>,
}

impl<'a> OrphanedReferences<'a> {
    /// Opens all `shots` of the suite and renders nothing.
    ///
    /// # Errors
    /// Those of reading the references; [`Error::Interrupted`] when cancelled.
    pub(super) fn find(suite: &Suite, shots: &'a [SuiteShot]) -> Result<Self> {
        let (mut rendered, mut unopened) = (BTreeSet::new(), BTreeMap::new());
        for shot in shots {
            match image_names(suite, shot) {
                Ok(names) => rendered.extend(names),
                Err(error @ Error::Interrupted(_)) => return Err(error),
                Err(error) => {
                    unopened.insert(shot.name.as_str(), error.to_string());
                }
            }
        }
        let files = reference_files(suite)?;
        let references = files.iter().filter(|file| matches!(file, ReferenceFile::Reference(_)));
        let inputs = ReferencedInputs::new(suite, shots);
        let is_orphaned = |name: &String| !rendered.contains(name) && !inputs.contains(name);
        let names = references.map(|file| file.name().to_owned()).filter(is_orphaned).collect();
        Ok(Self { filter: Filter::all(shots), names, unopened })
    }

    /// Whether no shot renders the reference `name`.
    ///
    /// # Errors
    /// [`Error::Different`] where the shot that may render it cannot be opened.
    pub(super) fn contains(&self, name: &str) -> Result<bool> {
        if !self.names.contains(name) {
            return Ok(false);
        }
        // Without a shot of its name, no shot renders it, whatever cannot be opened.
        match self.filter.owner(name).and_then(|owner| self.unopened.get(owner)) {
            Some(why) => {
                let message =
                    format!("{name}: its shot cannot be opened and may render this reference: {why}");
                Err(Error::Different { message })
            }
            None => Ok(true),
        }
    }
}

/// Finds orphaned references after all shots were tested, and updates pending images: marks the orphaned references for removal, and
/// discards pending images and removals of earlier runs that no longer apply. Returns the orphaned references, and errors of the
/// update. `shots` are all shots of the suite; `results` those that `options` select.
///
/// # Errors
/// When the references cannot be read.
pub fn finish(
    suite: &Suite,
    shots: &[SuiteShot],
    results: &[ShotResult],
    options: &RunOptions,
) -> Result<(Vec<FrameResult>, Vec<Error>)> {
    let mut files = reference_files(suite)?;
    if let Some(report) = &options.images {
        // The list by which its images are known is written last.
        let images = same_file(&images_folder(report));
        let path = |file: &ReferenceFile| same_file(&reference_path(&suite.references, file.name()));
        files.retain(|file| !path(file).starts_with(&images));
    }
    let keeps_pending = options.keeps_pending;
    let filter = Filter::new(suite, &options.filter, shots, files.iter().map(ReferenceFile::name));
    let rendered: BTreeSet<&str> =
        results.iter().flat_map(|shot| &shot.frames).map(|frame| frame.name.as_str()).collect();
    // A shot that was not tested, or could not be opened, may render any frame.
    let opened = results.iter().filter(|shot| !shot.is_unopened);
    let known: BTreeSet<&str> = opened.map(|shot| shot.name.as_str()).collect();
    let is_known = |shot: &str| known.contains(shot);
    // Without a shot, it belongs to the part that its shot would belong to.
    let is_here = |name: &str| {
        options.shard.is_none_or(|shard| shard.includes(possible_shots(name).last().unwrap_or(name)))
    };
    let is_decided = |name: &str| filter.owner(name).map_or_else(|| is_here(name), is_known);
    // A shot of this name may render it.
    let is_doubtful = |name: &str| filter.owner(name).is_some_and(|shot| !is_known(shot));
    if keeps_pending {
        let names = rendered.iter().copied().chain(files.iter().map(ReferenceFile::name));
        let paths = names.flat_map(|name| paths_of_image(&suite.references, name));
        remove_stale_temporaries(&paths.collect::<Vec<_>>());
    }
    let mut orphaned = Vec::new();
    let mut not_kept = Vec::new();
    let mut orphans = Orphans::new(suite, shots);
    let inputs = ReferencedInputs::new(suite, shots);
    for file in &files {
        let name = file.name();
        let is_rendered = rendered.contains(name);
        let is_orphaned = !is_rendered && is_decided(name) && filter.matches_image(name);
        match file {
            // No reference, whatever an earlier run marked.
            ReferenceFile::Reference(_) if is_orphaned && inputs.contains(name) => {}
            ReferenceFile::Removal(_) if keeps_pending && inputs.contains(name) => {
                not_kept.extend(discard_removal(suite, name).err());
            }
            ReferenceFile::Reference(_) if is_orphaned => {
                orphaned.push(orphans.failure(name));
                if keeps_pending {
                    not_kept.extend(store_removal(suite, name, filter.owner(name)).err());
                }
            }
            ReferenceFile::Pending(_) | ReferenceFile::Changed(_) if is_orphaned && keeps_pending => {
                not_kept.extend(discard_image(suite, name).err());
            }
            ReferenceFile::Compared(_) if keeps_pending && is_decided(name) && filter.matches_image(name) => {
                not_kept.extend(discard_stray_comparison(suite, name).err());
            }
            // Those without a shot that belong to another part are left to it.
            ReferenceFile::Removal(_) if keeps_pending && (is_rendered || is_doubtful(name)) => {
                not_kept.extend(discard_removal(suite, name).err());
            }
            _ => {}
        }
    }
    Ok((orphaned, not_kept))
}

/// The failures of references that no shot renders.
pub(super) struct Orphans<'a> {
    suite: &'a Suite,
    shots: &'a [SuiteShot],
    /// The scenes that shots name, and those that are excluded. Found when there is an orphan.
    scenes: Option<(NamedScenes<'a>, ExcludedPaths<'a>)>,
}

impl<'a> Orphans<'a> {
    /// `shots` are all shots of the suite.
    pub(super) fn new(suite: &'a Suite, shots: &'a [SuiteShot]) -> Self {
        Self { suite, shots, scenes: None }
    }

    /// The failure of the reference `name`.
    pub(super) fn failure(&mut self, name: &str) -> FrameResult {
        let why = self.shadowing(name).map(|(shot_file, scene)| {
            let [shot_file, scene] = [&shot_file.path, &scene].map(|path| path.display());
            format!(", because {shot_file} names the scene {scene}; `whole_scene = true` in [test] of {shot_file} tests both")
        });
        let message = format!("no shot renders this reference{}", why.unwrap_or_default());
        let mut result = FrameResult::new(name.to_owned(), None, FrameStatus::Orphaned).because(message);
        add_reference(self.suite, &mut result);
        result
    }

    /// A shot file and the scene that it names, which would render the image `name` if it were a shot by itself.
    fn shadowing(&mut self, name: &str) -> Option<(&'a SuiteShot, PathBuf)> {
        let Self { suite, shots, scenes } = self;
        let (named_scenes, excluded) =
            scenes.get_or_insert_with(|| (NamedScenes::new(shots), ExcludedPaths::new(suite)));
        possible_shots(name).find_map(|owner| {
            let of_owner = shots.iter().find(|shot| shot.name == owner);
            // A shot file of that name has numbered frames, too.
            let is_of_scene = owner == name || name[owner.len()..].starts_with('@');
            if of_owner.is_some_and(|shot| !is_shot(&shot.path) || !is_of_scene) {
                return None;
            }
            ["glb", "gltf"].iter().find_map(|ending| {
                let scene = suite.scenes.join(format!("{owner}.{ending}"));
                let shot_file = named_scenes.shot_file(&scene)?;
                (scene.exists() && !excluded.contains(&scene)).then_some((shot_file, scene))
            })
        })
    }
}

/// Adds its reference to the result of an image that has no other.
pub(super) fn add_reference(suite: &Suite, result: &mut FrameResult) {
    let reference = reference_path(&suite.references, &result.name);
    let bytes = read_regular_file(&reference, u64::MAX).ok();
    let image = bytes.as_ref().and_then(|bytes| Image::decode(&reference, bytes).ok());
    result.expected = image.as_ref().and_then(EncodedImage::new);
    result.reference_hash = bytes.as_deref().map(file_hash);
}
