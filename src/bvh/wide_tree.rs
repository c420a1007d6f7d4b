//! The tree that rays walk: eight children a node, up to eight triangles a leaf.
//!
//! # Layout
//!
//! A node is 224 bytes: six rows of eight `f32`, the planes min x, y, z, max x, y, z of its children's boxes, and a row of
//! eight child words. A child that is not there has the word [`NO_CHILD`] and a box that no ray enters. A clear top bit
//! is the index of a node. A set top bit is a [`Leaf`]: three bits hold the number of its triangles less one, the other 28
//! the place of the first.
//!
//! A place takes 40 bytes, ten words. The `n` triangles of a leaf that starts at place `p` fill words `10 p` to
//! `10 p + 10 n`, component by component: `n` words for each of a.x, a.y, a.z, b.x, …, c.z, and `n` tags ([`Tag`]). So
//! leaves of any size have no gaps, and one load takes a component of all their triangles. A leaf is read as a block of
//! the largest size and a load of eight, whose end is into what follows; as many spare words end the array.

use super::triangle_flags::TriangleFlags;
use crate::geometry::Aabb;
use glam::Vec3;

/// Children a node, and most triangles a leaf.
pub(super) const WIDTH: usize = 8;
/// A child that is not there; its box is entered by no ray.
pub(super) const NO_CHILD: u32 = u32::MAX;
/// Most triangles, and references, that the words of nodes and leaves can number.
pub const MAX_TRIANGLES: usize = (1 << POSITION_BITS) - WIDTH;
/// Words of a place in the leaves.
pub(super) const WORDS_PER_SLOT: usize = 10;
/// Words from the first of a leaf on that may be read, whatever its size; so many spare ones end the array.
pub(super) const BLOCK: usize = WORDS_PER_SLOT * WIDTH + WIDTH;

/// Set in child words of leaves.
const LEAF: u32 = 1 << 31;
const POSITION_BITS: u32 = 28;
const POSITION_MASK: u32 = (1 << POSITION_BITS) - 1;
/// Set in all tags, so that they are no denormal numbers where they are read beyond a leaf.
const TAG: u32 = 1 << 30;

/// Boxes of up to eight children, by plane: min x, y, z, max x, y, z.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct WideNode {
    /// The planes of all children.
    pub(super) planes: [[f32; WIDTH]; 6],
    /// Index of a node, the word of a [`Leaf`], or [`NO_CHILD`].
    pub(super) children: [u32; WIDTH],
}

/// The child word of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Leaf(u32);

/// Id and flags of a triangle in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tag(u32);

/// The triangles of a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangles<'a> {
    /// From the first word of the leaf on. Its size is known to the compiler, and subscripts are made so that it sees them
    /// in range: no read needs a check.
    block: &'a [f32; BLOCK],
    count: usize,
}

/// The wide tree.
#[derive(Debug)]
pub(super) struct WideTree {
    /// Child word of the root.
    pub(super) root: u32,
    /// Inner nodes; children come after their parents.
    pub(super) nodes: Vec<WideNode>,
    /// The words of all leaves and [`BLOCK`] spare ones.
    pub(super) words: Vec<f32>,
}

impl Default for WideTree {
    fn default() -> Self {
        Self { root: NO_CHILD, nodes: Vec::new(), words: vec![0.0; BLOCK] }
    }
}

impl WideTree {
    /// The triangles of a leaf.
    #[inline(always)]
    pub(super) fn triangles(&self, leaf: Leaf) -> Triangles<'_> {
        const NONE: &[f32; BLOCK] = &[0.0; BLOCK];
        let words = self.words.get(WORDS_PER_SLOT * leaf.first()..).and_then(<[f32]>::first_chunk);
        Triangles { block: words.unwrap_or(NONE), count: leaf.count() }
    }

    /// How many places the leaves have.
    pub(super) fn places(&self) -> usize {
        (self.words.len() - BLOCK) / WORDS_PER_SLOT
    }

    /// Bytes of the arrays.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.words.as_slice())
    }
}

impl Leaf {
    /// The leaf of the `count` places from `first` on.
    pub(super) fn new(first: usize, count: usize) -> Self {
        debug_assert!((1..=WIDTH).contains(&count) && first <= MAX_TRIANGLES);
        Self(LEAF | ((count - 1) as u32) << POSITION_BITS | first as u32)
    }

    /// The leaf of a child word, unless it is a node's. The word is not [`NO_CHILD`].
    #[inline(always)]
    pub(super) fn of(child: u32) -> Option<Self> {
        (child & LEAF != 0).then_some(Self(child))
    }

    /// The child word.
    pub(super) fn word(self) -> u32 {
        self.0
    }

