//! Tests of refitting against rebuilding.

use super::*;
use crate::bvh::hierarchy::Structure;
use crate::bvh::{BuildKind, Builder, Bvh, Hit, Split, TraversalCounters};
use crate::cancel::CancelFlag;
use crate::geometry::Ray;

const ROWS: usize = 40;

/// Sheet twisted about the vertical axis.
fn sheet(twist: f32) -> Vec<Triangle> {
    let corner = |i: usize, j: usize| {
        let (u, v) = (i as f32 / ROWS as f32 - 0.5, j as f32 / ROWS as f32 - 0.5);
        let (sin, cos) = (libm::sinf(twist * v), libm::cosf(twist * v));
        Vec3::new(u * cos, v, u * sin + 0.1 * v * v)
    };
    let quads = (0..ROWS).flat_map(|i| (0..ROWS).map(move |j| (i, j)));
    let triangles = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [Triangle { vertices: [a, b, c] }, Triangle { vertices: [a, c, d] }]
    });
    triangles.collect()
}

/// Triangles of the sheet in another order.
fn scrambled(seed: usize) -> Vec<Triangle> {
    let sheet = sheet(0.0);
    // 1009 is a prime that does not divide the count, so that every triangle is taken once.
    (0..sheet.len()).map(|i| sheet[(i * 1009 + seed) % sheet.len()]).collect()
}

fn settings(refit: Refit) -> BuildSettings {
    BuildSettings { split: Split::Off, refit, ..BuildSettings::default() }
}

fn build(
    triangles: &[Triangle],
    flags: &[TriangleFlags],
    settings: &BuildSettings,
    last: Option<Bvh>,
) -> Bvh {
    let bvh = Builder::default().build(triangles, flags, settings, &CancelFlag::new(), last).unwrap();
    bvh.validate(triangles, flags).unwrap();
    bvh
}

fn plain(triangles: &[Triangle]) -> Vec<TriangleFlags> {
    vec![TriangleFlags::default(); triangles.len()]
}

fn build_kinds(frames: &[Vec<Triangle>], settings: &BuildSettings) -> Vec<BuildKind> {
    let mut last = None;
    let step = |triangles: &Vec<Triangle>| {
        let bvh = build(triangles, &plain(triangles), settings, last.take());
        let kind = bvh.statistics().kind;
        last = Some(bvh);
        kind
    };
    frames.iter().map(step).collect()
}

fn hits(bvh: &Bvh) -> Vec<Option<Hit>> {
    let target = |i: i32| Vec3::new((i % 31) as f32 / 31.0 - 0.5, (i % 37) as f32 / 37.0 - 0.5, 0.0);
    let rays = (0..500).map(|i| {
        let origin = Vec3::new((i % 7) as f32 - 3.0, (i % 5) as f32 - 2.0, 2.0);
        Ray::new(origin, target(i) - origin)
    });
    let mut counters = TraversalCounters::default();
    rays.map(|ray| bvh.closest_hit(&ray, None, |_| true, &mut counters)).collect()
}

fn tree(bvh: &Bvh) -> &WideTree {
    match &bvh.structure {
        Structure::Wide(tree) => tree,
        Structure::BruteForce(_) => panic!("no tree"),
    }
}

/// Areas of all boxes over that of the root, summed in the order of memory.
fn plain_cost(tree: &WideTree) -> f64 {
    let lanes = tree.nodes.iter().flat_map(|node| (0..WIDTH).map(|lane| node.bounds(lane)));
    let root = (0..WIDTH).fold(Aabb::EMPTY, |all, lane| all.union(tree.nodes[0].bounds(lane)));
    1.0 + lanes.map(|bounds| bounds.area()).sum::<f64>() / root.area()
}

#[test]
fn every_builders_tree_can_be_refitted() {
    for builder in [BuilderKind::Auto, BuilderKind::Lbvh, BuilderKind::Karras, BuilderKind::Ploc] {
        let always = BuildSettings { builder, ..settings(Refit::UpTo(f32::INFINITY)) };
        let frames = [sheet(0.0), sheet(0.3)];
        let first = build(&frames[0], &plain(&frames[0]), &always, None);
        let second = build(&frames[1], &plain(&frames[1]), &always, Some(first));
        assert!(matches!(second.statistics().kind, BuildKind::Refitted { .. }), "{builder:?}");
    }
}

