use super::*;

/// Asserts that every elementary interval of area 1 / count holds one point, for all shapes of intervals.
fn assert_net(points: &[Vec2]) {
    let log2 = points.len().ilog2();
    assert_eq!(points.len(), 1 << log2);
    for across in 0..=log2 {
        let (columns, rows) = (1 << across, 1 << (log2 - across));
        let mut is_filled = vec![false; points.len()];
        for point in points {
            assert!(point.min_element() >= 0.0 && point.max_element() < 1.0);
            let cell = (point.y * rows as f32) as usize * columns + (point.x * columns as f32) as usize;
            assert!(!is_filled[cell], "two points of {} in one of {columns} x {rows} cells", points.len());
            is_filled[cell] = true;
        }
    }
}

fn pixel_points(sampler: &ZSobol, pixel: (u32, u32), count: u32, dimension: u32) -> Vec<Vec2> {
    (0..count).map(|sample| sampler.sequence(pixel, sample).point(dimension)).collect()
}

fn block_points(sampler: &ZSobol, corner: (u32, u32), size: u32, samples: u32, dimension: u32) -> Vec<Vec2> {
    let pixels = (0..size * size).map(|i| (corner.0 + i % size, corner.1 + i / size));
    pixels.flat_map(|pixel| pixel_points(sampler, pixel, samples, dimension)).collect()
}

#[test]
fn first_powers_of_four_samples_of_a_pixel_are_nets() {
    for seed in 0..4 {
        for max_samples in [256, 1 << 20] {
            let sampler = ZSobol::new(max_samples, seed);
            for dimension in [0, 1, 7, 1000] {
                for count in [1, 4, 16, 64, 256] {
                    assert_net(&pixel_points(&sampler, (65535, 32768 + seed), count, dimension));
                    assert_net(&pixel_points(&sampler, (seed, 13), count, dimension));
                }
            }
        }
    }
}

#[test]
fn all_samples_of_a_pixel_are_a_net_for_every_power_of_two() {
    for max_samples in [1, 2, 4, 8, 32, 128, 512] {
        let sampler = ZSobol::new(max_samples, 5);
        for dimension in 0..8 {
            assert_net(&pixel_points(&sampler, (123, 4567), max_samples, dimension));
        }
    }
}

#[test]
fn aligned_blocks_of_pixels_are_nets() {
    for max_samples in [1, 2, 4, 8] {
        let sampler = ZSobol::new(max_samples, 9);
        for size in [1, 2, 4, 8, 16] {
            for dimension in [0, 5] {
                assert_net(&block_points(&sampler, (0, 0), size, max_samples, dimension));
                assert_net(&block_points(&sampler, (512 + size, 65536 - size), size, max_samples, dimension));
            }
        }
    }
}

#[test]
fn samples_beyond_the_maximum_are_sets_of_their_own() {
    let sampler = ZSobol::new(16, 2);
    let points: Vec<_> = (0..48).map(|sample| sampler.sequence((4, 4), sample).point(0)).collect();
    for set in points.chunks(16) {
        assert_net(set);
    }
    assert_ne!(points[..16], points[16..32]);
    assert_ne!(points[16], ZSobol::new(16, 2).sequence((5, 4), 0).point(0));
}

#[test]
fn numbers_are_stratified_and_known_values_stay() {
    let sampler = ZSobol::new(64, 1);
    let mut cells = [0; 64];
    for sample in 0..64 {
        cells[(sampler.sequence((3, 5), sample).number(4) * 64.0) as usize] += 1;
    }
    assert_eq!(cells, [1; 64]);

    let sequence = sampler.sequence((640, 480), 17);
    assert_eq!(sequence.number(2), sequence.point(2).x);
    let found = [sequence.point(0), sequence.point(1), ZSobol::new(8, 7).sequence((65535, 1), 5).point(3)];
    let expected = [
        Vec2::new(0.9004107, 0.86479163),
        Vec2::new(0.7387944, 0.62641704),
        Vec2::new(0.059061468, 0.39708424),
    ];
    assert_eq!(found, expected);
}

