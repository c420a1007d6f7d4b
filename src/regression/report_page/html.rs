//! The text of the page. Parts come from files of this room; what others named is escaped by where it goes.

use std::fmt::Write as _;

use base64::{Engine as _, engine::general_purpose::STANDARD};
use sha2::{Digest as _, Sha256};

use super::data::{PageData, status};
use super::page_images::PageImages;
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
    include_str!("page/tools.js"),
    include_str!("page/page.js"),
    "})();\n",
);

/// The page.
pub(super) fn html(page: &ReportPage, budget_bytes: usize) -> Result<String> {
    html_of([PAGE, STYLE, SCRIPT], page, budget_bytes)
}

fn html_of(sources: [&str; 3], page: &ReportPage, budget_bytes: usize) -> Result<String> {
    // Browsers hash what they have read, without carriage returns, which a checkout may have added.
    let [template, style, script] = sources.map(|source| source.replace('\r', ""));
    let places = PageImages::new(page, budget_bytes);
    let json = serde_json::to_string(&PageData::new(page, &places, budget_bytes))
        .map_err(|error| Error::Internal { message: error.to_string() })?;
    // Within a script element only `<` could end it or begin a comment; in JSON it stands in texts alone.
    let json = json.replace('<', "\\u003c");
    let others = template.len() + style.len() + script.len() + json.len();
    let mut text = String::with_capacity(others + places.text_bytes() + 65536);
    fill(&mut text, &template, |text, name| match name {
        "policy" => text.push_str(&policy(&script, &style)),
        "title" => text.push_str(&escaped(&page.title)),
        "style" => text.push_str(&style),
        "list" => plain_list(text, page),
        "data" => text.push_str(&json),
        "pictures" => picture_elements(text, &places),
        "script" => text.push_str(&script),
        _ => {}
    });
    Ok(text)
}

/// Writes each part where the template has its name in double braces. Parts are not looked into.
fn fill(text: &mut String, template: &str, write_part: impl Fn(&mut String, &str)) {
    let mut rest = template;
    while let Some((before, (name, after))) =
        rest.split_once("{{").and_then(|(before, rest)| Some((before, rest.split_once("}}")?)))
    {
        text.push_str(before);
        write_part(text, name);
        rest = after;
    }
    text.push_str(rest);
}

/// Nothing may be loaded, and nothing may run but this script.
fn policy(script: &str, style: &str) -> String {
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text.as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{}'; style-src 'sha256-{}'; img-src data: blob:; base-uri 'none'; \
         form-action 'none'",
        hash(script),
        hash(style)
    )
}

/// The failures for somebody without scripts.
fn plain_list(text: &mut String, page: &ReportPage) {
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
    text.push_str("\n</ul>");
}

/// Each in an element of its own, so that only those that are looked at are unpacked.
fn picture_elements(text: &mut String, places: &PageImages<'_>) {
    for (index, picture) in places.pictures.iter().enumerate() {
        let _ = write!(text, "<script type=\"text/plain\" id=\"picture-{index}\">");
        STANDARD.encode_string(picture, text);
        text.push_str("</script>\n");
    }
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

#[cfg(test)]
mod tests;
