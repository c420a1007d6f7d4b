//! The pages of the reference, docs/cli.md and docs/schemas.md, the commands of docs/cookbook.md, and the links between all pages.

use std::process::Command;

use crate::{rayframe, skipped, stderr};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Runs a script of tests/oracles and fails with what it prints; skips where there is no Python.
fn run_script(name: &str, arguments: &[&str]) {
    let script = format!("tests/oracles/{name}");
    let Ok(output) = Command::new("python3").current_dir(ROOT).arg(script).args(arguments).output() else {
        skipped("there is no python3");
        return;
    };
    assert!(output.status.success(), "{}{}", String::from_utf8_lossy(&output.stdout), stderr(&output));
}

#[test]
fn pages_of_the_reference_are_those_of_this_program() {
    run_script("reference_pages.py", &[env!("CARGO_BIN_EXE_rayframe"), "--check"]);
}

#[test]
fn links_between_pages_are_whole() {
    run_script("check_links.py", &[]);
}

#[test]
fn every_option_is_on_the_page_of_the_command_line() {
    let page = std::fs::read_to_string(format!("{ROOT}/docs/cli.md")).unwrap();
    let mut options = 0;
    for verb in
        ["render", "merge", "farm", "check", "info", "diff", "test", "accept", "reject", "review", "watch"]
    {
        assert!(page.contains(&format!("\n## rayframe {verb}\n")), "{verb}");
        let help = rayframe(&[verb, "--help"]);
        let help = String::from_utf8_lossy(&help.stdout).into_owned();
        let names = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
        let names = names.filter_map(|line| line.split_whitespace().find(|word| word.starts_with("--")));
        for name in names {
            let name = name.split(['=', '[', ',']).next().unwrap_or_default();
            if !["--help", "--version"].contains(&name) {
                assert!(page.contains(name), "{verb} {name}");
                options += 1;
            }
        }
    }
    assert!(options > 100, "{options} options were read");
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
    assert_eq!(commands.len(), 20);
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
