//! Cost of textures: `cargo bench --bench textures [-- SCENE… --size WxH --frames N --threads N --only NAME]`. A generated scene (balls on a hilly floor, a point light and the studio environment) is traced with and without textures in turn,
//! in one run. Each of its two materials has a base colour, a normal map, and a map of occlusion, roughness and metalness, of
//! 2048x2048 texels each, filtered through mip maps at every distance and angle. Roughness is too high for mirror rays, so
//! all variants trace the same camera rays, and the same shadow rays except where normal maps turn points into or out of the light.
//!
//! A row of the table is one variant: its rays, the median milliseconds of the whole frame (pose, hierarchy, tracing and shading)
//! and of tracing and shading alone, and the growth of each against the first row. `point lookups` is the same textures
//! without mip maps, with one lookup of the full image each. Named scenes are measured instead of the generated one, with and
//! without their textures, with the cameras and lights that `rayframe render` uses by default.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::{Mat4, Vec2, Vec3, Vec4};
use rayframe::bvh::{BuildSettings, Builder, Bvh, Refit};
use rayframe::cancel::CancelFlag;
use rayframe::film::PixelWindow;
use rayframe::frame::Frame;
use rayframe::framing::resolve_camera;
use rayframe::gltf::{ImportOptions, import};
use rayframe::render::{RenderSettings, SceneView, render_frame};
use rayframe::scene::{
    BuiltInLight, Encoding, Environment, Image, ImageIndex, ImageMips, Light, LightIndex, LightKind,
    Material, MaterialIndex, Mesh, MeshIndex, MipFilter, Node, NodeIndex, NormalTexture, OcclusionTexture,
    Primitive, Projection, Sampler, Scene, SelectedCamera, Selection, SelectionRequest, Texels, Texture,
    TextureIndex, TextureRef, UvTransform, ViewRequest, mip_levels,
};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Texels along the side of each image.
const TEXELS: u32 = 2048;
/// Cells along the side of the floor, and of the grid that becomes a ball.
const CELLS: usize = 96;
/// Samples per pixel.
const SAMPLES: u32 = 4;

/// Command-line options.
struct Options {
    size: (u32, u32),
    frames: usize,
    threads: usize,
    /// Only variant besides the first row; all if absent.
    only: Option<String>,
    scenes: Vec<PathBuf>,
}

/// Variant of a scene.
struct Subject {
    name: String,
    scene: Scene,
    selection: Selection,
    environment: Environment,
    frame: Frame,
    builder: Builder,
    bvh: Option<Bvh>,
    rays: u64,
    /// Times of whole frames.
    frame_milliseconds: Vec<f64>,
    /// Times of tracing and shading.
    trace_milliseconds: Vec<f64>,
}

fn main() -> Result<()> {
    let options = options(std::env::args().skip(1))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build()?;
    let mut out = std::io::stdout();
    let (width, height) = options.size;
    writeln!(
        out,
        "{width}x{height}, {SAMPLES} samples, {} threads, medians of {} frames",
        pool.current_num_threads(),
        options.frames
    )?;
    writeln!(
        out,
        "{:<16}{:>12}{:>10}{:>10}{:>10}{:>10}",
        "variant", "rays", "frame", "growth", "trace", "growth"
    )?;
    let sets = if options.scenes.is_empty() {
        vec![generated_variants(options.only.as_deref())]
    } else {
        options.scenes.iter().map(|path| file_variants(path, &options)).collect::<Result<_>>()?
    };
    for mut subjects in sets {
        pool.install(|| measure(&mut subjects, &options)).map_err(|error| error.to_string())?;
        write_rows(&mut out, &subjects)?;
    }
    Ok(())
}

