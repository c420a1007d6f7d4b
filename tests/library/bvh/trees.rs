//! Tests of trees: equal for any number of threads, of bounded depth, and of low SAH cost.

use glam::Vec3;
use rayframe::bvh::{
    BuildSettings, Builder, BuilderKind, SimdLevel, Split, TraversalCounters, TriangleFlags,
};
use rayframe::cancel::CancelFlag;
use rayframe::geometry::{Aabb, Ray, Triangle};

use super::inputs::{Random, moved, rays, scaled, soup, sphere, triangle};
use super::{HIERARCHIES, build, flags, settings};

#[test]
fn threads_do_not_change_the_tree() {
    let triangles = soup(20_000, 0.3, &mut Random(4));
    let flags = flags(triangles.len());
    let rays = rays(&triangles, 200, &mut Random(5));
    for (builder, split) in [
        (BuilderKind::Lbvh, Split::Off),
        (BuilderKind::Lbvh, Split::Area(0.05)),
        (BuilderKind::Karras, Split::Auto),
        (BuilderKind::Ploc, Split::Off),
        (BuilderKind::Ploc, Split::Auto),
    ] {
        let settings = settings(builder, split, SimdLevel::best());
        let results = [1, 2, 3, 8].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let bvh = pool.install(|| build(&triangles, &flags, &settings));
            let s = bvh.statistics();
            // The counters are equal only if the trees are.
            let mut counters = TraversalCounters::default();
            for ray in &rays {
                bvh.closest_hit(ray, None, |_| true, &mut counters);
            }
            (s.references, s.sa_max.to_bits(), s.depth, s.sah_cost.to_bits(), s.bytes, counters)
        });
        assert!(results.iter().all(|result| *result == results[0]), "{builder:?} {split:?} {results:?}");
    }
}

#[test]
fn many_identical_triangles_build_a_shallow_tree() {
    let triangles = vec![triangle(Vec3::ZERO, Vec3::X, Vec3::Y); 1_000_000];
    let flags = vec![TriangleFlags::default(); triangles.len()];
    for builder in HIERARCHIES {
        let bvh = build(&triangles, &flags, &settings(builder, Split::Off, SimdLevel::best()));
        bvh.validate(&triangles, &flags).unwrap();
        // Equal codes are split by the bits of their positions, and identical boxes merge in pairs. Both give about
        // ceil(log2(10⁶)) = 20 levels. Chunks, of which the last is smaller, may add a few.
        assert!((20..=24).contains(&bvh.statistics().depth), "{builder:?} {}", bvh.statistics().depth);
        let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
        let hit = bvh.closest_hit(&ray, None, |_| true, &mut TraversalCounters::default()).unwrap();
        assert_eq!((hit.triangle, hit.t), (0, 1.0));
    }
}

#[test]
fn chains_and_nested_boxes_build_a_shallow_tree() {
    // Nested boxes and boxes in a row that grow by a factor: each is nearest to the next smaller one.
    let size = |i: i32| libm::powf(1.001, i as f32) * 1.0e-3;
    let nested = (0..30_000).map(|i| {
        let [a, b, c] = [Vec3::NEG_ONE, Vec3::ONE, Vec3::new(1.0, -1.0, 0.0)].map(|p| p * size(i));
        triangle(a, b, c)
    });
    let chain = (0..30_000).map(|i| {
        let corner = Vec3::splat(size(i));
        triangle(corner, corner + Vec3::X * size(i) * 5.0e-4, corner + Vec3::Y * size(i) * 5.0e-4)
    });
    for triangles in [nested.collect::<Vec<_>>(), chain.collect()] {
        let flags = vec![TriangleFlags::default(); triangles.len()];
        for builder in HIERARCHIES {
            let bvh = build(&triangles, &flags, &settings(builder, Split::Off, SimdLevel::best()));
            bvh.validate(&triangles, &flags).unwrap();
            assert!(bvh.statistics().depth <= 78, "{builder:?} {}", bvh.statistics().depth);
        }
    }
}

