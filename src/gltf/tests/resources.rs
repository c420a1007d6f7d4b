use std::path::Path;

use serde_json::{Value, json};

use super::{Document, error_text, glb, import_bytes};
use crate::gltf::uri::{Uri, UriError, most_data_bytes, parse};
use crate::gltf::{ImportOptions, import};

#[test]
fn uris_are_relative_paths() {
    for bad in [
        "/etc/passwd",
        "%2Fetc/passwd",
        "file:///etc/passwd",
        "http://127.0.0.1/a.bin",
        "a%00b",
        "sub\\a.bin",
        "C:/a.bin",
        "C%3A/a.bin",
        "%ff.bin",
        "//server/a.bin",
    ] {
        assert!(matches!(parse(bad), Err(UriError::Refused(_))), "{bad}");
    }
    for (good, path) in [
        ("a.bin", "a.bin"),
        ("Box%20With%20Spaces.bin", "Box With Spaces.bin"),
        ("Box With Spaces.bin", "Box With Spaces.bin"),
        ("./sub//a:b.bin", "sub/a:b.bin"),
        ("%E2%9D%A4.bin", "❤.bin"),
        ("..a/b..bin", "..a/b..bin"),
        ("%2e%2e/a.bin", "../a.bin"),
    ] {
        let Ok(Uri::Relative(parsed)) = parse(good) else {
            panic!("{good}");
        };
        assert_eq!(parsed.components().collect::<Vec<_>>(), relative(path), "{good}");
    }
}

fn relative(path: &str) -> Vec<std::path::Component<'_>> {
    Path::new(path).components().collect()
}

#[test]
fn a_short_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let document = Document::triangle();
    std::fs::write(folder.path().join("a.bin"), &document.bytes[..20]).unwrap();
    let mut json = document.to_json();
    json["buffers"][0]["uri"] = json!("a.bin");
    let scene = folder.path().join("scene.gltf");
    std::fs::write(&scene, json.to_string()).unwrap();
    let text = error_text(import(&scene, &ImportOptions::default()), 65);
    assert!(text.contains("scene.gltf: /buffers/0/byteLength: is "), "{text}");
    assert!(text.contains("but the file \"a.bin\" has only 20"), "{text}");
}

