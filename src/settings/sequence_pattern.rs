//! Names of sequences that exist, with the placeholders of output names.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::name_parts::{Part, filled, is_letter, is_numbered, parse_parts};
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
    /// is no place for the frame number, as in `50%done.exr`: `%d` before a letter is none.
    ///
    /// # Errors
    /// One line: a place for the frame number that is not valid, and a placeholder of another kind.
    pub fn parse(path: &Path) -> Result<Option<Self>, String> {
        let Some(name) = path.file_name() else { return Ok(None) };
        let literal = path.parent().filter(|folder| folder.is_dir());
        let text = literal.map_or_else(
            || path.as_os_str().to_owned(),
            |folder| Path::new(&OutputPattern::escaped(folder)).join(name).into_os_string(),
        );
        let parts = match parse_parts(&text) {
            Ok(parts) => parts,
            Err(why) if has_frame_place(text.as_encoded_bytes()) => return Err(why),
            // The name of a file may hold any character.
            Err(_) => return Ok(None),
        };
        let place = parts.iter().find_map(|part| match part {
            Part::Layer => Some("{layer}"),
            Part::Name(placeholder) => Some(placeholder.text()),
            Part::Literal(_) | Part::Frame { .. } => None,
        });
        if let Some(place) = place {
            return Err(format!(
                "{place} has no meaning in the names of frames that exist; write what render put in its place, or %{place} for the text itself"
            ));
        }
        Ok(is_numbered(&parts).then_some(Self { parts }))
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
        let numbers = numbers_in(name.as_encoded_bytes(), i64::MAX).into_iter();
        numbers.filter(|&frame| self.path(frame).starts_with(&start)).collect()
    }
}

/// Whether a name has what looks like a place for the frame number: `#`, `%4d` or `{frame`, and not `%d` before a letter.
fn has_frame_place(name: &[u8]) -> bool {
    let is_conversion = |rest: &[u8]| {
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let is_word = digits == 0 && rest.get(1).is_some_and(|&next| is_letter(next));
        rest.get(digits) == Some(&b'd') && !is_word
    };
    (0..name.len()).any(|at| match &name[at..] {
        [b'#', ..] => true,
        [b'%', rest @ ..] => is_conversion(rest),
        rest => rest.starts_with(b"{frame"),
    })
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
            ("a.#.exr", "", "a.20240115123000.exr", &[20_240_115_123_000]),
            ("a.#.exr", "", "a.99999999999999999999.exr", &[]),
            ("nowhere/50%d.exr", "nowhere/", "507.exr", &[7]),
            ("nowhere/a%d_b.exr", "nowhere/", "a7_b.exr", &[7]),
            ("nowhere/50%01done.exr", "nowhere/", "507one.exr", &[7]),
            ("nowhere/50%%/{frame}.exr", "nowhere/50%/", "12.exr", &[12]),
        ] {
            let pattern = SequencePattern::parse(Path::new(pattern)).unwrap().unwrap();
            assert_eq!(pattern.folder(), Path::new(folder));
            assert_eq!(pattern.frames_of(OsStr::new(name)), frames.iter().copied().collect(), "{name}");
        }
        let words = ["50%done.exr", "50%détail.exr", "%dämmerung.exr"];
        for path in ["a.exr", "%%d.exr", "50%.exr", "{name}.exr", "..", ""].into_iter().chain(words) {
            assert_eq!(SequencePattern::parse(Path::new(path)), Ok(None), "{path}");
        }
    }

    #[test]
    fn names_of_no_sequence_say_what_is_wrong() {
        for (path, words) in [
            ("a.%4d.exr", "a % in a name must be %04d, %d, or %% for a percent sign"),
            ("50%_####.exr", "a % in a name must be"),
            ("50%done.####.exr", "%d before a letter in a name must be %01d, or %%d for the text itself"),
            ("{name}.####.exr", "{name} is no placeholder"),
            ("a.{frame:4}.exr", "must be {frame:04} or {frame}"),
            ("{layer}.####.exr", "{layer} has no meaning in the names of frames that exist"),
            ("{layer}.exr", "{layer} has no meaning"),
            ("{scene}.####.exr", "{scene} has no meaning"),
        ] {
            let why = SequencePattern::parse(Path::new(path)).unwrap_err();
            assert!(why.contains(words), "{path}: {why}");
        }
        // As `{layer}` in the advice.
        let pattern = SequencePattern::parse(Path::new("%{layer}.##.exr")).unwrap().unwrap();
        assert_eq!(pattern.path(1), Path::new("{layer}.01.exr"));
    }

    #[test]
    fn a_folder_that_exists_stands_for_itself() {
        let folder = tempfile::tempdir().unwrap();
        let literal = folder.path().join("50%#1");
        std::fs::create_dir(&literal).unwrap();
        let pattern = SequencePattern::parse(&literal.join("a.#.exr")).unwrap().unwrap();
        assert_eq!(pattern.path(3), literal.join("a.3.exr"));
    }
}
