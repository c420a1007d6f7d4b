//! Pairing of the files of two sequences by frame number.
//!
//! A sequence is a folder, or a path with placeholders for the frame number as in output names. A path of an existing file is that file,
//! whatever its name contains.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::image_file::{OutputKind, is_output};
use crate::settings::SequencePattern;

/// File name extensions of images in folders.
const IMAGES: [&str; 3] = ["exr", "png", "hdr"];

/// Two files to be compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilePair {
    /// Frame number, if the names have one.
    pub frame: Option<i64>,
    /// The rendered file.
    pub actual: PathBuf,
    /// The reference file.
    pub reference: PathBuf,
}

/// Paired files of two sequences, sorted by name and frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PairedFiles {
    /// Frames of both sequences.
    pub pairs: Vec<FilePair>,
    /// Files without a reference.
    pub only_in_actual: Vec<PathBuf>,
    /// Reference files without a rendered file.
    pub only_in_reference: Vec<PathBuf>,
}

/// Folder below that of the sequence, name with the number replaced by `#`, and the number.
type Key = (PathBuf, String, Option<i64>);

/// Whether a path is a sequence.
///
/// # Errors
/// [`Error::Usage`] for a name of no file that has a placeholder and is not valid.
pub fn is_sequence(path: &Path) -> Result<bool> {
    Ok(path.is_dir() || pattern_of(path)?.is_some())
}

/// The pattern that `path` is, where it is neither a folder nor a file.
fn pattern_of(path: &Path) -> Result<Option<SequencePattern>> {
    if path.is_dir() || path.is_file() {
        return Ok(None);
    }
    SequencePattern::parse(path).map_err(|why| Error::usage(format!("{}: {why}", path.display())))
}

/// Pairs the files of two sequences, or two files, by frame number; also by name where a folder holds several sequences. Of two folders all
/// folders below are paired as well, but for hidden ones, links, and reports of this program.
///
/// # Errors
/// [`Error::Usage`] for a sequence beside a file, for names with placeholders that are not valid, and for two files of one frame number; [`Error::Missing`] when a folder cannot be read,
/// or one of a sequence and a file does not exist, [`Error::NoImages`] when a folder holds no frame.
pub fn pair_files(actual: &Path, reference: &Path) -> Result<PairedFiles> {
    let are_sequences = is_sequence(actual)?;
    if are_sequences != is_sequence(reference)? {
        // A path to nothing is no file.
        for path in [actual, reference] {
            if pattern_of(path)?.is_none() {
                std::fs::metadata(path).map_err(Error::missing(path))?;
            }
        }
        return Err(Error::usage(format!(
            "{} and {}: one is a sequence and the other a file; name two of a kind",
            actual.display(),
            reference.display()
        )));
    }
    if !are_sequences {
        let pair = FilePair { frame: None, actual: actual.to_owned(), reference: reference.to_owned() };
        return Ok(PairedFiles { pairs: vec![pair], ..PairedFiles::default() });
    }
    let depth = if actual.is_dir() && reference.is_dir() { Depth::All } else { Depth::One };
    let (mut ours, mut theirs) = (frames(actual, depth)?, frames(reference, depth)?);
    let sequences = &folders_of_one_sequence(&ours) & &folders_of_one_sequence(&theirs);
    for files in [&mut ours, &mut theirs] {
        let nameless = std::mem::take(files).into_iter().map(|((folder, name, frame), path)| {
            let name = if sequences.contains(&folder) { String::new() } else { name };
            ((folder, name, frame), path)
        });
        *files = nameless.collect();
    }
    let mut paired = PairedFiles::default();
    for (key, actual) in &ours {
        match theirs.remove(key) {
            Some(reference) => {
                paired.pairs.push(FilePair { frame: key.2, actual: actual.clone(), reference });
            }
            None => paired.only_in_actual.push(actual.clone()),
        }
    }
    paired.only_in_reference = theirs.into_values().collect();
    Ok(paired)
}

/// The files of a sequence, sorted by folder, name and frame. Of a folder these are those of all folders below it as well, but for hidden
/// ones, links, and reports of this program.
///
/// # Errors
/// [`Error::Missing`] when a folder cannot be read, [`Error::NoImages`] when it holds no frame, and those of [`is_sequence`].
pub fn sequence_files(path: &Path) -> Result<Vec<PathBuf>> {
    let (files, unreadable) = readable_sequence_files(path)?;
    unreadable.into_iter().next().map_or(Ok(files), Err)
}

/// The same, with the errors of folders below the given one that cannot be read.
///
/// # Errors
/// [`Error::Missing`] when the folder itself cannot be read, [`Error::NoImages`] when nothing is found, and those of [`is_sequence`].
pub fn readable_sequence_files(path: &Path) -> Result<(Vec<PathBuf>, Vec<Error>)> {
    let mut unreadable = Vec::new();
    let mut files = match pattern_of(path)? {
        Some(pattern) => files_of_pattern(&pattern)?,
        None => files_of_folder(path, Depth::All, |error| {
            unreadable.push(error);
            Ok(())
        })?,
    };
    if files.is_empty() && unreadable.is_empty() {
        return Err(no_frames(path));
    }
    files.sort_unstable();
    Ok((files.into_iter().map(|(_, file)| file).collect(), unreadable))
}

/// Frame number in a file name.
pub fn frame_number(path: &Path) -> Option<i64> {
    numbered_name(path.file_name()?).1
}

/// How many levels of folders are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Depth {
    One,
    All,
}

