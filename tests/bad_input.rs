//! Wrong input ends in one line that says where, with the exit code that says what kind, and leaves no file.

use std::path::{Path, PathBuf};
use std::process::Command;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// One triangle: positions, then indices of 16 bits, in one buffer.
const POSITIONS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const INDICES: [u16; 3] = [0, 1, 2];
const BUFFER_BYTES: usize = 42;

fn buffer(positions: &[[f32; 3]], indices: &[u16]) -> Vec<u8> {
    let positions = positions.iter().flatten().flat_map(|value| value.to_le_bytes());
    positions.chain(indices.iter().flat_map(|index| index.to_le_bytes())).collect()
}

/// A right scene of one triangle; its buffer is at `buffer_uri`, or else the binary chunk of a GLB.
fn document(buffer_uri: Option<&str>) -> Value {
    let mut document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0],
            },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 },
        ],
        "buffers": [{ "byteLength": BUFFER_BYTES }],
    });
    if let Some(uri) = buffer_uri {
        document["buffers"][0]["uri"] = uri.into();
    }
    document
}

fn embedded(positions: &[[f32; 3]], indices: &[u16]) -> Value {
    let data = STANDARD.encode(buffer(positions, indices));
    document(Some(&format!("data:application/octet-stream;base64,{data}")))
}

fn triangle() -> Value {
    embedded(&POSITIONS, &INDICES)
}

/// A GLB of `document` with the triangle as its binary chunk.
fn glb(document: &Value) -> Vec<u8> {
    let padded = |mut bytes: Vec<u8>, padding: u8| {
        bytes.resize(bytes.len().next_multiple_of(4), padding);
        bytes
    };
    let chunks = [
        (*b"JSON", padded(document.to_string().into_bytes(), b' ')),
        (*b"BIN\0", padded(buffer(&POSITIONS, &INDICES), 0)),
    ];
    let length: usize = 12 + chunks.iter().map(|(_, content)| 8 + content.len()).sum::<usize>();
    let mut file = [&b"glTF"[..], &2_u32.to_le_bytes(), &(length as u32).to_le_bytes()].concat();
    for (kind, content) in chunks {
        file.extend((content.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(content);
    }
    file
}

/// A folder with a scene in it, and the program run there.
struct Stage {
    folder: tempfile::TempDir,
}

/// How a run ended and what it said on the standard error stream.
struct Ending {
    code: Option<i32>,
    said: String,
}

impl Stage {
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn new(name: &str, content: impl AsRef<[u8]>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("scene")).unwrap();
        std::fs::write(folder.path().join("scene").join(name), content).unwrap();
        Self { folder }
    }

    fn with(document: &Value) -> Self {
        Self::new("bad.gltf", document.to_string())
    }

    /// Every file and folder below the stage.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn everything(&self) -> Vec<PathBuf> {
        let mut found = vec![self.folder.path().to_owned()];
        let mut next = 0;
        while let Some(path) = found.get(next) {
            if path.is_dir() && !path.is_symlink() {
                let entries: Vec<_> =
                    std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).collect();
                found.extend(entries);
            }
            next += 1;
        }
        found.sort();
        found
    }

    /// Renders `scene/NAME` quietly, 8x6 pixels unless `options` ask for others; the stage is the current folder.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn render(&self, name: &str, options: &[&str]) -> Ending {
        let size = if options.contains(&"-r") { &[][..] } else { &["-r", "8x6"] };
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .current_dir(self.folder.path())
            .args(["render", &format!("scene/{name}"), "--samples", "1", "-q"])
            .args(size)
            .args(options)
            .output()
            .unwrap();
        assert!(output.stdout.is_empty());
        Ending { code: output.status.code(), said: String::from_utf8_lossy(&output.stderr).into_owned() }
    }

    /// The run fails with `code` in one line that holds `words`, and changes nothing on disk.
    fn assert_fails_with(&self, name: &str, options: &[&str], (code, words): (i32, &[&str])) {
        let before = self.everything();
        let ending = self.render(name, options);
        let Ending { said, .. } = &ending;
        assert_eq!(ending.code, Some(code), "{options:?}: {said}");
        let (errors, others): (Vec<&str>, Vec<&str>) =
            said.lines().partition(|line| line.starts_with("rayframe: error: "));
        assert_eq!(errors.len(), 1, "{options:?}: {said}");
        assert!(others.iter().all(|line| line.starts_with("rayframe: warning: ")), "{options:?}: {said}");
        for word in words {
            assert!(errors[0].contains(word), "\"{word}\" is not in: {said}");
        }
        assert_eq!(self.everything(), before, "{options:?}: {said}");
    }

    fn assert_fails(&self, name: &str, expected: (i32, &[&str])) {
        self.assert_fails_with(name, &["-o", "out/a.exr"], expected);
    }
}

