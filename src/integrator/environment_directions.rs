//! Directions of shadow rays towards the environment, for surfaces that look its light up.
//!
//! Whitted's tree multiplies a looked-up light by an estimate of the share that arrives: a ratio of shadowed to unshadowed samples
//! (Heitz, Hill and McGuire, "Combining Analytic Direct Illumination and Stochastic Shadows", I3D 2018). Directions follow the
//! light that the lookup averages, so that the ratio is the mean visibility of the samples.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::occluders::Cone;
use super::whitted::local_frame;
use crate::geometry::sin_cos_of_turn;
use crate::scene::{Environment, LuminanceImage};

/// The golden ratio less one: the share of a turn from one candidate to the next.
const GOLDEN_SHARE: f32 = 0.618_034;

/// Cells along an edge of the square of directions: 6° to 9° each.
const CELLS: usize = 32;

/// Intervals between normals along an edge of their square: 11° to 17° each.
const NORMAL_STEPS: usize = 16;

/// Directions of a rough lobe among which one is chosen.
const CANDIDATES: usize = 4;

/// Directions by the luminance of an environment.
#[derive(Debug)]
pub(super) struct EnvironmentDirections {
    luminance: LuminanceImage,
    /// For each normal, the cumulative light of the cells times their cosine, row by row.
    cumulative: Vec<f32>,
    /// The largest luminance.
    brightest: f32,
    /// Irradiance for one of the last sums of `cumulative`: the solid angle that its weights leave out.
    irradiance_scale: f32,
    /// The same as `cumulative` at the end of each row: two cache lines, where a search among all cells touches one for each of its first steps.
    row_ends: Vec<f32>,
}

impl EnvironmentDirections {
    /// Directions of an environment that is lit.
    pub(super) fn new(environment: &Environment) -> Self {
        let luminance = LuminanceImage::new(environment);
        let mut widths = 0.0;
        let cells: Vec<(Vec3, f32)> = (0..CELLS * CELLS)
            .map(|cell| {
                let direction = direction_in(cell, Vec2::splat(0.5));
                // The solid angle of a cell, but for a factor: the plane of the octahedron is nearest in the middle of a face.
                let width = direction.abs().element_sum();
                widths += width * width * width;
                (direction, luminance.at(direction) * width * width * width)
            })
            .collect();
        let side = NORMAL_STEPS + 1;
        let mut cumulative = Vec::with_capacity(side * side * cells.len());
        for node in 0..side * side {
            let uv = Vec2::new((node % side) as f32, (node / side) as f32) / NORMAL_STEPS as f32;
            let normal = LuminanceImage::direction_from_uv(uv);
            let mut sum = 0.0;
            cumulative.extend(cells.iter().map(|&(direction, light)| {
                let cosine = normal.dot(direction);
                sum += if cosine > 0.0 { light * cosine } else { 0.0 };
                sum
            }));
        }
        let row_ends = cumulative.iter().skip(CELLS - 1).step_by(CELLS).copied().collect();
        Self {
            brightest: luminance.largest(),
            irradiance_scale: 2.0 * TAU / widths,
            luminance,
            cumulative,
            row_ends,
        }
    }

    /// A direction from which light reaches a diffuse surface; `None` where none does. The density is that of the light times the cosine, by
    /// cells, and interpolated between normals; the place in the cell depends a little on which normal was chosen.
    pub(super) fn diffuse(&self, normal: Vec3, u: Vec2, u_choice: f32) -> Option<Vec3> {
        // One of the four normals around this one, by its share in a bilinear interpolation
        let node = (LuminanceImage::uv_from_direction(normal) * NORMAL_STEPS as f32 + u).floor();
        let node = node.min(Vec2::splat(NORMAL_STEPS as f32));
        let node = node.y as usize * (NORMAL_STEPS + 1) + node.x as usize;
        let row_ends = self.row_ends.get(node * CELLS..)?.first_chunk::<CELLS>()?;
        let chosen = u_choice * row_ends[CELLS - 1];
        let row = node * CELLS + count_up_to(row_ends, chosen);
        if row == (node + 1) * CELLS {
            return None;
        }
        let cells = self.cumulative.get(row * CELLS..)?.first_chunk::<CELLS>()?;
        let column = count_up_to(cells, chosen);
        let direction = direction_in(row % CELLS * CELLS + column, u);
        // A cell, or a normal, may reach a little beyond the horizon.
        let height = direction.dot(normal);
        Some(if height < 0.0 { direction - normal * (2.0 * height) } else { direction })
    }

