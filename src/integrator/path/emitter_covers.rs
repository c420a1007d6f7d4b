//! What covers emissive triangles: others with the same corners, in any order, which rays hit first.
//!
//! Distances to such triangles are equal, but for the rounding of very few rays, and of equal distances the lowest index wins, whichever side a ray comes from. Triangles that coincide
//! without having the same corners are not found.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use crate::bvh::{Hit, TriangleFlags};
use crate::geometry::{Aabb, Facing};
use crate::integrator::TRANSPARENCY_LIMIT;
use crate::interaction::alpha_at;
use crate::scene_view::SceneView;

/// Bits of a filter for each set of corners in it.
const BITS_A_SET: usize = 16;
/// An odd number of random bits.
const MIX: u64 = 0x9E6C_63D0_876A_68DD;

/// The bits of three corners, ascending.
type CornerSet = [[u32; 3]; 3];

/// One of the triangles with the same corners. They are ordered by corners, then by triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct CoincidentTriangle {
    corners: CornerSet,
    triangle: u32,
    is_lit: bool,
}

/// What covers emissive triangles in part: from one side, or where it is not transparent.
#[derive(Clone, Debug, Default)]
pub(super) struct EmitterCovers {
    /// Those of one set of corners after those of another, ascending.
    covers: Vec<u32>,
    /// Emissive triangles, ascending, each with its covers.
    covered: Vec<(u32, Range<u32>)>,
}

impl EmitterCovers {
    /// The covers of emissive triangles, and those of the triangles that no ray hits, ascending. `lit` is ascending.
    pub(super) fn new(view: SceneView<'_>, lit: &[u32]) -> (Self, Vec<u32>) {
        let copy = |&triangle: &u32| CoincidentTriangle {
            corners: corner_set(corners(view, triangle)),
            triangle,
            is_lit: true,
        };
        let mut copies: Vec<CoincidentTriangle> = lit.par_iter().map(copy).collect();
        copies.par_sort_unstable();
        let unlit = unlit_copies(view, lit, &copies);
        if !unlit.is_empty() {
            copies.extend(unlit);
            copies.par_sort_unstable();
        }
        let mut covers = Self::default();
        let mut hidden = Vec::new();
        for of_one_set in copies.chunk_by(|a, b| a.corners == b.corners).filter(|copies| copies.len() > 1) {
            covers.add(view, of_one_set, &mut hidden);
        }
        covers.covered.sort_unstable_by_key(|(triangle, _)| *triangle);
        hidden.sort_unstable();
        (covers, hidden)
    }

    /// Adds triangles with the same corners, and the emissive ones that no ray hits to `hidden`.
    fn add(&mut self, view: SceneView<'_>, copies: &[CoincidentTriangle], hidden: &mut Vec<u32>) {
        let (first_cover, known) = (self.covers.len(), self.covered.len());
        let first_corners = corners(view, copies[0].triangle);
        let mut transparent = 0;
        // The front of the first triangle, and its back
        let mut is_hidden = [false; 2];
        for &CoincidentTriangle { triangle, is_lit, .. } in copies {
            let flags = view.frame.flags[triangle as usize];
            let is_turned = is_turned(first_corners, corners(view, triangle));
            let seen =
                if flags.has(TriangleFlags::SINGLE_SIDED) { [!is_turned, is_turned] } else { [true; 2] };
            if transparent == TRANSPARENCY_LIMIT || (0..2).all(|side| is_hidden[side] || !seen[side]) {
                if is_lit {
                    hidden.push(triangle);
                }
                continue;
            }
            let covers = first_cover as u32..self.covers.len() as u32;
            if is_lit && !covers.is_empty() {
                self.covered.push((triangle, covers));
            }
            if !hides_what_it_covers(view, triangle) {
                continue;
            }
            self.covers.push(triangle);
            if flags.has(TriangleFlags::FILTERED) {
                transparent += 1;
            } else {
                is_hidden = [0, 1].map(|side| is_hidden[side] || seen[side]);
            }
        }
        if self.covered.len() == known {
            self.covers.truncate(first_cover);
        }
    }

    /// The share of the emission of a hit that its covers let pass.
    pub(super) fn uncovered_share(&self, view: SceneView<'_>, hit: &Hit) -> f32 {
        let Ok(index) = self.covered.binary_search_by_key(&hit.triangle, |(triangle, _)| *triangle) else {
            return 1.0;
        };
        let Range { start, end } = self.covered[index].1;
        let covers = &self.covers[start as usize..end as usize];
        covers.iter().map(|&cover| 1.0 - coverage(view, hit, cover)).product()
    }
}

