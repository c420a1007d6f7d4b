//! Sequences without write-behind: a frame is on the disk before the next one begins, whatever happens to it.

use std::sync::Mutex;

use rayframe::cancel::CancelFlag;
use rayframe::sequence::{Plan, SequenceEvent, run};

use crate::sequence::{job, names, render};

#[test]
fn without_write_behind_a_frame_is_on_the_disk_before_the_next_one_begins() {
    let folder = tempfile::tempdir().unwrap();
    let frames = [0, 1, 2, 3, 4, 5, 6, 7];
    let reference = job(folder.path(), "a.##.exr", &frames);
    render(&reference).unwrap();
    for threads in [1, 2, 8] {
        let folder = tempfile::tempdir().unwrap();
        let mut job = job(folder.path(), "a.##.exr", &frames);
        job.write_behind = false;
        let missing = Mutex::new(Vec::new());
        let on_event = |event: SequenceEvent<'_>| {
            let (SequenceEvent::FrameStarted(started) | SequenceEvent::FrameProgress(started, _)) = event
            else {
                return;
            };
            if (0..started.frame).any(|frame| !job.output.path(frame).is_file()) {
                missing.lock().unwrap().push(started.frame);
            }
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let plan = Plan::new(&job).unwrap();
        let summary = pool.install(|| run(&job, &plan, &CancelFlag::new(), &on_event));
        assert_eq!(summary.written.len(), frames.len());
        assert_eq!(missing.into_inner().unwrap(), [0_i64; 0], "{threads} threads");
        for frame in frames {
            let bytes = [&job, &reference].map(|job| std::fs::read(job.output.path(frame)).unwrap());
            assert!(bytes[0] == bytes[1], "frame {frame}");
        }
    }
}

#[test]
fn frames_after_a_panic_while_tracing_are_rendered() {
    for write_behind in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let mut job = job(folder.path(), "a.##.exr", &[1, 2, 3, 4, 5]);
        (job.write_behind, job.keep_going) = (write_behind, true);
        let plan = Plan::new(&job).unwrap();
        let order = Mutex::new(Vec::new());
        let summary = run(&job, &plan, &CancelFlag::new(), &|event| match event {
            SequenceEvent::FrameProgress(frame, _) if [2, 3].contains(&frame.frame) => panic!("a bug"),
            SequenceEvent::FrameStarted(frame) => order.lock().unwrap().push((frame.frame, "started")),
            SequenceEvent::FrameWritten(report) => order.lock().unwrap().push((report.frame, "written")),
            _ => {}
        });
        assert_eq!(names(folder.path()), ["a.01.exr", "a.04.exr", "a.05.exr"]);
        assert_eq!(summary.failed.len(), 2);
        let order = order.into_inner().unwrap();
        let at = |event| order.iter().position(|other| *other == event).unwrap();
        assert!(write_behind || at((4, "written")) < at((5, "started")), "{order:?}");
    }
}
