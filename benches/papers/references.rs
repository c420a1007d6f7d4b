//! Boxes over which hierarchies are built, each with its triangle, and the ways to make them before a hierarchy is there.

use glam::Vec3;

use rayframe::geometry::{Aabb, Triangle};

use super::clip::Part;

/// Largest relative error of a hit point and of a box test, with a wide margin.
const PADDING: f32 = 1.0e-6;

/// A box around a triangle or a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reference {
    pub(crate) bounds: Aabb,
    pub(crate) triangle: u32,
}

/// A reference to each triangle.
pub(crate) fn whole(triangles: &[Triangle]) -> Vec<Reference> {
    let of = |(id, triangle): (usize, &Triangle)| Reference {
        bounds: padded(triangle.bounds(), triangle),
        triangle: id as u32,
    };
    triangles.iter().enumerate().map(of).collect()
}

/// Early split clipping (Ernst and Greiner 2007, Algorithm 4): boxes with an area above `sa_max` are cut in the middle of their longest
/// axis, the triangle is clipped, and its parts get tight boxes.
pub(crate) fn early_split(triangles: &[Triangle], sa_max: f64) -> Vec<Reference> {
    split_triangles(triangles, |triangle, parts| {
        let mut pending = vec![Part::whole(triangle)];
        while let Some(part) = pending.pop() {
            let bounds = *part.bounds();
            match middle(&bounds).filter(|_| bounds.area() > sa_max) {
                Some((axis, plane)) => pending.extend(part.cut(axis, plane).into_iter().flatten()),
                None => parts.push(bounds),
            }
        }
    })
}

/// Geometry refinement (Ernst and Greiner 2007, section 4): a triangle whose box has an area above `sa_max` is replaced by the four
/// triangles between its corners and the middles of its edges.
pub(crate) fn refined(triangles: &[Triangle], sa_max: f64) -> Vec<Reference> {
    split_triangles(triangles, |triangle, parts| {
        let mut pending = vec![triangle.vertices];
        while let Some([a, b, c]) = pending.pop() {
            let bounds = Aabb::from_points(&[a, b, c]);
            let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
            let smaller = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
            // Where coordinates have no floats between them, a part is as large as the whole.
            let shrinks = smaller.iter().all(|part| Aabb::from_points(part).area() < bounds.area());
            if bounds.area() > sa_max && shrinks {
                pending.extend(smaller);
            } else {
                parts.push(bounds);
            }
        }
    })
}

/// References to the boxes that `split` makes of each triangle.
fn split_triangles(triangles: &[Triangle], split: impl Fn(&Triangle, &mut Vec<Aabb>)) -> Vec<Reference> {
    let mut references = Vec::with_capacity(triangles.len());
    let mut parts = Vec::new();
    for (id, triangle) in triangles.iter().enumerate() {
        split(triangle, &mut parts);
        let reference = |bounds| Reference { bounds: padded(bounds, triangle), triangle: id as u32 };
        references.extend(parts.drain(..).map(reference));
    }
    references
}

/// The middle of the longest axis of a box; `None` where no float lies between its ends.
pub(crate) fn middle(bounds: &Aabb) -> Option<(usize, f32)> {
    let axis = bounds.extent().max_position();
    let plane = bounds.center()[axis];
    (bounds.min[axis] < plane && plane < bounds.max[axis]).then_some((axis, plane))
}

/// A box grown by the rounding errors of hits with `triangle`.
pub(crate) fn padded(bounds: Aabb, triangle: &Triangle) -> Aabb {
    let largest =
        triangle.vertices.iter().fold(0.0_f32, |largest, vertex| largest.max(vertex.abs().max_element()));
    bounds.grown(largest * PADDING)
}

/// The box of all references.
pub(crate) fn bounds_of(references: &[Reference]) -> Aabb {
    references.iter().fold(Aabb::EMPTY, |all, reference| all.union(reference.bounds))
}

/// The box of the centres of all references.
pub(crate) fn center_bounds(references: &[Reference]) -> Aabb {
    references.iter().fold(Aabb::EMPTY, |all, reference| all.union_point(reference.bounds.center()))
}

/// Overlap E of the boxes: their areas over that of the scene's box.
pub(crate) fn overlap(references: &[Reference]) -> f64 {
    references.iter().map(|reference| reference.bounds.area()).sum::<f64>() / bounds_of(references).area()
}

/// Box area over that of many tiny boxes around a triangle from which the box is sparse, as in the product.
const SPARSE: f64 = 4.0;

/// Overlap D: the same of sparse boxes alone. Tiny boxes around a triangle have twice the area of its projections along the axes.
pub(crate) fn sparse_overlap(references: &[Reference], triangles: &[Triangle]) -> f64 {
    let tiny = |reference: &Reference| {
        let [a, b, c] = triangles[reference.triangle as usize].vertices.map(Vec3::as_dvec3);
        (b - a).cross(c - a).abs().element_sum()
    };
    let sparse = references.iter().filter(|reference| reference.bounds.area() >= SPARSE * tiny(reference));
    // Not a sum, which is -0.0 where nothing is sparse.
    sparse.fold(0.0, |sum, reference| sum + reference.bounds.area()) / bounds_of(references).area()
}

/// Whether all corners of a triangle are finite.
pub(crate) fn is_finite(triangle: &Triangle) -> bool {
    triangle.vertices.iter().copied().all(Vec3::is_finite)
}
