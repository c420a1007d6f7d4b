//! The façade: equal bytes in memory and in sequences, settings, errors.

use glam::Vec3;
use rayframe::error::Provenance;
use rayframe::output::Aov;
use rayframe::scene::BuiltInLight;
use rayframe::sequence::SequenceEvent;
use rayframe::settings::{EnvironmentSource, Settings};
use rayframe::{Error, Renderer};
use scene_builder::document::Gltf;
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::cuboid;
use scene_builder::staging::directional_light;

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
fn images_of_one_pixel_are_rendered() {
    for integrator in ["whitted", "path"] {
        let one =
            Renderer::open(SCENE).unwrap().size(1, 1).samples(16).set("integrator", integrator).unwrap();
        let frame = one.aovs([Aov::Depth, Aov::Motion, Aov::CryptoObject]).frame(0).unwrap();
        let [[red, green, blue, alpha]] = frame.pixels() else { panic!("{} pixels", frame.pixels().len()) };
        assert!([red, green, blue].iter().all(|value| value.is_finite() && **value > 0.0), "{integrator}");
        assert!((0.0..=1.0).contains(alpha));
        assert_eq!(frame.image().unwrap().size(), (1, 1));
    }
}

#[test]
fn every_built_in_light_renders_its_own_image() {
    let image = |light| {
        let frame = small().environment(EnvironmentSource::BuiltIn(light)).frame(0).unwrap();
        let pixels = frame.pixels().to_vec();
        assert!(pixels.iter().flatten().all(|value| value.is_finite()), "{light:?}");
        pixels
    };
    let images = BuiltInLight::ALL.map(image);
    for (index, pixels) in images.iter().enumerate() {
        assert!(images[..index].iter().all(|other| other != pixels), "{:?}", BuiltInLight::ALL[index]);
        assert_eq!(*pixels, image(BuiltInLight::ALL[index]));
    }
}

#[test]
fn pixels_are_linear_and_row_major() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/texture/vertex_color.gltf");
    let renderer = Renderer::open(scene).unwrap().size(24, 16).samples(1).set("camera", "auto").unwrap();
    let frame = renderer.set("background", "0.25,0.5,1").unwrap().frame(0).unwrap();
    assert_eq!((frame.size(), frame.pixels().len(), frame.number()), ((24, 16), 24 * 16, 0));
    assert_eq!(frame.pixel(3, 2), Some(frame.pixels()[2 * 24 + 3]));
    // The background shows beside the scene as it is given.
    assert_eq!(frame.pixel(0, 0), Some([0.25, 0.5, 1.0, 1.0]));
    assert_ne!(frame.pixel(12, 8), frame.pixel(0, 0));
    assert_eq!((frame.pixel(24, 0), frame.pixel(0, 16)), (None, None));
}

#[test]
fn an_environment_adds_its_light() {
    let lit_by = |environment| small().environment(environment).frame(0).unwrap().pixels().to_vec();
    let [none, white] = [EnvironmentSource::None, EnvironmentSource::Constant([1.0; 3])].map(lit_by);
    let pairs = || none.iter().zip(&white).flat_map(|(none, white)| none.iter().zip(white));
    assert!(pairs().all(|(none, white)| white >= none));
    let lit = pairs().filter(|(none, white)| white > none).count();
    assert!(lit > none.len(), "{lit}");
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
    let error = small().set("variant", "each").unwrap().frame(0).unwrap_err();
    assert!(error.to_string().contains("each makes several sequences"), "{error}");
    assert!(matches!(Renderer::open("no such file.glb"), Err(Error::Missing { .. })));
}

