//! Renders files with the automatic camera and prints what share of the image the asset covers:
//! `cargo run --release -p oracles --bin camera_coverage [--all] FILE…`. Files with cameras of their own are left out without `--all`.
//!
//! It is measured in up to nine frames, evenly over the animation, by the rectangle of the covered pixels: the least is its larger side as
//! a share of the image's smaller side, the most the larger share of its sides in those of the image. The exit code is 1 where the
//! least is below 25 % or the most above 85 %. Cameras inside interiors are listed with the number of nodes that they see, at least five.

#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use rayframe::framing::{CameraRule, framed_nodes};
use rayframe::gltf::ImageLoading;
use rayframe::image::Samples;
use rayframe::output::Aov;
use rayframe::scene::CameraRequest;
use rayframe::settings::Settings;
use rayframe::shot::{RenderJob, ShotSettings, resolve};
use rayframe::{RenderedFrame, Renderer};

/// Size of the images in pixels.
const SIZE: (u32, u32) = (320, 180);
/// Accepted coverage.
const LEAST: f32 = 0.25;
const MOST: f32 = 0.85;
/// Fewest nodes that an interior shows.
const NODES: usize = 5;
/// Most frames of one file.
const FRAMES: usize = 9;

/// One line of the table.
struct Measured {
    rule: CameraRule,
    least: f32,
    most: f32,
    nodes: usize,
    /// Time to resolve the job with the automatic camera, and with a camera at a given place.
    seconds: [Duration; 2],
}

impl Measured {
    fn is_good(&self) -> bool {
        match self.rule {
            CameraRule::Inside => self.nodes >= NODES,
            _ => self.least >= LEAST && self.most <= MOST,
        }
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let is_all = arguments.first().is_some_and(|first| first.as_os_str() == "--all");
    let files = if is_all { arguments.split_off(1) } else { arguments };
    let mut good = 0;
    let mut measured_files = 0;
    println!("{:<44} {:<8} {:>8} {:>8} {:>6} {:>9}", "file", "camera", "least", "most", "nodes", "cost");
    for file in &files {
        let Some(measured) = measure(file, is_all)? else { continue };
        let [automatic, given] = measured.seconds.map(|time| time.as_secs_f64() * 1e3);
        let verdict = if measured.is_good() { "" } else { "  outside the limits" };
        println!(
            "{:<44} {:<8} {:7.1}% {:7.1}% {:>6} {:6.1} ms{verdict}",
            file.file_name().unwrap_or_default().to_string_lossy(),
            if measured.rule == CameraRule::Inside { "inside" } else { "outside" },
            measured.least * 100.0,
            measured.most * 100.0,
            measured.nodes,
            (automatic - given).max(0.0),
        );
        good += usize::from(measured.is_good());
        measured_files += 1;
    }
    println!("{good} of {measured_files} within the limits");
    Ok(if good == measured_files { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Measures one file; `None` where its own camera is used.
fn measure(file: &Path, is_all: bool) -> Result<Option<Measured>, Box<dyn Error>> {
    let renderer = Renderer::open(file)?.size(SIZE.0, SIZE.1).samples(1);
    if !renderer.scene().cameras.is_empty() && !is_all {
        return Ok(None);
    }
    let renderer = renderer.camera(CameraRequest::Auto).aovs([Aov::NodeId]).set("background", "none")?;
    let (job, automatic) = resolved(renderer.settings(), file)?;
    let framed = framed_nodes(&job.sequence.scene, &job.sequence.selection);
    let fixed = renderer.clone().set("camera_position", "1,1,1")?.set("look_at", "0,0,0")?;
    let (_, given) = resolved(fixed.settings(), file)?;

    let sequence = renderer.sequence(std::env::temp_dir().join("coverage.####.exr"))?;
    let all = sequence.frames();
    let count = all.len().min(FRAMES);
    let frames: BTreeSet<i64> =
        (0..count).map(|index| all[index * (all.len() - 1) / count.saturating_sub(1).max(1)]).collect();
    let mut measured =
        Measured { rule: job.camera, least: f32::INFINITY, most: 0.0, nodes: 0, seconds: [automatic, given] };
    for frame in frames {
        let image = renderer.frame(frame)?;
        let nodes = node_ids(&image)?;
        let (of_smaller_side, of_own_sides) = coverage(&image, &nodes, &framed);
        measured.least = measured.least.min(of_smaller_side);
        measured.most = measured.most.max(of_own_sides);
        let seen: BTreeSet<u32> = nodes.into_iter().filter(|&id| id != 0).collect();
        measured.nodes = measured.nodes.max(seen.len());
    }
    Ok(Some(measured))
}

/// The job, and the time to resolve it without decoding images.
fn resolved(settings: &Settings, file: &Path) -> Result<(RenderJob, Duration), Box<dyn Error>> {
    let mut settings = settings.clone();
    settings.scene = Some(file.to_owned().into());
    let shot = ShotSettings::merge([settings], None)?;
    let begin = Instant::now();
    let job = resolve(&shot, ImageLoading::Budget)?;
    Ok((job, begin.elapsed()))
}

/// The larger side of the rectangle of pixels of framed nodes as a share of the image's smaller side, and the larger share of its
/// sides in those of the image. Pixels are covered at their centres.
fn coverage(image: &RenderedFrame, nodes: &[u32], framed: &BTreeSet<u32>) -> (f32, f32) {
    let (width, height) = image.size();
    let covered = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let is_framed = |id: u32| id.checked_sub(1).is_some_and(|node| framed.contains(&node));
    let covered: Vec<_> = covered.filter(|&(x, y)| is_framed(nodes[(y * width + x) as usize])).collect();
    let side = |of: fn(&(u32, u32)) -> u32| {
        let least = covered.iter().map(of).min().unwrap_or(1);
        let most = covered.iter().map(of).max().unwrap_or(0);
        (most + 1).saturating_sub(least) as f32
    };
    let sides = [side(|&(x, _)| x), side(|&(_, y)| y)];
    let share = sides[0].max(sides[1]) / width.min(height) as f32;
    (share, (sides[0] / width as f32).max(sides[1] / height as f32))
}

/// Index of the node plus one, or 0, of each pixel.
fn node_ids(image: &RenderedFrame) -> Result<Vec<u32>, Box<dyn Error>> {
    let image = image.image()?;
    let ids = image.channel("node_id").ok_or("no node_id is recorded")?;
    let Samples::Uint(ids) = &ids.samples else { return Err("node_id holds no integers".into()) };
    Ok(ids.clone())
}
