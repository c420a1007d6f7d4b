//! `rayframe farm`: writes the job files of a scheduler, and submits nothing.
//!
//! [`planning`] makes a [`JobPlan`] of a shot: its tasks, what they need and what they read. Each engine has a module that turns the plan
//! into files, without any access to the system; [`job_files`] writes them.

mod asset_folders;
mod chunks;
mod engine;
mod frame_costs;
mod job_files;
mod job_plan;
mod kubernetes;
mod not_unicode;
mod openjd;
mod options;
mod parallel;
mod parts;
mod planning;
mod settings;
mod slurm;
mod task_script;
#[cfg(test)]
mod test_plan;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use rayon::ThreadPoolBuilder;

use crate::progress::print_note;
use rayframe::error::{Error, Result};

use super::render::{WrittenFiles, check_folders};
use super::render_options::NamedShot;
use super::summary::counted;
use job_files::{check_files, write_files};
use job_plan::{DEFAULT_THREADS, JobPlan};
pub(super) use options::FarmArgs;

/// Plans the jobs of all shots, checks every file, and writes them.
pub(super) fn run(args: &FarmArgs) -> Result<()> {
    args.check()?;
    let (shots, allowed_folders) = (args.render.shots(), args.render.allowed_folders());
    let folders = folders(&args.out_dir, &shots);
    let mut jobs = Vec::new();
    let mut written = WrittenFiles::default();
    for (named, folder) in shots.into_iter().zip(folders) {
        let shot = named.settings?;
        // The estimate of the memory counts the threads of the worker.
        let threads = shot.values.threads.unwrap_or(DEFAULT_THREADS);
        let pool = ThreadPoolBuilder::new().num_threads(threads.into()).build().map_err(Error::no_threads)?;
        let plan = pool.install(|| planning::plan(&shot, args, &folder));
        let added = plan.and_then(|(plan, outline)| {
            check_folders(&outline.sequences, &shot, &allowed_folders)?;
            written.add(&named.path, &shot, &outline)?;
            Ok(plan)
        });
        let plan = added.map_err(|error| shot.settings.locate(error))?;
        let files = args.engine.files(&plan)?;
        check_files(&folder, &files, shot.values.overwrite)?;
        jobs.push((plan, files, folder, shot.values.quiet));
    }
    for (plan, files, folder, is_quiet) in &jobs {
        write_files(folder, args.engine.name(), plan, files)?;
        if !is_quiet {
            print_note(&summary(plan, folder));
            print_note(&args.engine.hint(folder));
        }
    }
    Ok(())
}

/// The folder of each job: the named one, or with several shots one in it for each.
fn folders(out_dir: &Path, shots: &[NamedShot]) -> Vec<PathBuf> {
    if let [_] = shots {
        return vec![out_dir.to_owned()];
    }
    let mut taken = HashSet::new();
    let mut numbers = HashMap::new();
    let folder = |shot: &NamedShot| {
        let stem = shot.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let next: &mut usize = numbers.entry(stem.to_lowercase()).or_insert(1);
        loop {
            let name = if *next == 1 { stem.clone() } else { format!("{stem}-{next}") };
            *next += 1;
            // Many file systems take names that differ in case only for one.
            if taken.insert(name.to_lowercase()) {
                return out_dir.join(name);
            }
        }
    };
    shots.iter().map(folder).collect()
}

/// `shot: 10 tasks of 4 threads and 512 MiB, 7 assets; job files in farm/shot`.
fn summary(plan: &JobPlan, folder: &Path) -> String {
    let resources = plan.resources;
    format!(
        "{}: {} of {} and {} MiB, {}; job files in {}",
        plan.name,
        counted(plan.tasks.len() as u64, "task"),
        counted(resources.threads.into(), "thread"),
        resources.memory_mib(),
        counted(plan.assets.len() as u64, "asset"),
        folder.display(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shots_of_one_name_have_folders_of_their_own() {
        let named = |path: &str| NamedShot { path: path.into(), settings: Err(Error::usage("")) };
        let folders_of = |paths: &[&str]| {
            let shots: Vec<_> = paths.iter().map(|path| named(path)).collect();
            let folders = folders(Path::new("jobs"), &shots);
            folders.iter().map(|folder| folder.display().to_string()).collect::<Vec<_>>()
        };
        assert_eq!(folders_of(&["a/s.glb"]), ["jobs"]);
        let four = ["a/s.glb", "b/s.glb", "s-2.glb", "c/S.glb"];
        assert_eq!(folders_of(&four), ["jobs/s", "jobs/s-2", "jobs/s-2-2", "jobs/S-3"]);
        assert_eq!(folders_of(&["s-2.glb", "a/s.glb", "b/s.glb"]), ["jobs/s-2", "jobs/s", "jobs/s-3"]);
    }
}