#[test]
fn files_that_git_lfs_has_not_fetched_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
    std::fs::write(at("a.bin"), pointer).unwrap();
    std::fs::write(at("scene.glb"), pointer).unwrap();
    let mut json = Document::triangle().to_json();
    json["buffers"][0]["uri"] = json!("a.bin");
    std::fs::write(at("scene.gltf"), json.to_string()).unwrap();
    for (scene, words) in [
        ("scene.glb", "scene.glb: is a Git LFS pointer, not the file itself; run git lfs pull"),
        ("scene.gltf", "a.bin: /buffers/0/uri: is a Git LFS pointer"),
    ] {
        let text = error_text(import(&at(scene), &ImportOptions::default()), 65);
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn data_uris_are_decoded_tolerantly() {
    for uri in [
        "data:;base64,AQIDBA==",
        "data:application/octet-stream;base64,AQIDBA",
        "data:;charset=utf-8;base64,AQ\nID BA==",
        "DATA:;BASE64,AQIDBA%3D%3D",
        "data:,%01%02%03%04",
    ] {
        assert_eq!(parse(uri), Ok(Uri::Data(vec![1, 2, 3, 4])), "{uri}");
        assert!((4..=12).contains(&most_data_bytes(uri)), "{uri}");
    }
    assert_eq!(most_data_bytes("data:;base64,AQIDBA=="), 6);
    assert_eq!(most_data_bytes("data:,%01%02"), 6);
    for uri in ["data:;base64", "data:;base64,@@@@", "data:;base64,A", ""] {
        assert!(matches!(parse(uri), Err(UriError::Invalid(_))), "{uri}");
    }
}

/// Document whose buffer is the file `uri`.
fn with_external_buffer(uri: &str) -> (Value, Vec<u8>) {
    let document = Document::triangle();
    let mut json = document.to_json();
    json["buffers"][0]["uri"] = json!(uri);
    (json, document.bytes)
}

#[test]
fn external_buffers_are_read_and_hashed() {
    let folder = tempfile::tempdir().unwrap();
    let (json, bytes) = with_external_buffer("my%20data.bin");
    let scene_path = folder.path().join("scene.gltf");
    let data_path = folder.path().join("my data.bin");
    std::fs::write(&scene_path, json.to_string()).unwrap();
    let options = ImportOptions::default();
    assert_eq!(import(&scene_path, &options).unwrap_err().exit_code(), 66);
    std::fs::write(&data_path, &bytes[..20]).unwrap();
    assert_eq!(import(&scene_path, &options).unwrap_err().exit_code(), 65);
    std::fs::write(&data_path, &bytes).unwrap();
    let first = import(&scene_path, &options).unwrap().content_hash;
    assert_eq!(import(&scene_path, &options).unwrap().content_hash, first);
    // A byte after the used ones changes the hash, which covers whole files.
    std::fs::write(&data_path, [&bytes[..], &[1]].concat()).unwrap();
    assert_ne!(import(&scene_path, &options).unwrap().content_hash, first);
}

#[cfg(unix)]
#[test]
fn symbolic_links_and_special_files_are_refused() {
    let outside = tempfile::tempdir().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (json, bytes) = with_external_buffer("link.bin");
    let scene_path = folder.path().join("scene.gltf");
    std::fs::write(&scene_path, json.to_string()).unwrap();
    std::fs::write(outside.path().join("secret.bin"), &bytes).unwrap();
    std::fs::write(folder.path().join("real.bin"), &bytes).unwrap();
    let link = folder.path().join("link.bin");
    let options = ImportOptions::default();

    std::os::unix::fs::symlink(outside.path().join("secret.bin"), &link).unwrap();
    assert_eq!(import(&scene_path, &options).unwrap_err().exit_code(), 77);
    std::fs::remove_file(&link).unwrap();
    std::os::unix::fs::symlink("real.bin", &link).unwrap();
    assert!(import(&scene_path, &options).is_ok());
    std::fs::remove_file(&link).unwrap();
    std::fs::create_dir(&link).unwrap();
    assert_eq!(import(&scene_path, &options).unwrap_err().exit_code(), 65);
    // The scene file itself is a folder, a device, or missing.
    assert_eq!(import(folder.path(), &options).unwrap_err().exit_code(), 65);
    assert_eq!(import(Path::new("/dev/zero"), &options).unwrap_err().exit_code(), 65);
    let nothing = folder.path().join("nothing.glb");
    assert_eq!(import(&nothing, &options).unwrap_err().exit_code(), 66);
}

#[test]
fn files_outside_the_folder_are_read_where_their_folder_is_allowed() {
    let root = tempfile::tempdir().unwrap();
    let at = |name: &str| root.path().join(name);
    for folder in ["scene/sub", "shared/deep", "other"] {
        std::fs::create_dir_all(at(folder)).unwrap();
    }
    let code = |uri: &str, allowed: &[&str]| {
        let (json, bytes) = with_external_buffer(uri);
        for name in ["scene/own.bin", "shared/deep/a.bin", "other/b.bin"] {
            std::fs::write(at(name), &bytes).unwrap();
        }
        std::fs::write(at("scene/scene.gltf"), json.to_string()).unwrap();
        let allowed_folders = allowed.iter().map(|folder| at(folder)).collect();
        let options = ImportOptions { allowed_folders, ..ImportOptions::default() };
        import(&at("scene/scene.gltf"), &options).map_or_else(|error| error.exit_code(), |_| 0)
    };
    // A detour stays inside.
    assert_eq!(code("sub/../own.bin", &[]), 0);
    assert_eq!(code("../scene/own.bin", &[]), 0);
    // Without permission nobody learns what exists.
    assert_eq!(code("../shared/deep/a.bin", &[]), 77);
    assert_eq!(code("../shared/missing.bin", &[]), 77);
    assert_eq!(code("missing/../../other/b.bin", &[]), 77);
    // Permission is for a folder and what is in it.
    assert_eq!(code("../shared/deep/a.bin", &["shared"]), 0);
    assert_eq!(code("%2e%2e/shared/deep/a.bin", &["other", "scene/../shared/deep"]), 0);
    assert_eq!(code("../shared/missing.bin", &["shared"]), 66);
    assert_eq!(code("../other/b.bin", &["shared", "missing"]), 77);
    assert_eq!(code("../shared/../other/b.bin", &["shared"]), 77);
    assert_eq!(code("own.bin", &["shared"]), 0);
    // The message names a folder that permits it.
    let permits = |uri: &str| {
        assert_eq!(code(uri, &[]), 77, "{uri}");
        let message = import(&at("scene/scene.gltf"), &ImportOptions::default()).unwrap_err().to_string();
        let folder = message.split('"').nth(3).unwrap().to_owned();
        let options = ImportOptions { allowed_folders: vec![folder.into()], ..ImportOptions::default() };
        assert!(import(&at("scene/scene.gltf"), &options).is_ok(), "{message}");
    };
    permits("../shared/deep/a.bin");
    // Links lead where they lead.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(at("other/b.bin"), at("shared/link.bin")).unwrap();
        assert_eq!(code("../shared/link.bin", &["shared"]), 77);
        assert_eq!(code("../shared/link.bin", &["shared", "other"]), 0);
        std::os::unix::fs::symlink(at("other/b.bin"), at("scene/link.bin")).unwrap();
        permits("link.bin");
    }
}

