//! Light that bounces, environments that cast shadows, and emissive surfaces, by the path integrator.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;
use rayframe::render::{Integrator, LightSize};
use rayframe::scene::{
    AlphaMode, BuiltInLight, ClearCoat, Environment, LightKind, Material, NormalTexture, Primitive,
    Projection, Transmission,
};

use crate::stage::{Stage, assert_close, cuboid, lambert, rectangle};

/// A stage of one narrow pixel with `samples` samples for the path integrator.
pub(super) fn stage(samples: u32) -> Stage {
    let mut stage = Stage::new();
    stage.settings.integrator = Integrator::Path;
    stage.settings.samples = samples;
    stage.projection =
        Projection::Perspective { fov_y_radians: 1e-4, aspect_ratio: None, z_near: 0.0, z_far: None };
    stage
}

pub(super) fn floor(half_width: f32) -> Primitive {
    rectangle(Vec3::ZERO, Vec3::Z * half_width, Vec3::X * half_width)
}

/// A black material of radiance `emission`.
fn lamp(emission: f32) -> Material {
    Material { emissive: Vec3::splat(emission), ..lambert(Vec3::ZERO) }
}

/// The radiance of the floor's middle, seen aslant.
pub(super) fn middle(stage: &Stage) -> glam::Vec4 {
    stage.look(Vec3::new(0.0, 0.5, 2.0), Vec3::ZERO)
}

/// Form factor of a square of half width `a`, parallel to the receiver and at height `h` above it.
pub(super) fn square_form_factor(a: f32, h: f32) -> f32 {
    // Four times that of a quarter, whose corner is above the receiver.
    let x = a / h;
    let root = (1.0 + x * x).sqrt();
    4.0 * FRAC_1_PI * (x / root) * libm::atanf(x / root)
}

#[test]
fn a_lambertian_floor_in_uniform_light_shows_its_albedo() {
    let mut stage = stage(64);
    stage.environment = Environment::Constant(Vec3::splat(2.0));
    stage.add(floor(5.0), lambert(Vec3::new(0.8, 0.5, 0.2)));
    assert_close(middle(&stage), Vec3::new(1.6, 1.0, 0.4), 1e-5);
}

#[test]
fn environments_cast_shadows() {
    // A black square above the floor hides its form factor of the uniform light.
    for half_width in [0.2, 1.0, 5.0] {
        let mut stage = stage(4096);
        stage.environment = Environment::Constant(Vec3::ONE);
        stage.add(floor(5.0), lambert(Vec3::splat(0.5)));
        let above = rectangle(Vec3::Y, Vec3::Z * half_width, Vec3::X * half_width);
        stage.add(above, Material { double_sided: true, ..lambert(Vec3::ZERO) });
        let eye = Vec3::new(0.0, 0.5, 2.0);
        let expected = 0.5 * (1.0 - square_form_factor(half_width, 1.0));
        assert_close(stage.look(eye, Vec3::ZERO), Vec3::splat(expected), 0.004);
    }
}

#[test]
fn emissive_squares_light_by_their_form_factor() {
    // From tiny, where shadow rays find the light, to large, where sampled rays do.
    // A copy in the same place is never hit, and gives no light.
    for (half_width, radiance, copies) in
        [(0.01, 1e4, 1), (0.1, 100.0, 1), (1.0, 3.0, 1), (1.0, 3.0, 2), (8.0, 1.0, 3)]
    {
        let mut stage = stage(4096);
        stage.add(floor(9.0), lambert(Vec3::splat(0.5)));
        // The front faces down.
        for _ in 0..copies {
            stage.add(rectangle(Vec3::Y, Vec3::X * half_width, Vec3::Z * half_width), lamp(radiance));
        }
        let expected = 0.5 * radiance * square_form_factor(half_width, 1.0);
        let seen = middle(&stage);
        assert_close(seen, Vec3::splat(expected), 0.01 * expected);
    }
}

