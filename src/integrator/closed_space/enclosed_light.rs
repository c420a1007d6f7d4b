//! Light of the environment inside a closed space, as surfaces look it up by their positions and normals.

use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::ClosedSpace;
use super::radiosity::LitWall;
use crate::geometry::Aabb;

/// Cells along the longest axis of the grid.
const CELLS: usize = 10;
/// Walls of which a grid is made, at most: of many times of an animation, every few.
const MOST_WALLS: usize = 2048;
/// Walls around a point count up to [`REACH`] times the distance of this one.
const NEAREST: usize = 6;
const REACH: f32 = 2.0;
/// Cosine between the normal of a wall and the axis that it faces, at least.
const FACING_COSINE: f32 = 0.5;
/// Share of the walls at either end of each axis that may be beyond the grid: far ones that are seen through windows.
const OUTLIERS: f32 = 0.05;

/// The irradiance of walls, in between and beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct EnclosedLight {
    light: Arc<Grid>,
    /// The same without the environment, where its intensity is animated and `light` is that of an intensity of one.
    dark: Option<Arc<Grid>>,
}

#[derive(Clone, Debug, PartialEq)]
struct Grid {
    bounds: Aabb,
    /// Cells along each axis.
    cells: [usize; 3],
    cells_a_metre: Vec3,
    /// Of the corners of the cells, x first.
    cubes: Vec<AmbientCube>,
    /// Over all walls and directions.
    mean_radiance: Vec3,
}

/// Irradiance of surfaces that face the negative and the positive direction of each axis (McTaggart 2004).
type AmbientCube = [[Vec3A; 2]; 3];

/// A wall and its weight.
type WeightedWall = (LitWall, f32);

impl EnclosedLight {
    /// The light of spaces by their weights, of which one must not be 0; `None` where no light comes into any.
    pub(in crate::integrator) fn new(spaces: &[(&ClosedSpace, f32)]) -> Option<Self> {
        spaces.iter().find(|(space, weight)| space.is_lit && *weight > 0.0)?;
        let all = spaces.iter().map(|(space, _)| space.walls.len()).sum::<usize>();
        let step = all.div_ceil(MOST_WALLS).max(1);
        let walls: Vec<WeightedWall> = spaces
            .iter()
            .flat_map(|(space, weight)| space.walls.iter().map(|wall| (*wall, *weight)))
            .filter(|(_, weight)| *weight > 0.0)
            .step_by(step)
            .collect();
        Some(Self { light: Arc::new(Grid::new(&walls)), dark: None })
    }

    /// The light at any intensity of the environment: `self` is that of one, `dark` that of the same walls without it.
    pub(in crate::integrator) fn with_dark(self, dark: Self) -> Self {
        Self { dark: Some(dark.light), ..self }
    }

    /// The light in a frame whose environment has this intensity; the same as `self` where that is not animated.
    pub(in crate::integrator) fn at_intensity(&self, intensity: f32) -> Self {
        let Some(dark) = &self.dark else { return self.clone() };
        Self { light: Arc::new(self.light.at_intensity(dark, intensity)), dark: None }
    }

    /// Irradiance on a surface with this normal.
    #[inline]
    pub(in crate::integrator) fn irradiance(&self, position: Vec3, normal: Vec3) -> Vec3 {
        self.light.irradiance(position, normal)
    }

    /// Mean radiance in a lobe around a direction: that of the widest lobe, whatever its roughness.
    #[inline]
    pub(in crate::integrator) fn prefiltered(&self, position: Vec3, direction: Vec3) -> Vec3 {
        self.light.irradiance(position, direction) * FRAC_1_PI
    }

    /// Mean radiance over all directions.
    pub(in crate::integrator) fn mean_radiance(&self) -> Vec3 {
        self.light.mean_radiance
    }

