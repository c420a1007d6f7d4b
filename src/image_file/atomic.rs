//! Atomic writing of files: a final name holds a complete file or nothing new.
//!
//! The bytes go to a temporary file in the same folder, are synced, and then renamed over the final name, and the folder
//! is synced. A temporary is named `.NAME.<process>.<random>.tmp`; one whose process is gone is removed by the next run
//! that writes the same name. `<process>` holds the process id and a mark of the machine's boot and process namespace,
//! so that another machine or container on the same file system never takes a live temporary for a dead one.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use sha2::{Digest as _, Sha256};
use tempfile::NamedTempFile;

use crate::cancel::CancelFlag;
use crate::error::{Error, Result};

/// Longest file name that common file systems take, bytes.
const NAME_MAX: usize = 255;
/// Bytes that a temporary's name adds to the final one: two dots, the process (8 + 1 + 10), a dot, the random part, `.tmp`.
const TEMPORARY_AFFIXES: usize = 2 + 19 + 1 + RANDOM_CHARACTERS + 4;
const RANDOM_CHARACTERS: usize = 6;
/// Bytes that are written between two looks at a cancellation flag.
const CHUNK_BYTES: usize = 1 << 23;
/// Age beyond which a temporary of an unknown machine counts as abandoned.
const ABANDONED_AFTER: Duration = Duration::from_secs(24 * 3600);

/// Writes a file atomically: even after a crash, `path` holds either its previous content or all of `bytes`.
///
/// # Errors
/// [`Error::CannotCreate`] when the temporary cannot be made, [`Error::WriteFailed`] when it cannot be written or renamed;
/// then the temporary is removed and `path` is unchanged.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<()> {
    write_atomically_unless(&CancelFlag::new(), path, bytes)
}

/// The same, unless `cancel` is raised while the bytes are written.
///
/// # Errors
/// Those of [`write_atomically`], and [`Error::Interrupted`].
pub(crate) fn write_atomically_unless(cancel: &CancelFlag, path: &Path, bytes: &[u8]) -> Result<()> {
    let Replacement(mut temporary) = begin_replacing(path)?;
    for chunk in bytes.chunks(CHUNK_BYTES) {
        cancel.check()?;
        // Write to the file itself, because errors of the wrapper name the temporary.
        let written = temporary.as_file_mut().write_all(chunk);
        written.map_err(|source| Error::WriteFailed { path: path.to_owned(), source })?;
    }
    Replacement(temporary).commit(path)
}

/// Writes a file that no frame of a sequence is: creates its folder, removes what killed runs left of it, and writes it atomically.
/// Reads the folder each time, so sequences do not use it.
///
/// # Errors
/// Those of [`probe_folder`] and [`write_atomically`].
pub fn write_single_file(path: &Path, bytes: &[u8]) -> Result<()> {
    probe_folder(path)?;
    remove_stale_temporaries(&[path.to_owned()]);
    write_atomically(path, bytes)
}

/// A temporary file that takes its final name when it is complete. Dropping it removes the file.
#[derive(Debug)]
pub(crate) struct Replacement(NamedTempFile);

/// Creates the temporary file for `path`.
pub(crate) fn begin_replacing(path: &Path) -> Result<Replacement> {
    create_temporary(path).map(Replacement)
}

impl Replacement {
    /// Path of the temporary file.
    pub(super) fn path(&self) -> &Path {
        self.0.path()
    }

    /// The file, open for reading and writing.
    pub(crate) fn file(&mut self) -> &mut File {
        self.0.as_file_mut()
    }

    /// Opens it for writing.
    pub(super) fn reopen(&self, path: &Path) -> Result<File> {
        self.0.reopen().map_err(|source| Error::WriteFailed { path: path.to_owned(), source })
    }

    /// Syncs the content and renames the file to `path`.
    pub(crate) fn commit(self, path: &Path) -> Result<()> {
        let failed = |source: io::Error| Error::WriteFailed { path: path.to_owned(), source };
        self.0.as_file().sync_all().map_err(failed)?;
        self.0.persist(path).map_err(|error| failed(error.error))?;
        sync_folder(folder_of(path)).map_err(failed)
    }
}

/// Creates the folder of `path` where it is missing and makes sure that a file can be created in it.
///
/// # Errors
/// [`Error::CannotCreate`] with the reason; also when `path` exists and is not a regular file.
pub fn probe_folder(path: &Path) -> Result<()> {
    check_new_names(path)?;
    let folder = folder_of(path);
    fs::create_dir_all(folder).map_err(|error| Error::CannotCreate {
        path: folder.to_owned(),
        message: format!("the output folder cannot be created: {error}; choose another place"),
    })?;
    check_name(path)?;
    create_temporary(path).map(drop)
}

