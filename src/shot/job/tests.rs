use super::*;
use crate::error::Error;
use crate::film::PixelWindow;
use crate::render::Aperture;
use crate::settings::EnvironmentSource;

/// A folder with a scene, a shot in a folder of its own, and a suite file.
fn suite(shot: &str, suite: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/camera/perspective.gltf");
    std::fs::create_dir(folder.path().join("shots")).unwrap();
    std::fs::copy(scene, folder.path().join("shots/a.gltf")).unwrap();
    std::fs::write(folder.path().join("shots/a.toml"), shot).unwrap();
    std::fs::write(folder.path().join("suite.toml"), suite).unwrap();
    folder
}

fn job_of(folder: &Path, name: &str, overrides: &[&str]) -> Result<ShotJob> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let (path, suite) = (folder.join(name), folder.join("suite.toml"));
    shot_job(&ShotRequest { path: &path, suite: Some(&suite), overrides: &overrides })
}

#[test]
fn overrides_come_before_the_shot_before_the_suite_before_defaults() {
    let folder = suite(
        "scene = 'a.gltf'\nsamples = 3\ndepth = 3\nwidth = 32\n[test]\npreset = 'visual'\nwhatever = 1",
        "scenes = 'shots'\n[shot]\nsamples = 2\ndepth = 2\nglossy = 2\nresolution = [64, 36]\nframes = '0-2'\n[more]\nsampels = 1",
    );
    let ShotJob { sequence, warnings, .. } = job_of(folder.path(), "shots/a.toml", &["samples=4"]).unwrap();
    let render = &sequence.render;
    assert_eq!((render.samples, render.max_depth, render.glossy_samples), (4, 3, 2));
    // The suite's resolution cannot be said beside the shot's width; the height follows from the scene.
    assert_eq!(render.resolution.0, 32);
    assert_eq!(sequence.frames, [0, 1, 2]);
    assert_eq!(sequence.scene.path, folder.path().join("shots/a.gltf"));
    assert!(warnings.is_empty());
    // The scene without the shot file.
    let sequence = job_of(folder.path(), "shots/a.gltf", &["depth=5"]).unwrap().sequence;
    assert_eq!((sequence.render.samples, sequence.render.max_depth), (2, 5));
    assert_eq!(sequence.render.resolution, (64, 36));
    // Without a suite, and as the command line understands it.
    let path = folder.path().join("shots/a.toml");
    let alone = shot_job(&ShotRequest { path: &path, suite: None, overrides: &[] }).unwrap().sequence;
    assert_eq!(alone.render.samples, 3);
}

#[test]
fn shots_at_once_load_and_render_within_shares_of_the_memory() {
    let folder = suite("scene = 'a.gltf'\nresolution = [16, 9]\nmax_memory = '400M'", "");
    let path = folder.path().join("shots/a.toml");
    let request = ShotRequest { path: &path, suite: None, overrides: &[] };
    let jobs = |shots_at_once| {
        shot_jobs(&request, (ImageLoading::Texels, shots_at_once), |_, _| Ok(vec![ViewSettings::default()]))
    };
    for (shots_at_once, share) in [(1, 400_000_000), (4, 100_000_000)] {
        let job = jobs(shots_at_once).unwrap().remove(0).unwrap();
        assert_eq!(job.sequence.max_memory_bytes, share);
    }
    // The scene itself needs more than 400 bytes.
    assert!(matches!(jobs(1_000_000), Err(Error::Refused { .. })));
}

/// The other side follows from the camera, whose aspect ratio is 16:9.
#[test]
fn crops_give_way_to_one_stronger_side_where_they_reach_beyond_the_image() {
    let folder = suite("scene = 'a.gltf'\nresolution = [640, 320]\ncrop = [0, 0, 64, 32]", "");
    for (definition, window) in [
        ("width=64", PixelWindow { x0: 0, y0: 0, x1: 64, y1: 32 }),
        ("height=400", PixelWindow { x0: 0, y0: 0, x1: 64, y1: 32 }),
        ("width=62", PixelWindow::full(62, 35)),
        ("width=54", PixelWindow::full(54, 30)),
        ("height=31", PixelWindow::full(55, 31)),
    ] {
        let sequence = job_of(folder.path(), "shots/a.toml", &[definition]).unwrap().sequence;
        assert_eq!(sequence.render.window, window, "{definition}");
    }
    // A stronger crop is wrong, and so is one beside the size in the same file.
    let text = "crop=[0,0,64,32]";
    for (shot, overrides) in [
        ("scene = 'a.gltf'\nheight = 31", &[text][..]),
        ("scene = 'a.gltf'", &[text, "width=62"]),
        ("scene = 'a.gltf'\nwidth = 62\ncrop = [0, 0, 64, 32]", &[]),
    ] {
        let folder = suite(shot, "");
        let error = job_of(folder.path(), "shots/a.toml", overrides).unwrap_err();
        let message = "0,0,64,32 reaches beyond the image of ";
        assert!(error.to_string().contains(message), "{error}");
    }
}