/// The folders whose files are all of one sequence.
fn folders_of_one_sequence(files: &BTreeMap<Key, PathBuf>) -> BTreeSet<PathBuf> {
    let mut names = BTreeMap::<_, BTreeSet<_>>::new();
    for (folder, name, frame) in files.keys() {
        names.entry(folder).or_default().insert((name, frame.is_some()));
    }
    let is_one =
        |names: &BTreeSet<(_, bool)>| names.len() == 1 && names.iter().all(|(_, numbered)| *numbered);
    names.into_iter().filter(|(_, names)| is_one(names)).map(|(folder, _)| folder.clone()).collect()
}

/// Files of a sequence, by folder, name and number, of which each has one file.
fn frames(path: &Path, depth: Depth) -> Result<BTreeMap<Key, PathBuf>> {
    let mut files = keyed_files(path, depth)?;
    files.sort_unstable();
    let same = files.windows(2).find_map(|pair| match pair {
        [(key, one), (next, other)] if key == next => Some((one, other)),
        _ => None,
    });
    match same {
        Some((one, other)) => Err(Error::usage(format!(
            "{} and {} have the same frame number; name one sequence by its digits, such as a.####.exr, or remove one of them",
            one.display(),
            other.display()
        ))),
        None => Ok(files.into_iter().collect()),
    }
}

fn keyed_files(path: &Path, depth: Depth) -> Result<Vec<(Key, PathBuf)>> {
    let files = match pattern_of(path)? {
        Some(pattern) => files_of_pattern(&pattern)?,
        None => files_of_folder(path, depth, Err)?,
    };
    if files.is_empty() { Err(no_frames(path)) } else { Ok(files) }
}

fn no_frames(path: &Path) -> Error {
    let message = if path.is_dir() { "holds no images" } else { "the sequence has no frames" };
    Error::NoImages { path: path.to_owned(), message }
}

fn files_of_pattern(pattern: &SequencePattern) -> Result<Vec<(Key, PathBuf)>> {
    let folder = pattern.folder();
    let read = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
    let mut frames = BTreeSet::new();
    for entry in std::fs::read_dir(read).map_err(|source| missing(read, source))? {
        let entry = entry.map_err(|source| missing(read, source))?;
        frames.extend(pattern.frames_of(&entry.file_name()));
    }
    let files = frames.into_iter().map(|frame| (frame, pattern.path(frame)));
    let files = files.filter(|(_, file)| is_file_or_lost(file));
    Ok(files.map(|(frame, file)| ((PathBuf::new(), String::new(), Some(frame)), file)).collect())
}

/// The files of a folder. `unreadable` decides about errors of folders below it.
fn files_of_folder(
    path: &Path,
    depth: Depth,
    mut unreadable: impl FnMut(Error) -> Result<()>,
) -> Result<Vec<(Key, PathBuf)>> {
    let mut files = Vec::new();
    let mut folders = vec![(PathBuf::new(), path.to_owned())];
    while let Some((below, folder)) = folders.pop() {
        let entries = match entries(&folder) {
            Err(error) if folder != path => {
                unreadable(error)?;
                continue;
            }
            entries => entries?,
        };
        for entry in entries {
            let (file, name) = (entry.path(), entry.file_name());
            if depth == Depth::All && may_hold_frames(&file) {
                folders.push((below.join(name), file));
            } else if !is_hidden(&file)
                && is_image(&file)
                && is_file_or_lost(&file)
                && !is_output(&file, OutputKind::Movie)
            {
                let (name, frame) = numbered_name(&name);
                files.push(((below.clone(), name, frame), file));
            }
        }
    }
    Ok(files)
}

fn entries(folder: &Path) -> Result<Vec<std::fs::DirEntry>> {
    let read = std::fs::read_dir(folder).and_then(Iterator::collect);
    read.map_err(|source| missing(folder, source))
}

fn missing(path: &Path, source: std::io::Error) -> Error {
    Error::Missing { path: path.to_owned(), pointer: String::new(), source }
}

fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'))
}

/// Whether a path is a folder, no link and not hidden, and neither a report of this program nor the thumbnails of a summary.
fn may_hold_frames(folder: &Path) -> bool {
    let is_thumbnails =
        || folder.extension() == Some("files".as_ref()) && folder.with_extension("").is_file();
    folder.is_dir()
        && !folder.is_symlink()
        && !is_hidden(folder)
        && !is_thumbnails()
        && !is_output(&folder.join("index.html"), OutputKind::ReportPage)
}

/// Whether a path is a file, or a link to nothing: a frame that is lost, which those who read it tell.
fn is_file_or_lost(path: &Path) -> bool {
    path.is_file() || path.is_symlink() && !path.exists()
}

fn is_image(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    IMAGES.iter().any(|known| extension == *known)
}

/// The name with the last number before the extension replaced by `#`, and the number. A name that is not UTF-8 has none.
fn numbered_name(name: &OsStr) -> (String, Option<i64>) {
    let Some(name) = name.to_str() else {
        return (name.as_encoded_bytes().escape_ascii().to_string(), None);
    };
    let stem = name.rfind('.').map_or(name, |dot| &name[..dot]);
    let Some(last) = stem.rfind(|character: char| character.is_ascii_digit()) else {
        return (name.to_owned(), None);
    };
    let digits = stem[..=last].rfind(|character: char| !character.is_ascii_digit()).map_or(0, |at| at + 1);
    // A minus sign belongs to the number, as in `a_-001` and `shot--001`, but not after a letter or digit, as in `shot-0001`.
    let before = &stem[..digits];
    let start = match before.strip_suffix('-') {
        Some(rest) if !rest.ends_with(char::is_alphanumeric) => digits - 1,
        _ => digits,
    };
    match stem[start..=last].parse() {
        Ok(frame) => (format!("{}#{}", &name[..start], &name[last + 1..]), Some(frame)),
        Err(_) => (name.to_owned(), None),
    }
}

#[cfg(test)]
mod tests;
