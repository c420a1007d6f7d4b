use super::super::Cli;
use super::form::Form;
use super::setting::{excludes, unknown};
use super::*;
use clap::{Arg, CommandFactory as _, Parser as _};

/// What was typed after `rayframe render`.
fn given(arguments: &[&str]) -> GivenOptions {
    let matches = options().try_get_matches_from(arguments).unwrap();
    GivenOptions::from_arg_matches(&matches).unwrap()
}

fn shot(text: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap().to_owned();
    (folder, path)
}

/// Something that the option takes, as it is written in a shot file.
fn example(arg: &Arg) -> String {
    let form = Form::of(arg);
    if form.is_flag() {
        return "true".to_owned();
    }
    let of_name = match arg.get_value_names().unwrap()[0].as_str() {
        "SPEC" => "\"1-10x2\"",
        "FRAME" => "-3",
        "RATE" => "23.976",
        "WxH" => "[640, 360]",
        "X0,Y0,X1,Y1" => "[0, 0, 8, 8]",
        "PERCENT|FACTOR" => "\"50%\"",
        "METRES|f/N" => "\"f/2.8\"",
        "SIZE" => "\"8G\"",
        "EV" => "-1.5",
        "LIST" => "[\"depth\", \"uv\"]",
        "TYPE,COMPRESSION" => "[\"float\", \"piz\"]",
        _ if form.is_repeated => "[\"a\", \"#1\"]",
        _ if form.takes_number() => "1",
        _ => "\"a.exr\"",
    };
    match arg.get_possible_values().first() {
        Some(value) => format!("\"{}\"", value.get_name()),
        None => of_name.to_owned(),
    }
}

#[test]
fn every_option_can_be_set_in_a_file_and_by_name() {
    let command = options();
    let manual = include_str!("../../../docs/shots.md");
    for arg in command.get_arguments() {
        let key = arg.get_id().as_str();
        if ["config", "set", "dry_run"].contains(&key) {
            continue;
        }
        assert!(manual.contains(&format!("`{key}`")), "docs/shots.md lacks {key}");
        // One rule for names, with one exception.
        match key {
            "scene" => assert!(arg.is_positional()),
            "scene_choice" => assert_eq!(arg.get_long(), Some("scene")),
            _ => assert_eq!(arg.get_long(), Some(key.replace('_', "-").as_str())),
        }
        let (_folder, path) = shot(&format!("{key} = {}", example(arg)));
        let settings = file::read_shot(Path::new(&path), &command)
            .unwrap_or_else(|error| panic!("{key} cannot be set in a shot file: {error}"));
        check_alone(&command, &settings[0]).unwrap_or_else(|error| panic!("{key}: {error}"));
        let Value::Texts(texts) = &settings[0].value else {
            setting::defined(&command, &format!("{key}=true")).unwrap();
            continue;
        };
        let typed = format!("{key}={}", texts[0].to_str().unwrap());
        let defined = setting::defined(&command, &typed).unwrap();
        check_alone(&command, &defined).unwrap_or_else(|error| panic!("{key}: {error}"));
    }
}

#[test]
fn options_come_before_definitions_before_the_file() {
    let (_folder, path) = shot(concat!(
        "scene = 'a.glb'\nsamples = 2\ndepth = 2\nglossy = 2\nresume = true\nresolution = [64, 36]\n",
        "shadow_catcher = ['a', 'b']\nframes = 7\nquiet = true"
    ));
    let arguments = [
        path.as_str(),
        "--samples",
        "4",
        "-D",
        "samples=3",
        "-D",
        "depth=3",
        "-D",
        "resume=false",
        "-W",
        "9",
        "-D",
        "shadow-catcher=c",
        "-D",
        "shadow_catcher=d",
        "-s",
        "3",
        "-v",
    ];
    let meant = given(&arguments).meant().unwrap();
    let args = meant.args;
    assert_eq!((args.samples, args.depth, args.glossy), (4, 3, 2));
    assert!(!args.resume);
    // What cannot be said beside an option gives way to it.
    assert_eq!((args.width, args.resolution), (Some(9), None));
    assert_eq!((args.start, args.frames), (Some(3), None));
    assert_eq!((args.verbose, args.quiet), (true, false));
    assert_eq!(args.shadow_catcher, ["c", "d"]);
    assert_eq!(args.scene, Path::new(&path).with_file_name("a.glb"));
}

