//! `rayframe merge`: merges crops, or sample ranges, into whole frames.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use rayon::ThreadPoolBuilder;

use crate::progress::print_note;
use rayframe::cancel::CancelFlag;
use rayframe::error::{Error, Result};
use rayframe::merge::{MergePlan, MergedFrame, join_frame, write_joined_frame};
use rayframe::regression::{is_sequence, sequence_files};
use rayframe::sequence::OutputPattern;

use super::exit_status::{ExitStatus, exit_status};
use super::signals;
use super::summary::counted;
use rayframe::settings::parse as options;
use rayframe::shot::memory_limit::default_max_memory_bytes;

/// Options of `rayframe merge`: merges crops, or sample ranges, into whole frames.
#[derive(Clone, Debug, Args)]
pub(super) struct MergeArgs {
    /// Crops that cover each image exactly once, or sample ranges that have each sample of each crop exactly once, in any order; names with #### are sequences
    #[arg(required = true, value_name = "TILES")]
    tiles: Vec<PathBuf>,
    /// Output name; with ####, %04d or {frame:04} tiles are merged frame by frame
    #[arg(short, long, visible_alias = "outfile", value_name = "PATTERN", required = true)]
    output: Option<OsString>,
    /// Merge every frame and replace existing files
    #[arg(long)]
    overwrite: bool,
    /// Number of threads [default: all cores]
    #[arg(short, long, value_name = "N", value_parser = |text: &str| options::whole::<u16>(text, 1, 65535))]
    threads: Option<u16>,
    /// Memory limit, such as 8G [default: 80 % of the available memory]
    #[arg(long, value_name = "SIZE", value_parser = options::memory_size)]
    max_memory: Option<u64>,
    /// Print warnings and errors only
    #[arg(short, long)]
    quiet: bool,
}

/// Merges the crops.
pub(super) fn run(args: &MergeArgs) -> ExitStatus {
    let pool = ThreadPoolBuilder::new().num_threads(args.threads.map_or(0, usize::from)).build();
    let merged = match pool {
        Ok(pool) => pool.install(|| merge(args)),
        Err(error) => Err(Error::no_threads(error)),
    };
    merged.unwrap_or_else(|error| exit_status(Err(error)))
}

fn merge(args: &MergeArgs) -> Result<ExitStatus> {
    // Check everything before the first frame.
    let output = OutputPattern::parse(args.output.as_deref().unwrap_or_default())
        .map_err(|why| Error::usage(format!("--output: {why}")))?;
    let max_memory_bytes = args.max_memory.unwrap_or_else(default_max_memory_bytes);
    let tiles: Vec<_> = args.tiles.iter().map(|path| files_of(path)).collect::<Result<_>>()?;
    let plan = MergePlan::new(&tiles.concat(), &output, args.overwrite, max_memory_bytes)?;

    // Merge. A signal ends the program at once, unless a file is being written.
    let (cancel, ends_at_once) = (CancelFlag::new(), Arc::new(AtomicBool::new(false)));
    let caught = signals::watch_unless(&cancel, &ends_at_once)
        .map_err(|error| Error::Internal { message: format!("signals cannot be watched: {error}") })?;
    plan.prepare()?;
    for frame in &plan.frames {
        ends_at_once.store(true, Ordering::Relaxed);
        if let (true, Some(signal)) = (cancel.is_raised(), caught.number()) {
            return Ok(ExitStatus::Signal(signal));
        }
        if !frame.is_done {
            let joined = join_frame(frame)?;
            ends_at_once.store(false, Ordering::Relaxed);
            match (write_joined_frame(frame, &joined, &cancel), caught.number()) {
                (Err(Error::Interrupted(_)), Some(signal)) => return Ok(ExitStatus::Signal(signal)),
                (written, _) => written?,
            }
        }
        if !args.quiet {
            print_note(&done_text(frame));
        }
    }
    Ok(ExitStatus::Code(0))
}

/// The files of a name with `####`, or the file itself.
fn files_of(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() && is_sequence(path)? { sequence_files(path) } else { Ok(vec![path.to_owned()]) }
}

/// `out.0001.exr: 6 tiles merged`.
fn done_text(frame: &MergedFrame) -> String {
    let what = if frame.is_done {
        "was there already".to_owned()
    } else {
        let parts = if frame.are_sample_ranges { "sample range" } else { "tile" };
        format!("{} merged", counted(frame.tiles.len() as u64, parts))
    };
    format!("{}: {what}", frame.path.display())
}
