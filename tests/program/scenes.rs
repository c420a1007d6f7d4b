//! `rayframe info`, names in scenes, and warnings about unsupported or ineffective content.

use crate::cli::assert_fails;
use crate::progress::schema::Schema;
use crate::{both, rayframe, stderr};

#[test]
fn a_variant_changes_the_image_and_unknown_ones_are_listed() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/material/variants.gltf");
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, options: &[&str]| {
        let path = folder.path().join(name);
        let output = path.to_str().unwrap();
        let arguments = [&["render", scene, "-r", "16x9", "--samples", "1", "-q", "-o", output], options];
        let done = rayframe(&arguments.concat());
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        rayframe::regression::Image::read(&path).unwrap().rgba().unwrap()
    };
    let own = render("own.exr", &[]);
    let red = render("red.exr", &["--variant", "red"]);
    let gold = render("gold.exr", &["--variant", "#1"]);
    // The box left of the centre is white, red, and white again, as "gold" is for the ball alone.
    let box_at = 4 * 16 + 5;
    let [own_box, red_box, gold_box] = [&own, &red, &gold].map(|pixels| pixels[box_at]);
    assert!(own_box[1] > 0.2 && red_box[1] < 0.2 * red_box[0], "{own_box:?} {red_box:?}");
    assert_eq!(own_box, gold_box);
    assert!(own != gold && red != gold);

    assert_fails(&["render", scene, "--variant", "blue"], 2, "there is no variant \"blue\"; ");
    assert_fails(&["render", scene, "--variant", "blue"], 2, "#0 \"red\", #1 \"gold\"");
    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    assert!(shown.contains("variants:\n  #0 \"red\"\n  #1 \"gold\"\n"), "{shown}");
    assert!(shown.contains("KHR_materials_variants: supported"), "{shown}");
}

