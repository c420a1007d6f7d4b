//! Wide tree that rays traverse: eight children per node, up to eight triangles per leaf.
//!
//! # Layout
//!
//! A node is 224 bytes: six rows of eight `f32`, the planes min x, y, z, max x, y, z of its children's boxes, and a row of
//! eight child words. An unused child has the word [`NO_CHILD`] and a box that no ray enters. A word with a clear top bit is
//! the index of a node. A word with a set top bit is a [`Leaf`]: three bits hold the number of its triangles less one, the
//! other 28 its first slot.
//!
//! A slot takes 40 bytes, ten words. The `n` triangles of a leaf whose first slot is `p` fill words `10 p` to
//! `10 p + 10 n`, component by component: `n` words for each of a.x, a.y, a.z, b.x, …, c.z, and `n` tags ([`Tag`]). Leaves of
//! any size therefore have no gaps, and one load reads a component of all their triangles. A leaf is read as a block of
//! [`BLOCK`] words, which may extend into the next leaves; as many unused words end the array.

use super::triangle_flags::TriangleFlags;
use crate::geometry::Aabb;
use glam::Vec3;

/// Children per node, and maximum of triangles per leaf.
pub(super) const WIDTH: usize = 8;
/// Word of an unused child.
pub(super) const NO_CHILD: u32 = u32::MAX;
/// Maximum of triangles, and of references, that a hierarchy can hold.
pub const MAX_TRIANGLES: usize = (1 << SLOT_BITS) - WIDTH;
/// Words of a leaf slot.
pub(super) const WORDS_PER_SLOT: usize = 10;
/// Words that a read of a leaf may touch, whatever its size; as many unused ones end the array.
pub(super) const BLOCK: usize = WORDS_PER_SLOT * WIDTH + WIDTH;

/// Bit that marks child words of leaves.
const LEAF: u32 = 1 << 31;
const SLOT_BITS: u32 = 28;
const SLOT_MASK: u32 = (1 << SLOT_BITS) - 1;
/// Bit set in all tags, so that tags read as coordinates beyond a leaf are not denormal numbers.
const TAG: u32 = 1 << 30;
/// Flags of a triangle that its tag keeps, in the other bits beyond the index.
const TAG_FLAGS: u8 =
    TriangleFlags::SINGLE_SIDED.with(TriangleFlags::FILTERED).with(TriangleFlags::TRANSMISSIVE).0;

/// Inner node: boxes of up to eight children, by plane (min x, y, z, max x, y, z), and their words.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct WideNode {
    /// Planes of all children.
    pub(super) planes: [[f32; WIDTH]; 6],
    /// Index of a node, word of a [`Leaf`], or [`NO_CHILD`].
    pub(super) children: [u32; WIDTH],
}

/// Child word of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Leaf(u32);

/// Index and flags of a triangle in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tag(u32);

/// View of the triangles of a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangles<'a> {
    /// Words from the first of the leaf on. The compiler knows the size and sees that all indices are in range, so reads
    /// need no checks.
    block: &'a [f32; BLOCK],
    count: usize,
}

/// Wide tree of one frame.
#[derive(Debug)]
pub(super) struct WideTree {
    /// Child word of the root.
    pub(super) root: u32,
    /// Inner nodes; children follow their parents.
    pub(super) nodes: Vec<WideNode>,
    /// Words of all leaves, and [`BLOCK`] unused ones.
    pub(super) words: Vec<f32>,
}

impl Default for WideTree {
    fn default() -> Self {
        Self { root: NO_CHILD, nodes: Vec::new(), words: vec![0.0; BLOCK] }
    }
}

impl WideTree {
    /// Triangles of a leaf.
    #[inline(always)]
    pub(super) fn triangles(&self, leaf: Leaf) -> Triangles<'_> {
        const NONE: &[f32; BLOCK] = &[0.0; BLOCK];
        let words = self.words.get(WORDS_PER_SLOT * leaf.first()..).and_then(<[f32]>::first_chunk);
        Triangles { block: words.unwrap_or(NONE), count: leaf.count() }
    }

    /// Number of leaf slots.
    pub(super) fn slots(&self) -> usize {
        (self.words.len() - BLOCK) / WORDS_PER_SLOT
    }

    /// Bytes of nodes and leaves.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.words.as_slice())
    }
}

impl Leaf {
    /// Leaf of `count` slots from `first` on.
    pub(super) fn new(first: usize, count: usize) -> Self {
        debug_assert!((1..=WIDTH).contains(&count) && first <= MAX_TRIANGLES);
        Self(LEAF | ((count - 1) as u32) << SLOT_BITS | first as u32)
    }

    /// Leaf of a child word; `None` for a node. The word is not [`NO_CHILD`].
    #[inline(always)]
    pub(super) fn of(child: u32) -> Option<Self> {
        (child & LEAF != 0).then_some(Self(child))
    }

    /// Child word.
    pub(super) fn word(self) -> u32 {
        self.0
    }

    /// First slot.
    #[inline(always)]
    pub(super) fn first(self) -> usize {
        (self.0 & SLOT_MASK) as usize
    }

    /// Number of triangles, 1 to [`WIDTH`].
    #[inline(always)]
    pub(super) fn count(self) -> usize {
        (self.0 >> SLOT_BITS & 7) as usize + 1
    }
}

impl Tag {
    /// Packs a triangle index below 2²⁸ with its flags.
    pub(super) fn new(triangle_id: u32, flags: TriangleFlags) -> Self {
        debug_assert!(triangle_id <= SLOT_MASK);
        Self(TAG | u32::from(flags.0 & TAG_FLAGS) << SLOT_BITS | triangle_id)
    }

