//! One run of the program: its times, its statistics, and what it took from the machine.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command as Process, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::Result;
use super::job::{Command, Job, text};

/// Clock ticks a second of `/proc/PID/stat` on Linux.
const TICKS_A_SECOND: f64 = 100.0;
/// Exit codes of a suite that ran: all shots as their references, or some not.
const SUITE_CODES: [i32; 2] = [0, 1];

/// What a run took. Zero where it is unknown.
#[derive(Clone, Debug, Default)]
pub(crate) struct Run {
    pub(crate) wall_seconds: f64,
    pub(crate) cpu_seconds: f64,
    /// From the start of the process to its first finished tile.
    pub(crate) first_tile_seconds: f64,
    /// From the start of the process to its first frame.
    pub(crate) import_seconds: f64,
    pub(crate) pose_seconds: f64,
    pub(crate) build_seconds: f64,
    /// Tracing and shading.
    pub(crate) trace_seconds: f64,
    /// Queries of the hierarchy, a thread.
    pub(crate) query_seconds: f64,
    pub(crate) rays: f64,
    pub(crate) peak_bytes: f64,
    pub(crate) faults: f64,
}

impl Run {
    /// The faster of both runs, with the least CPU time and memory of either.
    pub(crate) fn or_less(self, other: Self) -> Self {
        let cpu_seconds = self.cpu_seconds.min(other.cpu_seconds);
        let peak_bytes = self.peak_bytes.min(other.peak_bytes);
        let first_tile_seconds = self.first_tile_seconds.min(other.first_tile_seconds);
        let faster = if self.wall_seconds < other.wall_seconds { self } else { other };
        Self { cpu_seconds, first_tile_seconds, peak_bytes, ..faster }
    }
}

/// Runs a job by the program at `binary`.
pub(crate) fn run(binary: &Path, job: &Job, threads: usize) -> Result<Run> {
    let mut process = Process::new(binary);
    let statistics_file = match &job.command {
        Command::Render { arguments, folder } => {
            remake(folder)?;
            let statistics = folder.join("statistics.json");
            process.arg("render").args(arguments).args(["--stats", &text(&statistics), "--progress", "json"]);
            Some(statistics)
        }
        Command::Test { scenes, references, folder } => {
            prepare_suite(scenes, references, folder)?;
            process.args(["test", "--suite", &text(folder)]);
            None
        }
    };
    let (Command::Render { folder, .. } | Command::Test { folder, .. }) = &job.command;
    let messages = folder.join("messages.txt");
    process.args(["-t", &threads.to_string()]).stdout(Stdio::piped()).stderr(fs::File::create(&messages)?);

    let before = ChildUsage::now();
    let start = Instant::now();
    let mut child = process.spawn().map_err(|error| format!("{}: {error}", binary.display()))?;
    let mut run = watch(&mut child, start)?;
    let code = child.wait()?.code().unwrap_or(-1);
    run.wall_seconds = start.elapsed().as_secs_f64();
    if code != 0 && !(statistics_file.is_none() && SUITE_CODES.contains(&code)) {
        let told = fs::read_to_string(messages)?;
        return Err(format!("{} failed with {code} by {}: {told}", job.name, binary.display()).into());
    }
    let after = ChildUsage::now();
    run.cpu_seconds = after.cpu_seconds - before.cpu_seconds;
    run.faults = after.faults - before.faults;
    if let Some(path) = statistics_file {
        run.read_statistics(&serde_json::from_slice(&fs::read(path)?)?, threads);
    }
    Ok(run)
}

