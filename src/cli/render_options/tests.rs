use clap::{Args as _, Command, FromArgMatches as _};
use rayframe::scene::NameOrIndex;
use rayframe::sequence::FrameSpec;

use super::*;

/// Options typed after `rayframe render`.
fn options(arguments: &[&str]) -> RenderOptions {
    let command = RenderOptions::augment_args(Command::new("render").no_binary_name(true));
    RenderOptions::from_arg_matches(&command.try_get_matches_from(arguments).unwrap()).unwrap()
}

fn shot(text: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap().to_owned();
    (folder, path)
}

#[test]
fn options_override_definitions_and_both_override_the_file() {
    let (_folder, path) = shot(concat!(
        "scene = 'a.glb'\nsamples = 2\ndepth = 2\nglossy = 2\nresume = true\nresolution = [64, 36]\n",
        "shadow_catcher = ['a', 'b']\nframes = 7\nquiet = true"
    ));
    let arguments = "--samples 4 -D samples=3 -D depth=3 -D resume=false -W 9 -D shadow-catcher=c \
                     -D shadow_catcher=d -s 3 -v";
    let arguments: Vec<&str> = std::iter::once(path.as_str()).chain(arguments.split_whitespace()).collect();
    let merged = options(&arguments).settings().unwrap();
    let values = &merged.values;
    assert_eq!((values.samples, values.depth, values.glossy), (4, 3, 2));
    assert!(!values.resume);
    // What cannot be combined with an option gives way to it.
    assert_eq!((values.width, values.resolution), (Some(9), None));
    assert_eq!((values.start, &values.frames), (Some(3), &None));
    assert_eq!((values.verbose, values.quiet), (true, false));
    assert_eq!(values.shadow_catcher, ["c", "d"]);
    assert_eq!(merged.scene, Path::new(&path).with_file_name("a.glb"));
}

#[test]
fn a_typed_default_overrides_the_file() {
    let (_folder, path) = shot("scene = 'a.glb'\nsamples = 16");
    assert_eq!(options(&[&path]).settings().unwrap().values.samples, 16);
    assert_eq!(options(&[&path, "--samples", "4"]).settings().unwrap().values.samples, 4);
}

#[test]
fn scenes_come_from_the_command_line_or_the_file() {
    let (_folder, path) = shot("samples = 9");
    let merged = options(&["b.glb", "--config", &path]).settings().unwrap();
    assert_eq!((merged.scene.as_path(), merged.values.samples), (Path::new("b.glb"), 9));
    let merged = options(&["--config", &path, "-D", "scene=-c.glb"]).settings().unwrap();
    assert_eq!(merged.scene, Path::new("-c.glb"));
    assert!(options(&[&path]).settings().unwrap_err().to_string().contains("names no scene"));
    assert!(options(&["-D", "samples=1"]).settings().unwrap_err().to_string().contains("no scene"));
    assert!(options(&[&path, "--config", &path]).settings().unwrap_err().to_string().contains("--config"));
}

#[test]
fn earlier_spellings_are_accepted() {
    let values =
        options(&["a.glb", "--layers", "depth", "--aperture", "f/2", "--focus", "middle", "--spp", "2"])
            .settings()
            .unwrap()
            .values;
    assert_eq!(values.aovs.unwrap().as_slice().len(), 2);
    assert_eq!((values.focus, values.samples), (rayframe::settings::FocusRequest::Center, 2));
    let values = options(&[
        "a.glb",
        "-D",
        "layers=[\"depth\", \"uv\"]",
        "-D",
        "scene_choice=#1",
        "-D",
        "frames=[1, 3]",
    ])
    .settings()
    .unwrap()
    .values;
    assert_eq!(values.aovs.unwrap().as_slice().len(), 3);
    assert_eq!(values.scene_choice, Some(NameOrIndex::Index(1)));
    assert_eq!(values.frames, Some(FrameSpec::Listed(vec![1, 3])));
}

#[test]
fn a_scene_that_is_the_value_of_an_option_is_refused() {
    let typed = |arguments: &[&str]| options(arguments).settings().map_err(|error| message(&error));
    let why = typed(&["--ground", "reflection", "a.glb"]).unwrap_err();
    assert!(why.ends_with("write --ground=reflection"), "{why}");
    assert!(typed(&["reflection"]).is_ok() && typed(&["a.glb", "--ground"]).is_ok());
}
