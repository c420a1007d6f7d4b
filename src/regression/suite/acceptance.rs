//! Acceptance of pending changes: checks them against the present references and shots, and applies them.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::covered_jobs::ShotImages;
use super::names::compared_path;
use super::pending::{owner_text, remove_file};
use super::rendered_images::reference_hash;
use super::stored_reference::{check_replaceable, is_there, is_unreadable_link};
use super::{Pending, PendingKind, Suite, SuiteShot, is_ci, name_and_options, shell_word};
use crate::error::{Error, Result};
use crate::image_file::{ExrIntegrity, MAX_POINTER_BYTES, check_fetched, read_regular_file, verify_exr};
use crate::regression::Image;

/// A shot that cannot be opened.
#[derive(Debug)]
pub struct Unopened {
    /// Its name.
    pub shot: String,
    /// Why.
    pub error: Error,
    /// Number of its pending changes.
    pub changes: usize,
}

/// Checks and applies pending changes. The images of each shot are listed once.
#[derive(Debug)]
pub struct Acceptance<'a> {
    suite: &'a Suite,
    /// By name of shot.
    images: BTreeMap<String, ShotImages>,
}

impl<'a> Acceptance<'a> {
    /// Acceptance into the references of `suite`.
    pub fn new(suite: &'a Suite) -> Self {
        Self { suite, images: BTreeMap::new() }
    }

    /// Applies the change. One of the kind [`PendingKind::Keep`] is discarded.
    ///
    /// # Errors
    /// Those of [`Acceptance::check`]; [`Error::WriteFailed`] when the file cannot be written.
    pub fn accept(&mut self, pending: &Pending) -> Result<()> {
        self.check(pending)?;
        if pending.kind == PendingKind::Remove {
            remove_file(&pending.reference)?;
        }
        if pending.kind.is_removal() {
            return remove_file(&pending.file);
        }
        std::fs::rename(&pending.file, &pending.reference)
            .map_err(|source| Error::WriteFailed { path: pending.reference.clone(), source })?;
        remove_file(&compared_path(&self.suite.references, &pending.name))
    }

    /// Splits the changes into those whose shot can be opened and those whose shot cannot. Renders nothing.
    pub fn opened(&mut self, changes: Vec<Pending>) -> (Vec<Pending>, Vec<Unopened>) {
        let (mut opened, mut unopened) = (Vec::new(), Vec::<Unopened>::new());
        for pending in changes {
            let Some(shot) = &pending.shot else {
                opened.push(pending);
                continue;
            };
            if let Some(known) = unopened.iter_mut().find(|unopened| unopened.shot == shot.name) {
                known.changes += 1;
                continue;
            }
            match self.images_of(shot) {
                Ok(_) => opened.push(pending),
                Err(error) => unopened.push(Unopened { shot: shot.name.clone(), error, changes: 1 }),
            }
        }
        (opened, unopened)
    }

    /// Splits the changes into those that [`Acceptance::check`] permits, and the others with its errors. Renders nothing.
    pub fn permitted(&mut self, changes: Vec<Pending>) -> (Vec<Pending>, Vec<(Pending, Error)>) {
        let (mut permitted, mut refused) = (Vec::new(), Vec::new());
        for pending in changes {
            match self.check(&pending) {
                Ok(()) => permitted.push(pending),
                Err(error) => refused.push((pending, error)),
            }
        }
        (permitted, refused)
    }