#[test]
fn single_sided_lamps_are_dark_behind() {
    let mut stage = stage(256);
    stage.add(floor(9.0), lambert(Vec3::splat(0.5)));
    let up = rectangle(Vec3::Y, Vec3::Z, Vec3::X);
    stage.add(up.clone(), lamp(10.0));
    assert_close(middle(&stage), Vec3::ZERO, 0.0);
    let mut both = self::stage(1024);
    both.add(floor(9.0), lambert(Vec3::splat(0.5)));
    both.add(up, Material { double_sided: true, ..lamp(10.0) });
    let expected = 5.0 * square_form_factor(1.0, 1.0);
    assert_close(middle(&both), Vec3::splat(expected), 0.02 * expected);
}

#[test]
fn lamps_behind_transparent_texels_light_by_their_coverage() {
    // Half the lamp is there, and half of its light passes what is there.
    let mut stage = stage(4096);
    stage.add(floor(9.0), lambert(Vec3::splat(0.5)));
    let half = Material { alpha_mode: AlphaMode::Blend, ..lamp(3.0) };
    let half = Material { base_color: half.base_color.truncate().extend(0.5), ..half };
    stage.add(rectangle(Vec3::Y, Vec3::X, Vec3::Z), half);
    let expected = 0.5 * 1.5 * square_form_factor(1.0, 1.0);
    assert_close(middle(&stage), Vec3::splat(expected), 0.01 * expected);
}

#[test]
fn light_bounces_in_a_closed_box() {
    // All walls emit L and reflect a: the radiance is L (1 + a + a² + …), here cut off after the ninth surface.
    let (emission, albedo) = (0.5_f32, 0.6_f32);
    let mut stage = stage(16_384);
    let mut inside = cuboid(Vec3::ZERO, Vec3::new(1.0, 0.7, 1.3));
    for triangle in &mut inside.triangles {
        triangle.swap(1, 2);
    }
    stage.add(inside, Material { emissive: Vec3::splat(emission), ..lambert(Vec3::splat(albedo)) });
    let surfaces = stage.settings.max_depth as i32 + 1;
    // Light of lamps is found one surface farther than the deepest ray.
    let expected = emission * (1.0 - albedo.powi(surfaces + 1)) / (1.0 - albedo);
    let seen = stage.look(Vec3::new(0.1, 0.2, -0.3), Vec3::new(1.0, 0.3, 0.4));
    assert_close(seen, Vec3::splat(expected), 0.01 * expected);
}

#[test]
fn guided_light_in_a_closed_box_is_exact() {
    // All walls emit L and reflect a, and a mirror shows them, which makes photons guide the paths: the radiance is L / (1 − a) everywhere.
    let (emission, albedo) = (0.5_f32, 0.5_f32);
    let mut stage = stage(8192);
    stage.settings.max_depth = 40;
    let mut inside = cuboid(Vec3::ZERO, Vec3::new(1.0, 0.7, 1.3));
    for triangle in &mut inside.triangles {
        triangle.swap(1, 2);
    }
    stage.add(inside, Material { emissive: Vec3::splat(emission), ..lambert(Vec3::splat(albedo)) });
    stage.add(cuboid(Vec3::new(0.2, -0.3, 0.2), Vec3::new(0.3, 0.2, 0.4)), mirror_of(0.0));
    let expected = emission / (1.0 - albedo);
    for target in [Vec3::new(1.0, 0.3, 0.4), Vec3::new(0.2, -0.2, 0.2), Vec3::new(0.6, -0.7, 0.2)] {
        let seen = stage.look(Vec3::new(-0.5, 0.3, -0.6), target);
        assert_close(seen, Vec3::splat(expected), 0.01 * expected);
    }
}

