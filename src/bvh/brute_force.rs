//! The slow twin of every hierarchy: each ray tests each triangle by the definition of a hit.

use super::query::Visitor;
use super::references::is_traced;
use super::{Hit, PrimitiveFlags, TraversalCounters};
use crate::geometry::{Ray, Triangle};

/// All triangles that take part, with their ids.
#[derive(Debug, Default)]
pub(super) struct TriangleList {
    entries: Vec<(u32, PrimitiveFlags, Triangle)>,
}

impl TriangleList {
    /// Lists the triangles that take part.
    pub(super) fn new(triangles: &[Triangle], flags: &[PrimitiveFlags]) -> Self {
        let entries = (0..)
            .zip(triangles.iter().zip(flags))
            .filter(|(_, (triangle, flags))| is_traced(triangle, **flags))
            .map(|(primitive, (triangle, flags))| (primitive, *flags, *triangle))
            .collect();
        Self { entries }
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Bytes of the list.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.entries.as_slice())
    }

    /// Gives every hit of `ray` to `visitor`.
    pub(super) fn walk(&self, ray: &Ray, visitor: &mut impl Visitor, counters: &mut TraversalCounters) {
        for (primitive, flags, triangle) in &self.entries {
            counters.triangles += 1;
            if let Some(hit) = triangle.intersect(ray)
                && visitor.offer(&Hit::of(hit, *primitive), *flags)
            {
                return;
            }
        }
    }
}
