//! The summary of a result in Markdown, for pull requests: counts, and one table of failures and one of changes, worst first.
//!
//! It stays below the 65,536 characters of a comment on GitHub, and so below the 1 MiB of a step summary. Thumbnails lie in a folder
//! beside the file.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::findings::Finding;
use rayframe::error::Result;
use rayframe::image_file::{
    DisplayImage, SUMMARY_MARK, THUMBNAIL, encode_png, is_marked_png, write_single_file,
};
use rayframe::regression::{Verdict, VerdictCounts, heat_map_thumbnail, thumbnail};
use rayframe::terminal::misleads;

/// Largest number of characters of the file.
const MAX_CHARACTERS: usize = 65_536;
/// Characters kept free for the lines after the last row.
const TAIL_CHARACTERS: usize = 200;
/// Characters of a message or cause, after which it is cut.
const MAX_MESSAGE_CHARACTERS: usize = 240;
/// Number of messages of an image.
const MAX_MESSAGES: usize = 3;
/// Number of lines of lost content.
const MAX_LOSSES: usize = 50;
/// Columns of a thumbnail.
const THUMBNAIL_COLUMNS: u32 = 160;
/// Last bytes of an image's name in the names of its thumbnails, which file systems limit to 255.
const MAX_NAME_BYTES: usize = 100;
/// Endings of thumbnails.
const ENDINGS: [&str; 3] = ["reference.png", "new.png", "difference.png"];

/// What a summary says.
#[derive(Clone, Copy, Debug)]
pub(super) struct MarkdownSummary<'a> {
    /// What was tested or compared.
    pub(super) title: &'a str,
    /// Numbers of images by verdict.
    pub(super) counts: VerdictCounts,
    /// Content that an asset lost, one line each.
    pub(super) losses: &'a [String],
    /// The images that changed or fail.
    pub(super) findings: &'a [Finding<'a>],
}

/// Writes the summary to `file`, and its thumbnails to the folder `FILE.md.files`, whose thumbnails of earlier runs are removed.
///
/// # Errors
/// Those of writing files.
pub(super) fn write_summary(file: &Path, summary: MarkdownSummary<'_>) -> Result<()> {
    let MarkdownSummary { title, counts, losses, findings } = summary;
    let folder = thumbnail_folder(file);
    remove_thumbnails(&folder);
    let mut text = format!("## {}: {}\n", escaped(title), headline(counts, losses.len()));
    lost(&mut text, losses);
    let mut left_out = 0;
    for (verdict, heading) in [(Verdict::Failed, "Failed"), (Verdict::Changed, "Changed within limits")] {
        let mut rows = findings.iter().enumerate().filter(|(_, finding)| finding.frame.verdict() == verdict);
        let Some(first) = rows.next() else { continue };
        let head = format!(
            "\n### {heading}\n\n| image | verdict | measures | likely cause | reference | new | difference |\n\
             |---|---|---|---|---|---|---|\n"
        );
        let mut has_head = false;
        for (index, finding) in std::iter::once(first).chain(rows) {
            let thumbnails = Thumbnails::new(index, finding);
            let row = thumbnails.row(finding, &folder);
            let head = if has_head { "" } else { &head };
            let characters = [&text, head, &row].map(|part| part.chars().count()).iter().sum::<usize>();
            // Once a row is left out, all others are, as they are better.
            if left_out > 0 || characters + TAIL_CHARACTERS > MAX_CHARACTERS {
                left_out += 1;
                continue;
            }
            text.push_str(head);
            has_head = true;
            thumbnails.write(&folder)?;
            text.push_str(&row);
        }
    }
    if left_out > 0 {
        let rows = if left_out == 1 { "row is" } else { "rows are" };
        let _ = write!(text, "\n{left_out} more {rows} left out; the report has all.\n");
    }
    let _ = writeln!(text, "\n{SUMMARY_MARK}");
    write_single_file(file, text.as_bytes())
}

/// The section of lost content.
fn lost(text: &mut String, losses: &[String]) {
    if losses.is_empty() {
        return;
    }
    text.push_str("\n### Lost\n\n");
    for loss in losses.iter().take(MAX_LOSSES) {
        let _ = writeln!(text, "- {}", cell(loss));
    }
    if losses.len() > MAX_LOSSES {
        let _ = writeln!(text, "- and {} more", losses.len() - MAX_LOSSES);
    }
}

/// The counts, the worst first, without those of nothing.
fn headline(counts: VerdictCounts, lost: usize) -> String {
    let VerdictCounts { identical, changed, failed } = counts;
    let parts =
        [(lost, "lost"), (failed, "failed"), (changed, "changed within limits"), (identical, "identical")];
    let parts = parts.iter().filter(|(count, _)| *count > 0);
    parts.map(|(count, words)| format!("{count} {words}")).collect::<Vec<_>>().join(", ")
}