/// Correlation coefficient of two lists of numbers in [0, 1), of mean 1/2 and variance 1/12.
fn correlation(pairs: impl Iterator<Item = (f32, f32)>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for (a, b) in pairs {
        sum += (f64::from(a) - 0.5) * (f64::from(b) - 0.5);
        count += 1;
    }
    12.0 * sum / f64::from(count)
}

#[test]
fn dimensions_and_seeds_are_uncorrelated() {
    // Correlations of 65536 independent pairs have a standard deviation of 0.004.
    let count = 1 << 16;
    for (first, second) in [(0, 1), (0, 2), (1, 2), (3, 1024), (17, 18)] {
        let sampler = ZSobol::new(16, 3);
        let sequences = || (0..count).map(|i| sampler.sequence((i / 16 % 64, i / 1024), i % 16));
        let points = || sequences().map(|s| (s.point(first), s.point(second)));
        for found in [
            correlation(points().map(|(a, b)| (a.x, b.x))),
            correlation(points().map(|(a, b)| (a.x, b.y))),
            correlation(points().map(|(a, b)| (a.y, b.x))),
            correlation(points().map(|(a, b)| (a.y, b.y))),
            correlation(points().map(|(a, _)| (a.x, a.y))),
        ] {
            assert!(found.abs() < 0.016, "{first}, {second}: {found}");
        }
        // The same of a pixel's own four dimensions over independent pixels: the joint distribution has no structure.
        let mut cells = [0_u32; 256];
        for i in 0..count {
            let sequence = sampler.sequence((i % 256, i / 256), 5);
            let (a, b) = (sequence.point(first), sequence.point(second));
            let digit = |x: f32| (x * 4.0) as usize;
            cells[digit(a.x) * 64 + digit(a.y) * 16 + digit(b.x) * 4 + digit(b.y)] += 1;
        }
        // Chi-squared with 255 degrees of freedom exceeds 360 once in 50 000 times; stratified points stay below the mean.
        let chi_squared: f64 = cells.iter().map(|&n| (f64::from(n) - 256.0).powi(2) / 256.0).sum();
        assert!(chi_squared < 360.0, "{first}, {second}: {chi_squared}");
    }
    let (a, b) = (ZSobol::new(4, 0), ZSobol::new(4, 1));
    let pairs = (0..count).map(|i| ((i % 256, i / 256), 0));
    let found = correlation(pairs.map(|(p, s)| (a.sequence(p, s).number(0), b.sequence(p, s).number(0))));
    assert!(found.abs() < 0.016, "{found}");
}

#[test]
fn shuffles_use_all_permutations_of_a_digit() {
    // The permutation of the last digit in 24 000 pixels.
    let mut counts = std::collections::BTreeMap::new();
    let sampler = ZSobol::new(4, 11);
    for i in 0..24_000 {
        let digits: [u64; 4] = std::array::from_fn(|sample| {
            let sequence = sampler.sequence((i % 160, i / 160), sample as u32);
            sequence.shuffled_index(DimensionKeys::new(11, i % 3).shuffle) & 3
        });
        *counts.entry(digits).or_insert(0) += 1;
    }
    // Chances of 1/32 and 3/64.
    assert_eq!(counts.len(), 24);
    assert!(counts.values().all(|count| (650..1250).contains(count)), "{counts:?}");
}

#[test]
fn the_second_dimension_is_pascals_triangle() {
    // Row by row: bit i of the coordinate sums the bits j of the index for which j choose i is odd.
    for index in [1_u64, 0x8000_0000_0000_0000, 0x0123_4567_89AB_CDEF, 0xFFFF_0000_F0F0_3355] {
        let mut expected = 0;
        for i in 0..32_u64 {
            let sum = (0..64).filter(|j| i & j == i).fold(0, |sum, j| sum ^ (index >> j) & 1);
            expected |= (sum as u32) << i;
        }
        assert_eq!(bits_of_second_dimension(index), expected);
    }
}

