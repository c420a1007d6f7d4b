//! The text of the page: a template filled with data, images and script. Names from outside are escaped for their context.

use std::fmt::Write as _;

use base64::{Engine as _, engine::general_purpose::STANDARD};
use sha2::{Digest as _, Sha256};

use super::data::PageData;
use super::page::{AssetChanges, ChangeGroup, ChangeRow, FolderSummary, ReportPage};
use super::page_images::PageImages;
use crate::error::{Error, Result};
use crate::regression::{Verdict, VerdictCounts};

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = concat!(
    include_str!("page/page.css"),
    include_str!("page/viewer.css"),
    include_str!("page/changes.css"),
);
/// All scripts in one function, so that none of their names are global.
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
    include_str!("page/thumbnails.js"),
    include_str!("page/list.js"),
    include_str!("page/changes.js"),
    include_str!("page/details.js"),
    include_str!("page/keys.js"),
    include_str!("page/tools.js"),
    include_str!("page/page.js"),
    "})();\n",
);

/// The text of `page`, with images up to `budget_bytes`.
pub(super) fn html(page: &ReportPage, budget_bytes: usize) -> Result<String> {
    html_of([PAGE, STYLE, SCRIPT], page, budget_bytes)
}

fn html_of(sources: [&str; 3], page: &ReportPage, budget_bytes: usize) -> Result<String> {
    // Browsers remove carriage returns before they hash; a checkout may have added some.
    let [template, style, script] = sources.map(|source| source.replace('\r', ""));
    let images = PageImages::new(page, budget_bytes);
    let json = serde_json::to_string(&PageData::new(page, &images, budget_bytes))
        .map_err(|error| Error::Internal { message: error.to_string() })?;
    // In a script element, only `<` can end the element or begin a comment. In JSON it occurs in strings only.
    let json = json.replace('<', "\\u003c");
    let others = template.len() + style.len() + script.len() + json.len();
    let mut text = String::with_capacity(others + images.text_bytes() + 65536);
    fill(&mut text, &template, |text, name| match name {
        "policy" => text.push_str(&policy(&script, &style)),
        "title" => text.push_str(&escaped(&page.title)),
        "style" => text.push_str(&style),
        "list" => plain_list(text, page),
        "data" => text.push_str(&json),
        "images" => image_elements(text, &images),
        "script" => text.push_str(&script),
        _ => {}
    });
    Ok(text)
}

/// Replaces each name in double braces by its part. Parts are not searched for further names.
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

/// The Content Security Policy: loads nothing, runs this script only.
fn policy(script: &str, style: &str) -> String {
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text.as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{}'; style-src 'sha256-{}'; img-src data: blob:; base-uri 'none'; \
         form-action 'none'",
        hash(script),
        hash(style)
    )
}

/// The changes of an asset, and the lists of failures and changes, for browsers without JavaScript.
fn plain_list(text: &mut String, page: &ReportPage) {
    if let Some(asset) = &page.asset {
        plain_changes(text, asset);
    }
    let sum = |count: fn(&FolderSummary) -> usize| page.folders.iter().map(count).sum();
    let counts = VerdictCounts {
        identical: sum(|folder| folder.counts.identical),
        changed: sum(|folder| folder.counts.changed),
        failed: sum(|folder| folder.counts.failed),
    };
    let _ = write!(text, "<p>{counts}.</p>");
    for (verdict, title) in [(Verdict::Failed, "Failed"), (Verdict::Changed, "Changed within limits")] {
        let frames = page.shots.iter().flat_map(|shot| &shot.frames);
        let mut frames = frames.filter(|frame| frame.verdict() == verdict).peekable();
        if frames.peek().is_none() {
            continue;
        }
        let _ = write!(text, "\n<h2>{title}</h2>\n<ul>");
        for frame in frames {
            let _ = write!(text, "\n<li>{}: {}", escaped(&frame.name), frame.kind());
            for message in &frame.messages {
                let _ = write!(text, "<br>{}", escaped(message));
            }
            text.push_str("</li>");
        }
        text.push_str("\n</ul>");
    }
}

fn plain_changes(text: &mut String, asset: &AssetChanges) {
    text.push_str("<ul>");
    for loss in &asset.losses {
        let _ = write!(text, "\n<li>{}</li>", escaped(loss));
    }
    for ChangeGroup { title, rows } in &asset.groups {
        let _ = write!(text, "\n<li>{}:", escaped(title));
        for ChangeRow { mark, name, property, values } in rows {
            let _ = write!(text, "<br>{mark} {} {} {}", escaped(name), escaped(property), escaped(values));
        }
        text.push_str("</li>");
    }
    text.push_str("\n</ul>\n");
}

/// Writes each image as an element of its own, so that the script unpacks only those that are shown.
fn image_elements(text: &mut String, images: &PageImages<'_>) {
    for (index, image) in images.packed.iter().enumerate() {
        let _ = write!(text, "<script type=\"text/plain\" id=\"image-{index}\">");
        STANDARD.encode_string(image, text);
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