/// The folder of the thumbnails.
fn thumbnail_folder(file: &Path) -> PathBuf {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    file.with_file_name(format!("{name}.files"))
}

/// Removes thumbnails of earlier runs. Other files stay.
fn remove_thumbnails(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_numbered = name.starts_with(|first: char| first.is_ascii_digit());
        let is_named = is_numbered && ENDINGS.iter().any(|ending| name.ends_with(ending));
        if is_named && is_marked_png(&entry.path(), THUMBNAIL) {
            // One that stays is not named by the new summary.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// The thumbnails of an image: reference, new image and heat map.
struct Thumbnails {
    /// Beginning of their names.
    name: String,
    images: [Option<DisplayImage>; 3],
}

impl Thumbnails {
    fn new(index: usize, finding: &Finding<'_>) -> Self {
        let frame = finding.frame;
        let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' };
        // Each character is one byte.
        let plain: String = frame.name.chars().map(plain).collect();
        let end = &plain[plain.len().saturating_sub(MAX_NAME_BYTES)..];
        let small = |image| thumbnail(image, THUMBNAIL_COLUMNS);
        let heat_map = |image| heat_map_thumbnail(image, THUMBNAIL_COLUMNS);
        Self {
            name: format!("{:04}-{end}", index + 1),
            images: [
                frame.expected.as_ref().and_then(small),
                frame.actual.as_ref().and_then(small),
                frame.actual.as_ref().and_then(heat_map),
            ],
        }
    }

    fn file_names(&self) -> [String; 3] {
        ENDINGS.map(|ending| format!("{}-{ending}", self.name))
    }

    /// The row of the table.
    fn row(&self, finding: &Finding<'_>, folder: &Path) -> String {
        let frame = finding.frame;
        let mut messages: Vec<String> =
            frame.messages.iter().take(MAX_MESSAGES).map(|text| cell(text)).collect();
        if frame.messages.len() > MAX_MESSAGES {
            messages.push(format!("and {} more", frame.messages.len() - MAX_MESSAGES));
        }
        let cause = frame.likely_cause().map(|cause| cell(&cause)).unwrap_or_default();
        let mut row = format!(
            "| <code>{}</code> | {} | {} | {cause} |",
            html_escaped(&frame.name),
            finding.title(),
            messages.join("<br>")
        );
        let folder = address(&folder.file_name().unwrap_or_default().to_string_lossy());
        for ((image, file), ending) in self.images.iter().zip(self.file_names()).zip(ENDINGS) {
            let what = ending.trim_end_matches(".png");
            let _ = match image {
                Some(_) => write!(row, " ![{what}]({folder}/{}) |", address(&file)),
                None => write!(row, " |"),
            };
        }
        row + "\n"
    }

    fn write(&self, folder: &Path) -> Result<()> {
        for (image, file) in self.images.iter().zip(self.file_names()) {
            if let Some(image) = image {
                let path = folder.join(file);
                write_single_file(&path, &encode_png(image.size, &image.pixels, THUMBNAIL)?)?;
            }
        }
        Ok(())
    }
}

/// Text for a cell of a table, on one line.
fn cell(text: &str) -> String {
    let mut short: String = text.chars().take(MAX_MESSAGE_CHARACTERS).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    escaped(&short)
}

/// Text without Markdown.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' | '#' | '!' | '$' => {
                escaped.extend(['\\', character]);
            }
            _ if character.is_control() => escaped.push(' '),
            _ if misleads(character) => escaped.extend(character.escape_unicode()),
            _ => escaped.push(character),
        }
    }
    escaped
}

/// Text for an HTML element in a cell of a table.
fn html_escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let markdown = ['|', '\\', '`', '*', '_', '[', ']', '~', '$'];
    text.chars().fold(String::new(), |mut escaped, character| {
        if markdown.contains(&character) || character.is_control() {
            let _ = write!(escaped, "&#{};", u32::from(character));
        } else if misleads(character) {
            escaped.extend(character.escape_unicode());
        } else {
            escaped.push(character);
        }
        escaped
    })
}

