use super::*;
use crate::geometry::spiral_direction;
use crate::scene::{BuiltInLight, Environment, EnvironmentImage, EnvironmentMap};

fn points(count: u32) -> impl Iterator<Item = Vec2> {
    (0..count).map(move |i| {
        let x = f64::from(i) * 0.618_033_988_749_894_9;
        Vec2::new((x - x.floor()) as f32, (i as f32 + 0.5) / count as f32)
    })
}

/// The radiance of a turned image with a bright column, and built-in and constant lights.
fn environments() -> Vec<Environment> {
    let (width, height) = (24, 12);
    let pixel = |index: u32| [(index % 7) as f32 * if index % width == 3 { 100.0 } else { 0.1 }; 3];
    let pixels = (0..width * height).map(pixel).collect();
    let image = EnvironmentImage { width, height, pixels, content_hash: [0; 32] };
    vec![
        Environment::Constant(Vec3::new(0.0, 0.5, 2.0)),
        Environment::BuiltIn(BuiltInLight::Outdoor),
        Environment::Map(EnvironmentMap::new(std::path::Path::new("sky.hdr"), image, 77.0).unwrap()),
    ]
}

#[test]
fn samples_are_found_in_their_sector_with_their_density() {
    for environment in environments() {
        let sectors = environment.sectors().unwrap();
        let power: f32 = sectors.powers().iter().sum();
        assert!((power - 1.0).abs() < 1e-5, "{power}");
        let mut moved = 0;
        for sector in (0..SECTORS).filter(|&sector| sectors.powers()[sector] > 0.0) {
            for u in points(37).chain([Vec2::ZERO, Vec2::splat(1.0 - f32::EPSILON / 2.0)]) {
                let DirectionSample { direction, pdf } = sectors.sample(sector, u);
                assert!((direction.length() - 1.0).abs() < 1e-6 && pdf > 0.0 && pdf.is_finite());
                let (found, density) = sectors.find(direction);
                moved += u32::from((found, density) != (sector, pdf));
            }
        }
        // A turned direction is rounded twice, and may be in the next cell.
        let limit = if matches!(environment, Environment::Map(_)) { SECTORS as u32 / 5 } else { 0 };
        assert!(moved <= limit, "{moved}");
    }
}

#[test]
fn densities_follow_the_radiance() {
    // Σ over all sectors of power · density is proportional to the radiance, and integrates to 1.
    for environment in environments() {
        let sectors = environment.sectors().unwrap();
        let count = 1 << 16;
        let (mut density, mut light) = (0.0, 0.0);
        let mut sums = [0.0; 3];
        for index in 0..count {
            let direction = spiral_direction(index, count);
            let (sector, in_sector) = sectors.find(direction);
            let pdf = f64::from(sectors.powers()[sector] * in_sector);
            let radiance = f64::from(crate::color::luminance(environment.radiance(direction)));
            density += pdf;
            light += radiance;
            for (sum, value) in sums.iter_mut().zip([pdf * pdf, pdf * radiance, radiance * radiance]) {
                *sum += value;
            }
        }
        let integral = density * 4.0 * std::f64::consts::PI / f64::from(count);
        assert!((integral - 1.0).abs() < 0.01, "{integral}");
        assert!(light > 0.0);
        let correlation = sums[1] / (sums[0] * sums[2]).sqrt();
        assert!(correlation > 0.97, "{correlation}");
    }
}

#[test]
fn darkness_has_no_sectors() {
    assert!(Environment::None.sectors().is_none());
    assert!(Environment::Constant(Vec3::ZERO).sectors().is_none());
    assert!(SectorTables::new(&[0.0; SECTORS]).is_none());
}

#[test]
fn intervals_hold_their_numbers() {
    let sums = [0.0, 0.0, 0.25, 0.25, 1.0, 1.0];
    assert_eq!(interval(&sums, 0.0), (1, 0.0));
    assert_eq!(interval(&sums, 0.125), (1, 0.5));
    assert_eq!(interval(&sums, 0.25), (3, 0.0));
    assert_eq!(interval(&sums, 0.625), (3, 0.5));
}
