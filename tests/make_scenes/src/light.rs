//! Scenes of `light/`: a plain floor under each kind of light.

use glam::{Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::json::object;
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{cuboid, cylinder, ico_sphere};
use scene_builder::staging::{camera, grey_floor, light, looking, point_light};

pub(crate) const SCENES: [Entry; 7] = [
    entry("light/point", point),
    entry("light/spot", spot),
    entry("light/directional", directional),
    entry("light/range", range),
    entry("light/frosted_globes", frosted_globes),
    entry("light/environment_only", environment_only),
    entry("light/two_lights_shadows", two_lights_shadows),
];

fn point() -> Built {
    let mut gltf = Gltf::new(
        "A point light 1 m above the middle of a grey floor: a round pool that fades with the square of the distance, \
         and the shadows of four posts running straight away from it.",
    );
    camera(&mut gltf, Vec3::new(0.0, 3.4, 4.6), Vec3::new(0.0, 0.1, 0.0), 45.0);
    grey_floor(&mut gltf, 8.0, 8.0);
    posts(&mut gltf, &[(-0.9, -0.9), (0.9, -0.9), (-0.9, 0.9), (0.9, 0.9)]);
    // 3 cd at 1 m: radiance 0.6 · 3 / π = 0.57 under the light.
    point_light(&mut gltf, Vec3::Y, 3.0);
    Ok(gltf)
}

fn spot() -> Built {
    let mut gltf = Gltf::new(
        "Two spot lights from 2 m: on the left, straight down, a disc of radius 0.73 m with a hard edge (inner and \
         outer angle nearly equal, 20°); on the right, tilted, an ellipse that fades softly from 5° to 25°.",
    );
    camera(&mut gltf, Vec3::new(0.0, 3.6, 3.8), Vec3::new(0.0, 0.0, 0.1), 40.0);
    grey_floor(&mut gltf, 8.0, 8.0);
    let hard = spot_light(&mut gltf, 19.9, 20.0, 16.0);
    let soft = spot_light(&mut gltf, 5.0, 25.0, 26.0);
    let places = [
        (hard, Vec3::new(-1.0, 2.0, 0.0), Vec3::new(-1.0, 0.0, 0.0)),
        (soft, Vec3::new(1.8, 2.0, 0.6), Vec3::new(0.9, 0.0, 0.0)),
    ];
    for (light, from, target) in places {
        let node = Node { light: Some(light), ..Node::default() };
        gltf.node(node.at(from.x, from.y, from.z).turned(looking(from, target)));
    }
    Ok(gltf)
}

fn spot_light(gltf: &mut Gltf, inner_degrees: f32, outer_degrees: f32, candela: f32) -> usize {
    let cone = object([
        ("innerConeAngle", inner_degrees.to_radians().into()),
        ("outerConeAngle", outer_degrees.to_radians().into()),
    ]);
    gltf.light(object([("type", "spot".into()), ("intensity", candela.into()), ("spot", cone)]))
}

fn directional() -> Built {
    let mut gltf = Gltf::new(
        "A directional light from the left: the shadows of all posts are parallel and equally long, the floor is lit \
         evenly. The light's node is far away, below the floor and scaled, none of which matters.",
    );
    camera(&mut gltf, Vec3::new(0.0, 4.0, 4.6), Vec3::new(0.2, 0.0, 0.0), 42.0);
    grey_floor(&mut gltf, 9.0, 9.0);
    posts(&mut gltf, &[(-1.6, -1.0), (0.0, -1.0), (1.6, -1.0), (-1.6, 0.6), (0.0, 0.6), (1.6, 0.6)]);
    let sun = light(&mut gltf, "directional", [1.0, 0.95, 0.85], 4.0);
    gltf.node(
        Node { light: Some(sun), ..Node::default() }
            .at(50.0, -7.0, 3.0)
            .turned(looking(Vec3::new(-1.0, 1.2, 0.3), Vec3::ZERO))
            .scaled(3.0, 3.0, 3.0),
    );
    Ok(gltf)
}

fn range() -> Built {
    let mut gltf = Gltf::new(
        "Two equal point lights over a floor split by a wall: the left one has a range of 1.5 m and its pool ends \
         there in black, the right one has none and reaches the floor's edge.",
    );
    camera(&mut gltf, Vec3::new(0.0, 5.2, 4.6), Vec3::new(0.0, 0.0, 0.2), 42.0);
    grey_floor(&mut gltf, 8.0, 5.0);
    let white = Material::matte("wall", [0.7, 0.7, 0.7]).add_to(&mut gltf);
    let wall = cuboid(0.06, 1.6, 5.0).plain().add_to(&mut gltf, white);
    gltf.node(Node::mesh(wall).named("wall").at(0.0, 0.8, 0.0));
    let near =
        gltf.light(object([("type", "point".into()), ("intensity", 3.0.into()), ("range", 1.5.into())]));
    gltf.node(Node { light: Some(near), ..Node::default() }.at(-2.0, 0.8, 0.0));
    point_light(&mut gltf, Vec3::new(2.0, 0.8, 0.0), 3.0);
    Ok(gltf)
}

fn environment_only() -> Built {
    let mut gltf = Gltf::new(
        "No light at all in the file: the studio gradient and its key light give a white ball soft shading and a shadow on \
         the floor; a chrome ball mirrors the gradient, the floor and its neighbour.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.6, 4.6), Vec3::new(0.0, 0.55, 0.0), 35.0);
    grey_floor(&mut gltf, 7.0, 7.0);
    let white = Material::matte("white", [0.85, 0.85, 0.85]).add_to(&mut gltf);
    let chrome = Material::metal("chrome", [0.9, 0.9, 0.9], 0.0).add_to(&mut gltf);
    let balls = ico_sphere(0.7, 3).add_with_each(&mut gltf, &[white, chrome]);
    gltf.node(Node::mesh(balls[0]).at(-0.9, 0.7, 0.0));
    gltf.node(Node::mesh(balls[1]).at(0.9, 0.7, 0.0));
    Ok(gltf)
}

fn two_lights_shadows() -> Built {
    let mut gltf = Gltf::new(
        "A red light from the left and a cyan one from the right: where both reach, the floor is grey; the ball's \
         shadow of the red light is cyan, of the cyan light red, and black where the two overlap.",
    );
    camera(&mut gltf, Vec3::new(0.0, 3.2, 4.4), Vec3::new(0.0, 0.2, -0.2), 42.0);
    grey_floor(&mut gltf, 10.0, 10.0);
    let white = Material::matte("white", [0.8, 0.8, 0.8]).add_to(&mut gltf);
    let ball = ico_sphere(0.6, 3).add_to(&mut gltf, white);
    gltf.node(Node::mesh(ball).at(0.0, 0.6, 0.0));
    for (x, color) in [(-2.5, [1.0, 0.05, 0.05]), (2.5, [0.05, 1.0, 1.0])] {
        let lamp = light(&mut gltf, "point", color, 35.0);
        gltf.node(Node { light: Some(lamp), ..Node::default() }.at(x, 3.0, 1.5));
    }
    Ok(gltf)
}

fn frosted_globes() -> Built {
    let mut gltf = Gltf::new(
        "Lamps in three globes of frosted glass: a thin one is bright all over, a blown one and a solid ball are brightest in the \
         middle. Two shine on the wall behind; the ball shows it, turned over.",
    );
    camera(&mut gltf, Vec3::new(0.0, 1.0, 5.2), Vec3::new(0.0, 0.6, 0.0), 32.0);
    grey_floor(&mut gltf, 8.0, 8.0);
    let wall = Material::matte("wall", [0.25, 0.35, 0.45]).add_to(&mut gltf);
    let wall = cuboid(8.0, 4.0, 0.1).plain().add_to(&mut gltf, wall);
    gltf.node(Node::mesh(wall).at(0.0, 2.0, -1.5));
    let glass = |name| Material { roughness: 0.6, ..Material::glass(name, 1.5) };
    let thin = Material { volume: None, ..glass("thin frosted glass") }.two_sided().add_to(&mut gltf);
    let solid = glass("frosted glass").add_to(&mut gltf);
    let air = Material::glass("air", 1.0).add_to(&mut gltf);
    let globes = ico_sphere(0.5, 3).plain().add_with_each(&mut gltf, &[thin, solid, air]);
    gltf.node(Node::mesh(globes[2]).named("hollow").at(0.0, 0.6, 0.0).scaled(0.92, 0.92, 0.92));
    for (x, mesh) in [(-1.3, globes[0]), (0.0, globes[1]), (1.3, globes[1])] {
        gltf.node(Node::mesh(mesh).at(x, 0.6, 0.0));
        point_light(&mut gltf, Vec3::new(x, 0.6, 0.0), 1.2);
    }
    Ok(gltf)
}

fn posts(gltf: &mut Gltf, places: &[(f32, f32)]) {
    let material = Material::matte("posts", [0.7, 0.55, 0.35]).add_to(gltf);
    let mesh = cylinder(0.07, 0.6, 16).plain().add_to(gltf, material);
    for &(x, z) in places {
        gltf.node(Node::mesh(mesh).named("post").at(x, 0.3, z).turned(Quat::IDENTITY));
    }
}
