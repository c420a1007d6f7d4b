//! The files of all sequences of a run: no two may have one name, and none may be an input.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::super::output_folders::check_inside;
use rayframe::error::{Error, Provenance, Result};
use rayframe::image_file::probe_folder;
use rayframe::output::AovSet;
use rayframe::sequence::{canonical, is_plate, without_case};
use rayframe::settings::{BackgroundSource, OutputNames, Placeholder, PlatePattern, SettingValues};
use rayframe::shot::{SequenceOutline, ShotOutline, ShotSettings};

/// The files of the sequences that were added.
///
/// Names that differ only in case are the same, because they are on many file systems.
#[derive(Debug, Default)]
pub(in crate::cli) struct WrittenFiles {
    sequences: Vec<Owner>,
    /// Number of shots so far.
    shot_count: usize,
    /// Index of the sequence and the setting of each file, by its canonical name [`without_case`].
    files: BTreeMap<OsString, (usize, &'static str, PathBuf)>,
    inputs: BTreeSet<PathBuf>,
    /// Names of plates.
    plates: Vec<PlatePattern>,
    /// Canonical forms of folders.
    folders: BTreeMap<PathBuf, PathBuf>,
}

/// A sequence for messages.
#[derive(Debug)]
struct Owner {
    label: String,
    /// Position of its shot.
    shot: usize,
    /// Its scene file, for comparison.
    scene: PathBuf,
    names: OutputNames,
    /// Names of its files with placeholders, each with its setting.
    patterns: Vec<(&'static str, PathBuf)>,
}

impl Owner {
    fn pattern(&self, setting: &str) -> &Path {
        let pattern = self.patterns.iter().find(|(of, _)| *of == setting);
        pattern.map_or(Path::new(""), |(_, pattern)| pattern)
    }
}

impl WrittenFiles {
    /// Adds the files of a shot, which was named `path`; an empty path is that of its scene.
    ///
    /// # Errors
    /// [`Error::Setting`] for a file that an added sequence writes, too, or that is an input or a plate of any shot, earlier or later.
    pub(in crate::cli) fn add(
        &mut self,
        path: &Path,
        settings: &ShotSettings,
        shot: &ShotOutline,
    ) -> Result<()> {
        let args = &settings.values;
        let path = if path.as_os_str().is_empty() { &settings.scene } else { path };
        self.shot_count += 1;
        for input in &shot.inputs {
            let input = canonical(input);
            if let Some((owner, setting, file)) = self.files.get(&without_case(&input))
                && canonical(file) == input
            {
                return Err(self.is_read_later((*owner, setting, file), path));
            }
            self.inputs.insert(input);
        }
        if let BackgroundSource::Plate(plates) = &args.background
            && !self.plates.contains(plates)
        {
            let written = self.files.values().find(|(.., file)| is_plate(plates, &canonical(file)));
            if let Some((owner, setting, file)) = written {
                return Err(self.is_read_later((*owner, setting, file), path));
            }
            self.plates.push(plates.clone());
        }
        for sequence in &shot.sequences {
            let separator = if sequence.label().is_empty() { "" } else { " " };
            let label = format!("{}{separator}{}", path.display(), sequence.label());
            self.sequences.push(Owner {
                label,
                shot: self.shot_count,
                scene: canonical(&settings.scene),
                names: sequence.output_names.clone(),
                patterns: patterns(sequence, args),
            });
            for file in frame_files(sequence, args) {
                self.add_file(&file, "output")?;
            }
            for (file, setting) in sequence.sidecar_files() {
                self.add_file(file, setting)?;
            }
        }
        Ok(())
    }

    /// Checks that a file can be created in each folder.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] with the folder.
    pub(super) fn probe_folders(&self) -> Result<()> {
        let mut probed = BTreeSet::new();
        for (_, _, file) in self.files.values() {
            if probed.insert(file.parent()) {
                probe_folder(file)?;
            }
        }
        Ok(())
    }

    fn add_file(&mut self, file: &Path, setting: &'static str) -> Result<()> {
        let canonical_file = self.in_known_folder(file);
        let is_plate = || self.plates.iter().any(|plates| is_plate(plates, &canonical_file));
        if self.inputs.contains(&canonical_file) || is_plate() {
            let why = format!(
                "\"{}\" is an input and cannot be written to as well; choose another name",
                file.display()
            );
            return Err(Error::setting(setting, why));
        }
        let index = self.sequences.len() - 1;
        let key = without_case(&canonical_file);
        match self.files.get(&key) {
            // One sheet shows several sequences.
            Some((_, "contact_sheet", other))
                if setting == "contact_sheet" && canonical(other) == canonical_file =>
            {
                Ok(())
            }
            // Within a sequence the plan checks.
            Some((owner, ..)) if *owner == index => Ok(()),
            Some((owner, _, other)) => {
                let (first, second) = (&self.sequences[*owner], &self.sequences[index]);
                Err(Error::setting(setting, collision(first, second, [other, file], second.pattern(setting))))
            }
            None => {
                self.files.insert(key, (index, setting, file.to_owned()));
                Ok(())
            }
        }
    }

