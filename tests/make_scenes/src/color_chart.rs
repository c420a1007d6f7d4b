//! A chart of 24 known colours, and the differences of a rendered one from them.
//!
//! The chart is no scene of the suite: it has no light of its own, so that the default studio lights it, and it is measured in
//! display colours. Each patch is a card of a rough dielectric, tilted back like the top of an object on a table.

use glam::Quat;

use crate::camera::orthographic;
use crate::color_difference::delta_e_2000;
use scene_builder::document::Gltf;
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::quad;

/// Columns and rows of the chart, and the aspect ratio of its image.
pub const SIZE: (u32, u32) = (6, 4);
/// Angle by which the cards are tilted back.
pub const TILT_DEGREES: f32 = 25.0;
/// Side of a card, where patches are 1 apart.
const SIDE: f32 = 0.7;

/// Names and sRGB colours of the patches, row by row from the top left.
pub const PATCHES: [(&str, [u8; 3]); 24] = [
    ("brick", [146, 62, 48]),
    ("terracotta", [196, 108, 76]),
    ("amber", [214, 152, 44]),
    ("straw", [222, 200, 130]),
    ("olive", [108, 112, 46]),
    ("leaf", [84, 140, 62]),
    ("moss", [58, 84, 50]),
    ("mint", [150, 206, 172]),
    ("teal", [38, 128, 128]),
    ("sky", [120, 172, 214]),
    ("denim", [64, 92, 148]),
    ("navy", [40, 48, 96]),
    ("violet", [104, 72, 150]),
    ("lilac", [184, 160, 208]),
    ("plum", [110, 48, 92]),
    ("rose", [206, 110, 138]),
    ("crimson", [176, 38, 60]),
    ("skin", [224, 176, 148]),
    ("white", [236, 236, 236]),
    ("light grey", [196, 196, 196]),
    ("middle grey", [150, 150, 150]),
    ("grey", [110, 110, 110]),
    ("dark grey", [74, 74, 74]),
    ("black", [44, 44, 44]),
];

/// The chart as a glTF file.
pub fn color_chart() -> String {
    let mut gltf = Gltf::new("A chart of 24 cards of known base colours.");
    let (columns, rows) = (SIZE.0 as f32, SIZE.1 as f32);
    for (index, (name, color)) in PATCHES.into_iter().enumerate() {
        let (column, row) = (index as u32 % SIZE.0, index as u32 / SIZE.0);
        let material = Material::matte(name, color.map(linear)).add_to(&mut gltf);
        let card = quad(SIDE, SIDE).plain().add_to(&mut gltf, material);
        let (x, y) = (column as f32 + 0.5 - columns / 2.0, rows / 2.0 - row as f32 - 0.5);
        let tilt = Quat::from_rotation_x(-TILT_DEGREES.to_radians());
        gltf.node(Node::mesh(card).named(name).at(x, y, 0.0).turned(tilt));
    }
    let camera = gltf.add("cameras", orthographic(columns / 2.0, rows / 2.0));
    gltf.node(Node { camera: Some(camera), ..Node::default() }.named("camera").at(0.0, 0.0, 5.0));
    gltf.to_file_text()
}

/// Decodes an sRGB value.
fn linear(encoded: u8) -> f32 {
    let encoded = f32::from(encoded) / 255.0;
    if encoded > 0.04045 { libm::powf((encoded + 0.055) / 1.055, 2.4) } else { encoded / 12.92 }
}

/// A measured patch.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Name.
    pub name: &'static str,
    /// sRGB base colour.
    pub base: [u8; 3],
    /// Mean sRGB colour of the middle of the rendered patch.
    pub shown: [f64; 3],
    /// ΔE2000 between the two.
    pub delta_e: f64,
}

/// Measures a rendered chart: sRGB pixels of `width` columns, row by row, with [`SIZE`] patches of equal squares.
pub fn measure(width: u32, pixels: &[[u8; 4]]) -> Vec<Patch> {
    let cell = width / SIZE.0;
    // The inner third of each side, within the card and away from its shadow.
    let inner = cell / 3..cell - cell / 3;
    let measured = PATCHES.into_iter().enumerate().map(|(index, (name, base))| {
        let (x0, y0) = (index as u32 % SIZE.0 * cell, index as u32 / SIZE.0 * cell);
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for (y, x) in inner.clone().flat_map(|y| inner.clone().map(move |x| (y0 + y, x0 + x))) {
            let pixel = pixels.get((y * width + x) as usize).copied().unwrap_or_default();
            sum.iter_mut().zip(pixel).for_each(|(sum, channel)| *sum += f64::from(channel));
            count += 1.0;
        }
        let shown = sum.map(|sum| sum / count);
        Patch { name, base, shown, delta_e: delta_e_2000(shown, base.map(f64::from)) }
    });
    measured.collect()
}

/// Mean ΔE2000 of patches.
pub fn mean_delta_e(patches: &[Patch]) -> f64 {
    patches.iter().map(|patch| patch.delta_e).sum::<f64>() / patches.len() as f64
}