    /// Its first place.
    #[inline(always)]
    pub(super) fn first(self) -> usize {
        (self.0 & POSITION_MASK) as usize
    }

    /// How many triangles it has, 1 to [`WIDTH`].
    #[inline(always)]
    pub(super) fn count(self) -> usize {
        (self.0 >> POSITION_BITS & 7) as usize + 1
    }
}

impl Tag {
    /// Packs an id below 2²⁸ with its flags.
    pub(super) fn new(triangle_id: u32, flags: TriangleFlags) -> Self {
        debug_assert!(triangle_id <= POSITION_MASK);
        let kept = u32::from(flags.0 & (TriangleFlags::SINGLE_SIDED.0 | TriangleFlags::FILTERED.0));
        Self(TAG | kept << POSITION_BITS | triangle_id)
    }

    /// The tag that stands as this word of a leaf.
    #[inline(always)]
    pub(super) fn of(word: f32) -> Self {
        Self(word.to_bits())
    }

    /// The tag as it stands among the words of a leaf.
    pub(super) fn word(self) -> f32 {
        f32::from_bits(self.0)
    }

    /// Index of the triangle.
    #[inline(always)]
    pub(super) fn triangle(self) -> u32 {
        self.0 & POSITION_MASK
    }

    /// Flags of the triangle that rays ask for.
    #[inline(always)]
    pub(super) fn flags(self) -> TriangleFlags {
        TriangleFlags((self.0 >> POSITION_BITS) as u8 & 3)
    }
}

impl<'a> Triangles<'a> {
    /// How many there are.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// One axis of one corner of all triangles; lanes beyond the last hold anything.
    #[inline(always)]
    pub(super) fn lanes(&self, corner: usize, axis: usize) -> &'a [f32; WIDTH] {
        const NONE: &[f32; WIDTH] = &[0.0; WIDTH];
        let start = (3 * corner + (axis & 3)) * self.count;
        self.block[start..].first_chunk().unwrap_or(NONE)
    }

    /// A number of one triangle.
    #[inline(always)]
    fn component(&self, corner: usize, axis: usize, lane: usize) -> f32 {
        self.block[(3 * corner + (axis & 3)) * self.count + (lane & (WIDTH - 1))]
    }

    /// The corners of a triangle.
    #[inline(always)]
    pub(super) fn corners(&self, lane: usize) -> [Vec3; 3] {
        let [a, b, c] = self.corners_in_order(lane, [0, 1, 2]);
        [Vec3::from_array(a), Vec3::from_array(b), Vec3::from_array(c)]
    }

    /// The corners of a triangle, their coordinates in the order of `axes`.
    #[inline(always)]
    pub(super) fn corners_in_order(&self, lane: usize, axes: [usize; 3]) -> [[f32; 3]; 3] {
        [self.corner(0, lane, axes), self.corner(1, lane, axes), self.corner(2, lane, axes)]
    }

    #[inline(always)]
    fn corner(&self, corner: usize, lane: usize, [x, y, z]: [usize; 3]) -> [f32; 3] {
        [self.component(corner, x, lane), self.component(corner, y, lane), self.component(corner, z, lane)]
    }

    /// Id and flags of a triangle.
    #[inline(always)]
    pub(super) fn tag(&self, lane: usize) -> Tag {
        Tag::of(self.component(3, 0, lane))
    }
}

/// Writes triangles, in order, to the words of their leaf, of which there are [`WORDS_PER_SLOT`] a triangle.
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

/// Writes `N` triangles; their number is known to the compiler, so that no subscript needs a check.
#[inline(always)]
fn write_rows<const N: usize>(words: &mut [f32], triangles: impl Iterator<Item = ([Vec3; 3], Tag)>) {
    let Some(rows) = words.as_chunks_mut::<N>().0.first_chunk_mut::<WORDS_PER_SLOT>() else { return };
    for (lane, ([a, b, c], tag)) in (0..N).zip(triangles) {
        let values = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, tag.word()];
        for (row, value) in rows.iter_mut().zip(values) {
            row[lane] = value;
        }
    }
}

impl WideNode {
    /// No children.
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

    /// Sets a child and its box.
    pub(super) fn put(&mut self, lane: usize, child: u32, bounds: &Aabb) {
        self.children[lane] = child;
        for axis in 0..3 {
            self.planes[axis][lane] = bounds.min[axis];
            self.planes[3 + axis][lane] = bounds.max[axis];
        }
    }

    /// The box of a child.
    pub(super) fn bounds(&self, lane: usize) -> Aabb {
        let [x0, y0, z0, x1, y1, z1] = self.planes.map(|plane| plane[lane]);
        Aabb { min: Vec3::new(x0, y0, z0), max: Vec3::new(x1, y1, z1) }
    }
}