#[test]
fn info_lists_everything_with_its_support() {
    let folder = tempfile::tempdir().unwrap();
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let text = std::fs::read_to_string(root.join("animation/pointer_light_camera.gltf")).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(&text).unwrap();
    // One of three channels has a missing target, one texture is unused, and one extension is unknown.
    document["animations"][0]["channels"][0]["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
        "/materials/9/alphaCutoff".into();
    document["textures"] = serde_json::json!([{}]);
    document["extensionsUsed"].as_array_mut().unwrap().push("ACME_glow".into());
    let scene = folder.path().join("a.gltf");
    std::fs::write(&scene, document.to_string()).unwrap();
    let scene = scene.to_str().unwrap();

    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    for line in [
        "1 s, 2 channels, 1 more left out, supported in part",
        "spot, supported",
        "perspective, supported",
        "1 more that nothing looks up",
        "KHR_animation_pointer: supported",
        "ACME_glow: not supported, left out",
        "/materials/9/alphaCutoff",
    ] {
        assert!(shown.contains(line), "{line} is not in\n{shown}");
    }
    let output = rayframe(&["info", "--json", scene]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    Schema::read("info").check(&report);
    assert_eq!(report["schema"], 2);
    assert_eq!(report["clips"][0]["ignored_channels"], 1);
    assert_eq!(report["clips"][0]["support"], "supported in part");
    assert_eq!(report["lights"][0]["support"], "supported");
    assert_eq!(report["cameras"][0]["support"], "supported");
    assert_eq!(report["unused_textures"], 1);

    let scene = root.join("light/image_based.gltf");
    let shown = String::from_utf8_lossy(&rayframe(&["info", scene.to_str().unwrap()]).stdout).into_owned();
    assert!(shown.contains("cube of 16x16 texels, 3 levels, supported"), "{shown}");
}

#[test]
fn the_json_of_every_scene_is_that_of_its_schema() {
    let schema = Schema::read("info");
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let folders = std::fs::read_dir(&root).unwrap().map(|entry| entry.unwrap().path());
    let files = folders.filter(|path| path.is_dir()).flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let mut reports = 0;
    for path in files.map(|entry| entry.unwrap().path()) {
        if matches!(path.extension().and_then(|extension| extension.to_str()), Some("gltf" | "glb")) {
            let output = rayframe(&["info", "--json", path.to_str().unwrap()]);
            assert_eq!(output.status.code(), Some(0), "{}: {}", path.display(), stderr(&output));
            schema.check(&serde_json::from_slice(&output.stdout).unwrap());
            reports += 1;
        }
    }
    assert!(reports > 50, "{reports}");
}

#[test]
fn many_large_textures_are_refused_by_their_total_and_shown_without_decoding_them() {
    let folder = tempfile::tempdir().unwrap();
    let first = folder.path().join("t0.png");
    image::GrayImage::new(4096, 4096).save(&first).unwrap();
    for index in 1..20 {
        std::fs::copy(&first, folder.path().join(format!("t{index}.png"))).unwrap();
    }
    let numbered = |value: &dyn Fn(usize) -> serde_json::Value| (0..20).map(value).collect::<Vec<_>>();
    let document = serde_json::json!({
        "asset": {"version": "2.0"},
        "images": numbered(&|index| serde_json::json!({"uri": format!("t{index}.png")})),
        "textures": numbered(&|index| serde_json::json!({"source": index})),
        "materials": numbered(&|index| serde_json::json!({"normalTexture": {"index": index}})),
    });
    let path = folder.path().join("walls.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    let scene = path.to_str().unwrap();
    let output = folder.path().join("a.exr");
    let output = output.to_str().unwrap();

    // 20 · 89 478 484 bytes, and 89 478 480 while the last mip maps are made.
    // More threads decode more images at once.
    let render = ["render", scene, "-o", output, "-t", "1", "--max-memory", "500M"];
    for word in
        ["20 images need 1.9 GB with mip maps", "/images/0 \"t0.png\" with 89.5 MB", "limit of 500.0 MB"]
    {
        assert_fails(&render, 77, word);
    }
    // A render checks memory before it decodes textures; `info` does not decode them.
    // One band of it needs more.
    let huge = ["-r", "900000x900000"];
    assert_fails(&[&render[..], &huge].concat(), 77, "900000x900000 pixels need about");
    assert_fails(&[&render[..], &["--dry-run"]].concat(), 77, "20 images need 1.9 GB");
    let planned = rayframe(&["render", scene, "-o", output, "-t", "1", "--max-memory", "2G", "--dry-run"]);
    assert_eq!(planned.status.code(), Some(0), "{}", stderr(&planned));
    let shown = rayframe(&["info", scene, "--max-memory", "100M"]);
    let text = String::from_utf8_lossy(&shown.stdout).into_owned();
    assert!(
        text.contains("#19 4096x4096, 8 bits") || text.contains("\"t19.png\" 4096x4096, 8 bits"),
        "{text}"
    );
}

#[test]
fn unlikely_settings_are_warned_about() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.exr");
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/");
    let said = |scene: &str, options: &[&str]| {
        let scene = format!("{root}{scene}");
        let arguments = ["render", &scene, "-o", output.to_str().unwrap(), "-r", "16x9", "--overwrite"];
        let done = rayframe(&[&arguments[..], &["--samples", "1", "-f", "0"], options].concat());
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        stderr(&done)
    };
    // A mirror in the centre of the image, and a depth limit of 0.
    let cut = said("material/mirror.gltf", &["--depth", "0"]);
    assert!(cut.contains(" % of the light was cut off at depth 0: raise --depth"), "{cut}");
    assert!(!said("material/diffuse.gltf", &["--depth", "0"]).contains("cut off"));

    // The same camera behind all objects.
    let text = std::fs::read_to_string(format!("{root}material/diffuse.gltf")).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(&text).unwrap();
    for node in document["nodes"].as_array_mut().unwrap() {
        if node.get("camera").is_some() {
            *node = serde_json::json!({"name": "lost", "camera": 0, "translation": [0, 0, -1000]});
        }
    }
    let scene = folder.path().join("lost.gltf");
    std::fs::write(&scene, document.to_string()).unwrap();
    let arguments =
        ["render", scene.to_str().unwrap(), "-o", output.to_str().unwrap(), "-r", "16x9", "--overwrite"];
    let lost = stderr(&rayframe(&arguments));
    assert!(lost.contains("warning: camera \"") && lost.contains("sees nothing in frame 0"), "{lost}");
    // A camera at a given position is neither one of the file nor an automatic one.
    let away = ["--camera-position", "0,50,0", "--look-at", "0,100,1"];
    let lost = stderr(&rayframe(&[&arguments[..], &away].concat()));
    assert!(lost.contains("warning: the camera sees nothing in frame 0"), "{lost}");
}

#[test]
fn names_of_nodes_are_listed_and_suggested() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/environment/shadow_catcher.gltf");
    let render = ["render", scene, "--dry-run", "-o", "unwritten.exr"];
    assert_fails(&both(&render, &["--shadow-catcher", "flor"]), 2, "did you mean \"floor\"?");
    assert_fails(&both(&render, &["--aperture", "0.1", "--focus", "flor"]), 2, "did you mean \"floor\"?");
    assert_fails(
        &both(&render, &["--aperture", "0.1", "--focus", "-1"]),
        2,
        "a distance lies above 0 metres",
    );
    assert_fails(&both(&render, &["--shadow-catcher", "#999"]), 2, "\"floor\"");

    let shown = rayframe(&["info", "--json", scene]);
    let report: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    let nodes = report["holding_nodes"].as_array().unwrap();
    let floor = nodes.iter().find(|node| node["name"] == "floor").unwrap();
    assert_eq!(floor["holds"], serde_json::json!(["mesh"]));
    let by_number = format!("#{}", floor["index"]);
    let done = rayframe(&both(&render, &["--shadow-catcher", &by_number, "--background", "none"]));
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    assert!(stderr(&done).contains("background none"), "{}", stderr(&done));
    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    assert!(shown.contains(&format!("  {by_number} \"floor\" mesh\n")), "{shown}");
}

#[test]
fn every_node_that_an_option_takes_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("joints.gltf");
    // More nodes than a message lists.
    let mut nodes = vec![serde_json::json!({"name": "lens", "camera": 0}), serde_json::json!({})];
    nodes.extend((2..32).map(|i| serde_json::json!({"name": format!("joint{i}")})));
    let roots: Vec<usize> = (0..nodes.len()).collect();
    let document = serde_json::json!({"asset": {"version": "2.0"}, "scenes": [{"nodes": roots}], "nodes": nodes,
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]});
    std::fs::write(&scene, document.to_string()).unwrap();
    let scene = scene.to_str().unwrap();

    let refused = rayframe(&["render", scene, "--dry-run", "--look-at", "head"]);
    let message = stderr(&refused);
    assert!(message.contains(" and 11 more, which rayframe info --json lists"), "{message}");
    let shown = rayframe(&["info", "--json", scene]);
    let report: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    assert_eq!(report["holding_nodes"].as_array().unwrap().len(), 1);
    let others = report["other_nodes"].as_array().unwrap();
    let expected: Vec<_> =
        (2..32).map(|i| serde_json::json!({"index": i, "name": format!("joint{i}")})).collect();
    assert_eq!(*others, expected);
}

