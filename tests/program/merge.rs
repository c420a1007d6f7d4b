//! `rayframe merge`: merged crops equal the file of one render, and incomplete or foreign tiles are refused.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Crops in two columns and three rows of an image of 48x27, of unequal sizes and across blocks of scan lines.
const TILES: [&str; 6] = ["0,0,20,9", "20,0,48,9", "0,9,20,17", "20,9,48,17", "0,17,20,27", "20,17,48,27"];

/// A folder for runs of the program and renders of one scene.
struct Stage {
    folder: tempfile::TempDir,
}

/// Exit code and output of a run.
struct Ended {
    code: Option<i32>,
    said: String,
}

impl Stage {
    fn new() -> Self {
        #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
        let folder = tempfile::tempdir().unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    fn run(&self, arguments: &[&str]) -> Ended {
        let output = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .current_dir(self.folder.path())
            .args(arguments)
            .output()
            .unwrap();
        assert!(output.stdout.is_empty());
        Ended { code: output.status.code(), said: String::from_utf8_lossy(&output.stderr).into_owned() }
    }

    fn render(&self, output: &str, options: &[&str]) {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/demo/whitted_1980.gltf");
        let scene = scene.display().to_string();
        let size = if options.contains(&"-r") { &[][..] } else { &["-r", "48x27"] };
        let frames = if options.contains(&"-f") { &[][..] } else { &["-f", "5"] };
        let common = ["render", &scene, "-o", output, "--samples", "1", "-q"];
        let ended = self.run(&[&common, size, frames, options].concat());
        assert_eq!(ended.code, Some(0), "{options:?}: {}", ended.said);
    }

    /// Renders the tiles as `PREFIX0.exr` and so on; returns their names.
    fn render_tiles(&self, prefix: &str, options: &[&str]) -> Vec<String> {
        let name = |index: usize| format!("{prefix}{index}.exr");
        for (index, crop) in TILES.iter().enumerate() {
            self.render(&name(index), &[&["--crop", crop], options].concat());
        }
        (0..TILES.len()).map(name).collect()
    }

    fn merge(&self, tiles: &[impl AsRef<str>], options: &[&str]) -> Ended {
        let tiles: Vec<&str> = tiles.iter().map(AsRef::as_ref).collect();
        self.run(&[&["merge"], tiles.as_slice(), options].concat())
    }

    /// Asserts that the merge fails with `code`, in one line with all `words`, and does not write `whole.exr`.
    fn assert_fails(&self, tiles: &[&str], code: i32, words: &[&str]) {
        let ended = self.merge(tiles, &["-o", "whole.exr"]);
        assert_eq!(ended.code, Some(code), "{tiles:?}: {}", ended.said);
        assert_eq!(ended.said.lines().count(), 1, "{}", ended.said);
        for word in words {
            assert!(ended.said.contains(word), "\"{word}\" is not in: {}", ended.said);
        }
        assert!(!self.path("whole.exr").exists());
    }
}

#[test]
fn merged_tiles_are_the_whole_frame_to_the_last_byte() {
    let kinds: [&[&str]; 4] = [
        &[],
        &["--exr", "float,piz"],
        &["--layers", "all", "--exr", "half,zips"],
        &["--layers", "depth,crypto", "--exr", "half,none"],
    ];
    for (kind, options) in kinds.iter().enumerate() {
        let stage = Stage::new();
        stage.render("expected.exr", options);
        let mut tiles = stage.render_tiles("tile", options);
        // The order of the tiles does not matter.
        tiles.rotate_left(kind + 1);
        let ended = stage.merge(&tiles, &["-o", "new/whole.exr"]);
        assert_eq!(ended.code, Some(0), "{options:?}: {}", ended.said);
        assert_eq!(ended.said, "new/whole.exr: 6 tiles merged\n");
        assert!(stage.bytes("new/whole.exr") == stage.bytes("expected.exr"), "{options:?}");
    }
}

#[test]
fn split_aovs_are_merged_one_by_one_without_stamps() {
    let stage = Stage::new();
    let options = ["--layers", "depth", "--split-aovs"];
    stage.render("expected.exr", &options);
    let tiles = stage.render_tiles("tile", &[&options[..], &["--stamp"]].concat());
    let depths: Vec<_> = (0..TILES.len()).map(|index| format!("tile{index}.depth.exr")).collect();
    for (tiles, name) in [(&tiles, "expected.exr"), (&depths, "expected.depth.exr")] {
        let ended = stage.merge(tiles, &["-o", "whole.exr", "--overwrite"]);
        assert_eq!(ended.code, Some(0), "{}", ended.said);
        assert!(stage.bytes("whole.exr") == stage.bytes(name), "{name}");
    }
    // The merged file of another AOV is no merged file of these.
    let ended = stage.merge(&tiles, &["-o", "whole.exr"]);
    assert!(ended.code == Some(73) && ended.said.contains("--overwrite"), "{}", ended.said);
    // Files of different AOVs are not parts of one image.
    let ended = stage.merge(&[tiles, depths].concat(), &["-o", "both.exr"]);
    assert_eq!(ended.code, Some(65), "{}", ended.said);
    assert!(ended.said.contains("tile0.depth.exr: has the channels Z float"), "{}", ended.said);
}

#[test]
fn sequences_are_merged_frame_by_frame() {
    let stage = Stage::new();
    let frames = ["-f", "-1-1"];
    stage.render("expected.####.exr", &frames);
    for (index, crop) in ["0,0,48,10", "0,10,48,27"].iter().enumerate() {
        stage.render(&format!("tiles/{index}.####.exr"), &[&frames[..], &["--crop", crop]].concat());
    }
    let names = |frames: &[&str]| -> Vec<String> {
        frames.iter().flat_map(|frame| [0, 1].map(|tile| format!("tiles/{tile}.{frame}.exr"))).collect()
    };
    let all = names(&["-001", "0000", "0001"]);
    let ended = stage.merge(&all, &["-o", "out/whole.%04d.exr"]);
    assert_eq!(ended.code, Some(0), "{}", ended.said);
    for frame in ["-001", "0000", "0001"] {
        let (merged, expected) = (format!("out/whole.{frame}.exr"), format!("expected.{frame}.exr"));
        assert!(stage.bytes(&merged) == stage.bytes(&expected), "{frame}");
    }

    // A second merge has nothing to do. A file that is not the merged image is not replaced without --overwrite.
    let ended = stage.merge(&all, &["-o", "out/whole.%04d.exr"]);
    assert_eq!((ended.code, ended.said.matches("was there already").count()), (Some(0), 3));
    let whole = stage.bytes("out/whole.0000.exr");
    std::fs::write(stage.path("out/whole.0000.exr"), &whole[..whole.len() - 1]).unwrap();
    let ended = stage.merge(&all, &["-o", "out/whole.%04d.exr"]);
    assert_eq!(ended.code, Some(73), "{}", ended.said);
    assert!(
        ended.said.contains("out/whole.0000.exr: ") && ended.said.contains("--overwrite"),
        "{}",
        ended.said
    );
    let ended = stage.merge(&all, &["-o", "out/whole.%04d.exr", "--overwrite", "-q"]);
    assert_eq!((ended.code, ended.said.as_str()), (Some(0), ""));
    assert!(stage.bytes("out/whole.0000.exr") == whole);

    // A frame with a missing tile stops the merge, and several frames need a frame pattern.
    let ended = stage.merge(&all[1..], &["-o", "less/whole.####.exr"]);
    assert_eq!(ended.code, Some(65), "{}", ended.said);
    assert!(
        ended.said.contains("less/whole.-001.exr: ") && ended.said.contains("0,0,48,10"),
        "{}",
        ended.said
    );
    assert!(!stage.path("less").exists());
    let ended = stage.merge(&all, &["-o", "whole.exr"]);
    assert_eq!(ended.code, Some(65), "{}", ended.said);
    assert!(ended.said.contains("shows frame") && ended.said.contains("####"), "{}", ended.said);
}

#[test]
fn tiles_that_do_not_form_one_whole_image_are_refused() {
    let stage = Stage::new();
    let tiles = stage.render_tiles("tile", &[]);
    let tiles: Vec<&str> = tiles.iter().map(String::as_str).collect();
    let with = |index: usize, other: &'static str| {
        let mut tiles = tiles.clone();
        tiles[index] = other;
        tiles
    };
    // The first missing region is named.
    stage.assert_fails(
        &tiles[1..],
        65,
        &["whole.exr: ", "no tile has the pixels 0,0,20,9;", "--crop 0,0,20,9"],
    );
    stage.assert_fails(&tiles[..4], 65, &["0,17,48,27"]);
    // Overlaps are named.
    stage.assert_fails(&with(1, "tile0.exr"), 65, &["tile0.exr: has the pixels 0,0,20,9 that tile0.exr has"]);
    stage.render("wide.exr", &["--crop", "18,9,48,17"]);
    stage.assert_fails(&with(3, "wide.exr"), 65, &["wide.exr: has the pixels 18,9,20,17 that tile2.exr has"]);

