//! Denoising by Intel's Open Image Denoise (Áfra, 2019 and later), a program of its own: `oidnDenoise`, a part of every release.
//!
//! The program gets the colours and two guides, the albedo and the normal of the first surfaces that scatter light. Guides are noisy
//! themselves where the camera has a lens or things move, so each is denoised first ("prefiltering"). Images go through files of
//! a temporary folder. The filter runs on the processor, with which its results differ in the last bits.

mod pfm;

use std::fs::File;
use std::io::{self, Read as _, Seek as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::cancel::{CancelFlag, Cancelled};
use crate::child_process::OwnedChild;
use crate::error::{Error, Result};

/// Name of the program.
const PROGRAM: &str = "oidnDenoise";
/// Time in which the program tells its version, seconds.
const VERSION_SECONDS: u64 = 30;
/// Most bytes of an output stream that are read.
const MOST_OUTPUT: u64 = 1 << 16;
/// What the version follows in its output.
const BEFORE_VERSION: &str = "Open Image Denoise ";

/// An installed denoiser.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Denoiser {
    program: PathBuf,
    /// Version, such as `2.5.1`.
    pub version: String,
}

/// Images of equal size, row by row from the top.
#[derive(Clone, Copy, Debug)]
pub struct NoisyImage<'i> {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Linear colours without an upper bound.
    pub colors: &'i [[f32; 3]],
    /// Albedos from 0 to 1.
    pub albedos: &'i [[f32; 3]],
    /// Normals in world space, 0 where nothing is hit.
    pub normals: &'i [[f32; 3]],
}

impl Denoiser {
    /// The program at `path`, or in it or its folder `bin` where it is a folder; the one that the system finds by name without a path.
    ///
    /// # Errors
    /// Why it cannot be used, to be read after the setting's name.
    pub fn find(path: Option<&Path>) -> std::result::Result<Self, String> {
        let program = match path {
            // A name alone would be searched for.
            Some(path) if path.is_file() => path.canonicalize().unwrap_or_else(|_| path.to_owned()),
            None => PathBuf::from(PROGRAM),
            Some(path) if path.is_dir() => {
                let places = [path.join(PROGRAM), path.join("bin").join(PROGRAM)];
                let [first, second] =
                    places.map(|place| place.with_extension(std::env::consts::EXE_EXTENSION));
                if second.is_file() { second } else { first }
            }
            Some(path) => path.to_owned(),
        };
        // Without an image, the program prints its version and ends.
        let mut command = Command::new(&program);
        command.args(["-d", "cpu", "-v", "2"]);
        let never = CancelFlag::new();
        let said = match run(command, Some(VERSION_SECONDS), &never) {
            Ok(ended) => ended.said,
            Err(Stopped::NoPlace(error)) => return Err(format!("cannot be used: {error}")),
            Err(Stopped::Failed(error)) if path.is_some() => {
                return Err(format!("\"{}\" cannot be started: {error}", program.display()));
            }
            Err(Stopped::Failed(_)) => {
                return Err(format!(
                    "{PROGRAM} is not installed; it is part of Open Image Denoise (https://www.openimagedenoise.org); put it into the \
                     search path, or name it with --oidn"
                ));
            }
            Err(Stopped::TooLate | Stopped::Cancelled) => String::new(),
        };
        let version = said.split_once(BEFORE_VERSION).and_then(|(_, after)| after.split_whitespace().next());
        match version {
            Some(version) => Ok(Self { program, version: version.to_owned() }),
            None => Err(format!("\"{}\" is not the program {PROGRAM} of version 2", program.display())),
        }
    }

    /// The denoised colours.
    ///
    /// # Errors
    /// [`Error::WriteFailed`] with what the program says, [`Error::CannotCreate`] without a place for temporary files,
    /// [`Error::Interrupted`] when cancelled.
    pub fn denoise(&self, image: NoisyImage<'_>, cancel: &CancelFlag) -> Result<Vec<[f32; 3]>> {
        let folder = tempfile::tempdir().map_err(|source| Error::CannotCreate {
            path: std::env::temp_dir(),
            message: format!("a temporary folder cannot be created: {source}"),
        })?;
        let run = Run { denoiser: self, cancel, folder, size: image.size };
        let colors = run.write("color", image.colors)?;
        let noisy_albedos = run.write("noisy_albedo", image.albedos)?;
        let noisy_normals = run.write("noisy_normal", image.normals)?;
        let albedos = run.filter("albedo", &[("--alb", &noisy_albedos)])?;
        let normals = run.filter("normal", &[("--nrm", &noisy_normals)])?;
        let inputs = [("--hdr", colors.as_path()), ("--alb", &albedos), ("--nrm", &normals)];
        run.read(&run.filter("denoised", &inputs)?)
    }
}

