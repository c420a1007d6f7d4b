//! Tests of the page's text: its data, images, escaping and budget.

use std::collections::BTreeMap;

use super::*;
use crate::regression::encoded_image::{base64_bytes, pack_errors, unpack_colors};
use crate::regression::{
    ColorEncoding, EncodedImage, FolderSummary, FrameCommands, FrameResult, FrameStatus, IMAGE_BUDGET_BYTES,
    Image, NamedCommand, Preset, ShotResult, VerdictCounts, compare,
};

const SIZE: (u32, u32) = (24, 16);
const NASTY: &str = "</script><!--<script>alert('1')&\"\u{2028}";

fn image(value: f32) -> Image {
    let pixel = |at: u32| [value, (at % 7) as f32 * 0.1, value * 2.0, 1.0];
    let pixels: Vec<_> = (0..SIZE.0 * SIZE.1).map(pixel).collect();
    Image::from_rgba(SIZE, ColorEncoding::Linear, &pixels)
}

fn frame(name: &str, frame: i64, value: f32) -> FrameResult {
    let (actual, expected) = (image(value), image(0.25));
    let comparison = compare(&actual, &expected, &Preset::Visual.limits());
    FrameResult {
        name: name.to_owned(),
        frame: Some(frame),
        status: FrameStatus::Different,
        messages: comparison.failures(),
        comparison: Some(comparison),
        expected: EncodedImage::new(&expected),
        actual: EncodedImage::new(&actual),
        actual_hash: Some("ab".repeat(32)),
        value_hash: None,
        reference_hash: None,
    }
}

fn page(name: &str) -> ReportPage {
    let shot = ShotResult {
        name: name.to_owned(),
        path: name.into(),
        preset: "visual".to_owned(),
        limits: Preset::Visual.limits(),
        frames: vec![frame(name, 1, 0.5), frame(&format!("{name}2"), 2, 0.9)],
        warnings: Vec::new(),
        not_kept: Vec::new(),
        seconds: 0.0,
        is_cached: false,
        is_unopened: false,
    };
    let counts = VerdictCounts { identical: 3, changed: 0, failed: 2 };
    let command = NamedCommand(name.to_owned(), format!("rayframe diff '{name}'"));
    ReportPage {
        title: name.to_owned(),
        command: "rayframe test".to_owned(),
        folders: vec![FolderSummary { counts, ..FolderSummary::default() }],
        shots: vec![shot],
        asset: None,
        accept_command: String::new(),
        shot_commands: BTreeMap::from([(name.to_owned(), vec![command])]),
        frame_commands: BTreeMap::new(),
    }
}

fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    text.split_once(start).and_then(|(_, rest)| rest.split_once(end)).unwrap().0
}

fn data(text: &str) -> serde_json::Value {
    serde_json::from_str(between(text, "id=\"data\">", "</script>")).unwrap()
}

#[test]
fn names_cannot_escape_their_context() {
    let text = html(&page(NASTY), IMAGE_BUDGET_BYTES).unwrap();
    // The data, four images, two maps and the script.
    assert_eq!(text.matches("<script").count(), 8);
    assert_eq!(text.matches("</script>").count(), 8);
    assert!(!text.contains("<!--") && !text.contains("alert('1')&\""));
    let data = data(&text);
    assert_eq!((&data["title"], &data["shots"][0]["name"]), (&NASTY.into(), &NASTY.into()));
    assert_eq!(data["shots"][0]["commands"][0][0], NASTY);
}

#[test]
fn equal_data_give_equal_bytes_and_load_nothing() {
    let text = html(&page("light/point"), IMAGE_BUDGET_BYTES).unwrap();
    assert_eq!(text, html(&page("light/point"), IMAGE_BUDGET_BYTES).unwrap());
    let of_windows = [PAGE, STYLE, SCRIPT].map(|source| source.replace('\n', "\r\n"));
    let sources = of_windows.each_ref().map(String::as_str);
    assert_eq!(text, html_of(sources, &page("light/point"), IMAGE_BUDGET_BYTES).unwrap());
    for pattern in ["http:", "https:", "src=", "@import", "url("] {
        // The namespace of SVG is a name, not an address to load.
        assert!(!text.replace("http://www.w3.org/2000/svg", "").contains(pattern), "{pattern}");
    }
    for (kind, embedded) in [
        ("style", between(&text, "<style>", "</style>")),
        ("script", between(&text, "<script>", "</script>")),
    ] {
        assert!(!embedded.contains('\r'));
        let hash = STANDARD.encode(Sha256::digest(embedded.as_bytes()));
        assert!(text.contains(&format!("{kind}-src 'sha256-{hash}'")), "{kind}");
    }
}

#[test]
fn images_can_be_unpacked_from_the_page() {
    let text = html(&page("light/point"), IMAGE_BUDGET_BYTES).unwrap();
    let shown = &data(&text)["shots"][0]["frames"][1]["actual"];
    assert_eq!((&shown["width"], &shown["is_light"]), (&24.into(), &true.into()));
    let id = format!("id=\"image-{}\">", shown["index"]);
    let packed = STANDARD.decode(between(&text, &id, "</script>")).unwrap();
    let half = |value: f32| half::f16::from_f32(value).to_bits();
    let pixels = unpack_colors(&packed, SIZE).unwrap();
    assert_eq!((pixels.len(), pixels[30]), (384, [half(0.9), half(2.0 * 0.1), half(1.8)]));
}

