//! Scenes of animated properties, hidden nodes and instances. Frames are at 24 fps.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};

use crate::{Entry, entry};
use scene_builder::accessor::{Accessor, Component, Use};
use scene_builder::document::{Built, Gltf};
use scene_builder::image::{Filter, Image};
use scene_builder::json::{Json, list, object};
use scene_builder::material::{Material, TextureTransform, TextureUse};
use scene_builder::node::Node;
use scene_builder::shapes::{cuboid, ico_sphere, quad};
use scene_builder::staging::{camera, flat4, grey_floor, light, lit_stage, looking};

pub(crate) const SCENES: [Entry; 4] = [
    entry("animation/pointer_material", pointer_material),
    entry("animation/pointer_light_camera", pointer_light_camera),
    entry("animation/visibility", visibility),
    entry("geometry/gpu_instancing", gpu_instancing),
];

/// Keys of one property from 0 to 1 s.
struct Moved<'a> {
    pointer: &'a str,
    interpolation: &'a str,
    /// The accessor of the values.
    output: usize,
}

fn moves<'a>(gltf: &mut Gltf, pointer: &'a str, values: &[f32]) -> Moved<'a> {
    let width = values.len() / 2;
    let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1];
    Moved { pointer, interpolation: "LINEAR", output: gltf.track(kind, width, values) }
}

