//! Effects of several rays a pixel: depth of field, soft shadows, rough mirrors, filters, adaptive samples on edges.

use std::f32::consts::PI;

use glam::Vec3;
use rayframe::film::PixelWindow;
use rayframe::render::{Adaptive, Aperture, Focus, Lens, LightSize, PixelFilter};
use rayframe::scene::{Environment, LightKind, Material, NodeIndex, Projection, Transmission};

use crate::stage::{Stage, cuboid, lambert, rectangle, unlit};

/// Share of a disk beyond a line at half its radius: 1/3 − √3 / 4π.
const BEYOND_HALF: f32 = 0.195_501;

/// A field of view so narrow that all samples of the pixel pass through nearly one point.
const NARROW: Projection =
    Projection::Perspective { fov_y_radians: 1e-4, aspect_ratio: None, z_near: 0.0, z_far: None };

/// A white half plane x > `edge` at a distance of 2 m, seen along −Z by [`NARROW`].
fn half_white(edge: f32) -> Stage {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::new(edge + 50.0, 0.0, -2.0), Vec3::X * 50.0, Vec3::Y * 50.0), unlit(Vec3::ONE));
    stage.projection = NARROW;
    stage.settings.samples = 2048;
    stage
}

#[test]
fn an_edge_out_of_focus_is_blurred_over_the_lens() {
    // At a depth of 2 m a ray from x on the lens passes x / 2 with the focus at 4 m, and −x with the focus at 1 m. With a lens
    // of radius 0.2, an edge at 0 is seen by half of the lens, and an edge at 0.05 or 0.1 by the part beyond half the radius.
    let seen = |edge: f32, focus: f32| {
        let mut stage = half_white(edge);
        let focus = Focus::Metres(focus);
        stage.settings.lens = Some(Lens { aperture: Aperture::Radius(0.2), focus });
        stage.look(Vec3::ZERO, Vec3::NEG_Z).x
    };
    for (edge, focus, expected) in [
        (0.0, 4.0, 0.5),
        (0.05, 4.0, BEYOND_HALF),
        (0.1, 1.0, BEYOND_HALF),
        (-0.1, 1.0, 1.0 - BEYOND_HALF),
        (0.01, 2.0, 0.0),
        (-0.01, 2.0, 1.0),
    ] {
        let seen = seen(edge, focus);
        assert!((seen - expected).abs() < 0.01, "{edge} {focus}: {seen} is not {expected}");
    }
}

#[test]
fn the_center_of_the_image_is_in_focus() {
    // The edge of the plane at 2 m lies just beside the centre; in focus, it is outside the pixel.
    let mut stage = half_white(-0.01);
    stage.settings.lens = Some(Lens { aperture: Aperture::Radius(0.2), focus: Focus::Center });
    assert_eq!(stage.look(Vec3::ZERO, Vec3::NEG_Z).x, 1.0);
}

#[test]
fn an_f_number_is_the_focal_length_over_the_diameter() {
    // yfov 1e-4 and 24 mm: a focal length of 12 mm / tan(0.5e-4) = 240 m; at f/600 the radius is 0.2 m.
    let mut stage = half_white(0.05);
    stage.settings.lens = Some(Lens { aperture: Aperture::FNumber(600.0), focus: Focus::Metres(4.0) });
    let seen = stage.look(Vec3::ZERO, Vec3::NEG_Z).x;
    assert!((seen - BEYOND_HALF).abs() < 0.01, "{seen}");
}

#[test]
fn an_f_number_refers_to_the_height_of_the_image() {
    // A camera made for images four times as wide as high shows four times its own height in a square one: the angle of the test before.
    let mut stage = half_white(0.05);
    stage.projection =
        Projection::Perspective { fov_y_radians: 0.25e-4, aspect_ratio: Some(4.0), z_near: 0.0, z_far: None };
    stage.settings.lens = Some(Lens { aperture: Aperture::FNumber(600.0), focus: Focus::Metres(4.0) });
    let seen = stage.look(Vec3::ZERO, Vec3::NEG_Z).x;
    assert!((seen - BEYOND_HALF).abs() < 0.01, "{seen}");
}

