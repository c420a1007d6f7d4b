//! `rayframe accept --from` a zip archive: the artefact of a build server as it is downloaded, and archives that are not to be trusted.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::DeflateEncoder;
use rawzip::path::EntryPath;
use rawzip::{CompressionMethod, ZipArchiveWriter};

use super::rendered::tested_in_ci;
use super::{Stage, collect};

/// Permissions and kind of a link.
const LINK: u32 = 0o120777;

/// A file of an archive.
#[derive(Clone)]
struct Entry {
    name: String,
    bytes: Vec<u8>,
    mode: Option<u32>,
    is_encrypted: bool,
}

impl Entry {
    fn new(name: &str, bytes: &[u8]) -> Self {
        Self { name: name.to_owned(), bytes: bytes.to_owned(), mode: None, is_encrypted: false }
    }
}

/// An archive with these files, deflated.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn zipped(entries: &[Entry]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut archive = ZipArchiveWriter::new(&mut bytes);
    for entry in entries {
        let mut file = archive.new_file(EntryPath::verbatim(entry.name.clone().into_bytes()));
        file = file.compression_method(CompressionMethod::DEFLATE).encrypted(entry.is_encrypted);
        if let Some(mode) = entry.mode {
            file = file.unix_permissions(mode);
        }
        let (mut compressed, config) = file.start().unwrap();
        let mut data = config.wrap(DeflateEncoder::new(&mut compressed, Compression::default()));
        data.write_all(&entry.bytes).unwrap();
        let (encoder, descriptor) = data.finish().unwrap();
        encoder.finish().unwrap();
        compressed.finish(descriptor).unwrap();
    }
    archive.finish().unwrap();
    bytes
}

/// The files of the folder `artefact`, below `prefix`.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn artefact(stage: &Stage, prefix: &str) -> Vec<Entry> {
    let mut names = Vec::new();
    collect(&stage.path("artefact"), "", &mut names);
    names.sort();
    let read = |name: &String| std::fs::read(stage.path("artefact").join(name)).unwrap();
    names.iter().map(|name| Entry::new(&format!("{prefix}{name}"), &read(name))).collect()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn write(stage: &Stage, bytes: &[u8]) {
    std::fs::write(stage.path("artefact.zip"), bytes).unwrap();
}

/// The archive of the artefact, in which `change` changed something, is refused with this code and word, and nothing is accepted.
#[track_caller]
fn refused(stage: &Stage, code: i32, word: &str, change: impl FnOnce(&mut Vec<Entry>)) {
    let mut entries = artefact(stage, "");
    change(&mut entries);
    write(stage, &zipped(&entries));
    refused_as_it_is(stage, code, word);
}

#[track_caller]
fn refused_as_it_is(stage: &Stage, code: i32, word: &str) {
    let references = stage.references();
    let ran = stage.run(&["accept", "--from", "artefact.zip"]);
    ran.ends(code, &["artefact.zip", word]);
    assert_eq!(ran.text.lines().count(), 1, "{}", ran.text);
    assert_eq!(stage.references(), references);
}

/// The archive in which a file has other bytes is refused.
#[track_caller]
fn replaced(stage: &Stage, name: &str, bytes: &[u8], (code, word): (i32, &str)) {
    refused(stage, code, word, |entries| {
        for entry in entries.iter_mut().filter(|entry| entry.name == name) {
            entry.bytes = bytes.to_vec();
        }
    });
}

