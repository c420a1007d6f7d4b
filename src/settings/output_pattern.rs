//! Output patterns: paths with a placeholder for the frame number.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::home_folder::check_expanded;
use super::name_parts::{Part, filled, is_numbered, parse_parts};
use super::placeholder::{OutputNames, Placeholder, os_string};
use crate::image_file::{MOVIE_ENDINGS, MovieFormat};

/// File format of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputFormat {
    /// Scene-linear OpenEXR.
    Exr,
    /// Tone-mapped sRGB PNG.
    Png,
    /// One tone-mapped movie of all frames.
    Movie(MovieFormat),
}

/// A path with any number of placeholders for the frame number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputPattern {
    parts: Vec<Part>,
    format: OutputFormat,
}

/// Name in place of the AOV in the main file.
const MAIN_LAYER: &str = "beauty";
impl OutputPattern {
    /// Parses `####` (any number), `%04d`, `%d`, `{frame:04}` and `{frame}`; `{layer}`; each [`Placeholder`]; `%%`, `%#` and `%{` are the second
    /// character itself. `%d` before a letter is an error.
    ///
    /// # Errors
    /// One line: an unknown extension, a folder, an unknown placeholder, or a place for the frame that is not valid.
    pub fn parse(text: &OsStr) -> Result<Self, String> {
        check_expanded(Path::new(text))?;
        let parts = parse_parts(text)?;
        let format = format_of(Path::new(text))?;
        let pattern = Self { parts, format };
        if matches!(format, OutputFormat::Movie(_)) && pattern.is_numbered() {
            let name = Path::new(text).display();
            return Err(format!("\"{name}\" is one movie of all frames; leave the frame number out"));
        }
        Ok(pattern)
    }

    /// `<stem>.####.exr`, or `<stem>.exr` for a single image; the stem is literal. `names` follow it, separated by dots.
    pub fn default_for(stem: &OsStr, names: &[Placeholder], numbered: bool) -> Self {
        let mut parts = vec![Part::Literal(stem.to_owned())];
        for &name in names {
            parts.extend([Part::Literal(".".into()), Part::Name(name)]);
        }
        if numbered {
            parts.push(Part::Literal(".".into()));
            parts.push(Part::Frame { width: 4 });
        }
        parts.push(Part::Literal(".exr".into()));
        Self { parts, format: OutputFormat::Exr }
    }

    /// The text of `path` with all special characters escaped.
    pub fn escaped(path: &Path) -> OsString {
        let mut bytes = Vec::new();
        for &byte in path.as_os_str().as_encoded_bytes() {
            if matches!(byte, b'%' | b'#' | b'{') {
                bytes.push(b'%');
            }
            bytes.push(byte);
        }
        // Only ASCII was added, so that what was Unicode still is.
        os_string(bytes).unwrap_or_else(|_| path.as_os_str().to_owned())
    }

    /// The file format.
    pub fn format(&self) -> OutputFormat {
        self.format
    }

    /// Whether all frames make one movie.
    pub fn is_movie(&self) -> bool {
        matches!(self.format, OutputFormat::Movie(_))
    }

    /// Whether the frame number is part of the name.
    pub fn is_numbered(&self) -> bool {
        is_numbered(&self.parts)
    }

    /// Whether a placeholder is part of the name.
    pub fn has_name(&self, placeholder: Placeholder) -> bool {
        self.parts.contains(&Part::Name(placeholder))
    }

    /// The pattern for messages, with `####` for the frame number.
    pub fn shown(&self) -> String {
        let whole: OsString = self.parts.iter().map(part_text).collect();
        whole.display().to_string()
    }

    /// The text that [`OutputPattern::parse`] reads as this pattern.
    pub fn to_text(&self) -> OsString {
        let mut text = OsString::new();
        let parts: Vec<&Part> =
            self.parts.iter().filter(|part| **part != Part::Literal(OsString::new())).collect();
        let is_frame = |index: usize| matches!(parts.get(index), Some(Part::Frame { .. }));
        for (index, part) in parts.iter().enumerate() {
            match part {
                Part::Literal(literal) => text.push(Self::escaped(Path::new(literal))),
                // Two rows of # would be one number.
                Part::Frame { width }
                    if *width < 100 && (is_frame(index + 1) || index > 0 && is_frame(index - 1)) =>
                {
                    text.push(format!("%0{width}d"));
                }
                Part::Frame { width } => text.push("#".repeat(*width)),
                Part::Layer => text.push("{layer}"),
                Part::Name(placeholder) => text.push(placeholder.text()),
            }
        }
        text
    }

