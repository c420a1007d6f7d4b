//! Determinism: the image depends on the scene and its settings, never on how it is computed.
//!
//! Runs the program itself: each scene is rendered plainly, and again in another way that must give the same file to the
//! last byte. The scenes are those where something could go another way: many ties in depth, boxes that are split,
//! stacked surfaces that are passed through in order, deformed meshes, the studio's light, and paths, which photons and
//! the view through windows guide.

use std::path::{Path, PathBuf};
use std::process::Command;

use rayframe::bvh::SimdLevel;
use rayframe::image::RgbaImage;
use rayframe::image_file::decode_exr_rgba;

/// A scene and the options that these tests render it with.
struct Shot {
    scene: &'static str,
    frame: u32,
    options: &'static [&'static str],
}

static SHOTS: [Shot; 17] = [
    shot("demo/whitted_1980", 5, &[]),
    shot("bvh/slivers", 0, &[]),
    shot("bvh/long_diagonals", 0, &[]),
    shot("bvh/coincident_faces", 0, &[]),
    shot("bvh/degenerate_triangles", 0, &[]),
    shot("material/alpha_blend_stack", 0, &[]),
    shot("material/nested_glass", 0, &[]),
    shot("skin/two_bone_strip", 5, &[]),
    shot("morph/morph_then_skin", 5, &[]),
    shot("light/environment_only", 0, &["--env", "studio"]),
    shot("environment/frosted_glass", 0, &["--env", "studio"]),
    shot("material/nested_glass", 0, &["--env", "outdoor", "--integrator", "path"]),
    shot("material/alpha_blend_stack", 0, &["--env", "studio", "--integrator", "path", "--seed-per-frame"]),
    shot("texture/emissive", 0, &["--integrator", "path", "--noise", "0.02"]),
    shot("material/glass_sphere", 0, &["--env", "studio", "--ground", "--shadow-catcher", "floor"]),
    shot("path/box", 0, &["--integrator", "path"]),
    shot("showcase/apartment", 0, &["--env", "outdoor", "--integrator", "path"]),
];

/// An odd size leaves lanes empty.
const SIZE: &[&str] = &["-r", "61x35", "--samples", "2"];
/// Small enough for brute force.
const TINY: &[&str] = &["-r", "16x9", "--samples", "1"];

const fn shot(scene: &'static str, frame: u32, options: &'static [&'static str]) -> Shot {
    Shot { scene, frame, options }
}

/// Renders `shot` with `options`; returns the standard error stream.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn rayframe(shot: &Shot, output: &Path, options: &[&str]) -> String {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(shot.scene);
    let run = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .arg("render")
        .arg(scene.with_extension("gltf"))
        .arg("-o")
        .arg(output)
        .args(["--progress", "plain"])
        .args(shot.options)
        .args(options)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(run.status.success(), "{} with {options:?}: {}\n{said}", shot.scene, run.status);
    said
}

