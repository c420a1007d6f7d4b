//! Trace time of the renderer compared with that of the benchmark's batches: the same scene and camera through
//! [`rayframe::render::render_frame`], and as many rays of each kind in batches.
//!
//! The surface is half mirror and half diffuse. Every camera hit sends a mirror ray and, where the surface faces the light, a
//! shadow ray; hits of mirror rays send only shadow rays. So the renderer's rays are the sets `primary`, `shadow` and
//! `reflect`, and shadow rays from the hits of `reflect`, which are generated here.

use glam::{Mat4, Vec3};
use rayframe::bvh::{BuildSettings, Bvh, TraversalCounters};
use rayframe::cancel::CancelFlag;
use rayframe::film::PixelWindow;
use rayframe::frame::Frame;
use rayframe::geometry::{Ray, Triangle};
use rayframe::render::{RenderSettings, RenderStatistics, SceneView, render_frame};
use rayframe::scene::{
    Environment, Light, LightIndex, LightKind, LocalTransform, Material, MaterialIndex, Mesh, MeshIndex,
    Node, NodeIndex, Primitive, Projection, Scene, SelectedCamera, Selection,
};
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::Result;
use crate::folder::{FRAME_SETS, Subject, View};
use peers::hierarchy::hierarchy;
use peers::ray_set::Query;
use peers::soup::Soup;
use peers::surface::Surface;
use peers::trace;

/// Pixels along the side of the image for which the rays were generated.
const SIDE: u32 = 1024;
/// Rendered images; the fastest counts.
const RUNS: usize = 3;

/// Milliseconds, summed over threads, over their number.
pub(crate) struct Compared {
    /// Queries of the renderer.
    pub(crate) render_ms: f64,
    /// As many rays of each kind in batches of the benchmark.
    pub(crate) rays_ms: f64,
}

/// Renders `subject` and traces the same rays through `bvh`.
pub(crate) fn compare(
    subject: &Subject,
    settings: &BuildSettings,
    bvh: &Bvh,
    pool: &ThreadPool,
) -> Result<Compared> {
    let (scene, selection) = mirror_scene(&subject.soup, &subject.view);
    let frame = Frame::at(&scene, &selection, 0.0);
    let soup = Soup { triangles: frame.triangles.clone(), flags: frame.flags.clone() };
    let built = pool.install(|| hierarchy(&soup, settings))?;
    let input = SceneView { scene: &scene, frame: &frame, bvh: &built, environment: &Environment::None };
    let threads = pool.current_num_threads();
    let mut render_ms = f64::INFINITY;
    let mut rendered = RenderStatistics::default();
    for _ in 0..RUNS {
        let render = || render_frame(&input, &render_settings(), &CancelFlag::new(), &|_| ());
        (_, rendered) = pool.install(render)?;
        render_ms = render_ms.min(rendered.integrator.query_seconds * 1e3 / threads as f64);
    }
    Ok(Compared { render_ms, rays_ms: rays_ms(subject, bvh, &rendered, threads) })
}

/// Time of `rendered`'s rays in batches: the time of each of the benchmark's sets, times the ratio of their numbers of rays.
fn rays_ms(subject: &Subject, bvh: &Bvh, rendered: &RenderStatistics, threads: usize) -> f64 {
    let counts = &rendered.integrator;
    let mirrored = second_shadows(subject, bvh);
    let frame_sets = subject.sets[..FRAME_SETS].iter();
    let mut sets: Vec<(Query, &[Ray])> = frame_sets.map(|set| (set.query, set.batched())).collect();
    sets.push((Query::Occluded, &mirrored));
    let shadows: usize =
        sets.iter().filter(|(query, _)| *query == Query::Occluded).map(|(_, rays)| rays.len()).sum();
    let wanted = [counts.camera_rays, 0, counts.reflection_rays];
    let mut seconds = 0.0;
    for (index, (query, rays)) in sets.into_iter().enumerate().filter(|(_, (_, rays))| !rays.is_empty()) {
        let traced = trace::batches(bvh, rays, query, threads).seconds;
        seconds += match query {
            Query::Closest => traced * wanted[index] as f64 / rays.len() as f64,
            Query::Occluded => traced * counts.shadow_rays as f64 / shadows as f64,
        };
    }
    seconds * 1e3
}

/// Shadow rays from the light to the lit hits of mirror rays, in their order.
fn second_shadows(subject: &Subject, bvh: &Bvh) -> Vec<Ray> {
    let ray = |ray: &Ray| {
        let hit = bvh.closest_hit(ray, None, |_| true, &mut TraversalCounters::default())?;
        let surface = Surface::new(&subject.soup.triangles, ray, &hit);
        let (origin, direction) = (subject.view.light, surface.position - subject.view.light);
        (direction.dot(surface.normal) < 0.0).then_some(Ray { origin, direction, t_min: 0.0, t_max: 1.0 })
    };
    subject.sets[FRAME_SETS - 1].rays.par_iter().filter_map(ray).collect()
}

fn render_settings() -> RenderSettings {
    RenderSettings {
        resolution: (SIDE, SIDE),
        window: PixelWindow::full(SIDE, SIDE),
        samples: 1,
        max_depth: 1,
        ..RenderSettings::default()
    }
}

/// Scene of one mesh and one point light, and its camera.
fn mirror_scene(soup: &Soup, view: &View) -> (Scene, Selection) {
    let light = Light { name: None, color: Vec3::ONE, intensity: 1.0, range: None, kind: LightKind::Point };
    let material = Material { metallic: 0.5, roughness: 0.0, double_sided: true, ..Material::default() };
    let at_light = Mat4::from_translation(view.light);
    let nodes = vec![
        Node { mesh: Some(MeshIndex(0)), ..Node::default() },
        Node { light: Some(LightIndex(0)), local: LocalTransform::Matrix(at_light), ..Node::default() },
    ];
    let scene = Scene {
        node_order: vec![NodeIndex(0), NodeIndex(1)],
        nodes,
        meshes: vec![Mesh { primitives: vec![primitive(&soup.triangles)], ..Mesh::default() }],
        materials: vec![material],
        lights: vec![light],
        ..Scene::default()
    };
    let selection = Selection {
        roots: vec![NodeIndex(0), NodeIndex(1)],
        clips: Vec::new(),
        camera: camera(view),
        camera_changes: rayframe::scene::CameraChanges::default(),
        image_light: None,
        variant: None,
    };
    (scene, selection)
}

fn primitive(triangles: &[Triangle]) -> Primitive {
    Primitive {
        positions: triangles.iter().flat_map(|triangle| triangle.vertices).collect(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        material: MaterialIndex(0),
        ..Primitive::default()
    }
}

fn camera(view: &View) -> SelectedCamera {
    let forward = (view.target - view.eye).normalize();
    let right = forward.cross(view.up).normalize();
    let up = right.cross(forward);
    let world_from_camera =
        Mat4::from_cols(right.extend(0.0), up.extend(0.0), (-forward).extend(0.0), view.eye.extend(1.0));
    let fov_y_radians = view.fov_y_radians;
    let projection = Projection::Perspective { fov_y_radians, aspect_ratio: None, z_near: 0.0, z_far: None };
    SelectedCamera::Fixed { world_from_camera, projection }
}