/// Without this the other tests could fail for a reason of their own.
#[test]
fn the_scene_that_is_spoiled_below_is_right() {
    let text = triangle();
    let binary = glb(&document(None));
    for (name, content) in [("a.gltf", text.to_string().into_bytes()), ("a.glb", binary)] {
        let stage = Stage::new(name, content);
        let ending = stage.render(name, &["-o", "out/a.exr", "--strict"]);
        assert_eq!((ending.code, ending.said.as_str()), (Some(0), ""), "{name}");
        assert!(stage.folder.path().join("out/a.exr").is_file());
    }
}

#[test]
fn a_truncated_glb_is_wrong_wherever_it_is_cut() {
    let whole = glb(&document(None));
    let bin_start = whole.len() - 8 - BUFFER_BYTES.next_multiple_of(4);
    for length in [0, 3, 4, 11, 12, 19, 20, 100, bin_start, bin_start + 4, bin_start + 20, whole.len() - 1] {
        Stage::new("cut.glb", &whole[..length]).assert_fails("cut.glb", (65, &["cut.glb: "]));
    }
}

#[test]
fn chunks_that_lie_about_their_length_are_wrong() {
    for length in [u32::MAX, u32::MAX - 3, 1 << 31] {
        let mut file = glb(&document(None));
        file[12..16].copy_from_slice(&length.to_le_bytes());
        Stage::new("lie.glb", &file).assert_fails("lie.glb", (65, &["lie.glb: ", "truncated or damaged"]));
    }
}

#[test]
fn a_missing_buffer_is_named_with_the_place_that_asks_for_it() {
    let stage = Stage::with(&document(Some("gone.bin")));
    stage.assert_fails("bad.gltf", (66, &["gone.bin", "bad.gltf", "/buffers/0/uri"]));
}

#[test]
fn a_buffer_that_is_too_short_is_wrong() {
    let stage = Stage::with(&document(Some("short.bin")));
    std::fs::write(stage.folder.path().join("scene/short.bin"), [0; BUFFER_BYTES - 1]).unwrap();
    stage.assert_fails("bad.gltf", (65, &["bad.gltf: ", "/buffers/0"]));
}

#[test]
fn indices_past_the_end_are_wrong_at_every_step_of_the_chain() {
    let spoil = |pointer: &str, value: Value| {
        let mut spoiled = triangle();
        *spoiled.pointer_mut(pointer).unwrap() = value;
        Stage::with(&spoiled)
    };
    for (stage, at) in [
        (Stage::with(&embedded(&POSITIONS, &[0, 1, 3])), "/accessors/1: "),
        // The restart value of strips is no index either.
        (Stage::with(&embedded(&POSITIONS, &[0, 1, u16::MAX])), "/accessors/1: "),
        (spoil("/meshes/0/primitives/0/indices", json!(2)), "/meshes/0/primitives/0/indices: "),
        (
            spoil("/meshes/0/primitives/0/attributes/POSITION", json!(9)),
            "/meshes/0/primitives/0/attributes/POSITION: ",
        ),
        (spoil("/nodes/0/mesh", json!(1)), "/nodes/0/mesh: "),
        (spoil("/scenes/0/nodes/0", json!(1)), "/scenes/0/nodes"),
        (spoil("/scene", json!(1)), "/scene: "),
        (spoil("/bufferViews/1/buffer", json!(1)), "/bufferViews/1"),
        (spoil("/bufferViews/1/byteLength", json!(7)), "/bufferViews/1"),
        (spoil("/bufferViews/0/byteOffset", json!(u64::MAX)), "/bufferViews/0"),
        (spoil("/accessors/0/count", json!(4)), "/accessors/0"),
        (spoil("/accessors/0/count", json!(u64::MAX)), "/accessors/0"),
        (spoil("/accessors/0/bufferView", json!(2)), "/accessors/0"),
    ] {
        stage.assert_fails("bad.gltf", (65, &["bad.gltf: ", at]));
    }
}

