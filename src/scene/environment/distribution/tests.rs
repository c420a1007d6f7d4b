use super::super::cell_grid::direction;
use super::*;

/// Points of the unit square: Fibonacci's lattice.
fn points(count: u32) -> impl Iterator<Item = Vec2> {
    (0..count).map(move |i| {
        let x = f64::from(i) * 0.618_033_988_749_894_9;
        Vec2::new((x - x.floor()) as f32, (i as f32 + 0.5) / count as f32)
            .min(Vec2::splat(1.0 - f32::EPSILON / 2.0))
    })
}

/// Directions of equal solid angles.
fn directions(count: u32) -> impl Iterator<Item = Vec3> {
    points(count).map(|p| direction((p.x - 0.5) * TAU, f64::from(1.0 - 2.0 * p.y)))
}

/// A sky that is brighter above, with a sun of a radius of 2.6 degrees. The integral of the sky is 2π, and that of the sun also.
fn sky(d: Vec3) -> f32 {
    0.5 + 0.4 * d.y + sun(d)
}

/// 2000 in the centre, falling linearly in the cosine.
fn sun(d: Vec3) -> f32 {
    2000.0 * (1000.0 * (d.dot(Vec3::new(0.36, 0.48, 0.8)) - 0.999)).max(0.0)
}

/// Several kinds of environments: the poles, one bright cell, hard edges, large and tiny values.
fn environments() -> Vec<EnvironmentDistribution> {
    vec![
        EnvironmentDistribution::of(128, 256, sky),
        EnvironmentDistribution::of(64, 128, |d| if d.y > 0.999 { 50.0 } else { 0.0 }),
        EnvironmentDistribution::of(63, 31, |d| if d.y < -0.999 { 1e30 } else { 1e-20 }),
        EnvironmentDistribution::of(64, 128, |d| if d.x > 0.0 && d.z > 0.0 { 1e-30 } else { 0.0 }),
        EnvironmentDistribution::of(1, 2, |d| 1.0 + d.x),
        EnvironmentDistribution::of(512, 1024, |d| {
            if d.dot(Vec3::X) > 0.999_99 { f32::INFINITY } else { f32::NAN }
        }),
    ]
}

#[test]
fn samples_have_their_directions_density() {
    for (index, environment) in environments().iter().enumerate() {
        for u in points(20_000).chain([Vec2::ZERO, Vec2::splat(1.0 - f32::EPSILON / 2.0)]) {
            let DirectionSample { direction, pdf } = environment.sample(u).unwrap();
            assert!((direction.length() - 1.0).abs() < 1e-6);
            assert!(pdf > 0.0 && pdf.is_finite());
            assert_eq!(environment.pdf(direction), pdf, "environment {index}, {u}, {direction}");
        }
    }
}

#[test]
fn densities_integrate_to_one() {
    for (index, environment) in environments().iter().enumerate() {
        // The cells are the quadrature.
        let (rows, columns) = (environment.row_sums.len() - 1, environment.grid.columns());
        let mut sum = 0.0;
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let cosines = environment.grid.cosines(row);
            let center = environment.grid.direction((row, column), 0.5, 0.5);
            assert_eq!(environment.grid.cell(center), (row, column));
            sum += f64::from(environment.pdf(center)) * cosines * f64::from(TAU) / columns as f64;
        }
        assert!((sum - 1.0).abs() < 1e-4, "environment {index}: {sum}");
    }
    // Directions that know nothing of the cells.
    let count = 1 << 19;
    let environment = EnvironmentDistribution::of(128, 256, sky);
    let sum: f64 = directions(count).map(|d| f64::from(environment.pdf(d))).sum();
    let integral = sum * 4.0 * std::f64::consts::PI / f64::from(count);
    assert!((integral - 1.0).abs() < 0.01, "{integral}");
}

#[test]
fn samples_find_a_small_sun() {
    let environment = EnvironmentDistribution::of(256, 512, sky);
    let count = 1 << 16;
    let (mut sum, mut squares) = (0.0, 0.0);
    for u in points(count) {
        let DirectionSample { direction, pdf } = environment.sample(u).unwrap();
        let value = f64::from(sun(direction) / pdf);
        sum += value;
        squares += value * value;
    }
    let mean = sum / f64::from(count);
    assert!((mean / (2.0 * std::f64::consts::PI) - 1.0).abs() < 0.003, "{mean}");
    // A uniform direction hits the sun once in 2000 times: a variance of more than 2000 squares of the mean.
    let variance = squares / f64::from(count) - mean * mean;
    assert!(variance < 0.2 * mean * mean, "{variance}");
}

#[test]
fn mixed_with_uniform_directions_samples_integrate_the_whole_sky() {
    // Balance heuristic of one sample each.
    let environment = EnvironmentDistribution::of(256, 512, sky);
    let count = 1 << 18;
    let uniform = 1.0 / (4.0 * std::f64::consts::PI);
    let value = |d: Vec3| f64::from(sky(d)) / (f64::from(environment.pdf(d)) + uniform);
    let sampled: f64 = points(count).map(|u| value(environment.sample(u).unwrap().direction)).sum();
    let other: f64 = directions(count).map(value).sum();
    let mean = (sampled + other) / f64::from(count);
    let expected = 4.0 * std::f64::consts::PI;
    assert!((mean / expected - 1.0).abs() < 0.003, "{mean} {expected}");
}

#[test]
fn frequencies_of_cells_are_their_probabilities() {
    let environment = EnvironmentDistribution::of(8, 16, |d| (d.x + 0.5 * d.y).max(0.0));
    let mut counts = [0_u32; 128];
    for u in points(1 << 18) {
        let (row, column) = environment.grid.cell(environment.sample(u).unwrap().direction);
        counts[row * 16 + column] += 1;
    }
    for (index, &count) in counts.iter().enumerate() {
        let (row, column) = (index / 16, index % 16);
        let cosines = environment.grid.cosines(row);
        let probability = f64::from(environment.density(row, column)) * cosines * f64::from(TAU) / 16.0;
        let found = f64::from(count) / f64::from(1 << 18);
        assert!((found - probability).abs() < 5e-4, "{row} {column}: {found} {probability}");
    }
}

#[test]
fn uniform_and_black_environments_leave_all_to_the_bsdf() {
    for radiance in [0.0, 1e-30, 0.3, 1.0, 1e30, f32::NAN, f32::NEG_INFINITY, -1.0] {
        let environment = EnvironmentDistribution::of(37, 71, |_| radiance);
        assert_eq!(environment.sample(Vec2::splat(0.5)), None, "{radiance}");
        assert_eq!(environment.pdf(Vec3::Y), 0.0);
    }
}