/// How much of a hit its cover `triangle` hides.
fn coverage(view: SceneView<'_>, hit: &Hit, triangle: u32) -> f32 {
    let [own, others] = [hit.triangle, triangle].map(|triangle| corners(view, triangle));
    let is_front = (hit.facing == Facing::Front) != is_turned(own, others);
    if !is_front && view.frame.flags[triangle as usize].has(TriangleFlags::SINGLE_SIDED) {
        return 0.0;
    }
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    let weight =
        |corner: Vec3| own.iter().position(|&other| other == corner).map_or(0.0, |index| weights[index]);
    let facing = if is_front { Facing::Front } else { Facing::Back };
    alpha_at(view, &Hit { t: hit.t, triangle, u: weight(others[1]), v: weight(others[2]), facing })
}

/// Whether rays see a triangle and not those with the same corners that come after it: it is no catcher, and neither glass nor paper that gives
/// way to what shines.
fn hides_what_it_covers(view: SceneView<'_>, triangle: u32) -> bool {
    let material = &view.frame.materials[view.frame.instance(triangle).material.index()];
    let is_paper = material.diffuse_transmission.is_some_and(|paper| paper.factor > 0.0) && !material.unlit;
    let gives_way = material.transmits() || (is_paper && material.emissive == Vec3::ZERO);
    let is_hidden = view.frame.flags[triangle as usize].has(TriangleFlags::HIDDEN);
    !is_hidden && !gives_way && !material.is_shadow_catcher
}

/// The triangles that have the corners of a later one of `lit`, and are none of these. `lit` is ascending, and `copies` are the same, sorted.
fn unlit_copies(view: SceneView<'_>, lit: &[u32], copies: &[CoincidentTriangle]) -> Vec<CoincidentTriangle> {
    let Some(&last) = lit.last() else { return Vec::new() };
    let box_of = |&triangle: &u32| Aabb::from_points(&corners(view, triangle));
    let bounds = lit.par_iter().map(box_of).reduce(|| Aabb::EMPTY, Aabb::union);
    let filter = CornerFilter::new(lit.iter().map(|&triangle| corners(view, triangle)), lit.len());
    let unlit = (0..last).into_par_iter().filter_map(|triangle| {
        let corners = corners(view, triangle);
        // One corner tells most others apart.
        let is_outside = corners[0].cmplt(bounds.min) | corners[0].cmpgt(bounds.max);
        if is_outside.any() || !filter.may_have(corners) || lit.binary_search(&triangle).is_ok() {
            return None;
        }
        if !hides_what_it_covers(view, triangle) {
            return None;
        }
        let copy = CoincidentTriangle { corners: corner_set(corners), triangle, is_lit: false };
        let next = copies.partition_point(|lit| (lit.corners, lit.triangle) < (copy.corners, triangle));
        copies.get(next).is_some_and(|lit| lit.corners == copy.corners).then_some(copy)
    });
    unlit.collect()
}

/// A set of corner sets that may also seem to have others.
struct CornerFilter {
    words: Vec<u64>,
}

impl CornerFilter {
    fn new(triangles: impl Iterator<Item = [Vec3; 3]>, count: usize) -> Self {
        let words = (count * BITS_A_SET / 64).next_power_of_two();
        let mut filter = Self { words: vec![0; words] };
        for corners in triangles {
            let (word, bit) = filter.bit_of(corners);
            filter.words[word] |= bit;
        }
        filter
    }

    fn may_have(&self, corners: [Vec3; 3]) -> bool {
        let (word, bit) = self.bit_of(corners);
        self.words[word] & bit != 0
    }

    /// The word and the bit of corners in any order.
    fn bit_of(&self, corners: [Vec3; 3]) -> (usize, u64) {
        let mixed = |corner: Vec3| {
            let [x, y, z] = bits(corner).map(u64::from);
            let product = (x ^ y << 16 ^ z << 32).wrapping_mul(MIX);
            product ^ product >> 29
        };
        let sum = corners.into_iter().map(mixed).fold(0, u64::wrapping_add).wrapping_mul(MIX) >> 16;
        let word = (sum >> 6) as usize & (self.words.len() - 1);
        (word, 1 << (sum & 63))
    }
}

fn corners(view: SceneView<'_>, triangle: u32) -> [Vec3; 3] {
    view.frame.triangles[triangle as usize].vertices
}

/// Bits that are the same for both zeros.
fn bits(corner: Vec3) -> [u32; 3] {
    (corner + Vec3::ZERO).to_array().map(f32::to_bits)
}

fn corner_set(corners: [Vec3; 3]) -> CornerSet {
    let mut set = corners.map(bits);
    set.sort_unstable();
    set
}

/// Whether triangles with the same corners face opposite sides.
fn is_turned(corners: [Vec3; 3], others: [Vec3; 3]) -> bool {
    let first = others.iter().position(|&other| other == corners[0]).unwrap_or(0);
    others[(first + 1) % 3] != corners[1]
}
