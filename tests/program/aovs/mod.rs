//! AOV files: names, channels and attributes, refusals, and resumed frames.

mod shutter;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use exr::meta::attribute::AttributeValue;
use exr::meta::header::Header;

use crate::names;

/// A few spheres over a floor.
const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/material/mirror.gltf");

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render_scene(scene: &Path, folder: &Path, options: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .arg("render")
        .arg(scene)
        .args(["-r", "24x16", "-f", "3", "--samples", "1", "-q"])
        .args(options.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap()
}

fn render(folder: &Path, options: &str) -> Output {
    render_scene(SCENE.as_ref(), folder, options)
}

fn rendered(folder: &Path, options: &str) {
    let output = render(folder, options);
    assert_eq!(output.status.code(), Some(0), "{options}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Asserts a usage error with `word` before any file is written.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn assert_refused(options: &str, word: &str) {
    let folder = tempfile::tempdir().unwrap();
    let output = render(folder.path(), options);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{options}: {message}");
    assert!(message.contains(word) && message.lines().count() == 1, "{options}: {message}");
    assert!(names(folder.path()).is_empty(), "{options}");
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn header(path: &Path) -> Header {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    exr::block::read(file, true).unwrap().headers()[0].clone()
}

/// Channels with their types.
fn channels(path: &Path) -> BTreeMap<String, String> {
    let list = header(path).channels.list;
    list.iter().map(|channel| (channel.name.to_string(), format!("{:?}", channel.sample_type))).collect()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    names(folder).into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap())).collect()
}

#[test]
fn a_plain_render_has_no_aovs() {
    let folder = tempfile::tempdir().unwrap();
    rendered(folder.path(), "-o a.####.exr");
    let path = folder.path().join("a.0003.exr");
    assert_eq!(
        channels(&path).into_iter().collect::<Vec<_>>(),
        ["A", "B", "G", "R"].map(|c| (c.to_owned(), "F16".to_owned()))
    );
    let header = header(&path);
    assert_eq!(header.compression, exr::compression::Compression::ZIP16);
    let code = header.shared_attributes.time_code.unwrap();
    assert_eq!((code.hours, code.minutes, code.seconds, code.frame), (0, 0, 0, 3));
    let own = header.own_attributes;
    assert!(own.capture_date.is_none() && own.owner.is_none());
    let names: Vec<_> = own.other.keys().map(ToString::to_string).collect();
    assert!(
        names
            .iter()
            .all(|name| ["frame", "timeSeconds", "renderHash", "sceneParts", "checksum"]
                .contains(&name.as_str())),
        "{names:?}"
    );
}

#[test]
fn all_aovs_fit_in_one_file_of_either_pixel_type() {
    let folder = tempfile::tempdir().unwrap();
    rendered(folder.path(), "-o a.exr --layers all");
    rendered(folder.path(), "-o b.exr --layers light,depth --exr piz,float --fps 23.976");
    let all = channels(&folder.path().join("a.exr"));
    // RGBA 4, 6 light passes and 4 data AOVs of 3 each, depth 1, uv 2, ids 3, motion 4, two mattes of 12 each.
    assert_eq!(all.len(), 4 + 6 * 3 + 4 * 3 + 1 + 2 + 3 + 4 + 24);
    for (name, expected) in
        [("R", "F16"), ("direct.G", "F16"), ("Z", "F32"), ("albedo.R", "F32"), ("node_id", "U32")]
    {
        assert_eq!(all[name], expected, "{name}");
    }
    let own = header(&folder.path().join("a.exr")).own_attributes;
    let mattes = own.other.keys().filter(|name| name.to_string().starts_with("cryptomatte/")).count();
    assert_eq!(mattes, 8);

    let some = header(&folder.path().join("b.exr"));
    assert_eq!(some.channels.list.len(), 4 + 6 * 3 + 1);
    assert!(channels(&folder.path().join("b.exr")).values().all(|kind| kind == "F32"));
    assert_eq!(some.compression, exr::compression::Compression::PIZ);
    assert!(some.shared_attributes.time_code.is_none());
}

#[test]
fn aovs_that_cannot_be_stored_are_refused_before_the_first_frame() {
    assert_refused("-o a.exr --layers depth --exr dwaa", "--split-aovs");
    assert_refused("-o a.exr --layers crypto --exr float,dwab", "crypto_object");
    assert_refused("-o a.exr --layers all --exr dwaa,half", "depth");
    assert_refused("-o a.png --layers depth", "end it with .exr");
    assert_refused("-o a.png --stamp", "end it with .exr");
    assert_refused("-o {layer}.exr --layers depth", "--split-aovs");
    assert_refused("-o a.exr --layers depth --split-aovs --stats a.depth.exr", "a.depth.exr");
    assert_refused("-o a.exr --layers node_ids", "did you mean \"node_id\"?");
}

#[test]
fn light_passes_may_have_lossy_compression() {
    let folder = tempfile::tempdir().unwrap();
    rendered(folder.path(), "-o a.exr --layers light --exr dwaa");
    assert!(matches!(
        header(&folder.path().join("a.exr")).compression,
        exr::compression::Compression::DWAA(_)
    ));
}

#[test]
fn split_aovs_have_files_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    rendered(
        folder.path(),
        "-o out/a_####.exr --layers depth,direct,crypto_material --split-aovs --exr dwab --preview png",
    );
    let out = folder.path().join("out");
    let expected =
        ["a_0003.exr", "a_0003.png", "a_crypto_material_0003.exr", "a_depth_0003.exr", "a_direct_0003.exr"];
    assert_eq!(names(&out), expected);
    let compression = |name: &str| header(&out.join(name)).compression;
    for (name, is_lossy) in [(0, true), (2, false), (3, false), (4, true)] {
        assert_eq!(compression(expected[name]).may_loose_data(), is_lossy, "{}", expected[name]);
    }
    assert_eq!(channels(&out.join("a_depth_0003.exr")).into_keys().collect::<Vec<_>>(), ["Z"]);
    rendered(folder.path(), "-o {layer}/b.####.exr --layers uv --split-aovs");
    assert_eq!(names(&folder.path().join("uv")), ["b.0003.exr"]);
    assert_eq!(names(&folder.path().join("beauty")), ["b.0003.exr"]);
}