impl Run {
    /// Sums the frames of the program's `--stats`.
    fn read_statistics(&mut self, statistics: &Value, threads: usize) {
        let frames = statistics["frames"].as_array().map(Vec::as_slice).unwrap_or_default();
        let sum = |group: &str, keys: &[&str]| -> f64 {
            let values = frames.iter().flat_map(|frame| keys.iter().map(|key| &frame[group][*key]));
            values.filter_map(Value::as_f64).sum()
        };
        self.pose_seconds = sum("seconds", &["pose"]);
        self.build_seconds = sum("seconds", &["refit", "bounds", "split", "sort", "tree", "widen"]);
        self.trace_seconds = sum("seconds", &["trace"]);
        self.query_seconds = sum("rays", &["query_seconds"]) / threads as f64;
        self.rays = sum("rays", &["camera", "reflection", "refraction", "shadow"]);
        let peaks = frames.iter().filter_map(|frame| frame["peak_memory_bytes"].as_f64());
        self.peak_bytes = peaks.fold(self.peak_bytes, f64::max);
    }
}

/// Reads the lines of the program until it closes its output, and the peak of its memory meanwhile.
fn watch(child: &mut Child, start: Instant) -> Result<Run> {
    let mut run = Run::default();
    let lines = BufReader::new(child.stdout.take().ok_or("the program has no output")?).lines();
    let has_ended = AtomicBool::new(false);
    let status = format!("/proc/{}/status", child.id());
    run.peak_bytes = std::thread::scope(|threads| {
        let peak = threads.spawn(|| peak_bytes(&status, &has_ended));
        for line in lines {
            let event: Value =
                line.ok().and_then(|line| serde_json::from_str(&line).ok()).unwrap_or_default();
            let seconds = match event["event"].as_str() {
                Some("start") => &mut run.import_seconds,
                Some("progress") => &mut run.first_tile_seconds,
                _ => continue,
            };
            if *seconds == 0.0 {
                *seconds = start.elapsed().as_secs_f64();
            }
        }
        has_ended.store(true, Ordering::Relaxed);
        peak.join().unwrap_or_default()
    });
    Ok(run)
}

/// Largest resident set of a process (`VmHWM` of Linux), read until it has ended.
fn peak_bytes(status: &str, has_ended: &AtomicBool) -> f64 {
    const INTERVAL: Duration = Duration::from_millis(5);
    let mut peak: f64 = 0.0;
    while !has_ended.load(Ordering::Relaxed) {
        let status = fs::read_to_string(status).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok());
        peak = peak.max(kilobytes.unwrap_or_default() * 1024.0);
        std::thread::sleep(INTERVAL);
    }
    peak
}

/// CPU time and page faults of all processes that this one started and that have ended.
struct ChildUsage {
    cpu_seconds: f64,
    faults: f64,
}

impl ChildUsage {
    fn now() -> Self {
        // After the name in parentheses: the state and the numbers of the parent, group, session, terminal, its group and the
        // flags; then minor faults, those of children, major faults, those of children, and ticks: user, system, of children.
        let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
        let fields = stat.rsplit(')').next().unwrap_or_default();
        let fields: Vec<f64> =
            fields.split_whitespace().map(|field| field.parse().unwrap_or_default()).collect();
        let field = |index: usize| fields.get(index).copied().unwrap_or_default();
        Self { cpu_seconds: (field(13) + field(14)) / TICKS_A_SECOND, faults: field(8) }
    }
}

/// Writes a suite of the scenes, with a copy of the references, which a run may add images to.
fn prepare_suite(scenes: &Path, references: &Path, folder: &Path) -> Result<()> {
    remake(folder)?;
    copy(references, &folder.join("references"))?;
    let own = fs::read_to_string(scenes.join("suite.toml"))?;
    let (_, tables) = own.split_once("\n[").ok_or("the suite has no tables")?;
    let paths = format!(
        "scenes = '{}'\nreferences = \"references\"\nreport = \"report\"\n",
        text(&scenes.canonicalize()?)
    );
    fs::write(folder.join("suite.toml"), format!("{paths}\n[{tables}"))?;
    Ok(())
}

/// Empties a folder, or makes it.
fn remake(folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    Ok(fs::create_dir_all(folder)?)
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}