#[test]
fn orthographic_cameras_have_f_numbers_where_a_field_of_view_makes_them_perspective() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/camera/orthographic.gltf");
    let job = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
        shot_job(&ShotRequest { path: &scene, suite: None, overrides: &overrides })
    };
    for lens in ["fov=40", "focal_length=35"] {
        let render = job(&["aperture=f/2.8", lens]).unwrap().sequence.render;
        assert_eq!(render.lens.unwrap().aperture, Aperture::FNumber(2.8), "{lens}");
    }
    let error = job(&["aperture=f/2.8"]).unwrap_err();
    assert!(error.to_string().contains("an orthographic camera has no f-number"), "{error}");
    assert!(job(&["aperture=0.1"]).is_ok());
}

#[test]
fn a_suite_names_files_from_its_own_folder() {
    let folder =
        suite("scene = 'a.gltf'", "[shot]\nenv = 'sky.hdr@90'\nbackground = 'none'\nmanifest = 'm.json'");
    let path = folder.path().join("shots/a.toml");
    let suite = folder.path().join("suite.toml");
    let read = |overrides: &[String]| {
        shot_settings(&ShotRequest { path: &path, suite: Some(&suite), overrides }).unwrap()
    };
    let shot = read(&[]);
    let env = |shot: &ShotSettings| shot.values.env.as_ref().map(EnvironmentSource::to_text);
    assert_eq!(env(&shot), Some(folder.path().join("sky.hdr@90").into_os_string()));
    assert_eq!(shot.values.manifest, Some(folder.path().join("m.json")));
    assert_eq!(shot.scene, folder.path().join("shots/a.gltf"));
    // What is said beside them is named from the current folder, as after -D.
    assert_eq!(env(&read(&["env=sea.hdr".to_owned()])), Some("sea.hdr".into()));
}

#[test]
fn mistakes_in_a_suite_are_named_with_file_and_line() {
    let good = "scene = 'a.gltf'";
    for (shot, suite_text, file, words) in [
        (good, "[shot]\nsampels = 4", "suite.toml", &["suite.toml:2:1: \"sampels\"", "\"samples\"?"][..]),
        (good, "[shot]\n\nsamples = 0", "suite.toml", &["suite.toml:3:1: samples: write a whole number"]),
        (good, "[shot]\nscene = 'b.gltf'", "suite.toml", &[":2:1: \"scene\" differs from shot to shot"]),
        (good, "\nshot = 4", "suite.toml", &[":2:1: shot: expected [shot]"]),
        (good, "[[shot]]\nsamples = 4", "suite.toml", &[":1:3: shot: expected [shot]"]),
        (good, "[shot]\n[shot.test]\nmean = 1", "suite.toml", &[":2:7: \"test\" is a table"]),
        (good, "[shot]\ntime_samples = 4", "suite.toml", &[":2:1: time_samples: ", "`shutter`"]),
        (good, "[shot]\nfps = 0", "suite.toml", &[":2:1: fps: "]),
        (good, "[shot]\ncamera = 'nobody'", "suite.toml", &[":2:1: camera: "]),
        (good, "[shot", "suite.toml", &[":1:"]),
        // Also where the shot says something else, for then it is wrong for the next one.
        ("scene = 'a.gltf'\nsamples = 1", "[shot]\nsamples = 0", "suite.toml", &[":2:1: samples: "]),
        ("scene = 'a.gltf'\nfps = 0", "[shot]\nfps = 25", "a.toml", &[":2:1: fps: "]),
        ("scene = 'a.gltf'\n[limits]", "", "a.toml", &[":2:2: \"limits\" is a table"]),
        ("scene = 'a.gltf'\ntest = 1", "", "a.toml", &[":2:1: \"test\" is no setting"]),
        ("samples = 1\n[test]\nscene = 'a.gltf'", "", "a.toml", &["names no scene"]),
        // The others would do without the suite's line, which counts least.
        ("scene = 'a.gltf'\nresume = true", "\n\n\n[shot]\ntime_samples = 2", "suite.toml", &[":5:1: "]),
    ] {
        let folder = suite(shot, suite_text);
        let error = job_of(folder.path(), "shots/a.toml", &[]).unwrap_err();
        assert_eq!(error.exit_code(), 65, "{suite_text}: {error}");
        for word in [file].iter().chain(words) {
            assert!(error.to_string().contains(word), "{suite_text}: {error}");
        }
        assert!(!error.to_string().contains('\n'), "{error}");
    }
    let folder = suite(good, "[shot]");
    let error = job_of(folder.path(), "shots/a.toml", &["sampels=4"]).unwrap_err();
    assert!(error.to_string().contains("-D sampels=4") && error.exit_code() == 2, "{error}");
    let error = job_of(folder.path(), "shots/b.gltf", &[]).unwrap_err();
    assert_eq!(error.exit_code(), 66, "{error}");
    std::fs::remove_file(folder.path().join("suite.toml")).unwrap();
    let error = job_of(folder.path(), "shots/a.toml", &[]).unwrap_err();
    assert!(error.to_string().contains("suite.toml") && error.exit_code() == 66, "{error}");
}

