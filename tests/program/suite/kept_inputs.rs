//! Results for build servers replace no input, no file of the report, and not each other.

use super::kept_files::write_image;
use super::{SUITE, Stage};

const POINT: (&str, &str) = ("a/point.gltf", "light/point.gltf");
const OPTIONS: [&str; 3] = ["--junit", "--summary", "--code-quality"];

#[test]
fn results_replace_no_input_even_with_overwrite() {
    let stage = Stage::new(&format!("{SUITE}env = 'sky.exr'\n"));
    write_image(&stage, "sky.exr", (8, 4));
    stage.scene(POINT.0, POINT.1, "", "");
    stage.scene("base.gltf", "light/spot.gltf", "", "");
    stage.write("near.toml", "scene = 'base.gltf'\n");
    stage.run(&["test", "-q"]).ends(1, &[]);
    stage.run(&["accept"]).ends(0, &[]);
    stage.write("references/notes.txt", "of the references");
    std::fs::remove_dir_all(stage.path("report")).unwrap();
    let inputs = [
        "suite.toml",
        "near.toml",
        "base.gltf",
        POINT.0,
        "a/../a/point.gltf",
        "sky.exr",
        "references/near.exr",
        "references/notes.txt",
    ];
    for (at, input) in inputs.into_iter().enumerate() {
        let option = OPTIONS[at % OPTIONS.len()];
        let before = std::fs::read(stage.path(input)).unwrap();
        let refused = format!(
            "{option}: \"{input}\" is an input and cannot be written to as well; choose another name"
        );
        stage.run(&["test", option, input, "--overwrite"]).ends(2, &[&refused]);
        assert_eq!(std::fs::read(stage.path(input)).unwrap(), before, "{input}");
    }
    // Nothing was rendered.
    assert!(!stage.path("report").exists());
    // Files of earlier runs are replaced, wherever they are, and others where it is permitted.
    for name in ["references/junit.xml", "references/junit.xml", "junit.xml"] {
        stage.run(&["test", "--junit", name]).ends(0, &["2 images identical"]);
    }
    stage.write("junit.xml", "<of another program/>");
    stage.run(&["test", "--junit", "junit.xml"]).ends(73, &["junit.xml: is there already"]);
    stage.run(&["test", "--junit", "junit.xml", "--overwrite"]).ends(0, &[]);
}

#[cfg(unix)]
#[test]
fn what_a_link_of_a_suite_leads_to_is_an_input() {
    let stage = Stage::new(SUITE);
    stage.scene(".store/real.gltf", POINT.1, "", "");
    std::os::unix::fs::symlink(stage.path(".store/real.gltf"), stage.path("point.gltf")).unwrap();
    let test = ["test", "--junit", ".store/real.gltf", "--overwrite"];
    stage.run(&test).ends(2, &["\".store/real.gltf\" is an input"]);
}

#[test]
fn results_and_reports_have_names_of_their_own() {
    let stage = Stage::new(SUITE);
    stage.scene(POINT.0, POINT.1, "", "");
    for (others, option, file) in [
        (&["--junit", "j.x"][..], "--summary", "j.x"),
        (&["--junit", "j.x"], "--code-quality", "./j.x"),
        (&[], "--junit", "report/index.html"),
        (&[], "--junit", "report/result.json"),
        (&[], "--code-quality", "report/images.json"),
        (&[], "--summary", "report/images/a/point.exr"),
        (&["--report", "pages"], "--summary", "pages/index.html"),
    ] {
        let refused =
            format!("{option}: \"{file}\" will hold something else and cannot be written to as well");
        stage.run(&[&["test", option, file], others].concat()).ends(2, &[&refused]);
    }
    for name in ["j.x", "report", "pages", "references"] {
        assert!(!stage.path(name).exists(), "{name}");
    }
    stage.run(&["test", "--report", "pages", "--junit", "report/index.html"]).ends(1, &[]);
    // Reports that are merged are inputs.
    for part in ["1/2", "2/2"] {
        stage.run(&["test", "-q", "--shard", part, "--report", &part[..1]]);
    }
    let merge = ["test", "--code-quality", "1/result.json", "--overwrite", "--merge", "1", "2"];
    stage.run(&merge).ends(2, &["\"1/result.json\" is an input"]);
}
