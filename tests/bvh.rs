//! The hierarchy against brute force: whatever the settings, every query gives the same bits.

use glam::Vec3;
use rayframe::bvh::{
    BuildSettings, Builder, BuilderKind, Bvh, Hit, HitOrder, PrimitiveFlags, SimdLevel, Split,
    TraversalCounters,
};
use rayframe::cancel::CancelFlag;
use rayframe::geometry::{Aabb, Ray, Triangle};

/// Builders of a hierarchy.
const HIERARCHIES: [BuilderKind; 3] = [BuilderKind::Lbvh, BuilderKind::Karras, BuilderKind::Ploc];

/// A small permuted congruential generator.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 22 ^ self.0) >> (22 + (self.0 >> 61))) as u32
    }

    /// In [-1, 1).
    fn signed(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    fn below(&mut self, n: usize) -> usize {
        self.bits() as usize % n
    }
}

fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Triangle {
    Triangle { vertices: [a, b, c] }
}

fn soup(n: usize, size: f32, random: &mut Random) -> Vec<Triangle> {
    (0..n)
        .map(|_| {
            let a = random.point();
            triangle(a, a + random.point() * size, a + random.point() * size)
        })
        .collect()
}

/// Aspect 10³ to 10⁵, in all directions.
fn slivers(n: usize, random: &mut Random) -> Vec<Triangle> {
    (0..n)
        .map(|i| {
            let (a, b) = (random.point(), random.point());
            let width = [1.0e-3, 1.0e-4, 1.0e-5][i % 3];
            triangle(a, b, (a + b) * 0.5 + random.point() * width)
        })
        .collect()
}

/// Sheets one above the other, many at exactly the same place.
fn stacked(n: usize) -> Vec<Triangle> {
    (0..n)
        .map(|i| {
            let z = (i % 7) as f32 * 0.125;
            let x = if i % 2 == 0 { 1.0 } else { -1.0 };
            triangle(Vec3::new(-x, -1.0, z), Vec3::new(x, -1.0, z), Vec3::new(0.0, 1.0, z))
        })
        .collect()
}

/// A chain of triangles whose distances and sizes grow by a factor.
fn chain(n: usize) -> Vec<Triangle> {
    (0..n)
        .map(|i| {
            let scale = libm::powf(1.02, i as f32) * 1.0e-3;
            let a = Vec3::new(scale, scale * 0.5, scale * 0.25);
            triangle(a, a + Vec3::X * scale * 0.1, a + Vec3::Y * scale * 0.1)
        })
        .collect()
}

fn scaled(triangles: &[Triangle], scale: f32) -> Vec<Triangle> {
    triangles.iter().map(|t| Triangle { vertices: t.vertices.map(|p| p * scale) }).collect()
}

/// Whole coordinates in the plane x = 3 y, for rays that lie in it exactly.
fn in_one_plane(n: usize, random: &mut Random) -> Vec<Triangle> {
    let mut point = || {
        let [y, z] = [0; 2].map(|_| (random.below(128) as f32) - 64.0);
        Vec3::new(3.0 * y, y, z)
    };
    (0..n).map(|_| triangle(point(), point(), point())).collect()
}

fn moved(triangles: &[Triangle], by: Vec3) -> Vec<Triangle> {
    triangles.iter().map(|t| Triangle { vertices: t.vertices.map(|p| p + by) }).collect()
}