    /// The irradiance of a surface by luminance, as the sum of all cells, interpolated between normals.
    pub(super) fn irradiance(&self, normal: Vec3) -> f32 {
        let position = LuminanceImage::uv_from_direction(normal) * NORMAL_STEPS as f32;
        let node = position.floor().min(Vec2::splat((NORMAL_STEPS - 1) as f32));
        let share = position - node;
        let sum = |column: usize, row: usize| {
            let node = (node.y as usize + row) * (NORMAL_STEPS + 1) + node.x as usize + column;
            self.row_ends.get((node + 1) * CELLS - 1).copied().unwrap_or_default()
        };
        let [above, below] = [0, 1].map(|row| sum(0, row) + (sum(1, row) - sum(0, row)) * share.x);
        (above + (below - above) * share.y) * self.irradiance_scale
    }

    /// The largest irradiance that [`EnvironmentDirections::within`] may find.
    pub(super) fn most_within(&self, cone: &Cone, normal: Vec3) -> f32 {
        self.brightest * cone.largest_cosine(normal) * cone.solid_angle()
    }

    /// A direction in a cone above a diffuse surface, and an estimate of the irradiance that the cone holds, by luminance; `None` if it holds
    /// none. Directions below the surface are mirrored by it, as those of [`EnvironmentDirections::diffuse`].
    pub(super) fn within(&self, cone: &Cone, normal: Vec3, u: Vec2) -> Option<(Vec3, f32)> {
        let direction = cone.direction(u);
        let height = direction.dot(normal);
        let mirrored = direction - normal * (2.0 * height);
        let above = if height < 0.0 { mirrored } else { direction };
        // Directions whose mirror image is in the cone, too, are twice as frequent.
        let has_both = cone.contains(mirrored);
        let frequency = if has_both { 2.0 } else { 1.0 };
        let irradiance = self.luminance.at(above) * height.abs() * cone.solid_angle() / frequency;
        ((height >= 0.0 || has_both) && irradiance > 0.0).then_some((above, irradiance))
    }

    /// A direction of the lobe that prefiltered lookups average: GGX of `roughness` around the mirror direction, for a view along the normal, as
    /// far as it is within 90° of that direction. Of several ones, one is chosen by its luminance (Talbot, Cline and Egbert, "Importance
    /// Resampling for Global Illumination", 2005).
    pub(super) fn glossy(&self, mirrored: Vec3, roughness: f32, u: Vec2, u_choice: f32) -> Vec3 {
        let candidates = LobeDirections::new(mirrored, roughness, u);
        let mut sums = [0.0; CANDIDATES];
        let mut sum = 0.0;
        for (uv, sum_to) in candidates.uvs().into_iter().zip(&mut sums) {
            sum += self.luminance.at_uv(uv);
            *sum_to = sum;
        }
        let chosen = sums.iter().position(|sum_to| u_choice * sum < *sum_to);
        chosen.map_or(mirrored, |candidate| candidates.get(candidate))
    }
}

/// Stratified directions of a lobe of [`EnvironmentDirections::glossy`], component by component, so that they are computed in lanes.
struct LobeDirections {
    x: [f32; CANDIDATES],
    y: [f32; CANDIDATES],
    z: [f32; CANDIDATES],
}

