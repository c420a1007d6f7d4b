//! Scenes in memory that several subjects share: a stage of one pixel, meshes, materials, clips and sequence jobs.
//!
//! Tests of glTF files build theirs with the crate `scene_builder`.

use std::path::Path;

use glam::{Mat4, Quat, Vec3, Vec4};
use rayframe::bvh::{BuildSettings, Builder};
use rayframe::cancel::CancelFlag;
use rayframe::color::ToneCurve;
use rayframe::film::{Film, PixelWindow};
use rayframe::frame::Frame;
use rayframe::output::ExrOutput;
use rayframe::render::{RenderSettings, SceneView, render_frame};
use rayframe::scene::{
    Animation, AnimationIndex, AnimationTarget, Channel, Environment, Image, ImageIndex, Interpolation,
    Keyframes, Light, LightIndex, LightKind, LocalTransform, Material, MaterialIndex, Mesh, MeshIndex, Node,
    NodeIndex, Primitive, Projection, Sampler, Scene, SelectedCamera, Selection, Texels, Texture,
    TextureIndex, TextureRef, UvTransform,
};
use rayframe::sequence::{
    ExistingFiles, Exposure, FirstPose, FrameRate, KnownShares, OutputPattern, SequenceJob, SequenceOutputs,
    Shutter,
};

/// A scene, its environment and its render settings.
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

    /// Adds a root node.
    pub(crate) fn push_node(&mut self, node: Node) {
        self.scene.node_order.push(NodeIndex(self.scene.nodes.len() as u32));
        self.scene.nodes.push(node);
    }

    /// Adds a mesh of one primitive in world space.
    pub(crate) fn add(&mut self, primitive: Primitive, material: Material) {
        let material_index = MaterialIndex(self.scene.materials.len() as u32);
        self.scene.materials.push(material);
        let mesh = MeshIndex(self.scene.meshes.len() as u32);
        let primitive = Primitive { material: material_index, ..primitive };
        self.scene.meshes.push(Mesh { primitives: vec![primitive], ..Default::default() });
        self.push_node(Node { mesh: Some(mesh), ..Default::default() });
    }

    /// Adds a texture of one texel.
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

    /// Radiance and coverage of the first pixel, seen from `eye` towards `target`.
    pub(crate) fn look(&self, eye: Vec3, target: Vec3) -> Vec4 {
        Vec4::from_array(self.render(eye, target).pixels[0])
    }

    /// Renders the view from `eye` towards `target`.
    #[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
    pub(crate) fn render(&self, eye: Vec3, target: Vec3) -> Film {
        let backward = (eye - target).normalize();
        let (right, up) = backward.any_orthonormal_pair();
        let world_from_camera =
            Mat4::from_cols(right.extend(0.0), up.extend(0.0), backward.extend(0.0), eye.extend(1.0));
        let projection = self.projection;
        let selection = select_all(&self.scene, SelectedCamera::Fixed { world_from_camera, projection });
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

/// A closed box around `center` with outward faces.
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

/// A Lambertian material: with an index of refraction of one there is no specular lobe.
pub(crate) fn lambert(color: Vec3) -> Material {
    Material { base_color: color.extend(1.0), metallic: 0.0, ior: 1.0, ..Material::default() }
}

/// A material of the same radiance in all directions.
pub(crate) fn unlit(color: Vec3) -> Material {
    Material { base_color: color.extend(1.0), unlit: true, double_sided: true, ..Material::default() }
}

/// A black, smooth dielectric, which shows its specular reflection alone.
pub(crate) fn black_gloss(ior: f32) -> Material {
    let base_color = Vec4::new(0.0, 0.0, 0.0, 1.0);
    Material { base_color, metallic: 0.0, roughness: 0.0, ior, ..Material::default() }
}

/// Asserts that the radiance is `expected` within `tolerance`.
#[track_caller]
pub(crate) fn assert_close(actual: Vec4, expected: Vec3, tolerance: f32) {
    let difference = (actual.truncate() - expected).abs().max_element();
    assert!(difference <= tolerance, "{actual} is not {expected} within {tolerance}");
}

/// Adds a clip of one linear channel from `from` at 0 s to `to` at 1 s.
pub(crate) fn animate(scene: &mut Scene, target: AnimationTarget, from: &[f32], to: &[f32]) {
    animate_by_keys(scene, target, &[(0.0, from), (1.0, to)]);
}

/// Adds a clip of one channel that is linear between keys of times and values.
pub(crate) fn animate_by_keys(scene: &mut Scene, target: AnimationTarget, keys: &[(f32, &[f32])]) {
    let keyframes = Keyframes {
        times_seconds: keys.iter().map(|(seconds, _)| *seconds).collect(),
        values: keys.iter().flat_map(|(_, values)| values.iter().copied()).collect(),
        width: keys[0].1.len(),
        interpolation: Interpolation::Linear,
    };
    scene.animations.push(Animation { name: None, channels: vec![Channel { target, keyframes }] });
}

/// All nodes and clips of a scene, seen by `camera`.
pub(crate) fn select_all(scene: &Scene, camera: SelectedCamera) -> Selection {
    Selection {
        roots: scene.node_order.clone(),
        clips: (0..scene.animations.len() as u32).map(AnimationIndex).collect(),
        camera,
        camera_changes: rayframe::scene::CameraChanges::default(),
        image_light: None,
        variant: None,
    }
}

/// A job of one sample a pixel that renders all of `scene` to the frame pattern `output`.
#[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
pub(crate) fn sequence_job(
    scene: Scene,
    camera: SelectedCamera,
    resolution: (u32, u32),
    output: &Path,
) -> SequenceJob {
    SequenceJob {
        selection: select_all(&scene, camera),
        scene: scene.into(),
        camera_follows_clips: false,
        environment: Environment::None,
        is_environment_default: false,
        frames: vec![1],
        rate: FrameRate::FILM,
        shutter: Shutter::default(),
        first_pose: FirstPose::default(),
        known_shares: KnownShares::default(),
        render: RenderSettings {
            resolution,
            window: PixelWindow::full(resolution.0, resolution.1),
            samples: 1,
            ..RenderSettings::default()
        },
        build: BuildSettings::default(),
        output: OutputPattern::parse(output.as_os_str()).unwrap(),
        exr: ExrOutput::default(),
        preview: false,
        sequence_outputs: SequenceOutputs::default(),
        exposure: Exposure::Auto,
        shared_exposure: None,
        tone: ToneCurve::Standard,
        display_background: None,
        plates: None,
        existing: ExistingFiles::Protect,
        keep_going: false,
        denoiser: None,
        checkpoint: false,
        write_behind: true,
        strict: false,
        max_memory_bytes: 1 << 30,
    }
}