    /// Checks whether [`Acceptance::accept`] would apply the change. Renders nothing.
    ///
    /// # Errors
    /// [`Error::Usage`] where `CI` is set; [`Error::Different`] when the reference or the shots have changed since the image was
    /// rendered; [`Error::Invalid`] when the reference was not fetched, or the image cannot be decoded; [`Error::CannotCreate`] when the
    /// reference is a link; [`Error::Refused`] when the image is larger than the suite allows; errors of opening its shot.
    pub fn check(&mut self, pending: &Pending) -> Result<()> {
        if is_ci() {
            return Err(Error::usage(
                "CI is set, and references are not written on build servers; accept them on your machine and commit them",
            ));
        }
        // References are not read for their first bytes.
        if let Ok(bytes) = read_regular_file(&pending.reference, MAX_POINTER_BYTES) {
            check_fetched(&pending.reference, "", &bytes)?;
        }
        if !pending.kind.is_removal() {
            check_replaceable(&pending.reference)?;
        }
        let file = pending.file.display();
        if let Some(why) = self.outdated(pending)? {
            let message =
                format!("{file}: {why} since the change was found; run rayframe test and look again");
            return Err(Error::Different { message });
        }
        if pending.kind.is_removal() {
            return Ok(());
        }
        if let Some(shot) = &pending.shot
            && !self.images_of(shot)?.rendered.contains(&pending.name)
        {
            let shot = shell_word(&shot.name);
            let image = name_and_options(&format!("{}.exr", pending.name), "");
            let message = format!(
                "{file}: the shot {shot} does not render it any more; rayframe reject {image} discards it"
            );
            return Err(Error::Different { message });
        }
        let bytes = std::fs::metadata(&pending.file).map_err(Error::missing(&pending.file))?.len();
        match self.suite.too_large(bytes) {
            Some(message) => Err(Error::refused(&pending.file, "", message)),
            None => check_image(&pending.file),
        }
    }

    /// Why the change no longer applies; `None` when it does.
    fn outdated(&mut self, pending: &Pending) -> Result<Option<&'static str>> {
        let Pending { name, kind, shot, .. } = pending;
        // A run that was killed has removed it.
        if kind.is_removal() && !is_there(&pending.reference) {
            return Ok(None);
        }
        let (compared, has_same_shots) = if kind.is_removal() {
            let text = std::fs::read_to_string(&pending.file).map_err(Error::missing(&pending.file))?;
            // The line of the hash may be empty.
            let lines = text.strip_suffix('\n').unwrap_or(&text);
            let (owner, compared) = lines.rsplit_once('\n').unwrap_or_default();
            let compared = compared.trim();
            let has_same_owner = owner == owner_text(shot.as_ref().map(|shot| shot.name.as_str()));
            // A link that cannot be read had no hash when it was marked either.
            let had_no_hash = compared.is_empty() && is_unreadable_link(&pending.reference);
            let compared = (!had_no_hash).then(|| compared.to_owned());
            (compared, has_same_owner && !self.is_needed(pending)?)
        } else {
            let compared = std::fs::read_to_string(compared_path(&self.suite.references, name)).ok();
            (compared.map(|hash| hash.trim().to_owned()), shot.is_some())
        };
        if compared != reference_hash(self.suite, name) {
            // Earlier versions did not write with what they compared an image.
            let is_known = compared.is_some_and(|hash| !hash.is_empty());
            let why = "the reference or the version of rayframe has changed";
            return Ok(Some(if is_known { "the reference has changed" } else { why }));
        }
        Ok(Some("the shots of its name have changed").filter(|_| !has_same_shots))
    }

    /// Whether the shot of its name renders the reference, or would if the scene had what the shot names.
    fn is_needed(&mut self, pending: &Pending) -> Result<bool> {
        let Some(shot) = &pending.shot else { return Ok(false) };
        let images = self.images_of(shot)?;
        Ok([&images.rendered, &images.lost].iter().any(|names| names.contains(&pending.name)))
    }

    fn images_of(&mut self, shot: &SuiteShot) -> Result<&ShotImages> {
        match self.images.entry(shot.name.clone()) {
            Entry::Occupied(known) => Ok(known.into_mut()),
            Entry::Vacant(unknown) => Ok(unknown.insert(ShotImages::of(self.suite, shot)?)),
        }
    }
}

/// Checks that a file holds a whole image, as a reference must. Only images without a checksum are decoded.
fn check_image(path: &Path) -> Result<()> {
    let file = File::open(path).map_err(Error::missing(path))?;
    match verify_exr(&mut BufReader::new(file)) {
        Ok(ExrIntegrity::Whole) => Ok(()),
        Ok(ExrIntegrity::Damaged) => {
            let why = "is damaged: its bytes do not match its checksum; run `rayframe test` again";
            Err(Error::invalid(path, "", why))
        }
        _ => Image::read(path).map(drop),
    }
}
