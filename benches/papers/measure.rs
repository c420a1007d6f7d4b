//! Measurements of all systems on one scene.

use std::time::Instant;

use rayframe::geometry::Ray;
use rayon::ThreadPool;
use serde::Serialize;

use super::Result;
use super::hierarchy::{Closest, Counters};
use super::options::{Options, Report};
use super::rays::{primary, secondary};
use super::references::{Reference, bounds_of, overlap, sparse_overlap, whole};
use super::scenes::TestScene;
use super::systems::{Properties, System, splits, sweep, systems};

/// Work and time of one kind of rays, each a ray.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct PerRay {
    pub(crate) nodes: f64,
    pub(crate) triangles: f64,
    pub(crate) microseconds: f64,
}

/// Row of a scene's table.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) system: String,
    /// References a triangle (R).
    pub(crate) references_a_triangle: f64,
    pub(crate) build_milliseconds: f64,
    /// Camera rays.
    pub(crate) primary: PerRay,
    /// Camera rays, and shadow and mirror rays of their hits.
    pub(crate) frame: PerRay,
    /// Speed-up of camera rays over the unsplit SAH BVH, and over the unsplit LBVH (S).
    pub(crate) speed_up: [f64; 2],
    pub(crate) nodes: usize,
    pub(crate) depth: u32,
    pub(crate) sah_cost: f64,
    pub(crate) end_point_overlap: Option<f64>,
    pub(crate) bytes_a_triangle: f64,
    pub(crate) is_automatic: bool,
}

/// Table of a scene.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SceneTable {
    pub(crate) scene: String,
    pub(crate) triangles: usize,
    /// Overlap E: areas of the triangles' boxes over that of the scene's.
    pub(crate) overlap: f64,
    /// Overlap D: the same of sparse boxes alone.
    pub(crate) sparse_overlap: f64,
    pub(crate) rays: usize,
    pub(crate) rows: Vec<Row>,
    pub(crate) left_out: Vec<String>,
}

impl SceneTable {
    /// A table without rows.
    fn new(scene: &TestScene, references: &[Reference]) -> Self {
        Self {
            scene: scene.name.clone(),
            triangles: scene.triangles.len(),
            overlap: overlap(references),
            sparse_overlap: sparse_overlap(references, &scene.triangles),
            rays: 0,
            rows: Vec::new(),
            left_out: Vec::new(),
        }
    }
}

/// Builds and traces every system. Calls `on_row` after each.
///
/// # Errors
/// A system whose hits differ from those of the product.
pub(crate) fn measure(
    scene: &TestScene,
    options: &Options,
    pool: &ThreadPool,
    on_row: &mut dyn FnMut(&Row),
) -> Result<SceneTable> {
    let TestScene { triangles, view, .. } = scene;
    let references = whole(triangles);
    let area_a_triangle = bounds_of(&references).area() / triangles.len() as f64;
    let camera_rays = primary(view, options.size);
    let mut table = SceneTable::new(scene, &references);

    // The hits that all must have are the product's.
    let all = match options.report {
        Report::Sweep => sweep(&options.factors, area_a_triangle),
        Report::Gain => splits(),
        Report::Table | Report::Throughput => systems(&options.factors, area_a_triangle),
    };
    let automatic = all.iter().find(|system| system.is_automatic()).ok_or("no automatic system")?;
    let (structure, _) = automatic.build(triangles, pool)?.ok_or("the product's hierarchy is too large")?;
    let (mut expected, mut expected_of_others, mut hits) = (Vec::new(), Vec::new(), Vec::new());
    structure.trace(&camera_rays, triangles, &mut expected);
    let others = secondary(&camera_rays, &expected, triangles, view.lamp);
    structure.trace(&others, triangles, &mut expected_of_others);
    table.rays = camera_rays.len() + others.len();
    drop(structure);

    for system in &all {
        let Some((structure, mut seconds)) = system.build(triangles, pool)? else {
            table.left_out.push(system.name.clone());
            continue;
        };
        for _ in 1..options.repeats {
            seconds = system.build(triangles, pool)?.map_or(seconds, |(_, again)| seconds.min(again));
        }
        let mut traced = |rays: &[Ray], expected: &[Closest]| -> Result<PerRay> {
            let (mut counters, mut seconds) = (Counters::default(), f64::INFINITY);
            for _ in 0..options.repeats {
                let start = Instant::now();
                counters = structure.trace(rays, triangles, &mut hits);
                seconds = seconds.min(start.elapsed().as_secs_f64());
            }
            same_hits(system, rays, &hits, expected)?;
            let count = rays.len().max(1) as f64;
            let (nodes, triangles) = (counters.nodes as f64 / count, counters.triangles as f64 / count);
            Ok(PerRay { nodes, triangles, microseconds: seconds * 1e6 / count })
        };
        let of_camera = traced(&camera_rays, &expected)?;
        let of_others = traced(&others, &expected_of_others)?;
        let properties = structure.properties(triangles, options.has_overlap);
        let row = row(
            system,
            &properties,
            seconds,
            [(of_camera, camera_rays.len()), (of_others, others.len())],
            triangles.len(),
        );
        on_row(&row);
        table.rows.push(row);
    }
    set_speed_ups(&mut table.rows);
    Ok(table)
}

/// Speed-ups over the unsplit hierarchies, of which there may be none.
fn set_speed_ups(rows: &mut [Row]) {
    for (index, unsplit) in ["SAH BVH, full sweep", "LBVH (Karras)"].into_iter().enumerate() {
        let base = rows.iter().find(|row| row.system == unsplit).map_or(0.0, |row| row.primary.microseconds);
        for row in &mut *rows {
            row.speed_up[index] = base / row.primary.microseconds;
        }
    }
}

fn row(
    system: &System,
    properties: &Properties,
    seconds: f64,
    [(camera, cameras), (other, others)]: [(PerRay, usize); 2],
    triangles: usize,
) -> Row {
    let mean = |of: fn(&PerRay) -> f64| {
        (of(&camera) * cameras as f64 + of(&other) * others as f64) / (cameras + others).max(1) as f64
    };
    let frame = PerRay {
        nodes: mean(|ray| ray.nodes),
        triangles: mean(|ray| ray.triangles),
        microseconds: mean(|ray| ray.microseconds),
    };
    Row {
        system: system.name.clone(),
        references_a_triangle: properties.references as f64 / triangles as f64,
        build_milliseconds: seconds * 1e3,
        primary: camera,
        frame,
        speed_up: [0.0; 2],
        nodes: properties.nodes,
        depth: properties.depth,
        sah_cost: properties.sah_cost,
        end_point_overlap: properties.overlap,
        bytes_a_triangle: properties.bytes as f64 / triangles as f64,
        is_automatic: system.is_automatic(),
    }
}

/// Compares hits to the last bit.
fn same_hits(system: &System, rays: &[Ray], hits: &[Closest], expected: &[Closest]) -> Result<()> {
    let key = |hit: &Closest| hit.map(|(t, id)| (t.to_bits(), id));
    let differs = |(found, expected): &(&Closest, &Closest)| key(found) != key(expected);
    let pairs = || hits.iter().zip(expected);
    let Some(at) = pairs().position(|pair| differs(&pair)) else { return Ok(()) };
    let count = pairs().filter(differs).count();
    Err(format!(
        "{}: {count} hits differ from the product's, the first of {:?}: {:?} instead of {:?}",
        system.name, rays[at], hits[at], expected[at]
    )
    .into())
}
