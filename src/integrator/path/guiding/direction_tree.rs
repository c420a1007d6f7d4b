//! A density of directions: a quadtree over the square to which an octahedron unfolds.

use glam::{Vec2, Vec3};

use super::photon::{Photon, PhotonPath};
use crate::geometry::DirectionSample;
use crate::scene::LuminanceImage;

/// Levels of squares; those of the last have 0.9° to 2.2°.
const LEVELS: u32 = 7;
/// A square with fewer photons is not divided: more would be chance.
const LEAST_PHOTONS: usize = 32;
/// Nor is one with less than this part of the flux and of the second moment.
const LEAST_PART: f64 = 0.003;

/// A density of directions by solid angle.
#[derive(Clone, Debug)]
pub(super) struct DirectionTree {
    /// The root first.
    nodes: Vec<Node>,
}

/// A square that is divided into quadrants.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Probability of the left half.
    left: f32,
    /// Probability of the upper quadrant in the left half, and in the right one.
    upper: [f32; 2],
    /// Nodes of the quadrants, column by column; 0: the density is constant in the quadrant.
    children: [u32; 4],
}

/// A photon that arrives from some direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct IncidentPhoton {
    uv: Vec2,
    moments: Moments,
}

/// What a ray finds in some directions, from photons.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    /// Flux of light that all rays find.
    flux: f64,
    /// Second moment of the radiance of light that rays find by chance, times squared area and solid angle.
    second: f64,
}

impl IncidentPhoton {
    /// A photon that landed in an area.
    pub(super) fn new(photon: &Photon, area: f32) -> Self {
        let uv = LuminanceImage::uv_from_direction(photon.direction);
        // Focused light has the radiance of its source or none.
        let power = f64::from(photon.power);
        let moments = match photon.path {
            PhotonPath::Caustic => {
                let second = power * f64::from(photon.source_luminance) * f64::from(area);
                Moments { flux: 0.0, second }
            }
            PhotonPath::Direct | PhotonPath::Indirect => Moments { flux: power, second: 0.0 },
        };
        Self { uv, moments }
    }
}

impl DirectionTree {
    /// The density that samples least noisily what arrives: as the root of the mean square of what a ray finds (Rath, Grittmann,
    /// Herholz, Vévoda, Slusallek and Křivánek, "Variance-Aware Path Guiding", SIGGRAPH 2020).
    /// `None` where there is none: without photons, and where they are too bright or too dark for numbers.
    pub(super) fn new(photons: &[IncidentPhoton]) -> Option<Self> {
        let mut tree = Self { nodes: Vec::new() };
        let (_, weight) = tree.add(photons, Moments::of(photons), (Vec2::ZERO, 1.0, 0));
        (weight > 0.0 && weight < f64::INFINITY).then_some(tree)
    }

    /// Adds the node of a square with the given corner, side and level; `total` is of all squares. Returns its index and its weight.
    fn add(
        &mut self,
        photons: &[IncidentPhoton],
        total: Moments,
        (corner, side, level): (Vec2, f32, u32),
    ) -> (u32, f64) {
        let index = self.nodes.len();
        self.nodes.push(Node { left: 0.5, upper: [0.5; 2], children: [0; 4] });
        let half = 0.5 * side;
        let mut quadrants: [Vec<IncidentPhoton>; 4] = Default::default();
        for photon in photons {
            let at = photon.uv - corner;
            quadrants[quadrant(usize::from(at.x >= half), usize::from(at.y >= half))].push(*photon);
        }

        let mut children = [0; 4];
        let weights: [f64; 4] = std::array::from_fn(|number| {
            let photons = &quadrants[number];
            let moments = Moments::of(photons);
            let is_small =
                moments.flux <= LEAST_PART * total.flux && moments.second <= LEAST_PART * total.second;
            if level + 1 == LEVELS || is_small || photons.len() < LEAST_PHOTONS {
                return moments.weight(half * half);
            }
            let corner = corner + Vec2::new((number / 2) as f32, (number % 2) as f32) * half;
            let (child, weight) = self.add(photons, total, (corner, half, level + 1));
            children[number] = child;
            weight
        });
        let halves = [weights[0] + weights[1], weights[2] + weights[3]];
        let upper = [share(weights[0], halves[0]), share(weights[2], halves[1])];
        let weight = halves[0] + halves[1];
        self.nodes[index] = Node { left: share(halves[0], weight), upper, children };
        (index as u32, weight)
    }

