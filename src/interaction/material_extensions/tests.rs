//! Texture channels and directions of material extensions.

use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::bvh::{BuildSettings, Builder, Hit};
use crate::cancel::CancelFlag;
use crate::frame::{Frame, PosedCamera};
use crate::geometry::{Facing, Ray};
use crate::interaction::{MaterialSample, RayDifferential, surface_at};
use crate::scene::{
    Anisotropy, ClearCoat, DiffuseTransmission, Environment, Glossiness, Image, ImageIndex, Iridescence,
    Material, MaterialIndex, Mesh, MeshIndex, Node, NodeIndex, NormalTexture, Primitive, Sampler, Scene,
    SelectedCamera, Selection, Sheen, Specular, Texels, Texture, TextureIndex, TextureRef, UvTransform,
};
use crate::scene_view::SceneView;

/// Red, green, blue and alpha of 0.2, 0.4, 0.6 and 0.8.
const STEPS: [u8; 4] = [51, 102, 153, 204];

fn texture(index: u32) -> TextureRef {
    TextureRef { texture: TextureIndex(index), uv_set: 0, transform: UvTransform::default() }
}

/// A triangle in the plane z = 0. Its first texture coordinates make +X the tangent, or −X where they are mirrored, and +Y the bitangent; its
/// second ones make +Y the tangent and −X the bitangent.
fn triangle(mirrored: bool) -> Primitive {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    // v grows downwards.
    let uv = |position: &Vec3| Vec2::new(if mirrored { -position.x } else { position.x }, -position.y);
    let turned = |position: &Vec3| Vec2::new(position.y, position.x);
    Primitive {
        uvs: vec![positions.iter().map(uv).collect(), positions.iter().map(turned).collect()],
        positions,
        triangles: vec![[0, 1, 2]],
        material: MaterialIndex(0),
        ..Primitive::default()
    }
}

/// The values of `material`, whose textures have one of `texels` each, on a [`triangle`] seen from +Z.
fn sampled(material: Material, texels: &[[u8; 4]], mirrored: bool) -> MaterialSample {
    sampled_on(triangle(mirrored), material, texels)
}

fn sampled_on(primitive: Primitive, material: Material, texels: &[[u8; 4]]) -> MaterialSample {
    let image =
        |texel: &[u8; 4]| Image { name: None, width: 1, height: 1, texels: Texels::Rgba8(vec![*texel]) };
    let over = |index| Texture { name: None, image: ImageIndex(index), sampler: Sampler::default() };
    let scene = Scene {
        nodes: vec![Node { mesh: Some(MeshIndex(0)), ..Node::default() }],
        node_order: vec![NodeIndex(0)],
        meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
        materials: vec![material],
        images: texels.iter().map(image).collect(),
        textures: (0..texels.len() as u32).map(over).collect(),
        ..Scene::default()
    };
    let projection = PosedCamera::default().projection;
    let selection = Selection {
        camera_changes: crate::scene::CameraChanges::default(),
        image_light: None,
        roots: vec![NodeIndex(0)],
        clips: Vec::new(),
        camera: SelectedCamera::Fixed { world_from_camera: Mat4::IDENTITY, projection },
        variant: None,
    };
    let frame = Frame::at(&scene, &selection, 0.0);
    let (build, cancel) = (BuildSettings::default(), CancelFlag::new());
    let bvh = Builder::default().build(&frame.triangles, &frame.flags, &build, &cancel, None).unwrap();
    let view = SceneView { scene: &scene, frame: &frame, bvh: &bvh, environment: &Environment::None };
    let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
    let hit = Hit { t: 1.0, triangle: 0, u: 0.25, v: 0.25, facing: Facing::Front };
    surface_at(view, &ray, &hit, &RayDifferential::ZERO).1
}

fn of_steps(material: Material) -> MaterialSample {
    sampled(material, &[STEPS], false)
}

/// The linear colour of [`STEPS`].
fn decoded() -> Vec3 {
    Vec3::new(0.2, 0.4, 0.6).map(|code| libm::powf((code + 0.055) / 1.055, 2.4))
}

