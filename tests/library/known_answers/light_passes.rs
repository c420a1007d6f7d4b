//! Light by the way it came, and which surfaces cover a pixel.

use glam::{Vec3, Vec4};
use rayframe::film::{AovFlags, LightPass, PixelWindow};
use rayframe::render::PixelFilter;
use rayframe::scene::{AlphaMode, Environment, LightKind, Material, Projection, Transmission};

use crate::stage::{Stage, lambert, rectangle, unlit};

const EYE: Vec3 = Vec3::new(0.0, 0.0, 4.0);

/// An empty stage that records everything.
fn stage() -> Stage {
    let mut stage = Stage::new();
    stage.settings.aovs = AovFlags { light: true, centers: true, coverage: true };
    stage
}

/// A rectangle across the camera's axis that faces it.
fn across(z: f32) -> rayframe::scene::Primitive {
    rectangle(Vec3::Z * z, Vec3::X * 3.0, Vec3::Y * 3.0)
}

fn blended(material: Material, alpha: f32) -> Material {
    let base_color = material.base_color.truncate().extend(alpha);
    Material { base_color, alpha_mode: AlphaMode::Blend, ..material }
}

fn mirror() -> Material {
    Material { base_color: Vec4::ONE, metallic: 1.0, roughness: 0.0, ..Material::default() }
}

/// The camera sees `expected` and nothing else, in sum the colour.
#[expect(clippy::unwrap_used, reason = "the stage records everything")]
#[track_caller]
fn assert_parts(stage: &Stage, eye: Vec3, expected: &[(LightPass, Vec3)]) {
    let film = stage.render(eye, Vec3::ZERO);
    let light = film.aovs.light.unwrap()[0];
    for part in LightPass::ALL {
        let seen = Vec3::from_array(light[part.index()]);
        let told = expected.iter().find(|(other, _)| *other == part).map_or(Vec3::ZERO, |(_, value)| *value);
        assert!(seen.abs_diff_eq(told, 1e-5), "{part:?} is {seen}, not {told}");
    }
    let sum: Vec3 = light.into_iter().map(Vec3::from_array).sum();
    assert!(sum.abs_diff_eq(Vec4::from_array(film.pixels[0]).truncate(), 1e-5));
}

#[test]
fn what_shines_by_itself_is_emission() {
    let color = Vec3::new(0.2, 0.5, 0.9);
    let mut stage = stage();
    stage.add(across(0.0), unlit(color));
    assert_parts(&stage, EYE, &[(LightPass::Emission, color)]);
    let mut stage = self::stage();
    stage.add(across(0.0), Material { emissive: color * 3.0, ..lambert(Vec3::ZERO) });
    assert_parts(&stage, EYE, &[(LightPass::Emission, color * 3.0)]);
}

#[test]
fn a_lamp_on_a_dull_square_is_direct() {
    // π candela two metres away on a white Lambert square: π / 4 / π = 1/4.
    let mut stage = stage();
    stage.add(across(0.0), lambert(Vec3::ONE));
    stage.add_light(LightKind::Point, std::f32::consts::PI, Vec3::Z * 2.0, Vec3::NEG_Z);
    assert_parts(&stage, EYE, &[(LightPass::Direct, Vec3::splat(0.25))]);
}

#[test]
fn the_sky_is_environment_whether_scattered_or_seen() {
    let mut stage = stage();
    stage.environment = Environment::Constant(Vec3::splat(0.5));
    assert_parts(&stage, EYE, &[(LightPass::Environment, Vec3::splat(0.5))]);
    stage.add(across(0.0), lambert(Vec3::new(1.0, 0.5, 0.25)));
    assert_parts(&stage, EYE, &[(LightPass::Environment, Vec3::new(0.5, 0.25, 0.125))]);
}

#[test]
fn everything_in_a_mirror_is_reflection() {
    // Seen at 45° from +X the mirror shows the panel at −X, 45° up; without it, the sky.
    let color = Vec3::new(0.2, 0.5, 0.9);
    let mut stage = stage();
    stage.add(rectangle(Vec3::ZERO, Vec3::Z * 5.0, Vec3::X * 5.0), mirror());
    stage.environment = Environment::Constant(Vec3::splat(0.5));
    let eye = Vec3::new(2.0, 2.0, 0.0);
    assert_parts(&stage, eye, &[(LightPass::Reflection, Vec3::splat(0.5))]);
    stage.add(rectangle(Vec3::new(-2.0, 2.0, 0.0), Vec3::new(0.1, 0.1, 0.0), Vec3::Z * 0.1), unlit(color));
    assert_parts(&stage, eye, &[(LightPass::Reflection, color)]);
}

#[test]
fn what_is_behind_glass_is_refraction() {
    // An index of one reflects nothing and lets all through; behind the wall's see-through half is another one.
    let pane = Material {
        base_color: Vec4::ONE,
        metallic: 0.0,
        roughness: 0.0,
        ior: 1.0,
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        ..Material::default()
    };
    let mut stage = stage();
    stage.add(across(1.0), pane);
    stage.add(across(0.0), blended(unlit(Vec3::ONE), 0.5));
    stage.add(across(-1.0), unlit(Vec3::X));
    assert_parts(&stage, EYE, &[(LightPass::Refraction, Vec3::new(1.0, 0.5, 0.5))]);
}

