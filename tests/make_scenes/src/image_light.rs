//! The scene of `EXT_lights_image_based`: a cube map and the spherical harmonics of its irradiance.

use std::f32::consts::PI;

use glam::Vec3;

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::Image;
use scene_builder::json::{Json, list, object};
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::ico_sphere;
use scene_builder::staging::camera;

pub(crate) const SCENES: [Entry; 1] = [entry("light/image_based", image_based)];

/// Texels along an edge of the sharpest cube.
const SIZE: u32 = 16;

/// Radiance: blue above, brown below, and twice as bright towards +X as white can be.
fn sky(direction: Vec3) -> Vec3 {
    let height = 0.5 + 0.5 * direction.y;
    let ground = Vec3::new(0.25, 0.18, 0.1);
    let base = ground + (Vec3::new(0.2, 0.4, 0.8) - ground) * height;
    base + Vec3::splat(if direction.x > 0.0 { 1.5 * direction.x } else { 0.0 })
}

fn image_based() -> Built {
    let mut gltf = Gltf::new(
        "A matte, a rough and a mirror ball under a sky that comes with the file: blue above, brown below, bright on the right; \
         the mirror shows the bright side in RGBD beyond white, the rough ball shows it blurred.",
    );
    gltf.uses_extension("EXT_lights_image_based");
    camera(&mut gltf, Vec3::new(0.0, 0.3, 5.0), Vec3::ZERO, 30.0);
    let materials = [
        Material::matte("matte", [0.8; 3]),
        Material::metal("rough", [0.9; 3], 0.5),
        Material::metal("mirror", [0.95; 3], 0.0),
    ]
    .map(|material| material.add_to(&mut gltf));
    let balls = ico_sphere(0.7, 3).plain().add_with_each(&mut gltf, &materials);
    for (index, ball) in balls.into_iter().enumerate() {
        gltf.node(Node::mesh(ball).at(index as f32 * 1.7 - 1.7, 0.0, 0.0));
    }
    let mut levels: Vec<Json> = Vec::new();
    for level in 0..3 {
        let mut faces = Vec::new();
        for face in 0..6 {
            faces.push(face_image(SIZE >> level, face, level as f32 / 2.0).add_to(&mut gltf, "sky")?);
        }
        levels.push(list(faces));
    }
    let light = object([
        ("intensity", 0.8.into()),
        ("irradianceCoefficients", list(irradiance().map(|c| list(c.to_array())))),
        ("specularImageSize", (SIZE as usize).into()),
        ("specularImages", levels.into()),
    ]);
    gltf.extension("EXT_lights_image_based", object([("lights", list([light]))]));
    let scene = gltf.scene("sky", &[0, 1, 2, 3]);
    let chosen = object([("EXT_lights_image_based", object([("light", 0.into())]))]);
    gltf.extend("scenes", scene, chosen);
    Ok(gltf)
}

/// A wall of the cube seen from inside, blurred towards the mean as `roughness` grows.
fn face_image(size: u32, face: usize, roughness: f32) -> Image {
    let walls = [
        (Vec3::X, Vec3::Y),
        (Vec3::NEG_X, Vec3::Y),
        (Vec3::Y, Vec3::NEG_Z),
        (Vec3::NEG_Y, Vec3::Z),
        (Vec3::Z, Vec3::Y),
        (Vec3::NEG_Z, Vec3::Y),
    ];
    let (forward, up) = walls[face];
    let mean = Vec3::new(0.6, 0.665, 0.825);
    Image::new(size, size, |x, y| {
        let place = |texel: u32| (texel as f32 + 0.5) / size as f32 * 2.0 - 1.0;
        let direction = (forward + forward.cross(up) * place(x) - up * place(y)).normalize();
        let radiance = sky(direction);
        rgbd(radiance + (mean - radiance) * (roughness * 0.8))
    })
}

/// Colour divided by alpha, in sRGB.
fn rgbd(radiance: Vec3) -> [u8; 4] {
    let greatest = radiance.max_element();
    let divisor = if greatest > 1.0 { libm::ceilf(255.0 / greatest) - 1.0 } else { 255.0 };
    let encoded = (radiance * (divisor / 255.0)).to_array().map(|channel| {
        let srgb = if channel <= 0.003_130_8 {
            channel * 12.92
        } else {
            1.055 * libm::powf(channel, 1.0 / 2.4) - 0.055
        };
        scene_builder::image::byte(srgb)
    });
    [encoded[0], encoded[1], encoded[2], divisor as u8]
}

/// The irradiance of [`sky`] up to the second band. Linear light a + b·n gives π a + 2π/3 b·n; a lobe of 1.5 max(x, 0) has
/// the coefficients 1.5 · (1/4, 1/2, 5/16) over Legendre polynomials of x, whose irradiance factors are π, 2π/3 and π/4.
fn irradiance() -> [Vec3; 9] {
    let ground = Vec3::new(0.25, 0.18, 0.1);
    let mean = (ground + Vec3::new(0.2, 0.4, 0.8)) * 0.5;
    let slope = (Vec3::new(0.2, 0.4, 0.8) - ground) * 0.5;
    let basis0 = 0.5 / PI.sqrt();
    let basis1 = (3.0 / (4.0 * PI)).sqrt();
    let constant = (mean + Vec3::splat(1.5 * 0.25)) * PI;
    let along_y = slope * (2.0 * PI / 3.0);
    let along_x = Vec3::splat(1.5 * 0.5 * 2.0 * PI / 3.0);
    // P₂(x) = (3x² − 1) / 2 in terms of Y₂₀ ~ 3z² − 1 and Y₂₂ ~ x² − y²: 3x² − 1 = −(3z² − 1)/2 + 3(x² − y²)/2.
    let curved = 1.5 * 5.0 / 16.0 * PI / 4.0;
    let basis20 = (5.0 / (16.0 * PI)).sqrt();
    let basis22 = 0.5 * (15.0 / (4.0 * PI)).sqrt();
    let zero = Vec3::ZERO;
    [
        constant / basis0,
        along_y / basis1,
        zero,
        along_x / basis1,
        zero,
        zero,
        Vec3::splat(-0.25 * curved / basis20),
        zero,
        Vec3::splat(0.75 * curved / basis22),
    ]
}