fn inputs() -> Vec<(&'static str, Vec<Triangle>)> {
    let mut random = Random(1);
    let flat = soup(300, 0.5, &mut random)
        .into_iter()
        .map(|t| Triangle { vertices: t.vertices.map(|p| Vec3::new(p.x, 0.25, p.z)) })
        .collect();
    let collinear = (0..50)
        .map(|i| {
            let p = Vec3::splat(i as f32 * 0.01);
            triangle(p, p * 2.0, p * 3.0)
        })
        .collect();
    let mut with_degenerate = soup(100, 0.5, &mut random);
    for i in (0..100).step_by(3) {
        with_degenerate[i].vertices[2] = with_degenerate[i].vertices[i % 2];
    }
    with_degenerate[5].vertices[1].y = f32::NAN;
    with_degenerate[7].vertices[0].x = f32::INFINITY;
    let one = soup(1, 1.0, &mut random);
    vec![
        ("none", Vec::new()),
        ("two", soup(2, 1.0, &mut random)),
        ("identical", vec![one[0]; 500]),
        ("one", one),
        ("small triangles", soup(3000, 0.05, &mut random)),
        ("large triangles", soup(400, 2.0, &mut random)),
        ("flat", flat),
        ("collinear", collinear),
        ("degenerate among others", with_degenerate),
        ("huge", scaled(&soup(300, 0.5, &mut random), 1.0e30)),
        ("tiny", scaled(&soup(300, 0.5, &mut random), 1.0e-30)),
        ("far away", moved(&soup(300, 0.5, &mut random), Vec3::new(1.0e4, -2.0e4, 0.5))),
        ("slivers", slivers(600, &mut random)),
        ("slivers far away", moved(&slivers(300, &mut random), Vec3::splat(700.0))),
        ("in one plane", in_one_plane(200, &mut random)),
        ("stacked", stacked(200)),
        ("chain", chain(400)),
    ]
}

/// Rays from everywhere, many aimed at corners, edges and faces, some along axes, some grazing.
fn rays(triangles: &[Triangle], n: usize, random: &mut Random) -> Vec<Ray> {
    let finite = triangles.iter().filter(|t| t.vertices.iter().all(|p| p.is_finite()));
    let bounds = finite.clone().fold(Aabb::EMPTY, |all, t| all.union(t.bounds()));
    let finite: Vec<&Triangle> = finite.collect();
    let (center, reach) =
        if bounds.is_empty() { (Vec3::ZERO, 1.0) } else { (bounds.center(), bounds.extent().max_element()) };
    (0..n)
        .map(|i| {
            let mut origin = center + random.point() * reach * [0.5, 1.0, 20.0][i % 3];
            let mut direction = random.point();
            if let (false, kind @ 0..8) = (finite.is_empty(), i % 9) {
                let [a, b, c] = finite[random.below(finite.len())].vertices;
                let target = match kind {
                    0 => a,
                    1 => a * 0.5 + b * 0.5,
                    2..=4 => a * 0.5 + b * 0.25 + c * 0.25,
                    // Nearly in the triangle's plane.
                    5 => {
                        origin = a + (a - b) * 0.7 + (b - a).cross(c - a) / reach * 1.0e-3;
                        b * 0.5 + c * 0.5
                    }
                    6 => {
                        let axis = random.below(3);
                        let mut along = a * 0.25 + b * 0.25 + c * 0.5;
                        along[axis] += reach * random.signed();
                        origin = along;
                        along[axis] += if i % 16 < 8 { reach } else { -reach };
                        along
                    }
                    // In line with an edge: edge-on but for rounding.
                    _ => {
                        origin = a * 2.0 - b;
                        if i % 2 == 0 { c } else { a * 0.5 + b * 0.25 + c * 0.25 }
                    }
                };
                direction = (target - origin) / [1.0, reach][i % 2];
            }
            let mut ray = Ray::new(origin, direction);
            if i % 5 == 0 {
                (ray.t_min, ray.t_max) = (0.25, 0.75);
            }
            ray
        })
        .filter(|ray| ray.direction != Vec3::ZERO && ray.direction.is_finite())
        .collect()
}

fn flags(n: usize) -> Vec<PrimitiveFlags> {
    (0..n)
        .map(|i| match i % 6 {
            0 => PrimitiveFlags::SINGLE_SIDED,
            1 => PrimitiveFlags::FILTERED,
            2 => PrimitiveFlags::FILTERED.with(PrimitiveFlags::SINGLE_SIDED),
            3 if i % 12 == 3 => PrimitiveFlags::HIDDEN,
            _ => PrimitiveFlags::default(),
        })
        .collect()
}

#[expect(clippy::unwrap_used, reason = "only tests call this, and nothing raises the flag")]
fn build(triangles: &[Triangle], flags: &[PrimitiveFlags], settings: &BuildSettings) -> Bvh {
    Builder::default().build(triangles, flags, settings, &CancelFlag::new(), None).unwrap()
}

