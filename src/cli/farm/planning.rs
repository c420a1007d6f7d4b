//! From a shot and the options of the command line to the plan of a job.

use std::path::Path;

use rayframe::error::Result;
use rayframe::gltf::ImageLoading;
use rayframe::output::SOFTWARE;
use rayframe::sequence::{ExistingFiles, Plan, canonical, estimated_bytes, frames_text, render_hash};
use rayframe::shot::{RenderJob, ShotOutline, ShotSettings, resolve};

use super::super::render::other_files;
use super::super::warnings::report_warnings;
use super::chunks::{ChunkRule, chunks};
use super::engine::Engine;
use super::frame_costs::{FrameCosts, Workload};
use super::job_plan::{DEFAULT_THREADS, JobPlan, Pin, Resources, Task};
use super::not_unicode::not_unicode;
use super::options::FarmArgs;
use super::settings::{check_shared, of_first_part, of_tasks, parts, shot_file};

/// Frames of a task where no costs are known.
const DEFAULT_CHUNK: usize = 10;
/// Seconds of a task where costs are known: loading the scene then is a small part.
const TASK_SECONDS: f64 = 300.0;
/// Memory of a task besides half more than the estimate, which is itself uncertain: splits make use of it.
const SPARE_BYTES: u64 = 128 << 20;

/// Plans the job of a shot, with its files in `folder`. Returns the files that it writes and reads, too.
///
/// # Errors
/// Those of `rayframe render --dry-run`, wrong options, and names that are not Unicode.
pub(super) fn plan(shot: &ShotSettings, args: &FarmArgs, folder: &Path) -> Result<(JobPlan, ShotOutline)> {
    check_shared(shot)?;
    // The lower limit counts, and errors name its option.
    let own_limit = shot.values.max_memory.unwrap_or(u64::MAX);
    let limit_of_request = args.memory.map(limit_within).filter(|limit| *limit < own_limit);
    let plan = plan_tasks(&of_tasks(shot, limit_of_request)?, args, folder);
    plan.map_err(|error| match limit_of_request {
        Some(_) => error.with_limit_of("--memory, of which four fifths are the limit"),
        None => error,
    })
}

/// Plans the job of a shot that has the settings of its tasks.
fn plan_tasks(shot: &ShotSettings, args: &FarmArgs, folder: &Path) -> Result<(JobPlan, ShotOutline)> {
    // Resolve the shot as `render` does.
    let mut job = resolve(&of_first_part(shot, args.division())?, ImageLoading::Budget)?;
    report_warnings(&job.sequence.scene.path, &job.warnings, job.sequence.strict)?;
    job.sequence.existing = ExistingFiles::Resume;
    let frames = Plan::new(&job.sequence)?;
    frames.check_collisions(&other_files(&job), &job.inputs)?;

    // Divide it.
    let folder = absolute(folder)?;
    let (output_folder, output_name) = output(&job)?;
    let resources = resources(shot, args, &job);
    let name = shot.shot_file.as_ref().unwrap_or(&shot.scene).file_stem().unwrap_or_default();
    let (shot_file, asset_folders) = shot_file(shot, &job)?;
    let cache = shot.values.asset_cache.as_deref().map(absolute).transpose()?;
    let mut plan = JobPlan {
        name: name.to_string_lossy().into_owned(),
        folder,
        program: program(args)?,
        version: SOFTWARE.to_owned(),
        scene: absolute(&shot.scene)?,
        shot_file,
        asset_folders,
        oidn: shot.values.oidn.as_deref().map(absolute).transpose()?,
        asset_cache: cache.map(|folder| (folder, shot.values.asset_cache_size)),
        output_folder,
        output_name,
        pin: pin(&job),
        tasks: Vec::new(),
        parts: Vec::new(),
        replaces_output: !frames.replaced.is_empty(),
        resources,
        retries: args.retries,
        at_most: args.at_most,
        image: args.image.clone(),
        claims: args.claims.clone(),
        assets: assets(&job)?,
    };
    let parts = parts(shot, &job, args.division())?;
    if parts.is_empty() {
        plan.tasks = frame_tasks(args, &job, &plan)?;
    } else {
        let frame = plan.pin.frame;
        for (name, option) in parts {
            // Jobs of one folder never share parts.
            let own = name.replace([' ', ','], "-");
            let hash = plan.pin.render_hash.get(..8).unwrap_or_default();
            let output_name = format!("parts/{}-{hash}.{own}.exr", plan.plain_name(80));
            plan.parts.push(output_name.clone());
            plan.tasks.push(Task { name, options: vec![format!("--frames={frame}"), option], output_name });
        }
    }
    let outline = ShotOutline { sequences: vec![job.outline], choices: Vec::new(), inputs: job.inputs };
    Ok((plan, outline))
}

