//! The engines that job files are written for.

use std::path::Path;

use clap::ValueEnum;

use rayframe::error::Result;
use rayframe::regression::suite::shell_quoted;

use super::job_files::JobFile;
use super::job_plan::JobPlan;
use super::{kubernetes, openjd, parallel, slurm};

/// A scheduler.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Engine {
    /// Open Job Description, as AWS Deadline Cloud takes it
    Openjd,
    /// Slurm: an array job
    Slurm,
    /// Kubernetes: an Indexed Job
    K8s,
    /// GNU parallel
    Parallel,
}

impl Engine {
    /// The name on the command line.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Openjd => "openjd",
            Self::Slurm => "slurm",
            Self::K8s => "k8s",
            Self::Parallel => "parallel",
        }
    }

    /// The files of a job.
    ///
    /// # Errors
    /// [`Error::Usage`](rayframe::error::Error::Usage) for a job that the engine cannot express.
    pub(super) fn files(self, plan: &JobPlan) -> Result<Vec<JobFile>> {
        let mut files = match self {
            Self::Openjd => openjd::files(plan)?,
            Self::Slurm => slurm::files(plan),
            Self::K8s => kubernetes::files(plan)?,
            Self::Parallel => parallel::files(plan),
        };
        // Names of files hold any character but zero.
        let assets = plan.assets.join("\0") + "\0";
        files.push(JobFile { name: "assets.list", content: assets });
        Ok(files)
    }

    /// How the job is submitted.
    pub(super) fn hint(self, folder: &Path) -> String {
        let at = |name: &str| shell_quoted(&folder.join(name).display().to_string());
        match self {
            Self::Openjd => {
                let folder = shell_quoted(&folder.display().to_string());
                format!("to submit it to AWS Deadline Cloud: deadline bundle submit {folder}")
            }
            Self::Slurm | Self::K8s => format!("to submit it: sh {}", at("submit.sh")),
            Self::Parallel => format!("to run it: sh {}", at("run.sh")),
        }
    }
}
