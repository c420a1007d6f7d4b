//! Tests of queries, one ray at a time and in batches.

use glam::Vec3;
use rayframe::bvh::{
    BuildSettings, BuilderKind, Bvh, Hit, HitOrder, SimdLevel, Split, TraversalCounters, TriangleFlags,
};
use rayframe::geometry::{Aabb, Ray, Triangle};

use super::inputs::{Random, inputs, moved, rays, scaled, sphere, stacked, triangle};
use super::{all_settings, build, flags, rotated_settings, settings};

/// Filter like an alpha mask, by the position of the hit on the triangle.
fn opaque_part(hit: &Hit) -> bool {
    ((hit.u * 8.0) as u32).is_multiple_of(2)
}

/// Answers of all queries of one ray.
fn answers(bvh: &Bvh, ray: &Ray) -> (Option<Hit>, Option<Hit>, bool, Vec<Hit>) {
    let counters = &mut TraversalCounters::default();
    let mut all = Vec::new();
    let mut after: Option<HitOrder> = None;
    while let Some(hit) = bvh.closest_hit_of_any_side(ray, after, opaque_part, counters) {
        assert!(after.is_none_or(|after| after < hit.order()), "hits come in order");
        after = Some(hit.order());
        all.push(hit);
        if all.len() == 40 {
            break;
        }
    }
    let closest = bvh.closest_hit(ray, None, opaque_part, counters);
    (closest, all.first().copied(), bvh.occluded(ray, opaque_part, counters), all)
}

#[test]
fn equals_brute_force_for_all_settings() {
    let mut random = Random(2);
    for (input, (name, triangles)) in inputs().into_iter().enumerate() {
        let flags = flags(triangles.len());
        let brute_force =
            build(&triangles, &flags, &settings(BuilderKind::BruteForce, Split::Off, SimdLevel::Scalar));
        let rays = rays(&triangles, 80, &mut random);
        let expected: Vec<_> = rays.iter().map(|ray| answers(&brute_force, ray)).collect();
        let hits = expected.iter().filter(|answer| answer.1.is_some()).count();
        if !["none", "collinear"].contains(&name) {
            assert!(hits * 20 > rays.len(), "{name}: only {hits} rays hit");
        }
        // Every SIMD level with every split of the hardest inputs, and each with some splits of the others
        let is_hard = ["two", "degenerate among others", "huge", "slivers"].contains(&name);
        for settings in if is_hard { all_settings() } else { rotated_settings(input) } {
            let bvh = build(&triangles, &flags, &settings);
            bvh.validate(&triangles, &flags).unwrap();
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(&answers(&bvh, ray), expected, "{name} {settings:?} {ray:?}");
            }
        }
    }
}

/// A product of an edge function and a depth is beyond the largest float, the hit's distance is not.
#[test]
fn narrow_triangles_far_along_the_ray_are_hit() {
    let (depth, side) = (1.0e32, 1.0e6);
    let at = |y: f32, z: f32| Vec3::new(depth, y * side, z * side);
    let triangles = [triangle(at(-1.0, -1.0), at(1.0, -1.0), at(0.0, 1.0)); 3];
    let rays = [Vec3::X * depth, Vec3::X].map(|direction| {
        let ray = Ray::new(Vec3::ZERO, direction);
        Ray { t_max: 2.0 * depth / direction.x, ..ray }
    });
    for settings in all_settings() {
        let bvh = build(&triangles, &[TriangleFlags::default(); 3], &settings);
        for ray in &rays {
            let counters = &mut TraversalCounters::default();
            assert!(bvh.occluded(ray, |_| true, counters), "{settings:?} {ray:?}");
            let mut hits = [None];
            bvh.closest_hits(&[*ray], |_, _| true, &mut hits, counters);
            let closest = bvh.closest_hit(ray, None, |_| true, counters);
            assert_eq!(closest.map(|hit| hit.t), Some(depth / ray.direction.x), "{settings:?} {ray:?}");
            assert_eq!(closest, hits[0]);
        }
    }
}

