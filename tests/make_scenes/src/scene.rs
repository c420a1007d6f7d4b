//! Scenes of `scene/`: the selection of scenes and nodes.

use glam::Vec3;

use crate::{Entry, entry};
use scene_builder::document::{Built, Gltf};
use scene_builder::json::object;
use scene_builder::material::Material;
use scene_builder::node::Node;
use scene_builder::shapes::{cuboid, ico_sphere};
use scene_builder::staging::{ASPECT_RATIO, grey_floor, light, looking, perspective};

pub(crate) const SCENES: [Entry; 2] =
    [entry("scene/multiple_scenes", multiple_scenes), entry("scene/default_material", default_material)];

fn multiple_scenes() -> Built {
    let mut gltf = Gltf::new(
        "The file's second scene, its default: one green ball on a floor in warm light. The red box and the blue light of \
         the first scene, and the yellow ball of no scene, are not there.",
    );
    let camera = perspective(&mut gltf, 32.0, Some(ASPECT_RATIO));
    let eye = Vec3::new(0.0, 1.3, 4.5);
    let target = Vec3::new(0.0, 0.5, 0.0);
    let camera = Node { camera: Some(camera), ..Node::default() }.at(eye.x, eye.y, eye.z);
    let camera = gltf.node(camera.turned(looking(eye, target)));
    let floor = grey_floor(&mut gltf, 7.0, 5.0);
    let colors = [("red", [0.7, 0.07, 0.05]), ("green", [0.08, 0.5, 0.1]), ("yellow", [0.8, 0.7, 0.1])];
    let materials = colors.map(|(name, color)| Material::matte(name, color).add_to(&mut gltf));
    let red = cuboid(0.8, 0.8, 0.8).plain().add_to(&mut gltf, materials[0]);
    let balls = ico_sphere(0.6, 2).add_with_each(&mut gltf, &materials[1..]);
    let red = gltf.node(Node::mesh(red).at(-1.2, 0.4, 0.0));
    let green = gltf.node(Node::mesh(balls[0]).at(0.0, 0.6, 0.0));
    gltf.node(Node::mesh(balls[1]).named("in no scene").at(1.3, 0.6, 0.0));
    let lights = [[0.2, 0.4, 1.0], [1.0, 0.85, 0.6]].map(|color| {
        let light = light(&mut gltf, "point", color, 40.0);
        gltf.node(Node { light: Some(light), ..Node::default() }.at(1.5, 3.0, 2.0))
    });
    gltf.scene("first", &[camera, floor, red, lights[0]]);
    let second = gltf.scene("second", &[camera, floor, green, lights[1]]);
    gltf.show_scene(second);
    Ok(gltf)
}

fn default_material() -> Built {
    let mut gltf = Gltf::new(
        "A box without a material is a white, fully rough metal: it shows the studio's soft gradient on its sides; the \
         floor is matte grey.",
    );
    let camera = perspective(&mut gltf, 32.0, Some(ASPECT_RATIO));
    let eye = Vec3::new(1.6, 1.6, 4.2);
    let turned = looking(eye, Vec3::new(0.0, 0.45, 0.0));
    gltf.node(Node { camera: Some(camera), ..Node::default() }.at(eye.x, eye.y, eye.z).turned(turned));
    grey_floor(&mut gltf, 7.0, 5.0);
    let shape = cuboid(0.9, 0.9, 0.9).plain();
    let attributes = shape.attributes(&mut gltf);
    let indices = gltf.indices(&shape.indices);
    let primitive = object([("attributes", attributes), ("indices", indices.into())]);
    let mesh = gltf.add("meshes", object([("primitives", vec![primitive].into())]));
    gltf.node(Node::mesh(mesh).at(0.0, 0.45, 0.0));
    Ok(gltf)
}
