//! Rows of one configuration of Rayframe on one scene.

use rayframe::bvh::TraversalCounters;
use rayon::ThreadPool;

use crate::Result;
use crate::folder::{FRAME_SETS, Subject};
use crate::product;
use crate::table::{Key, Table};
use peers::build::{self, Cost};
use peers::configuration::Configuration;
use peers::ray_set::Query;
use peers::trace::{self, Traced};

/// Measures builds and all sets of rays.
pub(crate) fn measure(
    subject: &Subject,
    configuration: &Configuration,
    pool: &ThreadPool,
    table: &mut Table,
) -> Result<()> {
    let threads = pool.current_num_threads();
    let key = Key { library: "rayframe", scene: &subject.name, configuration: configuration.name, threads };
    let (bvh, cost) = build::measure(&subject.soup, &configuration.settings(), pool)?;
    write_build(&cost, key, table)?;

    let mut frame_ms = [cost.rebuild_seconds * 1e3; 2];
    for (index, set) in subject.sets.iter().enumerate().filter(|(_, set)| !set.rays.is_empty()) {
        let single = trace::single(&bvh, &set.rays, set.query, threads);
        let packet = trace::batches(&bvh, set.batched(), set.query, threads);
        table.row(key, &format!("hits:{}", set.name), single.hits as f64)?;
        write_trace(&single, key, &format!("{}:single", set.name), table)?;
        write_trace(&packet, key, &format!("{}:packet", set.name), table)?;
        if set.from_light.is_some() {
            let surface = trace::batches(&bvh, &set.rays, Query::Occluded, threads);
            write_trace(&surface, key, &format!("{}:packet_surface", set.name), table)?;
        }
        if index < FRAME_SETS {
            frame_ms[0] += single.seconds * 1e3;
            frame_ms[1] += packet.seconds * 1e3;
        }
    }
    table.row(key, "frame_ms:single", frame_ms[0])?;
    table.row(key, "frame_ms:packet", frame_ms[1])?;
    if configuration.name == "auto" {
        let compared = product::compare(subject, &configuration.settings(), &bvh, pool)?;
        table.row(key, "trace_ms:render", compared.render_ms)?;
        table.row(key, "trace_ms:rays", compared.rays_ms)?;
        table.row(key, "trace_ms:ratio", compared.render_ms / compared.rays_ms)?;
    }
    Ok(())
}

fn write_build(cost: &Cost, key: Key<'_>, table: &mut Table) -> Result<()> {
    let tree = cost.fastest;
    let per_triangle = 1.0 / tree.triangles.max(1) as f64;
    table.row(key, "build_ms", cost.build_seconds * 1e3)?;
    table.row(key, "rebuild_ms", cost.rebuild_seconds * 1e3)?;
    table.row(key, "references", tree.references as f64 * per_triangle)?;
    table.row(key, "sah", f64::from(tree.sah_cost))?;
    table.row(key, "bytes_per_triangle", tree.bytes as f64 * per_triangle)?;
    table.row(key, "depth", f64::from(tree.depth))
}

fn write_trace(traced: &Traced, key: Key<'_>, rays: &str, table: &mut Table) -> Result<()> {
    let TraversalCounters { rays: count, nodes, triangles } = traced.counters;
    table.row(key, &format!("mrays:{rays}"), traced.mega_rays())?;
    table.row(key, &format!("nodes:{rays}"), nodes as f64 / count as f64)?;
    table.row(key, &format!("triangles:{rays}"), triangles as f64 / count as f64)
}