    // Tiles of another render, with the attribute that differs, also when they come first.
    let crop = ["--crop", TILES[0]];
    let foreign: [(&'static str, &[&str], &str); 5] = [
        ("settings.exr", &["--depth", "3"], "other settings or by another version than tile1.exr"),
        ("frame.exr", &["-f", "6"], "shows frame 6, not 5 as tile1.exr; put #### into -o"),
        ("size.exr", &["-r", "50x27"], "is part of an image of 50x27 pixels, not 48x27 as tile1.exr"),
        ("packed.exr", &["--exr", "piz"], "is compressed as piz, not zip as tile1.exr"),
        ("float.exr", &["--exr", "float"], "has the channels A float, B float, G float, R float, not A half"),
    ];
    for (name, options, words) in foreign {
        stage.render(name, &[&crop[..], options].concat());
        stage.assert_fails(&with(0, name), 65, &[&format!("{name}: "), words]);
    }

    // Files that are no tiles.
    std::fs::write(stage.path("text.exr"), "not an image").unwrap();
    std::fs::create_dir(stage.path("folder.exr")).unwrap();
    let whole = stage.bytes("tile0.exr");
    std::fs::write(stage.path("short.exr"), &whole[..whole.len() - 9]).unwrap();
    stage.render("lossy.exr", &[&crop[..], &["--exr", "dwaa"]].concat());
    stage.assert_fails(&with(0, "text.exr"), 65, &["text.exr: not an OpenEXR file"]);
    stage.assert_fails(&with(0, "folder.exr"), 65, &["folder.exr: "]);
    stage.assert_fails(&with(0, "short.exr"), 65, &["short.exr: is damaged"]);
    stage.assert_fails(&with(0, "lossy.exr"), 65, &["lossy.exr: dwaa is lossy"]);
    stage.assert_fails(&with(0, "missing.exr"), 66, &["missing.exr: cannot be read"]);
}

#[test]
fn invalid_output_names_are_refused() {
    let stage = Stage::new();
    stage.render("a.exr", &[]);
    let before = stage.bytes("a.exr");
    for (options, code, word) in [
        (&["-o", "./a.exr", "--overwrite"][..], 2, "one of the tiles"),
        (&["-o", "whole.png"], 2, ".exr"),
        (&["-o", "whole"], 2, "extension"),
        (&["-o", "{layer}.exr"], 2, "{layer}"),
        (&["-o", "{scene}.####.exr"], 2, "%{scene}"),
        (&["-o", "a_{camera}.exr"], 2, "%{camera}"),
        (&[], 2, "--output"),
        (&["-o", "a.exr/whole.exr"], 73, "a.exr"),
        (&["-o", "whole.exr", "--max-memory", "9k"], 77, "--max-memory"),
    ] {
        let ended = stage.merge(&["a.exr"], options);
        assert_eq!(ended.code, Some(code), "{options:?}: {}", ended.said);
        assert!(ended.said.contains(word), "{options:?}: {}", ended.said);
    }
    assert_eq!(stage.run(&["merge", "-o", "whole.exr"]).code, Some(2));
    assert!(stage.bytes("a.exr") == before);
    let left: Vec<_> = std::fs::read_dir(stage.folder.path()).unwrap().collect();
    assert_eq!(left.len(), 1);
}

#[test]
fn tiles_are_named_by_patterns() {
    let stage = Stage::new();
    stage.render("expected.####.exr", &["-f", "4-5"]);
    for (name, crop) in [("a", "0,0,20,27"), ("b", "20,0,48,27")] {
        stage.render(&format!("tiles/{name}.####.exr"), &["-f", "4-5", "--crop", crop]);
    }
    let ended = stage.merge(&["tiles/a.####.exr", "tiles/b.%04d.exr"], &["-o", "whole.####.exr"]);
    assert_eq!(ended.code, Some(0), "{}", ended.said);
    assert_eq!(ended.said, "whole.0004.exr: 2 tiles merged\nwhole.0005.exr: 2 tiles merged\n");
    for frame in ["0004", "0005"] {
        assert!(stage.bytes(&format!("whole.{frame}.exr")) == stage.bytes(&format!("expected.{frame}.exr")));
    }
    stage.assert_fails(&["tiles/c.####.exr"], 66, &["c.####.exr: ", "the sequence has no frames"]);
}

/// The output folder is created just before the first frame is merged.
#[cfg(unix)]
#[test]
fn a_signal_ends_the_merge_of_a_frame_within_a_second_and_leaves_nothing() {
    use std::os::unix::process::ExitStatusExt as _;
    use std::time::{Duration, Instant};
    let stage = Stage::new();
    let options = ["-r", "1920x1080", "--layers", "all"];
    for (name, crop) in [("a.exr", "0,0,1920,540"), ("b.exr", "0,540,1920,1080")] {
        stage.render(name, &[&options[..], &["--crop", crop]].concat());
    }
    for (name, number) in [("-INT", 2), ("-TERM", 15)] {
        let folder = format!("out{name}");
        let out = stage.path(&folder);
        let mut child = Command::new(env!("CARGO_BIN_EXE_rayframe"))
            .current_dir(stage.folder.path())
            .args(["merge", "a.exr", "b.exr", "-o", &format!("{folder}/whole.exr")])
            .spawn()
            .unwrap();
        let start = Instant::now();
        while !out.exists() && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let asked = Instant::now();
        assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
        let ended = child.wait().unwrap();
        assert_eq!(ended.signal(), Some(number), "{ended}");
        assert!(asked.elapsed() < Duration::from_secs(1), "{:?}", asked.elapsed());
        assert!(!out.join("whole.exr").exists());
        let left: Vec<_> = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert!(left.is_empty(), "{left:?}");
    }
}
