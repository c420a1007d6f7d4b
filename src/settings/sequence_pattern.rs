//! Names of sequences that exist, with the placeholders of output names.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::name_parts::{Part, filled, parse_parts};
use super::output_pattern::OutputPattern;
use super::placeholder::os_string;
use super::plate_pattern::numbers_in;

/// A path with at least one placeholder for the frame number, which is the same in all of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SequencePattern {
    parts: Vec<Part>,
}

impl SequencePattern {
    /// Parses what [`OutputPattern::parse`] does, with any extension. The name of a folder that exists stands for itself. `None` where there
    /// is no frame number, or a place for it that is not valid.
    pub fn parse(path: &Path) -> Option<Self> {
        let name = path.file_name()?;
        let literal = path.parent().filter(|folder| folder.is_dir());
        let text = literal.map_or_else(
            || path.as_os_str().to_owned(),
            |folder| Path::new(&OutputPattern::escaped(folder)).join(name).into_os_string(),
        );
        let parts = parse_parts(&text).ok()?;
        let is_numbered = parts.iter().any(|part| matches!(part, Part::Frame { .. }));
        is_numbered.then_some(Self { parts })
    }

    /// The file of `frame`.
    pub fn path(&self, frame: i64) -> PathBuf {
        filled(&self.parts, frame, "")
    }

    /// The folder whose files or folders have the frame number in their names; empty for the current one.
    pub fn folder(&self) -> PathBuf {
        let fixed = self.parts.iter().map_while(|part| match part {
            Part::Literal(text) => Some(text.as_os_str()),
            _ => None,
        });
        let fixed = fixed.collect::<OsString>().into_encoded_bytes();
        let is_separator = |&byte: &u8| std::path::is_separator(char::from(byte));
        let length = fixed.iter().rposition(is_separator).map_or(0, |at| at + 1);
        os_string(fixed[..length].to_vec()).map(PathBuf::from).unwrap_or_default()
    }

    /// The frames in whose paths `name` follows the [`SequencePattern::folder`], such as one.
    pub fn frames_of(&self, name: &OsStr) -> BTreeSet<i64> {
        let start = self.folder().join(name);
        let numbers = numbers_in(name.as_encoded_bytes()).into_iter();
        numbers.filter(|&frame| self.path(frame).starts_with(&start)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_those_that_the_name_would_be_given() {
        for (pattern, folder, name, frames) in [
            ("a.####.exr", "", "a.0007.exr", &[7][..]),
            ("a.####.exr", "", "a.007.exr", &[]),
            ("nowhere/a.##_##.exr", "nowhere/", "a.01_01.exr", &[1]),
            ("nowhere/a.##_##.exr", "nowhere/", "a.01_02.exr", &[]),
            ("nowhere/p%%q.%04d.hdr", "nowhere/", "p%q.-012.hdr", &[-12]),
            ("nowhere/x####/y####.exr", "nowhere/", "x0003", &[3]),
            ("nowhere/50%%/{frame}.exr", "nowhere/50%/", "12.exr", &[12]),
        ] {
            let pattern = SequencePattern::parse(Path::new(pattern)).unwrap();
            assert_eq!(pattern.folder(), Path::new(folder));
            assert_eq!(pattern.frames_of(OsStr::new(name)), frames.iter().copied().collect(), "{name}");
        }
        for path in ["a.exr", "%%d.exr", "a.%4d.exr", "..", ""] {
            assert_eq!(SequencePattern::parse(Path::new(path)), None, "{path}");
        }
    }

    #[test]
    fn a_folder_that_exists_stands_for_itself() {
        let folder = tempfile::tempdir().unwrap();
        let literal = folder.path().join("50%#1");
        std::fs::create_dir(&literal).unwrap();
        let pattern = SequencePattern::parse(&literal.join("a.#.exr")).unwrap();
        assert_eq!(pattern.path(3), literal.join("a.3.exr"));
    }
}
