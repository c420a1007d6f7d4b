//! Corrupted renders: edits of scenes and changes of pixels.

use std::path::Path;
use std::sync::Arc;

use rayframe::cancel::CancelFlag;
use rayframe::error::Result;
use rayframe::frame::Frame;
use rayframe::regression::{ColorEncoding, Image};
use rayframe::scene::{AnimationTarget, NodeIndex, Scene};
use rayframe::sequence::render_single_frame;
use rayframe::shot::{ShotRequest, shot_job};

use super::images::{changed_on_display, gaussian};

/// Size of all images. The balls of `material/metal_roughness_row` have 40x40 pixels.
const SIZE: (u32, u32) = (288, 162);
/// Samples a pixel.
const SAMPLES: u32 = 4;
/// Scene time of all images, seconds.
const TIME_SECONDS: f64 = 0.5;

/// One corruption, its scene, and the image before and after.
pub(crate) struct Corruption {
    pub(crate) name: &'static str,
    pub(crate) scene: &'static str,
    /// Whether the corruption is hard to find.
    pub(crate) is_small: bool,
    pub(crate) intact: Image,
    pub(crate) corrupted: Image,
}

/// A change of pixels, row by row.
type Change = fn(&mut [[f32; 4]]);
/// An edit of a scene.
type Edit = fn(&mut Scene);

const DEMO: &str = "demo/whitted_1980";
const BALLS: &str = "material/metal_roughness_row";

const EDITS: [(&str, &str, Edit); 3] = [
    ("object of 40x40 pixels lost", BALLS, lose_ball),
    ("swapped texture", "texture/base_color_srgb", swap_textures),
    ("one wrong joint", DEMO, bend_joint),
];

const CHANGES: [(&str, bool, Change); 4] = [
    ("speck of 6x6 pixels", false, speck),
    ("shift by one pixel", false, shift),
    ("noise of sigma 0.01", true, noise),
    ("exposure +2 %", true, exposure),
];

/// All corruptions, rendered.
pub(crate) fn all(scenes: &Path) -> Result<Vec<Corruption>> {
    let mut corruptions = Vec::new();
    for (name, scene, edit) in EDITS {
        let intact = render(scenes, scene, |_| {})?;
        let corrupted = render(scenes, scene, edit)?;
        corruptions.push(Corruption { name, scene, is_small: false, intact, corrupted });
    }
    for scene in [DEMO, BALLS] {
        let intact = render(scenes, scene, |_| {})?;
        for (name, is_small, change) in CHANGES {
            let mut pixels = intact.rgba().unwrap_or_default();
            change(&mut pixels);
            let corrupted = Image::from_rgba(SIZE, ColorEncoding::Linear, &pixels).rounded_to_halves();
            corruptions.push(Corruption { name, scene, is_small, intact: intact.clone(), corrupted });
        }
    }
    Ok(corruptions)
}

fn render(scenes: &Path, scene: &str, edit: impl Fn(&mut Scene)) -> Result<Image> {
    let path = scenes.join(scene).with_extension("gltf");
    // Without the grain of soft shadows, in which added noise is hard to tell.
    let overrides = [
        format!("resolution={}x{}", SIZE.0, SIZE.1),
        format!("samples={SAMPLES}"),
        "env_samples=0".to_owned(),
    ];
    let mut job = shot_job(&ShotRequest { path: &path, suite: None, overrides: &overrides })?.sequence;
    edit(Arc::make_mut(&mut job.scene));
    let frame = Frame::at(&job.scene, &job.selection, TIME_SECONDS);
    let (film, _) = render_single_frame(&job, &frame, &job.render, &CancelFlag::new())?;
    Ok(Image::from_rgba(SIZE, ColorEncoding::Linear, &film.pixels_over_plate()).rounded_to_halves())
}

/// The third ball is the fifth node.
fn lose_ball(scene: &mut Scene) {
    if let Some(node) = scene.nodes.get_mut(4) {
        node.is_hidden = true;
    }
}

/// Swaps the textures of two materials.
fn swap_textures(scene: &mut Scene) {
    if let [first, _, third, ..] = scene.materials.as_mut_slice() {
        std::mem::swap(&mut first.base_color_texture, &mut third.base_color_texture);
    }
}

/// Turns the fourth joint of a tentacle by a further 0.2 radians, over its animation.
fn bend_joint(scene: &mut Scene) {
    let bend = glam::Quat::from_xyzw(0.0, 0.0, libm::sinf(0.1), libm::cosf(0.1));
    for channel in scene.animations.iter_mut().flat_map(|animation| &mut animation.channels) {
        if channel.target == AnimationTarget::Rotation(NodeIndex(13)) {
            for key in channel.keyframes.values.as_chunks_mut::<4>().0 {
                *key = (glam::Quat::from_array(*key) * bend).to_array();
            }
        }
    }
}

/// Halves the brightness of a small square.
fn speck(pixels: &mut [[f32; 4]]) {
    let width = SIZE.0 as usize;
    for (y, x) in (101..107).flat_map(|y| (131..137).map(move |x| (y, x))) {
        for value in &mut pixels[y * width + x][..3] {
            *value *= 0.5;
        }
    }
}

fn shift(pixels: &mut [[f32; 4]]) {
    for row in pixels.chunks_exact_mut(SIZE.0 as usize) {
        row.copy_within(..row.len() - 1, 1);
    }
}

fn noise(pixels: &mut [[f32; 4]]) {
    for (at, pixel) in pixels.iter_mut().enumerate() {
        for (channel, value) in pixel[..3].iter_mut().enumerate() {
            let offset = 0.01 * gaussian((at * 3 + channel) as u32);
            *value = changed_on_display(*value, |shown| shown + offset);
        }
    }
}

fn exposure(pixels: &mut [[f32; 4]]) {
    for pixel in pixels {
        for value in &mut pixel[..3] {
            *value *= 1.02;
        }
    }
}
