//! Triangles from vertex indices and a primitive mode.
//!
//! Source: glTF 2.0 specification, section 3.7.2.1 (overview of meshes), the formulas of topology types.

use gltf::json::accessor::ComponentType;
use gltf::json::mesh::Mode;
use rayon::prelude::*;

use super::accessor::Data;
use super::attributes::Reference;
use super::context::Context;
use super::formats;
use super::scan::first_wrong;
use crate::error::Result;

/// Triangles of one parallel task.
const TRIANGLES_PER_TASK: usize = 16_384;

/// Vertex list of a primitive: its indices, or all vertices in order.
pub(super) fn read_indices(
    context: &mut Context,
    data: &Data,
    indices: Option<&Reference>,
    vertex_count: usize,
    pointer: &str,
) -> Result<Vec<u32>> {
    let Some(reference) = indices else {
        let mut list = context.allocate(vertex_count as u64, pointer)?;
        list.extend(0..u32::try_from(vertex_count).unwrap_or(u32::MAX));
        return Ok(list);
    };
    let elements: Vec<[u32; 1]> = data.integers_as(context, reference, &formats::INDICES)?;
    let accessor = data.accessor(context, reference.accessor, &reference.pointer)?;
    let restart = match formats::Format::of(accessor).map(|format| format.component) {
        Some(ComponentType::U8) => u32::from(u8::MAX),
        Some(ComponentType::U16) => u32::from(u16::MAX),
        _ => u32::MAX,
    };
    let list = elements.into_flattened();
    // The restart value is the largest of its type.
    let end = u32::try_from(vertex_count).unwrap_or(u32::MAX).min(restart);
    let is_wrong = |&index: &u32| index >= end;
    match first_wrong(&list, is_wrong) {
        None => Ok(list),
        Some(i) => {
            let index = list.get(i).copied().unwrap_or_default();
            let why = if index == restart {
                "is the primitive restart value, which glTF does not allow".to_owned()
            } else {
                format!("is vertex {index}, but there are only {vertex_count} vertices")
            };
            Err(context.invalid(format!("/accessors/{}", reference.accessor), format!("index {i} {why}")))
        }
    }
}

/// Number of the triangles of a list of `vertices` in the primitive mode `mode`.
pub(super) fn triangle_count(mode: Mode, vertices: usize) -> usize {
    match mode {
        Mode::Triangles => vertices / 3,
        Mode::TriangleStrip | Mode::TriangleFan => vertices.saturating_sub(2),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => 0,
    }
}

/// Triangles of a vertex list in the primitive mode `mode`, with the winding of the file, and the number of unused
/// vertices at the end. Points and lines give no triangles.
pub(super) fn triangles(mode: Mode, list: &[u32]) -> (Vec<[u32; 3]>, usize) {
    let at_least_three = if list.len() < 3 { list.len() } else { 0 };
    match mode {
        Mode::Triangles => {
            let (whole, rest) = list.as_chunks::<3>();
            (whole.par_iter().copied().with_min_len(TRIANGLES_PER_TASK).collect(), rest.len())
        }
        Mode::TriangleStrip => {
            let windows = list.windows(3).enumerate();
            let strip = windows.filter_map(|(i, window)| match (window, i & 1) {
                (&[a, b, c], 0) => Some([a, b, c]),
                (&[a, b, c], _) => Some([a, c, b]),
                _ => None,
            });
            (strip.collect(), at_least_three)
        }
        Mode::TriangleFan => {
            let Some((&center, rim)) = list.split_first() else {
                return (Vec::new(), 0);
            };
            let fan = rim.windows(2).filter_map(|window| match window {
                &[a, b] => Some([a, b, center]),
                _ => None,
            });
            (fan.collect(), at_least_three)
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => (Vec::new(), 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_alternate_their_winding() {
        // p_i = {v_i, v_(i + 1 + i mod 2), v_(i + 2 - i mod 2)}
        let (strip, rest) = triangles(Mode::TriangleStrip, &[10, 11, 12, 13, 14]);
        assert_eq!(strip, [[10, 11, 12], [11, 13, 12], [12, 13, 14]]);
        assert_eq!(rest, 0);
    }

    #[test]
    fn fans_share_their_first_vertex() {
        // p_i = {v_(i + 1), v_(i + 2), v_0}
        let (fan, _) = triangles(Mode::TriangleFan, &[5, 6, 7, 8]);
        assert_eq!(fan, [[6, 7, 5], [7, 8, 5]]);
    }

    #[test]
    fn short_lists_have_no_triangles() {
        for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
            assert_eq!(triangles(mode, &[]), (vec![], 0));
            assert_eq!(triangles(mode, &[1]), (vec![], 1));
            assert_eq!(triangles(mode, &[1, 2]), (vec![], 2));
        }
        assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 3]), (vec![[0, 1, 2]], 1));
    }

    #[test]
    fn counts_are_those_of_the_triangles() {
        let list = [0, 1, 2, 3, 4, 5, 6];
        let modes = [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan, Mode::Points, Mode::LineStrip];
        for (mode, length) in
            modes.iter().flat_map(|mode| (0..=list.len()).map(move |length| (*mode, length)))
        {
            let (found, _) = triangles(mode, &list[..length]);
            assert_eq!(triangle_count(mode, length), found.len(), "{mode:?} {length}");
        }
    }
}