fn clip(gltf: &mut Gltf, moved: &[Moved<'_>]) {
    gltf.uses_extension("KHR_animation_pointer");
    let times = gltf.track("SCALAR", 1, &[0.0, 1.0]);
    let mut samplers: Vec<Json> = Vec::new();
    let mut channels: Vec<Json> = Vec::new();
    for Moved { pointer, interpolation, output } in moved {
        let target = object([
            ("path", "pointer".into()),
            ("extensions", object([("KHR_animation_pointer", object([("pointer", (*pointer).into())]))])),
        ]);
        channels.push(object([("sampler", samplers.len().into()), ("target", target)]));
        samplers.push(object([
            ("input", times.into()),
            ("interpolation", (*interpolation).into()),
            ("output", (*output).into()),
        ]));
    }
    gltf.add("animations", object([("samplers", samplers.into()), ("channels", channels.into())]));
}

fn pointer_material() -> Built {
    let mut gltf = Gltf::new(
        "Left a ball that turns from red to blue within a second, in the middle one that begins to glow in yellow, right a \
         letter F that turns and slides until it stands on its head; at frame 12 the ball is purple, the glow half as strong, \
         and the F a quarter turned and cut by the repeating edge.",
    );
    gltf.reference_frames(&[0, 12, 24]);
    lit_stage(&mut gltf, Vec3::new(0.0, 1.2, 5.0), Vec3::new(0.0, 0.6, 0.0), 30.0);
    grey_floor(&mut gltf, 8.0, 5.0);
    let colour = Material::matte("colour", [0.8, 0.05, 0.05]).add_to(&mut gltf);
    let glow = Material {
        emissive: [1.0, 0.8, 0.2],
        emissive_strength: Some(0.0),
        ..Material::matte("glow", [0.05; 3])
    };
    let glow = glow.add_to(&mut gltf);
    let letter = Image::letter_f(16).texture(&mut gltf, "letter", Filter::Nearest)?;
    let transform = TextureTransform { offset: [0.0; 2], rotation_radians: 0.0, scale: [1.0; 2] };
    let letter = Material {
        base_color_texture: Some(TextureUse { transform: Some(transform), ..TextureUse::of(letter) }),
        ..Material::unlit("letter", [1.0; 3])
    };
    let letter = letter.add_to(&mut gltf);
    let ball = ico_sphere(0.6, 3).plain().add_with_each(&mut gltf, &[colour, glow]);
    let wall = quad(1.2, 1.2).add_to(&mut gltf, letter);
    gltf.node(Node::mesh(ball[0]).at(-1.5, 0.6, 0.0));
    gltf.node(Node::mesh(ball[1]).at(0.0, 0.6, 0.0));
    gltf.node(Node::mesh(wall).at(1.5, 0.6, 0.0));
    let (r, g, b) =
        ([0.8, 0.05, 0.05, 1.0], [0.05, 0.05, 0.8, 1.0], "/materials/1/pbrMetallicRoughness/baseColorFactor");
    let texture = "/materials/3/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform";
    let (rotation, offset) = (format!("{texture}/rotation"), format!("{texture}/offset"));
    let strength = "/materials/2/extensions/KHR_materials_emissive_strength/emissiveStrength";
    let moved = [
        moves(&mut gltf, b, &[r, g].concat()),
        moves(&mut gltf, strength, &[0.0, 1.0]),
        moves(&mut gltf, &rotation, &[0.0, PI]),
        moves(&mut gltf, &offset, &[0.0, 0.0, 1.0, 1.0]),
    ];
    clip(&mut gltf, &moved);
    Ok(gltf)
}

fn pointer_light_camera() -> Built {
    let mut gltf = Gltf::new(
        "A ball in a spot light whose cone opens from 8° to 24° while its colour goes from white to orange, seen by a camera \
         that zooms out from a field of 20° to 40° within a second.",
    );
    gltf.reference_frames(&[0, 12, 24]);
    camera(&mut gltf, Vec3::new(0.0, 1.6, 4.5), Vec3::new(0.0, 0.4, 0.0), 20.0);
    grey_floor(&mut gltf, 10.0, 8.0);
    let spot = object([("innerConeAngle", 0.0.into()), ("outerConeAngle", 8.0_f32.to_radians().into())]);
    let lamp = gltf.light(object([("type", "spot".into()), ("intensity", 40.0.into()), ("spot", spot)]));
    let eye = Vec3::new(1.5, 4.0, 1.5);
    gltf.node(
        Node { light: Some(lamp), ..Node::default() }
            .at(eye.x, eye.y, eye.z)
            .turned(looking(eye, Vec3::ZERO)),
    );
    let fill = light(&mut gltf, "directional", [1.0; 3], 0.3);
    gltf.node(Node { light: Some(fill), ..Node::default() }.turned(looking(Vec3::Y, Vec3::ZERO)));
    let white = Material::matte("ball", [0.8; 3]).add_to(&mut gltf);
    let ball = ico_sphere(0.5, 3).plain().add_to(&mut gltf, white);
    gltf.node(Node::mesh(ball).at(0.0, 0.5, 0.0));
    let lamp = "/extensions/KHR_lights_punctual/lights/0";
    let (color, cone) = (format!("{lamp}/color"), format!("{lamp}/spot/outerConeAngle"));
    let degrees = |from: f32, to: f32| [from.to_radians(), to.to_radians()];
    let moved = [
        moves(&mut gltf, &color, &[1.0, 1.0, 1.0, 1.0, 0.45, 0.1]),
        moves(&mut gltf, &cone, &degrees(8.0, 24.0)),
        moves(&mut gltf, "/cameras/0/perspective/yfov", &degrees(20.0, 40.0)),
    ];
    clip(&mut gltf, &moved);
    Ok(gltf)
}

fn visibility() -> Built {
    let mut gltf = Gltf::new(
        "Three balls: the left one is never shown, nor is its hat; the middle one is there until half a second and gone from \
         then on, with its hat and the lamp in it; the right one stays.",
    );
    gltf.reference_frames(&[11, 12]);
    lit_stage(&mut gltf, Vec3::new(0.0, 1.2, 5.0), Vec3::new(0.0, 0.6, 0.0), 30.0);
    grey_floor(&mut gltf, 8.0, 5.0);
    gltf.uses_extension("KHR_node_visibility");
    let materials = [[0.7, 0.1, 0.1], [0.1, 0.6, 0.1], [0.1, 0.2, 0.7]]
        .map(|color| Material::matte("ball", color).add_to(&mut gltf));
    let balls = ico_sphere(0.5, 3).plain().add_with_each(&mut gltf, &materials);
    let hats = cuboid(0.4, 0.2, 0.4).plain().add_with_each(&mut gltf, &materials);
    let lamp = light(&mut gltf, "point", [1.0, 0.8, 0.4], 4.0);
    for (index, (ball, hat)) in balls.iter().zip(hats).enumerate() {
        let hat = gltf.node(Node::mesh(hat).at(0.0, 0.6, 0.0));
        let lamp =
            gltf.node(Node { light: Some(lamp).filter(|_| index == 1), ..Node::default() }.at(0.0, 1.2, 1.0));
        let children = [hat, lamp];
        let ball = gltf.node(Node { children: children.to_vec(), ..Node::mesh(*ball) }.at(
            index as f32 * 1.4 - 1.4,
            0.5,
            0.0,
        ));
        let visible = object([("visible", (index != 0).into())]);
        gltf.extend("nodes", ball, object([("KHR_node_visibility", visible)]));
        if index == 1 {
            let switch =
                Accessor { used_as: Use::Other, ..Accessor::new(Component::U8, "SCALAR", 2, vec![1, 0]) };
            let output = gltf.accessor(&switch);
            let pointer = format!("/nodes/{ball}/extensions/KHR_node_visibility/visible");
            half_way(&mut gltf, &pointer, output);
        }
    }
    Ok(gltf)
}

/// A clip of one step property with keys at 0 and 0.5 s.
fn half_way(gltf: &mut Gltf, pointer: &str, output: usize) {
    gltf.uses_extension("KHR_animation_pointer");
    let input = gltf.track("SCALAR", 1, &[0.0, 0.5]);
    let target = object([
        ("path", "pointer".into()),
        ("extensions", object([("KHR_animation_pointer", object([("pointer", pointer.into())]))])),
    ]);
    let channel = object([("sampler", 0.into()), ("target", target)]);
    let sampler =
        object([("input", input.into()), ("interpolation", "STEP".into()), ("output", output.into())]);
    gltf.add("animations", object([("samplers", list([sampler])), ("channels", list([channel]))]));
}

fn gpu_instancing() -> Built {
    let mut gltf = Gltf::new(
        "A spiral of 24 blocks that grow and turn as they climb, all from one mesh under a node that leans to the right; the \
         block of the node itself is not drawn.",
    );
    gltf.requires_extension("EXT_mesh_gpu_instancing");
    lit_stage(&mut gltf, Vec3::new(0.0, 2.0, 6.0), Vec3::new(0.0, 1.0, 0.0), 30.0);
    grey_floor(&mut gltf, 8.0, 6.0);
    let material = Material::matte("block", [0.75, 0.5, 0.2]).add_to(&mut gltf);
    let block = cuboid(0.5, 0.12, 0.25).plain().add_to(&mut gltf, material);
    let share = |index: usize| index as f32 / 23.0;
    let angle = |index: usize| share(index) * 1.5 * TAU;
    let translations: Vec<f32> = (0..24)
        .flat_map(|index| {
            let (sine, cosine) = libm::sincosf(angle(index));
            [cosine * 0.9, 0.2 + share(index) * 1.6, sine * 0.9]
        })
        .collect();
    let rotations: Vec<Quat> = (0..24)
        .map(|index| {
            let (sine, cosine) = libm::sincosf(-angle(index) * 0.5);
            Quat::from_xyzw(0.0, sine, 0.0, cosine)
        })
        .collect();
    let packed: Vec<u8> = flat4(&rotations)
        .iter()
        .flat_map(|value| (libm::roundf(value * 32767.0) as i16).to_le_bytes())
        .collect();
    let rotation = Accessor {
        normalized: true,
        used_as: Use::Other,
        ..Accessor::new(Component::I16, "VEC4", 24, packed)
    };
    let scales: Vec<f32> = (0..24).flat_map(|index| [0.4 + 0.6 * share(index), 1.0, 1.0]).collect();
    let attributes = object([
        ("TRANSLATION", gltf.track("VEC3", 3, &translations).into()),
        ("ROTATION", gltf.accessor(&rotation).into()),
        ("SCALE", gltf.track("VEC3", 3, &scales).into()),
    ]);
    let (sine, cosine) = libm::sincosf(-0.1);
    let node = gltf.node(Node::mesh(block).named("spiral").turned(Quat::from_xyzw(0.0, 0.0, sine, cosine)));
    gltf.extend("nodes", node, object([("EXT_mesh_gpu_instancing", object([("attributes", attributes)]))]));
    Ok(gltf)
}
