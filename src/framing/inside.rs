//! Cameras inside interiors: from a point at eye height along the longest free line.

use glam::{Mat4, Vec3};
use rayon::prelude::*;

use super::enclosure::{GridPoints, possibly_enclosed};
use super::subject::Subject;
use crate::bvh::{BuildSettings, Builder, BuilderKind, Bvh, Split, TraversalCounters, TriangleFlags};
use crate::cancel::CancelFlag;
use crate::geometry::{Aabb, Facing, Ray};
use crate::scene::{Projection, look_along};

/// Points a side of the grid in which a place for the camera is sought.
const GRID: usize = 7;
/// Directions in which a point must see surfaces to lie inside.
const DIRECTIONS: usize = 48;
/// Share of those directions; doors and windows are open.
const ENCLOSED: f32 = 0.75;
/// Share of the grid's points that lie inside where the scene is an interior.
const INSIDE_POINTS: f32 = 0.3;
/// Horizontal directions of free lines.
const HEADINGS: usize = 32;
/// Height of the eyes above the floor, metres, or this share of the height above it.
const EYE_HEIGHT: (f32, f32) = (1.6, 0.5);
/// Shares of the way to the wall behind that the camera moves back, where it stays inside.
const STEPS_BACK: [f32; 4] = [0.85, 0.6, 0.3, 0.0];
/// What lengths are rounded by, at most, as a share of the largest coordinate.
const ROUNDING: f32 = 16.0 * f32::EPSILON;
/// Rays across and down an image in which nodes are counted.
const RAYS: (u32, u32) = (32, 18);
/// Fewest rays on a node that is counted as seen.
const RAYS_OF_A_NODE: usize = 2;
/// Fewest nodes that an interior shows.
const NODES: usize = 5;

/// The camera inside, where the scene is an interior that shows more nodes from there than `outside` does.
pub(super) fn inside_camera(subject: &Subject<'_>, projection: &Projection, outside: Mat4) -> Option<Mat4> {
    // Refuse most scenes before the hierarchy is built.
    if subject.framed_node_instances() < NODES {
        return None;
    }
    let is_interior = |points: usize| points as f32 >= INSIDE_POINTS * (GRID * GRID) as f32;
    let eyes = eyes(subject);
    if !is_interior(possibly_enclosed(&subject.frame, &eyes)) {
        return None;
    }

    let rays = SceneRays::new(subject)?;
    let inside: Vec<_> = eyes.par_iter().copied().filter(|&eye| rays.is_inside(eye)).collect();
    if !is_interior(inside.len()) {
        return None;
    }
    let camera = rays.longest_line(&inside)?;
    let seen = rays.seen_nodes(camera, projection);
    (seen >= NODES && seen > rays.seen_nodes(outside, projection)).then_some(camera)
}

/// Points of a grid at eye height above what is below them.
fn eyes(subject: &Subject<'_>) -> Vec<Vec3> {
    let bounds = subject.bounds;
    let position = |step: usize| {
        let share = (step as f32 + 0.5) / GRID as f32;
        bounds.min + bounds.extent() * Vec3::new(share, 0.5, share)
    };
    let across: Vec<Vec3> = (0..GRID).map(position).collect();
    let middles = GridPoints {
        x: across.iter().map(|point| point.x).collect(),
        y: across[0].y,
        z: across.iter().map(|point| point.z).collect(),
    };
    let above_floor = |(middle, floor): (Vec3, Option<f32>)| {
        let floor = floor.unwrap_or(bounds.min.y);
        let height = EYE_HEIGHT.0.min((bounds.max.y - floor) * EYE_HEIGHT.1);
        Vec3::new(middle.x, floor + height, middle.z)
    };
    middles.points().zip(middles.floors_below(&subject.frame)).map(above_floor).collect()
}

