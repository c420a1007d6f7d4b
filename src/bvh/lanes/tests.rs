//! The levels against each other and against the definition of a hit.

use super::*;
use crate::bvh::PrimitiveFlags;
use crate::bvh::wide::{Leaf, Tag, WORDS_A_PLACE, WideTree, write_leaf};
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
struct Kernels<'a>(&'a WideNode, &'a Triangles<'a>, &'a LaneRay, f32);

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
fn pack(random: &mut Random, target: Vec3, size: f32) -> (WideNode, WideTree, Vec<Triangle>) {
    let mut node = WideNode::EMPTY;
    let triangles: Vec<Triangle> = (0..7)
        .map(|i| {
            let thin = [1.0, 1.0e-3, 1.0e-5, 0.0][i % 4];
            let (a, b) = (target + random.point() * size, target + random.point() * size);
            let c = (a + b) * 0.5 + random.point() * size * thin;
            Triangle { vertices: [a, b, c] }
        })
        .collect();
    for (lane, triangle) in triangles.iter().enumerate() {
        let padding = triangle.magnitude() * BOX_PADDING + f32::MIN_POSITIVE;
        node.put(lane, lane as u32, &triangle.bounds().grown(padding));
    }
    let mut tree = WideTree::default();
    tree.words.resize(7 * WORDS_A_PLACE + WIDTH, 0.0);
    let tagged = |i: usize| (triangles[i].vertices, Tag::new(i as u32, PrimitiveFlags::default()));
    write_leaf(&mut tree.words[..7 * WORDS_A_PLACE], (0..7).map(tagged));
    (node, tree, triangles)
}

#[test]
fn levels_agree_and_no_hit_is_passed_over() {
    let mut random = Random(1);
    let mut hits = 0;
    for i in 0..60_000 {
        let scale = [1.0, 1.0e3, 1.0e30, 1.0e-30, 1.0e-18, 1.0e19][i % 6];
        let size = [1.0, 1.0e-4, 100.0][i / 6 % 3];
        let target = random.point() * scale;
        let (node, tree, triangles) = pack(&mut random, target, size * scale.min(1.0e36));
        let pack = tree.triangles(Leaf::new(0, 7));
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
        let scalar = dispatch(SimdLevel::Scalar, Kernels(&node, &pack, &lane_ray, upper), counters);
        let best = dispatch(SimdLevel::best(), Kernels(&node, &pack, &lane_ray, upper), counters);
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
            assert!(at_hit.mask >> lane & 1 == 1, "{ray:?} misses the box of {triangle:?}");
        }
    }
    assert!(hits > 20_000, "{hits}");
}

#[test]
fn triangles_far_from_the_ray_are_passed_over() {
    let mut random = Random(2);
    let (_, tree, _) = pack(&mut random, Vec3::new(50.0, 0.0, 0.0), 1.0);
    let ray = LaneRay::new(&Ray::new(Vec3::new(0.0, 0.0, -10.0), Vec3::Z), 0.0);
    assert_eq!(Scalar::candidates(&tree.triangles(Leaf::new(0, 7)), &ray), 0);
}

#[test]
fn a_ray_in_a_face_of_a_box_enters_it() {
    // No component of these differences is anything but zero on the face: 0·∞ must not lose the box.
    let mut node = WideNode::EMPTY;
    let unit = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
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
    assert_eq!(Scalar::enter(&node, &LaneRay::new(&beside, 0.0), f32::INFINITY).mask, 0);
}