#[test]
fn values_that_make_no_sense_are_errors_of_the_render() {
    let refused = |renderer: &Renderer, frame: i64, setting: &str| {
        let error = renderer.frame(frame).unwrap_err();
        assert!(matches!(&error, Error::Setting(error) if error.setting == setting), "{setting}: {error}");
        assert_eq!(error.exit_code(), 2);
    };
    for (width, height) in [(0, 0), (0, 9), (9, 0)] {
        refused(&small().size(width, height), 0, "resolution");
    }
    for samples in [0, 65_537] {
        refused(&small().samples(samples), 0, "samples");
    }
    let range = small().set("integrator", "path").unwrap().set("sample_range", "0-3").unwrap();
    refused(&range.samples(0), 0, "samples");
    for frame in [3_000_000_000, -3_000_000_000] {
        refused(&small(), frame, "frames");
    }
    let mut renderer = small();
    renderer.settings_mut().light_scale = Some(f32::NAN.into());
    refused(&renderer, 0, "light_scale");
    // No AOVs are an empty list.
    assert!(small().aovs([]).frame(0).is_ok());
}

#[test]
fn files_beside_the_frames_replace_none_of_other_programs() {
    let folder = tempfile::tempdir().unwrap();
    for (setting, name) in [("contact_sheet", "sheet.png"), ("movie", "movie.gif")] {
        let (frames, file) = (folder.path().join(setting), folder.path().join(name));
        std::fs::write(&file, "of another program").unwrap();
        let renderer = small().set("frames", "0-1").unwrap().set(setting, &file).unwrap();
        let run = |renderer: &Renderer| renderer.sequence(frames.join("a.#.png")).unwrap().run(|_| ());
        let error = run(&renderer).unwrap_err();
        assert!(matches!(&error, Error::CannotCreate { path, .. } if *path == file), "{setting}: {error}");
        assert_eq!(std::fs::read(&file).unwrap(), b"of another program");
        assert!(!frames.exists(), "{setting}");

        let overwriting = renderer.clone().set("overwrite", "true").unwrap();
        run(&overwriting).unwrap();
        assert_ne!(std::fs::read(&file).unwrap(), b"of another program");
        // Its own file may be replaced.
        run(&renderer).unwrap();
    }
}

#[test]
fn folders_of_files_beside_the_frames_are_checked_before_the_first_frame() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let sheet = folder.path().join("file/sheet.png");
    let renderer = small().set("frames", "0-1").unwrap().set("contact_sheet", sheet).unwrap();
    let sequence = renderer.sequence(folder.path().join("a.#.png")).unwrap();
    let error = sequence.run(|_| ()).unwrap_err();
    assert!(matches!(error, Error::CannotCreate { .. }), "{error}");
    assert!(!folder.path().join("a.0.png").exists());
}

#[test]
fn sequences_are_checked_as_by_the_program_before_the_first_frame() {
    let folder = tempfile::tempdir().unwrap();
    let sky = folder.path().join("sky.exr");
    small().frame(0).unwrap().write_exr(&sky).unwrap();
    let before = std::fs::read(&sky).unwrap();
    let one = small().set("frames", "0").unwrap().set("overwrite", "true").unwrap();

    let over_input = one.clone().set("env", &sky).unwrap().sequence(&sky).unwrap().run(|_| ()).unwrap_err();
    assert!(over_input.to_string().contains("is an input"), "{over_input}");
    assert_eq!(std::fs::read(&sky).unwrap(), before);

    let movie = one.set("movie", folder.path().join("a.mkvv")).unwrap();
    let error = movie.sequence(folder.path().join("a.exr")).unwrap().run(|_| ()).unwrap_err();
    assert!(matches!(&error, Error::Setting(error) if error.setting == "movie"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn the_exposure_that_a_frame_was_rendered_by_is_not_measured_again() {
    let folder = tempfile::tempdir().unwrap();
    let [first, again, measured] = ["a.png", "b.png", "c.png"].map(|name| folder.path().join(name));
    let by_noise = |noise: Option<&str>| {
        let cancel = rayframe::cancel::CancelFlag::new();
        let mut renderer = small().set("integrator", "path").unwrap().cancelled_by(&cancel);
        if let Some(noise) = noise {
            renderer = renderer.set("noise", noise).unwrap();
        }
        (renderer.frame(0).unwrap(), cancel)
    };
    let (frame, cancel) = by_noise(Some("0.5"));
    frame.write_png(&first).unwrap();
    // Measuring would be interrupted.
    cancel.raise();
    frame.write_png(&again).unwrap();
    assert_eq!(std::fs::read(&first).unwrap(), std::fs::read(&again).unwrap());
    let (frame, cancel) = by_noise(None);
    cancel.raise();
    assert!(matches!(frame.write_png(&measured), Err(Error::Interrupted(_))));
}

#[test]
fn strict_refuses_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("glow.gltf");
    let text = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{}],
        "extensionsUsed": ["ACME_glow"]}"#;
    std::fs::write(&scene, text).unwrap();
    let renderer = Renderer::open(&scene).unwrap().size(4, 4);
    assert_eq!(renderer.warnings().len(), 1);
    assert!(renderer.frame(0).is_ok());
    let error = renderer.set("strict", "true").unwrap().frame(0).unwrap_err();
    assert!(
        matches!(&error, Error::Unsupported { .. }) && error.to_string().contains("ACME_glow"),
        "{error}"
    );
}

