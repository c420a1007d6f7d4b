//! A scene put together in code and looked at through one pixel.

use glam::{Mat4, Quat, Vec3, Vec4};
use rayframe::bvh::{BuildSettings, Builder};
use rayframe::cancel::CancelFlag;
use rayframe::film::{Film, PixelWindow};
use rayframe::frame::Frame;
use rayframe::render::{RenderSettings, SceneView, render_frame};
use rayframe::scene::{
    Environment, Image, ImageIndex, Light, LightIndex, LightKind, LocalTransform, Material, MaterialIndex,
    Mesh, MeshIndex, Node, NodeIndex, Primitive, Projection, Sampler, Scene, SelectedCamera, Selection,
    Texels, Texture, TextureIndex, TextureRef, UvTransform,
};

/// Objects and lights, and how they are rendered.
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) environment: Environment,
    pub(crate) settings: RenderSettings,
    pub(crate) projection: Projection,
}

impl Stage {
    pub(crate) fn new() -> Self {
        let settings = RenderSettings {
            resolution: (1, 1),
            window: PixelWindow::full(1, 1),
            samples: 1,
            ..RenderSettings::default()
        };
        let projection =
            Projection::Perspective { fov_y_radians: 0.5, aspect_ratio: None, z_near: 0.0, z_far: None };
        Self { scene: Scene::default(), environment: Environment::None, settings, projection }
    }

    fn push_node(&mut self, node: Node) {
        self.scene.node_order.push(NodeIndex(self.scene.nodes.len() as u32));
        self.scene.nodes.push(node);
    }

    /// Adds a mesh primitive in world space.
    pub(crate) fn add(&mut self, primitive: Primitive, material: Material) {
        let material_index = MaterialIndex(self.scene.materials.len() as u32);
        self.scene.materials.push(material);
        let mesh = MeshIndex(self.scene.meshes.len() as u32);
        let primitive = Primitive { material: material_index, ..primitive };
        self.scene.meshes.push(Mesh { primitives: vec![primitive], ..Default::default() });
        self.push_node(Node { mesh: Some(mesh), ..Default::default() });
    }

    /// Adds a picture of one texel.
    pub(crate) fn add_texel(&mut self, texel: [u8; 4]) -> TextureRef {
        let image = ImageIndex(self.scene.images.len() as u32);
        let texels = Texels::Rgba8(vec![texel]);
        self.scene.images.push(Image { name: None, width: 1, height: 1, texels });
        let texture = TextureIndex(self.scene.textures.len() as u32);
        self.scene.textures.push(Texture { name: None, image, sampler: Sampler::default() });
        TextureRef { texture, uv_set: 0, transform: UvTransform::default() }
    }

    /// Adds a light at `position` that shines along `direction`.
    pub(crate) fn add_light(&mut self, kind: LightKind, intensity: f32, position: Vec3, direction: Vec3) {
        let index = LightIndex(self.scene.lights.len() as u32);
        self.scene.lights.push(Light { name: None, color: Vec3::ONE, intensity, range: None, kind });
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction.normalize());
        let local = LocalTransform::Trs { translation: position, rotation, scale: Vec3::ONE };
        self.push_node(Node { light: Some(index), local, ..Default::default() });
    }

    /// Radiance and coverage that a camera at `eye` sees towards `target`.
    pub(crate) fn look(&self, eye: Vec3, target: Vec3) -> Vec4 {
        Vec4::from_array(self.picture(eye, target).pixels[0])
    }

    /// The picture of a camera at `eye` that looks towards `target`.
    #[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
    pub(crate) fn picture(&self, eye: Vec3, target: Vec3) -> Film {
        let backward = (eye - target).normalize();
        let (right, up) = backward.any_orthonormal_pair();
        let world_from_camera =
            Mat4::from_cols(right.extend(0.0), up.extend(0.0), backward.extend(0.0), eye.extend(1.0));
        let projection = self.projection;
        let selection = Selection {
            roots: self.scene.node_order.clone(),
            clips: Vec::new(),
            camera: SelectedCamera::Fixed { world_from_camera, projection },
            image_light: None,
            variant: None,
        };
        let frame = Frame::at(&self.scene, &selection, 0.0);
        let cancel = CancelFlag::new();
        let bvh = Builder::default()
            .build(&frame.triangles, &frame.flags, &BuildSettings::default(), &cancel, None)
            .unwrap();
        let input =
            SceneView { scene: &self.scene, frame: &frame, bvh: &bvh, environment: &self.environment };
        let (film, _) = render_frame(&input, &self.settings, &cancel, &|_| ()).unwrap();
        film
    }
}

/// A rectangle around `center` spanned by the half edges `u` and `v`; its front is the side of `u × v`.
pub(crate) fn rectangle(center: Vec3, u: Vec3, v: Vec3) -> Primitive {
    primitive(
        vec![center - u - v, center + u - v, center + u + v, center - u + v],
        vec![[0, 1, 2], [0, 2, 3]],
    )
}

/// A closed box with faces outwards.
pub(crate) fn cuboid(center: Vec3, half: Vec3) -> Primitive {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut outward = Vec3::ZERO;
            outward[axis] = sign;
            let mut u = Vec3::ZERO;
            u[(axis + 1) % 3] = half[(axis + 1) % 3];
            let mut v = Vec3::ZERO;
            v[(axis + 2) % 3] = half[(axis + 2) % 3] * sign;
            let face = rectangle(center + outward * half, u, v);
            let first = positions.len() as u32;
            positions.extend(face.positions);
            triangles.extend(face.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
        }
    }
    primitive(positions, triangles)
}

fn primitive(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Primitive {
    Primitive { positions, triangles, material: MaterialIndex(0), ..Primitive::default() }
}

/// Pure Lambert: an index of refraction of one leaves no specular lobe.
pub(crate) fn lambert(color: Vec3) -> Material {
    Material { base_color: color.extend(1.0), metallic: 0.0, ior: 1.0, ..Material::default() }
}

/// Sends the same radiance everywhere.
pub(crate) fn unlit(color: Vec3) -> Material {
    Material { base_color: color.extend(1.0), unlit: true, double_sided: true, ..Material::default() }
}

/// A black, smooth dielectric: all that is seen is its specular reflection.
pub(crate) fn black_gloss(ior: f32) -> Material {
    let base_color = Vec4::new(0.0, 0.0, 0.0, 1.0);
    Material { base_color, metallic: 0.0, roughness: 0.0, ior, ..Material::default() }
}

#[track_caller]
pub(crate) fn assert_close(actual: Vec4, expected: Vec3, tolerance: f32) {
    let difference = (actual.truncate() - expected).abs().max_element();
    assert!(difference <= tolerance, "{actual} is not {expected} within {tolerance}");
}