fn triangle_glb() -> Vec<u8> {
    let document = Document::triangle();
    let mut json = document.to_json();
    json["buffers"][0].as_object_mut().unwrap().remove("uri");
    glb(&[(b"JSON", json.to_string().as_bytes()), (b"BIN\0", &document.bytes)])
}

#[test]
fn glb_chunks_are_found() {
    let file = triangle_glb();
    assert_eq!(import_bytes("a.glb", &file).unwrap().meshes[0].primitives[0].triangles.len(), 1);
    // Unknown chunks are skipped. Bytes after the end are ignored with a warning.
    let mut longer = file;
    longer.extend(b"junk");
    assert_eq!(import_bytes("a.glb", &longer).unwrap().warnings.len(), 1);
    let json = br#"{"asset": {"version": "2.0"}}"#;
    let unknown = glb(&[(b"JSON", json), (b"ACME", b"1234")]);
    assert!(import_bytes("a.glb", &unknown).is_ok());
}

#[test]
fn truncated_glbs_are_errors_at_every_length() {
    let file = triangle_glb();
    for length in (4..file.len()).step_by(7) {
        error_text(import_bytes("a.glb", &file[..length]), 65);
    }
    for (position, value) in
        [(4, 1_u32), (8, 0), (8, 11), (8, 20), (8, u32::MAX), (12, 0), (12, u32::MAX), (12, 4), (16, 7)]
    {
        let mut lying = file.clone();
        lying[position..position + 4].copy_from_slice(&value.to_le_bytes());
        error_text(import_bytes("a.glb", &lying), 65);
    }
    let json: &[u8] = br#"{"asset": {"version": "2.0"}}"#;
    error_text(import_bytes("a.glb", &glb(&[(b"JSON", json), (b"JSON", json)])), 65);
    error_text(import_bytes("a.glb", &glb(&[(b"BIN\0", b"1234"), (b"JSON", json)])), 65);
    error_text(import_bytes("a.glb", &glb(&[])), 65);
}

#[test]
fn a_misplaced_binary_chunk_is_named() {
    let mut document = Document::triangle();
    document.json["buffers"] = json!([{"byteLength": document.bytes.len()}]);
    let json = document.json.to_string();
    let (json, bin) = ((b"JSON", json.as_bytes()), (b"BIN\0", &document.bytes[..]));
    assert_eq!(import_bytes("a.glb", &glb(&[json, bin])).unwrap().warnings, []);
    let warnings = import_bytes("a.glb", &glb(&[json, (b"XTRA", b"1234"), bin])).unwrap().warnings;
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].message.contains("not its second chunk"), "{warnings:?}");
}

#[test]
fn data_uris_over_the_memory_limit_are_refused_before_they_are_decoded() {
    // The file, its value and its typed copy fit beside the objects, the bytes do not: an error in the base64 is not even seen.
    let mut json = Document::triangle().to_json();
    json["buffers"][0]["uri"] = json!(format!("data:;base64,{}@", "A".repeat(400_000)));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, json.to_string()).unwrap();
    let within = |max_memory_bytes, exit_code| {
        error_text(import(&path, &ImportOptions { max_memory_bytes, ..ImportOptions::default() }), exit_code)
    };
    assert!(within(1_400_000, 77).contains("/buffers/0/uri"));
    assert!(within(2_000_000, 65).contains("the base64 of the data: URI is invalid"));
}