    /// Samples a direction.
    pub(super) fn sample(&self, mut u: Vec2) -> DirectionSample {
        let (mut corner, mut half, mut density) = (Vec2::ZERO, 0.5, 1.0);
        let mut node = &self.nodes[0];
        loop {
            let (column, x, p_column) = choose(node.left, u.x);
            let (row, y, p_row) = choose(node.upper[column], u.y);
            u = Vec2::new(x, y);
            density *= 4.0 * p_column * p_row;
            corner += Vec2::new(column as f32, row as f32) * half;
            match node.children[quadrant(column, row)] {
                0 => {
                    let direction = LuminanceImage::direction_from_uv(corner + u * half);
                    let pdf = density * square_by_solid_angle(direction);
                    return DirectionSample { direction, pdf };
                }
                child => node = &self.nodes[child as usize],
            }
            half *= 0.5;
        }
    }

    /// The density of a unit direction.
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        let mut uv = LuminanceImage::uv_from_direction(direction);
        let mut density = 1.0;
        let mut node = &self.nodes[0];
        loop {
            uv *= 2.0;
            let (column, row) = (usize::from(uv.x >= 1.0), usize::from(uv.y >= 1.0));
            uv -= Vec2::new(column as f32, row as f32);
            let of = |first: f32, number: usize| if number == 0 { first } else { 1.0 - first };
            density *= 4.0 * of(node.left, column) * of(node.upper[column], row);
            match node.children[quadrant(column, row)] {
                0 => return density * square_by_solid_angle(direction),
                child => node = &self.nodes[child as usize],
            }
        }
    }
}

/// Number of a quadrant.
fn quadrant(column: usize, row: usize) -> usize {
    2 * column + row
}

/// The share of a whole; half of nothing.
fn share(part: f64, whole: f64) -> f32 {
    if whole > 0.0 { (part / whole) as f32 } else { 0.5 }
}

impl Moments {
    fn of(photons: &[IncidentPhoton]) -> Self {
        let mut all = Self::default();
        for IncidentPhoton { moments, .. } in photons {
            all.flux += moments.flux;
            all.second += moments.second;
        }
        all
    }

    /// Root of the second moment of what rays find in a share of all directions, times its solid angle.
    fn weight(self, share: f32) -> f64 {
        let solid_angle = f64::from(share) * 4.0 * std::f64::consts::PI;
        (self.flux * self.flux + self.second * solid_angle).sqrt()
    }
}

/// The first of two with some probability, or the second; with what is left of the number `u`, and the probability.
fn choose(first: f32, u: f32) -> (usize, f32, f32) {
    const BELOW_ONE: f32 = 1.0_f32.next_down();
    if u < first {
        (0, (u / first).min(BELOW_ONE), first)
    } else {
        (1, ((u - first) / (1.0 - first)).min(BELOW_ONE), 1.0 - first)
    }
}

