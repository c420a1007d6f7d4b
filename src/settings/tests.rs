use std::ffi::OsStr;
use std::path::Path;

use super::setting_type::Single;
use super::*;
use crate::error::{Error, Provenance};

#[cfg(unix)]
mod os_names;

/// A text that the setting accepts.
fn example(definition: &Definition) -> String {
    let of_name = match definition.value_name {
        "" => "true",
        "SPEC" => "1-9x2",
        "FRAME" => "-3",
        "RATE" => "24000/1001",
        "WxH" => "640x360",
        "X0,Y0,X1,Y1" => "0,0,8,8",
        "PERCENT|FACTOR" => "0.5",
        "METRES|f/N" => "f/2.8",
        "SIZE" => "8000000000",
        "EV" => "-1.5",
        "FIRST-LAST" => "0-63",
        "AZ,EL[,DIST]" => "30,20,1",
        "X,Y,Z" | "X,Y,Z|NODE" => "1,-2,0.5",
        "LIST" => "beauty,depth,uv",
        "TYPE,COMPRESSION" => "float,piz",
        _ if definition.name == "camera_path" => "a.glb#1",
        _ if definition.form.takes_number() => "1",
        _ => "a.exr",
    };
    definition.choices().first().map_or(of_name, |(name, _)| name).to_owned()
}

fn read(text: &str) -> crate::error::Result<Settings> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, text).unwrap();
    Settings::read_shot(&path)
}

fn defined(texts: &[&str]) -> crate::error::Result<Settings> {
    let texts: Vec<String> = texts.iter().map(ToString::to_string).collect();
    Settings::read_definitions(&texts)
}

#[test]
fn every_setting_is_documented_and_keeps_its_value_in_text_toml_and_json() {
    let manual = include_str!("../../docs/shots.md");
    for definition in DEFINITIONS {
        let name = definition.name;
        assert!(manual.contains(&format!("`{name}`")), "docs/shots.md lacks {name}");
        assert!(!definition.help.is_empty() && !definition.help[0].trim().ends_with('.'), "{name}");
        let mut settings = Settings::default();
        let text = example(definition);
        definition.parse(&mut settings, OsStr::new(&text), &Provenance::Library).unwrap_or_else(|why| {
            panic!("{name} = {text}: {why}");
        });
        assert_eq!(definition.texts(&settings).unwrap(), [text.as_str()], "{name}");
        assert!(settings.to_json().contains_key(name));
        let reread = read(&settings.to_toml()).unwrap();
        let reread_text = definition.texts(&reread).unwrap()[0].to_string_lossy().into_owned();
        let is_path = text.starts_with("a.") && reread_text.ends_with(&format!("/{text}"));
        assert!(is_path || definition.texts(&reread) == definition.texts(&settings), "{name}: {reread:?}");
    }
}

#[test]
fn every_default_is_a_value() {
    let defaults = Settings::default().with_defaults(Path::new("/folder"));
    assert_eq!(defaults.values().samples, 4);
    // Settings that need another one have no value of their own, and neither have flags.
    assert!(defaults.time_samples.is_none() && defaults.aa_threshold.is_none() && defaults.resume.is_none());
    assert_eq!(defaults.values(), Settings::default().values());
    assert_eq!(read(&defaults.to_toml()).unwrap().values(), defaults.values());
    for name in ["excludes", "requires"] {
        for definition in DEFINITIONS {
            let others = if name == "excludes" {
                definition.excludes.to_vec()
            } else {
                Vec::from_iter(definition.requires)
            };
            assert!(
                others.iter().all(|other| Definition::of(other).is_some()),
                "{}: {name}",
                definition.name
            );
        }
    }
}