fn settings(builder: BuilderKind, split: Split, simd: SimdLevel) -> BuildSettings {
    BuildSettings { builder, split, simd, ..BuildSettings::default() }
}

/// Both trees with every way of splitting and both kinds of lanes, and the slow twin of one of them.
fn all_settings() -> Vec<BuildSettings> {
    let mut all = vec![settings(BuilderKind::Karras, Split::Auto, SimdLevel::best())];
    for builder in [BuilderKind::Lbvh, BuilderKind::Ploc] {
        for split in [Split::Off, Split::Auto, Split::Area(1.0e-3), Split::Area(1.0e-30)] {
            for simd in [SimdLevel::Scalar, SimdLevel::Avx2] {
                all.push(settings(builder, split, simd));
            }
        }
    }
    all
}

/// A filter as alpha masks are: by where on the triangle the hit is.
fn opaque_part(hit: &Hit) -> bool {
    ((hit.u * 8.0) as u32).is_multiple_of(2)
}

/// All answers of one ray, as bits.
fn answers(bvh: &Bvh, ray: &Ray) -> (Option<Hit>, Option<Hit>, bool, Vec<Hit>) {
    let counters = &mut TraversalCounters::default();
    let mut all = Vec::new();
    let mut after: Option<HitOrder> = None;
    while let Some(hit) = bvh.closest_surface(ray, after, opaque_part, counters) {
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
fn equals_brute_force_whatever_the_settings() {
    let mut random = Random(2);
    for (name, triangles) in inputs() {
        let flags = flags(triangles.len());
        let slow =
            build(&triangles, &flags, &settings(BuilderKind::BruteForce, Split::Off, SimdLevel::Scalar));
        let rays = rays(&triangles, 400, &mut random);
        let expected: Vec<_> = rays.iter().map(|ray| answers(&slow, ray)).collect();
        let hits = expected.iter().filter(|answer| answer.1.is_some()).count();
        if !["none", "collinear"].contains(&name) {
            assert!(hits * 20 > rays.len(), "{name}: only {hits} rays hit");
        }
        for settings in all_settings() {
            let fast = build(&triangles, &flags, &settings);
            fast.validate(&triangles, &flags).unwrap();
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(&answers(&fast, ray), expected, "{name} {settings:?} {ray:?}");
            }
        }
    }
}

#[test]
fn all_hits_are_listed_once_and_in_order() {
    // 200 sheets of which every ray through the middle meets each: 7 distances, about 29 sheets at each.
    let triangles = stacked(200);
    let flags = vec![PrimitiveFlags::default(); 200];
    let bvh = build(&triangles, &flags, &settings(BuilderKind::Lbvh, Split::Area(0.05), SimdLevel::best()));
    assert!(bvh.statistics().references > 400);
    let ray = Ray::new(Vec3::new(0.01, -0.1, -1.0), Vec3::Z);
    let mut listed = Vec::new();
    let mut after = None;
    while let Some(hit) = bvh.closest_hit(&ray, after, |_| true, &mut TraversalCounters::default()) {
        after = Some(hit.order());
        listed.push((hit.t, hit.primitive));
    }
    let mut expected: Vec<(f32, u32)> = (0..200).map(|i| (1.0 + (i % 7) as f32 * 0.125, i)).collect();
    expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(listed, expected);
}

#[test]
fn single_sided_back_faces_are_seen_by_two_queries_only() {
    let triangles = [triangle(Vec3::ZERO, Vec3::X, Vec3::Y)];
    let bvh = build(&triangles, &[PrimitiveFlags::SINGLE_SIDED], &BuildSettings::default());
    let counters = &mut TraversalCounters::default();
    let from = |z: f32| Ray::new(Vec3::new(0.25, 0.25, z), Vec3::Z * -z);
    assert!(bvh.closest_hit(&from(1.0), None, |_| false, counters).is_some());
    assert!(bvh.closest_hit(&from(-1.0), None, |_| false, counters).is_none());
    assert!(bvh.closest_surface(&from(-1.0), None, |_| false, counters).is_some());
    assert!(bvh.occluded(&from(-1.0), |_| false, counters));
    assert_eq!(counters.rays, 4);
}

/// A sphere of 2 · `rings`² triangles whose vertices are shared exactly.
fn sphere(rings: usize) -> Vec<Triangle> {
    let vertex = |i: usize, j: usize| {
        let theta = std::f32::consts::PI * i as f32 / rings as f32;
        let phi = 2.0 * std::f32::consts::PI * (j % rings) as f32 / rings as f32;
        if i == 0 || i == rings {
            return Vec3::Y * if i == 0 { 1.0 } else { -1.0 };
        }
        let (s, c) = (libm::sinf(theta), libm::cosf(theta));
        Vec3::new(s * libm::cosf(phi), c, s * libm::sinf(phi))
    };
    let mut triangles = Vec::new();
    for i in 0..rings {
        for j in 0..rings {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| vertex(i, j));
            triangles.push(triangle(a, b, c));
            triangles.push(triangle(a, c, d));
        }
    }
    triangles
}