/// Area of the unit square over the solid angle of its directions.
fn square_by_solid_angle(direction: Vec3) -> f32 {
    // The octahedron's faces are nearer than the sphere.
    let width = direction.abs().element_sum();
    0.25 / (width * width * width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::spiral_direction;
    use crate::integrator::path::visible_environment::random_point;

    /// Most photons come from around one direction, few from everywhere.
    fn photons(count: u32, path: PhotonPath) -> Vec<IncidentPhoton> {
        let center = Vec3::new(0.48, 0.6, -0.64);
        let photon = |index: u32| {
            let around = spiral_direction(index, count);
            let direction =
                if index.is_multiple_of(8) { around } else { (center + 0.2 * around).normalize() };
            let photon = Photon {
                position: Vec3::ZERO,
                normal: Vec3::Y,
                direction,
                path,
                power: 1e-4 * (1 + index % 3) as f32,
                source_luminance: 5.0,
                index,
            };
            IncidentPhoton::new(&photon, 2.0)
        };
        (0..count).map(photon).collect()
    }

    fn trees() -> Vec<DirectionTree> {
        let lists = [
            photons(5000, PhotonPath::Indirect),
            photons(5000, PhotonPath::Caustic),
            [photons(500, PhotonPath::Indirect), photons(700, PhotonPath::Caustic)].concat(),
            photons(1, PhotonPath::Indirect),
            scaled(photons(1000, PhotonPath::Indirect), 1e25),
            scaled(photons(1000, PhotonPath::Indirect), 1e-25),
        ];
        lists.iter().map(|photons| DirectionTree::new(photons).unwrap()).collect()
    }

    fn scaled(mut photons: Vec<IncidentPhoton>, factor: f64) -> Vec<IncidentPhoton> {
        for photon in &mut photons {
            photon.moments.flux *= factor;
        }
        photons
    }

    #[test]
    fn densities_need_photons_that_shine() {
        assert!(DirectionTree::new(&[]).is_none());
        for factor in [0.0, f64::INFINITY, f64::NAN] {
            assert!(DirectionTree::new(&scaled(photons(100, PhotonPath::Indirect), factor)).is_none());
        }
    }

    #[test]
    fn densities_integrate_to_one() {
        let count = 1 << 16;
        for (index, tree) in trees().iter().enumerate() {
            let sum: f64 = (0..count).map(|index| f64::from(tree.pdf(spiral_direction(index, count)))).sum();
            let integral = sum * 4.0 * std::f64::consts::PI / f64::from(count);
            assert!((integral - 1.0).abs() < 0.01, "tree {index}: {integral}");
        }
    }

    #[test]
    fn samples_have_their_directions_density() {
        for tree in trees() {
            for index in 0..4000 {
                let u = (Vec2::new((index % 80) as f32, (index / 80) as f32) + 0.5) / Vec2::new(80.0, 50.0);
                let DirectionSample { direction, pdf } = tree.sample(u);
                assert!((direction.length() - 1.0).abs() < 1e-6 && pdf > 0.0);
                let again = tree.pdf(direction);
                assert!((again / pdf - 1.0).abs() < 1e-4, "{direction}: {again} {pdf}");
            }
            // Edges of squares, and folds and corners of the octahedron
            for (x, y) in (0..9).flat_map(|x| (0..9).map(move |y| (x, y))) {
                let uv = Vec2::new(x as f32, y as f32) / 8.0;
                let pdf = tree.pdf(LuminanceImage::direction_from_uv(uv));
                assert!(pdf >= 0.0 && pdf.is_finite(), "{uv}: {pdf}");
            }
        }
    }

    #[test]
    fn samples_are_as_frequent_as_densities_say() {
        // Mean of a function by samples over their density: its integral.
        let value = |direction: Vec3| (direction.dot(Vec3::new(0.48, 0.6, -0.64)).max(0.0)).powi(8);
        for tree in trees() {
            let (samples, mut sum) = (1 << 18, 0.0);
            for index in 0..samples {
                let DirectionSample { direction, pdf } = tree.sample(random_point(index, 0));
                sum += f64::from(value(direction) / pdf);
            }
            let integral = sum / f64::from(samples);
            // Directions without photons are not sampled.
            let count = 1 << 16;
            let directions = (0..count).map(|index| spiral_direction(index, count));
            let sampled = directions.filter(|&direction| tree.pdf(direction) > 0.0);
            let expected = sampled.map(|direction| f64::from(value(direction))).sum::<f64>()
                * (4.0 * std::f64::consts::PI / f64::from(count));
            assert!((integral / expected - 1.0).abs() < 0.02, "{integral} of {expected}");
        }
    }

    #[test]
    fn most_samples_go_where_most_arrives() {
        let tree = &trees()[0];
        let center = Vec3::new(0.48, 0.6, -0.64);
        assert!(tree.pdf(center) > 50.0 * tree.pdf(-center), "{}", tree.pdf(center));
        assert!(tree.pdf(-center) > 0.0);
    }

    #[test]
    fn chance_weighs_more_than_flux() {
        // Equal flux from two quadrants, in one of them by photons of a source so bright that rays seldom find it
        let photon = |uv: Vec2, path: PhotonPath| {
            let direction = LuminanceImage::direction_from_uv(uv);
            let (position, normal) = (Vec3::ZERO, Vec3::Y);
            let photon =
                Photon { position, normal, direction, path, power: 0.01, source_luminance: 500.0, index: 0 };
            IncidentPhoton::new(&photon, 2.0)
        };
        let (dependable, by_chance) = (Vec2::splat(0.2), Vec2::splat(0.7));
        let photons = [photon(dependable, PhotonPath::Indirect), photon(by_chance, PhotonPath::Caustic)];
        let tree = DirectionTree::new(&photons).unwrap();
        let pdf = |uv: Vec2| {
            let direction = LuminanceImage::direction_from_uv(uv);
            tree.pdf(direction) / square_by_solid_angle(direction)
        };
        // The root of power · luminance · area · a quarter of all directions, over the power
        let expected = (0.01_f32 * 500.0 * 2.0 * std::f32::consts::PI).sqrt() / 0.01;
        assert!((pdf(by_chance) / pdf(dependable) / expected - 1.0).abs() < 1e-3);
    }
}
