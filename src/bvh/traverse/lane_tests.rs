//! Tests of the lane kernels: all SIMD levels against each other and against the definition of a hit.

use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;

use super::lane_ray::{Entered, LaneRay, is_extreme};
use super::visitor::positive_lower;
use crate::bvh::simd::dispatch_lanes;
use crate::bvh::wide_tree::{BLOCK, Leaf, Tag, WIDTH, WORDS_PER_SLOT, WideNode, WideTree, write_leaf};
use crate::bvh::{SimdLevel, TriangleFlags};
use crate::geometry::{Aabb, BOX_PADDING, Ray, Triangle, rounded_down, rounded_up};

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

/// Results of the triangle kernel for one ray: possible and certain triangles, back sides and bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
struct KernelResults {
    possible: u32,
    certain: u32,
    back: u32,
    near: [f32; WIDTH],
    far: [f32; WIDTH],
}

#[inline(always)]
fn triangle_kernel<S: Simd>(simd: S, tree: &WideTree, ray: &Ray) -> KernelResults {
    let lane_ray = LaneRay::<true>::new(ray, ray.t_min);
    let edges = lane_ray.edge_functions(simd, &tree.triangles(Leaf::new(0, COUNT)));
    let lanes = (1 << COUNT) - 1;
    let bounds = edges.distance_bounds(simd, f32x8::splat(simd, lane_ray.depth_reciprocal));
    let (near, far): ([f32; WIDTH], [f32; WIDTH]) = (bounds.near.into(), bounds.far.into());
    let certain = edges.certain & lanes;
    let only_certain = |bounds: [f32; WIDTH]| {
        std::array::from_fn(|i| if certain >> i & 1 != 0 && bounds[i].is_finite() { bounds[i] } else { 0.0 })
    };
    KernelResults {
        possible: edges.possible & lanes,
        certain,
        back: edges.back() & certain,
        near: only_certain(near),
        far: only_certain(far),
    }
}

const COUNT: usize = 7;

/// Triangles of many shapes near `target` in one leaf, and a node of their boxes.
fn leaf(random: &mut Random, target: Vec3, size: f32) -> (WideNode, WideTree, Vec<Triangle>) {
    let triangles: Vec<Triangle> = (0..COUNT)
        .map(|i| {
            let thin = [1.0, 1.0e-3, 1.0e-5, 0.0][i % 4];
            let (a, b) = (target + random.point() * size, target + random.point() * size);
            let c = (a + b) * 0.5 + random.point() * size * thin;
            Triangle { vertices: [a, b, c] }
        })
        .collect();
    let mut node = WideNode::EMPTY;
    for (lane, triangle) in triangles.iter().enumerate() {
        let padding = triangle.magnitude() * BOX_PADDING + f32::MIN_POSITIVE;
        node.put(lane, lane as u32, &triangle.bounds().grown(padding));
    }
    let mut tree = WideTree::default();
    tree.words.resize(COUNT * WORDS_PER_SLOT + BLOCK, 0.0);
    let tagged = |i: usize| (triangles[i].vertices, Tag::new(i as u32, TriangleFlags::default()));
    write_leaf(&mut tree.words[..COUNT * WORDS_PER_SLOT], (0..COUNT).map(tagged));
    (node, tree, triangles)
}

