//! End-point overlap (Aila, Karras and Laine, "On Quality Metrics of Bounding Volume Hierarchies", HPG 2013): the share of the scene's
//! surface that lies in boxes of nodes which do not hold it, weighted by the cost of the node.

use rayframe::geometry::Triangle;

use super::clip::Part;
use super::hierarchy::Bvh2;

/// Largest number of triangles that are looked at; of more, every n-th is.
const MOST_TRIANGLES: usize = 20_000;

/// The end-point overlap of a hierarchy.
pub(crate) fn end_point_overlap(hierarchy: &Bvh2, triangles: &[Triangle]) -> f64 {
    let ranges = ranges(hierarchy);
    let mut places = vec![Vec::new(); triangles.len()];
    for (place, reference) in (0_u32..).zip(&hierarchy.references) {
        places[reference.triangle as usize].push(place);
    }
    let step = triangles.len().div_ceil(MOST_TRIANGLES).max(1);
    let (mut outside, mut all) = (0.0, 0.0);
    for (triangle, places) in triangles.iter().zip(&places).step_by(step) {
        all += Part::whole(triangle).area();
        let mut pending = vec![(0_u32, Part::whole(triangle))];
        while let Some((index, part)) = pending.pop() {
            let Some(node) = hierarchy.nodes.get(index as usize) else { continue };
            let Some(part) = part.inside(&node.bounds) else { continue };
            let [first, end] = ranges[index as usize];
            let next = places.partition_point(|&place| place < first);
            if places.get(next).is_none_or(|&place| place >= end) {
                outside += part.area() * f64::from(node.count.max(1));
            }
            if node.count == 0 {
                pending.extend([(node.first, part.clone()), (node.first + 1, part)]);
            }
        }
    }
    if all > 0.0 { outside / all } else { 0.0 }
}

/// The references below each node, first and end. References are in the order of leaves.
fn ranges(hierarchy: &Bvh2) -> Vec<[u32; 2]> {
    let mut ranges = vec![[u32::MAX, 0]; hierarchy.nodes.len()];
    // Children come after their parents.
    for index in (0..hierarchy.nodes.len()).rev() {
        let node = hierarchy.nodes[index];
        ranges[index] = if node.count > 0 {
            [node.first, node.first + node.count]
        } else {
            let [a, b] = [node.first, node.first + 1].map(|child| ranges[child as usize]);
            [a[0].min(b[0]), a[1].max(b[1])]
        };
    }
    ranges
}