/// Coherent rays as an integrator traces them: from one point to a small square, segments back to it, and from a curved mirror.
fn batches(triangles: &[Triangle], random: &mut Random) -> Vec<Vec<Ray>> {
    let finite = triangles.iter().filter(|t| t.vertices.iter().all(|p| p.is_finite()));
    let bounds = finite.fold(Aabb::EMPTY, |all, t| all.union(t.bounds()));
    let (center, reach) =
        if bounds.is_empty() { (Vec3::ZERO, 1.0) } else { (bounds.center(), bounds.extent().max_element()) };
    let mut batches = Vec::new();
    for i in 0..36 {
        let origin = center + random.point() * reach * [0.2, 1.5][i % 2];
        let aim = if triangles.is_empty() {
            center
        } else {
            triangles[random.below(triangles.len())].vertices[i % 3]
        };
        let along = if aim.is_finite() { aim - origin } else { center - origin };
        let side = along.any_orthogonal_vector();
        let up = along.cross(side).normalize_or_zero() * side.length();
        let spread = [0.002, 0.05, 0.5, 3.0][i / 2 % 4];
        let n = [64, 200, 5, 17][i % 4];
        let batch = (0..n).map(|k| {
            let (x, y) = ((k % 8) as f32 / 4.0 - 1.0, (k / 8 % 8) as f32 / 4.0 - 1.0);
            let direction = along + (side * x + up * y) * spread;
            match i % 3 {
                0 => Ray::new(origin, direction),
                1 => Ray { t_min: 0.01, t_max: 1.0, ..Ray::new(origin, direction) },
                _ => Ray::new(origin + side * (x * 0.1), direction),
            }
        });
        batches.push(batch.collect());
    }
    batches
}

/// Rays that begin or end at the first hits of `rays`, a float before or behind them.
fn limited(triangles: &[Triangle], rays: &[Ray]) -> Vec<Ray> {
    let flags = vec![TriangleFlags::default(); triangles.len()];
    let settings = settings(BuilderKind::BruteForce, Split::Off, SimdLevel::Scalar);
    let brute_force = build(triangles, &flags, &settings);
    let limited = |(i, ray): (usize, &Ray)| {
        let any = |_: &Hit| true;
        let hit = brute_force.closest_hit_of_any_side(ray, None, any, &mut TraversalCounters::default());
        let t = hit.map_or(1.0, |hit| hit.t);
        match i % 7 {
            0 => Ray { t_max: t, ..*ray },
            1 => Ray { t_max: t.next_up(), ..*ray },
            2 => Ray { t_max: t.next_down(), ..*ray },
            3 => Ray { t_min: t, ..*ray },
            4 => Ray { t_min: t.next_up(), ..*ray },
            5 => Ray { t_min: t.next_down(), ..*ray },
            _ => Ray { t_min: -t, ..*ray },
        }
    };
    rays.iter().enumerate().map(limited).collect()
}

#[test]
fn batches_equal_single_rays() {
    let mut random = Random(6);
    let mut hits = 0;
    for (name, triangles) in inputs() {
        let flags = flags(triangles.len());
        let mut batches = batches(&triangles, &mut random);
        let at_limits: Vec<_> = batches.iter().map(|rays| limited(&triangles, rays)).collect();
        batches.extend(at_limits);
        let brute_force =
            build(&triangles, &flags, &settings(BuilderKind::BruteForce, Split::Off, SimdLevel::Scalar));
        // The filter depends on the index of the ray: every third one sees other parts.
        let filter = |i: usize, hit: &Hit| opaque_part(hit) != i.is_multiple_of(3);
        let answer = |(i, ray): (usize, &Ray)| {
            let counters = &mut TraversalCounters::default();
            let closest = brute_force.closest_hit(ray, None, |hit| filter(i, hit), counters);
            (closest, brute_force.occluded(ray, |hit| filter(i, hit), counters))
        };
        let answers = |rays: &Vec<Ray>| rays.iter().enumerate().map(answer).collect::<Vec<_>>();
        let expected: Vec<_> = batches.iter().map(answers).collect();
        hits += expected.iter().flatten().filter(|(_, occluded)| *occluded).count();
        for simd in crate::supported_simd_levels() {
            let bvh = build(&triangles, &flags, &settings(BuilderKind::Auto, Split::Auto, simd));
            for (rays, expected) in batches.iter().zip(&expected) {
                let counters = &mut TraversalCounters::default();
                let mut closest = vec![None; rays.len()];
                let mut occluded = vec![false; rays.len()];
                bvh.closest_hits(rays, filter, &mut closest, counters);
                bvh.occluded_rays(rays, filter, &mut occluded, counters);
                assert_eq!(counters.rays, 2 * rays.len() as u64);
                for (i, ray) in rays.iter().enumerate() {
                    assert_eq!((closest[i], occluded[i]), expected[i], "{name} {simd:?} {i} {ray:?}");
                }
            }
        }
    }
    assert!(hits > 5000, "{hits}");
}

