//! Conditions that a run does not expect: inputs that change, closed streams, clocks that jump, and paths of any bytes.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io::{BufRead as _, BufReader};
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

use crate::{names, skipped, stderr};

/// A textured triangle whose buffer and image are files of their own.
const SCENE: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
    "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "extensions": {"KHR_materials_unlit": {}}}],
    "textures": [{"source": 0}], "images": [{"uri": "t.png"}], "extensionsUsed": ["KHR_materials_unlit"],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
    "buffers": [{"byteLength": 60, "uri": "b.bin"}]}"#;
/// Frames of a sequence that is still rendered when it is stopped after the first.
const FRAMES: usize = 100;
const INPUTS: [&str; 3] = ["s.gltf", "b.bin", "t.png"];

/// A folder with the scene.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn stage() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let corners: [f32; 15] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1.];
    let bytes: Vec<u8> = corners.iter().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(folder.path().join("b.bin"), bytes).unwrap();
    std::fs::write(folder.path().join("s.gltf"), SCENE).unwrap();
    image::RgbImage::from_pixel(2, 2, image::Rgb([200, 100, 50])).save(folder.path().join("t.png")).unwrap();
    folder
}

fn program(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.current_dir(folder).env_remove("CI");
    command
}

/// The command that renders many small frames into the folder `out`.
fn sequence(folder: &Path) -> Command {
    let mut command = program(folder);
    let frames = format!("0-{}", FRAMES - 1);
    command.args(["render", "s.gltf", "-r", "16x9", "--samples", "1", "-t", "1", "-f", &frames]);
    command.args(["--progress", "plain", "-o", "out/a.####.exr"]);
    command
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    names(folder).into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap())).collect()
}

