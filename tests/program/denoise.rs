//! `--denoise oidn`, with a program in place of oidnDenoise: it takes its options and copies an image.
#![cfg(unix)]

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use rayframe::image::Image;
use rayframe::image_file::decode_exr;

use crate::rayframe;

/// A program that copies the first input that is named to the output.
pub(crate) const COPIES: &str = r#"#!/bin/sh
echo "Open Image Denoise 2.9.9"
while [ $# -gt 0 ]; do
  case "$1" in
    --hdr|--alb|--nrm) [ -n "$input" ] || input="$2"; echo "$1" >> "$(dirname "$0")/inputs"; shift;;
    -o) output="$2"; shift;;
  esac
  shift
done
[ -z "$output" ] || cp "$input" "$output"
"#;

/// Writes the program `oidnDenoise` into `folder`, and returns its path.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
pub(crate) fn program(folder: &Path, text: &str) -> String {
    let path = folder.join("oidnDenoise");
    std::fs::write(&path, text).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path.display().to_string()
}

/// Exit code and standard error stream of a render into `out.exr`.
fn render(folder: &Path, options: &[&str]) -> (Option<i32>, String) {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");
    let output = folder.join("out.exr").display().to_string();
    let common = ["render", scene, "-o", &output, "-r", "24x16", "-f", "5", "-q", "--integrator", "path"];
    let ended = rayframe(&[&common, options].concat());
    (ended.status.code(), String::from_utf8_lossy(&ended.stderr).into_owned())
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn image(folder: &Path) -> Image {
    let path = folder.join("out.exr");
    decode_exr(&path, &std::fs::read(&path).unwrap(), u64::MAX).unwrap()
}

#[test]
fn files_hold_denoised_and_noisy_colours() {
    let folder = tempfile::tempdir().unwrap();
    program(folder.path(), COPIES);
    let place = folder.path().display().to_string();
    let (code, said) = render(folder.path(), &["--aovs", "denoising", "--samples", "4"]);
    assert_eq!(code, Some(0), "{said}");
    let plain = image(folder.path());
    let (code, said) =
        render(folder.path(), &["--denoise", "oidn", "--oidn", &place, "--samples", "4", "--overwrite"]);
    assert_eq!(code, Some(0), "{said}");
    let denoised = image(folder.path());
    // The program copies: both are the same.
    for name in ["R", "G", "B"] {
        let noisy = denoised.channel(&format!("noisy.{name}")).unwrap();
        assert_eq!(noisy.samples, denoised.channel(name).unwrap().samples);
        assert_eq!(noisy.samples, plain.channel(name).unwrap().samples);
    }
    assert!(denoised.channel("denoising_albedo.R").is_none() && plain.channel("noisy.R").is_none());
    // Each guide is denoised, and then the colours with both.
    let inputs = std::fs::read_to_string(folder.path().join("inputs")).unwrap();
    assert_eq!(inputs, "--alb\n--nrm\n--hdr\n--alb\n--nrm\n");
    // A file without denoising, or of another crop, is another image.
    for options in [
        &["--samples", "4"][..],
        &["--samples", "4", "--denoise", "oidn", "--oidn", &place, "--crop", "0,0,9,9"],
    ] {
        let (code, said) = render(folder.path(), options);
        assert!(code == Some(73) && said.contains("other settings"), "{said}");
    }
}

#[test]
fn the_denoiser_has_the_threads_of_the_render_and_needs_a_temporary_folder() {
    let folder = tempfile::tempdir().unwrap();
    let tells = COPIES.replace("while [ $#", "echo \"$@\" >> \"$(dirname \"$0\")/arguments\"\nwhile [ $#");
    let place = program(folder.path(), &tells);
    let options = ["--denoise", "oidn", "--oidn", &place, "--samples", "2", "-t", "1"];
    let (code, said) = render(folder.path(), &options);
    assert_eq!(code, Some(0), "{said}");
    let arguments = std::fs::read_to_string(folder.path().join("arguments")).unwrap();
    assert_eq!(arguments.matches("--threads 1 ").count(), 3, "{arguments}");

    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_rayframe"))
        .args(["render", scene, "-n", "--integrator", "path", "--denoise", "oidn", "--oidn", &place])
        .env("TMPDIR", folder.path().join("nowhere"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("no temporary file can be created in") && !said.contains("installed"), "{said}");
}

#[test]
fn a_denoiser_that_is_not_there_or_fails_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let nowhere = folder.path().join("nowhere").display().to_string();
    let (code, said) = render(folder.path(), &["--denoise", "oidn", "--oidn", &nowhere]);
    assert!(code == Some(2) && said.contains("--oidn") && said.contains("cannot be started"), "{said}");
    let other = program(folder.path(), "#!/bin/sh\necho hello\n");
    let (code, said) = render(folder.path(), &["--denoise", "oidn", "--oidn", &other]);
    assert!(code == Some(2) && said.contains("is not the program oidnDenoise"), "{said}");
    let failing = "#!/bin/sh\necho 'Open Image Denoise 2.0.0'\necho 'Error: out of paper' >&2\nexit 1\n";
    let failing = program(folder.path(), failing);
    let (code, said) = render(folder.path(), &["--denoise", "oidn", "--oidn", &failing]);
    assert!(code == Some(74) && said.contains("out of paper"), "{said}");
    // A denoiser that a signal ends, as for lack of memory
    let killed = "#!/bin/sh\necho 'Open Image Denoise 2.0.0'\n[ $# -lt 5 ] || kill -9 $$\n";
    let killed = program(folder.path(), killed);
    let (code, said) = render(folder.path(), &["--denoise", "oidn", "--oidn", &killed]);
    assert!(code == Some(74) && said.contains("it ended with signal: 9"), "{said}");
    let (code, said) = render(folder.path(), &["--denoise", "oidn", "--sample-range", "0-1"]);
    assert!(code == Some(2) && said.contains("needs all samples"), "{said}");
    assert!(!folder.path().join("out.exr").exists());
}

#[test]
fn no_file_names_a_program_that_is_started() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let tells = COPIES.replace("while [ $#", "touch \"$(dirname \"$0\")/started\"\nwhile [ $#");
    let place = program(folder.path(), &tells);
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");
    let settings = "integrator = 'path'\nsamples = 1\nresolution = [16, 9]\nframes = 5\ndenoise = 'oidn'\n";
    let named = format!("{settings}oidn = '../oidnDenoise'\n");
    for name in ["one", "other"] {
        std::fs::create_dir(at(name)).unwrap();
    }
    let (shot, suite, other) = (at("one/shot.toml"), at("one/suite.toml"), at("other/suite.toml"));
    std::fs::write(&shot, format!("scene = '{scene}'\n{named}")).unwrap();
    std::fs::write(&suite, "[test]\npreset = 'visual'\n").unwrap();
    std::fs::copy(scene, at("other/a.gltf")).unwrap();
    std::fs::write(&other, format!("[shot]\n{named}")).unwrap();
    let (job, out) = (at("job"), at("out.exr"));

    for (command, code) in [
        (&["render", &shot, "-n"][..], 77),
        (&["render", &shot, "-o", &out], 77),
        (&["render", scene, "--config", &shot, "-o", &out], 77),
        (&["farm", "parallel", &shot, "--out-dir", &job], 77),
        // A shot that cannot be rendered is a failure of the suite.
        (&["test", "--suite", &suite], 1),
        (&["test", "--suite", &other], 77),
    ] {
        let ended = rayframe(command);
        let said = crate::stderr(&ended) + &String::from_utf8_lossy(&ended.stdout);
        assert_eq!(ended.status.code(), Some(code), "{command:?}: {said}");
        assert!(said.contains("oidn: files may not name programs"), "{command:?}: {said}");
        assert!(!Path::new(&at("started")).exists(), "{command:?}");
    }

    // What is typed is started, and the printed shot says so.
    let typed = ["render", &shot, "--oidn", &place, "-o", &out];
    let planned = rayframe(&crate::both(&typed, &["-n"]));
    let printed = String::from_utf8(planned.stdout).unwrap();
    assert!(Path::new(&at("started")).exists() && !printed.contains("\noidn ="), "{printed}");
    assert!(printed.contains(&format!("with --oidn '{place}'\n")), "{printed}");
    assert_eq!(rayframe(&typed).status.code(), Some(0));
    std::fs::write(at("printed.toml"), printed).unwrap();
    let again = rayframe(&["render", &at("printed.toml"), "--oidn", &place, "-n", "--resume"]);
    let said = String::from_utf8_lossy(&again.stdout);
    assert!(again.status.code() == Some(0) && said.contains(" keep "), "{said}{}", crate::stderr(&again));
}