/// Cost of a tree that is divided at the best of 15 planes on the axis of the widest centres, with unit costs for nodes
/// and triangles and one triangle a leaf, as [`rayframe::bvh::BuildStatistics::sah_cost`] is: the areas of all boxes.
fn binned_area_sum(boxes: &mut [Aabb]) -> f64 {
    let around = |boxes: &[Aabb]| boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b));
    let whole = around(boxes);
    if boxes.len() == 1 {
        return whole.area();
    }
    let centers = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union_point(b.center()));
    let axis = centers.extent().max_position();
    let plane = |k: usize| centers.min[axis] + centers.extent()[axis] * k as f32 / 16.0;
    let cost = |k: usize| {
        let sides = [true, false].map(|left| {
            let side: Vec<Aabb> =
                boxes.iter().copied().filter(|b| (b.center()[axis] < plane(k)) == left).collect();
            around(&side).area() * side.len() as f64
        });
        sides[0] + sides[1]
    };
    let best = (1..16).min_by(|&a, &b| cost(a).total_cmp(&cost(b))).map_or(0.0, plane);
    boxes.sort_by_key(|b| b.center()[axis] >= best);
    let left = boxes.iter().filter(|b| b.center()[axis] < best).count();
    let middle = if left == 0 || left == boxes.len() { boxes.len() / 2 } else { left };
    let (low, high) = boxes.split_at_mut(middle);
    whole.area() + binned_area_sum(low) + binned_area_sum(high)
}

#[test]
fn a_teapot_in_a_stadium_costs_no_more_than_with_bins() {
    // A ball of 7200 triangles, 2 cm across, and stands of 2000 triangles, 200 m across.
    let mut triangles = moved(&scaled(&sphere(60), 0.01), Vec3::new(3.0, 1.0, -7.0));
    for i in 0..1000_usize {
        let angle = i as f32 * 0.1;
        let corner = Vec3::new(libm::cosf(angle), 0.002 * i as f32, libm::sinf(angle)) * 100.0;
        let (across, up) = (Vec3::new(-corner.z, 0.0, corner.x) * 0.1, Vec3::Y * 0.5);
        triangles.push(triangle(corner, corner + across, corner + up));
        triangles.push(triangle(corner + across, corner + up, corner + across + up));
    }
    let flags = vec![TriangleFlags::default(); triangles.len()];
    let bvh = build(&triangles, &flags, &BuildSettings { split: Split::Off, ..BuildSettings::default() });
    let mut boxes: Vec<Aabb> = triangles.iter().map(Triangle::bounds).collect();
    let root = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b)).area();
    let expected = binned_area_sum(&mut boxes) / root;
    let cost = f64::from(bvh.statistics().sah_cost);
    assert!(cost < 1.5 * expected, "{cost} {expected}");
}

#[test]
fn homogeneous_meshes_are_not_split() {
    let triangles = sphere(60);
    let flags = vec![TriangleFlags::default(); triangles.len()];
    let bvh = build(&triangles, &flags, &settings(BuilderKind::Auto, Split::Auto, SimdLevel::best()));
    assert_eq!(bvh.statistics().references, bvh.statistics().triangles);
}

#[test]
fn the_tree_is_named_and_chosen_by_what_rays_are_expected() {
    // Among small ones stand large ones.
    let mut triangles = soup(5000, 0.05, &mut Random(6));
    triangles.extend(soup(50, 2.0, &mut Random(7)));
    let flags = vec![TriangleFlags::default(); triangles.len()];
    for (expected_rays, built) in [(0, BuilderKind::Lbvh), (1 << 30, BuilderKind::Ploc)] {
        let settings = BuildSettings { expected_rays, ..BuildSettings::default() };
        assert_eq!(build(&triangles, &flags, &settings).statistics().builder, built);
    }
    for builder in HIERARCHIES {
        let settings = settings(builder, Split::Off, SimdLevel::best());
        assert_eq!(build(&triangles, &flags, &settings).statistics().builder, builder);
    }
}

#[test]
fn a_builder_and_a_hierarchy_can_be_used_again() {
    let mut builder = Builder::default();
    let mut last = None;
    for n in [1000, 10, 0, 3000, 1] {
        let triangles = soup(n, 0.1, &mut Random(n as u64));
        let flags = vec![TriangleFlags::default(); n];
        let bvh =
            builder.build(&triangles, &flags, &BuildSettings::default(), &CancelFlag::new(), last).unwrap();
        bvh.validate(&triangles, &flags).unwrap();
        assert_eq!(bvh.statistics().triangles, n);
        last = Some(bvh);
    }
}

#[test]
fn a_raised_flag_stops_the_build() {
    let cancel = CancelFlag::new();
    cancel.raise();
    let triangles = soup(10, 0.1, &mut Random(1));
    let flags = [TriangleFlags::default(); 10];
    assert!(Builder::default().build(&triangles, &flags, &BuildSettings::default(), &cancel, None).is_err());
}