#[test]
fn a_node_is_in_focus_where_it_is_seen() {
    // Its origin is in the lens; its surface is 2 m away, with an edge just beside the centre.
    let mut stage = half_white(-0.01);
    let focus = Focus::Node(NodeIndex(0));
    stage.settings.lens = Some(Lens { aperture: Aperture::Radius(0.2), focus });
    assert_eq!(stage.look(Vec3::ZERO, Vec3::NEG_Z).x, 1.0);
    // What is hidden below it does not count.
    let far = rectangle(Vec3::new(0.0, 0.0, -20.0), Vec3::X, Vec3::Y);
    stage.add(far, unlit(Vec3::ZERO));
    stage.scene.nodes[0].children.push(NodeIndex(1));
    assert!(stage.look(Vec3::ZERO, Vec3::NEG_Z).x < 0.9);
    stage.scene.nodes[1].is_hidden = true;
    assert_eq!(stage.look(Vec3::ZERO, Vec3::NEG_Z).x, 1.0);
}

/// A white floor, and 1 m above it a lid over x > 0.
fn half_covered() -> Stage {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::Z * 9.0, Vec3::X * 9.0), lambert(Vec3::ONE));
    stage.add(rectangle(Vec3::new(50.0, 1.0, 0.0), Vec3::X * 50.0, Vec3::Z * 50.0), unlit(Vec3::ZERO));
    stage.projection = NARROW;
    stage.settings.samples = 2048;
    stage
}

#[test]
fn a_large_light_is_partly_occluded() {
    // A light of radius 0.2 m, 2 m up: the ray from x on it to p on the floor passes the lid's height at (x + p) / 2. At p = 0
    // half of the light is occluded, at p = −0.1 the part beyond half its radius.
    for (p, visible) in [(0.0, 0.5), (-0.1, 1.0 - BEYOND_HALF), (-0.4, 1.0)] {
        let mut stage = half_covered();
        stage.add_light(LightKind::Point, 4.0, Vec3::Y * 2.0, Vec3::NEG_Y);
        stage.settings.light_size = LightSize { radius: 0.2, sun_angle_radians: 0.0 };
        let seen = stage.look(Vec3::new(p - 0.001, 0.5, 0.0), Vec3::new(p, 0.0, 0.0)).x;
        // 4 cd over d², twice the cosine 2 / d for d = √(4 + p²), over π.
        let d2 = 4.0 + p * p;
        let lit = 4.0 / d2 * (2.0 / d2.sqrt()) / PI;
        assert!((seen / lit - visible).abs() < 0.015, "{p}: {} is not {visible}", seen / lit);
    }
}

#[test]
fn a_wide_sun_is_partly_occluded() {
    // Straight down, tan of half the angle 0.2: the ray from p in a direction x aside passes 1 m at p + x.
    let angle = 2.0 * libm::atanf(0.2);
    for (p, visible) in [(0.0, 0.5), (-0.1, 1.0 - BEYOND_HALF), (-0.4, 1.0)] {
        let mut stage = half_covered();
        stage.add_light(LightKind::Directional, 1.0, Vec3::ZERO, Vec3::NEG_Y);
        stage.settings.light_size = LightSize { radius: 0.0, sun_angle_radians: angle };
        let seen = stage.look(Vec3::new(p - 0.001, 0.5, 0.0), Vec3::new(p, 0.0, 0.0)).x * PI;
        assert!((seen - visible).abs() < 0.015, "{p}: {seen} is not {visible}");
    }
}

#[test]
fn filters_preserve_uniform_radiance() {
    for filter in PixelFilter::ALL {
        let mut stage = Stage::new();
        stage.environment = Environment::Constant(Vec3::splat(0.75));
        stage.settings.samples = 16;
        stage.settings.filter = filter;
        let seen = stage.look(Vec3::ZERO, Vec3::NEG_Z);
        assert!((seen.x - 0.75).abs() < 1e-6 && (seen.w - 1.0).abs() < 1e-6, "{filter:?} {seen}");
    }
}

