//! Pairing of the files of two sequences by frame number.
//!
//! A sequence is a folder, or a path with placeholders for the frame number as in output names. A path of an existing file is that file,
//! whatever its name contains.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
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
/// [`Error::Usage`] for a sequence beside a file, for names with placeholders that are not valid, and for two files of one frame number; [`Error::Missing`] when a folder cannot be read or
/// holds no frame.
pub fn pair_files(actual: &Path, reference: &Path) -> Result<PairedFiles> {
    let are_sequences = is_sequence(actual)?;
    if are_sequences != is_sequence(reference)? {
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

/// The files of a sequence, sorted by name and frame.
///
/// # Errors
/// [`Error::Missing`] when a folder cannot be read or holds no frame, and those of [`is_sequence`].
pub fn sequence_files(path: &Path) -> Result<Vec<PathBuf>> {
    let mut files = keyed_files(path, Depth::One)?;
    files.sort_unstable();
    Ok(files.into_iter().map(|(_, file)| file).collect())
}

/// Frame number in a file name.
pub fn frame_number(path: &Path) -> Option<i64> {
    numbered_name(path.file_name()?.to_str()?).1
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
        None => files_of_folder(path, depth)?,
    };
    if files.is_empty() {
        return Err(missing(path, std::io::Error::new(ErrorKind::NotFound, "the sequence has no frames")));
    }
    Ok(files)
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
    let files = files.filter(|(_, file)| file.is_file());
    Ok(files.map(|(frame, file)| ((PathBuf::new(), String::new(), Some(frame)), file)).collect())
}

fn files_of_folder(path: &Path, depth: Depth) -> Result<Vec<(Key, PathBuf)>> {
    let mut files = Vec::new();
    let mut folders = vec![(PathBuf::new(), path.to_owned())];
    while let Some((below, folder)) = folders.pop() {
        for entry in std::fs::read_dir(&folder).map_err(|source| missing(&folder, source))? {
            let entry = entry.map_err(|source| missing(&folder, source))?;
            let (file, name) = (entry.path(), entry.file_name());
            if depth == Depth::All && may_hold_frames(&file) {
                folders.push((below.join(name), file));
            } else if !is_hidden(&file)
                && is_image(&file)
                && file.is_file()
                && !is_output(&file, OutputKind::Movie)
            {
                let (name, frame) = numbered_name(&name.as_encoded_bytes().escape_ascii().to_string());
                files.push(((below.clone(), name, frame), file));
            }
        }
    }
    Ok(files)
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

fn is_image(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    IMAGES.iter().any(|known| extension == *known)
}

/// The name with the last number before the extension replaced by `#`, and the number.
fn numbered_name(name: &str) -> (String, Option<i64>) {
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
mod tests {
    use super::*;
    use crate::image_file::PAGE_MARK;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let file = folder.path().join(name);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, "").unwrap();
        }
        folder
    }

    fn frames_of(paired: &PairedFiles) -> Vec<i64> {
        paired.pairs.iter().filter_map(|pair| pair.frame).collect()
    }

    #[test]
    fn frames_are_paired_by_number() {
        let ours = folder(&["a.0001.exr", "a.0002.exr", "a.0010.exr", "notes.txt", "a.0003.exr.tmp"]);
        let theirs = folder(&["b_1.exr", "b_2.exr", "b_3.exr", "b_x.exr", "c_1.exr"]);
        for place in ["b_#.exr", "b_%d.exr", "b_{frame}.exr"] {
            let paired = pair_files(&ours.path().join("a.####.exr"), &theirs.path().join(place)).unwrap();
            assert_eq!(frames_of(&paired), [1, 2]);
            assert_eq!(paired.only_in_actual, [ours.path().join("a.0010.exr")]);
            assert_eq!(paired.only_in_reference, [theirs.path().join("b_3.exr")]);
        }
        let paired = pair_files(ours.path(), &theirs.path().join("b_#.exr")).unwrap();
        assert_eq!(frames_of(&paired), [1, 2]);
    }

    #[test]
    fn a_minus_belongs_to_a_number_unless_it_follows_a_word() {
        for (name, frame) in [
            ("a.-001.exr", -1),
            ("-3.exr", -3),
            ("neg_-001.exr", -1),
            ("shot--001.exr", -1),
            ("shot-0001.exr", 1),
            ("v2-0001.exr", 1),
            ("\u{e9}-0001.exr", 1),
        ] {
            assert_eq!(frame_number(Path::new(name)), Some(frame), "{name}");
        }
    }

    #[test]
    fn names_that_render_writes_are_found() {
        let files =
            folder(&["a01_01.exr", "a01_02.exr", "p%q.0001.exr", "x0001/y0001.exr", "x0002/y0003.exr"]);
        for pattern in ["a##_##.exr", "p%%q.%04d.exr", "x####/y####.exr"] {
            let pattern = files.path().join(pattern);
            let paired = pair_files(&pattern, &pattern).unwrap();
            assert_eq!(frames_of(&paired), [1], "{}", pattern.display());
            assert_eq!(sequence_files(&pattern).unwrap().len(), 1);
        }
    }

    #[test]
    fn folders_of_several_sequences_are_paired_by_name_too() {
        let ours = folder(&["a.0001.exr", "a.depth.0001.exr", "a.-001.exr"]);
        let theirs = folder(&["a.0001.exr", "a.depth.0001.exr", "a.0002.exr", "still.png"]);
        let paired = pair_files(ours.path(), theirs.path()).unwrap();
        let names: Vec<_> = paired.pairs.iter().map(|pair| pair.actual.file_name().unwrap()).collect();
        assert_eq!(names, ["a.0001.exr", "a.depth.0001.exr"]);
        assert!(paired.pairs.iter().all(|pair| pair.actual.file_name() == pair.reference.file_name()));
        assert_eq!((paired.only_in_actual.len(), paired.only_in_reference.len()), (1, 2));
    }

    #[test]
    fn folders_below_are_paired_by_their_paths() {
        let ours = folder(&[
            "a.1.exr",
            "b/x.1.exr",
            "b/x.2.exr",
            "b/c/still.exr",
            "only/z.png",
            ".git/h.png",
            "report/images/a.exr",
            "s.md",
            "s.md.files/0001-a-new.png",
        ]);
        std::fs::write(ours.path().join("report/index.html"), PAGE_MARK).unwrap();
        let theirs = folder(&["k.1.exr", "b/y.1.exr", "b/y.2.exr", "b/c/still.exr", "b/c/other.exr"]);
        let paired = pair_files(ours.path(), theirs.path()).unwrap();
        let of_pair = |pair: &FilePair| {
            let below = pair.reference.strip_prefix(theirs.path()).unwrap();
            (below.display().to_string().replace('\\', "/"), pair.frame)
        };
        assert_eq!(
            paired.pairs.iter().map(of_pair).collect::<Vec<_>>(),
            [("k.1.exr", Some(1)), ("b/y.1.exr", Some(1)), ("b/y.2.exr", Some(2)), ("b/c/still.exr", None)]
                .map(|(name, frame)| (name.to_owned(), frame))
        );
        assert_eq!(paired.only_in_actual, [ours.path().join("only/z.png")]);
        assert_eq!(paired.only_in_reference, [theirs.path().join("b/c/other.exr")]);
        // A pattern is of one folder, and so is what it is paired with.
        let paired = pair_files(ours.path(), &theirs.path().join("k.#.exr")).unwrap();
        assert_eq!((frames_of(&paired), paired.only_in_actual.len()), (vec![1], 0));
    }

    #[test]
    #[cfg(unix)]
    fn links_to_folders_are_not_followed() {
        let (ours, theirs) = (folder(&["a.exr", "b/c.exr"]), folder(&["a.exr"]));
        std::os::unix::fs::symlink(ours.path().join("b"), theirs.path().join("b")).unwrap();
        std::os::unix::fs::symlink(ours.path(), ours.path().join("b/d")).unwrap();
        let paired = pair_files(ours.path(), theirs.path()).unwrap();
        assert_eq!(paired.pairs.len(), 1);
        assert_eq!(paired.only_in_actual, [ours.path().join("b/c.exr")]);
    }

    #[test]
    fn names_that_are_not_valid_are_usage_errors_unless_they_are_files() {
        let files = folder(&["a.1.exr", "b.%4d.exr"]);
        let [valid, wrong, file] = ["a.#.exr", "a.%4d.exr", "b.%4d.exr"].map(|name| files.path().join(name));
        let pairs = [pair_files(&wrong, &valid).map(drop), pair_files(&valid, &wrong).map(drop)];
        for result in pairs.into_iter().chain([sequence_files(&wrong).map(drop)]) {
            let error = result.unwrap_err();
            assert!(error.exit_code() == 2 && error.to_string().contains("must be %04d"), "{error}");
        }
        assert_eq!(pair_files(&file, &file).unwrap().pairs.len(), 1);
    }

    #[test]
    fn a_word_after_a_percent_sign_is_a_missing_file() {
        let files = folder(&["50%.exr", "b.1.exr"]);
        let [word, pattern, file] =
            ["50%done.exr", "50%d.exr", "b.1.exr"].map(|name| files.path().join(name));
        assert!(!is_sequence(&word).unwrap() && is_sequence(&pattern).unwrap());
        assert_eq!(pair_files(&word, &file).unwrap().pairs[0].actual, word);
        assert_eq!(pair_files(&pattern, &file).unwrap_err().exit_code(), 2);
    }

    #[test]
    fn two_files_of_one_frame_number_are_an_error() {
        let (ours, theirs) = (folder(&["a.01.exr", "a.002.exr", "a.1.exr"]), folder(&["a.1.exr", "a.2.exr"]));
        for error in [pair_files(ours.path(), theirs.path()), pair_files(theirs.path(), ours.path())] {
            let error = error.unwrap_err();
            let message = error.to_string();
            assert_eq!(error.exit_code(), 2);
            assert!(message.contains("a.01.exr and ") && message.contains("a.1.exr have"), "{message}");
        }
        // A field for the number selects one of them.
        let paired = pair_files(&ours.path().join("a.##.exr"), theirs.path()).unwrap();
        assert_eq!(frames_of(&paired), [1]);
    }

    #[test]
    fn a_file_beside_a_sequence_and_empty_folders_are_errors() {
        let (full, empty) = (folder(&["a.0001.exr"]), folder(&["a.txt"]));
        let file = full.path().join("a.0001.exr");
        assert_eq!(pair_files(&file, full.path()).unwrap_err().exit_code(), 2);
        assert_eq!(pair_files(full.path(), empty.path()).unwrap_err().exit_code(), 66);
        assert_eq!(pair_files(&file, &file).unwrap().pairs.len(), 1);
        let pattern = full.path().join("a.%04d.png");
        assert_eq!(pair_files(&pattern, &pattern).unwrap_err().exit_code(), 66);
    }
}
