//! `rayframe completions` and `rayframe man`.

use std::io::Write as _;
use std::process::{Command, Stdio};

use crate::{names, rayframe, skipped, stderr};

/// Whether a shell accepts a script; `None` where the shell is missing.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
fn accepts(shell: &[&str], script: &[u8]) -> Option<bool> {
    let mut child = Command::new(shell[0])
        .args(&shell[1..])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    // A shell that rejects the script may end before it has read all.
    let _ = child.stdin.take().unwrap().write_all(script);
    Some(child.wait().unwrap().success())
}

#[test]
fn every_shell_accepts_its_completions_and_they_name_all_verbs() {
    let help = rayframe(&["--help"]);
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    let commands =
        help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    // Longer descriptions go on in further columns.
    let names = commands.filter_map(|line| line.strip_prefix("  ").filter(|rest| !rest.starts_with(' ')));
    let verbs: Vec<&str> = names.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(verbs.len() > 10 && verbs.contains(&"render"), "{verbs:?}");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = rayframe(&["completions", shell]);
        assert!(output.status.success(), "{}", stderr(&output));
        let script = String::from_utf8_lossy(&output.stdout);
        for name in verbs.iter().copied().chain(["samples", "heat-map"]) {
            assert!(script.contains(name), "{shell}: {name}");
        }
        match accepts(&[shell, "-n"], &output.stdout) {
            _ if matches!(shell, "elvish" | "powershell") => {}
            None => skipped(&format!("{shell} is not installed")),
            Some(is_accepted) => assert!(is_accepted, "{shell}"),
        }
    }
    let unknown = rayframe(&["completions", "tcsh"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(stderr(&unknown).contains("'tcsh'"));
    let program = env!("CARGO_BIN_EXE_rayframe");
    let unnamed = Command::new(program).arg("completions").env("SHELL", "/bin/tcsh").output().unwrap();
    assert_eq!(unnamed.status.code(), Some(2));
    assert!(stderr(&unnamed).contains("SHELL=/bin/tcsh"), "{}", stderr(&unnamed));
}

#[test]
fn completions_complete_verbs_and_options() {
    let script = rayframe(&["completions", "bash"]).stdout;
    let script = String::from_utf8_lossy(&script);
    for (words, expected) in [
        ("rayframe ren", "render"),
        ("rayframe render a.glb --sam", "--samples"),
        ("rayframe render --integrator pa", "path"),
    ] {
        let last = words.split(' ').count() - 1;
        let program = format!(
            "{script}\nCOMP_WORDS=({words}); COMP_CWORD={last}; _rayframe rayframe \"${{COMP_WORDS[{last}]}}\" \"${{COMP_WORDS[{}]}}\"\n\
             printf '%s\\n' \"${{COMPREPLY[@]}}\"",
            last - 1
        );
        let Ok(output) = Command::new("bash").args(["--norc", "-c", &program]).output() else {
            return skipped("bash is not installed");
        };
        let completed = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(completed.lines().any(|line| line == expected), "{words}: {completed} {}", stderr(&output));
    }
}

#[test]
fn manual_pages_are_printed_or_written_and_replace_only_their_like() {
    let page = rayframe(&["man", "render"]);
    assert!(page.status.success());
    let text = String::from_utf8_lossy(&page.stdout).into_owned();
    assert!(text.contains(".TH rayframe-render 1") && text.contains("samples"), "{text}");
    assert_eq!(rayframe(&["man", "rendr"]).status.code(), Some(2));

    let folder = tempfile::tempdir().unwrap();
    let man = folder.path().join("man1");
    let write = || rayframe(&["man", "--folder", &man.display().to_string()]);
    // Its own pages are replaced.
    for _ in 0..2 {
        let output = write();
        assert!(output.status.success(), "{}", stderr(&output));
        assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), names(&man).len());
    }
    let written = names(&man);
    assert!(
        written.iter().any(|name| name == "rayframe.1")
            && written.iter().any(|name| name == "rayframe-diff.1")
    );
    assert_eq!(std::fs::read(man.join("rayframe-render.1")).unwrap(), page.stdout);
    std::fs::write(man.join("rayframe-diff.1"), "mine").unwrap();
    let refused = write();
    assert_eq!(refused.status.code(), Some(73));
    let told = stderr(&refused);
    assert!(
        told.contains("choose another folder, or remove the file") && !told.contains("overwrite"),
        "{told}"
    );
    assert_eq!(std::fs::read(man.join("rayframe-diff.1")).unwrap(), b"mine");
}
