//! URIs inside a scene file: data URIs, and relative paths.
//!
//! Source: RFC 3986 (relative references, percent encoding) and RFC 2397 (the `data` scheme).

use std::borrow::Cow;
use std::path::PathBuf;

use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

/// Parsed URI.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Uri {
    /// Bytes of a `data:` URI.
    Data(Vec<u8>),
    /// Path relative to the scene's folder.
    Relative(PathBuf),
}

/// Error of a URI.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum UriError {
    /// The URI is malformed.
    Invalid(String),
    /// The URI refers to something other than a relative path.
    Refused(String),
}

/// Base64 as files contain it: padding may be missing, trailing bits may be set.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Whether a URI holds its data itself.
pub(super) fn is_data(uri: &str) -> bool {
    uri.get(.."data:".len()).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// Parses `uri`.
pub(super) fn parse(uri: &str) -> Result<Uri, UriError> {
    match scheme(uri) {
        Some(scheme) if scheme.eq_ignore_ascii_case("data") => decode_data(uri).map(Uri::Data),
        Some(scheme) => Err(UriError::Refused(format!(
            "the URI has the scheme \"{scheme}:\"; only relative paths and data: URIs are read"
        ))),
        None => relative_path(uri).map(Uri::Relative),
    }
}

/// The scheme before the first colon; `None` for a relative reference. A drive letter counts as a scheme.
fn scheme(uri: &str) -> Option<&str> {
    let (head, _) = uri.split_once(':')?;
    let mut characters = head.chars();
    let starts_well = characters.next().is_some_and(|first| first.is_ascii_alphabetic());
    let goes_on_well = characters.all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'));
    (starts_well && goes_on_well).then_some(head)
}

/// The most bytes that a data URI can decode to, known before it is decoded.
pub(super) fn most_data_bytes(uri: &str) -> u64 {
    let Some((is_base64, body)) = data_parts(uri) else { return 0 };
    let characters = body.len() as u64;
    if is_base64 { characters.div_ceil(4).saturating_mul(3) } else { characters }
}

/// Whether the body of a data URI is base64, and the body. `None` without a comma.
fn data_parts(uri: &str) -> Option<(bool, &str)> {
    let (_, content) = uri.split_once(':')?;
    let (header, body) = content.split_once(',')?;
    let is_base64 = header.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    Some((is_base64, body))
}

fn decode_data(uri: &str) -> Result<Vec<u8>, UriError> {
    let Some((is_base64, body)) = data_parts(uri) else {
        return Err(UriError::Invalid("the data: URI has no comma".to_owned()));
    };
    if !is_base64 {
        return Ok(percent_decode_str(body).collect());
    }
    // Copy only if there is whitespace to remove.
    let percent_free: Cow<[u8]> = percent_decode_str(body).into();
    let clean: Cow<[u8]> = if percent_free.iter().any(u8::is_ascii_whitespace) {
        Cow::Owned(percent_free.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).collect())
    } else {
        percent_free
    };
    BASE64
        .decode(clean.as_ref())
        .map_err(|error| UriError::Invalid(format!("the base64 of the data: URI is invalid: {error}")))
}

fn relative_path(uri: &str) -> Result<PathBuf, UriError> {
    let refused = |why: &str| {
        Err(UriError::Refused(format!(
            "the path \"{}\" {why}; only relative paths are read",
            uri.escape_debug()
        )))
    };
    if uri.is_empty() {
        return Err(UriError::Invalid("the URI is empty".to_owned()));
    }
    let Ok(path) = percent_decode_str(uri).decode_utf8() else {
        return refused("is not UTF-8 after percent decoding");
    };
    if path.contains('\0') {
        return refused("contains a NUL character");
    }
    if path.contains('\\') {
        return refused("contains a backslash, where glTF requires \"/\"");
    }
    if path.starts_with('/') {
        return refused("is absolute");
    }
    if scheme(&path).is_some_and(|drive| drive.len() == 1) {
        return refused("has a drive letter");
    }
    Ok(path.split('/').filter(|segment| !matches!(*segment, "" | ".")).collect())
}
