//! Light of the environment inside a closed space, as surfaces look it up by their positions and normals.

use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

use glam::{Vec3, Vec3A};

use super::ClosedSpace;
use crate::integrator::ambient_cubes::{AmbientCubes, kernel_weights};
use crate::integrator::radiosity::LitWall;

/// Cells along the longest axis of the grid.
const CELLS: usize = 10;
/// Walls of which a grid is made, at most: of many times of an animation, every few.
const MOST_WALLS: usize = 2048;
/// Walls around a point count up to [`REACH`] times the distance of this one.
const NEAREST: usize = 6;
const REACH: f32 = 2.0;

/// The irradiance of walls, in between and beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct EnclosedLight {
    light: Arc<Light>,
    /// The same without the environment, where its intensity is animated and `light` is that of an intensity of one.
    dark: Option<Arc<Light>>,
}

#[derive(Debug, PartialEq)]
struct Light {
    cubes: AmbientCubes,
    /// Over all walls and directions.
    mean_radiance: Vec3,
}

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
        let total: f32 = walls.iter().map(|(_, weight)| weight).sum();
        let mean = walls.iter().map(|(wall, weight)| wall.irradiance * (weight / (total * PI))).sum();
        let position_and_normal = |(wall, _): &WeightedWall| (wall.position, wall.normal);
        let cubes = AmbientCubes::new(&walls, CELLS, position_and_normal, mean_irradiance);
        Some(Self { light: Arc::new(Light { cubes, mean_radiance: mean }), dark: None })
    }

    /// The light at any intensity of the environment: `self` is that of one, `dark` that of the same walls without it.
    pub(in crate::integrator) fn with_dark(self, dark: Self) -> Self {
        Self { dark: Some(dark.light), ..self }
    }

    /// The light in a frame whose environment has this intensity; the same as `self` where that is not animated.
    pub(in crate::integrator) fn at_intensity(&self, intensity: f32) -> Self {
        let Some(dark) = &self.dark else { return self.clone() };
        // Light is linear in the intensity.
        let cubes = dark.cubes.towards(&self.light.cubes, intensity);
        let mean_radiance = dark.mean_radiance + (self.light.mean_radiance - dark.mean_radiance) * intensity;
        Self { light: Arc::new(Light { cubes, mean_radiance }), dark: None }
    }

    /// Irradiance on a surface with this normal.
    #[inline]
    pub(in crate::integrator) fn irradiance(&self, position: Vec3, normal: Vec3) -> Vec3 {
        self.light.cubes.irradiance(position, normal)
    }

    /// Mean radiance in a lobe around a direction: that of the widest lobe, whatever its roughness.
    #[inline]
    pub(in crate::integrator) fn prefiltered(&self, position: Vec3, direction: Vec3) -> Vec3 {
        self.light.cubes.irradiance(position, direction) * FRAC_1_PI
    }

    /// Mean radiance over all directions.
    pub(in crate::integrator) fn mean_radiance(&self) -> Vec3 {
        self.light.mean_radiance
    }

    /// Numbers that tell one light from any other.
    pub(in crate::integrator) fn bits(&self) -> impl Iterator<Item = u32> {
        std::iter::once(&self.light).chain(&self.dark).flat_map(|light| light.cubes.bits())
    }
}

/// Mean irradiance of the walls around a point.
fn mean_irradiance(point: Vec3, walls: &[WeightedWall]) -> Vec3A {
    let distances = walls.iter().map(|(wall, _)| wall.position.distance_squared(point)).collect();
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for ((wall, weight), kernel) in walls.iter().zip(kernel_weights(distances, NEAREST, REACH)) {
        let weight = weight * kernel;
        sum += wall.irradiance * weight;
        weights += weight;
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
            LitWall { position, normal, irradiance, by_environment: irradiance, open_share: 0.1 }
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
