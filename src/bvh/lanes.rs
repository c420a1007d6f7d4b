//! Eight boxes or eight triangles at once: the only lane code of the room, in plain Rust and in AVX2.
//!
//! Kernels find candidates and err towards visiting; what a hit is, is decided by [`crate::geometry::ShearedRay`]. Both
//! levels do the same operations in the same order (no fused ones), so that they find the same candidates.
//!
//! # Boxes
//!
//! Source: the slab test with a widened far distance is Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. Here entry
//! distances are shortened and exit distances lengthened by [`SLACK`], more than twice the relative error of a
//! difference, a reciprocal, two products and the rounding of `t`; and the origin is moved outward by
//! [`BOX_PADDING`] of its largest coordinate, as the definition of a hit asks. The direction is scaled by a power
//! of two so that its largest component is in [1, 2), and its other components are not taken smaller than 2⁻³⁰:
//! within the scene this moves the ray by less than the padding, and no distance is 0·∞.
//!
//! # Triangles
//!
//! The edge functions of the definition in `f32`. With `u = 2⁻²⁴`, `M` the largest lateral coordinate after the shear
//! and `Z` a bound of all coordinates before it, a lateral coordinate is off by at most `8uZ` and an edge function
//! by at most `4·8uZ·M + 2·(8uZ)² + 4uM²`, where `M ≤ 2Z`. A triangle is passed over only if one edge function is below
//! and another above the margin `2⁻¹⁸·Z·(M + 2⁻²²·Z)`, which is larger by half; a tiny constant covers underflow, and
//! huge margins, where a product may have overflowed, pass nothing over.

use super::wide::{TrianglePack, WIDTH, WideNode};
use super::{SimdLevel, TraversalCounters};
use crate::geometry::{BOX_PADDING, Ray, dominant_axes};

/// Relative shortening of entry and lengthening of exit distances.
const SLACK: f32 = 1.0 / (1 << 20) as f32;
/// Smallest direction component, in units of the largest.
const SMALLEST_COMPONENT: f32 = 1.0 / (1 << 30) as f32;
/// Margin of edge functions, in units of `Z·M`.
const EDGE_MARGIN: f32 = 1.0 / (1 << 18) as f32;
/// `M` counts as at least this many `Z` in the margin.
const LATERAL_FLOOR: f32 = 1.0 / (1 << 22) as f32;
/// Margins above this pass nothing over.
const LARGEST_MARGIN: f32 = 1.0e30;
/// Added to margins for products that underflow.
const SMALLEST_MARGIN: f32 = 1.0e-37;

/// A ray as the kernels use it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneRay {
    /// Indices of the near planes in a node; the far plane of an axis is its other one.
    near: [usize; 3],
    far: [usize; 3],
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    near_reciprocal: [f32; 3],
    far_reciprocal: [f32; 3],
    /// Box distances are `t` times this.
    pub(super) scale: f32,
    /// Smallest box distance of interest.
    lower: f32,
    axes: [usize; 3],
    origin: [f32; 3],
    shear: [f32; 2],
}

/// Children of a node that a ray enters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entered {
    /// One bit a child.
    pub(super) mask: u32,
    /// Where, in units of [`LaneRay::scale`]; not negative.
    pub(super) distances: [f32; WIDTH],
}

/// The kernels of one instruction set.
pub(super) trait Lanes {
    /// Which children are entered at or before `upper`.
    fn enter(node: &WideNode, ray: &LaneRay, upper: f32) -> Entered;
    /// Which triangles of a pack may be hit, one bit each.
    fn candidates(pack: &TrianglePack, ray: &LaneRay) -> u32;
}

/// A computation that is compiled once a level; implementations are `#[inline(always)]`.
pub(super) trait LaneTask {
    /// What it returns.
    type Output;
    /// Runs it.
    fn run<L: Lanes>(self, counters: &mut TraversalCounters) -> Self::Output;
}

