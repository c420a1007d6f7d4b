//! What a page holds, and what cannot happen to it.

use std::collections::BTreeMap;

use super::super::encoded_image::tests::unpacked;
use super::super::encoded_image::{pack_errors, text_bytes};
use super::super::{
    EncodedImage, FolderSummary, FrameCommands, FrameStatus, IMAGE_BUDGET_BYTES, ReportedFrame, ReportedShot,
};
use super::*;
use crate::regression::{ColorEncoding, Image, Preset, compare};

const SIZE: (u32, u32) = (24, 16);
const NASTY: &str = "</script><!--<script>alert('1')&\"\u{2028}";

fn picture(value: f32) -> Image {
    let pixel = |at: u32| [value, (at % 7) as f32 * 0.1, value * 2.0, 1.0];
    let pixels: Vec<_> = (0..SIZE.0 * SIZE.1).map(pixel).collect();
    Image::from_rgba(SIZE, ColorEncoding::Linear, &pixels)
}

fn frame(name: &str, frame: i64, value: f32) -> ReportedFrame {
    let (actual, expected) = (picture(value), picture(0.25));
    let comparison = compare(&actual, &expected, &Preset::Visual.limits());
    ReportedFrame {
        name: name.to_owned(),
        frame: Some(frame),
        status: FrameStatus::Different,
        messages: comparison.failures(),
        comparison: Some(comparison),
        expected: EncodedImage::new(&expected),
        actual: EncodedImage::new(&actual),
        actual_hash: Some("ab".repeat(32)),
    }
}