#[test]
fn defaults_that_are_typed_count_as_typed() {
    let (_folder, path) = shot("scene = 'a.glb'\nsamples = 16");
    assert_eq!(given(&[&path]).meant().unwrap().args.samples, 16);
    assert_eq!(given(&[&path, "--samples", "4"]).meant().unwrap().args.samples, 4);
}

#[test]
fn scenes_come_from_the_command_line_or_the_file() {
    let (_folder, path) = shot("samples = 9");
    let args = given(&["b.glb", "--config", &path]).meant().unwrap().args;
    assert_eq!((args.scene.as_path(), args.samples), (Path::new("b.glb"), 9));
    let args = given(&["--config", &path, "-D", "scene=-c.glb"]).meant().unwrap().args;
    assert_eq!(args.scene, Path::new("-c.glb"));
    assert!(given(&[&path]).meant().unwrap_err().to_string().contains("names no scene"));
    assert!(given(&["-D", "samples=1"]).meant().unwrap_err().to_string().contains("no scene"));
    assert!(given(&[&path, "--config", &path]).meant().unwrap_err().to_string().contains("--config"));
}

#[test]
fn files_are_named_from_the_folder_of_the_shot() {
    let (folder, path) = shot(
        "scene = 'sub/a.glb'\noutput = 'out/####.exr'\nenv = 'sky.hdr@90'\nbackground = [1, 0.5, 0]\nstats = '/s.json'",
    );
    let args = given(&[&path]).meant().unwrap().args;
    assert_eq!(args.scene, folder.path().join("sub/a.glb"));
    assert_eq!(args.output, Some(folder.path().join("out/####.exr").into_os_string()));
    assert_eq!(args.env, Some(folder.path().join("sky.hdr@90").into_os_string()));
    assert_eq!(args.background, "1,0.5,0");
    assert_eq!(args.stats, Some("/s.json".into()));
    // Words stay what they are.
    let (_folder, path) = shot("scene = 'a.glb'\nenv = 'studio'\nbackground = 'env'");
    let args = given(&[&path]).meant().unwrap().args;
    assert_eq!((args.env, args.background), (Some("studio".into()), "env".into()));
}

#[test]
fn mistakes_are_named_with_line_and_key() {
    for (text, words) in [
        ("samples = 4\nsampels = 4", &["line 2: \"sampels\"", "did you mean \"samples\"?"][..]),
        ("light-scale = 4", &["did you mean \"light_scale\"?"]),
        ("spp = 4", &["did you mean \"samples\"?"]),
        ("xyzzy_plugh = 4", &["is no setting; settings are called as"]),
        ("dry_run = true", &["belongs on the command line"]),
        ("\n[picture]\nsamples = 4", &["line 2: \"picture\" is a table"]),
        ("samples = 'many'", &["line 1: \"samples\" is a text; write a number"]),
        ("samples = true", &["is true or false; write a number"]),
        ("samples = 0", &["line 1: samples: write a whole number from 1 to 65536"]),
        ("samples = 1.5", &["write a whole number"]),
        ("camera = 0", &["\"camera\" is a number; write a text in quotes"]),
        ("resume = 'yes'", &["is a text; write true or false"]),
        ("preview = 'gif'", &["preview: invalid value 'gif'", "png"]),
        ("shadow_catcher = [1]", &["is an array; write", "an array of texts"]),
        ("fps = 2024-01-01", &["is a date; write a number or a text in quotes"]),
        ("samples = 1\nsamples = 2", &["line 2"]),
        ("samples = ", &["line 1"]),
        ("\n\nresume = true\noverwrite = true", &["line 4: overwrite: ", "--resume"]),
        ("samples = 1\ntime_samples = 4", &["line 2: time_samples: ", "--shutter"]),
        ("frames = '10-1'\nresolution = '0x1'", &["line 2: resolution: a picture needs"]),
    ] {
        // A scene at the end, so that the lines are those of the text; tables end what comes before them.
        let scene = if text.contains('[') && text.contains("picture]") { "" } else { "\nscene = 'a.glb'" };
        let (_folder, path) = shot(&format!("{text}{scene}"));
        let error = given(&[&path]).meant().unwrap_err();
        assert_eq!(error.exit_code(), 65, "{text}: {error}");
        for word in words {
            assert!(error.to_string().contains(word), "{text}: {error}");
        }
        assert!(!error.to_string().contains('\n'), "{error}");
    }
}