#[test]
fn levels_agree_with_each_other_and_with_the_definition() {
    let mut random = Random(1);
    let (mut hits, mut certain_hits, mut extreme) = (0, 0, 0);
    for i in 0..60_000 {
        let scale = [1.0, 1.0e3, 1.0e30, 1.0e-30, 1.0e-18, 1.0e19][i % 6];
        let size = [1.0, 1.0e-4, 100.0][i / 6 % 3];
        let target = random.point() * scale;
        let (node, tree, triangles) = leaf(&mut random, target, size * scale.min(1.0e36));
        let corner = triangles[i % COUNT].vertices[i % 3];
        let aim = [corner, (triangles[i % COUNT].bounds()).center(), target][i / 18 % 3];
        let mut origin = random.point() * scale * [1.0, 10.0][i % 2];
        if i % 11 == 0 {
            origin.x = aim.x;
        }
        let mut direction = aim - origin;
        if i % 13 == 0 {
            direction /= direction.abs().max_element();
        }
        let ray = Ray::new(origin, direction);
        let results = triangles_at(SimdLevel::Scalar, &tree, &ray);
        let levels = || SimdLevel::ALL.into_iter().filter(|level| level.is_supported());
        for level in levels() {
            assert_eq!(triangles_at(level, &tree, &ray), results, "{level:?} {ray:?}");
        }
        extreme += u32::from(is_extreme(&ray));

        for (lane, triangle) in triangles.iter().enumerate() {
            let (possible, certain) = (results.possible >> lane & 1 != 0, results.certain >> lane & 1 != 0);
            assert!(possible || !certain);
            // No tree has these.
            if triangle.is_degenerate() {
                continue;
            }
            let Some(hit) = triangle.intersect(&ray) else {
                // A triangle that surely intersects the line is missed by the ray only because the ray ends or has not begun.
                assert!(!certain || results.near[lane] <= f32::MIN_POSITIVE, "{ray:?} misses {triangle:?}");
                continue;
            };
            hits += 1;
            assert!(possible, "{ray:?} passes over {triangle:?}");
            if certain {
                certain_hits += 1;
                // Bounds that are not finite, zero here, decide nothing.
                let apart = results.near[lane] > hit.t || results.far[lane] < hit.t;
                assert!(!apart || results.far[lane] == 0.0, "{results:?} {hit:?}");
                assert_eq!(results.back >> lane & 1 != 0, hit.facing == crate::geometry::Facing::Back);
            }
            // The box is entered by the hit's distance, not later.
            for level in levels() {
                for entered in boxes_at(level, &node, &ray, hit.t) {
                    assert!(entered >> lane & 1 == 1, "{level:?}: {ray:?} misses the box of {triangle:?}");
                }
            }
        }
    }
    assert!(hits > 20_000 && certain_hits > 3000, "{hits} {certain_hits}");
    assert!((5_000..30_000).contains(&extreme), "{extreme}");
}

#[test]
fn boxes_as_far_from_the_ray_as_a_hit_may_be_are_entered() {
    // See the definition of a hit: its point is within 0.63·2⁻²¹ of the largest coordinates from the ray.
    const DISTANCE: f64 = 0.63 / (1 << 21) as f64;
    let mut random = Random(3);
    for i in 0..100_000 {
        let scales = Vec3::from_array([0, 1, 2].map(|axis| [1.0e-3, 1.0, 1.0, 1.0e3][(i >> (2 * axis)) % 4]));
        let components =
            Vec3::from_array([0, 1, 2].map(|axis| [1.0, 1.0, 1.0e-4, 1.0e-9][(i / 3 + axis) % 4]));
        let (origin, direction) = (random.point() * scales, random.point() * components);
        let t = f64::from(random.signed().abs() + 1.0e-3) * [1.0e-2, 1.0, 1.0e4][i % 3] * 1.000_000_03;
        let point = origin.as_dvec3() + direction.as_dvec3() * t;
        let size = point.abs().max_element();
        let distance = DISTANCE * (f64::from(origin.abs().max_element()) + size);
        let moved = point + random.point().as_dvec3().signum() * distance;
        let corner = |rounded: fn(f64) -> f32| Vec3::from_array(moved.to_array().map(rounded));
        let bounds = Aabb { min: corner(rounded_down), max: corner(rounded_up) };
        let mut node = WideNode::EMPTY;
        node.put(0, 0, &bounds.grown(rounded_up(size) * BOX_PADDING + f32::MIN_POSITIVE));
        let ray = Ray::new(origin, direction);
        for level in SimdLevel::ALL.into_iter().filter(|level| level.is_supported()) {
            assert_eq!(boxes_at(level, &node, &ray, t as f32), [1, 1], "{level:?} {ray:?} {t} {bounds:?}");
        }
    }
}

fn triangles_at(level: SimdLevel, tree: &WideTree, ray: &Ray) -> KernelResults {
    dispatch_lanes!(level.level(), simd => triangle_kernel(simd, tree, ray))
}

/// Boxes that a ray enters at or before `upper`: by differences, and by products where those are finite.
fn boxes_at(level: SimdLevel, node: &WideNode, ray: &Ray, upper: f32) -> Vec<u32> {
    let by_differences = LaneRay::<true>::new(ray, ray.t_min);
    let mut entered = vec![entered_at(level, &by_differences, node, upper).mask];
    if !is_extreme(ray) {
        entered.push(entered_at(level, &LaneRay::<false>::new(ray, ray.t_min), node, upper).mask);
    }
    entered
}

