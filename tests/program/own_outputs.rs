//! No output replaces a file of another program, and no shot file writes outside its folder.

use std::path::Path;

use crate::{both, names, rayframe, stderr};

const FOREIGN: &[u8] = b"{\"notes\": \"of somebody else\"}\n";
const SCENE: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36,
        "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;
/// Options of `render` that write a file beside the frames, and its name.
const SIDECARS: [(&str, &str); 6] = [
    ("--stats", "a.json"),
    ("--manifest", "a.json"),
    ("--contact-sheet", "a.png"),
    ("--movie", "a.apng"),
    ("--movie", "a.webp"),
    ("--movie", "a.gif"),
];

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.gltf"), SCENE).unwrap();
    folder
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn files_beside_the_frames_replace_only_their_like() {
    for (option, name) in SIDECARS {
        let folder = folder();
        let at = |name: &str| folder.path().join(name);
        let (scene, frames, file) = (at("s.gltf"), at("out/f.####.exr"), at(name));
        let command =
            ["render", text(&scene), "-r", "8x6", "-f", "0", "-q", "-o", text(&frames), option, text(&file)];
        std::fs::write(&file, FOREIGN).unwrap();
        let refused = rayframe(&command);
        assert_eq!(refused.status.code(), Some(73), "{option} {name}: {}", stderr(&refused));
        assert!(stderr(&refused).contains(text(&file)), "{}", stderr(&refused));
        assert_eq!(std::fs::read(&file).unwrap(), FOREIGN);
        assert_eq!(names(&at("out")), [] as [&str; 0]);
        // `--overwrite` means it; the file is then one of this program.
        assert_eq!(rayframe(&both(&command, &["--overwrite"])).status.code(), Some(0));
        assert_ne!(std::fs::read(&file).unwrap(), FOREIGN);
        let again = rayframe(&both(&command, &["--resume"]));
        assert_eq!(again.status.code(), Some(0), "{option} {name}: {}", stderr(&again));
    }
}

#[cfg(unix)]
#[test]
fn links_are_not_replaced_unasked_and_never_followed() {
    for target in ["gone.txt", "victim.txt"] {
        let folder = folder();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("victim.txt"), FOREIGN).unwrap();
        std::os::unix::fs::symlink(target, at("a.json")).unwrap();
        let (scene, frames, file) = (at("s.gltf"), at("out/f.####.exr"), at("a.json"));
        let command = [
            "render",
            text(&scene),
            "-r",
            "8x6",
            "-f",
            "0",
            "-q",
            "-o",
            text(&frames),
            "--stats",
            text(&file),
        ];
        assert_eq!(rayframe(&command).status.code(), Some(73), "{target}");
        assert!(file.is_symlink());
        assert_eq!(rayframe(&both(&command, &["--overwrite"])).status.code(), Some(0));
        assert!(!file.is_symlink() && !at("gone.txt").exists());
        assert_eq!(std::fs::read(at("victim.txt")).unwrap(), FOREIGN);
    }
}

#[test]
fn shot_files_write_into_their_folder_unless_permitted() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("shots")).unwrap();
    let shot = at("shots/a.toml");
    for key in ["output = '../b.exr'", "stats = '../b.json'", "manifest = '/tmp/rayframe-none/b.json'"] {
        std::fs::write(&shot, format!("scene = '../s.gltf'\nresolution = [8, 6]\n{key}\n")).unwrap();
        let refused = rayframe(&["render", text(&shot), "-f", "0", "-q"]);
        assert_eq!(refused.status.code(), Some(77), "{key}: {}", stderr(&refused));
        assert!(stderr(&refused).contains("--allow-dir"), "{}", stderr(&refused));
    }
    std::fs::write(&shot, "scene = '../s.gltf'\nresolution = [8, 6]\noutput = '../b.exr'\n").unwrap();
    let permitted = rayframe(&["render", text(&shot), "-f", "0", "-q", "--allow-dir", text(folder.path())]);
    assert_eq!(permitted.status.code(), Some(0), "{}", stderr(&permitted));
    assert!(at("b.exr").is_file());
}

