//! What an output may replace: files that this program wrote for the same purpose, recognised by marks in their content.
//!
//! Only the ends of a file are read. Links are never replaced unasked, whatever they lead to.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

use super::exr_header::MAGIC;
use super::movie_mark::MOVIE_MARK;
use super::png_text::SIGNATURE;
use super::stored_frame::saved_by;
use crate::error::{Error, Result};

/// Bytes that are read at each end of a file.
const END_BYTES: u64 = 64 << 10;
/// Beginning of the text of PNG files of this program, which is before the end chunk.
const PNG_MARK: &[u8] = b"tEXtrenderHash\0";
/// The end chunk of PNG files.
const PNG_END: &[u8] = b"IEND\xae\x42\x60\x82";
/// Beginning of the hash in EXR files of this program.
const EXR_HASH: &[u8] = b"renderHash\0string\0";
/// Attributes of EXR files of this program, sorted by name: a long manifest of Cryptomatte is between the two.
const EXR_MARKS: [&[u8]; 2] = [b"checksum\0string\0\x40\0\0\0", EXR_HASH];
/// Boxes of a film that are searched for its metadata.
const MAX_BOXES: usize = 16;

/// The `renderHash` of contact sheets.
pub const CONTACT_SHEET: &str = "contact sheet";
/// The `renderHash` of heat maps.
pub const HEAT_MAP: &str = "heat map";
/// The `renderHash` of maps of FLIP.
pub const FLIP_MAP: &str = "FLIP map";
/// The `renderHash` of thumbnails.
pub const THUMBNAIL: &str = "thumbnail";
/// Images that are no frames, each by its `renderHash`, with what it is, to be read after "is".
const OTHER_IMAGES: [(&str, &str); 5] = [
    (CONTACT_SHEET, "a contact sheet"),
    (HEAT_MAP, "a heat map"),
    (FLIP_MAP, "a FLIP map"),
    (MOVIE_MARK, "a movie of this program"),
    (THUMBNAIL, "a thumbnail of a summary"),
];
/// The line by which a summary in Markdown is recognised.
pub const SUMMARY_MARK: &str = "<!-- rayframe summary -->";
/// The tag by which a report page is recognised.
pub const PAGE_MARK: &str = "<meta name=\"generator\" content=\"rayframe\">";

/// What to do about a file that is not replaced.
const REMEDY: &str = "choose another name, or `overwrite` replaces it";

/// The purpose of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// PNG image of many frames.
    ContactSheet,
    /// Movie of any format.
    Movie,
    /// Statistics of a run.
    Statistics,
    /// Manifest of a run.
    Manifest,
    /// FLIP as colours.
    HeatMap,
    /// FLIP as numbers.
    FlipMap,
    /// JUnit XML.
    JUnit,
    /// GitLab's Code Quality.
    CodeQuality,
    /// Summary in Markdown.
    Summary,
    /// HTML page.
    ReportPage,
    /// Result of a suite as JSON.
    SuiteResult,
    /// Manual page of the program or a verb.
    ManualPage,
    /// List of the job files of a farm.
    JobList,
    /// Finished passes of a frame.
    Checkpoint,
}

impl OutputKind {
    /// The purpose of the file that a setting names.
    pub fn of_setting(setting: &str) -> Option<Self> {
        Some(match setting {
            "movie" => Self::Movie,
            "contact_sheet" => Self::ContactSheet,
            "stats" => Self::Statistics,
            "manifest" => Self::Manifest,
            _ => return None,
        })
    }

    fn name(self) -> &'static str {
        match self {
            Self::ContactSheet => "a contact sheet",
            Self::Movie => "a movie of this program",
            Self::Statistics => "statistics of a run",
            Self::Manifest => "a manifest of a run",
            Self::HeatMap => "a heat map",
            Self::FlipMap => "a FLIP map",
            Self::JUnit => "a JUnit file of this program",
            Self::CodeQuality => "a Code Quality report of this program",
            Self::Summary => "a summary of this program",
            Self::ReportPage => "a report",
            Self::SuiteResult => "the result of a test",
            Self::ManualPage => "a manual page of this program",
            Self::JobList => "a list of job files",
            Self::Checkpoint => "a checkpoint of this program",
        }
    }

    /// What to do about a file of another purpose.
    fn remedy(self) -> &'static str {
        match self {
            // Their names are those of the verbs, and what writes them replaces nothing else.
            Self::ManualPage => "choose another folder, or remove the file",
            _ => REMEDY,
        }
    }

    /// Beginning of a file, and the marks in it.
    fn marks(self) -> (&'static [u8], Vec<&'static [u8]>) {
        match self {
            Self::ContactSheet => (SIGNATURE, vec![b"tEXtrenderHash\0contact sheet"]),
            Self::HeatMap => (SIGNATURE, vec![b"tEXtrenderHash\0heat map"]),
            Self::FlipMap => (&MAGIC, vec![b"renderHash\0string\0\x08\0\0\0FLIP map"]),
            Self::Movie => (b"", vec![MOVIE_MARK.as_bytes()]),
            Self::Statistics => (b"{", vec![b"\"software\": \"rayframe", b"\"seconds\":", b"\"threads\":"]),
            Self::Manifest => (b"{", vec![b"\"software\": \"rayframe", b"\"complete\":", b"\"schema\":"]),
            Self::JUnit => (b"<?xml", vec![b"<testsuites name=\"rayframe test\""]),
            Self::CodeQuality => (b"[", vec![b"\"check_name\": \"rayframe-", b"\"fingerprint\":"]),
            Self::Summary => (b"", vec![SUMMARY_MARK.as_bytes()]),
            Self::ReportPage => (b"", vec![PAGE_MARK.as_bytes()]),
            Self::SuiteResult => (b"{", vec![b"\"schema\":", b"\"shots\":"]),
            Self::ManualPage => (b"", vec![b".TH rayframe"]),
            Self::JobList => (b"{", vec![b"\"software\": \"rayframe", b"\"job_files\":"]),
            Self::Checkpoint => (&MAGIC, vec![b"renderHash\0string\0", b"samplesTaken\0string\0"]),
        }
    }

    fn is_mark_of(self, ends: &[u8]) -> bool {
        let (start, marks) = self.marks();
        ends.starts_with(start) && marks.iter().all(|mark| holds(ends, mark))
    }
}