#[test]
fn pixels_that_are_not_finite_are_a_warning_of_the_frame_or_an_error() {
    let mut scene = Gltf::new("a lamp beyond the largest number");
    let material = Material::matte("grey", [0.5; 3]).add_to(&mut scene);
    let mesh = cuboid(1.0, 1.0, 1.0).add_to(&mut scene, material);
    scene.node(Node::mesh(mesh));
    directional_light(&mut scene, Vec3::new(0.0, 0.0, 1.0), 3e38);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, scene.to_file_text()).unwrap();
    let renderer = Renderer::open(&path).unwrap().size(8, 8).samples(1).set("light_scale", "1000").unwrap();

    let frame = renderer.frame(0).unwrap();
    let messages: Vec<_> = frame.warnings().iter().map(|warning| warning.message.as_str()).collect();
    assert!(messages.iter().any(|message| message.contains("pixels were infinite")), "{messages:?}");
    assert!(frame.pixels().iter().flatten().all(|value| value.is_finite()));
    let error = renderer.set("strict", "true").unwrap().frame(0).unwrap_err();
    assert_eq!(error.exit_code(), 70, "{error}");
    assert!(small().frame(0).unwrap().warnings().is_empty());
}

#[test]
fn the_size_replaces_other_settings_of_it() {
    let renderer = small().set("scale", "50%").unwrap().set("width", "9").unwrap().size(6, 4);
    assert_eq!(renderer.frame(0).unwrap().size(), (6, 4));
    let smaller = renderer.set("scale", "50%").unwrap();
    assert_eq!(smaller.frame(0).unwrap().size(), (3, 2));
}

#[test]
fn settings_of_the_import_are_given_when_a_scene_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["scene", "shared"] {
        std::fs::create_dir(at(name)).unwrap();
    }
    let positions: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = positions.iter().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(at("shared/a.bin"), bytes).unwrap();
    let text = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "../shared/a.bin", "byteLength": 36}]}"#;
    let scene = at("scene/a.gltf");
    std::fs::write(&scene, text).unwrap();
    let shot = at("scene/a.toml");
    std::fs::write(&shot, "scene = 'a.gltf'\nallow_dir = '../shared'\nresolution = [8, 6]\n").unwrap();

    let opened = |path: &std::path::Path, name: &str, value: &std::ffi::OsStr| {
        let mut settings = Settings::default();
        settings.set(name, value, &Provenance::Library).unwrap();
        Renderer::open_with(path, settings)
    };
    assert!(matches!(Renderer::open(&scene), Err(Error::Refused { .. })));
    let allowed = opened(&scene, "allow_dir", at("shared").as_os_str()).unwrap();
    assert!(allowed.size(4, 3).samples(1).frame(0).is_ok());
    assert!(matches!(opened(SCENE.as_ref(), "max_memory", "1K".as_ref()), Err(Error::Refused { .. })));
    // Over the settings of a shot file, whose others stay.
    let small = opened(&shot, "scale", "50%".as_ref()).unwrap();
    assert_eq!(small.samples(1).frame(0).unwrap().size(), (4, 3));
    let sized = opened(&shot, "resolution", "2x2".as_ref()).unwrap();
    assert_eq!(sized.samples(1).frame(0).unwrap().size(), (2, 2));
}
