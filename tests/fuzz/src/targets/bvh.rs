//! Hierarchies over arbitrary triangles: their invariants, and every query against brute force.

use glam::Vec3;
use rayframe::bvh::{
    BuildSettings, Builder, BuilderKind, Bvh, Hit, HitOrder, Refit, SimdLevel, Split, TraversalCounters,
    TriangleFlags,
};
use rayframe::cancel::CancelFlag;
use rayframe::geometry::{Ray, Triangle};

use crate::input::Input;
use crate::verdict::must;

const MAX_TRIANGLES: usize = 96;
const MAX_RAYS: usize = 24;
/// Hits of one ray that are listed.
const MAX_HITS: usize = 12;

/// Triangles, their flags and rays.
struct Subject {
    triangles: Vec<Triangle>,
    flags: Vec<TriangleFlags>,
    rays: Vec<Ray>,
}

/// All builders and SIMD levels without splits or with the default ones, a refitted tree, and batches.
pub(crate) fn bvh(input: &[u8]) {
    let mut input = Input::new(input);
    let builder = [BuilderKind::Lbvh, BuilderKind::Karras, BuilderKind::Ploc, BuilderKind::Auto]
        [usize::from(input.u8() % 4)];
    let split = if input.u8().is_multiple_of(2) { Split::Off } else { Split::Auto };
    let simd = SimdLevel::ALL[usize::from(input.u8()) % SimdLevel::ALL.len()];
    let simd = if simd.is_supported() { simd } else { SimdLevel::Scalar };
    let settings =
        BuildSettings { builder, split, simd, refit: Refit::UpTo(1.0e9), ..BuildSettings::default() };
    let shift = input.point(true);
    let subject = subject(&mut input);
    let bvh = build(&subject, &settings, None);
    check(&subject, &bvh);

    // The same tree for moved triangles.
    let moved =
        |triangle: &Triangle| Triangle { vertices: triangle.vertices.map(|point| point * 0.5 + shift) };
    let subject = Subject { triangles: subject.triangles.iter().map(moved).collect(), ..subject };
    check(&subject, &build(&subject, &settings, Some(bvh)));
}

/// Split clipping with any area and budget: the parts cover their triangle, stay within the budget, and change no hit.
pub(crate) fn split(input: &[u8]) {
    let mut input = Input::new(input);
    let area = match input.u8() % 4 {
        0 => Split::Auto,
        1 => Split::Area(f32::from(input.u8()) * 0.01),
        2 => Split::Area(f32::from(input.u8()) * 1.0e-30),
        _ => Split::Area(input.f32().abs()),
    };
    let builder = [BuilderKind::Lbvh, BuilderKind::Ploc][usize::from(input.u8() % 2)];
    let reference_budget = 1.0 + f32::from(input.u8()) * 0.25;
    let settings = BuildSettings { builder, split: area, reference_budget, ..BuildSettings::default() };
    let subject = subject(&mut input);
    let bvh = build(&subject, &settings, None);
    let statistics = bvh.statistics();
    let most = (statistics.triangles as f32 * reference_budget).ceil() as usize;
    assert!(statistics.references <= most, "{} references of at most {most}", statistics.references);
    check(&subject, &bvh);
}

fn build(subject: &Subject, settings: &BuildSettings, recycled: Option<Bvh>) -> Bvh {
    let Subject { triangles, flags, .. } = subject;
    let built = Builder::default().build(triangles, flags, settings, &CancelFlag::new(), recycled);
    must(built.map_err(|_| "nothing cancels"))
}

fn subject(input: &mut Input<'_>) -> Subject {
    let is_on_grid = !input.u8().is_multiple_of(4);
    let flag_bits = input.u32();
    let count = usize::from(input.u8()) % (MAX_TRIANGLES + 1);
    let mut triangles = Vec::new();
    while triangles.len() < count && !input.is_empty() {
        triangles.push(Triangle { vertices: [(); 3].map(|()| input.point(is_on_grid)) });
    }
    let flags_of = |index: usize| match flag_bits >> (2 * (index % 16)) & 3 {
        0 => TriangleFlags::default(),
        1 => TriangleFlags::SINGLE_SIDED,
        2 if index.is_multiple_of(3) => TriangleFlags::TRANSMISSIVE,
        2 => TriangleFlags::FILTERED,
        _ => {
            if index.is_multiple_of(2) {
                TriangleFlags::HIDDEN
            } else {
                TriangleFlags::FILTERED.with(TriangleFlags::SINGLE_SIDED)
            }
        }
    };
    let flags = (0..triangles.len()).map(flags_of).collect();
    let mut rays = rays_at(&triangles);
    while rays.len() < MAX_RAYS && !input.is_empty() {
        rays.push(Ray {
            t_min: 0.0,
            t_max: f32::INFINITY,
            origin: input.point(is_on_grid),
            direction: input.point(is_on_grid),
        });
    }
    rays.retain(|ray| ray.origin.is_finite() && ray.direction.is_finite() && ray.direction != Vec3::ZERO);
    Subject { triangles, flags, rays }
}

/// Rays at corners, edges and middles of some triangles, along an axis and across.
fn rays_at(triangles: &[Triangle]) -> Vec<Ray> {
    let mut rays = Vec::new();
    for (index, triangle) in triangles.iter().enumerate().take(MAX_RAYS / 3) {
        let [a, b, c] = triangle.vertices;
        let axis = [Vec3::X, Vec3::NEG_Y, Vec3::Z][index % 3];
        rays.push(Ray::new(a - axis * 4.0, axis));
        rays.push(Ray::new(Vec3::new(-20.0, 3.0, 7.0), (a + b) * 0.5 - Vec3::new(-20.0, 3.0, 7.0)));
        let middle = (a + b + c) / 3.0;
        rays.push(Ray { t_min: 0.25, t_max: 2.0, ..Ray::new(c, middle - c) });
    }
    rays
}

/// Filter like an alpha mask, by the position of the hit on the triangle.
fn opaque_part(hit: &Hit) -> bool {
    ((hit.u * 8.0) as u32).is_multiple_of(2)
}

/// Answers of all queries of one ray.
fn answers(bvh: &Bvh, ray: &Ray) -> (Option<Hit>, bool, Vec<Hit>) {
    let counters = &mut TraversalCounters::default();
    let mut all = Vec::new();
    let mut after: Option<HitOrder> = None;
    while let Some(hit) = bvh.closest_hit_of_any_side(ray, after, opaque_part, counters) {
        after = Some(hit.order());
        all.push(hit);
        if all.len() == MAX_HITS {
            break;
        }
    }
    let closest = bvh.closest_hit(ray, None, opaque_part, counters);
    (closest, bvh.occluded(ray, opaque_part, counters), all)
}

fn check(subject: &Subject, bvh: &Bvh) {
    let Subject { triangles, flags, rays } = subject;
    must(bvh.validate(triangles, flags));
    let reference = BuildSettings { builder: BuilderKind::BruteForce, ..BuildSettings::default() };
    let reference = build(subject, &reference, None);
    let counters = &mut TraversalCounters::default();
    let mut hits = vec![None; rays.len()];
    bvh.closest_hits(rays, |_, hit| opaque_part(hit), &mut hits, counters);
    let mut occluded = vec![false; rays.len()];
    bvh.occluded_rays(rays, |_, hit| opaque_part(hit), &mut occluded, counters);
    for (index, ray) in rays.iter().enumerate() {
        let expected = answers(&reference, ray);
        assert_eq!(answers(bvh, ray), expected, "{ray:?}");
        assert_eq!((hits[index], occluded[index]), (expected.0, expected.1), "batch: {ray:?}");
    }
}