#[cfg(unix)]
#[test]
fn placeholders_of_shot_files_lead_into_no_other_folder() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    for name in ["shots", "out"] {
        std::fs::create_dir(at(name)).unwrap();
    }
    for name in ["s", "0001", "depth"] {
        std::os::unix::fs::symlink(at("out"), at("shots").join(name)).unwrap();
    }
    std::fs::copy(at("s.gltf"), at("shots/s.gltf")).unwrap();
    std::fs::write(at("out/notes.json"), FOREIGN).unwrap();
    let (shot, job) = (at("shots/a.toml"), at("job"));
    for lines in [
        "output = '{scene}/f.####.exr'",
        "output = '####/f.exr'",
        "output = '{layer}/f.exr'\naovs = 'light,depth'\nsplit_aovs = true",
        "stats = '{scene}/notes.json'\noverwrite = true",
        "manifest = '{scene}/a.json'",
        "contact_sheet = '{scene}/a.png'",
        "movie = '{scene}/a.gif'",
    ] {
        let text_of = format!("scene = 's.gltf'\nresolution = [8, 6]\nframes = 1\n{lines}\n");
        std::fs::write(&shot, text_of).unwrap();
        let farm = ["farm", "parallel", text(&shot), "--out-dir", text(&job)];
        let several = ["render", text(&shot), text(&shot), "-q"];
        for command in [&["render", text(&shot), "-q"][..], &several, &farm] {
            if command[0] == "farm" && !lines.starts_with("output") {
                continue;
            }
            let refused = rayframe(command);
            assert_eq!(refused.status.code(), Some(77), "{lines}: {command:?} {}", stderr(&refused));
            assert!(stderr(&refused).contains("leads outside the folder"), "{}", stderr(&refused));
        }
        assert_eq!(names(&at("out")), ["notes.json"], "{lines}");
        assert!(!job.exists());
    }
    assert_eq!(std::fs::read(at("out/notes.json")).unwrap(), FOREIGN);
    std::fs::write(&shot, "scene = 's.gltf'\nresolution = [8, 6]\nframes = 1\noutput = '####/f.exr'\n")
        .unwrap();
    let permitted = rayframe(&["render", text(&shot), "-q", "--allow-dir", text(&at("out"))]);
    assert_eq!(permitted.status.code(), Some(0), "{}", stderr(&permitted));
    assert!(at("out/f.exr").is_file());
}

#[test]
fn heat_maps_and_flip_maps_replace_only_their_like() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let (scene, image) = (at("s.gltf"), at("f.exr"));
    assert_eq!(
        rayframe(&["render", text(&scene), "-r", "8x6", "-f", "0", "-q", "-o", text(&image)]).status.code(),
        Some(0)
    );
    for (option, name) in [("--heat-map", "a.png"), ("--flip-map", "a.exr")] {
        let file = at(name);
        std::fs::write(&file, FOREIGN).unwrap();
        let command = ["diff", text(&image), text(&image), option, text(&file)];
        assert_eq!(rayframe(&command).status.code(), Some(73));
        assert_eq!(std::fs::read(&file).unwrap(), FOREIGN);
        assert_eq!(rayframe(&both(&command, &["--overwrite"])).status.code(), Some(0));
        let again = rayframe(&command);
        assert_eq!(again.status.code(), Some(0), "{}", stderr(&again));
    }
}

#[test]
fn resumed_frames_and_previews_replace_no_other_kind_of_image() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let [scene, frames, first, frame] = ["s.gltf", "f.####.exr", "f.0001.exr", "frame.exr"].map(at);
    let [sheet, movie, heat_map, flip_map] = ["sheet.png", "movie.apng", "heat.png", "flip.exr"].map(at);
    let render = ["render", text(&scene), "-r", "8x6", "-q"];
    let sidecars = ["--contact-sheet", text(&sheet), "--movie", text(&movie)];
    let made = [
        both(&both(&render, &["-f", "1-2", "-o", text(&frames)]), &sidecars),
        vec!["diff", text(&first), text(&first), "--heat-map", text(&heat_map)],
        vec!["diff", text(&first), text(&first), "--flip-map", text(&flip_map)],
    ];
    for command in made {
        let ran = rayframe(&command);
        assert_eq!(ran.status.code(), Some(0), "{command:?}: {}", stderr(&ran));
    }
    let kinds = [
        (&sheet, "frame.png", "is a contact sheet"),
        (&movie, "frame.png", "is a movie of this program"),
        (&heat_map, "frame.png", "is a heat map"),
        (&flip_map, "frame.exr", "is a FLIP map"),
    ];
    for (file, name, words) in kinds {
        let whole = std::fs::read(file).unwrap();
        for content in [&whole[..], &whole[..whole.len() - 5]] {
            let in_the_way = at(name);
            std::fs::write(&in_the_way, content).unwrap();
            // A PNG file is in the way of a frame and of a preview.
            for options in [&["-o", text(&in_the_way)][..], &["-o", text(&frame), "--preview", "png"]] {
                let command = both(&both(&render, &["-f", "0", "--resume"]), options);
                let refused = rayframe(&command);
                assert_eq!(refused.status.code(), Some(73), "{command:?}: {}", stderr(&refused));
                assert!(stderr(&refused).contains(words), "{}", stderr(&refused));
                assert_eq!(std::fs::read(&in_the_way).unwrap(), content);
            }
            std::fs::remove_file(&in_the_way).unwrap();
        }
    }
}

