//! Pixels of paths that stop by their noise: their mean is that of pixels with all samples.

use glam::Vec3;
use rayframe::film::PixelWindow;
use rayframe::render::Integrator;
use rayframe::scene::{Material, Projection};

use crate::stage::{Stage, cuboid, lambert, rectangle};

const SIDE: u32 = 8;

/// A closed box with a lamp just below the ceiling that shines up: all other surfaces are lit by the ceiling around it.
fn indirect_box() -> Stage {
    let mut stage = Stage::new();
    stage.settings.integrator = Integrator::Path;
    stage.settings.resolution = (SIDE, SIDE);
    stage.settings.window = PixelWindow::full(SIDE, SIDE);
    stage.projection =
        Projection::Perspective { fov_y_radians: 1.3, aspect_ratio: None, z_near: 0.0, z_far: None };
    let white = Material { double_sided: true, ..lambert(Vec3::splat(0.7)) };
    stage.add(cuboid(Vec3::ZERO, Vec3::splat(2.0)), white);
    let lamp = Material { emissive: Vec3::splat(100.0), ..lambert(Vec3::ZERO) };
    stage.add(rectangle(Vec3::Y * 1.9, Vec3::Z * 0.1, Vec3::X * 0.1), lamp);
    stage
}

/// The green of all pixels.
fn rendered(stage: &Stage) -> Vec<f32> {
    let film = stage.render(Vec3::new(0.0, 0.0, 1.9), Vec3::new(0.0, -0.3, 0.0));
    film.pixels.iter().map(|pixel| pixel[1]).collect()
}

#[test]
fn pixels_that_few_paths_light_do_not_stop_while_they_are_dark() {
    let mut stage = indirect_box();
    stage.settings.samples = 1024;
    let all = rendered(&stage);
    stage.settings.path.noise = Some(0.01);
    let stopped = rendered(&stage);
    assert!(stopped != all, "no pixel stops");
    let [stopped, all] = [stopped, all].map(|values| values.iter().sum::<f32>());
    assert!((stopped - all).abs() < 0.08 * all, "{stopped} instead of {all}");
}