    /// Whether there is a placeholder for the name of an AOV.
    pub fn has_layer_place(&self) -> bool {
        self.parts.contains(&Part::Layer)
    }

    /// The pattern with these of its placeholders replaced by names.
    #[must_use]
    pub fn with_names(&self, names: &OutputNames, replaced: &[Placeholder]) -> Self {
        let mut parts: Vec<Part> = Vec::new();
        for part in &self.parts {
            let literal = match part {
                Part::Literal(text) => text.as_os_str(),
                Part::Name(placeholder) if replaced.contains(placeholder) => names.of(*placeholder),
                _ => {
                    parts.push(part.clone());
                    continue;
                }
            };
            match parts.last_mut() {
                Some(Part::Literal(text)) => text.push(literal),
                _ => parts.push(Part::Literal(literal.to_owned())),
            }
        }
        Self { parts, format: self.format }
    }

    /// A path that all frames have in common: the folder before the first placeholder of a frame or an AOV, and the rest of the pattern
    /// as a name, with `+` for what separates folders.
    pub(crate) fn common_path(&self) -> PathBuf {
        let is_fixed = |part: &&Part| !matches!(part, Part::Frame { .. } | Part::Layer);
        let fixed = self.parts.iter().take_while(is_fixed).map(part_text).collect::<OsString>();
        let whole = self.parts.iter().map(part_text).collect::<OsString>();
        let is_separator = |&byte: &u8| std::path::is_separator(char::from(byte));
        let name_start = fixed.as_encoded_bytes().iter().rposition(is_separator).map_or(0, |at| at + 1);
        let (folder, name) = whole.as_encoded_bytes().split_at(name_start);
        let name = name.iter().map(|byte| if is_separator(byte) { b'+' } else { *byte });
        let path = os_string(folder.iter().copied().chain(name).collect());
        path.map_or_else(|_| self.path(0), PathBuf::from)
    }

    /// The file of `frame`.
    pub fn path(&self, frame: i64) -> PathBuf {
        filled(&self.parts, frame, MAIN_LAYER)
    }

    /// The file of an AOV of `frame`: the name of the AOV replaces its placeholder, or goes in front of the
    /// frame number in the file's name, or in front of the extension.
    pub fn layer_path(&self, frame: i64, layer: &str) -> PathBuf {
        if self.has_layer_place() {
            return filled(&self.parts, frame, layer);
        }
        let mut parts = self.parts.clone();
        let in_name = |part: &Part| matches!(part, Part::Literal(text) if holds_folder(text));
        let name_start = parts.iter().rposition(in_name).unwrap_or(0);
        let number = (name_start..parts.len()).find(|&at| matches!(parts[at], Part::Frame { .. }));
        if let Some(number) = number {
            parts.insert(number, Part::Literal(name_before_number(parts.get(number.wrapping_sub(1)), layer)));
            return filled(&parts, frame, layer);
        }
        let path = filled(&parts, frame, layer);
        let mut extension = OsString::from(layer);
        extension.push(".");
        extension.push(path.extension().unwrap_or_default());
        path.with_extension(extension)
    }
}

/// A part of a pattern for people.
fn part_text(part: &Part) -> OsString {
    match part {
        Part::Literal(text) => text.clone(),
        Part::Frame { width } => "#".repeat(*width).into(),
        Part::Layer => "{layer}".into(),
        Part::Name(placeholder) => placeholder.text().into(),
    }
}

pub(super) fn holds_folder(text: &OsStr) -> bool {
    text.as_encoded_bytes().iter().any(|&byte| std::path::is_separator(char::from(byte)))
}