#[test]
fn mistakes_after_d_are_of_the_command_line() {
    for (text, word) in [
        ("samples", "write KEY=VALUE"),
        ("sampels=4", "did you mean \"samples\"?"),
        ("samples=many", "-D samples=many: write a whole number"),
        ("resume=1", "write true or false"),
        ("config=a.toml", "belongs on the command line"),
        ("time_samples=4", "--shutter"),
    ] {
        let error = given(&["a.glb", "-D", text]).meant().unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains(word), "{text}: {error}");
    }
}

#[test]
fn what_is_found_out_later_is_still_blamed_on_the_line() {
    let (_folder, path) = shot("scene = 'a.glb'\n\nfps = 0");
    let meant = given(&[&path]).meant().unwrap();
    let error = meant.explained(Error::usage("--fps: write a rate"));
    assert_eq!(error.to_string(), format!("{path}: line 3: fps: write a rate"));
    let typed = meant.explained(Error::usage("--frames: write a number"));
    assert_eq!(typed.exit_code(), 2);
}

#[test]
fn other_files_are_no_shots() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    let read = || file::read_shot(&path, &options()).unwrap_err();
    assert_eq!(read().exit_code(), 66);
    std::fs::write(&path, [0xff, 0xfe]).unwrap();
    assert!(read().to_string().contains("UTF-8"));
    std::fs::write(&path, vec![b'\n'; (1 << 20) + 1]).unwrap();
    assert_eq!(read().exit_code(), 77);
    std::fs::write(&path, "a = ".to_owned() + &"[".repeat(100_000)).unwrap();
    assert_eq!(read().exit_code(), 65);
    assert_eq!(file::read_shot(folder.path(), &options()).unwrap_err().exit_code(), 65);
}

#[test]
fn settings_exclude_what_they_replace() {
    let command = options();
    let setting = |text: &str| setting::defined(&command, text).unwrap();
    assert!(excludes(&command, &setting("width=4"), &setting("resolution=4x4")));
    assert!(excludes(&command, &setting("resolution=4x4"), &setting("height=4")));
    assert!(!excludes(&command, &setting("width=4"), &setting("height=4")));
    assert!(!excludes(&command, &setting("resume=false"), &setting("overwrite=true")));
    assert!(unknown(&command, "").starts_with("is no setting"));
}

#[test]
fn both_commands_take_the_same_options() {
    Cli::command().debug_assert();
    for command in ["render", "watch"] {
        assert!(Cli::try_parse_from(["rayframe", command, "a.glb", "-D", "samples=1"]).is_ok());
        assert!(Cli::try_parse_from(["rayframe", command]).is_err());
        assert!(Cli::try_parse_from(["rayframe", command, "--config", "a.toml"]).is_ok());
    }
}

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
    let ShotJob { sequence, warnings } = job_of(folder.path(), "shots/a.toml", &["samples=4"]).unwrap();
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
    let typed = given(&[path.to_str().unwrap()]).meant().unwrap();
    let rendered = crate::cli::render_job::render_job(&typed.args).unwrap().sequence;
    assert_eq!(alone.render, rendered.render);
    assert_eq!((alone.render.samples, alone.render.resolution), (3, rendered.render.resolution));
}

