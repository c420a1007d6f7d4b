//! The façade: equal bytes in memory and in sequences, settings, errors.

use rayframe::output::Aov;
use rayframe::sequence::SequenceEvent;
use rayframe::settings::EnvironmentSource;
use rayframe::{Error, Renderer};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");

#[expect(clippy::unwrap_used, reason = "a helper of tests")]
fn small() -> Renderer {
    Renderer::open(SCENE).unwrap().size(24, 16).samples(1)
}

#[test]
fn a_frame_in_memory_and_a_frame_of_a_sequence_have_equal_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let renderer = small().aovs([Aov::Depth, Aov::Motion, Aov::CryptoObject]).set("frames", "7-8").unwrap();
    let written = std::sync::Mutex::new(Vec::new());
    let sequence = renderer.sequence(folder.path().join("a.####.exr")).unwrap();
    assert_eq!(sequence.frames(), [7, 8]);
    let summary = sequence
        .run(|event| {
            if let SequenceEvent::FrameWritten(report) = event {
                written.lock().unwrap().push(report.frame);
            }
        })
        .unwrap();
    assert_eq!((written.into_inner().unwrap().as_slice(), summary.written.len()), ([7, 8].as_slice(), 2));

    let frame = renderer.frame(8).unwrap();
    let alone = folder.path().join("alone.exr");
    frame.write_exr(&alone).unwrap();
    assert_eq!(std::fs::read(alone).unwrap(), std::fs::read(folder.path().join("a.0008.exr")).unwrap());
    let image = frame.image().unwrap();
    assert!(image.channel("Z").is_some() && image.channel("forward.u").is_some());
}

#[test]
fn pixels_are_linear_and_row_major() {
    let frame =
        small().set("background", "0.25,0.5,1").unwrap().set("camera", "auto").unwrap().frame(0).unwrap();
    assert_eq!((frame.size(), frame.pixels().len(), frame.number()), ((24, 16), 24 * 16, 0));
    assert_eq!(frame.pixel(3, 2), Some(frame.pixels()[2 * 24 + 3]));
    assert_eq!((frame.pixel(24, 0), frame.pixel(0, 16)), (None, None));
}

#[test]
fn the_environment_changes_the_image() {
    let none = small().environment(EnvironmentSource::None).frame(0).unwrap();
    let white = small().environment(EnvironmentSource::Constant([1.0; 3])).frame(0).unwrap();
    assert_ne!(none.pixels(), white.pixels());
}

#[test]
fn a_misspelled_setting_is_an_error_with_the_closest_name() {
    let error = small().set("sampels", "4").unwrap_err();
    let Error::Setting(error) = error else { panic!("{error}") };
    assert_eq!(error.setting, "sampels");
    assert!(error.why.contains("\"samples\""), "{}", error.why);
}

#[test]
fn a_setting_that_the_scene_cannot_honour_is_an_error_of_the_render() {
    let error = small().set("camera", "no such camera").unwrap().frame(0).unwrap_err();
    assert!(error.to_string().contains("no such camera"), "{error}");
    assert!(matches!(Renderer::open("no such file.glb"), Err(Error::Missing { .. })));
}
