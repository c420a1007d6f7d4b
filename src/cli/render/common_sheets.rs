//! Contact sheets of several sequences: one frame of each, with the names of scene, clip, camera and variant.

use std::path::PathBuf;

use crate::progress::{print_note, print_warning};
use rayframe::error::{Error, Result};
use rayframe::image_file::{CONTACT_SHEET, encode_png, write_single_file};
use rayframe::output::{LabelledSheet, LabelledTile};
use rayframe::sequence::{Plan, Summary, display_frame};
use rayframe::settings::{OutputNames, Placeholder, SettingValues};
use rayframe::shot::{RenderJob, SequenceOutline};

use crate::cli::render_options::NamedShot;

/// What the sheets of a run depend on.
#[derive(Clone, Copy, Debug)]
pub(super) struct SheetRun {
    /// Whether there are several sequences.
    pub(super) is_many: bool,
    /// Whether labels name the scene.
    pub(super) names_scenes: bool,
    /// Whether the names of the sheets are not printed.
    pub(super) is_quiet: bool,
}

/// The sheets of a run, in the order of their first sequences.
#[derive(Debug)]
pub(super) struct CommonSheets {
    run: SheetRun,
    /// Each sheet with its tiles, and the position of the scene of each.
    sheets: Vec<(PathBuf, Vec<(usize, LabelledTile)>)>,
    /// Position of the current scene.
    position: usize,
}

impl CommonSheets {
    /// No sheets yet.
    pub(super) fn new(run: SheetRun) -> Self {
        Self { run, sheets: Vec::new(), position: 0 }
    }

    /// Makes the scene at `position` the current one.
    pub(super) fn begin(&mut self, position: usize) {
        self.position = position;
    }

    /// Takes the contact sheet of a job over, where it shows several sequences: its name has no placeholder for what tells them
    /// apart.
    ///
    /// # Errors
    /// [`Error::Setting`] for movies, whose frames are in no files.
    pub(super) fn take(&mut self, job: &mut RenderJob, args: &SettingValues) -> Result<()> {
        self.check(&job.outline, args)?;
        if !self.is_common(&job.outline, args) {
            return Ok(());
        }
        job.sequence.sequence_outputs.check(job.sequence.render.window.size())?;
        job.sequence.sequence_outputs.contact_sheet = None;
        job.sequence.sequence_outputs.is_on_common_sheet = true;
        Ok(())
    }

    /// Checks that a common sheet can be made.
    ///
    /// # Errors
    /// [`Error::Setting`] for movies, whose frames are in no files.
    pub(super) fn check(&self, outline: &SequenceOutline, args: &SettingValues) -> Result<()> {
        if outline.output.is_movie() && self.is_common(outline, args) {
            let why = "shows frames of several movies, which are in no files; name frames with `output` and the movies with `movie`";
            return Err(Error::setting("contact_sheet", why));
        }
        Ok(())
    }

    fn is_common(&self, outline: &SequenceOutline, args: &SettingValues) -> bool {
        let Some(name) = args.contact_sheet.as_deref().filter(|_| self.run.is_many) else { return false };
        let has = |placeholder: Placeholder| placeholder.is_in(name);
        let is_of_one_scene = !self.run.names_scenes || has(Placeholder::Scene) || has(Placeholder::Shot);
        !(is_of_one_scene && outline.names.entries().all(|(what, _)| has(what)))
    }

    /// Adds the middle frame of a sequence that was rendered; an empty tile where it is missing.
    pub(super) fn add(&mut self, job: &RenderJob, plan: &Plan, summary: &Summary) {
        let outline = &job.outline;
        let Some(path) = outline.contact_sheet.clone() else { return };
        if !job.sequence.sequence_outputs.is_on_common_sheet {
            return;
        }
        let mut frames: Vec<_> = plan.frames.iter().collect();
        frames.sort_by_key(|planned| planned.frame);
        let exists = |frame: i64| {
            summary.kept.contains(&frame) || summary.written.iter().any(|report| report.frame == frame)
        };
        let middle = frames.get(frames.len() / 2).filter(|planned| exists(planned.frame));
        let image = match (middle, summary.look) {
            (Some(planned), Some(look)) => match display_frame(&job.sequence, planned, look) {
                Ok(image) => Some(image),
                Err(error) => {
                    print_warning(&format!("`contact_sheet`: {error}"));
                    None
                }
            },
            _ => None,
        };
        let scene = || outline.output_names.of(Placeholder::Shot).display().to_string();
        let mut parts: Vec<_> = self.run.names_scenes.then(scene).into_iter().collect();
        parts.extend(outline.names.entries().map(|(_, name)| name.to_owned()));
        let label = parts.join(" / ");
        self.add_tile(path, LabelledTile::new(label, image.as_ref()));
    }

    /// Adds an empty tile for a scene that cannot be rendered.
    pub(super) fn add_failed(&mut self, named: &NamedShot) {
        let Ok(shot) = &named.settings else { return };
        let Some(name) = shot.values.contact_sheet.as_deref() else { return };
        if Placeholder::ALL.into_iter().any(|placeholder| placeholder.is_in(name)) {
            return;
        }
        let names = OutputNames::new(&shot.scene, shot.shot_file.as_deref(), "", "", "");
        let label = names.of(Placeholder::Shot).display().to_string();
        let path = names.fill(name);
        self.add_tile(path, LabelledTile::new(label, None));
    }

    /// Writes all sheets.
    ///
    /// # Errors
    /// Those of writing files.
    pub(super) fn write(&mut self) -> Result<()> {
        for (path, tiles) in &mut self.sheets {
            // Scenes that failed were added first.
            tiles.sort_by_key(|(position, _)| *position);
            let mut sheet = LabelledSheet::default();
            tiles.drain(..).for_each(|(_, tile)| sheet.add(tile));
            let image = sheet.image();
            write_single_file(path, &encode_png(image.size, &image.pixels, CONTACT_SHEET)?)?;
            if !self.run.is_quiet {
                print_note(&format!("all together: {}", path.display()));
            }
        }
        Ok(())
    }

    /// Says that the sheets were not made, because the run ended early.
    pub(super) fn tell_missing(&self) {
        for (path, _) in &self.sheets {
            print_warning(&format!(
                "`contact_sheet`: \"{}\" was not made, as frames are missing",
                path.display()
            ));
        }
    }

    fn add_tile(&mut self, path: PathBuf, tile: LabelledTile) {
        let tile = (self.position, tile);
        match self.sheets.iter_mut().find(|(other, _)| *other == path) {
            Some((_, tiles)) => tiles.push(tile),
            None => self.sheets.push((path, vec![tile])),
        }
    }
}