impl LobeDirections {
    #[inline(always)]
    fn new(mirrored: Vec3, roughness: f32, u: Vec2) -> Self {
        let alpha_squared = (roughness * roughness) * (roughness * roughness);
        // Half vectors up to 45° from the axis
        let scale = 1.0 + alpha_squared;
        let cosines = in_lanes(|stratum| {
            let u_x = (stratum as f32 + u.x) / CANDIDATES as f32 / scale;
            1.0 / (1.0 + alpha_squared * u_x / (1.0 - u_x)).sqrt()
        });
        let sines = in_lanes(|i| (1.0 - cosines[i] * cosines[i]).max(0.0).sqrt());
        let (mut along_tangent, mut along_bitangent) = ([0.0; CANDIDATES], [0.0; CANDIDATES]);
        for stratum in 0..CANDIDATES {
            let turns = u.y + stratum as f32 * GOLDEN_SHARE;
            let (sine, cosine) = sin_cos_of_turn((turns - turns as i32 as f32) * TAU);
            along_tangent[stratum] = sines[stratum] * cosine;
            along_bitangent[stratum] = sines[stratum] * sine;
        }

        // Mirror the axis at the half vectors.
        let frame = local_frame(mirrored);
        let component = |tangent: f32, bitangent: f32, axis: f32| {
            in_lanes(|i| {
                let half = tangent * along_tangent[i] + bitangent * along_bitangent[i] + axis * cosines[i];
                half * (2.0 * cosines[i]) - axis
            })
        };
        Self {
            x: component(frame.x_axis.x, frame.y_axis.x, frame.z_axis.x),
            y: component(frame.x_axis.y, frame.y_axis.y, frame.z_axis.y),
            z: component(frame.x_axis.z, frame.y_axis.z, frame.z_axis.z),
        }
    }

    #[inline(always)]
    fn get(&self, candidate: usize) -> Vec3 {
        Vec3::new(self.x[candidate], self.y[candidate], self.z[candidate])
    }

    /// Positions in the unit square.
    #[inline(always)]
    fn uvs(&self) -> [Vec2; CANDIDATES] {
        std::array::from_fn(|candidate| LuminanceImage::uv_from_direction(self.get(candidate)))
    }
}

/// The value of each lane.
#[inline(always)]
fn in_lanes(value: impl Fn(usize) -> f32) -> [f32; CANDIDATES] {
    std::array::from_fn(value)
}

/// How many of the sums are at most `chosen`. They never decrease, so that this is a search; counting all takes no branch and is done in lanes.
fn count_up_to(sums: &[f32; CELLS], chosen: f32) -> usize {
    debug_assert!(sums.is_sorted() || sums[CELLS - 1].is_nan());
    sums.iter().map(|&sum| u32::from(sum <= chosen)).sum::<u32>() as usize
}

