//! The vertices that the triangles of a primitive use. Files often share one vertex list among many primitives.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::context::Context;
use crate::error::Result;

/// Triangles of one parallel task.
const TRIANGLES_PER_TASK: usize = 16_384;

/// Bytes of scratch memory and of the result for each vertex from the first used one to the last.
const BYTES_PER_VERTEX: u64 = 9;

/// The vertices that `triangles` use of `vertex_count`, in increasing order. `triangles` have indices into this list then. `None` if all are
/// used. The memory is charged to the object at `pointer`.
pub(super) fn select_vertices(
    context: &mut Context,
    triangles: &mut [[u32; 3]],
    vertex_count: usize,
    pointer: &str,
) -> Result<Option<Vec<u32>>> {
    // Only vertices from the first used one to the last cost time.
    let bounds = |task: &[[u32; 3]]| {
        let corners = task.as_flattened();
        (corners.iter().copied().min(), corners.iter().copied().max())
    };
    let (first, last) = triangles
        .par_chunks(TRIANGLES_PER_TASK)
        .map(bounds)
        .reduce(|| (None, None), |a, b| (a.0.into_iter().chain(b.0).min(), a.1.max(b.1)));
    let (Some(first), Some(last)) = (first, last) else {
        return Ok((vertex_count > 0).then(Vec::new));
    };
    let range = u64::from(last.saturating_sub(first)).saturating_add(1);
    let used_before = context.used_bytes();
    context.charge(range.saturating_mul(BYTES_PER_VERTEX), pointer)?;
    let offset = |vertex: u32| vertex.saturating_sub(first) as usize;
    let is_used: Vec<AtomicBool> = (first..=last).map(|_| AtomicBool::new(false)).collect();
    triangles.par_iter().with_min_len(TRIANGLES_PER_TASK).flatten_iter().for_each(|&vertex| {
        // Most vertices are named several times, and a store takes the cache line from other threads.
        if let Some(flag) = is_used.get(offset(vertex))
            && !flag.load(Ordering::Relaxed)
        {
            flag.store(true, Ordering::Relaxed);
        }
    });
    let vertices: Vec<u32> = (first..=last)
        .zip(&is_used)
        .filter_map(|(vertex, flag)| flag.load(Ordering::Relaxed).then_some(vertex))
        .collect();
    if vertices.len() == vertex_count {
        context.release_temporaries(used_before, 0);
        return Ok(None);
    }
    let mut renumbered = vec![0_u32; is_used.len()];
    for (new, &old) in (0_u32..).zip(&vertices) {
        if let Some(number) = renumbered.get_mut(offset(old)) {
            *number = new;
        }
    }
    for vertex in triangles.as_flattened_mut() {
        *vertex = renumbered.get(offset(*vertex)).copied().unwrap_or_default();
    }
    context.release_temporaries(used_before, (vertices.len() as u64).saturating_mul(4));
    Ok(Some(vertices))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn used_vertices_are_numbered_in_their_order() {
        let mut context = Context::new(std::path::Path::new("a.gltf"), 1 << 20);
        let mut select = |triangles: &mut [[u32; 3]], count| {
            select_vertices(&mut context, triangles, count, "/meshes/0").unwrap()
        };
        let mut triangles = [[9, 4, 6], [6, 4, 11]];
        assert_eq!(select(&mut triangles, 20), Some(vec![4, 6, 9, 11]));
        assert_eq!(triangles, [[2, 0, 1], [1, 0, 3]]);
        // The same list again is whole.
        assert_eq!(select(&mut triangles, 4), None);
        assert_eq!(triangles, [[2, 0, 1], [1, 0, 3]]);
        // The first vertices alone.
        assert_eq!(select(&mut triangles, 5), Some(vec![0, 1, 2, 3]));
        assert_eq!(select(&mut [], 5), Some(vec![]));
        assert_eq!(select(&mut [], 0), None);
    }

    #[test]
    fn distant_vertices_are_refused_before_memory_is_taken() {
        let mut context = Context::new(std::path::Path::new("a.gltf"), 1 << 30);
        let mut triangles = [[0, 1, u32::MAX - 7]];
        let error =
            select_vertices(&mut context, &mut triangles, u32::MAX as usize, "/meshes/0").unwrap_err();
        assert_eq!(error.exit_code(), 77);
    }
}
