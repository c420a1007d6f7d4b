//! The jobs: arguments of the program, and the files that they need.

use std::path::{Path, PathBuf};

use image::Rgb;
use image::codecs::hdr::HdrEncoder;
use tempfile::TempDir;

use super::Result;
use super::mesh::mesh_file;

/// Jobs by name. The names of meshes tell their triangles.
pub(crate) const NAMES: [&str; 8] =
    ["demo", "helmet", "character", "level", "interior", "mesh-1m", "mesh-10m", "suite"];
/// Width and height of the generated environment.
const SKY: (u32, u32) = (1024, 512);

/// A command of the program.
pub(crate) struct Job {
    pub(crate) name: String,
    pub(crate) command: Command,
}

pub(crate) enum Command {
    /// `render` with these arguments; files go to the folder.
    Render { arguments: Vec<String>, folder: PathBuf },
    /// `test` of the scenes of this folder against references, both copied to `folder` before each run.
    Test { scenes: PathBuf, references: PathBuf, folder: PathBuf },
}

/// Temporary folder of generated inputs and of all output.
pub(crate) struct Workspace {
    folder: TempDir,
}

impl Workspace {
    pub(crate) fn new() -> Result<Self> {
        Ok(Self { folder: tempfile::tempdir()? })
    }

    /// The job of this name, or one that renders the first second of the file of this name.
    pub(crate) fn job(&self, name: &str) -> Result<Job> {
        match name {
            "demo" => self.scene_job(name, "demo/whitted_1980.gltf", "-r 640x360 -f 1-4"),
            "helmet" => {
                let mut job = self.scene_job(name, "showcase/helmet.gltf", "-r 640x360 --turntable 6")?;
                if let Command::Render { arguments, .. } = &mut job.command {
                    arguments.extend(["--env".to_owned(), text(&self.sky()?)]);
                }
                Ok(job)
            }
            "character" => {
                let options = "--animation walk --ground -r 1920x1080 -f 1-8";
                self.scene_job(name, "showcase/character.gltf", options)
            }
            "level" => self.scene_job(name, "showcase/level.gltf", "-r 1280x720"),
            "interior" => self.scene_job(name, "showcase/apartment.gltf", "-r 1280x720"),
            "mesh-1m" => self.mesh_job(name, [1000, 500], "640x360"),
            "mesh-10m" => self.mesh_job(name, [2500, 2000], "640x360"),
            "suite" => Ok(self.suite_job(name)),
            path if Path::new(path).is_file() => {
                Ok(self.render_job(name, Path::new(path), "-r 640x360 --samples 4 -f 0-3"))
            }
            _ => Err(format!("{name} is neither a file nor one of {}", NAMES.join(", ")).into()),
        }
    }

    /// A still of a generated mesh with two triangles a cell.
    pub(crate) fn mesh_job(&self, name: &str, cells: [u32; 2], size: &str) -> Result<Job> {
        let path = self.folder.path().join(format!("{}x{}.glb", cells[0], cells[1]));
        if !path.exists() {
            std::fs::write(&path, mesh_file(cells))?;
        }
        Ok(self.render_job(name, &path, &format!("-r {size}")))
    }

    fn scene_job(&self, name: &str, scene: &str, options: &str) -> Result<Job> {
        Ok(self.render_job(name, &repository().join("scenes").join(scene).canonicalize()?, options))
    }

    fn render_job(&self, name: &str, scene: &Path, options: &str) -> Job {
        let folder = self.folder.path().join("output");
        let output = text(&folder.join("frame.####.exr"));
        let mut arguments = vec![text(scene), "-o".to_owned(), output];
        arguments.extend(options.split(' ').map(str::to_owned));
        Job { name: short(name), command: Command::Render { arguments, folder } }
    }

    fn suite_job(&self, name: &str) -> Job {
        let [scenes, references] = ["scenes", "reference_images"].map(|folder| repository().join(folder));
        let folder = self.folder.path().join("suite");
        Job { name: short(name), command: Command::Test { scenes, references, folder } }
    }

    /// A sky with a sun and a dark ground, as an HDR file.
    fn sky(&self) -> Result<PathBuf> {
        let path = self.folder.path().join("sky.hdr");
        let (width, height) = SKY;
        let texel = |index: u32| {
            let (x, y) = (index % width, index / width);
            let up = 1.0 - 2.0 * y as f32 / height as f32;
            let is_sun = x.abs_diff(300) < 6 && y.abs_diff(110) < 6;
            let sky = if up > 0.0 { [0.3 + 0.5 * (1.0 - up), 0.6, 1.0] } else { [0.12, 0.1, 0.08] };
            Rgb(if is_sun { [900.0, 800.0, 600.0] } else { sky })
        };
        let texels: Vec<_> = (0..width * height).map(texel).collect();
        let file = std::io::BufWriter::new(std::fs::File::create(&path)?);
        HdrEncoder::new(file).encode(&texels, width as usize, height as usize)?;
        Ok(path)
    }
}

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// File stem of a path; a name itself.
fn short(name: &str) -> String {
    let stem = Path::new(name).file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

pub(crate) fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}
