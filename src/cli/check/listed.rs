//! The files that a manifest lists, and where they are now: a delivery may have been moved.

use std::cmp::Reverse;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};

use rayframe::error::Result;
use rayframe::sequence::{ListedFile, Manifest, canonical};

use super::checked_file::{CheckedFile, FileStatus};
use super::delivered::DeliveredFile;

/// The files of a manifest, and frames that have none.
#[derive(Debug)]
pub(super) struct Listed {
    folder: PathBuf,
    files: Vec<ListedFile>,
    not_rendered: Vec<CheckedFile>,
}

/// Files of a manifest and where they are, `None` for those that are missing.
#[derive(Debug)]
pub(super) struct Matched<'a> {
    pub(super) files: Vec<(ListedFile, Option<PathBuf>)>,
    pub(super) not_rendered: Vec<CheckedFile>,
    /// Files that are there and not listed, sorted by path.
    pub(super) unlisted: Vec<&'a DeliveredFile>,
}

impl Listed {
    /// Reads a manifest.
    ///
    /// # Errors
    /// Those of [`Manifest::read`].
    pub(super) fn read(path: &Path) -> Result<Self> {
        let Manifest { files, not_rendered } = Manifest::read(path)?;
        let no_files = |(frame, status)| {
            let missing = CheckedFile::new(None, FileStatus::Missing, format!("has no files: {status}"));
            CheckedFile { frame: Some(frame), ..missing }
        };
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self { folder, files, not_rendered: not_rendered.into_iter().map(no_files).collect() })
    }

    /// Finds the listed files among the `given` ones, and others where the run wrote them if the given ones are there, too. Without any given
    /// they are looked for where the run wrote them, or beside the manifest.
    pub(super) fn matched(self, given: Option<&[DeliveredFile]>) -> Matched<'_> {
        let Self { folder, files, not_rendered } = self;
        let Some(given) = given else {
            let files = files.into_iter().map(|file| {
                let found = found(&file.path, &folder);
                (file, found)
            });
            return Matched { files: files.collect(), not_rendered, unlisted: Vec::new() };
        };
        let ends = PathEnds::new(&files);
        let mut nearest = HashMap::<&Path, (Nearness, &DeliveredFile)>::new();
        let mut unlisted = Vec::new();
        for file in given {
            let Some((listed, length)) = ends.listed(file) else {
                unlisted.push(file);
                continue;
            };
            let nearness = (length, Reverse(file.path.components().count()));
            match nearest.entry(listed) {
                Entry::Vacant(entry) => {
                    entry.insert((nearness, file));
                }
                Entry::Occupied(mut entry) if entry.get().0 < nearness => {
                    unlisted.push(entry.insert((nearness, file)).1);
                }
                Entry::Occupied(_) => unlisted.push(file),
            }
        }
        unlisted.sort_by(|a, b| a.path.cmp(&b.path));
        // A movie may be outside of the folder of the frames. Where the delivery was moved, files at the old paths are not its own.
        let is_in_place = |(listed, (_, file)): (&&Path, &(_, &DeliveredFile))| {
            **listed == file.path || canonical(listed) == canonical(&file.path)
        };
        let was_moved = nearest.is_empty() || !nearest.iter().all(is_in_place);
        let path = |file: &ListedFile| match nearest.get(&*file.path) {
            Some((_, given)) => Some(given.path.clone()),
            None => (!was_moved && file.path.is_file()).then(|| file.path.clone()),
        };
        let paths: Vec<_> = files.iter().map(path).collect();
        Matched { files: files.into_iter().zip(paths).collect(), not_rendered, unlisted }
    }
}

/// How well a file fits a listed one: by components that their paths share at their ends, then by being in a folder further up.
type Nearness = (usize, Reverse<usize>);

/// The listed paths by their ends, as far as these are below the folder that holds all of them.
struct PathEnds<'a> {
    /// `None` for what several listed paths end in.
    listed: HashMap<&'a Path, Option<&'a Path>>,
    /// Components of the folder that holds all listed files.
    common: usize,
}

impl<'a> PathEnds<'a> {
    fn new(files: &'a [ListedFile]) -> Self {
        let common = common_start(files);
        let mut listed = HashMap::new();
        for path in files.iter().map(|file| file.path.as_path()) {
            for end in ends(path).skip(common) {
                let only = listed.entry(end).or_insert(Some(path));
                // A file of all frames is listed for each of them.
                *only = only.filter(|other| *other == path);
            }
        }
        Self { listed, common }
    }

    /// The listed path that `file` is at now, and the number of components at the ends of both: all below the folder that was given, or all
    /// below the one that holds the listed files.
    fn listed(&self, file: &DeliveredFile) -> Option<(&'a Path, usize)> {
        let count = file.path.components().count();
        let lengths = ends(&file.path).zip((1..=count).rev());
        let (listed, length) =
            lengths.into_iter().find_map(|(end, length)| Some((*self.listed.get(end)?, length)))?;
        let is_whole = |listed: &Path| length + self.common == listed.components().count();
        Some((listed.filter(|listed| length >= file.depth || is_whole(listed))?, length))
    }
}

/// The path, then what is left of it without its first component, and so on to its last one.
fn ends(path: &Path) -> impl Iterator<Item = &Path> {
    let mut rest = path.components();
    std::iter::from_fn(move || {
        let end = rest.as_path();
        rest.next().map(|_| end)
    })
}

/// Number of components that the folders of all files start with.
fn common_start(files: &[ListedFile]) -> usize {
    let mut folders = files.iter().map(|file| file.path.parent().unwrap_or(Path::new("")));
    let Some(first) = folders.next() else { return 0 };
    let of_both = |count, folder: &Path| {
        let shared = first.components().zip(folder.components()).take(count);
        shared.take_while(|(a, b)| a == b).count()
    };
    folders.fold(first.components().count(), of_both)
}

/// The file where it was written, or below the folder of the manifest under as many of its folders as are there.
fn found(path: &Path, folder: &Path) -> Option<PathBuf> {
    if path.exists() {
        return Some(path.to_owned());
    }
    let ends = ends(path).map(|end| folder.join(end));
    ends.filter(|end| end.starts_with(folder)).find(|end| end.is_file())
}