#[test]
fn a_suite_names_files_from_its_own_folder() {
    let folder =
        suite("scene = 'a.gltf'", "[shot]\nenv = 'sky.hdr@90'\nbackground = 'black'\nmanifest = 'm.json'");
    let path = folder.path().join("shots/a.toml");
    let suite = folder.path().join("suite.toml");
    let read = |overrides: &[String]| {
        job::meant(&ShotRequest { path: &path, suite: Some(&suite), overrides }).unwrap().args
    };
    let args = read(&[]);
    assert_eq!(args.env, Some(folder.path().join("sky.hdr@90").into_os_string()));
    assert_eq!(args.manifest, Some(folder.path().join("m.json")));
    assert_eq!(args.scene, folder.path().join("shots/a.gltf"));
    // What is said beside them is named from the current folder, as after -D.
    assert_eq!(read(&["env=sea.hdr".to_owned()]).env, Some("sea.hdr".into()));
}

#[test]
fn mistakes_in_a_suite_are_named_with_file_and_line() {
    let good = "scene = 'a.gltf'";
    for (shot, suite_text, file, words) in [
        (good, "[shot]\nsampels = 4", "suite.toml", &["line 2: \"sampels\"", "\"samples\"?"][..]),
        (good, "[shot]\n\nsamples = 0", "suite.toml", &["line 3: samples: write a whole number"]),
        (good, "[shot]\nscene = 'b.gltf'", "suite.toml", &["line 2: \"scene\" differs from shot to shot"]),
        (good, "\nshot = 4", "suite.toml", &["line 2: \"shot\" is a number; write [shot]"]),
        (good, "[[shot]]\nsamples = 4", "suite.toml", &["line 1: \"shot\" is an array; write [shot]"]),
        (good, "[shot]\n[shot.test]\nmean = 1", "suite.toml", &["line 2: \"test\" is a table"]),
        (good, "[shot]\ntime_samples = 4", "suite.toml", &["line 2: time_samples: ", "--shutter"]),
        (good, "[shot]\nfps = 0", "suite.toml", &["line 2: fps: "]),
        (good, "[shot]\ncamera = 'nobody'", "suite.toml", &["line 2: camera: "]),
        (good, "[shot", "suite.toml", &["line 1: "]),
        // Also where the shot says something else, for then it is wrong for the next one.
        ("scene = 'a.gltf'\nsamples = 1", "[shot]\nsamples = 0", "suite.toml", &["line 2: samples: "]),
        ("scene = 'a.gltf'\nfps = 0", "[shot]\nfps = 25", "a.toml", &["line 2: fps: "]),
        ("scene = 'a.gltf'\n[limits]", "", "a.toml", &["line 2: \"limits\" is a table"]),
        ("scene = 'a.gltf'\ntest = 1", "", "a.toml", &["line 2: \"test\" is no setting"]),
        ("samples = 1\n[test]\nscene = 'a.gltf'", "", "a.toml", &["names no scene"]),
        // The others would do without the suite's line, which counts least.
        ("scene = 'a.gltf'\nresume = true", "\n\n\n[shot]\ntime_samples = 2", "suite.toml", &["line 5: "]),
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
fn the_scene_of_a_shot_is_found_whatever_else_it_says() {
    let (folder, path) = shot("sampels = 0\nscene = 'sub/a.glb'\n[limits]");
    assert_eq!(scene_of_shot(Path::new(&path)).unwrap(), folder.path().join("sub/a.glb"));
    for (text, word) in [
        ("samples = 1", "names no scene"),
        ("\nscene = 4", "line 2: \"scene\" is a number"),
        ("\nscene = ", "line 2"),
    ] {
        let (_folder, path) = shot(text);
        let error = scene_of_shot(Path::new(&path)).unwrap_err();
        assert!(error.to_string().contains(word) && error.exit_code() == 65, "{error}");
    }
    assert_eq!(scene_of_shot(Path::new("nobody.toml")).unwrap_err().exit_code(), 66);
}