/// A horizontal line through a point, up to the surfaces on both sides.
struct FreeLine {
    /// Among all lines.
    index: usize,
    eye: Vec3,
    /// Unit vector.
    forward: Vec3,
    /// Free lengths on both sides of the point.
    behind: f32,
    ahead: f32,
}

impl FreeLine {
    /// The most that a camera on the line has before it.
    fn most_length(&self) -> f32 {
        let length = self.behind * STEPS_BACK[0] + self.ahead;
        length + (self.eye.abs().max_element() + length) * ROUNDING
    }
}

/// Rays through the scene at its first time.
struct SceneRays<'a> {
    subject: &'a Subject<'a>,
    bvh: Bvh,
}

impl<'a> SceneRays<'a> {
    fn new(subject: &'a Subject<'a>) -> Option<Self> {
        let settings =
            BuildSettings { builder: BuilderKind::Lbvh, split: Split::Off, ..BuildSettings::default() };
        let (triangles, flags) = (&subject.frame.triangles, &subject.frame.flags);
        let bvh = Builder::default().build(triangles, flags, &settings, &CancelFlag::new(), None).ok()?;
        Some(Self { subject, bvh })
    }

    /// Whether visible sides of surfaces enclose the point. From within a solid, only hidden sides are seen.
    fn is_inside(&self, eye: Vec3) -> bool {
        let seen = (0..DIRECTIONS).filter(|&index| {
            let ray = Ray::new(eye, sphere_direction(index));
            let mut counters = TraversalCounters::default();
            let hit = self.bvh.closest_hit_of_any_side(&ray, None, |_| true, &mut counters);
            hit.is_some_and(|hit| {
                let is_single_sided =
                    self.subject.frame.flags[hit.triangle as usize].has(TriangleFlags::SINGLE_SIDED);
                hit.facing == Facing::Front || !is_single_sided
            })
        });
        seen.count() as f32 >= ENCLOSED * DIRECTIONS as f32
    }

    /// The camera at the beginning of the longest free horizontal line through one of the points, within the bounds.
    fn longest_line(&self, eyes: &[Vec3]) -> Option<Mat4> {
        let mut lines = self.free_lines(eyes);
        // Points inside are sought along the longest lines first, since that takes most of the time.
        lines.sort_by(|a, b| b.most_length().total_cmp(&a.most_length()));
        let mut longest: Option<(f32, usize, Mat4)> = None;
        for line in lines {
            if longest.is_some_and(|(longest, ..)| line.most_length() < longest) {
                break;
            }
            let Some((length, camera)) = self.camera_on(&line) else { continue };
            let is_longer = longest.is_none_or(|(longest, first, _)| {
                length > longest || (length == longest && line.index < first)
            });
            if is_longer {
                longest = Some((length, line.index, camera));
            }
        }
        longest.map(|(_, _, camera)| camera)
    }

    /// The free lines through the points in all headings.
    fn free_lines(&self, eyes: &[Vec3]) -> Vec<FreeLine> {
        let line = |index: usize| {
            let (eye, heading) = (eyes[index / HEADINGS], index % HEADINGS);
            let (sine, cosine) = libm::sincosf(heading as f32 * std::f32::consts::TAU / HEADINGS as f32);
            let forward = Vec3::new(sine, 0.0, -cosine);
            let [behind, ahead] = [-forward, forward].map(|direction| self.free_length(eye, direction));
            FreeLine { index, eye, forward, behind, ahead }
        };
        (0..eyes.len() * HEADINGS).into_par_iter().map(line).collect()
    }

    /// The camera inside that looks along a line from as far back as possible, and the free length before it; `None` if no point is inside.
    fn camera_on(&self, line: &FreeLine) -> Option<(f32, Mat4)> {
        let FreeLine { eye, forward, behind, .. } = *line;
        let mut steps_back = STEPS_BACK.iter().map(|share| eye - forward * (behind * share));
        let position = steps_back.find(|&position| self.is_inside(position))?;
        Some((self.free_length(position, forward), look_along(position, -forward, Vec3::Y)))
    }