/// Checks that the system accepts the names of the missing folders of `path` and of the file in them.
///
/// # Errors
/// [`Error::CannotCreate`] when it refuses one.
pub(crate) fn check_new_names(path: &Path) -> Result<()> {
    let missing: Vec<&Path> = path.ancestors().take_while(|path| !path.exists()).collect();
    let existing = missing.last().map_or(path, |path| folder_of(path));
    // Where a folder is missing, the system says so, whatever name follows.
    for name in missing.iter().filter_map(|path| path.file_name()) {
        if let Err(error) = fs::symlink_metadata(existing.join(name))
            && error.kind() == io::ErrorKind::InvalidFilename
        {
            return Err(refused_name(path, &error));
        }
    }
    Ok(())
}

fn refused_name(path: &Path, error: &io::Error) -> Error {
    let message = format!("the file cannot be created: {error}; choose another name");
    Error::CannotCreate { path: path.to_owned(), message }
}

/// Checks that `path` is a usable file name. Its folder may be missing.
///
/// # Errors
/// [`Error::CannotCreate`] when something else than a regular file has the name, or the system refuses the name.
pub fn check_name(path: &Path) -> Result<()> {
    let cannot = |message: String| Err(Error::CannotCreate { path: path.to_owned(), message });
    match fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() => {
            cannot("the name exists and is not a file; choose another name".to_owned())
        }
        Err(error) if error.kind() == io::ErrorKind::InvalidFilename => Err(refused_name(path, &error)),
        _ => Ok(()),
    }
}

/// Removes temporary files of `paths` that ended processes left. Failures are ignored.
pub fn remove_stale_temporaries(paths: &[PathBuf]) {
    let mut by_folder = std::collections::BTreeMap::<&Path, Vec<OsString>>::new();
    for path in paths {
        let prefixes = by_folder.entry(folder_of(path)).or_default();
        prefixes.push(hidden_prefix(path));
    }
    for (folder, mut prefixes) in by_folder {
        prefixes.sort();
        let Ok(entries) = fs::read_dir(folder) else {
            continue;
        };
        for entry in entries.flatten() {
            if is_stale(&entry, &prefixes) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

fn create_temporary(path: &Path) -> Result<NamedTempFile> {
    let mut prefix = hidden_prefix(path);
    prefix.push(process_mark());
    prefix.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).rand_bytes(RANDOM_CHARACTERS).suffix(".tmp");
    // The system applies the umask, as to every other file. Otherwise only the owner could read the file.
    #[cfg(unix)]
    builder.permissions(<fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666));
    builder.tempfile_in(folder_of(path)).map_err(|error| Error::CannotCreate {
        path: path.to_owned(),
        message: format!("the file cannot be created: {}; choose another place", without_path(&error)),
    })
}

/// Prefix of the names of hidden files beside `path`: `.NAME.`, with a hash for a name that would be too long.
pub(crate) fn hidden_prefix(path: &Path) -> OsString {
    let name = path.file_name().unwrap_or_default();
    let mut prefix = OsString::from(".");
    if name.len() + TEMPORARY_AFFIXES > NAME_MAX {
        prefix.push(short_hash(name.as_encoded_bytes()));
    } else {
        prefix.push(name);
    }
    prefix.push(".");
    prefix
}

/// `<machine>-<process id>`.
pub(crate) fn process_mark() -> String {
    format!("{}-{}", machine_mark(), std::process::id())
}

/// Eight hexadecimal digits that differ between machines, boots and process namespaces.
fn machine_mark() -> String {
    let boot = fs::read("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let namespace = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
    let mut seed = boot;
    seed.extend_from_slice(namespace.as_os_str().as_encoded_bytes());
    short_hash(&seed)
}

fn short_hash(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    format!("{:02x}{:02x}{:02x}{:02x}", digest[0], digest[1], digest[2], digest[3])
}

fn is_stale(entry: &fs::DirEntry, prefixes: &[OsString]) -> bool {
    let name = entry.file_name();
    let Some(mark) = mark_in(&name, prefixes) else {
        return false;
    };
    // Where process 1 is hidden (`hidepid`), live processes of other users may be hidden, too.
    if let Some((machine, process)) = mark.split_once('-')
        && machine == machine_mark()
        && process.bytes().all(|byte| byte.is_ascii_digit())
        && Path::new("/proc/1").exists()
    {
        return !Path::new("/proc").join(process).exists();
    }
    let age = entry
        .metadata()
        .and_then(|metadata| metadata.modified())
        .ok()
        .and_then(|modified| modified.elapsed().ok());
    age.is_some_and(|age| age > ABANDONED_AFTER)
}

/// The process mark of a temporary of one of `prefixes` (sorted).
fn mark_in(name: &OsStr, prefixes: &[OsString]) -> Option<String> {
    let bytes = name.as_encoded_bytes().strip_suffix(b".tmp")?;
    let random_dot = bytes.len().checked_sub(RANDOM_CHARACTERS + 1)?;
    let rest = bytes[..random_dot].to_vec();
    let mark_dot = rest.iter().rposition(|&byte| byte == b'.')?;
    let prefix = &rest[..=mark_dot];
    prefixes.binary_search_by(|candidate| candidate.as_encoded_bytes().cmp(prefix)).ok()?;
    String::from_utf8(rest[mark_dot + 1..].to_vec()).ok()
}

/// The folder that holds `path`; `.` for a bare name.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Syncs a folder to make a renaming durable. File systems without folder sync are ignored.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if !cfg!(unix) {
        return Ok(());
    }
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
            Ok(())
        }
        // A folder that may be written but not read cannot be opened for syncing.
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => Ok(()),
        outcome => outcome,
    }
}