#[test]
fn errors_name_file_line_and_column() {
    for (text, words) in [
        ("samples = 4\nsampels = 4", &[":2:1: \"sampels\" is no setting", "did you mean \"samples\"?"][..]),
        ("light-scale = 4", &["did you mean \"light_scale\"?"]),
        ("spp = 4", &["did you mean \"samples\"?"]),
        ("xyzzy_plugh = 4", &["is no setting; keys are the long options"]),
        ("dry_run = true", &["belongs on the command line"]),
        ("\n[image]\nsamples = 4", &[":2:2: \"image\" is a table"]),
        ("samples = 'many'", &[":1:1: samples: expected a number, found a text"]),
        ("samples = true", &["expected a number, found true or false"]),
        ("  samples = 0", &[":1:3: samples: write a whole number from 1 to 65536"]),
        ("samples = 1.5", &["write a whole number"]),
        ("camera = 0", &["camera: expected a text in quotes, found a number"]),
        ("samples = '4'", &["samples: expected a number, found a text; write 4 without quotes"]),
        (
            "samples = '1.5'",
            &[
                ":1:1: samples: expected a number without quotes, found a text; write a whole number from 1 to 65536",
            ],
        ),
        ("samples = '1_000'", &["expected a number, found a text; write 1_000 without quotes"]),
        ("samples = '1_000_000'", &["expected a number without quotes, found a text; write a whole number"]),
        ("resume = 'true'", &["expected true or false, found a text; write true without quotes"]),
        (
            "scene = \"C:\\x\"",
            &["not valid TOML", "write the text in single quotes, such as 'C:\\robot.glb'"],
        ),
        ("resume = 'yes'", &["expected true or false, found a text"]),
        ("simd = 'foo'", &["simd: \"foo\" is not one of the choices; there are best, scalar"]),
        ("preview = 'gif'", &["preview: \"gif\" is not one of the choices; there are png"]),
        ("shadow_catcher = [1]", &["expected a text in quotes or an array of texts, found an array"]),
        ("fps = 2024-01-01", &["expected a number or a text in quotes, found a date"]),
        ("samples = 1\nsamples = 2", &[":2:1: "]),
        ("layers = 'uv'\naovs = 'uv'", &[":2:1: aovs: is set twice"]),
        ("samples = ", &[":1:", ": not valid TOML: "]),
        ("\n\nresume = true\noverwrite = true", &[":4:1: overwrite: cannot be combined with `resume`"]),
        ("frames = '10-1'\nresolution = '0x1'", &[":1:1: frames: "]),
    ] {
        let error = read(text).unwrap_err();
        assert_eq!(error.exit_code(), 65, "{text}: {error}");
        for word in words {
            assert!(error.to_string().contains(word), "{text}: {error}");
        }
        assert!(!error.to_string().contains('\n'), "{error}");
    }
}

#[test]
fn definitions_are_toml_or_text() {
    let values =
        defined(&["samples=3", "env=none", "resolution=[64, 36]", "camera=\"cam 1\"", "frames=1-3"]).unwrap();
    let values = values.values();
    assert_eq!(
        (values.samples, values.env, values.resolution),
        (3, Some(EnvironmentSource::None), Some((64, 36)))
    );
    assert_eq!(values.camera, Some(parse::camera("cam 1")));
    assert_eq!(defined(&["samples=3", "samples=5"]).unwrap().values().samples, 5);
    let read = read("max_memory = 1e9\nasset_cache_size = 1_000.0").unwrap().values();
    assert_eq!((read.max_memory, read.asset_cache_size), (Some(1_000_000_000), 1000));
    assert_eq!(defined(&["max_memory=1e9"]).unwrap().values().max_memory, Some(1_000_000_000));
    // Blanks around the sign are no part of either. Quotes keep those within.
    for text in ["env = none ", " env =\tnone", "env = 'none' "] {
        assert_eq!(defined(&[text]).unwrap().values().env, Some(EnvironmentSource::None), "{text}");
    }
    assert_eq!(defined(&["camera = ' 1 '"]).unwrap().values().camera, Some(parse::camera(" 1 ")));
    for (text, word) in [
        ("samples", "write KEY=VALUE"),
        ("sampels=4", "did you mean \"samples\"?"),
        ("samples=many", "-D samples=many: write a whole number"),
        ("resume=1", "write true or false"),
        ("config=a.toml", "belongs on the command line"),
    ] {
        let error = defined(&[text]).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains(word), "{text}: {error}");
    }
}

#[test]
fn stronger_levels_win_and_exclude() {
    let mut strong = defined(&["width=4", "resume=false", "start=3"]).unwrap();
    strong.fill_from(&read("height = 5\noverwrite = true\nframes = 7\n\nsamples = 2").unwrap());
    strong.fill_from(&read("resolution = '8x8'\nsamples = 9").unwrap());
    let values = strong.values();
    assert_eq!((values.width, values.height, values.resolution), (Some(4), Some(5), None));
    assert_eq!((values.start, values.frames, values.samples), (Some(3), None, 2));
    // A flag that is false excludes nothing.
    assert!(values.overwrite && !values.resume);
    let lines = matches!(strong.origin_of("samples"), Some(Provenance::File { line: 5, column: 1, .. }));
    assert!(lines, "{:?}", strong.samples);
    let error = defined(&["time_samples=4"]).unwrap().check_requirements().unwrap_err();
    assert!(error.to_string().contains("has no effect without `shutter`"), "{error}");
    assert!(matches!(strong.locate(Error::setting("samples", "too few")), Error::Setting(error)
        if error.to_string().ends_with(":5:1: samples: too few")));
}

/// Checks which settings of a file give way to stronger ones, and which stay.
fn check_merged(file: &str, stronger: &[&str], gone: &[&str], stays: &[&str]) {
    let mut settings = defined(stronger).unwrap();
    settings.fill_from(&read(file).unwrap());
    for name in gone {
        assert!(settings.origin_of(name).is_none(), "{stronger:?} over {file}: {name}");
    }
    for name in stays {
        assert!(settings.origin_of(name).is_some(), "{stronger:?} over {file}: {name}");
    }
    settings.check_requirements().unwrap();
}