#[test]
fn spheres_of_light_and_suns_light_as_points_do() {
    // A sphere above the horizon of the receiver: I cos θ / d², whatever its radius (Lambert).
    for radius in [0.0, 0.1, 0.45] {
        let mut stage = stage(4096);
        stage.settings.light_size = LightSize { radius, sun_angle_radians: 0.0 };
        stage.add(floor(9.0), lambert(Vec3::splat(0.5)));
        stage.add_light(LightKind::Point, 8.0, Vec3::new(0.8, 1.0, 0.6), Vec3::NEG_Y);
        let expected = 0.5 * FRAC_1_PI * 8.0 * 0.5_f32.sqrt() / 2.0;
        assert_close(middle(&stage), Vec3::splat(expected), 0.002 * expected);
    }
    for sun_angle_radians in [0.0, 0.5] {
        let mut stage = stage(4096);
        stage.settings.light_size = LightSize { radius: 0.0, sun_angle_radians };
        stage.add(floor(9.0), lambert(Vec3::splat(0.5)));
        stage.add_light(
            LightKind::Directional,
            3.0,
            Vec3::ZERO,
            Vec3::new(-0.8 * 3_f32.sqrt(), -1.0, -0.6 * 3_f32.sqrt()),
        );
        let expected = 0.5 * FRAC_1_PI * 1.5;
        assert_close(middle(&stage), Vec3::splat(expected), 0.002 * expected);
    }
}

#[test]
fn one_of_many_lights_is_chosen_without_bias() {
    let mut stage = stage(4096);
    stage.add(floor(9.0), lambert(Vec3::splat(0.5)));
    let mut expected = 0.0;
    for index in 0..7 {
        let (x, intensity) = (index as f32 - 2.0, 1.0 + index as f32);
        stage.add_light(LightKind::Point, intensity, Vec3::new(x, 1.0, 0.0), Vec3::NEG_Y);
        expected += 0.5 * FRAC_1_PI * intensity / libm::powf(1.0 + x * x, 1.5);
    }
    assert_close(middle(&stage), Vec3::splat(expected), 0.005 * expected);
}

#[test]
fn clear_panes_pass_the_light_of_lamps_and_environments() {
    // An index of 1 reflects nothing: the pane colours light by 0.5 once, for shadow rays and sampled rays alike.
    let pane = Material {
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        roughness: 0.0,
        double_sided: true,
        ..lambert(Vec3::splat(0.5))
    };
    let above = |half_width: f32| rectangle(Vec3::Y * 0.4, Vec3::X * half_width, Vec3::Z * half_width);
    let mut lit = stage(4096);
    lit.add(floor(2.0), lambert(Vec3::splat(0.5)));
    lit.add(above(400.0), pane.clone());
    lit.add(rectangle(Vec3::Y, Vec3::X * 0.3, Vec3::Z * 0.3), lamp(20.0));
    let expected = 0.5 * 0.5 * 20.0 * square_form_factor(0.3, 1.0);
    let look = |stage: &Stage| stage.look(Vec3::new(0.0, 0.2, 0.8), Vec3::ZERO);
    assert_close(look(&lit), Vec3::splat(expected), 0.01 * expected);

    let mut outdoors = stage(4096);
    outdoors.environment = Environment::BuiltIn(BuiltInLight::Studio);
    outdoors.add(floor(2.0), lambert(Vec3::splat(0.5)));
    let open = look(&outdoors);
    outdoors.add(above(400.0), pane);
    let behind = look(&outdoors);
    assert_close(behind, open.truncate() * 0.5, 0.02 * open.x);
}

#[test]
fn the_clamp_limits_what_paths_bring() {
    // A mirror shows a lamp of 100, and so it does under a pane that reflects nothing; there with the clamp no more than 10.
    for (is_covered, clamped) in [(false, 100.0), (true, 10.0)] {
        let mut stage = stage(4);
        stage.add(floor(5.0), mirror_of(0.0));
        if is_covered {
            let transmission = Some(Transmission { factor: 1.0, texture: None });
            let pane = Material { transmission, roughness: 0.0, ior: 1.0, ..lambert(Vec3::ONE) };
            stage.add(rectangle(Vec3::Y * 0.01, Vec3::X * 5.0, Vec3::Z * 5.0), pane);
        }
        stage.add(rectangle(Vec3::new(0.0, 0.5, -2.0), Vec3::X, Vec3::Y * 0.4), lamp(100.0));
        assert_close(middle(&stage), Vec3::splat(100.0), 1.0);
        stage.settings.path.clamp_indirect = 10.0;
        assert_close(middle(&stage), Vec3::splat(clamped), clamped * 0.01);
    }
}