fn page(name: &str) -> ReportPage {
    let shot = ReportedShot {
        name: name.to_owned(),
        preset: "visual".to_owned(),
        limits: Preset::Visual.limits(),
        frames: vec![frame(name, 1, 0.5), frame(&format!("{name}2"), 2, 0.9)],
        commands: vec![(name.to_owned(), format!("rayframe diff '{name}'"))],
    };
    ReportPage {
        title: name.to_owned(),
        command: "rayframe test".to_owned(),
        folders: vec![FolderSummary { failed: 2, passed: 3, ..FolderSummary::default() }],
        shots: vec![shot],
        accept_command: String::new(),
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
fn names_cannot_leave_their_place() {
    let text = html(&page(NASTY), IMAGE_BUDGET_BYTES).unwrap();
    // The data, four pictures, two maps and the script.
    assert_eq!(text.matches("<script").count(), 8);
    assert_eq!(text.matches("</script>").count(), 8);
    assert!(!text.contains("<!--") && !text.contains("alert('1')&\""));
    let data = data(&text);
    assert_eq!((&data["title"], &data["shots"][0]["name"]), (&NASTY.into(), &NASTY.into()));
    assert_eq!(data["shots"][0]["commands"][0][0], NASTY);
}

#[test]
fn equal_data_give_equal_bytes_and_ask_no_network() {
    let text = html(&page("light/point"), IMAGE_BUDGET_BYTES).unwrap();
    assert_eq!(text, html(&page("light/point"), IMAGE_BUDGET_BYTES).unwrap());
    let of_windows = [PAGE, STYLE, SCRIPT].map(|source| source.replace('\n', "\r\n"));
    let sources = of_windows.each_ref().map(String::as_str);
    assert_eq!(text, html_of(sources, &page("light/point"), IMAGE_BUDGET_BYTES).unwrap());
    for asks in ["http:", "https:", "src=", "@import", "url("] {
        // The name space of SVG is a name.
        assert!(!text.replace("http://www.w3.org/2000/svg", "").contains(asks), "{asks}");
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
fn pictures_come_back_from_the_page() {
    let text = html(&page("light/point"), IMAGE_BUDGET_BYTES).unwrap();
    let shown = &data(&text)["shots"][0]["frames"][1]["actual"];
    assert_eq!((&shown["width"], &shown["is_light"]), (&24.into(), &true.into()));
    let id = format!("id=\"picture-{}\">", shown["picture"]);
    let packed = STANDARD.decode(between(&text, &id, "</script>")).unwrap();
    let half = |value: f32| half::f16::from_f32(value).to_bits();
    let pixels = unpacked(&packed, 24);
    assert_eq!((pixels.len(), pixels[30]), (384, [half(0.9), half(2.0 * 0.1), half(1.8)]));
}

#[test]
fn what_has_no_room_is_left_out_and_told() {
    let page = page("light/point");
    let bytes: usize = PageImages::new(&page, usize::MAX).pictures.iter().map(|part| part.len()).sum();
    // Room for one of the two frames: the second is the worse one.
    let text = html(&page, bytes).unwrap();
    let all = data(&text);
    let frames = &all["shots"][0]["frames"];
    assert_eq!(frames[0]["left_out"], serde_json::json!({"why": "no_room", "command": null}));
    assert!(frames[1]["left_out"].is_null());
    assert!(frames[0]["actual"].is_null() && frames[0]["expected"].is_null());
    assert_eq!((&all["left_out"], text.matches("id=\"picture-").count()), (&1.into(), 3));
    let none = data(&html(&page, 10).unwrap());
    assert_eq!(none["left_out"], 2);
    // A picture that waited without its pixels is one that is left out.
    let mut waiting = page;
    let waits = &mut waiting.shots[0].frames[1].actual;
    *waits = waits.take().map(EncodedImage::left_out);
    assert_eq!(
        data(&html(&waiting, usize::MAX).unwrap())["shots"][0]["frames"][1]["left_out"]["why"],
        "no_room"
    );
}

#[test]
fn a_frame_without_room_tells_what_shows_it() {
    let mut page = page("light/point");
    let room = page.shots[0].frames.iter().map(|frame| {
        let pictures = [&frame.expected, &frame.actual].into_iter().flatten();
        let colors: usize = pictures.map(EncodedImage::size_bytes).sum();
        let map = frame.comparison.as_ref().and_then(|comparison| comparison.flip_map.as_ref()).unwrap();
        colors + text_bytes(pack_errors(map).len())
    });
    let room = room.max().unwrap();
    let commands = FrameCommands { alone: Some("alone".to_owned()), heat_map: Some("map".to_owned()) };
    page.frame_commands.insert("light/point".to_owned(), commands);
    let left_out = |page: &ReportPage, budget_bytes| {
        data(&html(page, budget_bytes).unwrap())["shots"][0]["frames"][0]["left_out"].clone()
    };
    let (alone, map) = (
        serde_json::json!({"why": "no_room", "command": "alone"}),
        serde_json::json!({"why": "too_large", "command": "map"}),
    );
    // The second frame is worse; the page has room for either.
    assert_eq!(left_out(&page, room), alone);
    assert_eq!(left_out(&page, room / 2), map);
    assert!(left_out(&page, 2 * room).is_null());
    // A picture whose pixels are gone keeps its size.
    let waits = &mut page.shots[0].frames[0].actual;
    *waits = waits.take().map(EncodedImage::left_out).map(EncodedImage::left_out);
    assert_eq!(left_out(&page, 2 * room), alone);
    assert_eq!(left_out(&page, room / 2), map);
}

#[test]
fn there_are_tick_boxes_where_a_command_takes_approvals() {
    for command in ["rayframe accept --approvals approvals.json --suite 'my scenes'", ""] {
        let page = ReportPage { accept_command: command.to_owned(), ..page("light/point") };
        let told = data(&html(&page, IMAGE_BUDGET_BYTES).unwrap());
        assert_eq!(told["accept_command"], command);
        assert_eq!(told["can_approve"], !command.is_empty());
    }
}

#[test]
fn the_frame_that_is_shown_first_has_room_first() {
    let mut page = page("light/point");
    let frames = &mut page.shots[0].frames;
    frames.insert(0, ReportedFrame { comparison: None, ..frames[0].clone() });
    frames.insert(1, ReportedFrame { status: FrameStatus::Passed, ..frames[2].clone() });
    frames[3].comparison.as_mut().unwrap().flip_map = None;
    let room = |frame: &ReportedFrame| {
        [&frame.expected, &frame.actual].into_iter().flatten().map(EncodedImage::size_bytes).sum()
    };
    let all = data(&html(&page, room(&page.shots[0].frames[3])).unwrap());
    let shot = &all["shots"][0];
    assert_eq!(shot["worst"], 3);
    let shown: Vec<bool> =
        shot["frames"].as_array().unwrap().iter().map(|frame| frame["actual"].is_object()).collect();
    assert_eq!(shown, [false, false, false, true]);
    // Without any number it is the first failure.
    page.shots[0].frames.truncate(2);
    page.shots[0].frames.reverse();
    assert_eq!(data(&html(&page, 0).unwrap())["shots"][0]["worst"], 1);
}

#[test]
fn without_scripts_failures_are_listed() {
    let text = html(&page("a<b"), IMAGE_BUDGET_BYTES).unwrap();
    let plain = between(&text, "<noscript>", "</noscript>");
    assert!(
        plain.contains("<p>2 failed, 3 passed.</p>")
            && plain.contains("<li>a&lt;b2: different<br>mean FLIP: 0.")
    );
}