    /// Length of the ray before it hits a surface or leaves the bounds.
    fn free_length(&self, origin: Vec3, direction: Vec3) -> f32 {
        let Aabb { min, max } = self.subject.bounds;
        let exits = ((min - origin) / direction).max((max - origin) / direction);
        let limit =
            exits.to_array().into_iter().filter(|exit| exit.is_finite()).fold(f32::INFINITY, f32::min);
        let ray = Ray { t_max: limit, ..Ray::new(origin, direction) };
        let hit = self.bvh.closest_hit_of_any_side(&ray, None, |_| true, &mut TraversalCounters::default());
        hit.map_or(limit, |hit| hit.t)
    }

    /// Number of framed nodes that an image of the camera shows.
    fn seen_nodes(&self, camera: Mat4, projection: &Projection) -> usize {
        let frame = &self.subject.frame;
        let size = projection.half_size(RAYS.0 as f32 / RAYS.1 as f32);
        let node_at = |index: u32| {
            let (row, column) = (index / RAYS.0, index % RAYS.0);
            let x = ((column as f32 + 0.5) / RAYS.0 as f32 * 2.0 - 1.0) * size.x;
            let y = (1.0 - (row as f32 + 0.5) / RAYS.1 as f32 * 2.0) * size.y;
            let ray = Ray::new(camera.w_axis.truncate(), camera.transform_vector3(Vec3::new(x, y, -1.0)));
            let hit = self.bvh.closest_hit(&ray, None, |_| true, &mut TraversalCounters::default())?;
            let instance = frame.instance_of_triangle[hit.triangle as usize];
            let node = &frame.instances[instance as usize];
            self.subject.frames_instance(instance).then_some((node.node, node.node_instance))
        };
        let nodes: Vec<_> = (0..RAYS.0 * RAYS.1).into_par_iter().filter_map(node_at).collect();
        let mut rays_by_node = std::collections::BTreeMap::<_, usize>::new();
        for node in nodes {
            *rays_by_node.entry(node).or_default() += 1;
        }
        rays_by_node.values().filter(|&&rays| rays >= RAYS_OF_A_NODE).count()
    }
}

/// Directions evenly over the sphere, on a spiral.
fn sphere_direction(index: usize) -> Vec3 {
    let height = 1.0 - 2.0 * (index as f32 + 0.5) / DIRECTIONS as f32;
    let (sine, cosine) = libm::sincosf(index as f32 * 2.399_963_2);
    let across = (1.0 - height * height).sqrt();
    Vec3::new(across * cosine, height, across * sine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::{ImportOptions, import};
    use crate::scene::{Selection, SelectionRequest};

    #[test]
    fn the_longest_line_is_that_of_a_search_of_all() {
        for name in ["showcase/level", "showcase/apartment", "demo/whitted_1980", "path/box"] {
            let path = format!("{}/scenes/{name}.gltf", env!("CARGO_MANIFEST_DIR"));
            let scene = import(path.as_ref(), &ImportOptions::default()).unwrap();
            let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
            let subject = Subject::measure(&scene, &selection, None, &[]);
            let rays = SceneRays::new(&subject).unwrap();
            let eyes = eyes(&subject);
            let mut longest: Option<(f32, Mat4)> = None;
            for line in rays.free_lines(&eyes) {
                let Some((length, camera)) = rays.camera_on(&line) else { continue };
                assert!(length <= line.most_length(), "{name}: {length}");
                if longest.is_none_or(|(longest, _)| length > longest) {
                    longest = Some((length, camera));
                }
            }
            let is_interior = name.starts_with("showcase");
            assert!(longest.is_some() || !is_interior, "{name}");
            assert_eq!(rays.longest_line(&eyes), longest.map(|(_, camera)| camera), "{name}");
        }
    }
}
