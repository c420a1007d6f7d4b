//! The file of a reference: whether it is there, its bytes, and whether it is a link.

use std::io::ErrorKind;
use std::path::Path;

use crate::error::{Error, Result};
use crate::image_file::read_regular_file;

/// The bytes of the reference at `path`; `None` where there is none.
///
/// # Errors
/// [`Error::Missing`] for a file that cannot be read, and [`Error::Invalid`] for what is no file, and for a link to nothing.
pub(super) fn read_stored(path: &Path) -> Result<Option<Vec<u8>>> {
    check_link(path)?;
    is_there(path).then(|| read_regular_file(path, u64::MAX)).transpose()
}

/// Whether anything has this path, such as a link to nothing. What cannot be looked at is there.
pub(super) fn is_there(path: &Path) -> bool {
    std::fs::symlink_metadata(path).map_or_else(|error| !is_absent(&error), |_| true)
}

/// Refuses a link to nothing: git-annex leaves it in place of a locked file that it has not fetched.
///
/// # Errors
/// [`Error::Invalid`].
pub(super) fn check_link(path: &Path) -> Result<()> {
    let leads_to_nothing = || std::fs::metadata(path).is_err_and(|error| is_absent(&error));
    if path.is_symlink() && leads_to_nothing() {
        let message = "is a link to nothing; fetch its file, as git annex get does";
        return Err(Error::invalid(path, "", message));
    }
    Ok(())
}

/// Whether `path` is a link to nothing, or one that leads back to itself.
pub(super) fn is_unreadable_link(path: &Path) -> bool {
    // What may not be looked at may be a file.
    let leads_nowhere = |error: std::io::Error| error.kind() != ErrorKind::PermissionDenied;
    path.is_symlink() && std::fs::metadata(path).is_err_and(leads_nowhere)
}

/// Refuses to replace a link: what leads to a file that others share, or that git-annex or DVC keeps, would be a file of its own.
///
/// # Errors
/// [`Error::CannotCreate`] for a link, and those of [`check_link`].
pub(super) fn check_replaceable(path: &Path) -> Result<()> {
    check_link(path)?;
    if path.is_symlink() {
        let message = "is a link, which no image replaces; make it a file, as git annex unlock and dvc unprotect do, then accept the image";
        return Err(Error::CannotCreate { path: path.to_owned(), message: message.to_owned() });
    }
    Ok(())
}

fn is_absent(error: &std::io::Error) -> bool {
    [ErrorKind::NotFound, ErrorKind::NotADirectory].contains(&error.kind())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_file_is_an_error_and_nothing_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.exr");
        assert_eq!(read_stored(&file).unwrap(), None);
        std::fs::write(&file, "bytes").unwrap();
        assert_eq!(read_stored(&file).unwrap(), Some(b"bytes".to_vec()));
        // A file cannot hold another one.
        assert_eq!(read_stored(&file.join("b.exr")).unwrap(), None);
        assert_eq!(read_stored(folder.path()).unwrap_err().exit_code(), 65);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_read_and_not_replaced() {
        use std::os::unix::fs::symlink;

        let folder = tempfile::tempdir().unwrap();
        let [file, link, lost] = ["a.exr", "b.exr", "c.exr"].map(|name| folder.path().join(name));
        std::fs::write(&file, "bytes").unwrap();
        symlink("a.exr", &link).unwrap();
        symlink("gone.exr", &lost).unwrap();
        assert_eq!(read_stored(&link).unwrap(), Some(b"bytes".to_vec()));
        assert_eq!(check_replaceable(&link).unwrap_err().exit_code(), 73);
        assert!(is_there(&lost) && !is_there(&folder.path().join("gone.exr")));
        for error in [read_stored(&lost).map(drop), check_replaceable(&lost)] {
            let error = error.unwrap_err();
            assert!(error.exit_code() == 65 && error.to_string().contains("is a link to nothing"), "{error}");
        }
        let cycle = folder.path().join("d.exr");
        symlink("d.exr", &cycle).unwrap();
        let unreadable = [&file, &link, &lost, &cycle, &folder.path().join("gone.exr")];
        assert_eq!(unreadable.map(|path| is_unreadable_link(path)), [false, false, true, true, false]);
        // Links to folders are followed.
        symlink(folder.path(), folder.path().join("linked")).unwrap();
        check_replaceable(&folder.path().join("linked/a.exr")).unwrap();
    }
}