/// A path as a relative address.
fn address(path: &str) -> String {
    path.bytes().fold(String::new(), |mut address, byte| {
        if byte.is_ascii_alphanumeric() || b"._-".contains(&byte) {
            address.push(char::from(byte));
        } else {
            let _ = write!(address, "%{byte:02X}");
        }
        address
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayframe::image::{ColorEncoding, Image};
    use rayframe::regression::{EncodedImage, FailOn, FrameResult, FrameStatus, SuiteResult};

    #[test]
    fn names_and_messages_cannot_leave_their_cell() {
        assert_eq!(escaped("a|b*c\n<i>"), "a\\|b\\*c &lt;i&gt;");
        assert_eq!(html_escaped("a|b_<"), "a&#124;b&#95;&lt;");
        assert_eq!(escaped("a\u{202e}b"), "a\\u{202e}b");
        assert_eq!(html_escaped("a\u{202e}b"), "a\\u{202e}b");
        assert_eq!(address("my summary.md.files"), "my%20summary.md.files");
        assert!(cell(&"x".repeat(1000)).chars().count() == MAX_MESSAGE_CHARACTERS + 1);
    }

    #[test]
    fn lost_content_comes_first() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("summary.md");
        let losses: Vec<_> = (0..52).map(|at| format!("lost: clip \"walk_{at}\"")).collect();
        let counts = VerdictCounts { identical: 3, ..VerdictCounts::default() };
        let summary = MarkdownSummary { title: "a against b", counts, losses: &losses, findings: &[] };
        write_summary(&file, summary).unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        let head = "## a against b: 52 lost, 3 identical\n\n### Lost\n\n- lost: clip \"walk\\_0\"\n";
        assert!(text.starts_with(head) && text.contains("\n- and 2 more\n"), "{text}");
    }

    #[test]
    fn rows_say_how_many_messages_are_cut() {
        let row = |count: usize| {
            let messages = (0..count).map(|at| format!("lost: clip \"walk {at}\"")).collect();
            let frame = FrameResult {
                messages,
                ..FrameResult::new("robot".to_owned(), None, FrameStatus::Different)
            };
            let findings =
                super::super::findings::findings([(&frame, PathBuf::new())].into_iter(), FailOn::default());
            Thumbnails::new(0, &findings[0]).row(&findings[0], Path::new("s.md.files"))
        };
        let three = "lost: clip \"walk 0\"<br>lost: clip \"walk 1\"<br>lost: clip \"walk 2\"";
        assert!(row(3).contains(&format!("| {three} |")), "{}", row(3));
        assert!(row(5).contains(&format!("| {three}<br>and 2 more |")), "{}", row(5));
    }

    #[test]
    fn thumbnails_of_deep_folders_have_short_names() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("summary.md");
        let image = EncodedImage::new(&Image::from_rgba((1, 1), ColorEncoding::Linear, &[[0.5; 4]]));
        let deep = "folder_\u{e9}/".repeat(40);
        let frames = ["a", "b"].map(|shot| FrameResult {
            actual: image.clone(),
            ..FrameResult::new(format!("{deep}{shot}"), None, FrameStatus::Missing)
        });
        let findings = frames.iter().map(|frame| (frame, PathBuf::new()));
        let findings = super::super::findings::findings(findings, FailOn::default());
        let counts = frames.iter().map(FrameResult::verdict).collect();
        write_summary(&file, MarkdownSummary { title: "", counts, losses: &[], findings: &findings })
            .unwrap();
        let entries = std::fs::read_dir(thumbnail_folder(&file)).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(names.len(), 2);
        for (name, end) in names.iter().zip(["-a-new.png", "-b-new.png"]) {
            let name = name.to_str().unwrap();
            assert!(name.len() < 120 && name.ends_with(end) && text.contains(name), "{name}: {text}");
        }
    }

    #[test]
    fn long_summaries_say_how_many_rows_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let missing = |at: usize| {
            let message = "there is no reference ".to_owned() + &"folder/".repeat(30);
            FrameResult::new(format!("shot_{at:04}"), None, FrameStatus::Orphaned).because(message)
        };
        let result = SuiteResult { orphaned: (0..1000).map(missing).collect(), ..SuiteResult::default() };
        let file = folder.path().join("summary.md");
        let frames = result.orphaned.iter().map(|frame| (frame, PathBuf::new()));
        let findings = super::super::findings::findings(frames, FailOn::default());
        let summary =
            MarkdownSummary { title: "suite", counts: result.counts(), losses: &[], findings: &findings };
        write_summary(&file, summary).unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.chars().count() <= MAX_CHARACTERS && text.len() > MAX_CHARACTERS / 2);
        let rows = text.lines().filter(|line| line.starts_with("| <code>")).count();
        assert!(text.contains(&format!("\n{} more rows are left out; the report has all.\n", 1000 - rows)));
        assert!(text.starts_with("## suite: 1000 failed\n\n### Failed\n") && !text.contains("Changed"));
        assert!(!thumbnail_folder(&file).exists());
    }
}