#[test]
fn the_clamp_leaves_what_the_first_surface_receives_without_a_detour() {
    // A sky of 3, and a wide panel close above: shadow rays and sampled rays find their light.
    for panel in [None, Some(0.5), Some(5.0)] {
        let mut stage = stage(256);
        stage.add(floor(20.0), lambert(Vec3::splat(0.5)));
        match panel {
            None => stage.environment = Environment::Constant(Vec3::splat(3.0)),
            Some(half_width) => {
                let below = rectangle(Vec3::Y * 0.3, Vec3::X * half_width, Vec3::Z * half_width);
                stage.add(below, lamp(5.0));
            }
        }
        let look = |stage: &Stage| stage.look(Vec3::new(0.0, 0.1, 0.4), Vec3::ZERO);
        let without = look(&stage);
        assert!(without.x > 0.7, "{without}");
        stage.settings.path.clamp_indirect = 0.1;
        assert_eq!(look(&stage), without, "{panel:?}");
    }
    // A mirror and a clear pane show the sky without a detour, too; a mirror that a mirror shows does not.
    let transmission = Some(Transmission { factor: 1.0, texture: None });
    let pane = Material { transmission, roughness: 0.0, ior: 1.0, ..lambert(Vec3::ONE) };
    for (second, material, kept) in
        [(false, mirror_of(0.0), true), (false, pane, true), (true, mirror_of(0.0), false)]
    {
        let mut stage = stage(64);
        stage.add(floor(20.0), material);
        if second {
            stage.add(rectangle(Vec3::Y, Vec3::X * 20.0, Vec3::Z * 20.0), mirror_of(0.0));
        }
        stage.environment = Environment::Constant(Vec3::splat(3.0));
        let look = |stage: &Stage| stage.look(Vec3::new(0.0, 0.1, 0.4), Vec3::ZERO);
        let without = look(&stage);
        stage.settings.path.clamp_indirect = 0.1;
        assert_eq!(look(&stage) == without, kept, "{without}");
    }
}

#[test]
fn regularization_shows_what_mirrors_focus() {
    // A mirror above the floor reflects a lamp that rays cannot hit: the floor gets its light by a regularised mirror alone.
    let mut stage = stage(1024);
    stage.add(floor(2.0), lambert(Vec3::splat(0.5)));
    stage.add(rectangle(Vec3::Y * 2.0, Vec3::X * 20.0, Vec3::Z * 20.0), mirror_of(0.0));
    let shade = rectangle(Vec3::new(0.0, 0.1, -0.3), Vec3::X * 4.0, Vec3::Y * 0.1);
    stage.add(shade, lambert(Vec3::ZERO));
    stage.add_light(LightKind::Point, 8.0, Vec3::new(0.0, 0.15, -0.6), Vec3::NEG_Y);
    let look = |stage: &Stage| stage.look(Vec3::new(0.0, 1.0, 0.8), Vec3::ZERO).x;
    let without = look(&stage);
    stage.settings.path.regularize = true;
    let with = look(&stage);
    assert!(with > 1.5 * without, "{without} {with}");

    // What the camera sees directly stays a mirror.
    let shown = |regularize| {
        let mut stage = self::stage(64);
        stage.settings.path.regularize = regularize;
        stage.add(floor(5.0), mirror_of(0.0));
        stage.add(rectangle(Vec3::new(0.0, 0.5, -2.0), Vec3::X, Vec3::Y * 0.4), lamp(10.0));
        middle(&stage)
    };
    assert_eq!(shown(true), shown(false));
}

fn mirror_of(roughness: f32) -> Material {
    Material { metallic: 1.0, roughness, ..Material::default() }
}

#[test]
fn seeds_change_the_noise_and_not_the_mean() {
    let render = |seed| {
        let mut stage = stage(256);
        stage.settings.path.seed = seed;
        stage.add(floor(9.0), lambert(Vec3::splat(0.5)));
        stage.add(rectangle(Vec3::Y, Vec3::X * 2.0, Vec3::Z * 2.0), lamp(PI));
        middle(&stage).x
    };
    let (first, second) = (render(0), render(1));
    assert!(first != second && (first - second).abs() < 0.03 * first, "{first} {second}");
}