#[test]
fn weaker_settings_without_effect_beside_stronger_ones_give_way() {
    let paths = "integrator = 'path'\nseed = 3\nseed_per_frame = true\nnoise = 0.1\nclamp_indirect = 9\nregularize = true\n\
        time_limit = 9\ndenoise = 'oidn'\noidn = '/x'\ncheckpoint = true\naovs = ['noise']\ndepth = 3";
    let files = "output = 'a.####.exr'\naovs = ['depth']\nexr = 'float'\nsplit_aovs = true\nstamp = true\npreview = 'png'\n\
        movie = 'a.mp4'\nmanifest = 'm.json'\nresume = true\nstats = 's.json'";
    let of_exr = ["aovs", "exr", "split_aovs", "stamp", "preview"];
    let of_frames = ["movie", "manifest", "resume"];
    let of_paths = [
        "seed",
        "seed_per_frame",
        "noise",
        "clamp_indirect",
        "regularize",
        "time_limit",
        "denoise",
        "oidn",
        "checkpoint",
        "aovs",
    ];
    let of_whitted = "glossy = 3\nenv_samples = 2\nmax_samples = 8\naa_threshold = 0.1\ndepth = 3";
    for (file, stronger, gone, stays) in [
        (paths, &["integrator=whitted"][..], &of_paths[..], &["depth"][..]),
        (paths, &["integrator=path"], &[], &of_paths),
        (
            of_whitted,
            &["integrator=path"],
            &["glossy", "env_samples", "max_samples", "aa_threshold"],
            &["depth"],
        ),
        (files, &["output=a.png"], &of_exr, &of_frames),
        (files, &["output=a.gif"], &[&of_exr[..], &of_frames].concat(), &["stats"]),
        (files, &["output=b.exr"], &[], &[&of_exr[..], &of_frames].concat()),
    ] {
        check_merged(file, stronger, gone, stays);
    }
}

#[test]
fn weaker_settings_that_contradict_stronger_ones_give_way() {
    let edges = "max_samples = 32\naa_threshold = 0.1";
    let ranges = "samples = 8\nsample_range = '0-3'";
    for (file, stronger, gone, stays) in [
        (edges, &["samples=64"][..], &["max_samples", "aa_threshold"][..], &[][..]),
        (edges, &["samples=32"], &[], &["max_samples", "aa_threshold"]),
        ("samples = 64\ndepth = 3", &["max_samples=32"], &["samples"], &["depth"]),
        ("turntable = 5\nelevation = 10", &["camera_path=x.toml"], &["turntable", "elevation"], &[]),
        ("turntable = 5\nelevation = 10", &["view=back"], &["elevation"], &["turntable"]),
        ("elevation = 10", &["camera_path=x.toml"], &["elevation"], &[]),
        ("aperture = 'f/2'\nfocus = 3", &["ortho=true"], &["aperture", "focus"], &[]),
        ("aperture = 0.1\nfocus = 3", &["ortho=true"], &[], &["aperture", "focus"]),
        ("ortho = true", &["aperture=f/2"], &["ortho"], &[]),
        ("crop = [0, 0, 64, 32]", &["resolution=32x32"], &["crop"], &[]),
        ("crop = [0, 0, 64, 32]", &["width=64", "height=32"], &[], &["crop"]),
        ("crop = [0, 0, 64, 32]", &["scale=5%"], &[], &["crop"]),
        ("crop = [0, 0, 64, 32]\nwidth = 64", &["scale=5%"], &[], &["crop", "width"]),
        ("start = 5\nend = 9\nstep = 2", &["end=3"], &["start"], &["step"]),
        ("start = 5\nend = 9\nstep = 2", &["start=10"], &["end"], &["step"]),
        ("start = 5\nend = 9\nstep = 2", &["start=9"], &[], &["end", "step"]),
        ("exr = 'dwaa'", &["aovs=depth"], &["exr"], &[]),
        (
            "exr = 'dwaa'\naovs = 'depth'\nsplit_aovs = true",
            &["split_aovs=false"],
            &["exr"],
            &["aovs", "split_aovs"],
        ),
        ("aovs = 'depth'", &["exr=dwaa"], &["aovs"], &[]),
        (ranges, &["samples=2"], &["sample_range"], &[]),
        (ranges, &["noise=0.1"], &["sample_range"], &["samples"]),
        ("noise = 0.1\nsplit_aovs = true", &["sample_range=0-3"], &["noise", "split_aovs"], &[]),
        ("exr = 'piz'\naovs = 'crypto'", &["sample_range=0-3"], &["aovs"], &["exr"]),
    ] {
        check_merged(file, stronger, gone, stays);
    }
    // What is stronger stays, and is wrong.
    let mut settings = defined(&["aa_threshold=0.1", "samples=64"]).unwrap();
    settings.fill_from(&read(edges).unwrap());
    settings.check_requirements().unwrap_err();
}

