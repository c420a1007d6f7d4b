//! Every scene of `scenes/` looks as its reference in `reference_images/`.
//!
//! `RAYFRAME_ACCEPT=1 cargo test --release --test references` writes what is missing or different and fails nevertheless,
//! naming what it wrote; look at the pictures, run again without it, and commit both. `RAYFRAME_FILTER=light/` looks at a
//! part. Where `CI` is set nothing is accepted.

use std::path::Path;

use rayframe::cancel::CancelFlag;
use rayframe::regression::{Mode, Outcome, Picture, Suite, Tolerance, run};

#[test]
fn scenes_look_as_their_references() {
    let accept = std::env::var_os("RAYFRAME_ACCEPT").is_some_and(|value| value != "0");
    let in_ci = std::env::var_os("CI").is_some();
    assert!(!(accept && in_ci), "RAYFRAME_ACCEPT is refused where CI is set");
    let mode = if accept { Mode::Accept } else { Mode::Check };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let suite = Suite {
        scenes: root.join("scenes"),
        references: root.join("reference_images"),
        report: root.join("target/regression"),
        filter: std::env::var("RAYFRAME_FILTER").unwrap_or_default(),
        resolution: (160, 90),
        samples: 4,
        tolerance: Tolerance::EXACT,
    };
    let outcome = run(&suite, mode, &CancelFlag::default()).unwrap();
    assert!(outcome.failures.is_empty(), "{}", described(&outcome));
    assert!(!outcome.passed.is_empty(), "no shot was found");
}

fn described(outcome: &Outcome) -> String {
    let lines: Vec<String> = outcome.failures.iter().map(ToString::to_string).collect();
    format!(
        "{} of {} shots failed:\n{}\nRAYFRAME_ACCEPT=1 accepts what is right",
        lines.len(),
        lines.len() + outcome.passed.len(),
        lines.join("\n")
    )
}

/// The whole life of a reference: missing, accepted, right, changed, dangling.
#[test]
fn every_change_of_a_reference_fails_once() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let suite = Suite {
        scenes: at("scenes"),
        references: at("references"),
        report: at("report"),
        filter: String::new(),
        resolution: (8, 6),
        samples: 1,
        tolerance: Tolerance::EXACT,
    };
    std::fs::create_dir_all(at("scenes/camera")).unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/camera/perspective.gltf");
    std::fs::copy(scene, at("scenes/camera/perspective.gltf")).unwrap();
    let reference = at("references/camera/perspective.exr");
    let message = |mode| {
        let outcome = run(&suite, mode, &CancelFlag::default()).unwrap();
        assert_eq!(outcome.passed.len() + outcome.failures.len(), 1, "{outcome:?}");
        outcome.failures.first().map_or("passed".to_owned(), ToString::to_string)
    };

    assert!(message(Mode::Check).contains("no reference at"));
    assert!(at("report/camera/perspective.actual.exr").exists());
    assert!(message(Mode::Accept).contains("accepted, written to"));
    assert_eq!(message(Mode::Check), "passed");

    let mut changed = Picture::read(&reference).unwrap();
    changed.pixels[9][0] += 0.25;
    changed.write(&reference, 0, 0.0).unwrap();
    let told = message(Mode::Check);
    assert!(told.contains("1 pixels differ") && told.contains("column 1, row 1"), "{told}");
    assert!(at("report/camera/perspective.difference.exr").exists());
    assert!(message(Mode::Accept).contains("accepted, written to"));
    assert_eq!(message(Mode::Check), "passed");

    std::fs::rename(&reference, at("references/camera/gone.exr")).unwrap();
    let outcome = run(&suite, Mode::Check, &CancelFlag::default()).unwrap();
    assert_eq!(outcome.failures.len(), 2, "{outcome:?}");
    assert!(outcome.failures[1].message.contains("no scene asks for this reference"));
}

/// However geometry and images are packed, without loss the picture is that of the plain file to the last bit.
#[test]
fn packed_scenes_look_as_the_plain_one() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reference_images/storage");
    let picture = |name: &str| Picture::read(&folder.join(format!("{name}.exr"))).unwrap();
    let plain = picture("plain");
    for name in ["meshopt_ext", "meshopt_khr", "draco", "webp", "basis_uastc", "basis_etc1s"] {
        assert!(picture(name) == plain, "{name}");
    }
}
