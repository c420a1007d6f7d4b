use super::*;

fn map(width: u32, height: u32, pixels: Vec<[f32; 3]>, rotation: f32) -> Result<EnvironmentMap> {
    let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
    EnvironmentMap::new(Path::new("sky.hdr"), image, rotation)
}

/// Red in the middle half (around −Z), green elsewhere.
fn two_halves(rotation: f32) -> EnvironmentMap {
    let pixels = (0..32 * 64)
        .map(|index| if (16..48).contains(&(index % 64)) { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] })
        .collect();
    map(64, 32, pixels, rotation).unwrap()
}

#[test]
fn rotation_is_counter_clockwise_from_above() {
    let straight = two_halves(0.0);
    assert_eq!(straight.radiance(Vec3::NEG_Z), Vec3::X);
    assert_eq!(straight.radiance(Vec3::Z), Vec3::Y);
    // Seen from above, 90° counter-clockwise takes −Z (up on the page) to −X (left).
    let rotated = two_halves(450.0);
    assert_eq!(rotated.radiance(Vec3::NEG_X), Vec3::X);
    assert_eq!(rotated.radiance(Vec3::X), Vec3::Y);
    assert!((rotated.irradiance(Vec3::NEG_X) - straight.irradiance(Vec3::NEG_Z)).length() < 1e-5);
    let rough = two_halves(-90.0).prefiltered(Vec3::X, 0.5);
    assert!(rough.x > 0.85 && rough.x + rough.y < 1.0001, "{rough}");
}

#[test]
fn a_lit_hemisphere_gives_its_share_of_irradiance() {
    // A horizontal normal towards the lit hemisphere receives π, one away from it 0, one upwards half.
    let map = two_halves(0.0);
    let pi = std::f32::consts::PI;
    assert!((map.irradiance(Vec3::NEG_Z).x - pi).abs() < 0.02);
    assert!(map.irradiance(Vec3::Z).x < 0.02);
    assert!((map.irradiance(Vec3::Y).x - pi / 2.0).abs() < 0.08);
}

#[test]
fn roughness_moves_smoothly_from_the_image_to_the_mean() {
    let map = two_halves(0.0);
    let direction = Vec3::new(0.97, 0.1, -0.2).normalize();
    assert_eq!(map.prefiltered(direction, 0.0), map.radiance(direction));
    let mut last = map.prefiltered(direction, 0.0);
    for step in 1..=1000 {
        let next = map.prefiltered(direction, step as f32 / 1000.0);
        assert!((next - last).abs().max_element() < 0.01);
        last = next;
    }
}

#[test]
fn tiny_and_odd_images_work() {
    for (width, height) in [(1, 1), (3, 7), (65, 33)] {
        let pixels = vec![[0.25, 0.5, 1.0]; (width * height) as usize];
        let map = map(width, height, pixels, 12.0).unwrap();
        for direction in [Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.0, 0.8)] {
            let mean = Vec3::new(0.25, 0.5, 1.0);
            assert!((map.radiance(direction) - mean).abs().max_element() < 1e-5);
            assert!((map.prefiltered(direction, 0.3) - mean).abs().max_element() < 1e-5);
            assert!((map.irradiance(direction) / std::f32::consts::PI - mean).abs().max_element() < 1e-4);
        }
    }
}

#[test]
fn bad_images_are_refused_and_negative_values_become_zero() {
    assert!(matches!(map(0, 4, vec![], 0.0), Err(Error::Invalid { .. })));
    assert!(matches!(map(2, 2, vec![[0.0; 3]; 3], 0.0), Err(Error::Invalid { .. })));
    assert!(matches!(map(1 << 20, 1 << 20, vec![], 0.0), Err(Error::Refused { .. })));
    assert!(matches!(map(1, 1, vec![[1.0; 3]], f32::NAN), Err(Error::Usage { .. })));
    for bad in [f32::NAN, f32::INFINITY, 1e35] {
        let message = map(2, 1, vec![[0.0; 3], [0.0, bad, 0.0]], 0.0).unwrap_err().to_string();
        assert!(message.contains("(1, 0)") && message.contains("sky.hdr"), "{message}");
    }
    let dark = map(2, 1, vec![[-1.0, 0.0, 0.0], [0.0; 3]], 0.0).unwrap();
    assert!(!dark.is_lit());
    assert_eq!(dark.radiance(Vec3::X), Vec3::ZERO);
    let blinding = map(2, 1, vec![[1e30; 3]; 2], 0.0).unwrap();
    assert!(blinding.irradiance(Vec3::Y).is_finite() && blinding.prefiltered(Vec3::Y, 1.0).is_finite());
}

#[test]
fn lookups_do_not_depend_on_threads() {
    let pixels: Vec<[f32; 3]> = (0..64 * 32).map(|index| [((index * 7919) % 101) as f32, 1.0, 0.5]).collect();
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| map(64, 32, pixels.clone(), 30.0)).unwrap()
    };
    let (one, three) = (build(1), build(3));
    assert_eq!(one.tables.irradiance, three.tables.irradiance);
    assert_eq!(one.tables.prefiltered, three.tables.prefiltered);
}

#[test]
fn densities_cover_the_edge_of_a_sun_at_any_size() {
    const STEPS: i32 = 400;
    // A hard disk of 0.35°; between its texels and their neighbours lookups fall off over a texel.
    let toward = Vec3::new(0.36, 0.48, 0.8);
    for height in [256, 512, 700, 1023, 1024, 1100, 1500] {
        let image = EquirectImage::of(2 * height, |direction| {
            let is_sun = direction.cross(toward).length() < 0.0061;
            Vec3::splat(if is_sun && direction.dot(toward) > 0.0 { 20_000.0 } else { 0.3 })
        });
        let distribution = distribution(&image);
        let [side, up] = [toward.any_orthonormal_vector(), toward.cross(toward.any_orthonormal_vector())];
        let (mut light, mut missed, mut second_moment) = (0.0, 0.0, 0.0);
        for index in 0..STEPS * STEPS {
            let offset = |index: i32| 0.02 * (2.0 * (index as f32 + 0.5) / STEPS as f32 - 1.0);
            let direction = toward + side * offset(index % STEPS) + up * offset(index / STEPS);
            let direction = direction.normalize();
            let radiance = f64::from(luminance(image.bilinear(uv_from_direction(direction)))) - 0.3;
            let pdf = f64::from(distribution.pdf(direction));
            light += radiance;
            if pdf > 0.0 {
                second_moment += radiance * radiance / pdf;
            } else if radiance > 3.0 {
                missed += radiance;
            }
        }
        // One sample's variance over the squared mean, plus one
        let solid_angle = f64::from(0.04 / STEPS as f32).powi(2);
        let noise = second_moment / (light * light * solid_angle);
        assert!(missed < 1e-3 * light, "{height} rows: {}", missed / light);
        assert!(noise < 2.5, "{height} rows: {noise}");
    }
}