#[test]
fn positions_that_are_no_numbers_are_wrong() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut positions = POSITIONS;
        positions[1][2] = value;
        let stage = Stage::with(&embedded(&positions, &INDICES));
        stage.assert_fails("bad.gltf", (65, &["bad.gltf: ", "/accessors/0: ", "element 1"]));
    }
}

#[test]
fn nodes_that_form_no_trees_are_wrong() {
    for (nodes, at) in [
        (json!([{ "mesh": 0, "children": [0] }]), "/nodes/0"),
        (json!([{ "children": [1] }, { "mesh": 0, "children": [0] }]), "/nodes/0"),
        // A root above a cycle: the cycle's first node then has two parents.
        (json!([{ "children": [1] }, { "children": [2] }, { "mesh": 0, "children": [1] }]), "/nodes/"),
        (json!([{ "children": [1, 2] }, { "children": [2] }, { "mesh": 0 }]), "/nodes/"),
    ] {
        let mut cyclic = triangle();
        cyclic["nodes"] = nodes;
        Stage::with(&cyclic).assert_fails("bad.gltf", (65, &["bad.gltf: ", at]));
    }
}

#[test]
fn paths_out_of_the_scenes_folder_are_refused() {
    let secret = |stage: &Stage| {
        let path = stage.folder.path().join("secret.bin");
        std::fs::write(&path, buffer(&POSITIONS, &INDICES)).unwrap();
        path
    };
    for uri in
        ["../secret.bin", "sub/../../secret.bin", "%2e%2e/secret.bin", "..%2Fsecret.bin", "..\\secret.bin"]
    {
        let stage = Stage::with(&document(Some(uri)));
        secret(&stage);
        stage.assert_fails("bad.gltf", (77, &["bad.gltf: ", "/buffers/0/uri: "]));
    }
    for scheme in ["", "file://"] {
        let stage = Stage::new("bad.gltf", "");
        let uri = format!("{scheme}{}", secret(&stage).display());
        let scene = stage.folder.path().join("scene/bad.gltf");
        std::fs::write(scene, document(Some(&uri)).to_string()).unwrap();
        stage.assert_fails("bad.gltf", (77, &["bad.gltf: ", "/buffers/0/uri: "]));
    }
}

#[cfg(unix)]
#[test]
fn links_may_not_lead_out_of_the_scenes_folder() {
    let stage = Stage::with(&document(Some("link.bin")));
    let secret = stage.folder.path().join("secret.bin");
    std::fs::write(&secret, buffer(&POSITIONS, &INDICES)).unwrap();
    std::os::unix::fs::symlink(&secret, stage.folder.path().join("scene/link.bin")).unwrap();
    stage.assert_fails("bad.gltf", (77, &["bad.gltf: ", "/buffers/0/uri: "]));
}

#[test]
fn a_required_extension_that_is_unknown_is_named() {
    let mut document = triangle();
    document["extensionsUsed"] = json!(["ACME_hologram"]);
    document["extensionsRequired"] = json!(["ACME_hologram"]);
    let words = ["bad.gltf: ", "/extensionsRequired: ", "ACME_hologram"];
    Stage::with(&document).assert_fails("bad.gltf", (65, &words));
}

#[test]
fn an_optional_extension_that_is_unknown_is_one_warning_or_a_strict_error() {
    let mut document = triangle();
    document["extensionsUsed"] = json!(["ACME_hologram"]);
    document["nodes"][0]["extensions"] = json!({ "ACME_hologram": { "depth": 2 } });
    let stage = Stage::with(&document);
    let words =
        ["bad.gltf: ", "/nodes/0/extensions/ACME_hologram: ", "ACME_hologram is not supported", "--strict"];
    stage.assert_fails_with("bad.gltf", &["-o", "out/a.exr", "--strict"], (65, &words));

    let ending = stage.render("bad.gltf", &["-o", "out/a.exr"]);
    assert_eq!(ending.code, Some(0), "{}", ending.said);
    assert_eq!(ending.said.lines().count(), 1, "{}", ending.said);
    assert!(ending.said.starts_with("rayframe: warning: scene/bad.gltf: /nodes/0/"), "{}", ending.said);
    assert!(stage.folder.path().join("out/a.exr").is_file());
}