/// Stops the sequence after its first frame, calls `change`, and lets it go on to its end, whose status and last lines it returns.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn changed_while_stopped(folder: &Path, change: impl Fn(&Child)) -> (ExitStatus, Vec<String>) {
    let mut child = sequence(folder).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.contains(" written ")));
    signal(&child, "-STOP");
    let count = names(&folder.join("out")).len();
    change(&child);
    signal(&child, "-CONT");
    assert!(count < FRAMES, "the run ended before the change");
    let last: Vec<String> = lines.collect();
    (child.wait().unwrap(), last)
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn inputs_that_change_during_a_run_do_not_reach_its_frames() {
    let whole = stage();
    assert!(sequence(whole.path()).output().unwrap().status.success());
    let expected = contents(&whole.path().join("out"));
    assert_eq!(expected.len(), FRAMES);
    let overwrite = |path: &Path| {
        let mut bytes = std::fs::read(path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0xff;
        std::fs::write(path, bytes).unwrap();
    };
    let truncate = |path: &Path| std::fs::File::options().write(true).open(path).unwrap().set_len(5).unwrap();
    let delete = |path: &Path| std::fs::remove_file(path).unwrap();
    let changes = [("over", overwrite as fn(&Path)), ("cut", truncate), ("gone", delete)];
    for (what, change) in changes {
        let folder = stage();
        let (status, last) = changed_while_stopped(folder.path(), |_| {
            for name in INPUTS {
                change(&folder.path().join(name));
            }
        });
        assert_eq!(status.code(), Some(0), "{:?}", last.last());
        assert!(contents(&folder.path().join("out")) == expected, "{what}");
        // The next run says what is wrong with them, and keeps the frames.
        let again = sequence(folder.path()).output().unwrap();
        let code = if what == "gone" { 66 } else { 65 };
        assert_eq!(again.status.code(), Some(code), "{what}: {}", stderr(&again));
        assert!(contents(&folder.path().join("out")) == expected, "{what}");
    }
}

#[test]
fn a_hangup_or_a_second_signal_ends_the_run_at_once() {
    let whole = stage();
    assert!(sequence(whole.path()).output().unwrap().status.success());
    let expected = contents(&whole.path().join("out"));
    // Numbers of SIGHUP, SIGTERM, and SIGINT or SIGTERM, which are delivered in any order once the process goes on.
    let ends_at_once = |signals: &[&str], numbers: &[i32]| {
        let folder = stage();
        let (status, last) = changed_while_stopped(folder.path(), |child| {
            for name in signals {
                signal(child, name);
            }
        });
        if signals == ["-HUP"] && status.success() {
            skipped("this process and its children ignore SIGHUP, as under nohup");
            return true;
        }
        let said = last.last();
        assert!(
            status.signal().is_some_and(|number| numbers.contains(&number)),
            "{signals:?}: {status} {said:?}"
        );
        let out = folder.path().join("out");
        for (name, bytes) in contents(&out).iter().filter(|(name, _)| !name.starts_with('.')) {
            assert!(*bytes == expected[name], "{signals:?}: {name}");
        }
        assert!(sequence(folder.path()).arg("--resume").output().unwrap().status.success());
        assert!(contents(&out) == expected, "{signals:?}");
        !said.is_some_and(|line| line.contains("stopped before the end"))
    };
    assert!(ends_at_once(&["-HUP"], &[1]));
    assert!(!ends_at_once(&["-TERM"], &[15]));
    // Two threads may take both at the same moment, each as the first.
    assert!((0..20).any(|_| ends_at_once(&["-INT", "-TERM"], &[2, 15])));
}

#[test]
fn files_never_take_the_place_of_closed_streams() {
    let whole = stage();
    let render = ["render", "s.gltf", "-r", "16x9", "--samples", "1", "-o", "a.exr", "--stats", "stats.json"];
    assert!(program(whole.path()).args(render).output().unwrap().status.success());
    let expected = std::fs::read(whole.path().join("a.exr")).unwrap();
    for closed in ["<&-", ">&-", "2>&-", "<&- >&-", "<&- >&- 2>&-"] {
        let folder = stage();
        let run = |arguments: &[&str]| {
            let mut shell = Command::new("sh");
            shell.args(["-c", &format!("exec \"$0\" \"$@\" {closed}"), env!("CARGO_BIN_EXE_rayframe")]);
            let shell = shell.args(arguments).current_dir(folder.path()).env_remove("CI");
            shell.output().unwrap().status.code()
        };
        for more in [&[][..], &["--progress", "json"], &["--progress", "plain"]] {
            assert_eq!(run(&[&render[..], more, &["--overwrite"]].concat()), Some(0), "{closed}");
            assert!(std::fs::read(folder.path().join("a.exr")).unwrap() == expected, "{closed}");
        }
        std::fs::write(folder.path().join("suite.toml"), "[shot]\nresolution = [16, 9]\nsamples = 1\n")
            .unwrap();
        for (arguments, code) in
            [(&["test", "--json"][..], 1), (&["accept"], 0), (&["test"], 0), (&["info", "s.gltf"], 0)]
        {
            assert_eq!(run(arguments), Some(code), "{closed}: {arguments:?}");
        }
        for (name, bytes) in [("s.gltf", SCENE.as_bytes()), ("a.exr", &expected)] {
            assert!(std::fs::read(folder.path().join(name)).unwrap() == bytes, "{closed}: {name}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn jumps_of_the_clock_change_no_frame() {
    let library = ["lib/x86_64-linux-gnu", "lib/aarch64-linux-gnu", "lib64", "lib"]
        .map(|folder| PathBuf::from("/usr").join(folder).join("faketime/libfaketimeMT.so.1"));
    let Some(library) = library.into_iter().find(|library| library.exists()) else {
        return crate::skipped("faketime is not installed");
    };
    let folder = stage();
    assert!(sequence(folder.path()).output().unwrap().status.success());
    let expected = contents(&folder.path().join("out"));
    std::fs::remove_dir_all(folder.path().join("out")).unwrap();

    // All clocks are set back and forth, the monotonic one too.
    let clock = folder.path().join("clock");
    let set = |date: &str| std::fs::write(&clock, format!("@{date} 00:00:00")).unwrap();
    set("2026-01-01");
    let mut command = sequence(folder.path());
    command.args(["--stats", "s.json", "--manifest", "m.json"]).stderr(Stdio::null());
    command.env("LD_PRELOAD", library).env("FAKETIME_TIMESTAMP_FILE", &clock).env("FAKETIME_NO_CACHE", "1");
    let mut child = command.spawn().unwrap();
    let mut dates =
        ["1970-01-01", "2100-01-01", "2000-01-01", "1999-12-31", "2050-06-01"].into_iter().cycle();
    while child.try_wait().unwrap().is_none() {
        set(dates.next().unwrap());
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(contents(&folder.path().join("out")) == expected);
    for name in ["s.json", "m.json"] {
        let text = std::fs::read(folder.path().join(name)).unwrap();
        serde_json::from_slice::<serde_json::Value>(&text).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn every_path_may_have_any_bytes() {
    for name in [&b"\xff\xfe"[..], b"a\nb", b"-q", b"a \"b\" $c 'd'", b"a:b\\c"] {
        let folder = stage();
        let inside = folder.path().join(OsStr::from_bytes(name));
        std::fs::create_dir(&inside).unwrap();
        let at = |ending: &str| inside.join(OsStr::from_bytes(&[name, ending.as_bytes()].concat()));
        let run = |words: &[&dyn AsRef<OsStr>], code: i32| {
            let output = program(folder.path()).args(words).output().unwrap();
            let said = stderr(&output);
            assert_eq!(output.status.code(), Some(code), "{:?}: {said}", String::from_utf8_lossy(name));
            assert!(!said.contains("panicked"), "{said}");
        };
        for input in INPUTS {
            std::fs::copy(folder.path().join(input), inside.join(input)).unwrap();
        }
        let scene = at(".gltf");
        std::fs::rename(inside.join("s.gltf"), &scene).unwrap();
        let (image, stats, manifest, sheet) = (at(".exr"), at("s.json"), at("m.json"), at("c.png"));
        let size: [&dyn AsRef<OsStr>; 6] = [&"render", &scene, &"-r", &"16x9", &"--samples", &"1"];
        let render = |more: &[&dyn AsRef<OsStr>]| run(&[&size[..], more].concat(), 0);
        render(&[&"-o", &image, &"--stats", &stats, &"--manifest", &manifest, &"--contact-sheet", &sheet]);
        assert!([&image, &stats, &manifest, &sheet].iter().all(|path| path.is_file()));
        run(&[&"check", &"--manifest", &manifest], 0);
        run(&[&"info", &scene, &"--json"], 0);

        let (top, bottom, merged) = (at("t.exr"), at("b.exr"), at("m.exr"));
        render(&[&"-o", &top, &"--crop", &"0,0,16,4"]);
        render(&[&"-o", &bottom, &"--crop", &"0,4,16,9"]);
        run(&[&"merge", &top, &bottom, &"-o", &merged], 0);
        assert!(std::fs::read(&merged).unwrap() == std::fs::read(&image).unwrap());
        run(&[&"diff", &merged, &image, &"--heat-map", &at("h.png"), &"--report", &at("page")], 0);
        assert!(at("page").join("index.html").is_file());

        let suite = at(".toml");
        std::fs::write(&suite, "[shot]\nresolution = [16, 9]\nsamples = 1\n").unwrap();
        let (junit, summary) = (at("j.xml"), at("s.md"));
        run(&[&"test", &"--suite", &suite, &"--junit", &junit, &"--summary", &summary], 1);
        run(&[&"accept", &"--suite", &suite], 0);
        run(&[&"test", &"--suite", &suite], 0);
    }
}