#[test]
fn suites_replace_only_their_like_and_stay_in_their_folder() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("suite")).unwrap();
    std::fs::copy(at("s.gltf"), at("suite/s.gltf")).unwrap();
    std::fs::write(at("suite/suite.toml"), "[shot]\nresolution = [8, 6]\n").unwrap();
    let suite = at("suite");
    for (option, name) in [("--junit", "a.xml"), ("--summary", "a.md"), ("--code-quality", "a.json")] {
        let file = at(name);
        std::fs::write(&file, FOREIGN).unwrap();
        let command = ["test", "--suite", text(&suite), option, text(&file)];
        assert_eq!(rayframe(&command).status.code(), Some(73), "{option}");
        assert_eq!(std::fs::read(&file).unwrap(), FOREIGN);
        assert_eq!(names(&at("suite")), ["s.gltf", "suite.toml"]);
        assert_eq!(rayframe(&both(&command, &["--overwrite"])).status.code(), Some(1));
        let again = rayframe(&command);
        assert_eq!(again.status.code(), Some(1), "{option}: {}", stderr(&again));
        std::fs::remove_dir_all(at("suite/report")).unwrap();
        let _ = std::fs::remove_dir_all(at("suite/references"));
        let _ = std::fs::remove_dir_all(at("suite/.rayframe-cache"));
    }
    std::fs::write(at("suite/suite.toml"), "report = '/tmp/rayframe-none'\n").unwrap();
    let refused = rayframe(&["test", "--suite", text(&suite)]);
    assert_eq!(refused.status.code(), Some(77), "{}", stderr(&refused));
}

#[test]
fn empty_files_are_replaced_whatever_their_purpose() {
    let outputs: [(&str, &[&str], &[&str]); 6] = [
        ("a.exr", &[], &["a.exr"]),
        ("a.png", &[], &["a.png"]),
        ("a.webp", &[], &["a.webp"]),
        ("a.exr", &["--preview", "png"], &["a.png"]),
        ("a.exr", &["--aovs", "depth,normal", "--split-aovs"], &["a.depth.exr", "a.normal.exr"]),
        ("a.exr", &["--stats", "a.json", "--contact-sheet", "b.png"], &["a.json", "b.png"]),
    ];
    for (output, options, empty) in outputs {
        let folder = folder();
        let at = |name: &str| folder.path().join(name);
        for name in empty {
            std::fs::write(at(name), "").unwrap();
        }
        let options = options.iter().map(|word| match word.rsplit_once('.') {
            Some(_) => at(word).to_string_lossy().into_owned(),
            None => (*word).to_owned(),
        });
        let options: Vec<_> = options.collect();
        let (scene, output) = (at("s.gltf"), at(output));
        let command = ["render", text(&scene), "-r", "8x6", "-f", "0", "-q", "-o", text(&output)];
        let command: Vec<&str> = command.into_iter().chain(options.iter().map(String::as_str)).collect();
        let ran = rayframe(&command);
        assert_eq!(ran.status.code(), Some(0), "{command:?}: {}", stderr(&ran));
        for name in empty {
            assert!(at(name).metadata().unwrap().len() > 0, "{command:?}: {name}");
        }
    }
}

#[test]
fn merged_images_replace_empty_files_and_no_others() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let (scene, whole) = (at("s.gltf"), at("whole.exr"));
    let tiles = [at("left.exr"), at("right.exr")];
    for (tile, crop) in tiles.iter().zip(["0,0,4,6", "4,0,8,6"]) {
        let command =
            ["render", text(&scene), "-r", "8x6", "--crop", crop, "-f", "0", "-q", "-o", text(tile)];
        assert_eq!(rayframe(&command).status.code(), Some(0));
    }
    let command = ["merge", text(&tiles[0]), text(&tiles[1]), "-o", text(&whole)];
    std::fs::write(&whole, FOREIGN).unwrap();
    assert_eq!(rayframe(&command).status.code(), Some(73));
    std::fs::write(&whole, "").unwrap();
    let merged = rayframe(&command);
    assert_eq!(merged.status.code(), Some(0), "{}", stderr(&merged));
    assert!(whole.metadata().unwrap().len() > 0);
}

#[test]
fn a_movie_as_the_output_replaces_movies_of_this_program_alone() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let scene = at("s.gltf");
    for name in ["a.apng", "a.webp", "a.gif"] {
        let file = at(name);
        let render = |options: &[&str]| {
            let command = ["render", text(&scene), "-r", "8x6", "-f", "1-3", "-q", "-o", text(&file)];
            rayframe(&both(&command, options))
        };
        std::fs::write(&file, FOREIGN).unwrap();
        let refused = render(&[]);
        assert_eq!(refused.status.code(), Some(73), "{name}: {}", stderr(&refused));
        assert!(stderr(&refused).contains("is not a movie of this program"), "{}", stderr(&refused));
        assert_eq!(std::fs::read(&file).unwrap(), FOREIGN);
        assert_eq!(render(&["--overwrite"]).status.code(), Some(0));
        let movie = std::fs::read(&file).unwrap();
        let again = render(&["--exposure", "1"]);
        assert_eq!(again.status.code(), Some(0), "{name}: {}", stderr(&again));
        assert_ne!(std::fs::read(&file).unwrap(), movie);
    }
}