fn assert_close(found: Vec3, expected: Vec3) {
    assert!((found - expected).abs().max_element() < 1e-5, "{found} is not {expected}");
}

#[test]
fn each_value_reads_its_channel() {
    let map = Some(texture(0));
    let specular = Specular { factor: 0.5, texture: map, color: Vec3::splat(2.0), color_texture: map };
    let sample = of_steps(Material { specular: Some(specular), ..Material::default() });
    assert_close(sample.specular_color, decoded() * 2.0);
    assert!((sample.specular - 0.5 * 0.8).abs() < 1e-6);

    let glossiness = Glossiness { factor: 0.5, texture: map };
    let sample = of_steps(Material { glossiness: Some(glossiness), ..Material::default() });
    assert!((sample.roughness - (1.0 - 0.5 * 0.8)).abs() < 1e-6);

    let coat =
        ClearCoat { factor: 0.5, texture: map, roughness: 0.5, roughness_texture: map, normal_texture: None };
    let coat = of_steps(Material { clear_coat: Some(coat), ..Material::default() }).clear_coat.unwrap();
    assert!((coat.factor - 0.5 * 0.2).abs() < 1e-6 && (coat.roughness - 0.5 * 0.4).abs() < 1e-6);

    let sheen = Sheen { color: Vec3::ONE, color_texture: map, roughness: 0.5, roughness_texture: map };
    let sheen = of_steps(Material { sheen: Some(sheen), ..Material::default() }).sheen.unwrap();
    assert_close(sheen.color, decoded());
    assert!((sheen.roughness - 0.5 * 0.8).abs() < 1e-6);

    let film = Iridescence {
        factor: 0.5,
        texture: map,
        ior: 1.3,
        thickness_minimum_nm: 100.0,
        thickness_maximum_nm: 600.0,
        thickness_texture: map,
    };
    let material = Material { iridescence: Some(film), ..Material::default() };
    let film = of_steps(material.clone()).iridescence.unwrap();
    assert!((film.factor - 0.5 * 0.2).abs() < 1e-6 && (film.thickness_nm - 300.0).abs() < 1e-3);
    // Without a texture it is the maximum.
    let plain = Iridescence { thickness_texture: None, ..material.iridescence.unwrap() };
    let film = of_steps(Material { iridescence: Some(plain), ..Material::default() }).iridescence;
    assert_eq!(film.unwrap().thickness_nm, 600.0);

    let layer = DiffuseTransmission { factor: 0.5, texture: map, color: Vec3::ONE, color_texture: map };
    let sample = of_steps(Material { diffuse_transmission: Some(layer), ..Material::default() });
    assert!((sample.diffuse_transmission - 0.5 * 0.8).abs() < 1e-6);
    assert_close(sample.diffuse_transmission_color, decoded());

    let anisotropy = Anisotropy { strength: 0.5, rotation_radians: 0.0, texture: map };
    let sample = of_steps(Material { anisotropy: Some(anisotropy), ..Material::default() });
    assert!((sample.anisotropy.unwrap().strength - 0.5 * 0.6).abs() < 1e-6);
}

#[test]
fn unlit_materials_have_no_extensions() {
    let sheen = Sheen { color: Vec3::ONE, color_texture: None, roughness: 0.5, roughness_texture: None };
    assert_eq!(of_steps(Material { sheen: Some(sheen), unlit: true, ..Material::default() }).sheen, None);
}

#[test]
fn anisotropy_follows_the_tangent_and_rotates_counter_clockwise() {
    let along = |rotation_degrees: f32, texel: Option<[u8; 4]>, mirrored| {
        let anisotropy = Anisotropy {
            strength: 1.0,
            rotation_radians: rotation_degrees.to_radians(),
            texture: texel.map(|_| texture(0)),
        };
        let material = Material { anisotropy: Some(anisotropy), ..Material::default() };
        sampled(material, &[texel.unwrap_or_default()], mirrored).anisotropy.unwrap().direction
    };
    assert_close(along(0.0, None, false), Vec3::X);
    assert_close(along(90.0, None, false), Vec3::Y);
    // Mirrored coordinates mirror the tangent, and so the rotation.
    assert_close(along(0.0, None, true), Vec3::NEG_X);
    assert_close(along(90.0, None, true), Vec3::Y);
    // Green alone is the bitangent; equal red and green lie between, whatever their length.
    let half = 0.5_f32.sqrt();
    let close = |found: Vec3, expected: Vec3| assert!((found - expected).length() < 0.01, "{found}");
    close(along(0.0, Some([128, 255, 255, 255]), false), Vec3::Y);
    close(along(90.0, Some([128, 255, 255, 255]), false), Vec3::NEG_X);
    close(along(0.0, Some([200, 200, 255, 255]), false), Vec3::new(half, half, 0.0));
}