#[test]
fn defaults_are_written_only_beside_what_they_can_be_combined_with() {
    let given: Vec<Settings> = DEFINITIONS
        .iter()
        .map(|definition| {
            let mut settings = Settings::default();
            definition.parse(&mut settings, OsStr::new(&example(definition)), &Provenance::Library).unwrap();
            settings
        })
        .collect();
    let merged = |stronger: &Settings, weaker: &Settings| {
        let mut both = stronger.clone();
        both.fill_from(weaker);
        both
    };
    for (at, first) in given.iter().enumerate() {
        for second in &given[at..] {
            // The order matters only where one excludes the other.
            let orders = [merged(first, second), merged(second, first)];
            let distinct = if orders[0] == orders[1] { &orders[..1] } else { &orders };
            for both in distinct {
                let all = both.with_defaults(Path::new("/folder"));
                assert!(all.check_exclusions().is_ok(), "{}", all.to_toml());
            }
        }
    }
}

#[test]
fn a_later_setting_replaces_those_that_it_excludes() {
    let set = |texts: &[(&str, &str)]| {
        let mut settings = Settings::default();
        for (name, text) in texts {
            settings.set(name, OsStr::new(text), &Provenance::Library).unwrap();
        }
        settings
    };
    let values = set(&[("frames", "1-9"), ("start", "3"), ("end", "5")]).values();
    assert_eq!((values.frames, values.start, values.end), (None, Some(3), Some(5)));
    let values = set(&[("start", "3"), ("width", "9"), ("frames", "7"), ("resolution", "8x8")]).values();
    assert_eq!((values.start, values.width, values.resolution), (None, None, Some((8, 8))));
    let values = set(&[("resume", "true"), ("overwrite", "false"), ("shadow_catcher", "a")]).values();
    assert!(values.resume && !values.overwrite);
    let values = set(&[("turntable", "5"), ("elevation", "9"), ("camera_path", "x.toml")]);
    assert!(values.turntable.is_none() && values.elevation.is_none() && values.camera_path.is_some());
    assert_eq!(set(&[("shadow_catcher", "a"), ("shadow_catcher", "b")]).values().shadow_catcher, ["a", "b"]);
    let mut settings = set(&[("frames", "1-9")]);
    settings.set("start", OsStr::new("first"), &Provenance::Library).unwrap_err();
    settings.set("frames", OsStr::new("last"), &Provenance::Library).unwrap_err();
    assert_eq!(settings, set(&[("frames", "1-9")]));
}

#[test]
fn other_files_are_no_shots() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    let code = || Settings::read_shot(&path).unwrap_err().exit_code();
    assert_eq!(code(), 66);
    std::fs::write(&path, [0xff, 0xfe]).unwrap();
    assert_eq!(code(), 65);
    std::fs::write(&path, vec![b'\n'; (1 << 20) + 1]).unwrap();
    assert_eq!(code(), 77);
    std::fs::write(&path, "a = ".to_owned() + &"[".repeat(100_000)).unwrap();
    assert_eq!(code(), 65);
    assert_eq!(Settings::read_shot(folder.path()).unwrap_err().exit_code(), 65);
}

#[test]
fn files_are_named_from_the_folder_of_the_shot() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    let text = "scene = 'sub/a.glb'\noutput = 'out/####.exr'\nenv = 'sky.hdr@90'\nbackground = [1, 0.5, 0]\nstats = '/s.json'";
    std::fs::write(&path, text).unwrap();
    let values = Settings::read_shot(&path).unwrap().values();
    assert_eq!(values.scene, Some(folder.path().join("sub/a.glb")));
    assert_eq!(values.output.unwrap().path(7), folder.path().join("out/0007.exr"));
    assert_eq!(values.env, Some(EnvironmentSource::File(folder.path().join("sky.hdr"), 90.0)));
    let orange = EnvironmentSource::Constant([1.0, 0.5, 0.0]);
    assert_eq!(values.background, BackgroundSource::Environment(orange));
    assert_eq!(values.stats, Some("/s.json".into()));
}

#[test]
fn numbers_and_texts_have_one_json_type() {
    let json = defined(&["samples=+2", "exposure=-1.5", "focus=2", "aperture=f/2", "resume=true"])
        .unwrap()
        .to_json();
    assert_eq!(
        (&json["samples"], &json["exposure"], &json["resume"]),
        (&2.into(), &"-1.5".into(), &true.into())
    );
    assert!(DEFINITIONS.iter().any(|definition| definition.form.single == Single::NumberOrText));
}
