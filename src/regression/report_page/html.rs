//! The text of the page. Parts come from files of this room; what others named is escaped by where it goes.

use std::fmt::Write as _;

use base64::{Engine as _, engine::general_purpose::STANDARD};
use sha2::{Digest as _, Sha256};

use super::budget::Places;
use super::data::{PageData, status};
use super::{FrameStatus, ReportPage};
use crate::error::{Error, Result};

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = concat!(include_str!("page/page.css"), include_str!("page/viewer.css"),);
/// One function, so that nothing of it is global.
const SCRIPT: &str = concat!(
    "(() => {\n\"use strict\";\n",
    include_str!("page/elements.js"),
    include_str!("page/data.js"),
    include_str!("page/state.js"),
    include_str!("page/colors.js"),
    include_str!("page/view.js"),
    include_str!("page/inspect.js"),
    include_str!("page/graph.js"),
    include_str!("page/approvals.js"),
    include_str!("page/list.js"),
    include_str!("page/details.js"),
    include_str!("page/keys.js"),
    include_str!("page/page.js"),
    "})();\n",
);

/// The page.
pub(super) fn html(page: &ReportPage, budget_bytes: usize) -> Result<String> {
    let places = Places::new(page, budget_bytes);
    let json = serde_json::to_string(&PageData::new(page, &places, budget_bytes))
        .map_err(|error| Error::Internal { message: error.to_string() })?;
    let parts = [
        ("policy", policy()),
        ("title", escaped(&page.title)),
        ("style", STYLE.to_owned()),
        ("list", plain_list(page)),
        // Within a script element only `<` could end it or begin a comment; in JSON it stands in texts alone.
        ("data", json.replace('<', "\\u003c")),
        ("pictures", picture_elements(&places)),
        ("script", SCRIPT.to_owned()),
    ];
    Ok(filled(PAGE, &parts))
}

/// Puts each part where the template has its name in double braces. Parts are not looked into.
fn filled(template: &str, parts: &[(&str, String)]) -> String {
    let mut text = String::new();
    let mut rest = template;
    while let Some((before, (name, after))) =
        rest.split_once("{{").and_then(|(before, rest)| Some((before, rest.split_once("}}")?)))
    {
        text.push_str(before);
        if let Some((_, part)) = parts.iter().find(|(known, _)| *known == name) {
            text.push_str(part);
        }
        rest = after;
    }
    text + rest
}

/// Nothing may be loaded, and nothing may run but this script.
fn policy() -> String {
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text.as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{}'; style-src 'sha256-{}'; img-src data: blob:; base-uri 'none'; \
         form-action 'none'",
        hash(SCRIPT),
        hash(STYLE)
    )
}

/// The failures for somebody without scripts.
fn plain_list(page: &ReportPage) -> String {
    let mut text = String::new();
    let failed: usize = page.folders.iter().map(|folder| folder.failed).sum();
    let passed: usize = page.folders.iter().map(|folder| folder.passed).sum();
    let _ = write!(text, "<p>{failed} failed, {passed} passed.</p>\n<ul>");
    for frame in page.shots.iter().flat_map(|shot| &shot.frames) {
        if frame.status != FrameStatus::Passed {
            let _ = write!(text, "\n<li>{}: {}", escaped(&frame.name), status(frame.status));
            for message in &frame.messages {
                let _ = write!(text, "<br>{}", escaped(message));
            }
            text.push_str("</li>");
        }
    }
    text + "\n</ul>"
}

/// Each in an element of its own, so that only those that are looked at are unpacked.
fn picture_elements(places: &Places) -> String {
    let mut text = String::new();
    for (index, picture) in places.pictures.iter().enumerate() {
        let _ = writeln!(
            text,
            "<script type=\"text/plain\" id=\"picture-{index}\">{}</script>",
            STANDARD.encode(picture)
        );
    }
    text
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            _ => escaped.push(character),
        }
    }
    escaped
}
