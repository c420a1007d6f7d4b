//! `--memory` and `--max-memory` of `rayframe farm`.

use super::{farm, json};
use crate::{both, stderr};

#[test]
fn the_request_and_the_limit_of_a_task_are_two() {
    for (options, request, limit) in [
        (&["--memory", "1000M", "--max-memory", "100M"][..], 1_000_000_000, 100_000_000),
        (&["--memory", "1000M"], 1_000_000_000, 800_000_000),
        (&["--memory", "1000M", "--max-memory", "32G"], 1_000_000_000, 800_000_000),
        (&["--max-memory", "100M"], 125_000_000, 100_000_000),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let wrote = farm(folder.path(), "slurm", &both(&["-f", "0-3"], options));
        assert_eq!(wrote.status.code(), Some(0), "{}", stderr(&wrote));
        assert_eq!(json(&folder.path().join("job/job.json"))["memory_bytes"], request);
        let script = std::fs::read_to_string(folder.path().join("job/task.sh")).unwrap();
        assert!(script.contains(&format!("--max-memory {limit} ")), "{script}");
    }
    let of_request = "raise --memory, of which four fifths are the limit";
    for (options, limit, remedy) in [
        (&["--memory", "20M"][..], "16.0 MB", of_request),
        (&["--memory", "1"], "1 byte", of_request),
        (&["--memory", "20M", "--max-memory", "32G"], "16.0 MB", of_request),
        (&["--max-memory", "16M"], "16.0 MB", "raise --max-memory"),
        (&["--memory", "1000M", "--max-memory", "16M"], "16.0 MB", "raise --max-memory"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let refused = farm(folder.path(), "slurm", &both(&["-f", "0-3"], options));
        assert_eq!(refused.status.code(), Some(77), "{options:?}: {}", stderr(&refused));
        let message = stderr(&refused);
        assert!(message.contains(&format!("the limit of {limit}")) && message.contains(remedy), "{message}");
        assert!(!folder.path().join("job").exists());
    }
}
