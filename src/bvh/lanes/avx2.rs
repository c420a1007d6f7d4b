//! The kernels in AVX2: the same operations in the same order as the plain ones, eight lanes an instruction.

use std::arch::x86_64::{
    __m256, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_ps, _mm256_and_ps, _mm256_andnot_ps,
    _mm256_cmp_ps, _mm256_loadu_ps, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_set1_ps, _mm256_storeu_ps, _mm256_sub_ps,
};

use super::{
    EDGE_MARGIN, Entered, LARGEST_MARGIN, LATERAL_FLOOR, LaneRay, LaneTask, Lanes, SMALLEST_MARGIN,
    Triangles, WIDTH, WideNode,
};
use crate::bvh::TraversalCounters;

/// Exists in code that runs inside [`run_with_avx2`] only.
struct Avx2;

/// Runs `task` compiled for AVX2; the caller has found that the machine has it.
#[inline]
pub(super) fn run<T: LaneTask>(task: T, counters: &mut TraversalCounters) -> T::Output {
    debug_assert!(std::arch::is_x86_feature_detected!("avx2"));
    // SAFETY: `dispatch`, the only caller, has checked that the machine has AVX2.
    unsafe { run_with_avx2(task, counters) }
}

#[target_feature(enable = "avx2")]
fn run_with_avx2<T: LaneTask>(task: T, counters: &mut TraversalCounters) -> T::Output {
    task.run::<Avx2>(counters)
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn enter(node: &WideNode, ray: &LaneRay, upper: f32) -> Entered {
        // SAFETY: `Avx2` is private and named in `run_with_avx2` only, so the machine has AVX2.
        unsafe { enter(node, ray, upper) }
    }

    #[inline(always)]
    fn candidates(pack: &Triangles<'_>, ray: &LaneRay) -> u32 {
        // SAFETY: as above.
        unsafe { candidates(pack, ray) }
    }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load(lanes: &[f32; WIDTH]) -> __m256 {
    // SAFETY: the array has exactly the eight floats that are read, and the load needs no alignment.
    unsafe { _mm256_loadu_ps(lanes.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn slab(plane: &[f32; WIDTH], origin: f32, reciprocal: f32) -> __m256 {
    _mm256_mul_ps(_mm256_sub_ps(load(plane), _mm256_set1_ps(origin)), _mm256_set1_ps(reciprocal))
}

#[inline]
#[target_feature(enable = "avx2")]
fn enter(node: &WideNode, ray: &LaneRay, upper: f32) -> Entered {
    let near = |axis: usize| {
        slab(&node.planes[ray.near_plane(axis)], ray.near_origin[axis], ray.near_reciprocal[axis])
    };
    let far =
        |axis: usize| slab(&node.planes[ray.far_plane(axis)], ray.far_origin[axis], ray.far_reciprocal[axis]);
    let entry =
        _mm256_max_ps(_mm256_max_ps(near(0), near(1)), _mm256_max_ps(near(2), _mm256_set1_ps(ray.lower)));
    let exit = _mm256_min_ps(_mm256_min_ps(far(0), far(1)), _mm256_min_ps(far(2), _mm256_set1_ps(upper)));
    let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(entry, exit)) as u32;
    let mut distances = [0.0; WIDTH];
    // SAFETY: the array has exactly the eight floats that are written, and the store needs no alignment.
    unsafe { _mm256_storeu_ps(distances.as_mut_ptr(), entry) };
    Entered { mask, distances }
}

#[inline]
#[target_feature(enable = "avx2")]
fn absolute(x: __m256) -> __m256 {
    _mm256_andnot_ps(_mm256_set1_ps(-0.0), x)
}

#[inline]
#[target_feature(enable = "avx2")]
fn sheared(pack: &Triangles<'_>, ray: &LaneRay, corner: usize) -> [__m256; 3] {
    let relative =
        |axis: usize| _mm256_sub_ps(load(pack.lanes(corner, axis)), _mm256_set1_ps(ray.origin[axis]));
    let [kx, ky, kz] = ray.axes;
    let z = relative(kz);
    let x = _mm256_sub_ps(relative(kx), _mm256_mul_ps(_mm256_set1_ps(ray.shear[0]), z));
    let y = _mm256_sub_ps(relative(ky), _mm256_mul_ps(_mm256_set1_ps(ray.shear[1]), z));
    [x, y, z]
}

/// `a·b − c·d`.
#[inline]
#[target_feature(enable = "avx2")]
fn difference(a: __m256, b: __m256, c: __m256, d: __m256) -> __m256 {
    _mm256_sub_ps(_mm256_mul_ps(a, b), _mm256_mul_ps(c, d))
}

#[inline]
#[target_feature(enable = "avx2")]
fn candidates(pack: &Triangles<'_>, ray: &LaneRay) -> u32 {
    let [ax, ay, az] = sheared(pack, ray, 0);
    let [bx, by, bz] = sheared(pack, ray, 1);
    let [cx, cy, cz] = sheared(pack, ray, 2);
    let u = difference(cx, by, cy, bx);
    let v = difference(ax, cy, ay, cx);
    let w = difference(bx, ay, by, ax);

    let larger_size = |x: __m256, y: __m256| _mm256_max_ps(absolute(x), absolute(y));
    let lateral = _mm256_max_ps(_mm256_max_ps(larger_size(ax, ay), larger_size(bx, by)), larger_size(cx, cy));
    let depth = _mm256_add_ps(lateral, _mm256_max_ps(larger_size(az, bz), absolute(cz)));
    let floored = _mm256_add_ps(lateral, _mm256_mul_ps(depth, _mm256_set1_ps(LATERAL_FLOOR)));
    let margin = _mm256_add_ps(
        _mm256_mul_ps(floored, _mm256_mul_ps(depth, _mm256_set1_ps(EDGE_MARGIN))),
        _mm256_set1_ps(SMALLEST_MARGIN),
    );

    let lowest = _mm256_min_ps(_mm256_min_ps(u, v), w);
    let highest = _mm256_max_ps(_mm256_max_ps(u, v), w);
    let below = _mm256_cmp_ps::<_CMP_LT_OQ>(lowest, _mm256_sub_ps(_mm256_set1_ps(-0.0), margin));
    let above = _mm256_cmp_ps::<_CMP_GT_OQ>(highest, margin);
    let sure = _mm256_cmp_ps::<_CMP_LT_OQ>(margin, _mm256_set1_ps(LARGEST_MARGIN));
    let outside = _mm256_movemask_ps(_mm256_and_ps(_mm256_and_ps(below, above), sure)) as u32;
    !outside & ((1 << pack.count()) - 1)
}