#[test]
fn a_refitted_tree_gives_the_hits_of_a_new_one_bit_for_bit() {
    let always = settings(Refit::UpTo(f32::INFINITY));
    let mut last = None;
    for step in 0..8 {
        let triangles = sheet(step as f32 * 0.7);
        let flags = plain(&triangles);
        let refitted = build(&triangles, &flags, &always, last.take());
        assert_eq!(matches!(refitted.statistics().kind, BuildKind::Refitted { .. }), step > 0);
        let built = build(&triangles, &flags, &settings(Refit::Off), None);
        assert_eq!(built.statistics().kind, BuildKind::Built(RebuildReason::RefittingOff));
        let expected = hits(&built);
        assert_eq!(hits(&refitted), expected);
        assert!(expected.iter().flatten().count() > 50);
        last = Some(refitted);
    }
}

#[test]
fn cost_is_the_sum_over_all_boxes_for_any_number_of_threads() {
    let frames = [sheet(0.0), sheet(0.5), sheet(2.0)];
    let always = settings(Refit::UpTo(f32::INFINITY));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| build_kinds(&frames, &always))
    };
    let expected = run(1);
    assert!([2, 8].into_iter().all(|threads| run(threads) == expected));

    let first = build(&frames[0], &plain(&frames[0]), &always, None);
    let built_cost = plain_cost(tree(&first));
    let refitted = build(&frames[2], &plain(&frames[2]), &always, Some(first));
    let BuildKind::Refitted { cost_ratio: factor } = refitted.statistics().kind else {
        panic!("not refitted")
    };
    let expected = plain_cost(tree(&refitted)) / built_cost;
    assert!((f64::from(factor) / expected - 1.0).abs() < 1.0e-5, "{factor} is not {expected}");
    assert!(factor > 1.05);
}

#[test]
fn scrambled_triangles_are_rebuilt_with_growing_pauses() {
    let frames: Vec<_> = (0..8).map(scrambled).collect();
    let reasons = [
        RebuildReason::NoPreviousTree,
        RebuildReason::CostRatioTooHigh,
        RebuildReason::CostRatioTooHigh,
        RebuildReason::Pausing,
        RebuildReason::CostRatioTooHigh,
        RebuildReason::Pausing,
        RebuildReason::Pausing,
        RebuildReason::CostRatioTooHigh,
    ];
    assert_eq!(build_kinds(&frames, &settings(Refit::UpTo(1.5))), reasons.map(BuildKind::Built));
    // The same triangles with little movement are refitted.
    let gentle: Vec<_> = (0..4).map(|i| sheet(i as f32 * 0.05)).collect();
    let gentle = build_kinds(&gentle, &settings(Refit::UpTo(1.5)));
    assert!(gentle[1..].iter().all(|kind| matches!(kind, BuildKind::Refitted { .. })), "{gentle:?}");
}

#[test]
fn cost_ratio_is_relative_to_the_best_frame() {
    // Shrinking triangles make the tree better than when it was built. Growing again is detected at once.
    let shrunk = |scale: f32| -> Vec<Triangle> {
        let shrink = |t: &Triangle| {
            let center = (t.vertices[0] + t.vertices[1] + t.vertices[2]) / 3.0;
            Triangle { vertices: t.vertices.map(|p| center + (p - center) * scale) }
        };
        sheet(0.0).iter().map(shrink).collect()
    };
    let frames = [shrunk(1.0), shrunk(0.3), shrunk(1.0)];
    let kinds = build_kinds(&frames, &settings(Refit::UpTo(1.01)));
    assert!(matches!(kinds[1], BuildKind::Refitted { cost_ratio: factor } if factor < 1.0), "{kinds:?}");
    assert_eq!(kinds[2], BuildKind::Built(RebuildReason::CostRatioTooHigh));
}

