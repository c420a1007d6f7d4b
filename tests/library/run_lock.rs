//! Exclusion of runs through the library.

use rayframe::cancel::CancelFlag;
use rayframe::sequence::{ExistingFiles, Plan, RunLock, SequenceJob};

use crate::sequence::{job, names, render};

#[test]
fn files_that_change_between_the_plan_and_the_lock_end_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let cancel = CancelFlag::new();
    let resumed =
        SequenceJob { existing: ExistingFiles::Resume, ..job(folder.path(), "a.####.exr", &[1, 2]) };
    render(&resumed).unwrap();
    let plan = Plan::new(&resumed).unwrap();
    assert_eq!(plan.remaining(), 0);
    drop(RunLock::acquire(&resumed, &plan, &cancel).unwrap());
    // Another run replaces a frame that the plan keeps.
    let frame = std::fs::read(folder.path().join("a.0002.exr")).unwrap();
    std::fs::write(folder.path().join("a.0002.exr"), &frame[..frame.len() / 2]).unwrap();
    let error = RunLock::acquire(&resumed, &plan, &cancel).unwrap_err();
    assert_eq!(error.exit_code(), 75, "{error}");
    // Frames that are to be rendered are looked at again when they are claimed.
    let plan = Plan::new(&resumed).unwrap();
    assert_eq!(plan.remaining(), 1);
    std::fs::remove_file(folder.path().join("a.0002.exr")).unwrap();
    drop(RunLock::acquire(&resumed, &plan, &cancel).unwrap());

    // Another run makes the movie.
    let movie = job(folder.path(), "a.gif", &[1, 2]);
    let plan = Plan::new(&movie).unwrap();
    std::fs::write(folder.path().join("a.gif"), "another").unwrap();
    let error = RunLock::acquire(&movie, &plan, &cancel).unwrap_err();
    assert_eq!(error.exit_code(), 75, "{error}");
    assert_eq!(names(folder.path()), ["a.0001.exr", "a.gif"], "no lock remains");
}