/// `depth.`, `depth_` or `depth-` after the separator of the number, `.depth.` where it has none.
fn name_before_number(before: Option<&Part>, layer: &str) -> OsString {
    let last = match before {
        Some(Part::Literal(text)) => text.as_encoded_bytes().last().copied(),
        _ => None,
    };
    OsString::from(match last {
        Some(separator @ (b'.' | b'_' | b'-')) => format!("{layer}{}", char::from(separator)),
        Some(byte) if !std::path::is_separator(char::from(byte)) => format!(".{layer}."),
        _ => format!("{layer}."),
    })
}

fn format_of(path: &Path) -> Result<OutputFormat, String> {
    let shown = path.display();
    if path.as_os_str().is_empty() {
        return Err("the name is empty; write one such as shot.####.exr".to_owned());
    }
    if path.as_os_str().as_encoded_bytes().ends_with(b"/") || path.file_name().is_none() {
        return Err(format!("\"{shown}\" names a folder; add a file name such as shot.####.exr"));
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("exr") => Ok(OutputFormat::Exr),
        Some("png") => Ok(OutputFormat::Png),
        Some("") => {
            Err(format!("\"{shown}\" has no extension; end it with .exr or .png, or {MOVIE_ENDINGS}"))
        }
        _ => MovieFormat::of_path(path).map(OutputFormat::Movie).ok_or_else(|| {
            let extension = extension.display();
            format!(
                "\".{extension}\" cannot be written; end it with .exr or .png, or {MOVIE_ENDINGS} for a movie"
            )
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(pattern: &str, frame: i64) -> String {
        let pattern = OutputPattern::parse(OsStr::new(pattern)).unwrap();
        pattern.path(frame).into_os_string().into_string().unwrap()
    }

    #[test]
    fn every_frame_placeholder_is_filled() {
        assert_eq!(path("out/a.####.exr", 7), "out/a.0007.exr");
        assert_eq!(path("a_%04d.exr", 12), "a_0012.exr");
        assert_eq!(path("a_%d.EXR", 12), "a_12.EXR");
        assert_eq!(path("{frame:05}/a.{frame}.png", 3), "00003/a.3.png");
        assert_eq!(path("a.####.exr", -3), "a.-003.exr");
        assert_eq!(path("a.##.exr", 12345), "a.12345.exr");
        assert_eq!(path("50%%/%{x}{a b}{0}.exr", 1), "50%/{x}{a b}{0}.exr");
    }

    #[test]
    fn escaped_folders_are_literal() {
        let folder = "50%/#1 {frame}/a##b";
        let pattern = Path::new(&OutputPattern::escaped(Path::new(folder))).join("####.exr");
        assert_eq!(path(pattern.to_str().unwrap(), 7), format!("{folder}/0007.exr"));
    }

    #[test]
    fn patterns_without_placeholder_are_not_numbered() {
        let parse = |text: &str| OutputPattern::parse(OsStr::new(text)).unwrap();
        assert!(!parse("a.exr").is_numbered());
        assert!(parse("#.exr").is_numbered());
        assert_eq!(parse("a.png").format(), OutputFormat::Png);
        assert_eq!(parse("a.apng").format(), OutputFormat::Movie(MovieFormat::AnimatedPng));
        assert!(parse("a.Mp4").is_movie() && !parse("a.png").is_movie());
    }

    #[test]
    fn unknown_extensions_folders_and_broken_placeholders_are_errors() {
        for text in [
            "",
            "a",
            "a.jpg",
            "out/",
            "a.%s.exr",
            "a.%4d.exr",
            "a.{frame:4}.exr",
            "a.{frame.exr",
            "{name}.exr",
            "%%{x}.exr",
            "a.%",
            "..",
            "%0999999d.exr",
            "a.####.mp4",
            "a.%d.gif",
        ] {
            assert!(OutputPattern::parse(OsStr::new(text)).is_err(), "{text}");
        }
    }

    #[test]
    fn frames_of_a_pattern_have_one_path_in_common() {
        let common = |text: &str| OutputPattern::parse(OsStr::new(text)).unwrap().common_path();
        assert_eq!(common("out/a.####.exr"), Path::new("out/a.####.exr"));
        assert_eq!(common("out/a.%04d.exr"), Path::new("out/a.####.exr"));
        assert_eq!(common("a.exr"), Path::new("a.exr"));
        assert_eq!(common("out/{layer}/####/a.exr"), Path::new("out/{layer}+####+a.exr"));
        assert_eq!(common("/out/v####/a.exr"), Path::new("/out/v####+a.exr"));
    }

    #[test]
    fn aovs_have_names_beside_the_image() {
        let layer = |pattern: &str| {
            let pattern = OutputPattern::parse(OsStr::new(pattern)).unwrap();
            pattern.layer_path(7, "depth").into_os_string().into_string().unwrap()
        };
        assert_eq!(layer("out/a.####.exr"), "out/a.depth.0007.exr");
        assert_eq!(layer("a_%04d.exr"), "a_depth_0007.exr");
        assert_eq!(layer("a-#.exr"), "a-depth-7.exr");
        assert_eq!(layer("shot##.exr"), "shot.depth.07.exr");
        assert_eq!(layer("####.exr"), "depth.0007.exr");
        assert_eq!(layer("out.v2/####.exr"), "out.v2/depth.0007.exr");
        assert_eq!(layer("####/a.exr"), "0007/a.depth.exr");
        assert_eq!(layer("{frame}/a.####.EXR"), "7/a.depth.0007.EXR");
        assert_eq!(layer("a.exr"), "a.depth.exr");
        assert_eq!(layer("{layer}/a.####.exr"), "depth/a.0007.exr");
        assert_eq!(path("{layer}/a.####.exr", 7), "beauty/a.0007.exr");
    }

    #[test]
    fn a_default_name_takes_the_stem_literally() {
        let name = |numbered| OutputPattern::default_for(OsStr::new("50%#1"), &[], numbered).path(2);
        assert_eq!(name(true), Path::new("50%#1.0002.exr"));
        assert_eq!(name(false), Path::new("50%#1.exr"));
    }

    #[test]
    fn names_replace_their_placeholders_literally() {
        let names = OutputNames::new(Path::new("50%#1.glb"), None, "a|{camera}", "####", "x");
        let pattern = OutputPattern::parse(OsStr::new("{scene}/%{clip}.{clip}{camera}.##.exr")).unwrap();
        let filled = pattern.with_names(&names, &Placeholder::ALL);
        assert_eq!(filled.path(3), Path::new("50%#1/{clip}.a_{camera}####.03.exr"));
        assert_eq!(filled.layer_path(3, "depth"), Path::new("50%#1/{clip}.a_{camera}####.depth.03.exr"));
        assert_eq!(OutputPattern::parse(&filled.to_text()).unwrap().path(3), filled.path(3));
        // Those that are left are read again.
        let partly = pattern.with_names(&names, &[Placeholder::Scene]);
        assert_eq!(partly.to_text(), "50%%%#1/%{clip}.{clip}{camera}.##.exr");
        assert!(partly.has_name(Placeholder::Clip) && !partly.has_name(Placeholder::Scene));
        let each = OutputPattern::default_for(OsStr::new("a"), &[Placeholder::Clip], true);
        assert_eq!(each.to_text(), "a.{clip}.####.exr");
    }

    #[test]
    fn adjacent_numbers_and_numbers_of_no_width_are_written_as_they_are_read() {
        for (text, name) in
            [("%d#.exr", "77.exr"), ("%04d{frame}##.exr", "0007707.exr"), ("%0d.exr", "7.exr")]
        {
            let pattern = OutputPattern::parse(OsStr::new(text)).unwrap();
            assert_eq!(path(text, 7), name);
            let written = pattern.to_text();
            assert_eq!(OutputPattern::parse(&written), Ok(pattern), "{}", written.display());
        }
    }

    #[cfg(unix)]
    #[test]
    fn names_need_not_be_unicode() {
        use std::os::unix::ffi::OsStrExt as _;
        let pattern = OutputPattern::parse(OsStr::from_bytes(b"\xff.####.exr")).unwrap();
        assert_eq!(pattern.path(1).as_os_str().as_bytes(), b"\xff.0001.exr");
    }
}