#[test]
fn other_triangles_are_rebuilt() {
    let always = settings(Refit::UpTo(f32::INFINITY));
    let whole = sheet(0.0);
    let mut flat = sheet(0.1);
    flat[70].vertices[2] = flat[70].vertices[0];
    let mut flags = plain(&whole);
    flags[9] = TriangleFlags::HIDDEN;
    let other = BuildKind::Built(RebuildReason::OtherTriangles);

    // A triangle loses its area, has none while others move, and gets it back; one is hidden; one is removed.
    let bvh = build(&whole, &plain(&whole), &always, None);
    let bvh = build(&flat, &plain(&flat), &always, Some(bvh));
    assert_eq!(bvh.statistics().kind, other);
    flat[500].vertices[0].x += 0.01;
    let bvh = build(&flat, &plain(&flat), &always, Some(bvh));
    assert!(matches!(bvh.statistics().kind, BuildKind::Refitted { .. }));
    let bvh = build(&whole, &plain(&whole), &always, Some(bvh));
    assert_eq!(bvh.statistics().kind, other);
    let bvh = build(&whole, &flags, &always, Some(bvh));
    assert_eq!(bvh.statistics().kind, other);
    // The same number of traced triangles, but the last one is removed.
    let fewer = whole.len() - 1;
    let bvh = build(&whole[..fewer], &plain(&whole)[..fewer], &always, Some(bvh));
    assert_eq!(bvh.statistics().kind, other);
    let bvh = build(&[], &[], &always, Some(bvh));
    assert_eq!(bvh.statistics().triangles, 0);
    assert_eq!(
        build(&whole, &flags, &always, Some(bvh)).statistics().kind,
        BuildKind::Built(RebuildReason::NoPreviousTree)
    );
}

#[test]
fn split_triangles_are_refitted_in_parts() {
    let split = BuildSettings { split: Split::Area(0.0002), ..settings(Refit::UpTo(f32::INFINITY)) };
    let mut last = None;
    for step in 0..4 {
        let triangles = sheet(step as f32 * 0.1);
        let flags = plain(&triangles);
        let bvh = build(&triangles, &flags, &split, last.take());
        let statistics = bvh.statistics();
        assert!(statistics.references > 2 * statistics.triangles, "{statistics:?}");
        match statistics.kind {
            // Boxes around whole triangles would cost far more.
            BuildKind::Refitted { cost_ratio } => assert!(step > 0 && cost_ratio < 1.2, "{cost_ratio}"),
            BuildKind::Built(_) => assert_eq!(step, 0),
        }
        assert_eq!(hits(&bvh), hits(&build(&triangles, &flags, &settings(Refit::Off), None)));
        last = Some(bvh);
    }
    // Building them anew takes less time.
    let auto = BuildSettings { refit: Refit::Auto, ..split };
    let kinds = build_kinds(&[sheet(0.0), sheet(0.1)], &auto);
    assert_eq!(kinds[1], BuildKind::Built(RebuildReason::SplitTriangles));
}

#[test]
fn refitting_updates_flags() {
    let always = settings(Refit::UpTo(f32::INFINITY));
    // Every second triangle shows its back.
    let mut triangles = sheet(0.0);
    triangles.iter_mut().step_by(2).for_each(|triangle| triangle.vertices.swap(1, 2));
    let single_sided = vec![TriangleFlags::SINGLE_SIDED; triangles.len()];
    let bvh = build(&triangles, &plain(&triangles), &always, None);
    let seen = hits(&bvh).iter().flatten().count();
    let bvh = build(&triangles, &single_sided, &always, Some(bvh));
    assert!(matches!(bvh.statistics().kind, BuildKind::Refitted { .. }));
    let expected = hits(&build(&triangles, &single_sided, &settings(Refit::Off), None));
    assert_eq!(hits(&bvh), expected);
    assert_ne!(expected.iter().flatten().count(), seen);
}

#[test]
fn max_cost_depends_on_the_number_of_rays() {
    // 1000 triangles save 30 µs; at 12 ns a step that is 2500 steps, 25 for each of 100 rays.
    let with_rays = |expected_rays| BuildSettings { expected_rays, ..settings(Refit::Auto) };
    // Of a clustered tree they save 90 µs: 7500 steps, 75 for each.
    let of = |builder| BuildStatistics { builder, references: 1000, ..BuildStatistics::default() };
    assert_eq!(max_cost(10.0, &of(BuilderKind::Lbvh), &with_rays(100)), 35.0);
    assert_eq!(max_cost(10.0, &of(BuilderKind::Ploc), &with_rays(100)), 85.0);
    let frames = [sheet(0.0), sheet(1.0)];
    assert!(matches!(build_kinds(&frames, &with_rays(1000))[1], BuildKind::Refitted { .. }));
    assert_eq!(
        build_kinds(&frames, &with_rays(10_000_000))[1],
        BuildKind::Built(RebuildReason::CostRatioTooHigh)
    );
}