#[test]
fn an_archive_has_the_report_at_its_top_or_in_a_folder() {
    let stage = tested_in_ci();
    write(&stage, &zipped(&artefact(&stage, "")));
    let from = |words: &[&str]| stage.run(&[&["accept", "--from", "artefact.zip"], words].concat());
    from(&["spot"]).ends(0, &["replaced references/spot.exr"]);
    // Beside the report a file browser's own files.
    let mut entries = artefact(&stage, "rayframe-report/");
    entries.push(Entry::new("__MACOSX/rayframe-report/._images.json", b"x"));
    write(&stage, &zipped(&entries));
    from(&[]).ends(0, &["added references/new.exr", "removed references/sun.exr"]);
    from(&["--changed"]).ends(0, &["replaced references/a/point.exr"]);
    from(&[]).ends(0, &["all images are references already"]);
    assert_eq!(stage.references(), ["a/point.exr", "new.exr", "spot.exr"]);
    stage.run(&["test"]).ends(0, &["3 images identical, 0 changed within limits, 0 failed"]);
    assert!(!stage.path("rayframe-report").exists() && !stage.path("images").exists());
}

#[test]
fn archives_without_one_report_are_refused() {
    let stage = tested_in_ci();
    refused(&stage, 66, "the archive has no images.json", |entries| {
        entries.retain(|entry| entry.name != "images.json");
    });
    refused(&stage, 66, "images/spot.exr", |entries| entries.retain(|entry| entry.name != "images/spot.exr"));
    refused(&stage, 66, "the archive has no images.json", |entries| {
        for entry in entries {
            entry.name.insert_str(0, "a/b/");
        }
    });
    refused(&stage, 65, "the archive has several reports, such as a and b", |entries| {
        let twice = entries.clone();
        for entry in &mut *entries {
            entry.name.insert_str(0, "a/");
        }
        entries.extend(twice.into_iter().map(|entry| Entry { name: format!("b/{}", entry.name), ..entry }));
    });
}

#[test]
fn hostile_archives_are_refused() {
    let stage = tested_in_ci();
    for name in ["../spot.exr", "/etc/passwd", "a/../../b", "..\\spot.exr", ""] {
        refused(&stage, 77, "leaves the archive", |entries| entries.push(Entry::new(name, b"x")));
    }
    refused(&stage, 77, "\"images/link.exr\" is a link", |entries| {
        entries.push(Entry { mode: Some(LINK), ..Entry::new("images/link.exr", b"/etc/passwd") });
    });
    refused(&stage, 65, "two files of the name \"images/spot.exr\"", |entries| {
        entries.push(Entry::new("images/spot.exr", b"x"));
    });
    refused(&stage, 65, "is encrypted", |entries| entries[0].is_encrypted = true);
    replaced(&stage, "images.json", &[], (65, "is not a list of rendered images"));
    // A thousand bytes are one of the archive.
    replaced(
        &stage,
        "images/spot.exr",
        &vec![0; 8 << 20],
        (77, "images/spot.exr: the file has 1025 KiB and a reference at most 1024"),
    );
    replaced(&stage, "images.json", &vec![b' '; 66 << 20], (77, "images.json: has more than 65536 KiB"));
}

#[test]
fn damaged_archives_are_refused() {
    let stage = tested_in_ci();
    let whole = zipped(&artefact(&stage, ""));
    for length in [0, 10, whole.len() / 2, whole.len() - 30, whole.len() - 1] {
        write(&stage, &whole[..length]);
        refused_as_it_is(&stage, 65, "is no whole zip archive");
    }
    // A byte of each fiftieth: the archive is refused, or a file that is not needed differs.
    let references = stage.references();
    for at in (0..whole.len()).step_by(whole.len() / 50) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x55;
        write(&stage, &damaged);
        let ran = stage.run(&["accept", "--from", "artefact.zip", "spot"]);
        assert!(matches!(ran.code, Some(0 | 1 | 65 | 66 | 77)), "{at}: {}", ran.text);
        if ran.code == Some(0) {
            let [accepted, rendered] = ["references/spot.exr", "artefact/images/spot.exr"];
            let [accepted, rendered] =
                [accepted, rendered].map(|path| std::fs::read(stage.path(path)).unwrap());
            assert!(accepted == rendered, "{at}");
        }
        assert_eq!(stage.references(), references);
    }
}