    /// That a file of an added sequence is an input of the shot `reader`.
    fn is_read_later(&self, (owner, setting, file): (usize, &'static str, &Path), reader: &Path) -> Error {
        let why = format!(
            "\"{}\" is an input of {} and cannot be written to by {} as well; choose another name",
            file.display(),
            reader.display(),
            self.sequences[owner].label
        );
        Error::setting(setting, why)
    }

    fn in_known_folder(&mut self, file: &Path) -> PathBuf {
        let (Some(folder), Some(name)) = (file.parent(), file.file_name()) else { return canonical(file) };
        if let Some(folder) = self.folders.get(folder) {
            return folder.join(name);
        }
        let whole = canonical(file);
        if let Some(of_folder) = whole.parent() {
            self.folders.insert(folder.to_owned(), of_folder.to_owned());
        }
        whole
    }
}

/// Checks that the files of `sequences` that a shot file names are in its folder or in one of `allowed`: where placeholders are filled,
/// they may lead into other folders, through links, than their names with placeholders.
///
/// # Errors
/// [`Error::Refused`] for a file outside of them.
pub(in crate::cli) fn check_folders<'a>(
    sequences: impl IntoIterator<Item = &'a SequenceOutline>,
    shot: &ShotSettings,
    allowed: &[PathBuf],
) -> Result<()> {
    let file_of = |setting: &str| match shot.settings.origin_of(setting) {
        Some(Provenance::File { path, .. }) => Some(path),
        _ => None,
    };
    let mut checked = BTreeSet::new();
    for sequence in sequences {
        let frames = file_of("output").map(|_| frame_files(sequence, &shot.values)).unwrap_or_default();
        let frames = frames.into_iter().map(|path| (path, "output"));
        let others = sequence.sidecar_files().map(|(path, setting)| (path.to_owned(), setting));
        for (path, setting) in frames.chain(others) {
            let Some(file) = file_of(setting) else { continue };
            if checked.insert((path.parent().map(Path::to_owned), setting)) {
                check_inside(file, setting, &path, allowed)?;
            }
        }
    }
    Ok(())
}

/// The frames' main files, those of split AOVs, and previews.
pub(super) fn frame_files(sequence: &SequenceOutline, args: &SettingValues) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let aovs = args.aovs.iter().filter(|_| args.split_aovs).flat_map(AovSet::as_slice);
    // The first of them is in the main file.
    let split: Vec<_> = aovs.skip(1).collect();
    for &frame in &sequence.frames {
        let main = sequence.output.path(frame);
        files.extend(split.iter().map(|aov| sequence.output.layer_path(frame, aov.name())));
        files.extend(args.preview.map(|_| main.with_extension("png")));
        files.push(main);
    }
    files
}

/// Names of the files of a sequence with placeholders, each with its setting.
fn patterns(sequence: &SequenceOutline, args: &SettingValues) -> Vec<(&'static str, PathBuf)> {
    let beside = [
        ("movie", &args.movie),
        ("contact_sheet", &args.contact_sheet),
        ("stats", &args.stats),
        ("manifest", &args.manifest),
    ];
    let beside = beside.into_iter().filter_map(|(setting, file)| Some((setting, file.clone()?)));
    std::iter::once(("output", sequence.pattern.shown().into())).chain(beside).collect()
}

/// What is wrong with two sequences that write one file, and what tells them apart, such as a placeholder in the name `pattern`.
fn collision(first: &Owner, second: &Owner, files: [&Path; 2], pattern: &Path) -> String {
    let file = files[1].display();
    let name = |owner: &Owner, placeholder| owner.names.of(placeholder).to_string_lossy().to_lowercase();
    let differs = |placeholder: &Placeholder| name(first, *placeholder) != name(second, *placeholder);
    // Clips, cameras and variants of two scenes may have any names.
    let telling = if first.scene == second.scene {
        &Placeholder::ALL[..]
    } else {
        &[Placeholder::Scene, Placeholder::Shot]
    };
    let remedy = if files[0] != files[1] && files[0].file_name() != files[1].file_name() {
        format!("\"{}\" differs in case only; choose another name", files[0].display())
    } else if let Some(placeholder) = telling.iter().copied().find(differs) {
        let placeholder = placeholder.text();
        let name = pattern.file_name().unwrap_or_default().display();
        let example = pattern.with_file_name(format!("{placeholder}.{name}"));
        format!("put {placeholder} in the name, such as {}", example.display())
    } else if first.shot == second.shot {
        "their names are equal in names of files; select one by its index, such as '#1'".to_owned()
    } else if first.label == second.label {
        "it is named twice; name it once".to_owned()
    } else {
        let name = second.names.of(Placeholder::Shot).display();
        format!("both are called \"{name}\"; rename one, or render them to different folders")
    };
    format!("{} and {} would both be written to \"{file}\"; {remedy}", first.label, second.label)
}
