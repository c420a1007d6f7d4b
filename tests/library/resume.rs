//! What resuming replaces: damaged frames of this program, no file of another one, and previews that are not whole.

use rayframe::color::ToneCurve;
use rayframe::sequence::{ExistingFiles, Exposure, Plan};

use crate::sequence::{job, render};

/// Beginning of an EXR file with deep pixels, which this program does not read.
const DEEP: &[u8] = b"\x76\x2f\x31\x01\x02\x08\0\0name\0string\0\x04\0\0\0deep";

/// Bytes of an image of another program.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn foreign_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let writer = png::Encoder::new(&mut bytes, 1, 1).write_header();
    writer.unwrap().write_image_data(&[7]).unwrap();
    bytes
}

/// A file whose header says that its pixels are in tiles; by the version's bit alone, or as tiled files do.
fn with_tiles(file: &[u8], has_attribute: bool) -> Vec<u8> {
    let mut tiled = file.to_vec();
    tiled[5] |= 2;
    if has_attribute {
        let tiles = b"tiles\0tiledesc\0\x09\0\0\0\x40\0\0\0\x40\0\0\0\0";
        tiled.splice(8..8, tiles.iter().copied());
    }
    tiled
}

#[test]
fn resuming_replaces_damaged_frames_of_this_program_alone() {
    let folder = tempfile::tempdir().unwrap();
    let rendered = |name: &str| {
        render(&job(folder.path(), name, &[0])).unwrap();
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let (exr, png, foreign) = (rendered("own.exr"), rendered("own.png"), foreign_png());
    // A long manifest may be between the marks of the header, and a changed bit in one of them.
    let [no_checksum, no_hash] = [&b"checksum\0"[..], b"renderHash\0"].map(|name| {
        let mut damaged = exr.clone();
        let at = damaged.windows(name.len()).position(|part| part == name).unwrap();
        damaged[at] ^= 1;
        damaged
    });
    // Another program saves the frame with all attributes but its own name; or a bit of that has changed.
    let [saved, renamed] = [&b"OpenImag"[..], b"rayfrale"].map(|name| {
        let mut saved = exr.clone();
        let attribute = b"software\0string\0";
        let at = saved.windows(attribute.len()).position(|part| part == attribute).unwrap();
        saved[at] = if name == b"OpenImag" { b'S' } else { b's' };
        let value = at + attribute.len() + 4;
        saved[value..value + name.len()].copy_from_slice(name);
        saved
    });
    // The same in tiles, with its name and without one: the bit and the attribute, or a changed bit alone.
    let [tiled, unnamed_tiles, changed_bit] =
        [(&saved, true), (&exr, true), (&exr, false)].map(|(file, has_tiles)| with_tiles(file, has_tiles));
    let cases: [(&str, &[u8], bool); 18] = [
        ("a.exr", &saved, false),
        ("a.exr", &tiled, false),
        ("a.exr", &unnamed_tiles, false),
        ("a.exr", &changed_bit, true),
        ("a.exr", &renamed, true),
        ("a.exr", &exr[..exr.len() / 2], true),
        ("a.exr", &[&exr[..], b"\n"].concat(), true),
        ("a.exr", &no_checksum, true),
        ("a.exr", &no_hash, true),
        ("a.exr", &[0; 5000], true),
        ("a.exr", DEEP, false),
        ("a.exr", &foreign, false),
        ("a.exr", b"\0\0\0\0notes", false),
        ("a.png", &png[..png.len() / 2], true),
        ("a.png", &[&png[..], b"\n"].concat(), true),
        ("a.png", &[0; 5000], true),
        ("a.png", &[&foreign[..], b"\n"].concat(), false),
        ("a.png", &exr[..exr.len() / 2], false),
    ];
    for (index, (name, content, is_replaced)) in cases.into_iter().enumerate() {
        let mut job = job(folder.path(), name, &[0]);
        job.existing = ExistingFiles::Resume;
        std::fs::write(folder.path().join(name), content).unwrap();
        match Plan::new(&job) {
            Ok(plan) => assert!(is_replaced && plan.replaced.len() == 1, "case {index}"),
            Err(error) => assert!(!is_replaced && error.exit_code() == 73, "case {index}: {error}"),
        }
    }
}

#[test]
fn whole_previews_of_kept_frames_are_left_and_others_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "a.##.exr", &[0, 1, 2]);
    job.preview = true;
    job.existing = ExistingFiles::Resume;
    job.exposure = Exposure::Ev(0.0);
    assert_eq!(render(&job).unwrap().previews, 0);
    let path = |frame: i64| folder.path().join(format!("a.{frame:02}.png"));
    let bytes = |frame| std::fs::read(path(frame)).unwrap();
    let time = |frame| std::fs::metadata(path(frame)).unwrap().modified().unwrap();
    let (first, times) = ([0, 1, 2].map(bytes), [0, 1, 2].map(time));
    assert_eq!(render(&job).unwrap().previews, 0);
    assert_eq!([0, 1, 2].map(time), times);
    // One is missing, one is cut short.
    std::fs::remove_file(path(0)).unwrap();
    std::fs::write(path(1), &first[1][..first[1].len() - 5]).unwrap();
    let summary = render(&job).unwrap();
    assert_eq!((summary.previews, summary.kept.len()), (2, 3));
    assert!([0, 1, 2].map(bytes) == first && time(2) == times[2]);
    // Another tone mapping, and with it another exposure or background.
    job.exposure = Exposure::Ev(1.0);
    assert_eq!(render(&job).unwrap().previews, 3);
    assert!((0..3).all(|frame| bytes(frame) != first[frame as usize]));
    job.tone = ToneCurve::Aces;
    assert_eq!([render(&job).unwrap().previews, render(&job).unwrap().previews], [3, 0]);
    job.display_background = Some([1, 2, 3]);
    assert_eq!([render(&job).unwrap().previews, render(&job).unwrap().previews], [3, 0]);
}