#[test]
fn clips_that_do_not_begin_at_0_are_told_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/morph/weights.gltf");
    let mut document: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    // Key times of 1 s and 2.5 s
    let times: Vec<u8> = [1.0_f32, 2.5].iter().flat_map(|seconds| seconds.to_le_bytes()).collect();
    std::fs::write(folder.path().join("times.bin"), times).unwrap();
    let add = |list: &mut serde_json::Value, item: serde_json::Value| {
        list.as_array_mut().unwrap().push(item);
        list.as_array().unwrap().len() - 1
    };
    let buffer = serde_json::json!({"uri": "times.bin", "byteLength": 8});
    let buffer = add(&mut document["buffers"], buffer);
    let view = serde_json::json!({"buffer": buffer, "byteLength": 8});
    let view = add(&mut document["bufferViews"], view);
    let accessor = serde_json::json!({"bufferView": view, "componentType": 5126, "count": 2, "type": "SCALAR",
        "min": [1.0], "max": [2.5]});
    let accessor = add(&mut document["accessors"], accessor);
    document["animations"][0]["samplers"][0]["input"] = accessor.into();
    let scene = folder.path().join("a.gltf");
    std::fs::write(&scene, document.to_string()).unwrap();
    let scene = scene.to_str().unwrap();

    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    assert!(shown.contains("#0 \"grow\" 1 s to 2.5 s, 1 channel, supported\n"), "{shown}");
    let report: serde_json::Value =
        serde_json::from_slice(&rayframe(&["info", "--json", scene]).stdout).unwrap();
    assert_eq!(report["clips"][0]["start_seconds"], 1.0);
    let done = rayframe(&["render", scene, "--dry-run", "-o", "unwritten.####.exr"]);
    let first = "a.gltf: clip \"grow\" 1 s to 2.5 s → frames 0-60 at 24 fps";
    assert!(stderr(&done).contains(first), "{}", stderr(&done));
}