#[test]
fn no_ray_escapes_from_a_sphere() {
    let mut random = Random(3);
    for (scale, offset) in [(1.0, Vec3::ZERO), (1.0e6, Vec3::ZERO), (1.0e-3, Vec3::new(10.0, -3.0, 1.0))] {
        let triangles = moved(&scaled(&sphere(60), scale), offset);
        let flags = vec![PrimitiveFlags::default(); triangles.len()];
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
    let flags = vec![PrimitiveFlags::default(); triangles.len()];
    for builder in HIERARCHIES {
        let bvh = build(&triangles, &flags, &settings(builder, Split::Off, SimdLevel::best()));
        bvh.validate(&triangles, &flags).unwrap();
        // Equal codes are split by the bits of their places, and identical boxes merge in pairs: about ceil(log2(10⁶))
        // levels either way, 20. Chunks, of which the last is smaller, may add a few.
        assert!((20..=24).contains(&bvh.statistics().depth), "{builder:?} {}", bvh.statistics().depth);
        let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
        let hit = bvh.closest_hit(&ray, None, |_| true, &mut TraversalCounters::default()).unwrap();
        assert_eq!((hit.primitive, hit.t), (0, 1.0));
    }
}

#[test]
fn chains_and_nested_boxes_build_a_shallow_tree() {
    // Boxes around one centre, and boxes in a row, that grow by a factor: every one is nearest to the next smaller one.
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
        let flags = vec![PrimitiveFlags::default(); triangles.len()];
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
    let flags = vec![PrimitiveFlags::default(); triangles.len()];
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
    let flags = vec![PrimitiveFlags::default(); triangles.len()];
    let bvh = build(&triangles, &flags, &settings(BuilderKind::Auto, Split::Auto, SimdLevel::best()));
    assert_eq!(bvh.statistics().references, bvh.statistics().triangles);
}

#[test]
fn the_tree_is_named_and_chosen_by_what_rays_are_expected() {
    let triangles = soup(5000, 0.05, &mut Random(6));
    let flags = vec![PrimitiveFlags::default(); triangles.len()];
    for (expected_rays, built) in [(0, BuilderKind::Lbvh), (1 << 30, BuilderKind::Ploc)] {
        let settings = BuildSettings { expected_rays, ..BuildSettings::default() };
        assert_eq!(build(&triangles, &flags, &settings).statistics().built, built);
    }
    for builder in HIERARCHIES {
        let settings = settings(builder, Split::Off, SimdLevel::best());
        assert_eq!(build(&triangles, &flags, &settings).statistics().built, builder);
    }
}

#[test]
fn a_builder_and_a_hierarchy_can_be_used_again() {
    let mut builder = Builder::default();
    let mut last = None;
    for n in [1000, 10, 0, 3000, 1] {
        let triangles = soup(n, 0.1, &mut Random(n as u64));
        let flags = vec![PrimitiveFlags::default(); n];
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
    let flags = [PrimitiveFlags::default(); 10];
    assert!(Builder::default().build(&triangles, &flags, &BuildSettings::default(), &cancel, None).is_err());
}
