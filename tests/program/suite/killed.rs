//! Commands that are killed lose no reference.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use super::{SUITE, Stage};

const SHOTS: usize = 40;

/// Bytes of all files below the folder of references.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn references(stage: &Stage) -> BTreeMap<String, Vec<u8>> {
    let read = |name: String| (name.clone(), std::fs::read(stage.path("references").join(name)).unwrap());
    stage.references().into_iter().map(read).collect()
}

#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn spawn(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayframe"));
    command.args(arguments).current_dir(folder).env_remove("CI").stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().unwrap()
}

/// Starts the command, and kills it once so many pending images are left or stored.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn killed_when(stage: &Stage, arguments: &[&str], pending: impl Fn(usize) -> bool) {
    let mut child = spawn(stage.0.path(), arguments);
    let count = || stage.references().iter().filter(|name| name.ends_with(".exr.new")).count();
    while child.try_wait().unwrap().is_none() && !pending(count()) {}
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_killed_test_or_accept_leaves_whole_references() {
    let stage = Stage::new(SUITE);
    for number in 0..SHOTS {
        stage.scene(&format!("shot{number:02}.gltf"), "light/point.gltf", "", "");
    }
    stage.run(&["test", "-q"]).ends(1, &[]);
    stage.run(&["accept"]).ends(0, &[]);
    let old = references(&stage);
    assert_eq!(old.len(), SHOTS);

    // Killed while testing: no reference changed, and pending images are whole.
    stage.write("suite.toml", &format!("{SUITE}light_scale = 3\n"));
    killed_when(&stage, &["test", "--no-cache"], |pending| pending >= 5);
    let partly = references(&stage);
    assert!(old.iter().all(|(name, bytes)| partly.get(name) == Some(bytes)));
    stage.run(&["test", "-q"]).ends(1, &[]);
    let tested = references(&stage);
    let new = |name: &str| tested.get(&format!("{name}.new"));
    for (name, bytes) in partly.iter().filter(|(name, _)| name.ends_with(".exr.new")) {
        assert_eq!(tested.get(name), Some(bytes), "{name}");
    }

    // Killed while accepting: each reference is the old or the new one, and what is not accepted is still pending.
    killed_when(&stage, &["accept"], |pending| pending < SHOTS - 5);
    let now = references(&stage);
    for (name, bytes) in &old {
        let is_new = now.get(name) == new(name);
        assert!(is_new || now.get(name) == Some(bytes), "{name}");
        assert!(is_new || now.contains_key(&format!("{name}.new")), "{name}");
    }
    // The next runs end what was begun.
    stage.run(&["test", "-q"]);
    stage.run(&["accept"]).ends(0, &[]);
    stage.run(&["test"]).ends(0, &["40 images identical"]);
    let last = references(&stage);
    assert_eq!(last.len(), SHOTS, "{:?}", stage.references());
    assert!(old.keys().all(|name| last.get(name) == new(name)));
}