/// The files of one image.
struct Run<'d> {
    denoiser: &'d Denoiser,
    cancel: &'d CancelFlag,
    folder: TempDir,
    size: (u32, u32),
}

impl Run<'_> {
    fn write(&self, name: &str, pixels: &[[f32; 3]]) -> Result<PathBuf> {
        let path = self.folder.path().join(name).with_extension("pfm");
        let written = std::fs::write(&path, pfm::encode(self.size, pixels));
        written.map_err(|source| Error::WriteFailed { path: path.clone(), source })?;
        Ok(path)
    }

    /// Filters one image, guided by the others.
    fn filter(&self, name: &str, inputs: &[(&str, &Path)]) -> Result<PathBuf> {
        let path = self.folder.path().join(name).with_extension("pfm");
        let mut command = Command::new(&self.denoiser.program);
        for (option, input) in inputs {
            command.arg(option).arg(input);
        }
        if inputs.len() > 1 {
            command.arg("--clean_aux");
        }
        let threads = rayon::current_num_threads().to_string();
        command.args(["-d", "cpu", "-q", "high", "--threads", &threads, "-o"]).arg(&path);
        match run(command, None, self.cancel) {
            Ok(ended) if ended.status.success() => Ok(path),
            Ok(ended) => {
                let line = ended.said.lines().find(|line| line.contains("rror"));
                Err(self.failed(line.unwrap_or(&format!("it ended with {}", ended.status))))
            }
            Err(Stopped::Failed(error) | Stopped::NoPlace(error)) => Err(self.failed(&error.to_string())),
            Err(Stopped::TooLate | Stopped::Cancelled) => Err(Error::Interrupted(Cancelled)),
        }
    }

    fn read(&self, path: &Path) -> Result<Vec<[f32; 3]>> {
        let bytes = std::fs::read(path).map_err(|error| self.failed(&error.to_string()))?;
        let pixels = pfm::decode(self.size, &bytes);
        pixels.ok_or_else(|| self.failed("it wrote no image of this size"))
    }

    /// The error of a run that ended with `why`.
    fn failed(&self, why: &str) -> Error {
        Error::WriteFailed { path: self.denoiser.program.clone(), source: io::Error::other(why.to_owned()) }
    }
}

/// An ended process.
struct Ended {
    status: ExitStatus,
    /// Its standard output, then its standard error stream.
    said: String,
}

/// Why a process has not ended by itself.
enum Stopped {
    Failed(io::Error),
    /// There is no place for its output.
    NoPlace(io::Error),
    TooLate,
    Cancelled,
}

/// Runs a program, which is ended when `cancel` is raised or after `limit_seconds`. Its output goes to files: a full pipe
/// would stop it.
fn run(
    mut command: Command,
    limit_seconds: Option<u64>,
    cancel: &CancelFlag,
) -> std::result::Result<Ended, Stopped> {
    let temporary = || {
        let without_place = |error| {
            let folder = std::env::temp_dir();
            let why = format!("no temporary file can be created in \"{}\": {error}", folder.display());
            Stopped::NoPlace(io::Error::other(why))
        };
        tempfile::tempfile().map_err(without_place)
    };
    let (mut output, mut errors) = (temporary()?, temporary()?);
    let copy = |file: &File| file.try_clone().map_err(Stopped::Failed);
    command.stdin(Stdio::null()).stdout(copy(&output)?).stderr(copy(&errors)?);
    let started = Instant::now();
    let mut process = OwnedChild(command.spawn().map_err(Stopped::Failed)?);
    let is_late = || limit_seconds.is_some_and(|limit| started.elapsed() > Duration::from_secs(limit));
    let ended = process.wait_unless(|| cancel.is_raised() || is_late()).map_err(Stopped::Failed)?;
    let Some(status) = ended else {
        return Err(if cancel.is_raised() { Stopped::Cancelled } else { Stopped::TooLate });
    };
    let mut said = String::new();
    for stream in [&mut output, &mut errors] {
        let mut bytes = Vec::new();
        stream
            .rewind()
            .and_then(|()| stream.take(MOST_OUTPUT).read_to_end(&mut bytes))
            .map_err(Stopped::Failed)?;
        said.push_str(&String::from_utf8_lossy(&bytes));
    }
    Ok(Ended { status, said })
}