fn entered_at<const EXTREME: bool>(
    level: SimdLevel,
    ray: &LaneRay<EXTREME>,
    node: &WideNode,
    upper: f32,
) -> Entered {
    dispatch_lanes!(level.level(), simd => ray.enter(simd, &ray.slabs, node, upper * ray.scale))
}

#[test]
fn triangles_far_from_the_ray_are_passed_over() {
    let mut random = Random(2);
    let (_, tree, _) = leaf(&mut random, Vec3::new(50.0, 0.0, 0.0), 1.0);
    let ray = Ray::new(Vec3::new(0.0, 0.0, -10.0), Vec3::Z);
    assert_eq!(triangles_at(SimdLevel::Scalar, &tree, &ray).possible, 0);
}

#[test]
fn a_ray_in_a_face_of_a_box_enters_it() {
    // No component of these differences is anything but zero on the face: 0·∞ must not lose the box.
    let mut node = WideNode::EMPTY;
    let unit = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
    node.put(0, 0, &unit);
    let enter =
        |ray: &Ray| entered_at(SimdLevel::best(), &LaneRay::<false>::new(ray, 0.0), &node, f32::INFINITY);
    let enter_by_differences =
        |ray: &Ray| entered_at(SimdLevel::Scalar, &LaneRay::<true>::new(ray, 0.0), &node, f32::INFINITY);
    for x in [0.0, -0.0, 0.5, 1.0] {
        for zero in [0.0, -0.0] {
            let ray = Ray::new(Vec3::new(x, 0.5, -1.0), Vec3::new(zero, zero, 1.0));
            for entered in [enter(&ray), enter_by_differences(&ray)] {
                assert_eq!(entered.mask, 1);
                assert!((entered.distances[0] - 1.0).abs() < 1.0e-5);
            }
        }
    }
    let beside = Ray::new(Vec3::new(1.1, 0.5, -1.0), Vec3::Z);
    assert_eq!((enter(&beside).mask, enter_by_differences(&beside).mask), (0, 0));
}

#[test]
fn entry_distances_inside_a_box_are_zero_rather_than_subnormal() {
    // The smallest limit of `t` times a scale below one would be subnormal, which costs some processors a hundred cycles.
    let mut node = WideNode::EMPTY;
    node.put(0, 0, &Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE });
    let ray = Ray::new(Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8));
    let lower = positive_lower(ray.t_min);
    for level in SimdLevel::ALL.into_iter().filter(|level| level.is_supported()) {
        let by_products = entered_at(level, &LaneRay::<false>::new(&ray, lower), &node, 1.0);
        let by_differences = entered_at(level, &LaneRay::<true>::new(&ray, lower), &node, 1.0);
        for entered in [by_products, by_differences] {
            assert_eq!((entered.mask, entered.distances[0].to_bits()), (1, 0));
        }
    }
}

#[test]
fn rays_with_overflowing_products_are_extreme() {
    let towards = |x: f32| Vec3::new(x, 1.0, 0.0);
    assert!(!is_extreme(&Ray::new(Vec3::splat(-7.0e28), towards(0.0))));
    assert!(is_extreme(&Ray::new(Vec3::new(0.0, -8.0e28, 0.0), towards(0.0))));
    assert!(is_extreme(&Ray::new(Vec3::new(f32::NAN, 0.0, 0.0), towards(0.0))));
    assert!(is_extreme(&Ray::new(Vec3::ONE, towards(0.0) * 1.0e-39)));
    assert!(
        is_extreme(&Ray::new(Vec3::ONE, towards(f32::NAN)))
            && is_extreme(&Ray::new(Vec3::ONE, towards(f32::INFINITY)))
    );
    let farthest = LaneRay::<false>::new(&Ray::new(Vec3::splat(-7.9e28), towards(0.0)), 0.0);
    let mut node = WideNode::EMPTY;
    node.put(0, 0, &Aabb { min: Vec3::splat(-8.0e28), max: Vec3::splat(8.0e28) });
    assert_eq!(entered_at(SimdLevel::best(), &farthest, &node, f32::INFINITY).mask, 1);
}