#[test]
fn what_is_not_honoured_is_a_warning_or_an_error() {
    let folder = suite("scene = 'a.gltf'", "");
    let scene = folder.path().join("shots/a.gltf");
    let text = std::fs::read_to_string(&scene).unwrap();
    let used = "\"extensionsUsed\": [";
    assert!(text.contains(used));
    let text = text.replacen(used, &format!("{used}\"ACME_fur\", "), 1);
    std::fs::write(&scene, text).unwrap();
    let warnings = job_of(folder.path(), "shots/a.toml", &[]).unwrap().warnings;
    assert!(warnings.iter().any(|warning| warning.message.contains("ACME_fur")), "{warnings:?}");
    let error = job_of(folder.path(), "shots/a.toml", &["strict=true"]).unwrap_err();
    assert!(error.to_string().contains("ACME_fur") && error.exit_code() == 65, "{error}");
}

#[test]
fn a_framed_node_does_nothing_where_position_and_target_are_given() {
    let folder = suite("scene = 'a.gltf'", "");
    let path = folder.path().join("shots/a.gltf");
    let settings = |given: &[&str]| {
        let definitions: Vec<String> = given.iter().map(ToString::to_string).collect();
        let shot = ShotSettings::read_with(&path, Settings::read_definitions(&definitions).unwrap()).unwrap();
        resolve(&shot, ImageLoading::Texels).unwrap()
    };
    let warnings = |given: &[&str]| {
        let choices = settings(given).choices.into_iter().map(|warning| warning.message);
        choices.filter(|message| message.contains("frame_node")).collect::<Vec<_>>()
    };
    let (node, position, target) = ("frame_node=#0", "camera_position=0,1,5", "look_at=0,0,0");
    let told = "`frame_node` does nothing: `camera_position` and `look_at` decide what is seen";
    assert_eq!(warnings(&[node, position, target]), [told]);
    let camera = |given: &[&str]| settings(given).sequence.selection.camera;
    assert_eq!(camera(&[node, position, target]), camera(&[position, target]));
    for given in [&[node, position][..], &[node, target], &[position, target], &[node]] {
        assert_eq!(warnings(given), [""; 0], "{given:?}");
    }
    // Of a camera that is kept it removes the near and far plane.
    let kept = ["camera=#0", position, target];
    assert_eq!(warnings(&[&kept[..], &[node]].concat()), [""; 0]);
    assert_ne!(camera(&[&kept[..], &[node]].concat()), camera(&kept));
}

#[test]
fn strict_ignores_what_only_other_variants_have() {
    let text = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_variants", "KHR_materials_anisotropy"],
        "extensions": {"KHR_materials_variants": {"variants": [{"name": "plain"}, {"name": "brushed"}]}},
        "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "extensions":
            {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}}}]}],
        "materials": [{}, {"extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri":
            "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;
    let folder = suite("scene = 'a.gltf'", "");
    std::fs::write(folder.path().join("shots/a.gltf"), text).unwrap();
    let job = |variant: Option<&str>| {
        let variant = variant.map(|name| format!("variant={name}"));
        let overrides: Vec<_> = std::iter::once("strict=true").chain(variant.as_deref()).collect();
        job_of(folder.path(), "shots/a.toml", &overrides)
    };
    for variant in [None, Some("plain")] {
        assert!(job(variant).unwrap().warnings.is_empty(), "{variant:?}");
    }
    let error = job(Some("brushed")).unwrap_err();
    assert!(error.to_string().contains("anisotropy has no direction"), "{error}");
}

#[test]
fn the_scene_of_a_shot_is_found_whatever_else_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, "sampels = 0\nscene = 'sub/a.glb'\n[limits]").unwrap();
    assert_eq!(scene_of_shot(&path).unwrap(), folder.path().join("sub/a.glb"));
    for (text, word) in [
        ("samples = 1", "names no scene"),
        ("\nscene = 4", ":2:1: scene: expected a text in quotes, found a number"),
        ("\nscene = ", ":2:"),
    ] {
        std::fs::write(&path, text).unwrap();
        let error = scene_of_shot(&path).unwrap_err();
        assert!(error.to_string().contains(word) && error.exit_code() == 65, "{error}");
    }
    assert_eq!(scene_of_shot(Path::new("nobody.toml")).unwrap_err().exit_code(), 66);
}
