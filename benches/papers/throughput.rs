//! Build throughput as in the survey's Figure 9: by number of triangles, and by threads, from triangles to a finished hierarchy.

use std::fmt::Write as _;
use std::time::Instant;

use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use rayframe::bvh::{BuildSettings, Builder, BuilderKind, Refit, Split, TriangleFlags};
use rayframe::cancel::{CancelFlag, Cancelled};
use rayframe::geometry::Triangle;

use super::references::whole;
use super::{Result, lbvh, sah_bvh, scenes};

/// Subdivisions of the scan-like surface: from 1280 to 1.3 million triangles.
const LEVELS: std::ops::RangeInclusive<u32> = 3..=8;

/// Builders, by name.
const BUILDERS: [(&str, Build); 5] = [
    ("Karras, bench", Build::Karras),
    ("HLBVH, bench", Build::Hlbvh),
    ("binned SAH, bench", Build::BinnedSah),
    ("Rayframe, karras", Build::Product(BuilderKind::Karras)),
    ("Rayframe, lbvh", Build::Product(BuilderKind::Lbvh)),
];

#[derive(Clone, Copy, Debug)]
enum Build {
    Karras,
    Hlbvh,
    BinnedSah,
    Product(BuilderKind),
}

/// A measurement.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Point {
    pub(crate) builder: &'static str,
    pub(crate) triangles: usize,
    pub(crate) threads: usize,
    pub(crate) milliseconds: f64,
}

impl Point {
    /// Million triangles a second.
    pub(crate) fn throughput(&self) -> f64 {
        self.triangles as f64 / self.milliseconds / 1e3
    }
}

/// Measures all builders at all sizes with 1 to `most_threads` threads: the least of `repeats` times, after one build that is not timed.
///
/// # Errors
/// Those of the product's builder, and of starting threads.
pub(crate) fn measure(
    most_threads: usize,
    repeats: u32,
    on_point: &mut dyn FnMut(&str),
) -> Result<Vec<Point>> {
    let mut points = Vec::new();
    for level in LEVELS {
        let (triangles, _) = scenes::scan(level);
        for threads in 1..=most_threads {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
            for (name, build) in BUILDERS {
                let seconds = least_seconds(build, &triangles, &pool, repeats)?;
                let (triangles, milliseconds) = (triangles.len(), seconds * 1e3);
                let point = Point { builder: name, triangles, threads, milliseconds };
                on_point(&format!("{name}: {triangles} triangles, {threads} threads, {milliseconds:.2} ms"));
                points.push(point);
            }
        }
    }
    Ok(points)
}

fn least_seconds(build: Build, triangles: &[Triangle], pool: &ThreadPool, repeats: u32) -> Result<f64> {
    let mut builder = Builder::default();
    let flags = vec![TriangleFlags(0); triangles.len()];
    let mut least = f64::INFINITY;
    let mut recycled = None;
    for repeat in 0..=repeats {
        let start = Instant::now();
        pool.install(|| -> std::result::Result<(), Cancelled> {
            match build {
                Build::Karras => drop(lbvh::karras(&whole(triangles))),
                Build::Hlbvh => drop(lbvh::hlbvh(&whole(triangles))),
                Build::BinnedSah => drop(sah_bvh::binned(whole(triangles))),
                Build::Product(kind) => {
                    let settings = BuildSettings {
                        builder: kind,
                        split: Split::Off,
                        refit: Refit::Off,
                        ..BuildSettings::default()
                    };
                    let cancel = CancelFlag::new();
                    recycled = Some(builder.build(triangles, &flags, &settings, &cancel, recycled.take())?);
                }
            }
            Ok(())
        })?;
        if repeat > 0 {
            least = least.min(start.elapsed().as_secs_f64());
        }
    }
    Ok(least)
}

/// Markdown: a row for each size and number of threads, a column for each builder, in million triangles a second.
pub(crate) fn markdown(points: &[Point]) -> String {
    let names = BUILDERS.map(|(name, _)| name).join(" | ");
    let mut text = format!("| triangles | threads | {names} |\n|--:|--:|{}\n", "--:|".repeat(BUILDERS.len()));
    for row in points.chunks(BUILDERS.len()) {
        let cells: Vec<_> = row.iter().map(|point| format!("{:.2}", point.throughput())).collect();
        let _ = writeln!(text, "| {} | {} | {} |", row[0].triangles, row[0].threads, cells.join(" | "));
    }
    text
}

/// CSV.
pub(crate) fn csv(points: &[Point]) -> String {
    let mut text = "builder,triangles,threads,milliseconds,million triangles a second\n".to_owned();
    for point in points {
        let Point { builder, triangles, threads, milliseconds } = point;
        let _ =
            writeln!(text, "\"{builder}\",{triangles},{threads},{milliseconds:.3},{:.3}", point.throughput());
    }
    text
}
