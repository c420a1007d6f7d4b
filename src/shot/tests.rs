use super::form::Form;
use super::setting::{excludes, unknown};
use super::*;
use clap::Arg;

/// What was typed after `rayframe render`.
pub fn given(arguments: &[&str]) -> GivenOptions {
    let matches = options().try_get_matches_from(arguments).unwrap();
    GivenOptions::from_arg_matches(&matches).unwrap()
}

pub fn shot(text: &str) -> (tempfile::TempDir, String) {
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
    let manual = include_str!("../../docs/shots.md");
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