/// The direction at `u` in a cell.
fn direction_in(cell: usize, u: Vec2) -> Vec3 {
    let corner = Vec2::new((cell % CELLS) as f32, (cell / CELLS) as f32);
    LuminanceImage::direction_from_uv((corner + u) / CELLS as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::occluders::OccluderSphere;
    use crate::scene::BuiltInLight;

    fn points(count: u32) -> impl Iterator<Item = (Vec2, f32)> {
        let fraction = |x: f32| x - x.floor();
        (0..count).map(move |i| {
            let i = i as f32 + 0.5;
            (Vec2::new(fraction(i * 0.754_877_7), fraction(i * 0.569_840_3)), fraction(i * 0.618_034))
        })
    }

    #[test]
    fn the_mean_of_the_directions_is_that_of_the_light() {
        // A sky that is bright on one side: E[wi] = ∫ L wi cos / ∫ L cos, by a fine grid.
        let environment = Environment::BuiltIn(BuiltInLight::Studio);
        let directions = EnvironmentDirections::new(&environment);
        for normal in [Vec3::Y, Vec3::X, Vec3::new(0.0, -0.6, 0.8)] {
            let (mut expected, mut light) = (Vec3::ZERO, 0.0);
            let frame = local_frame(normal);
            for (u, _) in points(20_000) {
                let (sine, cosine) = libm::sincosf(u.y * TAU);
                let radius = u.x.sqrt();
                let wi = frame * Vec3::new(radius * cosine, radius * sine, (1.0 - u.x).sqrt());
                let luminance = directions.luminance.at(wi);
                expected += wi * luminance;
                light += luminance;
            }
            expected /= light;
            let count = 4000;
            let mean: Vec3 =
                points(count).map(|(u, choice)| directions.diffuse(normal, u, choice).unwrap()).sum::<Vec3>()
                    / count as f32;
            assert!((mean - expected).length() < 0.03, "{normal}: {mean} for {expected}");
        }
    }

    #[test]
    fn the_light_in_a_cone_is_the_mean_of_its_estimates() {
        // Under a uniform sky of 1, a cone of half angle a above the horizon holds pi sin² a cos b, b the angle of its axis; one whose axis lies
        // in the surface holds half of the solid angle's cosines: ∫ sin t (2 sin t) dt over 0..a = a - sin a cos a.
        let sphere = OccluderSphere::new(Vec3::ZERO, 1.0);
        let mean = |directions: &EnvironmentDirections, cone: &Cone, normal: Vec3| {
            let count = 20_000;
            let all = points(count).filter_map(|(u, _)| directions.within(cone, normal, u));
            all.inspect(|(wi, _)| assert!(cone.contains(*wi) || wi.dot(normal) < 1e-3))
                .map(|(_, irradiance)| f64::from(irradiance))
                .sum::<f64>()
                / f64::from(count)
        };
        let sky = EnvironmentDirections::new(&Environment::Constant(Vec3::ONE));
        let (sine, cosine) = (0.25_f64, 0.9375_f64.sqrt());
        let above = sphere.cone_from(Vec3::new(0.0, -3.2, -2.4)).unwrap();
        let expected = std::f64::consts::PI * sine * sine * 0.8;
        assert!((mean(&sky, &above, Vec3::Y) / expected - 1.0).abs() < 3e-3);
        let level = sphere.cone_from(Vec3::X * 4.0).unwrap();
        let expected = libm::asin(sine) - sine * cosine;
        assert!((mean(&sky, &level, Vec3::Y) / expected - 1.0).abs() < 3e-3);

        // A studio, and a cone that the surface cuts anywhere: the mean over its directions, of which those below hold nothing.
        let studio = EnvironmentDirections::new(&Environment::BuiltIn(BuiltInLight::Studio));
        let cut = sphere.cone_from(Vec3::new(-2.4, -0.2, 0.8)).unwrap();
        let count = 20_000;
        let of_direction = |(u, _)| {
            let wi = cut.direction(u);
            f64::from(studio.luminance.at(wi) * wi.y.max(0.0))
        };
        let expected =
            points(count).map(of_direction).sum::<f64>() * f64::from(cut.solid_angle()) / f64::from(count);
        assert!((mean(&studio, &cut, Vec3::Y) / expected - 1.0).abs() < 1e-2);
    }

    #[test]
    fn the_irradiance_is_that_of_the_cosine_lobe() {
        for environment in [Environment::Constant(Vec3::ONE), Environment::BuiltIn(BuiltInLight::Studio)] {
            let directions = EnvironmentDirections::new(&environment);
            for normal in [Vec3::Y, Vec3::X, Vec3::new(0.0, -0.6, 0.8), Vec3::new(0.48, 0.6, -0.64)] {
                let frame = local_frame(normal);
                let count = 20_000;
                let radiances = points(count).map(|(u, _)| {
                    let (sine, cosine) = libm::sincosf(u.y * TAU);
                    let radius = u.x.sqrt();
                    let wi = frame * Vec3::new(radius * cosine, radius * sine, (1.0 - u.x).sqrt());
                    f64::from(directions.luminance.at(wi))
                });
                let expected = radiances.sum::<f64>() * std::f64::consts::PI / f64::from(count);
                let found = f64::from(directions.irradiance(normal));
                assert!((found / expected - 1.0).abs() < 0.015, "{normal}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn no_estimate_of_a_cone_exceeds_its_limit() {
        let sphere = OccluderSphere::new(Vec3::ZERO, 1.0);
        for light in [BuiltInLight::Studio, BuiltInLight::Dark, BuiltInLight::Outdoor] {
            let directions = EnvironmentDirections::new(&Environment::BuiltIn(light));
            for i in 0..100 {
                let away = crate::geometry::spiral_direction(i, 100);
                let cone = sphere.cone_from(away * (2.1 + i as f32 * 0.1)).unwrap();
                let limit = directions.most_within(&cone, Vec3::Y);
                let mut largest = 0.0_f32;
                for (_, irradiance) in points(200).filter_map(|(u, _)| directions.within(&cone, Vec3::Y, u)) {
                    largest = largest.max(irradiance);
                }
                assert!(largest <= limit * 1.00001, "{light:?} {i}: {largest} {limit}");
            }
        }
    }

    #[test]
    fn directions_are_unit_vectors_of_their_hemisphere_and_lobe() {
        let directions = EnvironmentDirections::new(&Environment::Constant(Vec3::ONE));
        let axis = Vec3::new(0.48, 0.6, -0.64);
        for (u, choice) in points(500) {
            let wi = directions.diffuse(axis, u, choice).unwrap();
            assert!((wi.length() - 1.0).abs() < 1e-5 && wi.dot(axis) >= 0.0);
            assert!((directions.glossy(axis, 0.0, u, choice) - axis).length() < 1e-6);
            for roughness in [0.5, 0.8, 1.0] {
                let wide = directions.glossy(axis, roughness, u, choice);
                assert!((wide.length() - 1.0).abs() < 1e-4 && wide.dot(axis) > -1e-5, "{wide}");
            }
        }
    }

    /// [`EnvironmentDirections::glossy`], one direction after the other.
    fn chosen_one_by_one(
        directions: &EnvironmentDirections,
        (mirrored, roughness): (Vec3, f32),
        u: Vec2,
        u_choice: f32,
    ) -> Vec3 {
        let alpha = roughness * roughness;
        let lobe_direction = |u: Vec2| {
            let u_x = u.x / (1.0 + alpha * alpha);
            let tangent_squared = alpha * alpha * u_x / (1.0 - u_x);
            let cosine = 1.0 / (1.0 + tangent_squared).sqrt();
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            let (sin_azimuth, cos_azimuth) = libm::sincosf(u.y * TAU);
            let half = local_frame(mirrored) * Vec3::new(sine * cos_azimuth, sine * sin_azimuth, cosine);
            half * (2.0 * cosine) - mirrored
        };
        let mut candidates = [(mirrored, 0.0); CANDIDATES];
        let mut sum = 0.0;
        for (stratum, candidate) in candidates.iter_mut().enumerate() {
            let azimuth = u.y + stratum as f32 * GOLDEN_SHARE;
            let u = Vec2::new((stratum as f32 + u.x) / CANDIDATES as f32, azimuth - azimuth.floor());
            let direction = lobe_direction(u);
            sum += directions.luminance.at(direction);
            *candidate = (direction, sum);
        }
        let chosen = candidates.iter().find(|(_, sum_to)| u_choice * sum < *sum_to);
        chosen.map_or(mirrored, |(direction, _)| *direction)
    }

    #[test]
    fn glossy_directions_in_lanes_have_the_bits_of_single_ones() {
        let directions = EnvironmentDirections::new(&Environment::BuiltIn(BuiltInLight::Studio));
        for (number, (u, choice)) in points(4000).enumerate() {
            let mirrored = crate::geometry::spiral_direction(number as u32, 4000);
            let roughness = (number % 101) as f32 / 100.0;
            let expected = chosen_one_by_one(&directions, (mirrored, roughness), u, choice);
            let found = directions.glossy(mirrored, roughness, u, choice);
            assert_eq!(found.to_array().map(f32::to_bits), expected.to_array().map(f32::to_bits));
        }
    }

    #[test]
    fn counting_sums_is_a_search() {
        let ramp: [f32; CELLS] = std::array::from_fn(|i| i as f32);
        let steps = ramp.map(|sum| (sum / 5.0).floor());
        let overflow = ramp.map(|sum| if sum > 20.0 { f32::INFINITY } else { sum });
        let unknown = ramp.map(|sum| if sum > 20.0 { f32::NAN } else { sum });
        for sums in [ramp, steps, overflow, unknown, [0.0; CELLS]] {
            for chosen in [0.0, 0.5, 1.0, 5.5, 20.0, 31.0, 40.0, f32::INFINITY, f32::NAN] {
                let expected = sums.partition_point(|&sum| sum <= chosen);
                assert_eq!(count_up_to(&sums, chosen), expected, "{chosen} in {sums:?}");
            }
        }
    }

    #[test]
    fn no_direction_leads_to_darkness() {
        let directions = EnvironmentDirections::new(&Environment::Constant(Vec3::ZERO));
        assert_eq!(directions.diffuse(Vec3::Y, Vec2::splat(0.5), 0.5), None);
    }
}
