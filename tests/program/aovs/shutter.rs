//! AOV files of a sequence with motion blur.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use exr::prelude::{FlatSamples, ReadChannels as _, ReadLayers as _};

/// A cube, node 5, rises by 1.8 m in the first second at constant speed. The field of view is 30°.
const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/animation/step_linear_cubic.gltf");
const CUBE_ID: f32 = 6.0;
/// Sine and cosine of half the tilt of the camera, from the rotation around X in the file.
const HALF_TILT: [f32; 2] = [0.016659722, 0.9998613];

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(folder: &Path, options: &str) {
    let run = Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .args(["render", SCENE, "-r", "80x45", "-f", "5-6", "--exr", "float,zip", "--layers", "all", "-q"])
        .args(options.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
}

/// The channels of a file.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn channels(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let values = |samples: &FlatSamples| samples.values_as_f32().collect();
    let list = &image.layer_data.channel_data.list;
    list.iter().map(|channel| (channel.name.to_string(), values(&channel.sample_data))).collect()
}

#[test]
fn an_open_shutter_blurs_light_and_coverage_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    render(folder.path(), "-o sharp.####.exr --samples 4");
    render(folder.path(), "-o blurred.####.exr --samples 4 --shutter 0.5 --time-samples 4");
    for frame in ["0005", "0006"] {
        let read = |name: &str| channels(&folder.path().join(format!("{name}.{frame}.exr")));
        let (sharp, blurred) = (read("sharp"), read("blurred"));
        for name in ["Z", "position.Y", "normal.X", "albedo.G", "forward.v", "backward.v", "node_id"] {
            assert!(sharp[name] == blurred[name], "{name} of frame {frame}");
        }
        for name in ["R", "A", "direct.R", "crypto_object00.G"] {
            assert_eq!(sharp[name] == blurred[name], name == "A", "{name} of frame {frame}");
        }
        for (pixel, red) in blurred["R"].iter().enumerate() {
            let parts = ["emission", "direct", "environment", "reflection", "refraction", "pass_through"];
            let sum: f32 = parts.iter().map(|part| blurred[&format!("{part}.R")][pixel]).sum();
            assert!((sum - red).abs() <= 1e-5 * red, "{sum} is not {red}");
        }
    }
}

#[test]
fn a_rising_cube_moves_by_its_displacement() {
    // The cube rises by 1.8 / 24 m a frame. In camera space up is (0, cos a, sin a): a point at (x, y, −1) Z moves
    // up by cos a and closer by sin a of that. Half of the 45 rows of the image is tan 15° at one metre.
    let [half_sine, half_cosine] = HALF_TILT;
    let (sine, cosine) = (2.0 * half_sine * half_cosine, 1.0 - 2.0 * half_sine * half_sine);
    let pixels_a_unit = 22.5 / libm::tanf(0.261_799_4);
    let folder = tempfile::tempdir().unwrap();
    render(folder.path(), "-o a.####.exr --samples 1");
    let channels = channels(&folder.path().join("a.0005.exr"));
    let mut pixels = 0;
    for (pixel, node) in channels["node_id"].iter().enumerate().filter(|(_, node)| **node == CUBE_ID) {
        let depth = channels["Z"][pixel];
        let x = ((pixel % 80) as f32 + 0.5 - 40.0) / pixels_a_unit;
        let y = (22.5 - (pixel / 80) as f32 - 0.5) / pixels_a_unit;
        let expected = |rise: f32| {
            let there = depth - rise * sine;
            [x * depth / there - x, (y * depth + rise * cosine) / there - y]
                .map(|moved| moved * pixels_a_unit)
        };
        for (direction, rise) in [("forward", 0.075), ("backward", -0.075)] {
            let moved = ["u", "v"].map(|axis| channels[&format!("{direction}.{axis}")][pixel]);
            let expected = expected(rise);
            let is_near = moved.iter().zip(expected).all(|(moved, expected)| (moved - expected).abs() < 1e-3);
            assert!(is_near, "{node}: {moved:?} is not {expected:?}");
        }
        pixels += 1;
    }
    assert!(pixels > 50, "{pixels}");
}