    /// Tag stored in this word of a leaf.
    #[inline(always)]
    pub(super) fn of(word: f32) -> Self {
        Self(word.to_bits())
    }

    /// Word of a leaf that stores the tag.
    pub(super) fn word(self) -> f32 {
        f32::from_bits(self.0)
    }

    /// Index of the triangle.
    #[inline(always)]
    pub(super) fn triangle(self) -> u32 {
        self.0 & SLOT_MASK
    }

    /// Flags of the triangle that traversal reads.
    #[inline(always)]
    pub(super) fn flags(self) -> TriangleFlags {
        TriangleFlags((self.0 >> SLOT_BITS) as u8 & TAG_FLAGS)
    }
}

impl<'a> Triangles<'a> {
    /// Number of triangles.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// One coordinate of one corner of all triangles; lanes beyond the last are unspecified.
    #[inline(always)]
    pub(super) fn lanes(&self, corner: usize, axis: usize) -> &'a [f32; WIDTH] {
        const NONE: &[f32; WIDTH] = &[0.0; WIDTH];
        let start = (3 * corner + (axis & 3)) * self.count;
        self.block[start..].first_chunk().unwrap_or(NONE)
    }

    /// One number of one triangle.
    #[inline(always)]
    fn component(&self, corner: usize, axis: usize, lane: usize) -> f32 {
        self.block[(3 * corner + (axis & 3)) * self.count + (lane & (WIDTH - 1))]
    }

    /// Corners of a triangle.
    #[inline(always)]
    pub(super) fn corners(&self, lane: usize) -> [Vec3; 3] {
        let [a, b, c] = self.corners_in_order(lane, [0, 1, 2]);
        [Vec3::from_array(a), Vec3::from_array(b), Vec3::from_array(c)]
    }

    /// Corners of a triangle, coordinates in the order of `axes`.
    #[inline(always)]
    pub(super) fn corners_in_order(&self, lane: usize, axes: [usize; 3]) -> [[f32; 3]; 3] {
        [self.corner(0, lane, axes), self.corner(1, lane, axes), self.corner(2, lane, axes)]
    }

    #[inline(always)]
    fn corner(&self, corner: usize, lane: usize, [x, y, z]: [usize; 3]) -> [f32; 3] {
        [self.component(corner, x, lane), self.component(corner, y, lane), self.component(corner, z, lane)]
    }

    /// Index and flags of a triangle.
    #[inline(always)]
    pub(super) fn tag(&self, lane: usize) -> Tag {
        Tag::of(self.component(3, 0, lane))
    }
}

/// Writes the triangles of a leaf to its words, [`WORDS_PER_SLOT`] per triangle.
#[inline(always)]
pub(super) fn write_leaf(words: &mut [f32], triangles: impl ExactSizeIterator<Item = ([Vec3; 3], Tag)>) {
    debug_assert_eq!(words.len(), triangles.len() * WORDS_PER_SLOT);
    match triangles.len() {
        1 => write_rows::<1>(words, triangles),
        2 => write_rows::<2>(words, triangles),
        3 => write_rows::<3>(words, triangles),
        4 => write_rows::<4>(words, triangles),
        5 => write_rows::<5>(words, triangles),
        6 => write_rows::<6>(words, triangles),
        7 => write_rows::<7>(words, triangles),
        _ => write_rows::<8>(words, triangles),
    }
}

/// Writes `N` triangles. The compiler knows their number, so indices need no checks.
#[inline(always)]
fn write_rows<const N: usize>(words: &mut [f32], triangles: impl Iterator<Item = ([Vec3; 3], Tag)>) {
    let Some(rows) = words.as_chunks_mut::<N>().0.first_chunk_mut::<WORDS_PER_SLOT>() else { return };
    for (lane, (corners, tag)) in (0..N).zip(triangles) {
        for (row, value) in rows.iter_mut().zip(slot_words(corners, tag)) {
            row[lane] = value;
        }
    }
}

/// Words of a triangle, in the order of the components of a leaf.
#[inline(always)]
pub(super) fn slot_words([a, b, c]: [Vec3; 3], tag: Tag) -> [f32; WORDS_PER_SLOT] {
    [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, tag.word()]
}

impl WideNode {
    /// Node without children.
    pub(super) const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [NO_CHILD; WIDTH],
    };

    /// Sets a child word and its box.
    pub(super) fn put(&mut self, lane: usize, child: u32, bounds: &Aabb) {
        self.children[lane] = child;
        for axis in 0..3 {
            self.planes[axis][lane] = bounds.min[axis];
            self.planes[3 + axis][lane] = bounds.max[axis];
        }
    }

    /// Box of a child.
    pub(super) fn bounds(&self, lane: usize) -> Aabb {
        let [x0, y0, z0, x1, y1, z1] = self.planes.map(|plane| plane[lane]);
        Aabb { min: Vec3::new(x0, y0, z0), max: Vec3::new(x1, y1, z1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_keep_indices_and_all_flags_of_traversal() {
        let all = TriangleFlags::SINGLE_SIDED
            .with(TriangleFlags::FILTERED)
            .with(TriangleFlags::TRANSMISSIVE)
            .with(TriangleFlags::HIDDEN);
        for triangle in [0, 1, SLOT_MASK] {
            for bits in 0..=all.0 {
                let tag = Tag::of(Tag::new(triangle, TriangleFlags(bits)).word());
                assert_eq!(tag.triangle(), triangle);
                assert_eq!(tag.flags(), TriangleFlags(bits & !TriangleFlags::HIDDEN.0));
                assert!(!tag.word().is_subnormal());
            }
        }
    }
}
