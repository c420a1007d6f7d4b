//! Phase times of whole frames: `cargo bench --bench frame [-- SCENE… --size WxH --frames N --threads N]`.
//!
//! Without a scene it measures the demo; the defaults are 640x360 pixels of 4 samples, 9 frames, and all cores. Frames are
//! those of an animation at 24 frames per second from its start. Each is posed, built, traced and written as `rayframe render`
//! does, except that the hierarchy is built even where nothing moved. One frame before the first warms up memory and caches
//! and does not count.
//!
//! Each scene is a row of the table. Its columns:
//!
//! * `triangles`: triangles that are not hidden, in the last frame;
//! * `references`: boxes that the hierarchy is built over, after early split clipping;
//! * `pose`: animation, node matrices, morphing, skinning, and triangles in world space;
//! * `bounds`: boxes of triangles;
//! * `split`: boxes of parts of split triangles;
//! * `sort`: Morton codes and the radix sort;
//! * `tree`: the binary tree with its boxes;
//! * `collapse`: the collapse to the wide tree that rays traverse;
//! * `trace`: tracing and shading all samples;
//! * `write`: encoding the EXR file and writing it under a temporary name, synced to disk and renamed;
//! * `total`: the whole frame, measured by itself;
//! * `Mrays/s`: millions of rays of all kinds (camera, reflection, refraction, shadow) per second of `trace`.
//!
//! Times are medians over the frames in milliseconds. Each column has its own median, so they need not add up to `total`.
//!
//! `--kinds` compares the kinds of hierarchies instead ([`kinds`]).

mod kinds;

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rayframe::bvh::{BuildSettings, BuildStatistics, Builder, Bvh, Refit};
use rayframe::cancel::CancelFlag;
use rayframe::film::{Film, PixelWindow};
use rayframe::frame::Frame;
use rayframe::framing::resolve_camera;
use rayframe::gltf::{ImportOptions, import};
use rayframe::image_file::write_atomically;
use rayframe::output::{exr_file, frame_attributes};
use rayframe::render::{RenderSettings, RenderStatistics, SceneView, expected_rays, render_frame};
use rayframe::scene::{BuiltInLight, Environment, Scene, Selection, SelectionRequest, ViewRequest};
use rayframe::sequence::FrameRate;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const DEMO: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/demo/whitted_1980.gltf");
/// Samples per pixel, the default of `rayframe render`.
const SAMPLES: u32 = 4;
/// Columns that are medians over frames.
const TIMES: [&str; 9] = ["pose", "bounds", "split", "sort", "tree", "collapse", "trace", "write", "total"];

/// Command-line options.
struct Options {
    scenes: Vec<PathBuf>,
    size: (u32, u32),
    frames: usize,
    threads: usize,
    compares_kinds: bool,
}

/// Scene with the state kept between frames.
struct Subject {
    scene: Scene,
    selection: Selection,
    settings: RenderSettings,
    frame: Frame,
    builder: Builder,
    bvh: Option<Bvh>,
}

/// Times of one frame.
struct Cost {
    tree: BuildStatistics,
    /// Milliseconds, in the order of [`TIMES`].
    milliseconds: [f64; TIMES.len()],
    mega_rays_a_second: f64,
}

fn main() -> Result<()> {
    let options = options(std::env::args().skip(1))?;
    if options.compares_kinds {
        return kinds::print_kinds(&options);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build()?;
    let (width, height) = options.size;
    let mut out = std::io::stdout();
    writeln!(
        out,
        "{width}x{height}, {SAMPLES} samples, {} threads, medians of {} frames in milliseconds",
        pool.current_num_threads(),
        options.frames
    )?;
    writeln!(out, "{}", heading())?;
    for path in &options.scenes {
        let costs = pool.install(|| measure(path, &options)).map_err(|error| error.to_string())?;
        writeln!(out, "{}", row(path, &costs))?;
    }
    Ok(())
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<Options> {
    let mut options =
        Options { scenes: Vec::new(), size: (640, 360), frames: 9, threads: 0, compares_kinds: false };
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            // Cargo passes this to every benchmark.
            "--bench" => {}
            "--size" => {
                let text = value()?;
                let (width, height) = text.split_once('x').ok_or("--size: write 640x360")?;
                options.size = (width.parse()?, height.parse()?);
            }
            "--frames" => options.frames = value()?.parse()?,
            "--kinds" => options.compares_kinds = true,
            "--threads" => options.threads = value()?.parse()?,
            flag if flag.starts_with('-') => return Err(format!("{flag} is not an option").into()),
            scene => options.scenes.push(scene.into()),
        }
    }
    if options.size.0 == 0 || options.size.1 == 0 || options.frames == 0 {
        return Err("--size and --frames are at least 1".into());
    }
    if options.scenes.is_empty() {
        options.scenes.push(DEMO.into());
    }
    Ok(options)
}

