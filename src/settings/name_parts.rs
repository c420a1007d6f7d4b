//! Parts of file names with placeholders for the frame number, the AOV, and the names of what is rendered.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use super::placeholder::{Placeholder, os_string, unknown_placeholder, word_in_braces};

/// Part of a file name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Text as it is.
    Literal(OsString),
    /// The frame number, padded with zeros to this many characters, a minus sign included (as `printf` does).
    Frame { width: usize },
    /// Name of the AOV.
    Layer,
    /// Name of the scene, the shot file, the clip, the camera or the variant, until [`OutputPattern::with_names`] replaces it.
    Name(Placeholder),
}

/// Placeholder of the name of an AOV.
const LAYER_PLACE: &[u8] = b"{layer}";
/// Placeholders, for messages.
const KNOWN: &str = "{frame}, {layer}, {scene}, {shot}, {clip}, {camera}, {variant}";

/// The parts of a name with placeholders.
///
/// # Errors
/// One line, for a place for the frame that is not valid and for an unknown placeholder.
pub(super) fn parse_parts(text: &OsStr) -> Result<Vec<Part>, String> {
    let bytes = text.as_encoded_bytes();
    let mut parts = Vec::new();
    let mut literal = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        if let Some((width, length)) = frame_place(&bytes[at..])? {
            parts.push(Part::Literal(os_string(std::mem::take(&mut literal))?));
            parts.push(Part::Frame { width });
            at += length;
        } else if bytes[at..].starts_with(LAYER_PLACE) {
            parts.push(Part::Literal(os_string(std::mem::take(&mut literal))?));
            parts.push(Part::Layer);
            at += LAYER_PLACE.len();
        } else if let Some(placeholder) = Placeholder::at(&bytes[at..]) {
            parts.push(Part::Literal(os_string(std::mem::take(&mut literal))?));
            parts.push(Part::Name(placeholder));
            at += placeholder.text().len();
        } else if let Some(word) = word_in_braces(&bytes[at..]) {
            return Err(unknown_placeholder(word, KNOWN));
        } else {
            at += usize::from(is_escape(&bytes[at..]));
            literal.push(bytes[at]);
            at += 1;
        }
    }
    parts.push(Part::Literal(os_string(literal)?));
    Ok(parts)
}

/// Whether the frame number is part of the name.
pub(super) fn is_numbered(parts: &[Part]) -> bool {
    parts.iter().any(|part| matches!(part, Part::Frame { .. }))
}

/// The name with the number of a frame and the name of an AOV.
pub(super) fn filled(parts: &[Part], frame: i64, layer: &str) -> PathBuf {
    let mut path = OsString::new();
    for part in parts {
        match part {
            Part::Literal(text) => path.push(text),
            Part::Frame { width } => path.push(format!("{frame:0width$}")),
            Part::Layer => path.push(layer),
            Part::Name(placeholder) => path.push(placeholder.text()),
        }
    }
    PathBuf::from(path)
}

/// Whether `bytes` begins with an escaped character.
fn is_escape(bytes: &[u8]) -> bool {
    matches!(bytes, [b'%', b'%' | b'#' | b'{', ..])
}

/// Whether a byte of a name belongs to a letter. `%d` before one is no frame number: `50%done.exr` is a word.
pub(super) fn is_letter(byte: u8) -> bool {
    byte.is_ascii_alphabetic() || !byte.is_ascii()
}

/// Width and length of the frame placeholder at the beginning of `bytes`.
fn frame_place(bytes: &[u8]) -> Result<Option<(usize, usize)>, String> {
    match bytes {
        [b'#', ..] => {
            let width = bytes.iter().take_while(|&&byte| byte == b'#').count();
            Ok(Some((width, width)))
        }
        _ if is_escape(bytes) => Ok(None),
        [b'%', b'd', next, ..] if is_letter(*next) => {
            Err("%d before a letter in a name must be %01d, or %%d for the text itself".to_owned())
        }
        [b'%', rest @ ..] => closed_place(rest, b'd')
            .map(|(width, length)| Some((width, length + 1)))
            .ok_or_else(|| "a % in a name must be %04d, %d, or %% for a percent sign".to_owned()),
        _ => match bytes.strip_prefix(b"{frame") {
            None => Ok(None),
            Some(rest) => {
                let colon = usize::from(rest.starts_with(b":"));
                closed_place(&rest[colon..], b'}')
                    .map(|(width, length)| Some((width, length + colon + b"{frame".len())))
                    .ok_or_else(|| "a {frame in a name must be {frame:04} or {frame}".to_owned())
            }
        },
    }
}

/// Width and length of `04d` or `d`, with the last character as given. Only zero padding makes names that sort.
fn closed_place(bytes: &[u8], end: u8) -> Option<(usize, usize)> {
    let digits = bytes.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let is_closed = bytes.get(digits) == Some(&end);
    let is_padded = digits == 0 || (digits <= 3 && bytes[0] == b'0');
    let text = std::str::from_utf8(&bytes[..digits]).ok()?;
    // A number has a digit even where the width is zero.
    let width = if digits == 0 { 1 } else { text.parse::<usize>().ok()?.max(1) };
    (is_closed && is_padded).then_some((width, digits + 1))
}
