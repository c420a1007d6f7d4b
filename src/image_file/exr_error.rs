//! Errors of the `exr` crate in plain words.

use exr::error::Error;

/// Why a file could not be decoded, to be read after "not a readable OpenEXR file:".
pub(super) fn exr_error_text(error: &Error) -> String {
    match error {
        Error::Invalid(why) => match why.as_ref() {
            "reference to missing bytes" => "it is cut short, or a size in it is wrong".to_owned(),
            "file identifier missing" => "it does not begin as an OpenEXR file".to_owned(),
            why => format!("its content is inconsistent ({why})"),
        },
        Error::NotSupported(why) => format!("it has a feature that is not supported ({why})"),
        Error::Io(error) => error.to_string(),
        Error::Aborted => "decoding it was interrupted".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::image::{ColorEncoding, Image};
    use crate::image_file::{ExrCompression, FrameAttributes, decode_exr, encode_exr, inspect_exr};

    #[test]
    fn damaged_files_are_described_alike_by_every_reader() {
        let image = Image::from_rgba((8, 8), ColorEncoding::Linear, &[[0.5; 4]; 64]);
        let whole = encode_exr(image, ExrCompression::Zip, &FrameAttributes::unknown()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        for (bytes, expected) in [
            (&whole[..100], "it is cut short, or a size in it is wrong"),
            (&[0; 500][..], "it does not begin as an OpenEXR file"),
        ] {
            let path = folder.path().join("a.exr");
            std::fs::write(&path, bytes).unwrap();
            assert_eq!(inspect_exr(&path).map(|_| ()), Err(expected.to_owned()));
            let error = decode_exr(Path::new("a.exr"), bytes, 1 << 20).unwrap_err().to_string();
            assert!(error.ends_with(&format!("not a readable OpenEXR file: {expected}")), "{error}");
        }
    }

    #[test]
    fn other_errors_keep_their_reason() {
        let texts = [
            (Error::Invalid("chunk offset table".into()), "its content is inconsistent (chunk offset table)"),
            (
                Error::NotSupported("deep data version".into()),
                "it has a feature that is not supported (deep data version)",
            ),
            (Error::Io(std::io::Error::other("no disk")), "no disk"),
        ];
        for (error, text) in texts {
            assert_eq!(exr_error_text(&error), text);
        }
    }
}
