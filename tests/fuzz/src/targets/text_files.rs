//! Files and texts that people write, and reports that machines exchange.

use std::ffi::OsStr;
use std::path::Path;

use rayframe::gltf::ImageLoading;
use rayframe::regression::suite::{RenderedReport, RunOptions, Suite, merge_reports, read_approvals};
use rayframe::sequence::Manifest;
use rayframe::settings::{FrameSpec, OutputPattern, Settings};
use rayframe::shot::{ShotSettings, check_shot, resolve};

use crate::scratch;
use crate::verdict::{accepted, must};

/// A scene of one triangle.
const SCENE: &str = include_str!("../../../../scenes/scene/default_material.gltf");
/// Last frame of the animation that ranges of frames are resolved for.
const LAST_FRAME: i64 = 240;

/// A shot file beside `scene.gltf`: read, written and read again, and outlined.
pub(crate) fn shot(input: &[u8]) {
    scratch::file("scene.gltf", SCENE.as_bytes());
    let path = scratch::file("shot.toml", input);
    let Some(settings) = accepted(Settings::read_shot(&path)) else { return };
    let text = settings.to_toml();
    let again = scratch::file("again.toml", text.as_bytes());
    let again = accepted(Settings::read_shot(&again)).map(|settings| settings.to_toml());
    assert_eq!(again, Some(text), "a written shot file is read as another");
    // Only this scene is opened: names of others lead anywhere.
    let names_scene = settings.scene.as_ref().is_some_and(|scene| scene.value.ends_with("scene.gltf"));
    if let Some(shot) = accepted(ShotSettings::read(&path)).filter(|_| names_scene) {
        accepted(check_shot(&shot));
    }
}

/// A suite file. The folders that it names are not searched.
pub(crate) fn suite(input: &[u8]) {
    let path = scratch::file("suite.toml", input);
    accepted(Suite::read(&path));
    accepted(Settings::read_suite(&path));
}

/// A file of approvals.
pub(crate) fn approvals(input: &[u8]) {
    accepted(read_approvals(&scratch::file("approvals.json", input)));
}

/// The list of images that the report of a build server holds.
pub(crate) fn rendered(input: &[u8]) {
    let list = scratch::file("images.json", input);
    let folder = list.parent().unwrap_or(Path::new(""));
    accepted(RenderedReport::open(folder).and_then(|report| report.images()));
}

/// A zip archive of the report of a build server.
pub(crate) fn archive(input: &[u8]) {
    let archive = scratch::file("report.zip", input);
    accepted(RenderedReport::open(&archive).and_then(|report| report.images()));
}

/// The result of a shard, merged for a suite of no shots.
pub(crate) fn shard(input: &[u8]) {
    let folder = scratch::path("suite");
    must(std::fs::create_dir_all(folder.join("scenes")));
    let file = folder.join("suite.toml");
    must(std::fs::write(&file, "scenes = \"scenes\"\nreferences = \"references\"\n"));
    let report = scratch::file("result.json", input);
    let reports = [report.parent().unwrap_or(Path::new("")).to_owned()];
    if let Some(suite) = accepted(Suite::read(&file)) {
        accepted(merge_reports(&suite, &reports, &RunOptions::default()));
    }
}

/// The manifest of a delivery.
pub(crate) fn manifest(input: &[u8]) {
    if let Some(manifest) = accepted(Manifest::read(&scratch::file("manifest.json", input))) {
        let is_lower = |digits: &String| !digits.bytes().any(|byte| byte.is_ascii_uppercase());
        assert!(manifest.files.iter().filter_map(|file| file.sha256.as_ref()).all(is_lower));
    }
}

/// An output pattern and a list of frames, one text each line.
pub(crate) fn patterns(input: &[u8]) {
    let text = String::from_utf8_lossy(input);
    for line in text.lines().take(4) {
        if let Ok(pattern) = OutputPattern::parse(OsStr::new(line)) {
            let again = OutputPattern::parse(&pattern.to_text());
            assert_eq!(again.as_ref(), Ok(&pattern), "a written pattern is read as another");
            for frame in [i64::MIN, -1, 0, 1, i64::MAX] {
                assert!(
                    pattern.path(frame)
                        == again.as_ref().map_or_else(|_| line.into(), |again| again.path(frame))
                );
                drop(pattern.layer_path(frame, "depth"));
            }
        }
        if let Ok(spec) = FrameSpec::parse(line) {
            drop(spec.resolve(LAST_FRAME));
        }
    }
}

/// Definitions `KEY=VALUE`, one each line.
pub(crate) fn definitions(input: &[u8]) {
    let text = String::from_utf8_lossy(input);
    let lines: Vec<String> = text.lines().take(16).map(str::to_owned).collect();
    if let Some(settings) = accepted(Settings::read_definitions(&lines)) {
        drop(settings.to_json());
        drop(settings.values());
    }
}

/// The keys of a camera path, in a shot.
pub(crate) fn camera_path(input: &[u8]) {
    scratch::file("scene.gltf", SCENE.as_bytes());
    scratch::file("path.toml", input);
    let shot = b"scene = \"scene.gltf\"\ncamera_path = \"path.toml\"\nenv = \"none\"\nmax_memory = \"32M\"\nresolution = [8, 8]\n";
    if let Some(shot) = accepted(ShotSettings::read(&scratch::file("walk.toml", shot))) {
        accepted(resolve(&shot, ImageLoading::Headers));
    }
}