#[test]
fn coats_use_their_own_normals() {
    // Leaning to +X by 36.87°: (0.6, 0, 0.8) is stored as (0.8, 0.5, 0.9).
    let leaning = [204, 128, 230, 255];
    let map = Some(NormalTexture { texture: texture(0), scale: 1.0 });
    let normal_of = |base, own| {
        let coat = ClearCoat {
            factor: 1.0,
            texture: None,
            roughness: 0.0,
            roughness_texture: None,
            normal_texture: own,
        };
        let material = Material { normal_texture: base, clear_coat: Some(coat), ..Material::default() };
        sampled(material, &[leaning], false).clear_coat.unwrap().normal
    };
    assert_eq!(normal_of(None, None), Vec3::Z);
    assert_eq!(normal_of(map, None), Vec3::Z);
    let leant = normal_of(None, map);
    assert!((leant - Vec3::new(0.6, 0.0, 0.8)).length() < 0.01, "{leant}");
    assert_eq!(normal_of(map, map), leant);
}

#[test]
fn normal_maps_use_the_frame_of_their_own_coordinates() {
    // As above
    let leaning = [204, 128, 230, 255];
    let map = |uv_set| NormalTexture { texture: TextureRef { uv_set, ..texture(0) }, scale: 1.0 };
    let normal_of = |tangent_uv_set: Option<u32>, coat_set| {
        let tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3]);
        let primitive = Primitive { tangents, tangent_uv_set, ..triangle(false) };
        let coat = ClearCoat {
            factor: 1.0,
            texture: None,
            roughness: 0.0,
            roughness_texture: None,
            normal_texture: Some(map(coat_set)),
        };
        let material =
            Material { normal_texture: Some(map(0)), clear_coat: Some(coat), ..Material::default() };
        sampled_on(primitive, material, &[leaning]).clear_coat.unwrap().normal
    };
    let close = |found: Vec3, expected: Vec3| assert!((found - expected).length() < 0.01, "{found}");
    close(normal_of(Some(0), 0), Vec3::new(0.6, 0.0, 0.8));
    close(normal_of(Some(0), 1), Vec3::new(0.0, 0.6, 0.8));
    // Tangents of the file hold for all maps.
    close(normal_of(None, 1), Vec3::new(0.6, 0.0, 0.8));
}

#[test]
fn anisotropy_uses_the_frame_of_its_own_coordinates() {
    let direction = |tangent_uv_set, normal_set: Option<u32>| {
        let tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3]);
        let primitive = Primitive { tangents, tangent_uv_set, ..triangle(false) };
        let map = |uv_set| TextureRef { uv_set, ..texture(0) };
        let anisotropy = Anisotropy { strength: 1.0, rotation_radians: 0.0, texture: Some(map(1)) };
        let normal_texture = normal_set.map(|set| NormalTexture { texture: map(set), scale: 0.0 });
        let material = Material { anisotropy: Some(anisotropy), normal_texture, ..Material::default() };
        // Along the tangent
        sampled_on(primitive, material, &[[255, 128, 255, 255]]).anisotropy.unwrap().direction
    };
    let close = |found: Vec3, expected: Vec3| assert!((found - expected).length() < 0.01, "{found}");
    // A primitive whose tangents another material asked for
    close(direction(Some(0), None), Vec3::Y);
    // A normal map of the same material decides, and so do tangents of the file.
    close(direction(Some(0), Some(0)), Vec3::X);
    close(direction(None, None), Vec3::X);
}