#[test]
fn whatever_is_behind_a_see_through_pane_passes_through() {
    // The pane has a quarter: of a lit wall, of a mirror that shows the sky, or of the sky itself three quarters are left.
    let pane = || blended(unlit(Vec3::Y), 0.25);
    let front = (LightPass::Emission, Vec3::Y * 0.25);
    let mut open = stage();
    open.environment = Environment::Constant(Vec3::splat(0.5));
    open.add(across(1.0), pane());
    assert_parts(&open, EYE, &[front, (LightPass::Transparency, Vec3::splat(0.375))]);

    let mut before_mirror = stage();
    before_mirror.environment = Environment::Constant(Vec3::splat(0.5));
    before_mirror.add(across(1.0), pane());
    before_mirror.add(across(0.0), mirror());
    // The mirror sees the pane's back, too: a quarter of it and three quarters of the sky.
    let reflected = Vec3::new(0.375, 0.25 + 0.375, 0.375) * 0.75;
    assert_parts(&before_mirror, EYE, &[front, (LightPass::Transparency, reflected)]);

    let mut before_wall = stage();
    before_wall.add(across(1.0), pane());
    before_wall.add(across(0.0), lambert(Vec3::ONE));
    before_wall.add_light(LightKind::Point, std::f32::consts::PI, Vec3::Z * 0.5, Vec3::NEG_Z);
    assert_parts(&before_wall, EYE, &[front, (LightPass::Transparency, Vec3::splat(3.0))]);
}

#[test]
fn a_shadow_catcher_is_not_looked_through() {
    // Nothing stands in the lamp's way: the catcher is not there, and the sky is seen by itself.
    let mut stage = stage();
    stage.environment = Environment::Constant(Vec3::splat(0.5));
    stage.add(across(0.0), Material { is_shadow_catcher: true, ..lambert(Vec3::ONE) });
    stage.add_light(LightKind::Point, 1.0, Vec3::Z * 2.0, Vec3::NEG_Z);
    assert_parts(&stage, EYE, &[(LightPass::Environment, Vec3::splat(0.5))]);
    let film = stage.render(EYE, Vec3::ZERO);
    assert_eq!(film.aovs.coverage, Some(vec![vec![]]));
    assert_eq!(film.aovs.centers.unwrap()[0].instance, None);
}

/// Two metres wide parallel rays into one pixel.
fn wide(samples: u32, filter: PixelFilter) -> Stage {
    let mut stage = stage();
    stage.projection = Projection::Orthographic { x_mag: 1.0, y_mag: 1.0, z_near: 0.0, z_far: 9.0 };
    stage.settings.samples = samples;
    stage.settings.filter = filter;
    stage
}

#[expect(clippy::unwrap_used, reason = "the stage records everything")]
fn coverage(stage: &Stage) -> Vec<(u32, f32)> {
    stage.render(EYE, Vec3::ZERO).aovs.coverage.unwrap()[0].clone()
}

#[test]
fn a_surface_over_half_a_pixel_covers_half_of_it() {
    // Four samples, one in each quarter of the width.
    let mut stage = wide(4, PixelFilter::Box);
    stage.add(rectangle(Vec3::X * -5.0, Vec3::X * 5.0, Vec3::Y * 5.0), unlit(Vec3::ONE));
    assert_eq!(coverage(&stage), [(0, 0.5)]);
    stage.add(rectangle(Vec3::new(5.0, 0.0, -1.0), Vec3::X * 6.0, Vec3::Y * 5.0), unlit(Vec3::ONE));
    assert_eq!(coverage(&stage), [(0, 0.5), (1, 0.5)]);
}

#[test]
fn see_through_surfaces_share_with_what_is_behind_them() {
    let mut stage = wide(1, PixelFilter::Box);
    stage.add(across(0.0), unlit(Vec3::ONE));
    stage.add(across(1.0), blended(unlit(Vec3::ONE), 0.25));
    stage.add(across(-1.0), unlit(Vec3::ONE));
    assert_eq!(coverage(&stage), [(0, 0.75), (1, 0.25)]);
    // The middle shows what has at least half.
    let instance = |stage: &Stage| stage.render(EYE, Vec3::ZERO).aovs.centers.unwrap()[0].instance;
    assert_eq!(instance(&stage), Some(0));
    stage.add(across(2.0), blended(unlit(Vec3::ONE), 0.5));
    assert_eq!(instance(&stage), Some(3));
}

#[test]
fn a_filters_negative_lobes_leave_shares_between_none_and_all() {
    // Mitchell's filter is four pixels wide: the strip along one edge of its support lies under a negative lobe.
    let mut stage = wide(256, PixelFilter::Mitchell);
    stage.settings.window = PixelWindow::full(1, 1);
    stage.add(rectangle(Vec3::X * -3.3, Vec3::X * 0.7, Vec3::Y * 9.0), unlit(Vec3::ONE));
    stage.add(rectangle(Vec3::new(3.0, 0.0, -1.0), Vec3::X * 5.6, Vec3::Y * 9.0), unlit(Vec3::ONE));
    assert_eq!(coverage(&stage), [(1, 1.0)]);
}
