//! Pipes in the place of files, which would keep whoever opens them waiting for ever.

#![cfg(unix)]

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::triangle::{document, triangle};

const LIMIT: Duration = Duration::from_secs(20);

/// Exit code of a command in `folder`; `None` where it does not end.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn code(folder: &Path, arguments: &[&str]) -> Option<i32> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.args(arguments).current_dir(folder).env_remove("CI");
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let (mut child, start) = (command.spawn().unwrap(), Instant::now());
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > LIMIT {
            child.kill().unwrap();
            child.wait().unwrap();
            return None;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    child.wait().unwrap().code()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn make_pipe(path: &Path) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn pipes_are_refused_without_waiting() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("good.gltf"), triangle().to_string()).unwrap();
    std::fs::write(at("bad.gltf"), document(Some("p.bin")).to_string()).unwrap();
    std::fs::write(at("suite.toml"), "[shot]\nresolution = [8, 8]\n").unwrap();
    for name in ["p.bin", "p.gltf", "p.toml", "p.exr", "p.hdr", "p.json", "report/images.json"] {
        make_pipe(&at(name));
    }
    let render = ["render", "good.gltf", "-r", "8x8"];
    assert_eq!(code(folder.path(), &[&render[..], &["-o", "a.exr"]].concat()), Some(0));
    let cases: [(&[&str], i32); 17] = [
        (&["render", "bad.gltf"], 65),
        (&["render", "p.gltf"], 65),
        (&["render", "p.toml"], 65),
        (&["render", "good.gltf", "--config", "p.toml"], 65),
        (&["render", "good.gltf", "--env", "p.hdr"], 65),
        (&["render", "good.gltf", "--background", "p.exr"], 65),
        (&["render", "good.gltf", "--camera-path", "p.toml"], 65),
        (&["render", "good.gltf", "-o", "p.exr"], 73),
        (&["render", "good.gltf", "-o", "b.exr", "--stats", "p.json"], 73),
        (&["info", "p.gltf"], 65),
        (&["diff", "p.exr", "a.exr"], 65),
        (&["diff", "a.exr", "p.exr"], 65),
        (&["merge", "p.exr", "-o", "c.exr"], 65),
        (&["farm", "slurm", "good.gltf", "--out-dir", "job", "--cost", "p.json"], 65),
        (&["check", "p.exr"], 1),
        (&["accept", "--approvals", "p.json"], 65),
        (&["accept", "--from", "report"], 65),
    ];
    for (arguments, expected) in cases {
        assert_eq!(code(folder.path(), arguments), Some(expected), "{arguments:?}");
    }

    // As a reference.
    let suite = tempfile::tempdir().unwrap();
    std::fs::copy(at("good.gltf"), suite.path().join("good.gltf")).unwrap();
    std::fs::copy(at("suite.toml"), suite.path().join("suite.toml")).unwrap();
    make_pipe(&suite.path().join("references/good.exr"));
    assert_eq!(code(suite.path(), &["test", "-q"]), Some(1));
}