/// Checks that an output of a purpose may be written to `path`: nothing is there, or an earlier output of the same purpose, or an empty
/// file. `overwrites` permits to replace any file, and a link itself, never what it leads to.
///
/// # Errors
/// [`Error::CannotCreate`] for a file of another program or purpose, and for a link.
pub fn check_output(path: &Path, kind: OutputKind, overwrites: bool) -> Result<()> {
    check_replaced(path, (kind.name(), kind.remedy()), overwrites, || {
        let ends = ends_of(path)?;
        Ok(kind.is_mark_of(&ends) || kind == OutputKind::CodeQuality && ends.trim_ascii() == b"[]")
    })
}

/// The same for a file that `is_own` recognises, which is called where `path` is a file with content.
///
/// # Errors
/// [`Error::CannotCreate`].
pub(crate) fn check_existing(
    path: &Path,
    name: &str,
    overwrites: bool,
    is_own: impl FnOnce() -> io::Result<bool>,
) -> Result<()> {
    check_replaced(path, (name, REMEDY), overwrites, is_own)
}

fn check_replaced(
    path: &Path,
    (name, remedy): (&str, &str),
    overwrites: bool,
    is_own: impl FnOnce() -> io::Result<bool>,
) -> Result<()> {
    if overwrites {
        return Ok(());
    }
    let refused = |why: &str| {
        let message = format!("is there already and {why}; {remedy}");
        Err(Error::CannotCreate { path: path.to_owned(), message })
    };
    match std::fs::symlink_metadata(path) {
        Err(_) => return Ok(()),
        Ok(metadata) if metadata.is_symlink() => return refused("is a link"),
        // What is neither a file nor a link is refused by the check of its folder.
        Ok(metadata) if !metadata.is_file() || metadata.len() == 0 => return Ok(()),
        Ok(_) => {}
    }
    match is_own() {
        Ok(true) => Ok(()),
        Ok(false) => refused(&format!("is not {name}")),
        Err(error) => refused(&format!("cannot be read ({error})")),
    }
}

/// Whether an earlier output of a purpose is at `path`, not a link.
pub fn is_output(path: &Path, kind: OutputKind) -> bool {
    let is_file = std::fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_file());
    is_file && ends_of(path).is_ok_and(|ends| kind.is_mark_of(&ends))
}

/// Whether an empty file is at `path`, not a link. Any output may replace it.
pub fn is_empty_file(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_file() && metadata.len() == 0)
}

/// Whether a PNG file of this program has the `renderHash` `mark`.
pub fn is_marked_png(path: &Path, mark: &str) -> bool {
    let is_file = std::fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_file());
    let mark = [PNG_MARK, mark.as_bytes()].concat();
    is_file && ends_of(path).is_ok_and(|ends| holds(&ends, &mark))
}

/// What an image with this `renderHash` is, where it is no frame, to be read after "is".
pub fn other_image(render_hash: &str) -> Option<&'static str> {
    OTHER_IMAGES.iter().find(|(mark, _)| *mark == render_hash).map(|(_, name)| *name)
}

/// The same of a damaged file, as far as its mark is left.
pub(crate) fn damaged_other_image(path: &Path) -> Option<&'static str> {
    let ends = ends_of(path).ok()?;
    let is_marked = |mark: &str| {
        let length = (mark.len() as u32).to_le_bytes();
        ends.starts_with(SIGNATURE) && holds(&ends, &[PNG_MARK, mark.as_bytes()].concat())
            || ends.starts_with(&MAGIC) && holds(&ends, &[EXR_HASH, &length, mark.as_bytes()].concat())
    };
    OTHER_IMAGES.iter().find(|(mark, _)| is_marked(mark)).map(|(_, name)| *name)
}

/// Whether an EXR file has marks of this program.
pub(crate) fn is_own_exr(path: &Path) -> bool {
    ends_of(path).is_ok_and(|ends| has_exr_mark(&ends))
}

