//! Late split clipping (Ernst and Greiner 2007, section 5.1): the hierarchy is built over whole triangles, and then each leaf whose box has
//! an area above SA_max becomes a tree over the parts of its triangle. No box above the leaves shrinks.

use rayframe::geometry::Triangle;

use super::clip::Part;
use super::hierarchy::{Bvh2, Node};
use super::references::{Reference, middle, padded};

/// What a node of the new tree is made from.
enum Source {
    Node(u32),
    /// References of a leaf, first and count.
    Leaf(u32, u32),
    Part(u32, Part),
}

/// The hierarchy with split leaves.
pub(crate) fn late_split(whole: &Bvh2, triangles: &[Triangle], sa_max: f64) -> Bvh2 {
    let mut split = Bvh2::default();
    let Some(root) = whole.nodes.first() else { return split };
    split.nodes.push(*root);
    let mut pending = vec![(0_usize, Source::Node(0))];
    while let Some((index, source)) = pending.pop() {
        let children = match source {
            Source::Node(node) => {
                let Node { first, count, .. } = whole.nodes[node as usize];
                if count > 0 {
                    pending.push((index, Source::Leaf(first, count)));
                    continue;
                }
                [first, first + 1].map(|child| (whole.nodes[child as usize].bounds, Source::Node(child)))
            }
            Source::Leaf(first, 1) => {
                let reference = whole.references[first as usize];
                let triangle = &triangles[reference.triangle as usize];
                pending.push((index, Source::Part(reference.triangle, Part::whole(triangle))));
                continue;
            }
            Source::Leaf(first, count) => {
                let half = count / 2;
                [(first, half), (first + half, count - half)].map(|(first, count)| {
                    let references = &whole.references[first as usize..(first + count) as usize];
                    (super::references::bounds_of(references), Source::Leaf(first, count))
                })
            }
            Source::Part(id, part) => {
                let triangle = &triangles[id as usize];
                let cut = middle(part.bounds()).filter(|_| part.bounds().area() > sa_max);
                let parts: Vec<_> =
                    cut.map(|(axis, plane)| part.cut(axis, plane)).into_iter().flatten().flatten().collect();
                let Ok(parts) = <[Part; 2]>::try_from(parts) else {
                    let bounds = padded(*part.bounds(), triangle);
                    let first = split.references.len() as u32;
                    split.references.push(Reference { bounds, triangle: id });
                    split.nodes[index] = Node { bounds, first, count: 1 };
                    continue;
                };
                parts.map(|part| (padded(*part.bounds(), triangle), Source::Part(id, part)))
            }
        };
        let first = split.nodes.len();
        split.nodes[index].first = first as u32;
        split.nodes[index].count = 0;
        for (bounds, _) in &children {
            split.nodes.push(Node { bounds: *bounds, first: 0, count: 0 });
        }
        let [left, right] = children;
        pending.push((first + 1, right.1));
        pending.push((first, left.1));
    }
    split
}
