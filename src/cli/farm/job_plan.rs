//! One job of a farm, without the syntax of any engine.

use std::fmt::Write as _;

use super::asset_folders::AssetFolder;

/// Threads of a task where none are requested.
pub(super) const DEFAULT_THREADS: u16 = 4;

/// A job: tasks that may run at once on any machine, and a last step that joins their files.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct JobPlan {
    /// Name for people: that of the shot.
    pub(super) name: String,
    /// Absolute path of the folder that holds the job files.
    pub(super) folder: String,
    /// Rayframe on the workers.
    pub(super) program: String,
    /// What `--version` must print there.
    pub(super) version: String,
    /// Absolute path of the scene.
    pub(super) scene: String,
    /// All settings that decide about pixels, as a shot file.
    pub(super) shot_file: String,
    /// Folders of other files that the settings name.
    pub(super) asset_folders: Vec<AssetFolder>,
    /// The denoiser on each worker, or its folder.
    pub(super) oidn: Option<String>,
    /// Folder of decoded assets on each worker, and its largest size.
    pub(super) asset_cache: Option<(String, u64)>,
    /// Absolute path of the folder of all outputs.
    pub(super) output_folder: String,
    /// Name of the frames in that folder.
    pub(super) output_name: String,
    /// What the workers must find before they render.
    pub(super) pin: Pin,
    /// The tasks.
    pub(super) tasks: Vec<Task>,
    /// Files of all tasks, in the output folder, to be merged; empty where tasks render whole frames.
    pub(super) parts: Vec<String>,
    /// Whether there is an older frame in the place of the merged one.
    pub(super) replaces_output: bool,
    /// What each task needs.
    pub(super) resources: Resources,
    /// How often a task is repeated after a failure that may pass.
    pub(super) retries: u32,
    /// Most tasks that run at once.
    pub(super) at_most: Option<u32>,
    /// Image of the container that holds the program.
    pub(super) image: Option<String>,
    /// Volume claims that hold the scene and the outputs, each with the path of its mount.
    pub(super) claims: Vec<(String, String)>,
    /// Absolute paths of all files that the scene reads.
    pub(super) assets: Vec<String>,
}

/// The render hash of one frame: equal exactly for equal scenes, settings and versions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pin {
    pub(super) frame: i64,
    pub(super) render_hash: String,
}

/// A part of a job that one worker renders.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Task {
    /// Name for people: `1-10`, `tile 0,0,960,540` or `samples 0-511`.
    pub(super) name: String,
    /// Options of `rayframe render`.
    pub(super) options: Vec<String>,
    /// Name of its files in the output folder.
    pub(super) output_name: String,
}

/// What a task needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Resources {
    pub(super) threads: u16,
    /// The request.
    pub(super) memory_bytes: u64,
    /// `--max-memory` of a task.
    pub(super) limit_bytes: u64,
}

impl Resources {
    /// The request, rounded up.
    pub(super) fn memory_mib(self) -> u64 {
        self.memory_bytes.div_ceil(1 << 20)
    }

    /// `--max-memory` of the merge, which renders nothing: four fifths of the request, whatever the limit of tasks.
    pub(super) fn merge_limit_bytes(self) -> u64 {
        self.limit_bytes.max(self.memory_bytes / 5 * 4)
    }
}

impl JobPlan {
    /// The name with nothing but ASCII letters, digits, `-`, `_` and `.`, at most `longest` characters.
    pub(super) fn plain_name(&self, longest: usize) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
        let name: String = self.name.chars().map(plain).take(longest).collect();
        let name = name.trim_matches(['-', '_', '.']);
        if name.is_empty() { "render".to_owned() } else { name.to_owned() }
    }

    /// The list of tasks for people.
    pub(super) fn task_list(&self) -> String {
        let mut text = String::new();
        for (index, task) in self.tasks.iter().enumerate() {
            let _ = writeln!(text, "{index}\t{}", task.name);
        }
        text
    }
}