#[test]
fn traced_and_prefiltered_reflections_agree_in_a_uniform_environment() {
    // In a uniform environment both are the albedo of the lobe times its radiance.
    let looks = |material: &Material| {
        let look = |glossy_samples| {
            let mut stage = Stage::new();
            stage.projection = NARROW;
            stage.environment = Environment::Constant(Vec3::splat(0.75));
            stage.add(rectangle(Vec3::ZERO, Vec3::Z * 9.0, Vec3::X * 9.0), material.clone());
            stage.settings.samples = 16;
            stage.settings.glossy_samples = glossy_samples;
            stage.look(Vec3::new(0.0, 1.0, 1.5), Vec3::ZERO).truncate()
        };
        (look(0), look(64))
    };
    let metal = |roughness| Material { roughness, ..Material::default() };
    let frosted = Material {
        metallic: 0.0,
        roughness: 0.5,
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        ..Material::default()
    };
    let plastic = Material { metallic: 0.0, roughness: 0.3, ..lambert(Vec3::splat(0.5)) };
    for material in [metal(0.2), metal(0.6), metal(1.0), frosted, Material { ior: 1.5, ..plastic }] {
        let (looked_up, followed) = looks(&material);
        assert!((looked_up - followed).abs().max_element() < 0.006, "{looked_up} {followed}");
    }
}

#[test]
fn leaning_normals_do_not_darken_sampled_reflections() {
    // White metal in uniform light, whose lobe reaches beyond its plane: looked up, by glossy rays, and followed in a white box without environment.
    let look = |glossy_samples, is_boxed: bool, lean: f32| {
        let mut stage = Stage::new();
        stage.projection = NARROW;
        let mut floor = rectangle(Vec3::ZERO, Vec3::Z, Vec3::X);
        let normal = Vec3::new(lean, 1.0, 0.0).normalize();
        floor.normals = Some(vec![normal; floor.positions.len()]);
        stage.add(floor, Material { roughness: 0.5, ..Material::default() });
        if is_boxed {
            let walls = Material { double_sided: true, ..unlit(Vec3::ONE) };
            stage.add(cuboid(Vec3::ZERO, Vec3::splat(9.0)), walls);
        } else {
            stage.environment = Environment::Constant(Vec3::ONE);
        }
        stage.settings.samples = 256;
        stage.settings.glossy_samples = glossy_samples;
        stage.look(Vec3::new(0.0, 1.5, 0.5), Vec3::ZERO).x
    };
    for lean in [0.0, 0.5, 1.0] {
        for (glossy_samples, is_boxed) in [(0, false), (4, false), (0, true), (4, true)] {
            let seen = look(glossy_samples, is_boxed, lean);
            assert!((seen - 1.0).abs() < 0.03, "{lean} {glossy_samples} {is_boxed}: {seen}");
        }
    }
}

#[test]
fn a_rough_mirror_blurs_far_objects_more_than_near_ones() {
    // A white wall stands on a rough metal floor. Close to its foot, half of the lobe or more hits the wall. Far away, where a
    // smooth mirror shows either the wall or the background, a rough one shows a mixture.
    let look = |roughness: f32, x: f32| {
        let mut stage = Stage::new();
        stage.projection = NARROW;
        let floor = Material { roughness, ..Material::default() };
        stage.add(rectangle(Vec3::ZERO, Vec3::Z * 50.0, Vec3::X * 50.0), floor);
        stage.add(rectangle(Vec3::new(3.0, 1.0, 0.0), Vec3::Z * 50.0, Vec3::Y), unlit(Vec3::ONE));
        stage.settings.samples = 16;
        stage.settings.glossy_samples = 64;
        stage.look(Vec3::new(x - 1.0, 1.0, 0.0), Vec3::new(x, 0.0, 0.0)).x
    };
    // At 45° the mirror ray from x hits the wall at 3 − x, which is 2 m high.
    let (seen, missed) = (look(0.0, 1.5), look(0.0, 0.5));
    assert!(seen > 0.99 && missed == 0.0, "{seen} {missed}");
    let (seen, missed) = (look(0.5, 1.5), look(0.5, 0.5));
    assert!(missed > 0.05 && missed < 0.6 && seen > missed + 0.1 && seen < 0.98, "{seen} {missed}");
}

