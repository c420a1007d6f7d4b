//! Scenes of `material/` about glTF material extensions other than transmission.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Quat, Vec3, Vec4};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{Filter, Image, byte};
use scene_builder::json::{list, object};
use scene_builder::material::{
    Anisotropy, ClearCoat, DiffuseTransmission, Iridescence, Material, Sheen, Specular, SpecularGlossiness,
    TextureUse,
};
use scene_builder::node::Node;
use scene_builder::shapes::{TriangleMesh, cuboid, ico_sphere, mesh, quad, upright_prism, uv_sphere};
use scene_builder::staging::{
    camera, chequered_floor, directional_light, grey_floor, lit_stage, point_light,
};

pub(crate) const SCENES: [Entry; 12] = [
    entry("material/clear_coat", clear_coat),
    entry("material/clear_coat_normals", clear_coat_normals),
    entry("material/sheen", sheen),
    entry("material/iridescence", iridescence),
    entry("material/iridescence_thickness", iridescence_thickness),
    entry("material/anisotropy", anisotropy),
    entry("material/anisotropy_texture", anisotropy_texture),
    entry("material/dispersion", dispersion),
    entry("material/diffuse_transmission", diffuse_transmission),
    entry("material/specular", specular),
    entry("material/variants", variants),
    entry("material/specular_glossiness", specular_glossiness),
];

/// Balls side by side on the floor, one of each material, under the studio.
fn row_under_the_studio(gltf: &mut Gltf, materials: &[Material]) {
    camera(gltf, Vec3::new(0.0, 1.4, 7.5), Vec3::new(0.0, 0.5, 0.0), 31.0);
    chequered_floor(gltf, [16, 10], 0.5);
    let materials: Vec<usize> = materials.iter().map(|material| material.add_to(gltf)).collect();
    let balls = ico_sphere(0.5, 3).add_with_each(gltf, &materials);
    for (index, ball) in balls.into_iter().enumerate() {
        let x = (index as f32 - (materials.len() - 1) as f32 / 2.0) * 1.15;
        gltf.node(Node::mesh(ball).at(x, 0.5, 0.0));
    }
}

const COAT: ClearCoat = ClearCoat { factor: 1.0, roughness: 0.0, normal_texture: None };

fn clear_coat() -> Built {
    let mut gltf = Gltf::new(
        "Six dull red balls under the studio: bare, half coated, coated, with coats of roughness 0.25 and 0.5, and a black \
         glowing one that is coated. Smooth coats mirror the floor and their neighbours, faint in the middle and strong at \
         the rim, where they darken the red below.",
    );
    let red = Material { roughness: 0.8, ..Material::matte("red", [0.6, 0.03, 0.02]) };
    let with = |coat| Material { clear_coat: Some(coat), ..red };
    let glow = Material { emissive: [0.3, 0.1, 0.02], ..Material::matte("glow", [0.0; 3]) };
    let materials = [
        red,
        with(ClearCoat { factor: 0.5, ..COAT }),
        with(COAT),
        with(ClearCoat { roughness: 0.25, ..COAT }),
        with(ClearCoat { roughness: 0.5, ..COAT }),
        Material { clear_coat: Some(COAT), ..glow },
    ];
    row_under_the_studio(&mut gltf, &materials);
    Ok(gltf)
}

