//! Settings of a shot file that have no effect beside what was typed, or contradict it, give way to it.

use std::path::Path;
use std::process::{Command, Output};

use crate::stderr;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");
const KEYS: &str = "[[key]]\ntime = 0\nposition = [0, 1, 5]\nlook_at = [0, 0, 0]\n\n\
    [[key]]\ntime = 1\nposition = [4, 1, 4]\nlook_at = [0, 0, 0]\n";

/// Renders a shot file of these lines with these options.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn render(folder: &Path, lines: &str, options: &[&str]) -> Output {
    let text = format!("scene = '{SCENE}'\nresolution = [16, 9]\nframes = 0\n{lines}");
    std::fs::write(folder.join("a.toml"), text).unwrap();
    std::fs::write(folder.join("x.toml"), KEYS).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.current_dir(folder).args(["render", "a.toml", "-q"]).args(options).output().unwrap()
}

/// Settings of the file, and options of which each makes them meaningless.
#[test]
fn settings_of_a_file_give_way_to_stronger_ones() {
    let exr = "output = 'a.####.exr'\naovs = ['depth', 'crypto']\nexr = ['float', 'piz']\nsplit_aovs = true\nstamp = true\n\
        preview = 'png'\nresume = true\n";
    for (lines, options, gone) in [
        (
            "integrator = 'path'\nseed = 3\ncheckpoint = true\nnoise = 0.1\n",
            &["--integrator", "whitted"][..],
            &["seed", "checkpoint", "noise"][..],
        ),
        ("glossy = 3\n", &["--integrator", "path"], &["glossy"]),
        (
            "max_samples = 8\naa_threshold = 0.1\n",
            &["-D", "integrator=path"],
            &["max_samples", "aa_threshold"],
        ),
        ("max_samples = 32\n", &["--samples", "64"], &["max_samples"]),
        ("turntable = 5\nelevation = 10\n", &["--camera-path", "x.toml"], &["turntable", "elevation"]),
        (exr, &["-o", "look.png"], &["aovs", "exr", "split_aovs", "stamp", "preview"]),
        (exr, &["-o", "look.gif"], &["aovs", "exr", "split_aovs", "stamp", "preview", "resume"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let planned = render(folder.path(), lines, &crate::both(options, &["-n"]));
        let shot = String::from_utf8_lossy(&planned.stdout).into_owned();
        assert_eq!(planned.status.code(), Some(0), "{lines}{options:?}: {}", stderr(&planned));
        for name in gone {
            let key = format!("{name} = ");
            let is_printed = shot.lines().any(|line| line.starts_with(&key) && !line.ends_with("= 0"));
            assert!(!is_printed && (lines.contains(&key)), "{name} in {shot}");
        }
        if options.contains(&"-o") {
            let output = render(folder.path(), lines, &crate::both(options, &["--samples", "1"]));
            assert_eq!(output.status.code(), Some(0), "{lines}{options:?}: {}", stderr(&output));
            assert!(folder.path().join(options[1]).is_file());
        }
    }
}

#[test]
fn settings_of_one_level_that_contradict_each_other_are_errors() {
    for (lines, options, code, word) in [
        ("integrator = 'whitted'\nseed = 3\n", &[][..], 65, "a.toml:5:1: seed: "),
        ("integrator = 'path'\nglossy = 3\n", &[], 65, "a.toml:5:1: glossy: "),
        ("samples = 64\nmax_samples = 32\n", &[], 65, "a.toml:5:1: max_samples: "),
        ("output = 'a.png'\naovs = 'depth'\n", &[], 65, "a.toml:4:1: output: "),
        ("", &["--integrator", "whitted", "--seed", "3"], 2, "--seed: "),
        ("", &["-o", "a.png", "--aovs", "depth"], 2, "--output: "),
        ("", &["-o", "a.gif", "--resume"], 2, "--resume: "),
        ("", &["--samples", "8", "--max-samples", "4"], 2, "--max-samples: "),
        ("", &["--elevation", "8"], 2, "--elevation: "),
        // What is typed is never left out.
        ("integrator = 'path'\n", &["--glossy", "3"], 2, "--glossy: "),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let output = render(folder.path(), lines, &crate::both(options, &["-n"]));
        assert_eq!(output.status.code(), Some(code), "{lines}{options:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(word), "{lines}{options:?}: {}", stderr(&output));
    }
}

#[test]
fn all_frames_replace_the_range_of_a_file() {
    let frames = |lines: &str, options: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.toml"), format!("scene = '{SCENE}'\n{lines}")).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
        command.current_dir(folder.path()).args(["render", "a.toml", "-q", "-n"]).args(options);
        let planned = command.output().unwrap();
        assert_eq!(planned.status.code(), Some(0), "{lines}{options:?}: {}", stderr(&planned));
        let shot = String::from_utf8_lossy(&planned.stdout).into_owned();
        shot.lines().find(|line| line.starts_with("frames = ")).map(str::to_owned).unwrap()
    };
    let range = "start = 5\nend = 8\nstep = 2\n";
    let all = frames("", &[]);
    assert_ne!(all, frames(range, &[]));
    for options in [&["-a"][..], &["-f", "all"], &["-D", "all=true"]] {
        assert_eq!(frames(range, options), all, "{options:?}");
    }
    // As with Blender, the range of one command line counts.
    let typed = ["-s", "1", "-e", "3"];
    assert_eq!(frames("", &crate::both(&["-a"], &typed)), frames("", &typed));
    assert_eq!(frames("all = true\n", &typed), frames("", &typed));
}

#[test]
fn ranges_of_samples_give_way_to_what_excludes_them_alone() {
    let planned = |lines: &str, options: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        render(folder.path(), &format!("integrator = 'path'\n{lines}"), &crate::both(options, &["-n"]))
    };
    // Settings of one file that contradict each other, and options that have nothing to do with it
    for lines in [
        "noise = 0.1\nsample_range = '0-7'\n",
        "samples = 64\nsample_range = '0-70'\n",
        "aovs = 'crypto'\nsample_range = '0-3'\n",
    ] {
        for options in [&[][..], &["-o", "x.exr"], &["--exposure", "1"]] {
            let refused = planned(lines, options);
            assert_eq!(refused.status.code(), Some(65), "{lines}{options:?}: {}", stderr(&refused));
        }
    }
    let lines = "samples = 64\nsample_range = '0-63'\n";
    for options in [
        &["--samples", "32"][..],
        &["--noise", "0.1"],
        &["--time-limit", "1s"],
        &["-o", "x.png"],
        &["--aovs", "crypto"],
        &["--shutter", "0.5", "--time-samples", "3"],
    ] {
        let done = planned(lines, options);
        assert_eq!(done.status.code(), Some(0), "{options:?}: {}", stderr(&done));
        assert!(!String::from_utf8_lossy(&done.stdout).contains("sample_range ="), "{options:?}");
    }
    let kept = planned(lines, &["-o", "x.exr", "--samples", "128", "--aovs", "light"]);
    assert!(String::from_utf8_lossy(&kept.stdout).contains("sample_range = "), "{kept:?}");
}