/// Renders the frames of one scene. The error is sendable, as it leaves the pool.
fn measure(path: &Path, options: &Options) -> std::result::Result<Vec<Cost>, Box<dyn Error + Send + Sync>> {
    let mut subject = Subject::open(path, options.size)?;
    let folder = tempfile::tempdir()?;
    let mut costs = Vec::new();
    for frame in -1..options.frames as i64 {
        let cost = subject.render(frame.max(0), folder.path())?;
        if frame >= 0 {
            costs.push(cost);
        }
    }
    Ok(costs)
}

impl Subject {
    fn open(path: &Path, resolution: (u32, u32)) -> rayframe::error::Result<Self> {
        let scene = import(path, &ImportOptions::default())?;
        let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene)?;
        let aspect_ratio = resolution.0 as f32 / resolution.1 as f32;
        let selection = resolve_camera(&scene, selection, &ViewRequest::default(), aspect_ratio).selection;
        let settings = RenderSettings {
            resolution,
            window: PixelWindow::full(resolution.0, resolution.1),
            samples: SAMPLES,
            ..RenderSettings::default()
        };
        let (frame, builder) = (Frame::default(), Builder::default());
        Ok(Self { scene, selection, settings, frame, builder, bvh: None })
    }

    fn render(&mut self, frame: i64, folder: &Path) -> rayframe::error::Result<Cost> {
        let start = Instant::now();
        let time_seconds = FrameRate::FILM.time_seconds(frame);

        // Pose.
        self.frame.pose(&self.scene, &self.selection, time_seconds);
        let pose_seconds = start.elapsed().as_secs_f64();

        // Build and trace.
        let expected_rays = expected_rays(&self.settings, 1, &self.frame, &self.environment());
        let build = BuildSettings { expected_rays, refit: Refit::Off, ..BuildSettings::default() };
        let (film, rays) = self.build_and_trace(&build)?;

        // Write.
        let writing = Instant::now();
        let camera = (&self.frame.camera, self.settings.resolution);
        let rate = FrameRate::FILM.as_exr_rational();
        let attributes = frame_attributes(frame, time_seconds, rate, "benchmark", camera);
        write_atomically(&folder.join(format!("{frame:04}.exr")), &exr_file(&film, &attributes)?)?;
        let write_seconds = writing.elapsed().as_secs_f64();

        let tree = self.bvh.as_ref().map(Bvh::statistics).unwrap_or_default();
        let total_seconds = start.elapsed().as_secs_f64();
        Ok(Cost::new(tree, &rays, (pose_seconds, write_seconds, total_seconds)))
    }

    /// The light of the posed scene.
    fn environment(&self) -> Environment {
        let is_lit = !self.frame.lights.is_empty();
        if is_lit { Environment::None } else { Environment::BuiltIn(BuiltInLight::Studio) }
    }

    /// Builds the hierarchy of the posed scene and traces it.
    fn build_and_trace(
        &mut self,
        build: &BuildSettings,
    ) -> rayframe::error::Result<(Film, RenderStatistics)> {
        let cancel = CancelFlag::new();
        let Frame { triangles, flags, .. } = &self.frame;
        let bvh = self.builder.build(triangles, flags, build, &cancel, self.bvh.take())?;
        let environment = self.environment();
        let view = SceneView { scene: &self.scene, frame: &self.frame, bvh: &bvh, environment: &environment };
        let traced = render_frame(&view, &self.settings, &cancel, &|_| ())?;
        self.bvh = Some(bvh);
        Ok(traced)
    }
}

impl Cost {
    fn new(tree: BuildStatistics, rays: &RenderStatistics, (pose, write, total): (f64, f64, f64)) -> Self {
        let seconds = [
            pose,
            tree.bounds_seconds,
            tree.split_seconds,
            tree.sort_seconds,
            tree.tree_seconds,
            tree.collapse_seconds,
            rays.trace_seconds,
            write,
            total,
        ];
        let counts = &rays.integrator;
        let all_rays =
            counts.camera_rays + counts.reflection_rays + counts.refraction_rays + counts.shadow_rays;
        Self {
            tree,
            milliseconds: seconds.map(|seconds| seconds * 1e3),
            mega_rays_a_second: all_rays as f64 / rays.trace_seconds / 1e6,
        }
    }
}

fn heading() -> String {
    let times: Vec<_> = TIMES.iter().map(|name| format!("{name:>9}")).collect();
    let times = times.concat();
    format!("{:<20}{:>10}{:>11}{times}{:>9}", "scene", "triangles", "references", "Mrays/s")
}

fn row(path: &Path, costs: &[Cost]) -> String {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let tree = costs.last().map(|cost| cost.tree).unwrap_or_default();
    let column = |i: usize| median(costs.iter().map(|cost| cost.milliseconds[i]));
    let times: Vec<_> = (0..TIMES.len()).map(|i| format!("{:>9.2}", column(i))).collect();
    let times = times.concat();
    let rays = median(costs.iter().map(|cost| cost.mega_rays_a_second));
    format!("{name:<20}{:>10}{:>11}{times}{rays:>9.2}", tree.triangles, tree.references)
}

/// Median; of an even number of values, the mean of the middle two.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => 0.0,
        length if length % 2 == 0 => f64::midpoint(values[middle - 1], values[middle]),
        _ => values[middle],
    }
}