    /// Numbers that tell one light from any other.
    pub(in crate::integrator) fn bits(&self) -> impl Iterator<Item = u32> {
        let Aabb { min, max } = self.light.bounds;
        let grids = std::iter::once(&self.light).chain(&self.dark);
        let light = grids.flat_map(|grid| grid.cubes.iter().flatten().flatten());
        let numbers = [min, max].into_iter().chain(light.map(|light| Vec3::from(*light)));
        numbers.flat_map(|vector| vector.to_array()).map(f32::to_bits)
    }
}

impl Grid {
    fn new(walls: &[WeightedWall]) -> Self {
        let bounds = bounds_of(walls);
        let extent = bounds.extent();
        let cell = (extent.max_element() / CELLS as f32).max(f32::MIN_POSITIVE);
        let cells = extent.to_array().map(|length| ((length / cell).round() as usize).clamp(1, CELLS));
        let cells_a_metre =
            Vec3::from_array(cells.map(|count| count as f32)) / extent.max(Vec3::splat(f32::MIN_POSITIVE));

        let facing = facing_walls(walls);
        let [width, height, depth] = cells.map(|count| count + 1);
        let cubes = (0..width * height * depth).into_par_iter().map(|index| {
            let corner = [index % width, index / width % height, index / (width * height)];
            let point = bounds.min + Vec3::from_array(corner.map(|count| count as f32)) / cells_a_metre;
            facing.each_ref().map(|sides| sides.each_ref().map(|walls| mean_irradiance(point, walls)))
        });
        let total: f32 = walls.iter().map(|(_, weight)| weight).sum();
        let mean = walls.iter().map(|(wall, weight)| wall.irradiance * (weight / (total * PI))).sum();
        Self { bounds, cells, cells_a_metre, cubes: cubes.collect(), mean_radiance: mean }
    }

    /// Light is linear in the intensity: `self` has that of one, and `dark`, of the same cells, that of zero.
    fn at_intensity(&self, dark: &Self, intensity: f32) -> Self {
        let mut scaled = self.clone();
        let sides = scaled.cubes.iter_mut().flatten().flatten();
        for (light, dark) in sides.zip(dark.cubes.iter().flatten().flatten()) {
            *light = *dark + (*light - *dark) * intensity;
        }
        scaled.mean_radiance = dark.mean_radiance + (self.mean_radiance - dark.mean_radiance) * intensity;
        scaled
    }

    /// Trilinear between the corners of a cell. A point beyond the grid has the light at its edge.
    fn irradiance(&self, position: Vec3, normal: Vec3) -> Vec3 {
        let Self { bounds, cells, .. } = self;
        let at = (position.clamp(bounds.min, bounds.max) - bounds.min) * self.cells_a_metre;
        let strides = [1, cells[0] + 1, (cells[0] + 1) * (cells[1] + 1)];
        let (mut first, mut fractions) = (0, [0.0; 3]);
        for axis in 0..3 {
            let cell = (at[axis] as usize).min(cells[axis] - 1);
            first += cell * strides[axis];
            fractions[axis] = at[axis] - cell as f32;
        }
        let squares = normal * normal;
        let sides = normal.to_array().map(|component| usize::from(component > 0.0));
        let mut sum = Vec3A::ZERO;
        for corner in 0..8 {
            let (mut index, mut share) = (first, 1.0);
            for axis in 0..3 {
                let is_far = corner >> axis & 1;
                index += is_far * strides[axis];
                share *= if is_far == 1 { fractions[axis] } else { 1.0 - fractions[axis] };
            }
            let [x, y, z] = &self.cubes[index];
            sum += (x[sides[0]] * squares.x + y[sides[1]] * squares.y + z[sides[2]] * squares.z) * share;
        }
        sum.into()
    }
}

/// The box that contains most walls.
fn bounds_of(walls: &[WeightedWall]) -> Aabb {
    let mut bounds = Aabb { min: Vec3::ZERO, max: Vec3::ZERO };
    let last = walls.len() - 1;
    let outliers = (last as f32 * OUTLIERS) as usize;
    for axis in 0..3 {
        let mut coordinates: Vec<f32> = walls.iter().map(|(wall, _)| wall.position[axis]).collect();
        coordinates.sort_unstable_by(f32::total_cmp);
        (bounds.min[axis], bounds.max[axis]) = (coordinates[outliers], coordinates[last - outliers]);
    }
    bounds
}