fn clear_coat_normals() -> Built {
    let mut gltf = Gltf::new(
        "Three cards of rough blue metal that lean back under a lamp at the upper left, which all of them reflect: with ripples \
         in the base and a flat coat, one sharp spot over rippled metal; with ripples in the coat alone, a rippled spot over \
         even metal; with the same ripples in both, ripples all over.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 24.0);
    directional_light(&mut gltf, Vec3::new(-0.25, 1.0, 1.0), 0.4);
    let ripples = Image::normal_map(64, |u, v| {
        let (x, y) = (u - 0.5, v - 0.5);
        let distance = libm::sqrtf(x * x + y * y);
        if distance < 0.01 {
            return [0.0; 2];
        }
        let slope = 0.25 * libm::sinf(distance * TAU * 5.0);
        [slope * x / distance, slope * y / distance]
    });
    let texture = TextureUse::of(ripples.texture(&mut gltf, "ripples", Filter::Linear)?);
    let blue = Material::metal("blue", [0.1, 0.25, 0.7], 0.45);
    let coat = ClearCoat { roughness: 0.12, ..COAT };
    let rippled_coat = ClearCoat { normal_texture: Some(texture), ..coat };
    let materials = [
        Material { normal_texture: Some(texture), clear_coat: Some(coat), ..blue },
        Material { clear_coat: Some(rippled_coat), ..blue },
        Material { normal_texture: Some(texture), clear_coat: Some(rippled_coat), ..blue },
    ];
    for (index, material) in materials.into_iter().enumerate() {
        let material = material.add_to(&mut gltf);
        let card = quad(1.0, 1.4).add_to(&mut gltf, material);
        let lean = Quat::from_rotation_x(-0.35);
        gltf.node(Node::mesh(card).at((index as f32 - 1.0) * 1.15, 0.0, 0.0).turned(lean));
    }
    Ok(gltf)
}

fn sheen() -> Built {
    let mut gltf = Gltf::new(
        "Five dark red balls, lit from behind at the right and a little from the front: bare, then with a pale sheen of roughness \
         0.1, 0.3, 0.6 and 1. The second has a thin bright rim, which widens until the last is pale nearly all over.",
    );
    let cloth = |roughness| Material {
        sheen: Some(Sheen { color: [0.9, 0.8, 0.75], roughness }),
        ..Material::matte("velvet", [0.15, 0.01, 0.02])
    };
    let bare = Material::matte("bare", [0.15, 0.01, 0.02]);
    camera(&mut gltf, Vec3::new(0.0, 1.2, 6.5), Vec3::new(0.0, 0.5, 0.0), 31.0);
    directional_light(&mut gltf, Vec3::new(1.0, 0.8, -0.6), 3.0);
    directional_light(&mut gltf, Vec3::new(-0.5, 1.0, 1.0), 1.5);
    grey_floor(&mut gltf, 9.0, 6.0);
    let materials = [bare, cloth(0.1), cloth(0.3), cloth(0.6), cloth(1.0)];
    let materials = materials.map(|material| material.add_to(&mut gltf));
    let balls = ico_sphere(0.5, 3).add_with_each(&mut gltf, &materials);
    for (index, ball) in balls.into_iter().enumerate() {
        gltf.node(Node::mesh(ball).at((index as f32 - 2.0) * 1.15, 0.5, 0.0));
    }
    Ok(gltf)
}

fn iridescence() -> Built {
    let mut gltf = Gltf::new(
        "Six smooth balls under the studio with thin films: black plastic with 250, 400 and 550 nm, and steel with the same. Each \
         has its own colours, which run through other hues from the middle to the rim.",
    );
    let film =
        |thickness| Iridescence { ior: 1.5, thickness_nm: [100.0, thickness], thickness_texture: None };
    let black = Material { roughness: 0.0, ior: Some(1.8), ..Material::matte("black", [0.01; 3]) };
    let steel = Material::metal("steel", [0.55, 0.55, 0.56], 0.15);
    let thicknesses = [250.0, 400.0, 550.0];
    let on = |base: Material| thicknesses.map(|nm| Material { iridescence: Some(film(nm)), ..base });
    row_under_the_studio(&mut gltf, &[on(black), on(steel)].concat());
    Ok(gltf)
}

fn iridescence_thickness() -> Built {
    let mut gltf = Gltf::new(
        "A soap film on a frame before a dark wall, under even light: the film is 0 nm thick at the top and 1000 nm at the bottom, \
         so that bands of colour run across it, black at the top, then white, and paler the farther down.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 24.0);
    let dark = Material::unlit("dark wall", [0.005; 3]).add_to(&mut gltf);
    let wall = quad(8.0, 5.0).plain().add_to(&mut gltf, dark);
    gltf.node(Node::mesh(wall).at(0.0, 0.0, -1.0));
    // What the film mirrors
    let bright = Material {
        emissive: [1.0; 3],
        emissive_strength: Some(6.0),
        ..Material::matte("bright card", [0.0; 3]).two_sided()
    };
    let bright = bright.add_to(&mut gltf);
    let card = quad(20.0, 20.0).plain().add_to(&mut gltf, bright);
    gltf.node(Node::mesh(card).at(0.0, 0.0, 6.0));
    let ramp = Image::new(1, 256, |_, y| [0, y as u8, 0, 255]);
    let texture = ramp.texture(&mut gltf, "thickness", Filter::Linear)?;
    let film = Iridescence {
        ior: 1.33,
        thickness_nm: [0.0, 1000.0],
        thickness_texture: Some(TextureUse::of(texture)),
    };
    let soap = Material {
        roughness: 0.0,
        ior: Some(1.0),
        transmission: Some(1.0),
        iridescence: Some(film),
        ..Material::matte("soap", [1.0; 3]).two_sided()
    };
    let soap = soap.add_to(&mut gltf);
    let mut pane = quad(2.4, 1.4);
    // Within the texture's first and last row
    for uv in &mut pane.uvs {
        uv.y = uv.y * (255.0 / 256.0) + 0.5 / 256.0;
    }
    let pane = pane.add_to(&mut gltf, soap);
    gltf.node(Node::mesh(pane));
    Ok(gltf)
}

/// Balls whose tangents run around them, one of each material.
fn brushed_balls(gltf: &mut Gltf, materials: &[usize]) -> Vec<usize> {
    let ball = uv_sphere(0.5, 32, 16);
    let mut attributes = ball.attributes(gltf);
    let tangents: Vec<Vec4> = ball.normals.iter().map(|normal| around(*normal).extend(1.0)).collect();
    attributes.set("TANGENT", gltf.vec4s(&tangents));
    let indices = gltf.indices(&ball.indices);
    materials.iter().map(|&material| mesh(gltf, attributes.clone(), indices, material)).collect()
}

fn around(normal: Vec3) -> Vec3 {
    Vec3::Y.cross(normal).normalize_or(Vec3::X)
}

fn anisotropy() -> Built {
    let mut gltf = Gltf::new(
        "Five balls of copper whose tangents run around them, lit by one lamp from the front: strength 0, 0.4, 0.8, 1, and 0.8 turned \
         by a right angle. The highlight is round at first, then ever longer along the parallel, and on the last ball it runs along \
         the meridian.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.0, 6.5), Vec3::new(0.0, 0.5, 0.0), 31.0);
    point_light(&mut gltf, Vec3::new(0.0, 3.0, 6.0), 60.0);
    grey_floor(&mut gltf, 9.0, 6.0);
    let brushed = [(0.0, 0.0), (0.4, 0.0), (0.8, 0.0), (1.0, 0.0), (0.8, FRAC_PI_2)];
    let materials = brushed.map(|(strength, rotation_radians)| {
        let anisotropy = Anisotropy { strength, rotation_radians, texture: None };
        let copper = Material::metal("copper", [0.9, 0.5, 0.35], 0.3);
        Material { anisotropy: Some(anisotropy), ..copper }.add_to(&mut gltf)
    });
    for (index, ball) in brushed_balls(&mut gltf, &materials).into_iter().enumerate() {
        gltf.node(Node::mesh(ball).at((index as f32 - 2.0) * 1.15, 0.5, 0.0));
    }
    Ok(gltf)
}

fn anisotropy_texture() -> Built {
    let mut gltf = Gltf::new(
        "Two round brushed lids, seen without perspective from above in front and lit from above behind: the texture's directions \
         run around the centre of the left one, which is bright to the left and right of it; on the right one they are turned by \
         a right angle and run outwards, and it is bright above and below.",
    );
    let camera = gltf.add("cameras", crate::camera::orthographic(1.92, 1.08));
    let eye = Vec3::new(0.0, 3.0, 3.0);
    let turned = scene_builder::staging::looking(eye, Vec3::ZERO);
    gltf.node(Node { camera: Some(camera), ..Node::default() }.at(eye.x, eye.y, eye.z).turned(turned));
    directional_light(&mut gltf, Vec3::new(0.0, 1.0, -0.4), 0.5);
    grey_floor(&mut gltf, 6.0, 4.0);
    let circles = Image::new(64, 64, |x, y| {
        // v runs down the image and the bitangent up.
        let (dx, dy) = (x as f32 - 31.5, 31.5 - y as f32);
        let distance = libm::sqrtf(dx * dx + dy * dy);
        let strength = if distance < 31.0 { 255 } else { 0 };
        [byte(0.5 - 0.5 * dy / distance), byte(0.5 + 0.5 * dx / distance), strength, 255]
    });
    let texture = TextureUse::of(circles.texture(&mut gltf, "circles", Filter::Linear)?);
    for (x, rotation_radians) in [(-0.8, 0.0), (0.8, FRAC_PI_2)] {
        let anisotropy = Anisotropy { strength: 0.9, rotation_radians, texture: Some(texture) };
        let steel =
            Material { anisotropy: Some(anisotropy), ..Material::metal("steel", [0.6, 0.58, 0.55], 0.25) };
        let steel = steel.add_to(&mut gltf);
        let lid = scene_builder::shapes::floor(1.4, 1.4).add_to(&mut gltf, steel);
        gltf.node(Node::mesh(lid).at(x, 0.05, 0.0));
    }
    Ok(gltf)
}

fn dispersion() -> Built {
    let mut gltf = Gltf::new(
        "Two solid glass balls and two prisms before white and black stripes, without dispersion at the left and with dispersion 2 \
         at the right: through the right ones the stripes have rims of red on one side and blue on the other.",
    );
    camera(&mut gltf, Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 26.0);
    let light = Material::unlit("light stripes", [0.8; 3]).add_to(&mut gltf);
    let dark = Material::unlit("dark stripes", [0.02; 3]).add_to(&mut gltf);
    let wall = scene_builder::staging::chequered_wall(&mut gltf, [24, 1], 0.25, [light, dark]);
    gltf.node(Node::mesh(wall).named("stripes").at(0.0, 0.0, -2.0).scaled(1.0, 24.0, 1.0));
    let clear = Material::glass("glass", 1.5);
    let materials = [clear, Material { dispersion: Some(2.0), ..clear }].map(|glass| glass.add_to(&mut gltf));
    let balls = uv_sphere(0.42, 32, 16).plain().add_with_each(&mut gltf, &materials);
    let prisms = wedge().add_with_each(&mut gltf, &materials);
    for (x, mesh) in [(-1.5, balls[0]), (-0.5, prisms[0]), (0.5, prisms[1]), (1.5, balls[1])] {
        gltf.node(Node::mesh(mesh).at(x, 0.0, 0.0));
    }
    Ok(gltf)
}

/// A slim prism along Y that is thick at the right, flat towards the viewer.
fn wedge() -> TriangleMesh {
    upright_prism([(-0.4, 0.1), (0.4, 0.1), (0.4, -0.35)], 0.45)
}

fn diffuse_transmission() -> Built {
    let mut gltf = Gltf::new(
        "Four sheets of white paper with a strong lamp behind them and a weak one in front, and a ball that casts its shadow on \
         their backs: the first lets nothing through and is dim; the second lets half through, the third all, so that the ball's \
         shadow shows dark on them; the fourth lets all through in green.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.0, 5.0), Vec3::new(0.0, 0.7, 0.0), 30.0);
    grey_floor(&mut gltf, 8.0, 6.0);
    directional_light(&mut gltf, Vec3::new(0.0, 0.6, -1.0), 3.0);
    directional_light(&mut gltf, Vec3::new(0.0, 0.5, 1.0), 0.3);
    let black = Material::matte("ball", [0.02; 3]).add_to(&mut gltf);
    let ball = ico_sphere(0.25, 2).add_to(&mut gltf, black);
    let papers = [(0.0, [1.0; 3]), (0.5, [1.0; 3]), (1.0, [1.0; 3]), (1.0, [0.1, 0.8, 0.2])];
    for (index, (factor, color)) in papers.into_iter().enumerate() {
        let paper = Material {
            diffuse_transmission: Some(DiffuseTransmission { factor, color }),
            ..Material::matte("paper", [0.8; 3]).two_sided()
        };
        let paper = paper.add_to(&mut gltf);
        let sheet = quad(0.9, 1.2).plain().add_to(&mut gltf, paper);
        let x = (index as f32 - 1.5) * 1.05;
        gltf.node(Node::mesh(sheet).at(x, 0.65, 0.0));
        gltf.node(Node::mesh(ball).at(x, 0.95, -0.5));
    }
    Ok(gltf)
}

fn specular() -> Built {
    let mut gltf = Gltf::new(
        "Six smooth dark blue balls under the studio: specular 0, 0.5 and 1, then specular 1 in red, in green four times as strong, \
         and black. The first has no reflection at all; the last three have their colour in the middle, none in the last, and a \
         white rim all.",
    );
    let with = |factor, color| Material {
        roughness: 0.0,
        specular: Some(Specular { factor, color }),
        ..Material::matte("plastic", [0.02, 0.03, 0.12])
    };
    let materials = [
        with(0.0, [1.0; 3]),
        with(0.5, [1.0; 3]),
        with(1.0, [1.0; 3]),
        with(1.0, [1.0, 0.1, 0.1]),
        with(1.0, [0.4, 4.0, 0.4]),
        with(1.0, [0.0; 3]),
    ];
    row_under_the_studio(&mut gltf, &materials);
    Ok(gltf)
}

fn variants() -> Built {
    let mut gltf = Gltf::new(
        "Without a choice of a variant, primitives keep their own materials: a white box and a grey ball. The variants \"red\" and \
         \"gold\" would change both, and only the ball.",
    );
    lit_stage(&mut gltf, Vec3::new(0.0, 1.4, 4.6), Vec3::new(0.0, 0.45, 0.0), 32.0);
    grey_floor(&mut gltf, 7.0, 5.0);
    let own = [("white", [0.8, 0.8, 0.8]), ("grey", [0.2, 0.2, 0.2])];
    let own = own.map(|(name, color)| Material::matte(name, color).add_to(&mut gltf));
    let red = Material::matte("red", [0.7, 0.06, 0.05]).add_to(&mut gltf);
    let gold = Material::metal("gold", [1.0, 0.72, 0.3], 0.2).add_to(&mut gltf);
    gltf.variants(&["red", "gold"]);
    let mapping = |material: usize, variant: usize| {
        object([("material", material.into()), ("variants", list([variant]))])
    };
    let bodies = [
        (cuboid(0.8, 0.8, 0.8).plain(), own[0], vec![mapping(red, 0)], -0.7, 0.4),
        (ico_sphere(0.5, 2), own[1], vec![mapping(red, 0), mapping(gold, 1)], 0.7, 0.5),
    ];
    for (shape, material, mappings, x, y) in bodies {
        let attributes = shape.attributes(&mut gltf);
        let indices = gltf.indices(&shape.indices);
        let choice = object([("KHR_materials_variants", object([("mappings", mappings.into())]))]);
        let primitive = object([
            ("attributes", attributes),
            ("indices", indices.into()),
            ("material", material.into()),
            ("extensions", choice),
        ]);
        let body = gltf.add("meshes", object([("primitives", list([primitive]))]));
        gltf.node(Node::mesh(body).at(x, y, 0.0));
    }
    Ok(gltf)
}

fn specular_glossiness() -> Built {
    let mut gltf = Gltf::new(
        "Five balls under the studio in the older model: green plastic of glossiness 0.3 and 0.9, gold by specular colour of \
         glossiness 1 and 0.6, and one whose texture has gold bands of mirrors between blue bands of dull plastic.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.4, 7.5), Vec3::new(0.0, 0.5, 0.0), 31.0);
    chequered_floor(&mut gltf, [16, 10], 0.5);
    let bands =
        Image::new(1, 16, |_, y| if y / 2 % 2 == 0 { [255, 221, 149, 255] } else { [56, 56, 60, 40] });
    let texture = TextureUse::of(bands.texture(&mut gltf, "bands", Filter::Nearest)?);
    let older = |color, specular, glossiness, texture| Material {
        specular_glossiness: Some(SpecularGlossiness { specular, glossiness, texture }),
        ..Material::matte("older", color)
    };
    let (green, plastic, gold) = ([0.02, 0.3, 0.08], [0.04; 3], [1.0, 0.72, 0.3]);
    let materials = [
        older(green, plastic, 0.3, None),
        older(green, plastic, 0.9, None),
        older([0.0; 3], gold, 1.0, None),
        older([0.0; 3], gold, 0.6, None),
        older([0.02, 0.05, 0.3], [1.0; 3], 1.0, Some(texture)),
    ];
    let materials = materials.map(|material| material.add_to(&mut gltf));
    let balls = uv_sphere(0.5, 32, 16).add_with_each(&mut gltf, &materials);
    for (index, ball) in balls.into_iter().enumerate() {
        gltf.node(Node::mesh(ball).at((index as f32 - 2.0) * 1.15, 0.5, 0.0));
    }
    Ok(gltf)
}