/// Prints a row for each subject, compared with the first.
fn write_rows(out: &mut impl std::io::Write, subjects: &[Subject]) -> Result<()> {
    let times = |subject: &Subject| {
        [&subject.frame_milliseconds, &subject.trace_milliseconds].map(|times| median(times))
    };
    for subject in subjects {
        let (name, rays) = (&subject.name, subject.rays);
        let ([frame, trace], [plain_frame, plain_trace]) = (times(subject), times(&subjects[0]));
        let growth = |time: f64, plain: f64| (time / plain - 1.0) * 100.0;
        writeln!(
            out,
            "{name:<16}{rays:>12}{frame:>10.2}{:>9.1}%{trace:>10.2}{:>9.1}%",
            growth(frame, plain_frame),
            growth(trace, plain_trace)
        )?;
    }
    Ok(())
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<Options> {
    let mut options = Options { size: (640, 360), frames: 9, threads: 0, only: None, scenes: Vec::new() };
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            // Cargo passes this to every benchmark.
            "--bench" => {}
            "--size" => {
                let text = value()?;
                let (width, height) = text.split_once('x').ok_or("--size: write 640x360")?;
                options.size = (width.parse()?, height.parse()?);
            }
            "--frames" => options.frames = value()?.parse()?,
            "--threads" => options.threads = value()?.parse()?,
            "--only" => options.only = Some(value()?),
            flag if flag.starts_with('-') => return Err(format!("{flag} is not an option").into()),
            scene => options.scenes.push(scene.into()),
        }
    }
    Ok(options)
}

/// Variants of the generated scene.
fn generated_variants(only: Option<&str>) -> Vec<Subject> {
    let textured = scene(Some(MipFilter::Linear));
    let mut colored = textured.clone();
    for material in &mut colored.materials {
        material.normal_texture = None;
        material.metallic_roughness_texture = None;
        material.occlusion_texture = None;
    }
    let kinds = [
        ("untextured", scene(None)),
        ("base colour", colored),
        ("all maps", textured),
        ("point lookups", scene(Some(MipFilter::None))),
    ];
    let is_selected = |name: &str| name == "untextured" || only.is_none_or(|only| only == name);
    let kinds = kinds.into_iter().filter(|(name, _)| is_selected(name));
    kinds
        .map(|(name, scene)| {
            Subject::new(name, (selection(&scene), scene), Environment::BuiltIn(BuiltInLight::Studio))
        })
        .collect()
}

/// Variants of a file's scene: without and with its textures.
fn file_variants(path: &Path, options: &Options) -> Result<Vec<Subject>> {
    let scene = import(path, &ImportOptions::default())?;
    let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene)?;
    let (width, height) = options.size;
    let aspect_ratio = width as f32 / height as f32;
    let selection = resolve_camera(&scene, selection, &ViewRequest::default(), aspect_ratio).selection;
    let mut plain = scene.clone();
    plain.materials.iter_mut().for_each(remove_textures);
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let subject = |name: &str, scene: Scene| {
        let mut frame = Frame::default();
        frame.pose(&scene, &selection, 0.0);
        let environment = if frame.lights.is_empty() {
            Environment::BuiltIn(BuiltInLight::Studio)
        } else {
            Environment::None
        };
        Subject::new(name, (selection.clone(), scene), environment)
    };
    Ok(vec![subject("untextured", plain), subject(&name, scene)])
}

fn remove_textures(material: &mut Material) {
    let slots = [
        &mut material.base_color_texture,
        &mut material.metallic_roughness_texture,
        &mut material.emissive_texture,
    ];
    for slot in slots {
        *slot = None;
    }
    material.normal_texture = None;
    material.occlusion_texture = None;
    if let Some(transmission) = &mut material.transmission {
        transmission.texture = None;
    }
    if let Some(coat) = &mut material.clear_coat {
        (coat.texture, coat.roughness_texture, coat.normal_texture) = (None, None, None);
    }
}

impl Subject {
    fn new(name: &str, (selection, scene): (Selection, Scene), environment: Environment) -> Self {
        Self {
            name: name.into(),
            scene,
            selection,
            environment,
            frame: Frame::default(),
            builder: Builder::default(),
            bvh: None,
            rays: 0,
            frame_milliseconds: Vec::new(),
            trace_milliseconds: Vec::new(),
        }
    }
}