impl LaneRay {
    /// Prepares `ray`; box distances below `lower` (in `t`) are of no interest.
    pub(super) fn new(ray: &Ray, lower: f32) -> Self {
        let axes = dominant_axes(ray.direction);
        let largest = ray.direction[axes[2]].abs();
        // The power of two at or below the largest component, by its exponent bits, and its reciprocal.
        let exponent = (largest.to_bits() >> 23).clamp(1, 253);
        let scale = f32::from_bits(exponent << 23);
        let direction = ray.direction * f32::from_bits((254 - exponent) << 23);

        let padding = ray.origin.abs().max_element() * BOX_PADDING;
        let mut prepared = Self {
            near: [0; 3],
            far: [0; 3],
            near_origin: [0.0; 3],
            far_origin: [0.0; 3],
            near_reciprocal: [0.0; 3],
            far_reciprocal: [0.0; 3],
            scale,
            lower: if lower > 0.0 { lower * scale } else { 0.0 },
            axes,
            origin: ray.origin.to_array(),
            shear: [
                ray.direction[axes[0]] / ray.direction[axes[2]],
                ray.direction[axes[1]] / ray.direction[axes[2]],
            ],
        };
        for axis in 0..3 {
            let backward = direction[axis].is_sign_negative();
            let outward = if backward { -padding } else { padding };
            let component = if direction[axis].abs() >= SMALLEST_COMPONENT {
                direction[axis]
            } else {
                SMALLEST_COMPONENT.copysign(direction[axis])
            };
            prepared.near[axis] = if backward { 3 + axis } else { axis };
            prepared.far[axis] = if backward { axis } else { 3 + axis };
            prepared.near_origin[axis] = ray.origin[axis] + outward;
            prepared.far_origin[axis] = ray.origin[axis] - outward;
            prepared.near_reciprocal[axis] = (1.0 / component) * (1.0 - SLACK);
            prepared.far_reciprocal[axis] = (1.0 / component) * (1.0 + SLACK);
        }
        prepared
    }
}

/// Plain Rust.
pub(super) struct Scalar;

/// The larger one; `b` if either is not a number.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller one; `b` if either is not a number.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

impl Lanes for Scalar {
    #[inline(always)]
    fn enter(node: &WideNode, ray: &LaneRay, upper: f32) -> Entered {
        let mut distances = [0.0; WIDTH];
        let mut mask = 0;
        for (lane, distance) in distances.iter_mut().enumerate() {
            let near = |axis: usize| {
                (node.planes[ray.near[axis]][lane] - ray.near_origin[axis]) * ray.near_reciprocal[axis]
            };
            let far = |axis: usize| {
                (node.planes[ray.far[axis]][lane] - ray.far_origin[axis]) * ray.far_reciprocal[axis]
            };
            let entry = larger(larger(near(0), near(1)), larger(near(2), ray.lower));
            let exit = smaller(smaller(far(0), far(1)), smaller(far(2), upper));
            *distance = entry;
            mask |= u32::from(entry <= exit) << lane;
        }
        Entered { mask, distances }
    }

    #[inline(always)]
    fn candidates(pack: &TrianglePack, ray: &LaneRay) -> u32 {
        let [kx, ky, kz] = ray.axes;
        let mut mask = 0;
        for lane in 0..WIDTH {
            let corner = |i: usize| {
                let z = pack.corners[i][kz][lane] - ray.origin[kz];
                let x = (pack.corners[i][kx][lane] - ray.origin[kx]) - ray.shear[0] * z;
                let y = (pack.corners[i][ky][lane] - ray.origin[ky]) - ray.shear[1] * z;
                (x, y, z)
            };
            let (ax, ay, az) = corner(0);
            let (bx, by, bz) = corner(1);
            let (cx, cy, cz) = corner(2);
            let u = cx * by - cy * bx;
            let v = ax * cy - ay * cx;
            let w = bx * ay - by * ax;
            let lateral = larger(
                larger(larger(ax.abs(), ay.abs()), larger(bx.abs(), by.abs())),
                larger(cx.abs(), cy.abs()),
            );
            let depth = lateral + larger(larger(az.abs(), bz.abs()), cz.abs());
            let margin = (lateral + depth * LATERAL_FLOOR) * (depth * EDGE_MARGIN) + SMALLEST_MARGIN;
            let outside = smaller(smaller(u, v), w) < -margin
                && larger(larger(u, v), w) > margin
                && margin < LARGEST_MARGIN;
            mask |= u32::from(!outside) << lane;
        }
        mask & ((1 << pack.count) - 1)
    }
}

impl SimdLevel {
    /// The best level of the machine that runs.
    pub fn best() -> Self {
        if Self::Avx2.is_supported() {
            Self::Avx2
        } else {
            Self::Scalar
        }
    }

    /// Whether the machine that runs has this level; queries fall back to [`SimdLevel::Scalar`] where it has not.
    pub fn is_supported(self) -> bool {
        match self {
            Self::Scalar => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => std::arch::is_x86_feature_detected!("avx2"),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 => false,
        }
    }
}

