//! Brute force: each ray tests each triangle by the definition of a hit. Reference implementation of every query.

use crate::bvh::hit::Hit;
use crate::bvh::is_traced;
use crate::bvh::statistics::TraversalCounters;
use crate::bvh::traverse::Visitor;
use crate::bvh::triangle_flags::TriangleFlags;
use crate::geometry::{Ray, Triangle};

/// List of all traced triangles with their indices.
#[derive(Debug, Default)]
pub(crate) struct TriangleList {
    entries: Vec<(u32, TriangleFlags, Triangle)>,
}

impl TriangleList {
    /// Lists the traced triangles.
    pub(crate) fn new(triangles: &[Triangle], flags: &[TriangleFlags]) -> Self {
        let entries = (0..)
            .zip(triangles.iter().zip(flags))
            .filter(|(_, (triangle, flags))| is_traced(triangle, **flags))
            .map(|(triangle_id, (triangle, flags))| (triangle_id, *flags, *triangle))
            .collect();
        Self { entries }
    }

    /// Number of triangles.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Bytes of the list.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.entries.as_slice())
    }

    /// Passes every hit of `ray` to `visitor`.
    pub(crate) fn traverse(&self, ray: &Ray, visitor: &mut impl Visitor, counters: &mut TraversalCounters) {
        for (triangle_id, flags, triangle) in &self.entries {
            counters.triangles += 1;
            if let Some(hit) = triangle.intersect(ray)
                && visitor.accept(&Hit::of(hit, *triangle_id), *flags)
            {
                return;
            }
        }
    }
}
