//! The pages of the reference, docs/cli.md and docs/schemas.md, and the commands of docs/cookbook.md.

use std::process::Command;

use crate::{skipped, stderr};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

#[test]
fn pages_of_the_reference_are_those_of_this_program() {
    let script = "tests/oracles/reference_pages.py";
    let arguments = [script, env!("CARGO_BIN_EXE_rayframe"), "--check"];
    let Ok(output) = Command::new("python3").current_dir(ROOT).args(arguments).output() else {
        skipped("there is no python3");
        return;
    };
    assert!(output.status.success(), "{}{}", String::from_utf8_lossy(&output.stdout), stderr(&output));
}

#[test]
fn positions_of_reports_are_described_as_those_of_the_whole_image() {
    for name in ["diff", "test"] {
        let text = std::fs::read_to_string(format!("{ROOT}/schema/{name}.schema.json")).unwrap();
        let positions: Vec<_> = text.lines().filter(|line| line.contains("\"Column and row of ")).collect();
        assert!(positions.len() > 1, "{name}");
        for position in positions {
            assert!(
                position.contains("in the whole image, also where files hold a crop of it"),
                "{position}"
            );
        }
    }
}

/// A command of the cookbook with few pixels and samples; parts of samples keep their number.
#[cfg(unix)]
fn small(command: &str) -> String {
    let mut words: Vec<&str> = command.split(' ').collect();
    let has_parts = words.contains(&"--sample-range");
    for index in 1..words.len() {
        match words[index - 1] {
            "-r" => words[index] = "32x18",
            "--samples" if !has_parts => words[index] = "1",
            _ => {}
        }
    }
    words.join(" ")
}

#[cfg(unix)]
#[test]
fn commands_of_the_cookbook_succeed() {
    use std::os::unix::fs::symlink;

    let page = std::fs::read_to_string(format!("{ROOT}/docs/cookbook.md")).unwrap();
    let commands: Vec<&str> =
        page.split("\n```sh\n").skip(1).filter_map(|rest| Some(rest.split_once("\n```")?.0)).collect();
    assert_eq!(commands.len(), 21);
    let folder = tempfile::tempdir().unwrap();
    symlink(format!("{ROOT}/scenes"), folder.path().join("scenes")).unwrap();
    symlink(env!("CARGO_BIN_EXE_rayframe"), folder.path().join("rayframe")).unwrap();
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap());
    for command in commands {
        let output = Command::new("sh")
            .args(["-ec", &small(command)])
            .current_dir(folder.path())
            .env("PATH", &path)
            .output()
            .unwrap();
        assert!(output.status.success(), "{command}: {}", stderr(&output));
    }
}