#[test]
fn all_hits_are_listed_once_and_in_order() {
    // Every ray through the middle hits all 200 sheets: 7 distances, about 29 sheets at each.
    let triangles = stacked(200);
    let flags = vec![TriangleFlags::default(); 200];
    let bvh = build(&triangles, &flags, &settings(BuilderKind::Lbvh, Split::Area(0.05), SimdLevel::best()));
    assert!(bvh.statistics().references > 400);
    let ray = Ray::new(Vec3::new(0.01, -0.1, -1.0), Vec3::Z);
    let mut listed = Vec::new();
    let mut after = None;
    while let Some(hit) = bvh.closest_hit(&ray, after, |_| true, &mut TraversalCounters::default()) {
        after = Some(hit.order());
        listed.push((hit.t, hit.triangle));
    }
    let mut expected: Vec<(f32, u32)> = (0..200).map(|i| (1.0 + (i % 7) as f32 * 0.125, i)).collect();
    expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(listed, expected);
}

#[test]
fn single_sided_back_faces_are_seen_by_two_queries_only() {
    let triangles = [triangle(Vec3::ZERO, Vec3::X, Vec3::Y)];
    let bvh = build(&triangles, &[TriangleFlags::SINGLE_SIDED], &BuildSettings::default());
    let counters = &mut TraversalCounters::default();
    let from = |z: f32| Ray::new(Vec3::new(0.25, 0.25, z), Vec3::Z * -z);
    assert!(bvh.closest_hit(&from(1.0), None, |_| false, counters).is_some());
    assert!(bvh.closest_hit(&from(-1.0), None, |_| false, counters).is_none());
    assert!(bvh.closest_hit_of_any_side(&from(-1.0), None, |_| false, counters).is_some());
    assert!(bvh.occluded(&from(-1.0), |_| false, counters));
    assert_eq!(counters.rays, 4);
}

#[test]
fn transmissive_triangles_are_seen_by_two_queries_whatever_the_filter() {
    // Seventeen stacked triangles are in leaves below a node, so that packets are used.
    let triangles = stacked(17);
    let bvh = build(&triangles, &[TriangleFlags::TRANSMISSIVE; 17], &BuildSettings::default());
    let counters = &mut TraversalCounters::default();
    let ray = Ray::new(Vec3::new(0.01, -0.1, -1.0), Vec3::Z);
    let first = bvh.closest_hit(&ray, None, |_| false, counters);
    assert_eq!(first.unwrap().t, 1.0);
    assert_eq!(bvh.closest_hit_of_any_side(&ray, None, |_| false, counters), None);
    assert_eq!(bvh.closest_hit_of_any_side(&ray, None, |_| true, counters), first);
    assert!(!bvh.occluded(&ray, |_| false, counters));
    assert!(bvh.occluded(&ray, |hit| hit.triangle == 16, counters));
    let rays = [ray; 64];
    let (mut hits, mut occluded) = ([None; 64], [false; 64]);
    bvh.closest_hits(&rays, |_, _| false, &mut hits, counters);
    assert_eq!(hits, [first; 64]);
    bvh.occluded_rays(&rays, |ray, hit| ray == 5 && hit.triangle == 16, &mut occluded, counters);
    assert_eq!(occluded, std::array::from_fn(|ray| ray == 5));
}

#[test]
fn no_ray_escapes_from_a_sphere() {
    let mut random = Random(3);
    for (scale, offset) in [(1.0, Vec3::ZERO), (1.0e6, Vec3::ZERO), (1.0e-3, Vec3::new(10.0, -3.0, 1.0))] {
        let triangles = moved(&scaled(&sphere(60), scale), offset);
        let flags = vec![TriangleFlags::default(); triangles.len()];
        for split in [Split::Off, Split::Area(0.01 * scale * scale)] {
            let bvh = build(&triangles, &flags, &settings(BuilderKind::Auto, split, SimdLevel::best()));
            let counters = &mut TraversalCounters::default();
            for i in 0..170_000 {
                let origin = offset + random.point() * scale * 0.5;
                let [a, b, c] = triangles[random.below(triangles.len())].vertices;
                let direction = match i % 4 {
                    0 => a - origin,
                    1 => a * 0.5 + b * 0.5 - origin,
                    2 => c * 0.25 + b * 0.75 - origin,
                    _ => random.point(),
                };
                let ray = Ray::new(origin, direction);
                assert!(bvh.occluded(&ray, |_| true, counters), "{ray:?}");
                assert!(bvh.closest_hit(&ray, None, |_| true, counters).is_some(), "{ray:?}");
            }
        }
    }
}