/// Renders the shot's one frame as `name` in `folder`.
fn render(shot: &Shot, folder: &Path, name: &str, options: &[&[&str]]) -> PathBuf {
    let path = folder.join(name);
    let frame = shot.frame.to_string();
    let options = [&["-f", &frame, "--overwrite"], options.concat().as_slice()].concat();
    rayframe(shot, &path, &options);
    path
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn assert_same_file(shot: &Shot, size: &[&str], ways: &[&[&str]]) {
    let folder = tempfile::tempdir().unwrap();
    let plain = render(shot, folder.path(), "plain.exr", &[size]);
    for way in ways {
        let other = render(shot, folder.path(), "other.exr", &[size, way]);
        assert_same_bytes(&plain, &other, &format!("{} with {way:?}", shot.scene));
    }
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn assert_same_bytes(expected: &Path, actual: &Path, what: &str) {
    let (expected, actual) = (std::fs::read(expected).unwrap(), std::fs::read(actual).unwrap());
    if expected == actual {
        return;
    }
    let (decoded, other) = (decode(&expected), decode(&actual));
    assert_eq!(decoded.size, other.size, "{what}: the sizes differ");
    assert_same_pixels(&decoded, &other, (0, 0), what);
    let byte = expected.iter().zip(&actual).position(|(a, b)| a != b);
    assert!(expected == actual, "{what}: the pixels are the same, but not the file from byte {byte:?} on");
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn decode(bytes: &[u8]) -> RgbaImage {
    decode_exr_rgba("frame.exr".as_ref(), bytes, 1 << 28).unwrap()
}

/// Asserts that `part` holds the pixels of `whole` from `origin` on; names the first that differs.
fn assert_same_pixels(whole: &RgbaImage, part: &RgbaImage, origin: (u32, u32), what: &str) {
    let (width, height) = part.size;
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let expected = whole.pixels[((y + origin.1) * whole.size.0 + x + origin.0) as usize];
        let actual = part.pixels[(y * width + x) as usize];
        assert!(
            expected.map(f32::to_bits) == actual.map(f32::to_bits),
            "{what}: column {x}, row {y}: {actual:?} instead of {expected:?}"
        );
    }
}

/// The comparison itself fails for a difference, so the other tests can fail.
#[test]
#[should_panic(expected = "the demo without reflections: column ")]
fn a_difference_is_reported_with_its_pixel() {
    let folder = tempfile::tempdir().unwrap();
    let plain = render(&SHOTS[0], folder.path(), "plain.exr", &[SIZE]);
    let other = render(&SHOTS[0], folder.path(), "other.exr", &[SIZE, &["--depth", "0"]]);
    assert_same_bytes(&plain, &other, "the demo without reflections");
}

/// Each value of an option once or more, with different values of the others: two options that both change the image would have to
/// cancel out to go unnoticed.
#[test]
fn threads_splitting_simd_levels_and_hierarchies_do_not_change_the_image() {
    let is_arm = cfg!(target_arch = "aarch64");
    let least = if is_arm { (SimdLevel::Neon, "neon") } else { (SimdLevel::Sse42, "sse4.2") };
    let ways: [(_, &[&str]); 4] = [
        ((SimdLevel::Scalar, "scalar"), &["-t", "1", "--split", "off"]),
        (least, &["-t", "2", "--split", "1e-4"]),
        ((SimdLevel::Avx2, "avx2"), &["-t", "3", "--split", "auto", "--bvh", "lbvh"]),
        ((SimdLevel::Avx512, "avx512"), &["-t", "8", "--split", "1e-3", "--bvh", "ploc"]),
    ];
    let ways = ways.map(|((level, name), options)| {
        if level.is_supported() {
            return [options, &["--simd", name]].concat();
        }
        crate::skipped(&format!("this processor does not support {name}"));
        options.to_vec()
    });
    let ways = ways.each_ref().map(Vec::as_slice);
    for shot in &SHOTS {
        assert_same_file(shot, SIZE, &ways);
    }
}

/// Four flat boxes of 10⁻⁴ m², counting both sides, for each of the demo's 50 160 triangles cover 10 m²; its floor is
/// larger.
#[test]
fn a_tiny_split_area_reaches_the_reference_budget_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let options = [&["-f", "5", "--split", "1e-4"], TINY].concat();
    let said = rayframe(&SHOTS[0], &folder.path().join("a.exr"), &options);
    let warnings: Vec<_> = said.lines().filter(|line| line.contains("warning")).collect();
    assert!(warnings.len() == 1 && warnings[0].contains("--split"), "{said}");
}

/// `--split auto` splits one of the scenes at this size, so that the tests above cover it.
#[test]
fn one_scene_is_split_by_default() {
    let folder = tempfile::tempdir().unwrap();
    let stats = folder.path().join("stats.json");
    let options = [&["-f", "0", "--stats", stats.to_str().unwrap()], SIZE].concat();
    let diagonals = SHOTS.iter().find(|shot| shot.scene == "bvh/long_diagonals").unwrap();
    rayframe(diagonals, &folder.path().join("a.exr"), &options);
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(stats).unwrap()).unwrap();
    let tree = &stats["frames"][0]["tree"];
    assert!(tree["references"].as_u64() > tree["triangles"].as_u64(), "{tree}");
}

#[test]
fn brute_force_does_not_change_the_image() {
    for shot in &SHOTS {
        // Brute force takes a minute for the photons of the apartment. Those of the box are compared.
        let is_large = shot.scene == "showcase/apartment";
        let way: &[&str] = if is_large { &["--bvh", "lbvh", "--split", "1e-3"] } else { &["--bvh", "brute"] };
        assert_same_file(shot, TINY, &[way]);
    }
    // More rays than at that size: enough that triangles are split.
    let diagonals = SHOTS.iter().find(|shot| shot.scene == "bvh/long_diagonals").unwrap();
    assert_same_file(diagonals, &["-r", "48x27", "--samples", "2"], &[&["--bvh", "brute"]]);
}