/// Renders all variants in turn, so that other load on the machine affects all alike. The first round does not count.
fn measure(
    subjects: &mut [Subject],
    options: &Options,
) -> std::result::Result<(), Box<dyn Error + Send + Sync>> {
    let settings = RenderSettings {
        resolution: options.size,
        window: PixelWindow::full(options.size.0, options.size.1),
        samples: SAMPLES,
        ..RenderSettings::default()
    };
    let build = BuildSettings { refit: Refit::Off, ..BuildSettings::default() };
    let cancel = CancelFlag::new();
    for round in 0..=options.frames {
        for subject in &mut *subjects {
            let start = Instant::now();
            let Subject { scene, selection, environment, frame, builder, bvh, .. } = subject;
            frame.pose(scene, selection, 0.0);
            let built = builder.build(&frame.triangles, &frame.flags, &build, &cancel, bvh.take())?;
            let input = SceneView { scene, frame, bvh: &built, environment };
            let (_, statistics) = render_frame(&input, &settings, &cancel, &|_| ())?;
            *bvh = Some(built);
            let counts = &statistics.integrator;
            subject.rays =
                counts.camera_rays + counts.reflection_rays + counts.refraction_rays + counts.shadow_rays;
            if round > 0 {
                subject.frame_milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
                subject.trace_milliseconds.push(statistics.trace_seconds * 1e3);
            }
        }
    }
    Ok(())
}

fn selection(scene: &Scene) -> Selection {
    let (eye, target) = (Vec3::new(0.5, 1.6, 6.0), Vec3::new(0.0, 0.5, 0.0));
    let backward = (eye - target).normalize();
    let right = Vec3::Y.cross(backward).normalize();
    let up = backward.cross(right);
    let world_from_camera =
        Mat4::from_cols(right.extend(0.0), up.extend(0.0), backward.extend(0.0), eye.extend(1.0));
    let projection =
        Projection::Perspective { fov_y_radians: 0.7, aspect_ratio: None, z_near: 0.0, z_far: None };
    Selection {
        roots: scene.node_order.clone(),
        clips: Vec::new(),
        variant: None,
        camera_changes: rayframe::scene::CameraChanges::default(),
        image_light: None,
        camera: SelectedCamera::Fixed { world_from_camera, projection },
    }
}

/// Floor and balls, with textures of the given mip filter or without any.
fn scene(mip: Option<MipFilter>) -> Scene {
    let mut scene = Scene::default();
    for index in 0..2 {
        let mut material = Material { metallic: 0.0, roughness: 0.7, ..Material::default() };
        if let Some(mip) = mip {
            add_textures(&mut scene, &mut material, mip, index);
        }
        scene.materials.push(material);
    }
    // A floor of 24 metres with low hills; its texture repeats four times along each side.
    let hill = |x: f32, z: f32| 0.15 * libm::sinf(x * 1.1) * libm::cosf(z * 1.3);
    let floor = grid(0, 4.0, |u, v| {
        let (x, z) = ((u - 0.5) * 24.0, (v - 0.7) * 24.0);
        Vec3::new(x, hill(x, z), z)
    });
    add_mesh(&mut scene, floor);
    for index in 0..7 {
        let x = index as f32 * 1.1 - 3.3;
        let center = Vec3::new(x, 0.55 + hill(x, 0.0), libm::sinf(x) * 1.5);
        let ball = grid(1, 2.0, |u, v| {
            let (sin_u, cos_u) = libm::sincosf(u * std::f32::consts::TAU);
            let (sin_v, cos_v) = libm::sincosf((1.0 - v) * std::f32::consts::PI);
            center + Vec3::new(sin_v * cos_u, -cos_v, -sin_v * sin_u) * 0.5
        });
        add_mesh(&mut scene, ball);
    }
    scene.lights.push(Light {
        name: None,
        color: Vec3::ONE,
        intensity: 60.0,
        range: None,
        kind: LightKind::Point,
    });
    let local = rayframe::scene::LocalTransform::Matrix(Mat4::from_translation(Vec3::new(2.0, 4.5, 3.5)));
    add_node(&mut scene, Node { light: Some(LightIndex(0)), local, ..Node::default() });
    scene
}

fn add_mesh(scene: &mut Scene, primitive: Primitive) {
    let mesh = MeshIndex(scene.meshes.len() as u32);
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() });
    add_node(scene, Node { mesh: Some(mesh), ..Node::default() });
}