/// Message of the system without the name of the temporary.
fn without_path(error: &io::Error) -> String {
    let text = error.to_string();
    text.split_once(" at path ").map_or(text.as_str(), |(message, _)| message).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<OsString> {
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name()).collect();
        names.sort();
        names
    }

    #[test]
    fn writing_replaces_the_whole_file_and_leaves_no_temporary() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_atomically(&path, b"a long first version").unwrap();
        write_atomically(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names(folder.path()), ["a.exr"]);
    }

    #[test]
    fn a_cancelled_write_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_atomically(&path, b"first").unwrap();
        let cancel = CancelFlag::new();
        cancel.raise();
        let error = write_atomically_unless(&cancel, &path, b"second").unwrap_err();
        assert!(matches!(error, Error::Interrupted(_)), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(names(folder.path()), ["a.exr"]);
    }

    #[test]
    fn longest_names_fit() {
        // 255 bytes is NAME_MAX of ext4, xfs, tmpfs and NFS.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("n".repeat(255));
        write_atomically(&path, b"x").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"x");
    }

    #[test]
    fn missing_folders_are_created_and_a_folder_of_the_name_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x/y/a.exr");
        probe_folder(&path).unwrap();
        assert_eq!(names(path.parent().unwrap()), [] as [&str; 0]);
        // A name that is too long, of the file or of a folder, leaves no folder.
        let long = "n".repeat(300);
        for refused in [format!("z/{long}.exr"), format!("z/{long}/a.exr"), format!("z/y/{long}/x/a.exr")] {
            assert_eq!(probe_folder(&folder.path().join(refused)).unwrap_err().exit_code(), 73);
        }
        assert_eq!(names(folder.path()), ["x"]);
        fs::create_dir(&path).unwrap();
        assert_eq!(probe_folder(&path).unwrap_err().exit_code(), 73);
        let below_a_file = folder.path().join("file");
        fs::write(&below_a_file, "").unwrap();
        assert_eq!(probe_folder(&below_a_file.join("a.exr")).unwrap_err().exit_code(), 73);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn impossible_names_are_found_early() {
        let folder = tempfile::tempdir().unwrap();
        // One byte more than NAME_MAX.
        let too_long = folder.path().join("n".repeat(256));
        assert_eq!(check_name(&too_long).unwrap_err().exit_code(), 73);
        assert_eq!(probe_folder(&too_long).unwrap_err().exit_code(), 73);
        // Nobody may create files in /proc.
        let error = probe_folder(Path::new("/proc/a.exr")).unwrap_err();
        assert!(
            error.to_string().starts_with("/proc/a.exr: ") && !error.to_string().contains(".tmp"),
            "{error}"
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn only_temporaries_of_dead_processes_and_the_same_name_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        // Process ids stay below 2²², so no process has this one.
        let dead = format!(".a.exr.{}-4194999.abcdef.tmp", machine_mark());
        let alive = format!(".a.exr.{}.abcdef.tmp", process_mark());
        let elsewhere = ".a.exr.00000000-4194999.abcdef.tmp".to_owned();
        let other = format!(".b.exr.{}-4194999.abcdef.tmp", machine_mark());
        for name in [&dead, &alive, &elsewhere, &other] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        remove_stale_temporaries(&[path]);
        let mut expected = vec![OsString::from(alive), elsewhere.into(), other.into()];
        expected.sort();
        assert_eq!(names(folder.path()), expected);
    }

    #[cfg(unix)]
    #[test]
    fn the_mode_follows_the_umask() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let (atomic, plain) = (folder.path().join("a"), folder.path().join("b"));
        write_atomically(&atomic, b"").unwrap();
        fs::write(&plain, b"").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&atomic), mode(&plain));
    }
}