/// Edges of the crops lie inside tiles and on the edge of the image; a crop of one pixel lies within a single tile.
#[test]
fn a_crop_has_the_pixels_of_the_whole_image() {
    for shot in &SHOTS {
        let folder = tempfile::tempdir().unwrap();
        let whole = decode(&std::fs::read(render(shot, folder.path(), "whole.exr", &[SIZE])).unwrap());
        assert_eq!(whole.size, (61, 35));
        assert!(whole.pixels.iter().any(|pixel| *pixel != whole.pixels[0]), "{} is blank", shot.scene);
        for (crop, origin, size) in [
            ("13,7,61,27", (13, 7), (48, 20)),
            ("32,16,48,32", (32, 16), (16, 16)),
            ("47,26,48,27", (47, 26), (1, 1)),
        ] {
            let path = render(shot, folder.path(), "part.exr", &[SIZE, &["--crop", crop]]);
            let part = decode(&std::fs::read(path).unwrap());
            assert_eq!(part.size, size, "{} with --crop {crop}", shot.scene);
            assert_same_pixels(&whole, &part, origin, &format!("{} with --crop {crop}", shot.scene));
        }
    }
}

/// Shots that differ in more than the shapes of triangles, which frames of a sequence do not share.
fn shots_of_sequences() -> impl Iterator<Item = &'static Shot> {
    let shapes = ["bvh/coincident_faces", "bvh/degenerate_triangles"];
    SHOTS.iter().filter(move |shot| !shapes.contains(&shot.scene))
}

/// A sequence reuses memory and, where nothing moves, the hierarchy.
#[test]
fn a_frame_is_the_same_alone_and_in_a_sequence() {
    for shot in shots_of_sequences() {
        let folder = tempfile::tempdir().unwrap();
        rayframe(shot, &folder.path().join("a.####.exr"), &[&["-f", "0-8"], TINY].concat());
        for frame in [0_u32, 5, 8] {
            let alone = Shot { frame, ..*shot };
            let path = render(&alone, folder.path(), "alone.exr", &[TINY]);
            let in_sequence = folder.path().join(format!("a.{frame:04}.exr"));
            assert_same_bytes(&in_sequence, &path, &format!("{} frame {frame} alone", shot.scene));
        }
    }
}

/// Refitting gives the files of a new tree for each frame at any cost ratio, and it does refit.
#[test]
fn refitting_does_not_change_the_image() {
    for scene in ["demo/whitted_1980", "skin/two_bone_strip"] {
        let shot = Shot { scene, frame: 0, options: &[] };
        let folder = tempfile::tempdir().unwrap();
        let stats = folder.path().join("stats.json");
        let options = |name: &str, refit: &'static str| {
            let output = folder.path().join(name).join("a.####.exr");
            let stats = stats.to_str().unwrap();
            rayframe(&shot, &output, &[&["-f", "0-20x5", "--refit", refit, "--stats", stats], TINY].concat());
            output.parent().unwrap().to_owned()
        };
        let built = options("built", "off");
        let refitted = options("refitted", "inf");
        let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(&stats).unwrap()).unwrap();
        let made = stats["frames"].as_array().unwrap().iter().map(|frame| &frame["tree"]["made"]);
        assert_eq!(made.skip(1).collect::<Vec<_>>(), ["refitted"; 4], "{scene}");
        for frame in [0, 5, 10, 15, 20] {
            let name = format!("a.{frame:04}.exr");
            assert_same_bytes(&built.join(&name), &refitted.join(&name), &format!("{scene} {name}"));
        }
    }
}

/// Missing and broken frames are rendered again, with other options for acceleration, to the same bytes.
#[test]
fn a_resumed_sequence_is_the_whole_one() {
    // The box has photons, too.
    for shot in shots_of_sequences().filter(|shot| shot.scene != "showcase/apartment") {
        let folder = tempfile::tempdir().unwrap();
        let (whole, resumed) = (folder.path().join("whole"), folder.path().join("resumed"));
        let options = [&["-f", "3-7"], TINY].concat();
        rayframe(shot, &whole.join("a.####.exr"), &options);
        std::fs::create_dir(&resumed).unwrap();
        for frame in [4, 5, 7] {
            let name = format!("a.{frame:04}.exr");
            let bytes = std::fs::read(whole.join(&name)).unwrap();
            let is_broken = frame == 5;
            std::fs::write(resumed.join(&name), &bytes[..bytes.len() - usize::from(is_broken)]).unwrap();
        }
        let said = rayframe(
            shot,
            &resumed.join("a.####.exr"),
            &[&options[..], &["--resume", "-t", "1", "--split", "off"]].concat(),
        );
        assert!(said.contains("2 frames are there already"), "{}: {said}", shot.scene);
        for frame in 3..=7 {
            let name = format!("a.{frame:04}.exr");
            let what = format!("{} frame {frame} resumed", shot.scene);
            assert_same_bytes(&whole.join(&name), &resumed.join(&name), &what);
        }
        assert_eq!(std::fs::read_dir(&resumed).unwrap().count(), 5, "{}", shot.scene);
    }
}