#[test]
fn what_is_no_gltf_at_all_is_wrong() {
    for content in ["", "{", "[]", "null", "PNG", "{}", r#"{"asset":{"version":"1.0"}}"#] {
        Stage::new("bad.gltf", content).assert_fails("bad.gltf", (65, &["bad.gltf: "]));
    }
    // Deeper than any parser's stack.
    let deep = format!("{}{}", "[".repeat(200_000), "]".repeat(200_000));
    Stage::new("bad.gltf", deep).assert_fails("bad.gltf", (65, &["bad.gltf: "]));
}

#[test]
fn outputs_that_cannot_be_made_are_told_before_the_first_frame() {
    let stage = Stage::with(&triangle());
    std::fs::write(stage.folder.path().join("file"), "").unwrap();
    stage.assert_fails_with("bad.gltf", &["-o", "file/a.exr"], (73, &["file"]));
    std::fs::create_dir(stage.folder.path().join("a.exr")).unwrap();
    stage.assert_fails_with("bad.gltf", &["-o", "a.exr"], (73, &["a.exr"]));
    if cfg!(target_os = "linux") {
        // Not even the superuser can make a folder here.
        stage.assert_fails_with("bad.gltf", &["-o", "/proc/rayframe/a.exr"], (73, &["/proc/rayframe"]));
    }
}

#[cfg(unix)]
#[test]
fn a_folder_without_leave_to_write_is_told_before_the_first_frame() {
    use std::os::unix::fs::PermissionsExt as _;
    let stage = Stage::with(&triangle());
    let folder = stage.folder.path().join("locked");
    std::fs::create_dir(&folder).unwrap();
    std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser may write anyway; then there is nothing to see here.
    if std::fs::write(folder.join("probe"), "").is_err() {
        stage.assert_fails_with("bad.gltf", &["-o", "locked/a.exr"], (73, &["locked/a.exr"]));
    }
}

#[test]
fn frames_that_would_share_a_name_are_a_usage_error() {
    let stage = Stage::with(&triangle());
    let options = ["-o", "out/a.exr", "-f", "1-2"];
    stage.assert_fails_with("bad.gltf", &options, (2, &["out/a.exr", "####"]));
}

#[test]
fn pictures_that_do_not_fit_are_refused_before_anything_is_allocated() {
    let stage = Stage::with(&triangle());
    for size in ["65536x65536", "2147483647x2147483647"] {
        let options = ["-o", "out/a.exr", "--max-memory", "1G", "-r", size];
        stage.assert_fails_with("bad.gltf", &options, (77, &["bad.gltf: ", size, "--max-memory"]));
    }
}

#[test]
fn ranges_that_name_no_frames_are_usage_errors() {
    let stage = Stage::with(&triangle());
    for range in ["3-1", "1,x", "", "1-2-3", "1-10x0", "0-99999999999999999999"] {
        let options = ["-o", "out/a.####.exr", "-f", range];
        stage.assert_fails_with("bad.gltf", &options, (2, &["--frames"]));
    }
}

#[test]
fn a_foreign_frame_is_not_replaced_unasked() {
    let stage = Stage::with(&triangle());
    let path = stage.folder.path().join("out/a.0002.exr");
    std::fs::create_dir(stage.folder.path().join("out")).unwrap();
    std::fs::write(&path, "yesterday's picture").unwrap();
    let options = ["-o", "out/a.####.exr", "-f", "1-3"];
    stage.assert_fails_with("bad.gltf", &options, (73, &["out/a.0002.exr", "--resume", "--overwrite"]));
    assert_eq!(std::fs::read(&path).unwrap(), b"yesterday's picture");

    for flag in ["--resume", "--overwrite"] {
        std::fs::write(&path, "yesterday's picture").unwrap();
        let ending = stage.render("bad.gltf", &[&options[..], &[flag]].concat());
        assert_eq!(ending.code, Some(0), "{flag}: {}", ending.said);
        assert!(is_exr(&path) && is_exr(&path.with_file_name("a.0003.exr")), "{flag}");
    }
}

/// Whether the file begins as OpenEXR files do.
fn is_exr(path: &Path) -> bool {
    std::fs::read(path).is_ok_and(|bytes| bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]))
}
