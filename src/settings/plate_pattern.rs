//! Names of image plates: one file, or one for each frame.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::name_parts::{Part, filled, is_numbered, parse_parts};
use super::os_text::without_prefix;
use super::output_pattern::{OutputPattern, holds_folder};

/// Prefix that makes any image a plate.
const PREFIX: &str = "plate:";
/// Endings of images for displays, which are always plates.
const DISPLAY_ENDINGS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];
/// Endings of images that are environments without a prefix or a place for the frame number.
const LIGHT_ENDINGS: [&str; 2] = ["exr", "hdr"];

/// Files of an image plate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlatePattern {
    parts: Vec<Part>,
}

impl PlatePattern {
    /// The plate that `text` names; `None` where it names no plate: `plate:` and any name, a name that ends as images for displays do, or
    /// the name of a sequence of `.exr` or `.hdr` files. Placeholders and escapes are those of output names. The name of a file that exists
    /// stands for itself.
    ///
    /// # Errors
    /// One line: an empty name, or a place for the frame that is not valid.
    pub(super) fn parse(text: &OsStr) -> Result<Option<Self>, String> {
        let (name, has_prefix) = split(text);
        let ending = ending(&name);
        let is_file = Path::new(&name).is_file();
        let is_plate = has_prefix || DISPLAY_ENDINGS.contains(&ending.as_str());
        if !is_plate && (is_file || !LIGHT_ENDINGS.contains(&ending.as_str())) {
            return Ok(None);
        }
        if name.is_empty() {
            return Err("write the name of an image after plate:".to_owned());
        }
        let pattern = if is_file {
            Self { parts: vec![Part::Literal(name)] }
        } else {
            match parse_parts(&name) {
                Ok(parts) => Self { parts },
                // The name of an environment may hold any character, but there is none of this name.
                Err(_) if !is_plate && !name.to_string_lossy().contains("%d") => return Ok(None),
                Err(why) => return Err(why),
            }
        };
        let is_meaningless = |part: &&Part| matches!(part, Part::Layer | Part::Name(_));
        if let Some(part) = pattern.parts.iter().find(is_meaningless) {
            let placeholder = if let Part::Name(placeholder) = part { placeholder.text() } else { "{layer}" };
            return Err(format!("{placeholder} has no meaning in the name of a plate"));
        }
        Ok(Some(pattern).filter(|pattern| is_plate || pattern.is_numbered()))
    }

    /// Whether there is a file for each frame.
    pub fn is_numbered(&self) -> bool {
        is_numbered(&self.parts)
    }

    /// The file of `frame`.
    pub fn path(&self, frame: i64) -> PathBuf {
        filled(&self.parts, frame, "")
    }

    /// Names of plates, of any frames, that the canonical name `file` may have: those with a number of its digits.
    pub(crate) fn names_like(&self, file: &Path) -> BTreeSet<PathBuf> {
        let ends_folder = |part: &Part| matches!(part, Part::Literal(text) if holds_folder(text));
        let frame = self.parts.iter().position(|part| matches!(part, Part::Frame { .. }));
        let Some(frame) = frame else { return BTreeSet::from([self.path(0)]) };
        let is_in_name = !self.parts[frame..].iter().any(ends_folder);
        let text = if is_in_name { file.file_name().unwrap_or_default() } else { file.as_os_str() };
        let paths =
            numbers_in(text.as_encoded_bytes(), u32::MAX.into()).into_iter().map(|frame| self.path(frame));
        paths.filter(|path| path.file_name() == file.file_name()).collect()
    }

    /// As the setting is written.
    pub(super) fn to_text(&self) -> OsString {
        let mut name = OsString::new();
        for part in &self.parts {
            match part {
                Part::Literal(text) => name.push(OutputPattern::escaped(Path::new(text))),
                Part::Frame { width } => name.push("#".repeat(*width)),
                Part::Layer | Part::Name(_) => {}
            }
        }
        let ending = ending(&name);
        let is_numbered_light = LIGHT_ENDINGS.contains(&ending.as_str()) && self.is_numbered();
        let is_plate = DISPLAY_ENDINGS.contains(&ending.as_str()) || is_numbered_light;
        let mut text = OsString::from(if is_plate { "" } else { PREFIX });
        text.push(name);
        text
    }
}

/// The text of a background with its plate, if it names one, relative to `folder`.
pub(super) fn rebased(text: &OsStr, folder: &Path) -> Option<OsString> {
    let (name, has_prefix) = split(text);
    let literal = folder.join(&name);
    if !has_prefix && LIGHT_ENDINGS.contains(&ending(&name).as_str()) && literal.is_file() {
        return None;
    }
    PlatePattern::parse(text).ok().flatten()?;
    let mut rebased = OsString::from(if has_prefix { PREFIX } else { "" });
    rebased.push(if Path::new(&name).is_absolute() {
        name
    } else if literal.is_file() {
        OutputPattern::escaped(&literal)
    } else {
        Path::new(&OutputPattern::escaped(folder)).join(name).into_os_string()
    });
    Some(rebased)
}

