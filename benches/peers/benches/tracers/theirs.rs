//! Rows of one preset of obvhs on one scene.

use rayon::ThreadPool;

use crate::Result;
use crate::folder::{FRAME_SETS, Subject};
use crate::table::{Key, Table};
use peers::obvhs_build;
use peers::obvhs_preset::{LIBRARY, Preset};
use peers::obvhs_trace;

/// Measures builds and single rays; obvhs has no packets.
pub(crate) fn measure(
    subject: &Subject,
    preset: &Preset,
    pool: &ThreadPool,
    table: &mut Table,
) -> Result<()> {
    let threads = pool.current_num_threads();
    let key = Key { library: LIBRARY, scene: &subject.name, configuration: &preset.name, threads };
    let triangles = obvhs_build::triangles(&subject.soup.triangles);
    let (tree, [build_seconds, rebuild_seconds]) = obvhs_build::measure(&triangles, preset, pool);
    table.row(key, "build_ms", build_seconds * 1e3)?;
    table.row(key, "rebuild_ms", rebuild_seconds * 1e3)?;

    let mut frame_ms = rebuild_seconds * 1e3;
    for (index, set) in subject.sets.iter().enumerate().filter(|(_, set)| !set.rays.is_empty()) {
        let rays = obvhs_trace::rays(set);
        let (mega_rays, hits) = obvhs_trace::single(&tree, &rays, set.query, threads);
        table.row(key, &format!("mrays:{}:single", set.name), mega_rays)?;
        table.row(key, &format!("hits:{}", set.name), hits as f64)?;
        if index < FRAME_SETS {
            frame_ms += set.rays.len() as f64 / mega_rays * 1e-3;
        }
    }
    table.row(key, "frame_ms:single", frame_ms)
}