fn add_node(scene: &mut Scene, node: Node) {
    scene.node_order.push(NodeIndex(scene.nodes.len() as u32));
    scene.nodes.push(node);
}

/// Grid with the positions `surface(u, v)`, and normals and tangents from central differences.
fn grid(material: u32, repeats: f32, surface: impl Fn(f32, f32) -> Vec3) -> Primitive {
    let side = CELLS + 1;
    let step = 1.0 / CELLS as f32;
    let at = |index: usize| ((index % side) as f32 * step, (index / side) as f32 * step);
    let (mut positions, mut normals, mut tangents, mut uvs) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (u, v) in (0..side * side).map(at) {
        let (along_u, along_v) = (
            surface(u + step * 0.5, v) - surface(u - step * 0.5, v),
            surface(u, v + step * 0.5) - surface(u, v - step * 0.5),
        );
        positions.push(surface(u, v));
        normals.push(along_v.cross(along_u).normalize_or(Vec3::Y));
        tangents.push(along_u.normalize_or(Vec3::X).extend(1.0));
        uvs.push(Vec2::new(u, v) * repeats);
    }
    let corner = |x: usize, y: usize| (y * side + x) as u32;
    let cells = (0..CELLS * CELLS).map(|cell| (cell % CELLS, cell / CELLS));
    let triangles = cells.flat_map(|(x, y)| {
        let [a, b, c, d] = [corner(x, y), corner(x, y + 1), corner(x + 1, y + 1), corner(x + 1, y)];
        [[a, b, c], [a, c, d]]
    });
    Primitive {
        positions,
        normals: Some(normals),
        tangents: Some(tangents),
        uvs: vec![uvs],
        triangles: triangles.collect(),
        material: MaterialIndex(material),
        ..Primitive::default()
    }
}

/// Adds a base colour, a normal map of shallow bumps, and a map of occlusion, roughness and metalness.
fn add_textures(scene: &mut Scene, material: &mut Material, mip: MipFilter, seed: u32) {
    let noise = move |x: u32, y: u32| {
        let mixed =
            (x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca6b) ^ seed).wrapping_mul(0xc2b2_ae35);
        (mixed >> 24) as u8
    };
    let bump = |texel: u32| 127.5 + 20.0 * libm::sinf(texel as f32 * 0.1);
    let base = add_texture(scene, mip, Encoding::Srgb, |x, y| {
        let squares = ((x / 64 + y / 64) % 2) as u8 * 90;
        [100 + squares, 90 + noise(x, y) / 4, 120 - squares / 2, 255]
    });
    let normal = add_texture(scene, mip, Encoding::Normal, |x, y| [bump(x) as u8, bump(y) as u8, 250, 255]);
    let maps = add_texture(scene, mip, Encoding::Linear, |x, y| [255, 180 + noise(y, x) / 4, 0, 255]);
    material.base_color_texture = Some(base);
    material.base_color = Vec4::ONE;
    material.roughness = 1.0;
    material.normal_texture = Some(NormalTexture { texture: normal, scale: 1.0 });
    material.metallic_roughness_texture = Some(maps);
    material.occlusion_texture = Some(OcclusionTexture { texture: maps, strength: 1.0 });
}

fn add_texture(
    scene: &mut Scene,
    mip: MipFilter,
    encoding: Encoding,
    texel: impl Fn(u32, u32) -> [u8; 4],
) -> TextureRef {
    let texels = (0..TEXELS).flat_map(|y| (0..TEXELS).map(move |x| (x, y))).map(|(x, y)| texel(x, y));
    let image = Image { name: None, width: TEXELS, height: TEXELS, texels: Texels::Rgba8(texels.collect()) };
    let mut mips = ImageMips::default();
    mips.set(encoding, mip_levels(&image, encoding).into());
    let slot = scene.images.len() as u32;
    scene.images.push(image);
    scene.mips.push(mips);
    let sampler = Sampler { mip, ..Sampler::default() };
    scene.textures.push(Texture { name: None, image: ImageIndex(slot), sampler });
    TextureRef { texture: TextureIndex(slot), uv_set: 0, transform: UvTransform::default() }
}

/// Median.
fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}
