//! Scenes of `material/` about transmission.

use glam::{Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::material::{Material, Volume};
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, cuboid, ico_sphere, quad, upright_prism, uv_sphere};
use scene_builder::staging::{camera, chequered_floor, chequered_wall, directional_light, grey_floor};

pub(crate) const SCENES: [Entry; 8] = [
    entry("material/glass_sphere", glass_sphere),
    entry("material/glass_slab_offset", glass_slab_offset),
    entry("material/thin_glass", thin_glass),
    entry("material/absorption_thickness", absorption_thickness),
    entry("material/total_internal_reflection", total_internal_reflection),
    entry("material/nested_glass", nested_glass),
    entry("material/ior_row", ior_row),
    entry("material/glass_shadow", glass_shadow),
];

fn glass_sphere() -> Built {
    let mut gltf = Gltf::new(
        "A solid glass ball over a chequered floor before a wall that is blue on the left and red on the right: in the \
         ball the picture is upside down and mirrored, blue on the right, the floor at the top.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.1, 4.5), Vec3::new(0.0, 0.8, 0.0), 32.0);
    chequered_floor(&mut gltf, [16, 12], 0.5);
    two_colour_wall(&mut gltf, -3.0);
    let glass = Material::glass("glass", 1.5).add_to(&mut gltf);
    let ball = uv_sphere(0.8, 40, 20).plain().add_to(&mut gltf, glass);
    gltf.node(Node::mesh(ball).at(0.0, 0.82, 0.0));
    Ok(gltf)
}

fn two_colour_wall(gltf: &mut Gltf, z: f32) {
    let blue = Material::matte("blue", [0.06, 0.15, 0.65]).add_to(gltf);
    let red = Material::matte("red", [0.7, 0.08, 0.05]).add_to(gltf);
    let halves = quad(4.0, 3.0).plain().add_with_each(gltf, &[blue, red]);
    gltf.node(Node::mesh(halves[0]).at(-2.0, 1.5, z));
    gltf.node(Node::mesh(halves[1]).at(2.0, 1.5, z));
}

/// Upright stripes, `stripe` metres wide, facing +Z.
fn striped_wall(gltf: &mut Gltf, stripes: u32, stripe: f32, height: f32) -> usize {
    let light = Material::unlit("light stripes", [0.8, 0.8, 0.75]).add_to(gltf);
    let dark = Material::unlit("dark stripes", [0.05, 0.08, 0.15]).add_to(gltf);
    // One row of a chequered wall, scaled.
    let wall = chequered_wall(gltf, [stripes, 1], stripe, [light, dark]);
    gltf.node(Node::mesh(wall).named("stripes").scaled(1.0, height / stripe, 1.0))
}

fn glass_slab_offset() -> Built {
    let mut gltf = Gltf::new(
        "A glass slab 0.4 m thick, turned by 45°, before upright stripes, seen without perspective: through the slab \
         the stripes keep their width and are moved sideways by 0.13 m, which is 0.4 · sin 45° · \
         (1 − cos 45° / √(1.5² − sin² 45°)).",
    );
    let camera = gltf.add("cameras", crate::camera::orthographic(1.6, 0.9));
    gltf.node(Node { camera: Some(camera), ..Node::default() }.at(0.0, 0.0, 3.0));
    striped_wall(&mut gltf, 30, 0.25, 4.0);
    let glass = Material::glass("glass", 1.5).add_to(&mut gltf);
    let slab = cuboid(1.6, 1.1, 0.4).plain().add_to(&mut gltf, glass);
    gltf.node(Node::mesh(slab).at(0.0, 0.0, 1.2).turned(Quat::from_rotation_y(std::f32::consts::FRAC_PI_4)));
    Ok(gltf)
}

fn thin_glass() -> Built {
    let mut gltf = Gltf::new(
        "Three thin panes turned by 45° before upright stripes: clear, amber and one of index 2.4; the stripes run on \
         behind all of them without any offset, the third reflects the most.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.9, 4.5), Vec3::new(0.0, 0.7, 0.0), 32.0);
    grey_floor(&mut gltf, 9.0, 6.0);
    let light = Material::matte("light stripes", [0.8, 0.8, 0.75]).add_to(&mut gltf);
    let dark = Material::matte("dark stripes", [0.05, 0.08, 0.15]).add_to(&mut gltf);
    let wall = chequered_wall(&mut gltf, [30, 1], 0.25, [light, dark]);
    gltf.node(Node::mesh(wall).at(0.0, 1.25, -1.5).scaled(1.0, 10.0, 1.0));
    let thin = |name, color: [f32; 3], ior| Material {
        volume: None,
        base_color: [color[0], color[1], color[2], 1.0],
        ..Material::glass(name, ior).two_sided()
    };
    let panes = [
        thin("clear", [1.0; 3], 1.5).add_to(&mut gltf),
        thin("amber", [1.0, 0.6, 0.15], 1.5).add_to(&mut gltf),
        thin("dense", [1.0; 3], 2.4).add_to(&mut gltf),
    ];
    let panes = quad(1.0, 1.2).plain().add_with_each(&mut gltf, &panes);
    for (pane, x) in panes.into_iter().zip([-1.2, 0.0, 1.2]) {
        gltf.node(Node::mesh(pane).at(x, 0.65, 0.0).turned(Quat::from_rotation_y(0.785)));
    }
    Ok(gltf)
}

fn absorption_thickness() -> Built {
    let mut gltf = Gltf::new(
        "Four slabs of one green glass, 0.1, 0.2, 0.4 and 0.8 m thick, before a bright wall: each is the square of its \
         left neighbour's tint. The slabs are one mesh scaled in depth: absorption follows the world's metres.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.0, 6.0), Vec3::ZERO, 20.0);
    let white = Material::unlit("bright wall", [0.9; 3]).add_to(&mut gltf);
    let wall = quad(6.0, 4.0).plain().add_to(&mut gltf, white);
    gltf.node(Node::mesh(wall).at(0.0, 0.0, -1.5));
    let glass = Material {
        volume: Some(Volume { thickness: 0.1, attenuation: Some((0.2, [0.25, 0.8, 0.4])) }),
        ..Material::glass("green glass", 1.5)
    };
    let glass = glass.add_to(&mut gltf);
    let slab = cuboid(0.6, 1.2, 0.1).plain().add_to(&mut gltf, glass);
    for (index, depth) in [1.0, 2.0, 4.0, 8.0].into_iter().enumerate() {
        gltf.node(Node::mesh(slab).at((index as f32 - 1.5) * 0.8, 0.0, 0.0).scaled(1.0, 1.0, depth));
    }
    Ok(gltf)
}

fn total_internal_reflection() -> Built {
    let mut gltf = Gltf::new(
        "A right-angled glass prism, one short side towards the camera: light meets the long side at 45°, beyond the \
         critical 41.8°, so the prism shows the red card at its side as in a perfect mirror and nothing of the green \
         wall behind it.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 24.0);
    let green = Material::unlit("green wall", [0.08, 0.5, 0.12]).add_to(&mut gltf);
    let red = Material::unlit("red card", [0.8, 0.06, 0.04]).add_to(&mut gltf);
    let wall = quad(8.0, 4.0).plain().add_to(&mut gltf, green);
    gltf.node(Node::mesh(wall).at(0.0, 0.0, -3.0));
    // The card stands to the right of the prism and faces it.
    let card = quad(2.4, 2.0).plain().add_to(&mut gltf, red);
    gltf.node(Node::mesh(card).at(1.6, 0.0, 0.0).turned(Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2)));
    let glass = Material::glass("glass", 1.5).add_to(&mut gltf);
    let prism = prism().add_to(&mut gltf, glass);
    gltf.node(Node::mesh(prism).named("prism"));
    Ok(gltf)
}

/// A prism along Y with short sides at z = 0.6 and x = 0.6 and the long side between their far ends.
fn prism() -> TriangleMesh {
    upright_prism([(-0.6, 0.6), (0.6, 0.6), (0.6, -0.6)], 0.6)
}

fn nested_glass() -> Built {
    let mut gltf = Gltf::new(
        "Three glass balls over a chequered floor: with a ball of air inside, which shrinks what is behind it; with a ball \
         of ruby of index 1.8 inside; and with a ball of the same glass inside, which cannot be seen.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.3, 5.0), Vec3::new(0.0, 0.65, 0.0), 30.0);
    chequered_floor(&mut gltf, [16, 16], 0.4);
    let glass = Material::glass("glass", 1.5).add_to(&mut gltf);
    let air = Material::glass("air", 1.0).add_to(&mut gltf);
    let ruby = Material {
        volume: Some(Volume { thickness: 0.5, attenuation: Some((0.3, [0.8, 0.1, 0.15])) }),
        ..Material::glass("ruby", 1.8)
    };
    let ruby = ruby.add_to(&mut gltf);
    let balls = ico_sphere(1.0, 3).add_with_each(&mut gltf, &[glass, air, ruby, glass]);
    for (index, &inner) in balls[1..].iter().enumerate() {
        let x = (index as f32 - 1.0) * 1.4;
        gltf.node(Node::mesh(balls[0]).at(x, 0.65, 0.0).scaled(0.6, 0.6, 0.6));
        gltf.node(Node::mesh(inner).at(x, 0.65, 0.0).scaled(0.35, 0.35, 0.35));
    }
    Ok(gltf)
}

fn ior_row() -> Built {
    let mut gltf = Gltf::new(
        "Six solid balls over a chequered floor, index 1, 1.1, 1.33, 1.5, 1.8 and 2.4 from the left: the first cannot \
         be seen, then bending and reflection grow.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.4, 7.5), Vec3::new(0.0, 0.5, 0.0), 31.0);
    chequered_floor(&mut gltf, [20, 14], 0.4);
    let materials =
        [1.0, 1.1, 1.33, 1.5, 1.8, 2.4].map(|ior| Material::glass("glass", ior).add_to(&mut gltf));
    let balls = ico_sphere(0.5, 3).add_with_each(&mut gltf, &materials);
    for (index, ball) in balls.into_iter().enumerate() {
        gltf.node(Node::mesh(ball).at((index as f32 - 2.5) * 1.15, 0.52, 0.0));
    }
    Ok(gltf)
}

fn glass_shadow() -> Built {
    let mut gltf = Gltf::new(
        "The shadows of three standing plates: of thin red glass light red, of a thick slab of blue glass deep blue, of \
         an opaque card black; no bright rims.",
    );
    camera(&mut gltf, Vec3::new(0.0, 2.6, 4.2), Vec3::new(0.0, 0.3, 0.4), 38.0);
    grey_floor(&mut gltf, 8.0, 8.0);
    directional_light(&mut gltf, Vec3::new(0.1, 1.2, -1.0), 4.0);
    let thin = Material {
        volume: None,
        base_color: [0.9, 0.15, 0.1, 1.0],
        ..Material::glass("thin red", 1.5).two_sided()
    };
    let thin = thin.add_to(&mut gltf);
    let thick = Material {
        volume: Some(Volume { thickness: 0.2, attenuation: Some((0.2, [0.1, 0.2, 0.8])) }),
        ..Material::glass("thick blue", 1.5)
    };
    let thick = thick.add_to(&mut gltf);
    let opaque = Material::matte("card", [0.5, 0.5, 0.5]).two_sided().add_to(&mut gltf);
    let plates = quad(0.9, 0.9).plain().add_with_each(&mut gltf, &[thin, opaque]);
    let slab = cuboid(0.9, 0.9, 0.2).plain().add_to(&mut gltf, thick);
    for (mesh, x) in [(plates[0], -1.3), (slab, 0.0), (plates[1], 1.3)] {
        gltf.node(Node::mesh(mesh).at(x, 0.5, 0.0));
    }
    Ok(gltf)
}
