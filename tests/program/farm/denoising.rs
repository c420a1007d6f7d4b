//! The denoiser of a job: typed for each task, since shot files name no programs.

use std::process::Command;

use super::{farm, json, text};
use crate::denoise::{COPIES, program};
use crate::{names, stderr};

#[test]
fn tasks_denoise_with_the_program_of_the_worker() {
    let root = tempfile::tempdir().unwrap();
    let here = |name: &str| root.path().join(name);
    std::fs::create_dir(here("it's oidn")).unwrap();
    program(&here("it's oidn"), COPIES);
    let oidn = here("it's oidn");
    let options = ["-f", "0", "--samples", "1", "--integrator", "path", "--denoise", "oidn"];
    let options =
        [&options[..], &["--oidn", text(&oidn), "--program", env!("CARGO_BIN_EXE_rayframe")]].concat();
    let wrote = farm(root.path(), "slurm", &options);
    assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
    let shot = std::fs::read_to_string(here("job/shot.toml")).unwrap();
    assert!(shot.contains("denoise = \"oidn\"") && !shot.contains("\noidn ="), "{shot}");
    let ran = Command::new("sh").arg(here("job/task.sh")).arg("0").output().unwrap();
    assert_eq!(ran.status.code(), Some(0), "{}", stderr(&ran));
    assert_eq!(names(&here("out")), ["a.0000.exr"]);

    // The worker has it elsewhere.
    std::fs::rename(&oidn, here("else # where")).unwrap();
    std::fs::remove_file(here("out/a.0000.exr")).unwrap();
    let mut mapped = Command::new("sh");
    mapped.arg(here("job/task.sh")).arg("0").env("RAYFRAME_OIDN", here("else # where"));
    let ran = mapped.output().unwrap();
    assert_eq!(ran.status.code(), Some(0), "{}", stderr(&ran));
    assert_eq!(names(&here("out")), ["a.0000.exr"]);

    // Templates have a parameter for it.
    std::fs::rename(here("else # where"), &oidn).unwrap();
    let wrote = farm(root.path(), "openjd", &options);
    assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
    let template = json(&here("job/template.json"));
    let parameters = template["parameterDefinitions"].as_array().unwrap();
    assert!(parameters.iter().any(|one| one["name"] == "Oidn" && one["type"] == "STRING"), "{template}");
    let variables = &template["jobEnvironments"][0]["variables"];
    assert_eq!(variables["RAYFRAME_OIDN"], "{{Param.Oidn}}");
}
