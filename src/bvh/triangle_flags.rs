//! Flags of a triangle that traversal needs besides its corners.

use crate::geometry::Triangle;

/// Set of flags of one triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(transparent)]
pub struct TriangleFlags(pub u8);

impl TriangleFlags {
    /// The back face is invisible to [`crate::bvh::Bvh::closest_hit`]; the other queries see it.
    pub const SINGLE_SIDED: Self = Self(1);
    /// A hit counts only where the filter of the query accepts it, whatever the query.
    pub const FILTERED: Self = Self(2);
    /// The triangle is left out of the hierarchy (hidden, or of zero area); its index stays taken.
    pub const HIDDEN: Self = Self(4);
    /// Lets light through: the queries that see either side ask their filters, and [`crate::bvh::Bvh::closest_hit`] does not because
    /// of this flag.
    pub const TRANSMISSIVE: Self = Self(8);

    /// Union of both sets.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether queries that see either side ask their filters.
    pub(super) const fn is_filtered_from_any_side(self) -> bool {
        self.0 & (Self::FILTERED.0 | Self::TRANSMISSIVE.0) != 0
    }

    /// Whether all flags of `other` are set.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// Whether a triangle is traced: it is not hidden and not degenerate.
#[inline(always)]
pub(crate) fn is_traced(triangle: &Triangle, flags: TriangleFlags) -> bool {
    !flags.has(TriangleFlags::HIDDEN) && !triangle.is_degenerate()
}