#[test]
fn ineffective_options_are_warned_about() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/");
    let said = |scene: &str, options: &[&str]| {
        let scene = format!("{root}{scene}");
        let arguments = ["render", &scene, "--dry-run", "--strict", "-o", "unwritten.####.exr"];
        let done = rayframe(&[&arguments[..], options].concat());
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        stderr(&done)
    };
    let unlit = "light/environment_only.gltf";
    for (scene, options, ineffective) in [
        (unlit, &["--env", "none", "--env-intensity", "2"][..], "--env-intensity"),
        (unlit, &["--light-scale", "2"], "--light-scale"),
        (unlit, &["--light-radius", "2"], "--light-radius"),
        (unlit, &["--env", "none", "--sun-angle", "2"], "--sun-angle"),
        (unlit, &["--shutter", "0.5"], "--shutter"),
        (unlit, &["--exposure", "1"], "--exposure"),
        (unlit, &["--tone", "standard"], "--tone"),
        // A pixel decides after 32 samples, and the first 4 are always taken.
        (unlit, &["--integrator", "path", "--noise", "0.1"], "--noise"),
        (unlit, &["--integrator", "path", "--samples", "32", "--noise", "0.1"], "--noise"),
        (unlit, &["--integrator", "path", "--time-limit", "9s"], "--time-limit"),
    ] {
        let said = said(scene, options);
        assert_eq!(said.matches("does nothing").count(), 1, "{said}");
        assert!(said.contains(&format!("{ineffective} does nothing: ")), "{said}");
    }
    for (scene, options) in [
        (unlit, &["--env", "studio", "--env-intensity", "2", "--sun-angle", "1"][..]),
        ("light/point.gltf", &["--light-scale", "2", "--light-radius", "0.1"]),
        (unlit, &["--integrator", "path", "--noise", "0.1", "--samples", "33"]),
        (unlit, &["--integrator", "path", "--time-limit", "9s", "--samples", "5"]),
        ("light/directional.gltf", &["--sun-angle", "1"]),
        ("morph/weights.gltf", &["--shutter", "0.5", "--exposure", "1", "--preview", "png"]),
    ] {
        let said = said(scene, options);
        assert!(!said.contains("does nothing"), "{said}");
    }
}

#[test]
fn a_shutter_before_what_does_not_move_changes_nothing() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/");
    let hash = |scene: &str, options: &[&str]| {
        let scene = format!("{root}{scene}");
        let plan = ["render", &scene, "--dry-run", "--progress", "json", "-f", "0", "-o", "unwritten.exr"];
        let printed = rayframe(&[&plan[..], options].concat()).stdout;
        let plan: serde_json::Value = serde_json::from_slice(&printed).unwrap();
        plan["frames"][0]["render_hash"].as_str().unwrap().to_owned()
    };
    let shutter = ["--shutter", "0.5"];
    assert_eq!(hash("light/point.gltf", &shutter), hash("light/point.gltf", &[]));
    assert_ne!(hash("morph/weights.gltf", &shutter), hash("morph/weights.gltf", &[]));
    let once = [&shutter[..], &["--time-samples", "1"]].concat();
    assert_ne!(hash("morph/weights.gltf", &once), hash("morph/weights.gltf", &shutter));
}

#[test]
fn lights_that_are_scaled_beyond_all_numbers_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("a.gltf");
    let text = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 3e38}]}}}"#;
    std::fs::write(&scene, text).unwrap();
    for (integrator, scale, is_infinite) in
        [("whitted", "1000", true), ("path", "1000", true), ("path", "1", false)]
    {
        let options = ["--integrator", integrator, "--light-scale", scale, "-n", "-o", "unwritten.exr"];
        let done = rayframe(&[&["render", scene.to_str().unwrap()], &options[..]].concat());
        let said = stderr(&done);
        assert_eq!(done.status.code(), Some(0), "{said}");
        let is_told = said.contains("--light-scale takes the intensity of 1 light beyond 3.4e38");
        assert_eq!(is_told, is_infinite, "{integrator} {scale}: {said}");
    }
}

#[test]
fn info_names_the_option_that_selects_a_clip_that_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/");
    let text = std::fs::read_to_string(format!("{root}animation/hierarchy.gltf")).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let clip = document["animations"][0].clone();
    document["animations"].as_array_mut().unwrap().push(clip);
    std::fs::write(&path, document.to_string()).unwrap();
    let scene = path.to_str().unwrap();
    let told = "is left out; select it with --animation '#1'";
    for arguments in [&["info", scene][..], &["info", "--json", scene]] {
        let shown = String::from_utf8_lossy(&rayframe(arguments).stdout).into_owned();
        assert!(shown.contains(told), "{shown}");
    }
    let warned = stderr(&rayframe(&["render", scene, "-n", "-f", "0", "-o", "unwritten.exr"]));
    assert!(warned.contains(told), "{warned}");
}

#[test]
fn strict_reports_each_warning_once() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("a.gltf");
    std::fs::write(&scene, r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["ACME_glow"]}"#).unwrap();
    let scene = scene.to_str().unwrap();
    assert_fails(&["render", scene, "--strict"], 65, "ACME_glow");
    let shown = String::from_utf8_lossy(&rayframe(&["info", scene]).stdout).into_owned();
    assert!(shown.contains("lit by the studio"), "{shown}");
    let morph = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/morph/weights.gltf");
    let done =
        rayframe(&["render", morph, "--animation", "0", "--dry-run", "-f", "0", "-o", "unwritten.exr"]);
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
}