#[test]
fn lamps_shine_through_frosted_glass_once() {
    // Shadow rays pass the pane straight, as in Whitted's tree; the rays that it scatters find the lamp no second time.
    let frosted = Material {
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        roughness: 0.5,
        metallic: 0.0,
        double_sided: true,
        ..Material::default()
    };
    let mut stage = stage(4096);
    stage.add(floor(9.0), lambert(Vec3::splat(0.1)));
    stage.add(rectangle(Vec3::Y * 0.6, Vec3::X * 40.0, Vec3::Z * 40.0), frosted);
    stage.add_light(LightKind::Point, 8.0, Vec3::new(0.1, 1.5, 0.2), Vec3::NEG_Y);
    let look = |stage: &Stage| stage.look(Vec3::new(0.0, 0.2, 0.8), Vec3::ZERO);
    let bounced = look(&stage);
    stage.settings.integrator = Integrator::Whitted;
    let straight = look(&stage);
    assert_close(bounced, straight.truncate(), 0.06 * straight.x);
}

#[test]
fn lights_are_found_through_clear_walls_at_the_depth_limit() {
    // A wall of index 1 changes nothing, also where it is beyond the deepest surface: shadow rays and sampled rays pass it.
    for (depth, has_lamp) in [(0, true), (1, true), (0, false)] {
        let see = |has_wall: bool| {
            let mut stage = stage(4096);
            stage.settings.max_depth = depth;
            stage.add(floor(5.0), lambert(Vec3::splat(0.5)));
            let above = |height: f32| rectangle(Vec3::Y * height, Vec3::X * 3.0, Vec3::Z * 3.0);
            if has_lamp {
                stage.add(above(1.0), Material { double_sided: true, ..lamp(1.0) });
            } else {
                stage.environment = Environment::BuiltIn(BuiltInLight::Studio);
            }
            if has_wall {
                let transmission = Some(Transmission { factor: 1.0, texture: None });
                let clear =
                    Material { transmission, roughness: 0.0, double_sided: true, ..lambert(Vec3::ONE) };
                stage.add(above(0.5), clear);
            }
            stage.look(Vec3::new(0.0, 0.1, 0.4), Vec3::ZERO).x
        };
        let (bare, behind) = (see(false), see(true));
        assert!((bare / behind - 1.0).abs() < 0.03 && bare > 0.1, "{depth} {has_lamp}: {bare} {behind}");
    }
}

#[test]
fn coats_over_leaning_bases_reflect_as_their_own_normal_does() {
    // Seen at 80° in uniform light, a coat of index 1.5 reflects F(80°) = 0.3877, although the base's normal leans 30° to the viewer.
    for (roughness, integrator) in
        [0.0, 0.3].into_iter().flat_map(|r| [(r, Integrator::Whitted), (r, Integrator::Path)])
    {
        let mut stage = stage(4096);
        stage.settings.integrator = integrator;
        stage.environment = Environment::Constant(Vec3::ONE);
        // (0.5, 0, 0.866) in tangent space
        let texture = stage.add_texel([191, 128, 238, 255]);
        let coat = ClearCoat {
            factor: 1.0,
            texture: None,
            roughness,
            roughness_texture: None,
            normal_texture: None,
        };
        let base = Material {
            normal_texture: Some(NormalTexture { texture, scale: 1.0 }),
            clear_coat: Some(coat),
            ..lambert(Vec3::ZERO)
        };
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(glam::Vec2::from_array);
        let surface = rectangle(Vec3::ZERO, Vec3::X * 5.0, Vec3::NEG_Z * 5.0);
        stage.add(Primitive { uvs: vec![corners.to_vec()], ..surface }, base);
        let (sine, cosine) = libm::sincosf(80.0_f32.to_radians());
        let seen = stage.look(Vec3::new(2.0 * sine, 2.0 * cosine, 0.0), Vec3::ZERO);
        assert_close(seen, Vec3::splat(0.3877), 0.004);
    }
}