/// The numbers up to `most` that a place for the frame may have been filled with: those of all digits in a row, with their signs.
pub(super) fn numbers_in(text: &[u8], most: i64) -> BTreeSet<i64> {
    let mut numbers = BTreeSet::new();
    for first in 0..text.len() {
        let mut number: i64 = 0;
        for digit in text[first..].iter().take_while(|byte| byte.is_ascii_digit()) {
            let longer = number.checked_mul(10).and_then(|tens| tens.checked_add(i64::from(digit - b'0')));
            let Some(longer) = longer.filter(|longer| *longer <= most) else { break };
            number = longer;
            numbers.extend([number, -number]);
        }
    }
    numbers
}

/// The name without the prefix, and whether there was one.
fn split(text: &OsStr) -> (OsString, bool) {
    match without_prefix(text, PREFIX) {
        Some(name) => (name, true),
        None => (text.to_owned(), false),
    }
}

fn ending(name: &OsStr) -> String {
    let ending = Path::new(name).extension().unwrap_or_default();
    ending.to_ascii_lowercase().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plate(text: &str) -> Option<PlatePattern> {
        PlatePattern::parse(OsStr::new(text)).unwrap()
    }

    #[test]
    fn endings_places_and_the_prefix_make_plates() {
        for text in [
            "a.png",
            "b.JPG",
            "c.jpeg",
            "d.webp",
            "e.####.png",
            "f.##.exr",
            "g.#.hdr",
            "plate:h.exr",
            "plate:i.##.dat",
        ] {
            let plate = plate(text).unwrap();
            assert_eq!(plate.to_text(), text);
            assert_eq!(PlatePattern::parse(&plate.to_text()), Ok(Some(plate)));
        }
        for text in ["sky.exr", "sky.hdr@90", "studio", "none", "0,0,1", "50%.exr"] {
            assert_eq!(plate(text), None, "{text}");
        }
        for text in ["plate:", "a.%s.png", "a.{layer}.png", "{scene}.png"] {
            assert!(PlatePattern::parse(OsStr::new(text)).is_err(), "{text}");
        }
    }

    #[test]
    fn plates_are_numbered_by_frames() {
        let plate = plate("in/p.####.exr").unwrap();
        assert!(plate.is_numbered());
        assert_eq!(plate.path(7), Path::new("in/p.0007.exr"));
    }

    #[test]
    fn names_of_all_plates_are_found_by_their_digits() {
        for (pattern, file, is_found) in [
            ("in/p.####.png", "/in/p.0007.png", true),
            ("in/p.####.png", "/in/p.-007.png", true),
            ("in/p.####.png", "/in/p.12345.png", true),
            ("in/p1####.png", "/in/p10007.png", true),
            ("in/####/p.png", "/in/0007/p.png", true),
            ("in/%02d/p.%04d.png", "/in/07/p.0007.png", true),
            ("p.png", "/in/p.png", true),
            ("in/p.####.png", "/in/p.7.png", false),
            ("in/p.####.png", "/in/q.0007.png", false),
            ("in/p.####.png", "/in/p.png", false),
            ("in/p.##.png", "/in/p.99999999999.png", false),
        ] {
            let names = plate(pattern).unwrap().names_like(Path::new(file));
            let is_same = |name: &PathBuf| Path::new(file).ends_with(name);
            assert_eq!(names.iter().any(is_same), is_found, "{pattern} {file}: {names:?}");
        }
    }

    #[test]
    fn names_are_relative_to_their_folder() {
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("50%#1");
        std::fs::create_dir(&below).unwrap();
        let path_of = |text: &str| {
            let text = rebased(OsStr::new(text), &below).unwrap();
            PlatePattern::parse(&text).unwrap().unwrap().path(3)
        };
        assert_eq!(path_of("a.##.png"), below.join("a.03.png"));
        assert_eq!(path_of("plate:a.exr"), below.join("a.exr"));
        assert_eq!(path_of("/b.png"), Path::new("/b.png"));
        // Files that exist stand for themselves; such an .exr file is an environment.
        std::fs::write(below.join("a#1.png"), "").unwrap();
        std::fs::write(below.join("a#1.exr"), "").unwrap();
        assert_eq!(path_of("a#1.png"), below.join("a#1.png"));
        assert_eq!(rebased(OsStr::new("a#1.exr"), &below), None);
    }
}
