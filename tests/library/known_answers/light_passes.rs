//! Light passes, and the coverage of pixels by surfaces.

use glam::{Vec3, Vec4};
use rayframe::film::{AovFlags, LightPass, PixelWindow};
use rayframe::render::{Integrator, PixelFilter};
use rayframe::scene::{AlphaMode, Environment, LightKind, Material, Projection, Transmission};

use crate::stage::{Stage, lambert, rectangle, unlit};

const EYE: Vec3 = Vec3::new(0.0, 0.0, 4.0);

/// An empty stage with all AOV flags.
fn stage() -> Stage {
    let mut stage = Stage::new();
    stage.settings.aovs = AovFlags { light: true, centers: true, coverage: true, ..AovFlags::NONE };
    stage
}

/// A rectangle perpendicular to the camera's axis that faces the camera.
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

/// Asserts that the light passes in `expected` have these values, all others are black, and the sum is the colour.
#[expect(clippy::unwrap_used, reason = "the stage records everything")]
#[track_caller]
fn assert_passes(stage: &Stage, eye: Vec3, expected: &[(LightPass, Vec3)]) {
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
fn emitted_light_is_emission() {
    let color = Vec3::new(0.2, 0.5, 0.9);
    let mut stage = stage();
    stage.add(across(0.0), unlit(color));
    assert_passes(&stage, EYE, &[(LightPass::Emission, color)]);
    let mut stage = self::stage();
    stage.add(across(0.0), Material { emissive: color * 3.0, ..lambert(Vec3::ZERO) });
    assert_passes(&stage, EYE, &[(LightPass::Emission, color * 3.0)]);
}

#[test]
fn a_light_on_a_diffuse_square_is_direct() {
    // π candela two metres away on a white Lambert square: π / 4 / π = 1/4.
    let mut stage = stage();
    stage.add(across(0.0), lambert(Vec3::ONE));
    stage.add_light(LightKind::Point, std::f32::consts::PI, Vec3::Z * 2.0, Vec3::NEG_Z);
    assert_passes(&stage, EYE, &[(LightPass::Direct, Vec3::splat(0.25))]);
}

#[test]
fn the_sky_is_environment_whether_scattered_or_directly_visible() {
    let mut stage = stage();
    stage.environment = Environment::Constant(Vec3::splat(0.5));
    assert_passes(&stage, EYE, &[(LightPass::Environment, Vec3::splat(0.5))]);
    stage.add(across(0.0), lambert(Vec3::new(1.0, 0.5, 0.25)));
    assert_passes(&stage, EYE, &[(LightPass::Environment, Vec3::new(0.5, 0.25, 0.125))]);
}

#[test]
fn everything_in_a_mirror_is_reflection() {
    // Seen at 45° from +X the mirror shows the panel at −X, 45° up; without it, the sky.
    let color = Vec3::new(0.2, 0.5, 0.9);
    let mut stage = stage();
    stage.add(rectangle(Vec3::ZERO, Vec3::Z * 5.0, Vec3::X * 5.0), mirror());
    stage.environment = Environment::Constant(Vec3::splat(0.5));
    let eye = Vec3::new(2.0, 2.0, 0.0);
    assert_passes(&stage, eye, &[(LightPass::Reflection, Vec3::splat(0.5))]);
    stage.add(rectangle(Vec3::new(-2.0, 2.0, 0.0), Vec3::new(0.1, 0.1, 0.0), Vec3::Z * 0.1), unlit(color));
    assert_passes(&stage, eye, &[(LightPass::Reflection, color)]);
}

#[test]
fn light_through_glass_is_refraction() {
    // An index of one reflects nothing and transmits all. Behind the transparent half of the wall is another wall.
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
    assert_passes(&stage, EYE, &[(LightPass::Refraction, Vec3::new(1.0, 0.5, 0.5))]);
}

#[test]
fn light_through_a_transparent_pane_is_a_transparent_hit() {
    // The pane has an opacity of 1/4: of a lit wall, a mirror that shows the sky, or the sky itself, 3/4 remain.
    let pane = || blended(unlit(Vec3::Y), 0.25);
    let front = (LightPass::Emission, Vec3::Y * 0.25);
    let mut open = stage();
    open.environment = Environment::Constant(Vec3::splat(0.5));
    open.add(across(1.0), pane());
    assert_passes(&open, EYE, &[front, (LightPass::Transparency, Vec3::splat(0.375))]);

    let mut before_mirror = stage();
    before_mirror.environment = Environment::Constant(Vec3::splat(0.5));
    before_mirror.add(across(1.0), pane());
    before_mirror.add(across(0.0), mirror());
    // The mirror also reflects the back of the pane: 1/4 of it and 3/4 of the sky.
    let reflected = Vec3::new(0.375, 0.25 + 0.375, 0.375) * 0.75;
    assert_passes(&before_mirror, EYE, &[front, (LightPass::Transparency, reflected)]);

    let mut before_wall = stage();
    before_wall.add(across(1.0), pane());
    before_wall.add(across(0.0), lambert(Vec3::ONE));
    before_wall.add_light(LightKind::Point, std::f32::consts::PI, Vec3::Z * 0.5, Vec3::NEG_Z);
    assert_passes(&before_wall, EYE, &[front, (LightPass::Transparency, Vec3::splat(3.0))]);
}

#[test]
fn light_through_a_shadow_catcher_is_not_a_transparent_hit() {
    // Nothing occludes the light: the catcher is invisible, and the sky is directly visible.
    let mut stage = stage();
    stage.environment = Environment::Constant(Vec3::splat(0.5));
    stage.add(across(0.0), Material { is_shadow_catcher: true, ..lambert(Vec3::ONE) });
    stage.add_light(LightKind::Point, 1.0, Vec3::Z * 2.0, Vec3::NEG_Z);
    assert_passes(&stage, EYE, &[(LightPass::Environment, Vec3::splat(0.5))]);
    let film = stage.render(EYE, Vec3::ZERO);
    assert_eq!(film.aovs.coverage, Some(vec![vec![]]));
    assert_eq!(film.aovs.centers.unwrap()[0].instance, None);
}

/// One pixel of parallel rays, two metres wide.
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
fn transparent_surfaces_share_coverage_with_surfaces_behind_them() {
    let mut stage = wide(1, PixelFilter::Box);
    stage.add(across(0.0), unlit(Vec3::ONE));
    stage.add(across(1.0), blended(unlit(Vec3::ONE), 0.25));
    stage.add(across(-1.0), unlit(Vec3::ONE));
    assert_eq!(coverage(&stage), [(0, 0.75), (1, 0.25)]);
    // The pixel-centre sample is the surface with at least half of the coverage.
    let instance = |stage: &Stage| stage.render(EYE, Vec3::ZERO).aovs.centers.unwrap()[0].instance;
    assert_eq!(instance(&stage), Some(0));
    stage.add(across(2.0), blended(unlit(Vec3::ONE), 0.5));
    assert_eq!(instance(&stage), Some(3));
}

#[test]
fn negative_filter_lobes_keep_coverage_between_zero_and_one() {
    // Mitchell's filter is four pixels wide: the strip along one edge of its support lies under a negative lobe.
    let mut stage = wide(256, PixelFilter::Mitchell);
    stage.settings.window = PixelWindow::full(1, 1);
    stage.add(rectangle(Vec3::X * -3.3, Vec3::X * 0.7, Vec3::Y * 9.0), unlit(Vec3::ONE));
    stage.add(rectangle(Vec3::new(3.0, 0.0, -1.0), Vec3::X * 5.6, Vec3::Y * 9.0), unlit(Vec3::ONE));
    assert_eq!(coverage(&stage), [(1, 1.0)]);
}

#[test]
fn light_of_the_sky_behind_a_clear_wall_is_environment_however_a_path_finds_it() {
    // A wall of index 1 stands between a diffuse square and the sky, beside the camera.
    for has_wall in [false, true] {
        let mut stage = stage();
        stage.settings.integrator = Integrator::Path;
        stage.settings.samples = 64;
        stage.environment = Environment::Constant(Vec3::splat(0.5));
        stage.add(across(0.0), lambert(Vec3::ONE));
        if has_wall {
            let clear = Material {
                roughness: 0.0,
                double_sided: true,
                transmission: Some(Transmission { factor: 1.0, texture: None }),
                ior: 1.0,
                ..lambert(Vec3::ONE)
            };
            stage.add(rectangle(Vec3::Z * 5.0, Vec3::X * 300.0, Vec3::Y * 300.0), clear);
        }
        assert_passes(&stage, EYE, &[(LightPass::Environment, Vec3::splat(0.5))]);
    }
}

#[test]
fn unlit_surfaces_guide_denoising() {
    let mut stage = Stage::new();
    stage.settings.integrator = Integrator::Path;
    stage.settings.aovs = AovFlags { guides: true, ..AovFlags::NONE };
    let color = Vec3::new(0.2, 0.5, 0.8);
    stage.add(across(0.0), unlit(color));
    let guide = stage.render(EYE, Vec3::ZERO).aovs.guides.unwrap()[0];
    assert!(guide.albedo.abs_diff_eq(color, 1e-6), "{guide:?}");
    assert!(guide.normal.abs_diff_eq(Vec3::Z, 1e-6), "{guide:?}");
}