/// The tasks of a sequence.
fn frame_tasks(args: &FarmArgs, job: &RenderJob, plan: &JobPlan) -> Result<Vec<Task>> {
    let frames = &job.sequence.frames;
    let workload = Workload {
        resolution: job.sequence.render.resolution,
        samples: job.sequence.render.samples,
        threads: plan.resources.threads.into(),
    };
    let measured = args.cost.as_deref().map(|path| FrameCosts::read(path, workload)).transpose()?;
    let costs: Vec<f64> =
        frames.iter().map(|frame| measured.as_ref().map_or(1.0, |costs| costs.seconds(*frame))).collect();
    let count = match (args.chunk, &measured) {
        (Some(chunk), _) => frames.len().div_ceil(chunk as usize),
        (None, Some(_)) => (costs.iter().sum::<f64>() / TASK_SECONDS).ceil() as usize,
        (None, None) => frames.len().div_ceil(DEFAULT_CHUNK),
    };
    let rule = if args.interleaved { ChunkRule::Interleaved } else { ChunkRule::Contiguous };
    let task = |chunk: Vec<i64>| {
        let text = frames_text(&chunk);
        let range = text.split_once(' ').map_or(&*text, |(_, range)| range).to_owned();
        let options = vec![format!("--frames={range}")];
        Task { name: range, options, output_name: plan.output_name.clone() }
    };
    Ok(chunks(frames, &costs, count, rule).into_iter().map(task).collect())
}

fn resources(shot: &ShotSettings, args: &FarmArgs, job: &RenderJob) -> Resources {
    let estimate = u64::try_from(estimated_bytes(&job.sequence)).unwrap_or(u64::MAX / 4);
    let request = (estimate + estimate / 2).saturating_add(SPARE_BYTES);
    let limit = shot.values.max_memory;
    // A limit alone is four fifths of the request.
    let of_limit = limit.map(|limit| limit.saturating_add(limit / 4));
    let memory_bytes = args.memory.or(of_limit).unwrap_or(request);
    Resources {
        threads: shot.values.threads.unwrap_or(DEFAULT_THREADS),
        memory_bytes,
        limit_bytes: limit.unwrap_or_else(|| limit_within(memory_bytes)),
    }
}

/// The memory limit of a task where none is given: four fifths of its request, as of any machine.
fn limit_within(memory_bytes: u64) -> u64 {
    (memory_bytes / 5 * 4).max(1)
}

fn pin(job: &RenderJob) -> Pin {
    let frame = job.sequence.frames.first().copied().unwrap_or_default();
    Pin { frame, render_hash: render_hash(&job.sequence, frame) }
}

/// Everything that the scene reads, each file once.
fn assets(job: &RenderJob) -> Result<Vec<String>> {
    let mut assets = job.inputs.iter().map(|path| absolute(path)).collect::<Result<Vec<_>>>()?;
    assets.sort();
    assets.dedup();
    Ok(assets)
}

/// The folder of the outputs, as far as it is the same for all frames, and the rest of their pattern.
fn output(job: &RenderJob) -> Result<(String, String)> {
    let pattern = job.sequence.output.to_text();
    let text = pattern.to_str().ok_or_else(|| not_unicode(&pattern.to_string_lossy()))?;
    let fixed = &text[..text.find(['#', '%', '{']).unwrap_or(text.len())];
    let (folder, name) = text.split_at(fixed.rfind('/').map_or(0, |slash| slash + 1));
    let folder = if folder.is_empty() { Path::new(".") } else { Path::new(folder) };
    // Links are resolved up to the folder of a file: any name stands for it.
    let file = canonical(&folder.join("file"));
    Ok((unicode(file.parent().unwrap_or(folder))?, name.to_owned()))
}

/// Rayframe on the workers. Tasks run in the folder of the job, so that a path is made absolute; a bare name is searched for.
fn program(args: &FarmArgs) -> Result<String> {
    match &args.program {
        Some(name) if !name.contains(std::path::is_separator) => Ok(name.clone()),
        Some(path) => absolute(Path::new(path)),
        // GNU parallel starts on this machine.
        None if args.engine == Engine::Parallel => {
            std::env::current_exe().map_or_else(|_| Ok("rayframe".to_owned()), |path| absolute(&path))
        }
        None => Ok("rayframe".to_owned()),
    }
}

/// The absolute path, without links as far as its folder exists.
fn absolute(path: &Path) -> Result<String> {
    unicode(&canonical(path))
}

fn unicode(path: &Path) -> Result<String> {
    path.to_str().map(str::to_owned).ok_or_else(|| not_unicode(&path.to_string_lossy()))
}