#[test]
fn glossy_samples_count_for_rough_surfaces_beyond_clear_glass() {
    // Standard deviation of pixels that see one point of a rough metal floor before a white wall, also through a clear pane.
    let clear = Material {
        metallic: 0.0,
        roughness: 0.0,
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        double_sided: true,
        ..Material::default()
    };
    let noise = |is_behind_glass: bool, glossy_samples: u32| {
        let mut stage = Stage::new();
        stage.projection = NARROW;
        let floor = Material { roughness: 0.5, ..Material::default() };
        stage.add(rectangle(Vec3::ZERO, Vec3::Z * 50.0, Vec3::X * 50.0), floor);
        stage.add(rectangle(Vec3::new(3.0, 1.0, 0.0), Vec3::Z * 50.0, Vec3::Y), unlit(Vec3::ONE));
        if is_behind_glass {
            stage.add(rectangle(Vec3::Y * 0.5, Vec3::Z * 50.0, Vec3::X * 50.0), clear.clone());
        }
        stage.settings.resolution = (16, 16);
        stage.settings.window = PixelWindow::full(16, 16);
        (stage.settings.samples, stage.settings.glossy_samples) = (1, glossy_samples);
        let pixels = stage.render(Vec3::new(0.5, 1.0, 0.0), Vec3::new(1.5, 0.0, 0.0)).pixels;
        let mean = pixels.iter().map(|pixel| pixel[0]).sum::<f32>() / pixels.len() as f32;
        let square = |pixel: &[f32; 4]| (pixel[0] - mean) * (pixel[0] - mean);
        assert!(mean > 0.1, "{mean}");
        (pixels.iter().map(square).sum::<f32>() / pixels.len() as f32).sqrt()
    };
    for is_behind_glass in [false, true] {
        let (one, many) = (noise(is_behind_glass, 1), noise(is_behind_glass, 64));
        assert!(many < 0.3 * one && one > 0.05, "{many} {one}");
    }
}

/// A white square in the centre of 16 x 16 pixels.
fn square() -> Stage {
    let mut stage = Stage::new();
    let slanted = rectangle(Vec3::new(0.0, 0.0, -2.0), Vec3::new(0.2, 0.03, 0.0), Vec3::new(-0.03, 0.2, 0.0));
    stage.add(slanted, unlit(Vec3::ONE));
    stage.settings.resolution = (16, 16);
    stage.settings.window = PixelWindow::full(16, 16);
    stage.settings.samples = 4;
    stage
}

#[test]
fn edges_get_more_samples_and_nothing_else_changes() {
    let look = |stage: &Stage| stage.render(Vec3::ZERO, Vec3::NEG_Z).pixels;
    let base = look(&square());
    let mut adaptive = square();
    adaptive.settings.adaptive = Some(Adaptive { max_samples: 64, threshold: 0.05 });
    let refined = look(&adaptive);
    let mut many = square();
    many.settings.samples = 1024;
    let truth = look(&many);
    let error = |pixels: &[[f32; 4]]| -> f32 {
        pixels.iter().zip(&truth).map(|(pixel, truth)| (pixel[0] - truth[0]).abs()).sum()
    };
    assert!(error(&refined) < 0.25 * error(&base), "{} {}", error(&refined), error(&base));
    // Pixels inside and outside are exactly white and black.
    let flat = truth.iter().filter(|pixel| pixel[0] == 0.0 || pixel[0] == 1.0).count();
    let kept = refined
        .iter()
        .zip(&base)
        .zip(&truth)
        .filter(|((refined, base), truth)| (truth[0] == 0.0 || truth[0] == 1.0) && refined == base);
    assert_eq!(kept.count(), flat);
}

#[test]
fn a_crop_detects_the_same_edges_as_the_whole_image() {
    let mut stage = square();
    stage.settings.adaptive = Some(Adaptive { max_samples: 16, threshold: 0.05 });
    stage.settings.filter = PixelFilter::BlackmanHarris;
    stage.settings.lens = Some(Lens { aperture: Aperture::Radius(0.02), focus: Focus::Metres(1.5) });
    let whole = stage.render(Vec3::ZERO, Vec3::NEG_Z);
    let window = PixelWindow { x0: 4, y0: 3, x1: 11, y1: 5 };
    stage.settings.window = window;
    let crop = stage.render(Vec3::ZERO, Vec3::NEG_Z);
    for y in window.y0..window.y1 {
        for x in window.x0..window.x1 {
            let inside = ((y - window.y0) * window.width() + x - window.x0) as usize;
            assert_eq!(crop.pixels[inside], whole.pixels[(y * 16 + x) as usize], "{x} {y}");
        }
    }
}
