//! Scenes of `material/` about opaque surfaces; glass has its own file.

use glam::{Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{Filter, Image};
use scene_builder::material::{Alpha, Material, TextureUse};
use scene_builder::node::Node;
use scene_builder::shapes::{cuboid, ico_sphere, quad};
use scene_builder::staging::{
    camera, chequered_floor, directional_light, grey_floor, lit_stage, point_light,
};

pub(crate) const SCENES: [Entry; 9] = [
    entry("material/diffuse", diffuse),
    entry("material/metal_roughness_row", metal_roughness_row),
    entry("material/dielectric_roughness_row", dielectric_roughness_row),
    entry("material/mirror", mirror),
    entry("material/emissive_strength", emissive_strength),
    entry("material/unlit", unlit),
    entry("material/alpha_mask", alpha_mask),
    entry("material/alpha_blend_stack", alpha_blend_stack),
    entry("material/double_sided", double_sided),
];

fn diffuse() -> Built {
    let mut gltf = Gltf::new(
        "Five matte balls, black, grey, white, red and blue, lit from the upper right; no highlights, terminators at \
         the same place on all.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.2, 6.5), Vec3::new(0.0, 0.5, 0.0), 31.0);
    grey_floor(&mut gltf, 9.0, 6.0);
    let colors = [
        ("black", [0.0, 0.0, 0.0]),
        ("grey", [0.2, 0.2, 0.2]),
        ("white", [0.85, 0.85, 0.85]),
        ("red", [0.7, 0.06, 0.05]),
        ("blue", [0.05, 0.12, 0.6]),
    ];
    let materials = colors.map(|(name, color)| Material::matte(name, color).add_to(&mut gltf));
    row_of_balls(&mut gltf, &materials);
    Ok(gltf)
}

fn metal_roughness_row() -> Built {
    let mut gltf = Gltf::new(
        "Six gold balls under the studio, roughness 0, 0.1, 0.2, 0.3, 0.5 and 1 from the left: from a mirror to a dull \
         glow without a jump in brightness between neighbours.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.4, 7.5), Vec3::new(0.0, 0.5, 0.0), 31.0);
    chequered_floor(&mut gltf, [16, 10], 0.5);
    let steps = [0.0, 0.1, 0.2, 0.3, 0.5, 1.0];
    let materials =
        steps.map(|roughness| Material::metal("gold", [1.0, 0.72, 0.3], roughness).add_to(&mut gltf));
    row_of_balls(&mut gltf, &materials);
    Ok(gltf)
}

fn dielectric_roughness_row() -> Built {
    let mut gltf = Gltf::new(
        "Six dark green balls of plastic under the studio, roughness 0, 0.1, 0.2, 0.3, 0.5 and 1 from the left: the \
         reflection is faint in the middle and strong at the rim, and blurs to a sheen.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.4, 7.5), Vec3::new(0.0, 0.5, 0.0), 31.0);
    chequered_floor(&mut gltf, [16, 10], 0.5);
    let steps = [0.0, 0.1, 0.2, 0.3, 0.5, 1.0];
    let materials = steps.map(|roughness| {
        let plastic = Material { roughness, ..Material::matte("plastic", [0.02, 0.2, 0.08]) };
        plastic.add_to(&mut gltf)
    });
    row_of_balls(&mut gltf, &materials);
    Ok(gltf)
}

fn row_of_balls(gltf: &mut Gltf, materials: &[usize]) {
    let balls = ico_sphere(0.5, 3).add_with_each(gltf, materials);
    for (index, ball) in balls.into_iter().enumerate() {
        let x = (index as f32 - (materials.len() - 1) as f32 / 2.0) * 1.15;
        gltf.node(Node::mesh(ball).at(x, 0.5, 0.0));
    }
}

fn mirror() -> Built {
    let mut gltf = Gltf::new(
        "A chrome ball before a flat mirror: the mirror shows the back of the ball and of the red and the blue block, \
         left and right as seen; the ball shows them again, small and curved.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.5, 4.5), Vec3::new(0.0, 0.7, -0.5), 40.0);
    chequered_floor(&mut gltf, [12, 12], 0.5);
    let chrome = Material::metal("chrome", [0.95, 0.95, 0.95], 0.0).add_to(&mut gltf);
    let ball = ico_sphere(0.5, 3).add_to(&mut gltf, chrome);
    gltf.node(Node::mesh(ball).at(0.0, 0.5, 0.0));
    let wall = quad(4.0, 2.0).plain().add_to(&mut gltf, chrome);
    gltf.node(Node::mesh(wall).named("mirror").at(0.0, 1.0, -1.5));
    let red = Material::matte("red", [0.7, 0.06, 0.05]).add_to(&mut gltf);
    let blue = Material::matte("blue", [0.05, 0.12, 0.6]).add_to(&mut gltf);
    let blocks = cuboid(0.5, 0.8, 0.5).plain().add_with_each(&mut gltf, &[red, blue]);
    gltf.node(Node::mesh(blocks[0]).at(-1.1, 0.4, -0.4));
    gltf.node(Node::mesh(blocks[1]).at(1.1, 0.4, -0.4));
    Ok(gltf)
}

fn emissive_strength() -> Built {
    let mut gltf = Gltf::new(
        "Four glowing cards of radiance 0.125, 0.25, 0.5 and 4 in orange, each twice or more as bright as its left \
         neighbour, the last made by emissiveStrength 8; they do not light the floor.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.0, 4.6), Vec3::new(0.0, 0.55, 0.0), 32.0);
    grey_floor(&mut gltf, 8.0, 5.0);
    point_light(&mut gltf, Vec3::new(0.0, 3.0, 2.0), 4.0);
    for (index, (factor, strength)) in
        [(0.125, None), (0.5, Some(0.5)), (0.5, None), (0.5, Some(8.0))].into_iter().enumerate()
    {
        let glow = Material {
            emissive: [factor, factor * 0.5, factor * 0.125],
            emissive_strength: strength,
            ..Material::matte("glow", [0.0; 3])
        };
        let glow = glow.add_to(&mut gltf);
        let card = quad(0.9, 0.9).plain().add_to(&mut gltf, glow);
        gltf.node(Node::mesh(card).at((index as f32 - 1.5) * 1.1, 0.55, 0.0));
    }
    Ok(gltf)
}

fn unlit() -> Built {
    let mut gltf = Gltf::new(
        "Two orange balls on a grey floor: the left one is unlit and a flat disc of one colour, the right one shaded; \
         both cast shadows; the shadow of a bar above the picture crosses the right ball and the floor, not the left ball.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.5, 4.6), Vec3::new(0.0, 0.5, 0.0), 35.0);
    grey_floor(&mut gltf, 7.0, 7.0);
    let flat = Material::unlit("flat", [0.8, 0.3, 0.04]).add_to(&mut gltf);
    let shaded = Material::matte("shaded", [0.8, 0.3, 0.04]).add_to(&mut gltf);
    let balls = ico_sphere(0.6, 3).add_with_each(&mut gltf, &[flat, shaded]);
    gltf.node(Node::mesh(balls[0]).at(-0.95, 0.6, 0.0));
    gltf.node(Node::mesh(balls[1]).at(0.95, 0.6, 0.0));
    // A bar above the view casts a shadow over a band of each ball.
    let bar = cuboid(6.0, 0.12, 0.12).plain().add_to(&mut gltf, shaded);
    gltf.node(Node::mesh(bar).named("bar").at(0.0, 2.2, 1.41));
    Ok(gltf)
}

fn alpha_mask() -> Built {
    let mut gltf = Gltf::new(
        "Two cards with the same round alpha ramp: cutoff 0.25 leaves a large disc, cutoff 0.75 a small one; edges are \
         sharp and the shadows are the same discs.",
    );
    lit_stage(&mut gltf, Vec3::new(-0.6, 1.6, 4.6), Vec3::new(-0.3, 0.6, 0.0), 35.0);
    grey_floor(&mut gltf, 8.0, 8.0);
    let ramp = Image::new(64, 64, |x, y| {
        let (dx, dy) = (x as f32 - 31.5, y as f32 - 31.5);
        let alpha = 1.0 - libm::sqrtf(dx * dx + dy * dy) / 32.0;
        [230, 120, 60, scene_builder::image::byte(alpha)]
    });
    let texture = ramp.texture(&mut gltf, "ramp", Filter::Linear)?;
    for (x, cutoff) in [(-0.8, 0.25), (0.8, 0.75)] {
        let material = Material {
            base_color_texture: Some(TextureUse::of(texture)),
            alpha: Alpha::Mask(cutoff),
            ..Material::matte("masked", [1.0; 3]).two_sided()
        };
        let material = material.add_to(&mut gltf);
        let card = quad(1.3, 1.3).add_to(&mut gltf, material);
        gltf.node(Node::mesh(card).at(x, 0.75, 0.0));
    }
    Ok(gltf)
}

fn alpha_blend_stack() -> Built {
    let mut gltf = Gltf::new(
        "Six half-transparent cards, overlapping like tiles from red in front to violet behind: each overlap mixes the \
         nearer colour over the farther one, two coincident cards at the right end count once each, and shadows \
         darken step by step where cards overlap.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.5, 4.6), Vec3::new(0.0, 0.6, 0.0), 36.0);
    grey_floor(&mut gltf, 9.0, 9.0);
    let colors = [
        [0.8, 0.08, 0.06],
        [0.8, 0.4, 0.05],
        [0.6, 0.7, 0.08],
        [0.08, 0.6, 0.2],
        [0.08, 0.3, 0.7],
        [0.4, 0.1, 0.6],
    ];
    for (index, color) in colors.into_iter().enumerate() {
        let blend = Material {
            base_color: [color[0], color[1], color[2], 0.5],
            alpha: Alpha::Blend,
            ..Material::matte("card", color).two_sided()
        };
        let blend = blend.add_to(&mut gltf);
        let card = quad(1.0, 1.1).plain().add_to(&mut gltf, blend);
        let place = index as f32;
        // The last two lie in one plane: equal distances, told apart by their ids.
        let depth = if index == 5 { 4.0 } else { place };
        gltf.node(Node::mesh(card).at(-1.35 + 0.54 * place, 0.6, 0.5 - 0.2 * depth));
    }
    Ok(gltf)
}

fn double_sided() -> Built {
    let mut gltf = Gltf::new(
        "Three cards turned away from the camera cast the same shadow: the left one is single-sided and cannot be \
         seen, the middle one is double-sided and lit from its back, the right one is two single-sided cards back to back.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.5, 4.6), Vec3::new(0.0, 0.5, 0.0), 36.0);
    grey_floor(&mut gltf, 9.0, 9.0);
    directional_light(&mut gltf, Vec3::new(0.5, 1.5, 1.5), 3.0);
    let single = Material::matte("single", [0.1, 0.4, 0.7]).add_to(&mut gltf);
    let double = Material::matte("double", [0.1, 0.4, 0.7]).two_sided().add_to(&mut gltf);
    let cards = quad(1.0, 1.0).plain().add_with_each(&mut gltf, &[single, double]);
    let away = Quat::from_rotation_y(std::f32::consts::PI);
    gltf.node(Node::mesh(cards[0]).named("single").at(-1.3, 0.6, 0.0).turned(away));
    gltf.node(Node::mesh(cards[1]).named("double").at(0.0, 0.6, 0.0).turned(away));
    gltf.node(Node::mesh(cards[0]).named("back").at(1.3, 0.6, -0.01).turned(away));
    gltf.node(Node::mesh(cards[0]).named("front").at(1.3, 0.6, 0.0));
    Ok(gltf)
}