/// Runs `task` with the kernels of `level`, or plain ones where the machine lacks it.
#[inline]
pub(super) fn dispatch<T: LaneTask>(
    level: SimdLevel,
    task: T,
    counters: &mut TraversalCounters,
) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    if level == SimdLevel::Avx2 && level.is_supported() {
        return avx2::run(task, counters);
    }
    let _ = level;
    task.run::<Scalar>(counters)
}

#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "AVX2 intrinsics and calls into code compiled for AVX2")]
mod avx2 {
    use std::arch::x86_64::{
        __m256, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_ps, _mm256_and_ps, _mm256_andnot_ps,
        _mm256_cmp_ps, _mm256_loadu_ps, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
        _mm256_set1_ps, _mm256_storeu_ps, _mm256_sub_ps,
    };

    use super::{
        EDGE_MARGIN, Entered, LARGEST_MARGIN, LATERAL_FLOOR, LaneRay, LaneTask, Lanes, SMALLEST_MARGIN,
        TrianglePack, WIDTH, WideNode,
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
        fn candidates(pack: &TrianglePack, ray: &LaneRay) -> u32 {
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
        _mm256_mul_ps(
            _mm256_sub_ps(load(plane), _mm256_set1_ps(origin)),
            _mm256_set1_ps(reciprocal),
        )
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn enter(node: &WideNode, ray: &LaneRay, upper: f32) -> Entered {
        let near = |axis: usize| {
            slab(
                &node.planes[ray.near[axis]],
                ray.near_origin[axis],
                ray.near_reciprocal[axis],
            )
        };
        let far = |axis: usize| {
            slab(
                &node.planes[ray.far[axis]],
                ray.far_origin[axis],
                ray.far_reciprocal[axis],
            )
        };
        let entry = _mm256_max_ps(
            _mm256_max_ps(near(0), near(1)),
            _mm256_max_ps(near(2), _mm256_set1_ps(ray.lower)),
        );
        let exit = _mm256_min_ps(
            _mm256_min_ps(far(0), far(1)),
            _mm256_min_ps(far(2), _mm256_set1_ps(upper)),
        );
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
    fn sheared(pack: &TrianglePack, ray: &LaneRay, corner: usize) -> [__m256; 3] {
        let relative = |axis: usize| {
            _mm256_sub_ps(
                load(&pack.corners[corner][axis]),
                _mm256_set1_ps(ray.origin[axis]),
            )
        };
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
    fn candidates(pack: &TrianglePack, ray: &LaneRay) -> u32 {
        let [ax, ay, az] = sheared(pack, ray, 0);
        let [bx, by, bz] = sheared(pack, ray, 1);
        let [cx, cy, cz] = sheared(pack, ray, 2);
        let u = difference(cx, by, cy, bx);
        let v = difference(ax, cy, ay, cx);
        let w = difference(bx, ay, by, ax);

        let larger_size = |x: __m256, y: __m256| _mm256_max_ps(absolute(x), absolute(y));
        let lateral = _mm256_max_ps(
            _mm256_max_ps(larger_size(ax, ay), larger_size(bx, by)),
            larger_size(cx, cy),
        );
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
        !outside & ((1 << pack.count) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::PrimitiveFlags;
    use crate::geometry::{Aabb, Triangle};
    use glam::Vec3;

    struct Random(u32);

    impl Random {
        fn signed(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(747796405).wrapping_add(2891336453);
            (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
        }

        fn point(&mut self) -> Vec3 {
            Vec3::new(self.signed(), self.signed(), self.signed())
        }
    }

    /// Both kernels of a level for one ray.
    struct Kernels<'a>(&'a WideNode, &'a TrianglePack, &'a LaneRay, f32);

    impl LaneTask for Kernels<'_> {
        type Output = (u32, [u32; WIDTH], u32);

        #[inline(always)]
        fn run<L: Lanes>(self, _: &mut TraversalCounters) -> Self::Output {
            let entered = L::enter(self.0, self.2, self.3);
            let candidates = L::candidates(self.1, self.2);
            (entered.mask, entered.distances.map(f32::to_bits), candidates)
        }
    }

    /// A pack of triangles of many shapes near `target`, and a node of their boxes.
    fn pack(random: &mut Random, target: Vec3, size: f32) -> (WideNode, TrianglePack, Vec<Triangle>) {
        let (mut node, mut pack) = (WideNode::EMPTY, TrianglePack::EMPTY);
        let triangles: Vec<Triangle> = (0..7)
            .map(|i| {
                let thin = [1.0, 1.0e-3, 1.0e-5, 0.0][i % 4];
                let (a, b) = (target + random.point() * size, target + random.point() * size);
                let c = (a + b) * 0.5 + random.point() * size * thin;
                Triangle { vertices: [a, b, c] }
            })
            .collect();
        for (lane, triangle) in triangles.iter().enumerate() {
            pack.add(lane as u32, triangle, PrimitiveFlags::default());
            let padding = triangle.magnitude() * BOX_PADDING + f32::MIN_POSITIVE;
            node.put(lane, lane as u32, &triangle.bounds().grown(padding));
        }
        (node, pack, triangles)
    }

    #[test]
    fn levels_agree_and_no_hit_is_passed_over() {
        let mut random = Random(1);
        let mut hits = 0;
        for i in 0..60_000 {
            let scale = [1.0, 1.0e3, 1.0e30, 1.0e-30, 1.0e-18, 1.0e19][i % 6];
            let size = [1.0, 1.0e-4, 100.0][i / 6 % 3];
            let target = random.point() * scale;
            let (node, pack, triangles) = pack(&mut random, target, size * scale.min(1.0e36));
            let corner = triangles[i % 7].vertices[i % 3];
            let aim = [corner, (triangles[i % 7].bounds()).center(), target][i / 18 % 3];
            let mut origin = random.point() * scale * [1.0, 10.0][i % 2];
            if i % 11 == 0 {
                origin.x = aim.x;
            }
            let mut direction = aim - origin;
            if i % 13 == 0 {
                direction /= direction.abs().max_element();
            }
            let ray = Ray::new(origin, direction);
            let lane_ray = LaneRay::new(&ray, ray.t_min);
            let upper = 2.0 * lane_ray.scale;
            let counters = &mut TraversalCounters::default();
            let scalar = dispatch(
                SimdLevel::Scalar,
                Kernels(&node, &pack, &lane_ray, upper),
                counters,
            );
            let best = dispatch(
                SimdLevel::best(),
                Kernels(&node, &pack, &lane_ray, upper),
                counters,
            );
            assert_eq!(scalar, best, "{ray:?}");
            assert_eq!(scalar.2 >> 7, 0, "empty lanes are no candidates");

            for (lane, triangle) in triangles.iter().enumerate() {
                let Some(hit) = triangle.intersect(&ray) else {
                    continue;
                };
                hits += 1;
                assert!(scalar.2 >> lane & 1 == 1, "{ray:?} passes over {triangle:?}");
                // The box is entered by the hit's distance, not later.
                let at_hit = Scalar::enter(&node, &lane_ray, hit.t * lane_ray.scale);
                assert!(
                    at_hit.mask >> lane & 1 == 1,
                    "{ray:?} misses the box of {triangle:?}"
                );
            }
        }
        assert!(hits > 60_000, "{hits}");
    }

    #[test]
    fn triangles_far_from_the_ray_are_passed_over() {
        let mut random = Random(2);
        let (_, pack, _) = pack(&mut random, Vec3::new(50.0, 0.0, 0.0), 1.0);
        let ray = LaneRay::new(&Ray::new(Vec3::new(0.0, 0.0, -10.0), Vec3::Z), 0.0);
        assert_eq!(Scalar::candidates(&pack, &ray), 0);
    }

    #[test]
    fn a_ray_in_a_face_of_a_box_enters_it() {
        // No component of these differences is anything but zero on the face: 0·∞ must not lose the box.
        let mut node = WideNode::EMPTY;
        let unit = Aabb {
            min: Vec3::ZERO,
            max: Vec3::ONE,
        };
        node.put(0, 0, &unit);
        for x in [0.0, -0.0, 0.5, 1.0] {
            for zero in [0.0, -0.0] {
                let ray = Ray::new(Vec3::new(x, 0.5, -1.0), Vec3::new(zero, zero, 1.0));
                let entered = Scalar::enter(&node, &LaneRay::new(&ray, 0.0), f32::INFINITY);
                assert_eq!(entered.mask, 1);
                assert!((entered.distances[0] - 1.0).abs() < 1.0e-5);
            }
        }
        let beside = Ray::new(Vec3::new(1.1, 0.5, -1.0), Vec3::Z);
        assert_eq!(
            Scalar::enter(&node, &LaneRay::new(&beside, 0.0), f32::INFINITY).mask,
            0
        );
    }
}