fn has_exr_mark(ends: &[u8]) -> bool {
    ends.starts_with(&MAGIC) && EXR_MARKS.iter().any(|mark| holds(ends, mark))
}

/// Whether a file that is no whole EXR frame may be what is left of one of this program, or is zeros, as some are after the system stopped.
/// One that another program has saved since is that program's.
pub(crate) fn may_be_damaged_exr(path: &Path) -> bool {
    ends_of(path).is_ok_and(|ends| is_zeros(&ends) || has_exr_mark(&ends) && saved_by(path).is_none())
}

/// The same of PNG frames. One that was cut off has lost its mark, so that it may be of any program.
pub(crate) fn may_be_damaged_png(path: &Path) -> bool {
    let may_be_own =
        |ends: &[u8]| ends.starts_with(SIGNATURE) && (holds(ends, PNG_MARK) || !holds(ends, PNG_END));
    ends_of(path).is_ok_and(|ends| is_zeros(&ends) || may_be_own(&ends))
}

fn is_zeros(bytes: &[u8]) -> bool {
    bytes.iter().all(|byte| *byte == 0)
}

fn holds(bytes: &[u8], mark: &[u8]) -> bool {
    bytes.windows(mark.len()).any(|part| part == mark)
}

/// The first and the last bytes of a file, and those at the end of a film's metadata.
fn ends_of(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut ends = Vec::new();
    (&mut file).take(END_BYTES).read_to_end(&mut ends)?;
    let mut append = |from: u64, to: u64| -> io::Result<()> {
        file.seek(SeekFrom::Start(from))?;
        (&mut file).take(to.saturating_sub(from)).read_to_end(&mut ends)?;
        Ok(())
    };
    append(END_BYTES.max(length.saturating_sub(END_BYTES)).min(length), length)?;
    if let Some(end) = end_of_film_metadata(path)? {
        append(end.saturating_sub(END_BYTES), end)?;
    }
    Ok(ends)
}

/// Where the box `moov` of an MP4 or QuickTime file ends (ISO/IEC 14496-12, 4.2), whose last box holds the comment.
fn end_of_film_metadata(path: &Path) -> io::Result<Option<u64>> {
    let mut file = File::open(path)?;
    let mut start = 0_u64;
    for index in 0..MAX_BOXES {
        let mut header = Vec::new();
        file.seek(SeekFrom::Start(start))?;
        (&mut file).take(16).read_to_end(&mut header)?;
        let Some((size, name)) = box_header(&header) else { return Ok(None) };
        if index == 0 && name != b"ftyp" {
            return Ok(None);
        }
        let Some(end) = start.checked_add(size) else { return Ok(None) };
        if name == b"moov" {
            return Ok(Some(end));
        }
        start = end;
    }
    Ok(None)
}

/// Size and type of a box.
fn box_header(header: &[u8]) -> Option<(u64, &[u8])> {
    let short = u32::from_be_bytes(header.get(..4)?.try_into().ok()?);
    let size = match short {
        1 => u64::from_be_bytes(header.get(8..16)?.try_into().ok()?),
        size => u64::from(size),
    };
    (size >= 8).then_some((size, header.get(4..8)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(content: &[u8], kind: OutputKind) -> u8 {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, content).unwrap();
        assert!(check_output(&path, kind, true).is_ok());
        check_output(&path, kind, false).map_or_else(|error| error.exit_code(), |()| 0)
    }

    #[test]
    fn marks_are_found_at_both_ends_of_long_files_and_not_between() {
        let padding = vec![b'x'; 100_000];
        let mark = SUMMARY_MARK.as_bytes();
        assert_eq!(code(&[mark, &padding, &padding].concat(), OutputKind::Summary), 0);
        assert_eq!(code(&[&padding, &padding, mark].concat(), OutputKind::Summary), 0);
        assert_eq!(code(&[&padding, mark, &padding].concat(), OutputKind::Summary), 73);
    }

    #[test]
    fn empty_files_and_lists_are_replaced_and_other_purposes_are_not() {
        assert_eq!(code(b"", OutputKind::Statistics), 0);
        assert_eq!(code(b"[]\n", OutputKind::CodeQuality), 0);
        assert_eq!(code(b"[1]\n", OutputKind::CodeQuality), 73);
        let sheet = b"\x89PNG\r\n\x1a\n....tEXtrenderHash\0contact sheet";
        assert_eq!(code(sheet, OutputKind::ContactSheet), 0);
        assert_eq!(code(sheet, OutputKind::HeatMap), 73);
    }

    #[test]
    fn comments_of_long_films_are_found() {
        let box_of =
            |name: &[u8], content: &[u8]| [&(content.len() as u32 + 8).to_be_bytes(), name, content].concat();
        let table = vec![0; 200_000];
        let film = |comment: &[u8]| {
            [box_of(b"ftyp", b"isom"), box_of(b"moov", &[&table, comment].concat()), box_of(b"mdat", &table)]
                .concat()
        };
        assert_eq!(code(&film(MOVIE_MARK.as_bytes()), OutputKind::Movie), 0);
        assert_eq!(code(&film(b"holidays"), OutputKind::Movie), 73);
    }
}
