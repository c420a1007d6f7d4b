//! The file of a reference: whether it is there, and its bytes.

use std::io::ErrorKind;
use std::path::Path;

use crate::error::Result;
use crate::image_file::read_regular_file;

/// The bytes of the reference at `path`; `None` where there is none.
///
/// # Errors
/// [`Error::Missing`](crate::Error::Missing) for a file that cannot be read, and [`Error::Invalid`](crate::Error::Invalid) for what is no
/// file.
pub(super) fn read_stored(path: &Path) -> Result<Option<Vec<u8>>> {
    is_there(path).then(|| read_regular_file(path, u64::MAX)).transpose()
}

/// Whether anything has this path. What cannot be looked at is there.
fn is_there(path: &Path) -> bool {
    let absent = [ErrorKind::NotFound, ErrorKind::NotADirectory];
    !std::fs::symlink_metadata(path).is_err_and(|error| absent.contains(&error.kind()))
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
}