#[test]
fn a_frame_is_finished_when_all_its_files_are() {
    let folder = tempfile::tempdir().unwrap();
    let options = "-o a.####.exr --layers depth,uv --split-aovs --preview png";
    rendered(folder.path(), options);
    let whole = files(folder.path());

    // One file is missing, truncated, or of another frame.
    let uv = folder.path().join("a.uv.0003.exr");
    std::fs::remove_file(&uv).unwrap();
    rendered(folder.path(), options);
    assert!(files(folder.path()) == whole);
    std::fs::write(&uv, &whole["a.uv.0003.exr"][..300]).unwrap();
    let refused = render(folder.path(), options);
    assert_eq!(refused.status.code(), Some(73));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("a.uv.0003.exr"));
    rendered(folder.path(), &format!("{options} --resume"));
    assert!(files(folder.path()) == whole);

    // All files exist: a dry run keeps the frame. With other AOVs it is another frame.
    let dry = render(folder.path(), &format!("{options} --dry-run"));
    assert!(String::from_utf8_lossy(&dry.stdout).contains(" keep "));
    for other in [
        "-o a.####.exr --layers depth",
        "-o a.####.exr --layers depth,uv --split-aovs --exr piz",
        "-o a.####.exr --layers depth,uv --split-aovs --exr float",
    ] {
        assert_eq!(render(folder.path(), other).status.code(), Some(73), "{other}");
    }
}

#[test]
fn equal_runs_write_equal_files_except_for_stamps() {
    let folders: [_; 2] = std::array::from_fn(|_| tempfile::tempdir().unwrap());
    for (folder, threads) in folders.iter().zip([1, 4]) {
        rendered(folder.path(), &format!("-o a.exr --layers all --threads {threads}"));
        rendered(folder.path(), &format!("-o b.exr --layers all --split-aovs --threads {threads}"));
    }
    assert!(files(folders[0].path()) == files(folders[1].path()));

    let folder = &folders[0];
    rendered(folder.path(), "-o c.exr --stamp --layers depth --split-aovs");
    for name in ["c.exr", "c.depth.exr"] {
        let own = header(&folder.path().join(name)).own_attributes;
        assert!(own.capture_date.is_some() && own.utc_offset == Some(0.0), "{name}");
        let seconds = own.other.iter().find(|(name, _)| **name == *"renderSeconds");
        assert!(matches!(seconds, Some((_, AttributeValue::F32(seconds))) if *seconds > 0.0));
    }
    // A stamp does not change the identity of a frame.
    let dry = render(folder.path(), "-o c.exr --layers depth --split-aovs --dry-run");
    assert!(String::from_utf8_lossy(&dry.stdout).contains(" keep "));
}

#[test]
fn names_with_equal_matte_hashes_are_warned_about() {
    let folder = tempfile::tempdir().unwrap();
    let scene: PathBuf = folder.path().join("two.gltf");
    // Both names have the hash 0x30cf5f63.
    let document = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"name":"x"}],
        "materials":[{"name":"n40665"},{"name":"n93112"}]}"#;
    std::fs::write(&scene, document).unwrap();
    let output = render_scene(&scene, folder.path(), "-o a.exr --layers crypto");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert!(message.contains("n40665") && message.contains("n93112"), "{message}");
    let strict = render_scene(&scene, folder.path(), "-o b.exr --layers crypto --strict");
    assert_eq!(strict.status.code(), Some(65));
    let without = render_scene(&scene, folder.path(), "-o c.exr --strict");
    assert_eq!(without.status.code(), Some(0), "{}", String::from_utf8_lossy(&without.stderr));
}
