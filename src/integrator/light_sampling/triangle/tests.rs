use super::*;

/// Points of the unit square: Fibonacci's lattice.
fn points(count: u32) -> impl Iterator<Item = Vec2> {
    (0..count).map(move |i| {
        let x = f64::from(i) * 0.618_033_988_749_894_9;
        Vec2::new((x - x.floor()) as f32, (i as f32 + 0.5) / count as f32)
            .min(Vec2::splat(1.0 - f32::EPSILON / 2.0))
    })
}

/// Triangles and the points that see them: large and small, near and far, slivers, at grazing angles, far from the origin.
fn views() -> Vec<([Vec3; 3], Vec3)> {
    let triangle = [Vec3::new(-1.0, 0.2, 3.0), Vec3::new(1.5, -0.4, 2.5), Vec3::new(0.3, 2.0, 3.5)];
    let sliver = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(30.0, 0.0, 2.0), Vec3::new(30.0, 0.001, 2.0)];
    let mut views = vec![
        (triangle, Vec3::ZERO),
        ([triangle[2], triangle[1], triangle[0]], Vec3::ZERO),
        (triangle, Vec3::new(0.2, 0.5, 2.9)),
        (triangle, Vec3::new(0.2, 0.5, 2.99)),
        (triangle, Vec3::new(0.0, 30.0, -50.0)),
        (triangle, Vec3::new(500.0, 0.0, -5000.0)),
        (sliver, Vec3::ZERO),
        (sliver, Vec3::new(15.0, 0.0, 1.4)),
        ([Vec3::X, Vec3::Y, Vec3::Z], Vec3::ZERO),
        // Nearly a hemisphere.
        ([Vec3::new(-9.0, -9.0, 0.2), Vec3::new(9.0, -9.0, 0.2), Vec3::new(0.0, 9.0, 0.2)], Vec3::ZERO),
        // A grazing view.
        ([Vec3::new(1.0, 0.0, 1e-3), Vec3::new(2.0, 0.0, 1e-3), Vec3::new(1.0, 1.0, 1e-3)], Vec3::ZERO),
    ];
    let shift = Vec3::splat(4096.0);
    views.push((triangle.map(|corner| corner + shift), shift));
    views
}

/// The solid angle by subdivision.
fn solid_angle(corners: [DVec3; 3], depth: u32) -> f64 {
    if depth == 0 {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]) * 0.5;
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        return center.dot(normal).abs() / center.length().powi(3);
    }
    let [a, b, c] = corners;
    let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        .map(|part| solid_angle(part, depth - 1))
        .iter()
        .sum()
}

#[test]
fn samples_lie_on_the_triangle_and_have_their_density() {
    for (index, (corners, point)) in views().into_iter().enumerate() {
        for u in points(500).chain([Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::splat(1.0 - f32::EPSILON / 2.0)]) {
            let sample =
                sample_triangle(corners, point, u.min(Vec2::splat(1.0 - f32::EPSILON / 2.0))).unwrap();
            let [b1, b2] = sample.barycentrics;
            assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 + 1e-6, "view {index}: {sample:?}");
            assert!((sample.direction.length() - 1.0).abs() < 1e-6);
            let on_triangle = corners[0] * (1.0 - b1 - b2) + corners[1] * b1 + corners[2] * b2;
            let reached = point + sample.direction * sample.distance;
            let tolerance = 3e-7 * corners.map(|c| c.length() + c.distance(point)).iter().sum::<f32>();
            assert!(on_triangle.distance(reached) < tolerance, "view {index}: {on_triangle} {reached}");
            // The density by area depends on the rounded direction where the view is grazing.
            let pdf = triangle_pdf(corners, point, sample.direction);
            assert!((pdf / sample.pdf - 1.0).abs() < 2e-3, "view {index}: {pdf} {sample:?}");
        }
    }
}

#[test]
fn the_mean_of_one_by_the_density_is_the_solid_angle() {
    for (index, (corners, point)) in views().into_iter().enumerate() {
        let relative = corners.map(|corner| corner.as_dvec3() - point.as_dvec3());
        let expected = solid_angle(relative, 9);
        let count = 4096;
        let values = points(count).map(|u| 1.0 / f64::from(sample_triangle(corners, point, u).unwrap().pdf));
        let found = values.sum::<f64>() / f64::from(count);
        assert!((found / expected - 1.0).abs() < 0.01, "view {index}: {found} {expected}");
    }
}

#[test]
fn parts_of_the_triangle_are_sampled_by_their_solid_angle() {
    // Of the four parts between the middles of the edges, each gets the share of samples that its density asks for.
    for (index, (corners, point)) in views().into_iter().enumerate() {
        let relative = corners.map(|corner| corner.as_dvec3() - point.as_dvec3());
        let [a, b, c] = relative;
        let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
        let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].map(|part| solid_angle(part, 8));
        let whole: f64 = parts.iter().sum();
        let count = 1 << 14;
        let mut sums = [0.0; 4];
        for u in points(count) {
            let sample = sample_triangle(corners, point, u).unwrap();
            let [b1, b2] = sample.barycentrics;
            let part = if b1 + b2 < 0.5 {
                0
            } else if b1 > 0.5 {
                1
            } else if b2 > 0.5 {
                2
            } else {
                3
            };
            sums[part] += 1.0 / f64::from(sample.pdf) / f64::from(count);
        }
        for (part, sum) in parts.iter().zip(sums) {
            assert!((sum - part).abs() < 0.006 * whole, "view {index}: {parts:?} {sums:?}");
        }
    }
}

#[test]
fn densities_of_both_kinds_agree_where_they_change() {
    // A triangle that recedes until it is sampled by area: its density stays continuous.
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mut last: Option<f32> = None;
    for step in 0..400 {
        let distance = 8.0 + step as f32 * 0.1;
        let pdf = triangle_pdf(corners, Vec3::new(0.3, 0.3, distance), Vec3::NEG_Z);
        if let Some(last) = last {
            assert!(pdf > last && pdf / last < 1.04, "{distance}: {last} {pdf}");
        }
        last = Some(pdf);
    }
    assert!((1.0 / f64::from(last.unwrap()) - 0.5 / 47.9_f64.powi(2)).abs() < 1e-6);
}

#[test]
fn triangles_seen_edge_on_and_degenerate_ones_have_no_samples() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    for (corners, point) in [
        (corners, Vec3::new(3.0, -2.0, 0.0)),
        (corners, Vec3::new(0.25, 0.25, 0.0)),
        (corners, Vec3::X),
        ([Vec3::X; 3], Vec3::ZERO),
        ([Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0], Vec3::Y),
        ([Vec3::NAN, Vec3::X, Vec3::Y], Vec3::Z),
        ([Vec3::INFINITY, Vec3::X, Vec3::Y], Vec3::Z),
    ] {
        assert_eq!(sample_triangle(corners, point, Vec2::splat(0.3)), None);
        assert_eq!(triangle_pdf(corners, point, Vec3::Z), 0.0);
    }
}

#[test]
fn extreme_sizes_give_finite_samples() {
    for scale in [1e-18_f32, 1e-6, 1.0, 1e6, 1e17] {
        let corners =
            [Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 1.0)].map(|c| c * scale);
        for u in points(50) {
            let sample = sample_triangle(corners, Vec3::ZERO, u).unwrap();
            assert!(
                sample.direction.is_normalized() && sample.distance.is_finite() && sample.pdf.is_finite()
            );
        }
    }
}