#[test]
fn the_error_of_a_smooth_integral_falls_with_the_count() {
    // The root mean square error over 256 pixels and four dimensions; ∫ x·eʸ + sin(πx)·y over the unit square.
    let expected = (std::f64::consts::E - 1.0) / 2.0 + std::f64::consts::FRAC_1_PI;
    let integrand = |p: Vec2| {
        let (x, y) = (f64::from(p.x), f64::from(p.y));
        x * libm::exp(y) + libm::sin(std::f64::consts::PI * x) * y
    };
    let error = |samples: u32| {
        let sampler = ZSobol::new(1024, 6);
        let mut sum = 0.0;
        for i in 0..256 {
            for dimension in 0..4 {
                let points = pixel_points(&sampler, (i % 16, i / 16), samples, dimension);
                let mean = points.into_iter().map(integrand).sum::<f64>() / f64::from(samples);
                sum += (mean - expected).powi(2);
            }
        }
        (sum / 1024.0).sqrt()
    };
    let errors = [1, 4, 16, 64, 256].map(error);
    // Independent samples halve the error from count to count, points of scrambled nets make it less than a fifth.
    for pair in errors.windows(2).skip(1) {
        assert!(pair[1] < 0.22 * pair[0], "{errors:?}");
    }
}

#[test]
fn errors_of_neighbouring_pixels_cancel() {
    // The mean over a block of 4 x 4 pixels with one sample each has a far lower error than 16 independent samples.
    let sampler = ZSobol::new(1, 8);
    let error = |block: u32| {
        let points = block_points(&sampler, (block % 64 * 4, block / 64 * 4), 4, 1, 0);
        points.iter().map(|p| f64::from(p.x * p.y)).sum::<f64>() / 16.0 - 0.25
    };
    let variance = (0..1024).map(|block| error(block).powi(2)).sum::<f64>() / 1024.0;
    let independent = (1.0 / 9.0 - 1.0 / 16.0) / 16.0;
    assert!(variance < 0.1 * independent, "{variance} {independent}");
}

#[test]
fn what_coordinates_leave_is_white_noise() {
    let sampler = ZSobol::new(4, 3);
    let count = 1 << 16;
    let found: Vec<(Vec2, f32)> = (0..count)
        .map(|i| {
            let sequence = sampler.sequence((i / 4 % 128, i / 512), i % 4);
            let keys = DimensionKeys::new(sequence.seed(), 6);
            let (point, random) = sequence.point_and_random_by(&keys);
            assert_eq!(point, sequence.point(6));
            (point, random)
        })
        .collect();
    let low = |random: f32| (random * 256.0).fract();
    for correlated in [
        correlation(found.iter().map(|&(point, random)| (point.x, random))),
        correlation(found.iter().map(|&(point, random)| (point.y, random))),
        correlation(found.iter().map(|&(_, random)| (random, low(random)))),
        correlation(found.windows(2).map(|pair| (pair[0].1, pair[1].1))),
    ] {
        assert!(correlated.abs() < 0.016, "{correlated}");
    }
    // Both bytes are uniform: chi-squared with 255 degrees of freedom exceeds 360 once in 50 000 times, and falls below 170 as seldom.
    for byte in [|random: f32| random, |random: f32| (random * 256.0).fract()] {
        let mut counts = [0_u32; 256];
        for &(_, random) in &found {
            counts[(byte(random) * 256.0) as usize] += 1;
        }
        let chi_squared: f64 = counts.iter().map(|&n| (f64::from(n) - 256.0).powi(2) / 256.0).sum();
        assert!((170.0..360.0).contains(&chi_squared), "{chi_squared}");
    }
}