/// The walls that face the negative and positive direction of each axis; all of them where none does.
fn facing_walls(walls: &[WeightedWall]) -> [[Vec<WeightedWall>; 2]; 3] {
    std::array::from_fn(|axis| {
        [-1.0, 1.0].map(|side| {
            let faces = |(wall, _): &&WeightedWall| wall.normal[axis] * side > FACING_COSINE;
            let facing: Vec<_> = walls.iter().filter(faces).copied().collect();
            if facing.is_empty() { walls.to_vec() } else { facing }
        })
    })
}

/// Mean irradiance of the walls around a point. They count by a smooth function of their distance.
fn mean_irradiance(point: Vec3, walls: &[WeightedWall]) -> Vec3A {
    let squared = |wall: &LitWall| wall.position.distance_squared(point);
    let mut distances: Vec<f32> = walls.iter().map(|(wall, _)| squared(wall)).collect();
    let nearest = NEAREST.min(distances.len() - 1);
    let (_, distance, _) = distances.select_nth_unstable_by(nearest, f32::total_cmp);
    let scale = 1.0 / (*distance * (REACH * REACH)).max(f32::MIN_POSITIVE);
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for (wall, weight) in walls {
        let kernel = 1.0 - squared(wall) * scale;
        if kernel > 0.0 {
            let weight = weight * kernel * kernel;
            sum += wall.irradiance * weight;
            weights += weight;
        }
    }
    if weights > 0.0 { Vec3A::from(sum / weights) } else { Vec3A::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a floor of four metres and of a ceiling three metres above it.
    fn space(irradiance: impl Fn(Vec3, Vec3) -> f32) -> ClosedSpace {
        let points = (0..21 * 21).map(|index| Vec3::new((index % 21) as f32, 0.0, (index / 21) as f32) * 0.2);
        let walls = points.flat_map(|floor| [(floor, Vec3::Y), (floor + Vec3::Y * 3.0, Vec3::NEG_Y)]);
        let walls = walls.map(|(position, normal)| {
            let irradiance = Vec3::new(1.0, 0.5, 0.25) * irradiance(position, normal);
            LitWall { position, normal, irradiance, open_share: 0.1 }
        });
        ClosedSpace { walls: walls.collect(), is_lit: true }
    }

    fn light_of(irradiance: impl Fn(Vec3, Vec3) -> f32) -> EnclosedLight {
        EnclosedLight::new(&[(&space(irradiance), 1.0)]).expect("light comes in")
    }

    #[test]
    fn uniform_light_is_the_same_everywhere() {
        let light = light_of(|_, _| 2.0);
        for position in [Vec3::ZERO, Vec3::new(1.3, 0.7, 2.9), Vec3::splat(-50.0), Vec3::splat(1e30)] {
            for normal in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8)] {
                let found = light.irradiance(position, normal);
                assert!((found - Vec3::new(2.0, 1.0, 0.5)).length() < 1e-5, "{position} {normal}: {found}");
                assert!((light.prefiltered(position, normal) * PI - found).length() < 1e-6);
            }
        }
        assert!((light.mean_radiance() * PI - Vec3::new(2.0, 1.0, 0.5)).length() < 1e-4);
    }

    #[test]
    fn walls_near_a_point_light_it() {
        let light = light_of(|position, _| 1.0 + position.x);
        let found = |x: f32| light.irradiance(Vec3::new(x, 0.1, 2.0), Vec3::Y).x;
        for x in [1.0, 1.5, 2.0, 2.7, 3.0] {
            assert!((found(x) - (1.0 + x)).abs() < 0.1, "{x}: {}", found(x));
        }
        // At the edge there are walls on one side alone.
        assert!(found(0.0) < 1.4 && found(4.0) > 4.6, "{} {}", found(0.0), found(4.0));
    }

    #[test]
    fn normals_choose_the_walls_that_face_as_they_do() {
        let light = light_of(|_, normal| if normal.y > 0.0 { 1.0 } else { 5.0 });
        let found = |normal| light.irradiance(Vec3::new(2.0, 1.5, 2.0), normal).x;
        assert!((found(Vec3::Y) - 1.0).abs() < 1e-5 && (found(Vec3::NEG_Y) - 5.0).abs() < 1e-5);
        // No wall faces the x axis: it has the mean of both.
        assert!((found(Vec3::X) - 3.0).abs() < 0.2, "{}", found(Vec3::X));
        let tilted = found(Vec3::new(0.6, 0.8, 0.0));
        assert!((tilted - (0.64 + 0.36 * found(Vec3::X))).abs() < 1e-5, "{tilted}");
    }

    #[test]
    fn what_is_far_outside_has_no_part_in_it() {
        let near = light_of(|position, _| 1.0 + position.x);
        let mut with_far = space(|position, _| 1.0 + position.x);
        let far = LitWall { irradiance: Vec3::splat(100.0), position: Vec3::X * 1000.0, ..with_far.walls[0] };
        with_far.walls.extend([far; 20]);
        let with_far = EnclosedLight::new(&[(&with_far, 1.0)]).expect("light comes in");
        for position in [Vec3::splat(0.5), Vec3::new(2.0, 0.0, 2.0), Vec3::new(3.0, 2.0, 1.0)] {
            let [found, expected] = [&with_far, &near].map(|light| light.irradiance(position, Vec3::Y).x);
            assert!((found / expected - 1.0).abs() < 0.05, "{position}: {found}, expected {expected}");
        }
    }

    #[test]
    fn times_count_by_their_weights() {
        let [dark, bright] = [0.0, 4.0].map(|irradiance| space(|_, _| irradiance));
        let mean = EnclosedLight::new(&[(&dark, 0.5), (&bright, 1.5)]).expect("light comes in");
        assert!((mean.irradiance(Vec3::ONE, Vec3::Y).x - 3.0).abs() < 1e-4);
        let alone = EnclosedLight::new(&[(&dark, 0.0), (&bright, 0.1)]).expect("light comes in");
        assert!((alone.irradiance(Vec3::ONE, Vec3::Y).x - 4.0).abs() < 1e-4);
        assert!(alone.bits().ne(mean.bits()) && alone.bits().eq(alone.clone().bits()));
    }

    #[test]
    fn light_follows_the_intensity_of_the_environment() {
        // Walls receive 1 from unlit ones and 2 from the environment.
        let [bright, dark] = [3.0, 1.0].map(|irradiance| light_of(|_, _| irradiance));
        assert_eq!(bright.at_intensity(0.5), bright);
        let scaled = bright.clone().with_dark(dark);
        assert!(scaled.bits().ne(bright.bits()));
        for (intensity, expected) in [(0.0, 1.0), (0.25, 1.5), (1.0, 3.0), (4.0, 9.0)] {
            let light = scaled.at_intensity(intensity);
            let found = light.irradiance(Vec3::ONE, Vec3::Y);
            assert!((found - Vec3::new(1.0, 0.5, 0.25) * expected).length() < 1e-4, "{intensity}: {found}");
            assert!((light.mean_radiance().x * PI - expected).abs() < 1e-3, "{intensity}");
        }
    }

    #[test]
    fn without_openings_there_is_no_light() {
        let open = space(|_, _| 1.0);
        let closed = ClosedSpace { is_lit: false, ..open.clone() };
        assert_eq!(EnclosedLight::new(&[]), None);
        assert_eq!(EnclosedLight::new(&[(&closed, 1.0), (&open, 0.0)]), None);
        // But times without them count where there are others.
        assert!(EnclosedLight::new(&[(&closed, 1.0), (&open, 1.0)]).is_some());
    }
}