#[test]
fn images_beyond_the_budget_are_omitted() {
    let page = page("light/point");
    let bytes: usize = PageImages::new(&page, usize::MAX).packed.iter().map(|part| part.len()).sum();
    // The budget holds one of the two frames: the second, which is worse.
    let text = html(&page, bytes).unwrap();
    let all = data(&text);
    let frames = &all["shots"][0]["frames"];
    assert_eq!(frames[0]["omitted"], serde_json::json!({"why": "no_space", "command": null}));
    assert!(frames[1]["omitted"].is_null());
    assert!(frames[0]["actual"].is_null() && frames[0]["expected"].is_null());
    assert_eq!((&all["omitted"], text.matches("id=\"image-").count()), (&1.into(), 3));
    let none = data(&html(&page, 10).unwrap());
    assert_eq!(none["omitted"], 2);
    // An image that lost its pixels while it waited is omitted.
    let mut waiting = page;
    let actual = &mut waiting.shots[0].frames[1].actual;
    *actual = actual.take().map(EncodedImage::without_pixels);
    assert_eq!(
        data(&html(&waiting, usize::MAX).unwrap())["shots"][0]["frames"][1]["omitted"]["why"],
        "no_space"
    );
}

#[test]
fn an_omitted_frame_names_a_command_that_shows_it() {
    let mut page = page("light/point");
    let budget = page.shots[0].frames.iter().map(|frame| {
        let images = [&frame.expected, &frame.actual].into_iter().flatten();
        let colors: usize = images.map(EncodedImage::size_bytes).sum();
        let map = frame.comparison.as_ref().and_then(|comparison| comparison.flip_map.as_ref()).unwrap();
        colors + base64_bytes(pack_errors(map).len())
    });
    let budget = budget.max().unwrap();
    let commands = FrameCommands { alone: Some("alone".to_owned()), heat_map: Some("map".to_owned()) };
    page.frame_commands.insert("light/point".to_owned(), commands);
    let omitted = |page: &ReportPage, budget_bytes| {
        data(&html(page, budget_bytes).unwrap())["shots"][0]["frames"][0]["omitted"].clone()
    };
    let (alone, map) = (
        serde_json::json!({"why": "no_space", "command": "alone"}),
        serde_json::json!({"why": "too_large", "command": "map"}),
    );
    // The second frame is worse; the budget holds either.
    assert_eq!(omitted(&page, budget), alone);
    assert_eq!(omitted(&page, budget / 2), map);
    assert!(omitted(&page, 2 * budget).is_null());
    // An image without pixels keeps its size.
    let actual = &mut page.shots[0].frames[0].actual;
    *actual = actual.take().map(EncodedImage::without_pixels).map(EncodedImage::without_pixels);
    assert_eq!(omitted(&page, 2 * budget), alone);
    assert_eq!(omitted(&page, budget / 2), map);
}

#[test]
fn pages_have_tick_boxes_where_approvals_can_be_accepted() {
    for command in ["rayframe accept --approvals approvals.json --suite 'my scenes'", ""] {
        let page = ReportPage { accept_command: command.to_owned(), ..page("light/point") };
        let told = data(&html(&page, IMAGE_BUDGET_BYTES).unwrap());
        assert_eq!(told["accept_command"], command);
        assert_eq!(told["can_approve"], !command.is_empty());
    }
}

#[test]
fn the_first_shown_frame_gets_its_images_first() {
    let mut page = page("light/point");
    let frames = &mut page.shots[0].frames;
    frames.insert(0, FrameResult { comparison: None, ..frames[0].clone() });
    frames.insert(1, FrameResult { status: FrameStatus::Passed, ..frames[2].clone() });
    frames[3].comparison.as_mut().unwrap().flip_map = None;
    let budget = |frame: &FrameResult| {
        [&frame.expected, &frame.actual].into_iter().flatten().map(EncodedImage::size_bytes).sum()
    };
    let all = data(&html(&page, budget(&page.shots[0].frames[3])).unwrap());
    let shot = &all["shots"][0];
    assert_eq!(shot["worst"], 3);
    let shown: Vec<bool> =
        shot["frames"].as_array().unwrap().iter().map(|frame| frame["actual"].is_object()).collect();
    assert_eq!(shown, [false, false, false, true]);
    // Without FLIP, the first failure is shown first.
    page.shots[0].frames.truncate(2);
    page.shots[0].frames.reverse();
    assert_eq!(data(&html(&page, 0).unwrap())["shots"][0]["worst"], 1);
}

#[test]
fn failures_are_listed_without_javascript() {
    let text = html(&page("a<b"), IMAGE_BUDGET_BYTES).unwrap();
    let plain = between(&text, "<noscript>", "</noscript>");
    assert!(
        plain.contains("<p>3 identical, 0 changed within limits, 2 failed.</p>")
            && plain.contains("<h2>Failed</h2>")
            && !plain.contains("<h2>Changed")
            && plain.contains("<li>a&lt;b2: different<br>mean FLIP: 0.")
    );
}
