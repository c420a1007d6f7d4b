//! Light on a plane by azimuth and elevation, to choose directions in any range of both by it.
//!
//! Source: Bitterli, Novák and Jarosz, "Portal-Masked Environment Map Sampling" (EGSR 2015), whose rectangles of a summed-area table are
//! parts of a portal there, and ranges of azimuths and of squared sines of the elevation here: equal rectangles have equal projected solid angles.

use std::f32::consts::TAU;

use glam::Vec3;
use rayon::prelude::*;

use crate::geometry::sin_cos_of_turn;
use crate::integrator::local_frame::local_frame;
use crate::integrator::occluders::{DirectionRange, local_direction};

/// Cells of azimuths in a turn.
const COLUMNS: usize = 128;
/// Cells of squared sines of elevations.
const ROWS: usize = 64;
/// Directions along an edge of a cell whose mean luminance is that of the cell.
const STEPS: usize = 3;

/// The light that reaches a plane from each cell of directions.
#[derive(Clone, Debug)]
pub(in crate::integrator) struct HemisphereLight {
    normal: Vec3,
    /// Irradiance from all azimuths and squared sines up to the nodes, column by column over two turns, so that no range wraps around.
    summed_area: Vec<[f32; ROWS + 1]>,
}

/// A range of azimuths and elevations as one of columns and rows.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct LightWindow {
    columns: [f32; 2],
    rows: [f32; 2],
    /// Irradiance from the azimuths up to both ends, within the rows.
    ends: [f32; 2],
}

impl HemisphereLight {
    /// The light above a plane of this unit normal.
    pub(super) fn new(normal: Vec3, luminance: impl Fn(Vec3) -> f32 + Sync) -> Self {
        let frame = local_frame(normal);
        let cell = 0.5 * f64::from(TAU) / (COLUMNS * ROWS) as f64;
        let columns = (0..COLUMNS).into_par_iter().map(|column| {
            let azimuths: [(f32, f32); STEPS] = std::array::from_fn(|step| {
                let turns = (column as f32 + (step as f32 + 0.5) / STEPS as f32) / COLUMNS as f32;
                sin_cos_of_turn(turns * TAU)
            });
            let mut sum = 0.0;
            let mut sums = [0.0; ROWS + 1];
            for (row, sum_to) in sums.iter_mut().skip(1).enumerate() {
                // Cells at the horizon and at the zenith are high.
                let steps = if row == 0 || row + 1 == ROWS { 4 * STEPS } else { STEPS };
                let mut light = 0.0;
                for step in 0..steps {
                    let sine_squared = (row as f32 + (step as f32 + 0.5) / steps as f32) / ROWS as f32;
                    let directions = azimuths.map(|azimuth| frame * local_direction(azimuth, sine_squared));
                    light += directions.map(|direction| f64::from(luminance(direction))).iter().sum::<f64>();
                }
                sum += light * cell / (steps * STEPS) as f64;
                *sum_to = sum;
            }
            sums
        });
        let columns: Vec<[f64; ROWS + 1]> = columns.collect();
        let mut all = [0.0; ROWS + 1];
        let mut summed_area = vec![[0.0; ROWS + 1]];
        for column in columns.iter().chain(&columns) {
            all.iter_mut().zip(column).for_each(|(sum, light)| *sum += light);
            summed_area.push(all.map(|sum| sum as f32));
        }
        Self { normal, summed_area }
    }

    /// The normal of the plane.
    pub(super) fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Irradiance from all directions.
    pub(super) fn irradiance(&self) -> f32 {
        self.summed_area[COLUMNS][ROWS]
    }

    /// The part of the light from a range above the plane.
    pub(super) fn window(&self, range: &DirectionRange) -> LightWindow {
        let start = range.start_azimuth() / TAU * COLUMNS as f32;
        let columns = [start, start + range.span() / TAU * COLUMNS as f32];
        let rows = range.sines_squared().map(|sine_squared| sine_squared * ROWS as f32);
        let mut window = LightWindow { columns, rows, ends: [0.0; 2] };
        window.ends = columns.map(|position| {
            let (column, fraction) = cell_at(position, 2 * COLUMNS);
            let [start, end] = [column, column + 1].map(|column| self.up_to(&window, column));
            start + (end - start) * fraction
        });
        window
    }

    /// Irradiance from the azimuths up to a column, within the rows of a window.
    #[inline(always)]
    fn up_to(&self, window: &LightWindow, column: usize) -> f32 {
        let sums = &self.summed_area[column];
        let [lowest, highest] = window.at_rows(|row| sums[row]);
        highest - lowest
    }

    /// A direction of a window, by the light and its cosine.
    pub(super) fn direction(&self, window: &LightWindow, u: [f32; 2]) -> Vec3 {
        let [start, end] = window.ends;
        let column = (window.columns, 2 * COLUMNS);
        let (column, across) =
            inverted(column, start + u[0] * (end - start), |column| self.up_to(window, column));
        let [before, after] = [&self.summed_area[column], &self.summed_area[column + 1]];
        let of_column = |row: usize| after[row] - before[row];
        let [lowest, highest] = window.at_rows(of_column);
        let (row, along) = inverted((window.rows, ROWS), lowest + u[1] * (highest - lowest), of_column);

        let within = |[first, last]: [f32; 2], position: f32| position.max(first).min(last);
        let turns = within(window.columns, column as f32 + across) / COLUMNS as f32;
        let sine_squared = within(window.rows, row as f32 + along) / ROWS as f32;
        let azimuth = sin_cos_of_turn((turns - turns as i32 as f32) * TAU);
        local_frame(self.normal) * local_direction(azimuth, sine_squared)
    }
}

impl LightWindow {
    /// Irradiance from all its directions.
    pub(super) fn irradiance(&self) -> f32 {
        self.ends[1] - self.ends[0]
    }

    /// Sums up to the rows, interpolated at both ends of the window.
    #[inline(always)]
    fn at_rows(&self, sum_to: impl Fn(usize) -> f32) -> [f32; 2] {
        self.rows.map(|position| {
            let (row, fraction) = cell_at(position, ROWS);
            sum_to(row) + (sum_to(row + 1) - sum_to(row)) * fraction
        })
    }
}

/// The cell of a position among so many, and how far it is through the cell.
#[inline(always)]
fn cell_at(position: f32, cells: usize) -> (usize, f32) {
    let cell = (position as i32 as usize).min(cells - 1);
    (cell, position - cell as f32)
}

/// Inverts a cumulative sum: the cell of a range of positions, among so many cells, in which `sum` is reached, and how far through the cell.
/// `sum_to` returns the sum up to the start of a cell.
#[inline(always)]
fn inverted(
    ([start, end], cells): ([f32; 2], usize),
    sum: f32,
    sum_to: impl Fn(usize) -> f32,
) -> (usize, f32) {
    let (first, _) = cell_at(start, cells);
    // The first cell whose end is beyond the sum, or the last one
    let (mut low, mut high) = (first, (end.ceil() as i32 as usize).clamp(first + 1, cells) - 1);
    while low < high {
        let middle = usize::midpoint(low, high);
        if sum_to(middle + 1) > sum {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    let (before, after) = (sum_to(low), sum_to(low + 1));
    let fraction = (sum - before) / (after - before);
    // A cell without light, at the end of the range
    (low, if fraction >= 0.0 { fraction.min(1.0) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Aabb, spiral_direction};
    use crate::integrator::occluders::OccluderBox;

    fn luminance(wi: Vec3) -> f32 {
        let lamp = if wi.distance(Vec3::new(0.8, 0.36, 0.48)) < 0.3 { 20.0 } else { 0.0 };
        0.5 + 0.4 * wi.x + lamp
    }

    #[test]
    fn windows_hold_the_light_of_their_directions() {
        let boxed = |min: Vec3, max: Vec3| OccluderBox::new(Aabb { min, max });
        for (occluders, point, normal) in [
            (boxed(Vec3::splat(-0.5), Vec3::splat(0.5)), Vec3::new(-1.5, -0.5, -0.9), Vec3::Y),
            (boxed(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 4.0, 1.0)), Vec3::new(-1.6, 0.0, 0.2), Vec3::Y),
            (boxed(Vec3::new(-1.0, 3.0, -1.0), Vec3::new(2.0, 4.0, 1.0)), Vec3::ZERO, Vec3::Y),
            // Across the azimuth 0
            (boxed(Vec3::splat(-0.5), Vec3::splat(0.5)), Vec3::new(-3.0, -0.5, 0.0), Vec3::Y),
            (
                boxed(Vec3::splat(-0.5), Vec3::splat(0.5)),
                Vec3::new(-1.0, -0.5, 1.0),
                Vec3::new(0.6, 0.8, 0.0),
            ),
        ] {
            let light = HemisphereLight::new(normal, luminance);
            let range = occluders.range_from(point, normal).unwrap();
            let window = light.window(&range);

            // Light and its mean direction, by the directions of a range that are spread by their cosine
            let count = 100_000;
            let (mut expected, mut mean) = (0.0, Vec3::ZERO);
            let points = (0..count).map(|i| i as f32);
            for i in points.clone() {
                let u = glam::Vec2::new((i + 0.5) / count as f32, i * 0.618_034).fract();
                let wi = range.direction(u);
                expected += luminance(wi);
                mean += wi * luminance(wi);
            }
            mean /= expected;
            let expected = expected / count as f32 * range.projected_solid_angle();
            let irradiance = window.irradiance();
            assert!((irradiance / expected - 1.0).abs() < 0.03, "{point}: {irradiance} for {expected}");

            let mut of_samples = Vec3::ZERO;
            for i in points {
                let u = [(i + 0.5) / count as f32, (i * 0.618_034).fract()];
                let wi = light.direction(&window, u);
                assert!((wi.length() - 1.0).abs() < 1e-5);
                of_samples += wi / count as f32;
            }
            assert!(of_samples.distance(mean) < 0.02, "{point}: {of_samples} for {mean}");
        }
    }

    #[test]
    fn all_light_is_the_integral_of_light_times_cosine() {
        let normal = Vec3::new(0.48, 0.6, 0.64);
        let count = 100_000;
        let directions = (0..count).map(|i| spiral_direction(i, count));
        let expected = directions.map(|wi| f64::from(luminance(wi) * wi.dot(normal).max(0.0))).sum::<f64>()
            * 4.0
            * std::f64::consts::PI
            / f64::from(count);
        let found = f64::from(HemisphereLight::new(normal, luminance).irradiance());
        assert!((found / expected - 1.0).abs() < 0.01, "{found} for {expected}");
        let dark = HemisphereLight::new(normal, |_| 0.0);
        assert_eq!(dark.irradiance(), 0.0);
    }

    #[test]
    fn windows_without_light_have_none_and_are_no_trouble() {
        let light = HemisphereLight::new(Vec3::Y, |wi| if wi.x > 0.5 { 1.0 } else { 0.0 });
        let occluders = OccluderBox::new(Aabb { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) });
        let range = occluders.range_from(Vec3::new(3.0, -0.5, 0.0), Vec3::Y).unwrap();
        let window = light.window(&range);
        assert!(window.irradiance().abs() < 1e-6);
        let wi = light.direction(&window, [0.5, 0.5]);
        assert!((wi.length() - 1.0).abs() < 1e-5 && wi.x < 0.0, "{wi}");
        // The last number below 1
        let lit = light.window(&occluders.range_from(Vec3::new(-3.0, -0.5, 0.0), Vec3::Y).unwrap());
        let last = light.direction(&lit, [1.0_f32.next_down(); 2]);
        assert!(last.is_finite() && last.x > 0.5, "{last}");
    }

    #[test]
    fn small_lamps_at_the_zenith_and_at_the_horizon_are_found() {
        for (height, radius) in [(1.0, 0.05), (0.035, 0.05), (0.3, 0.03)] {
            let center = Vec3::new((1.0_f32 - height * height).sqrt(), height, 0.0);
            let lamp = |wi: Vec3| if wi.distance(center) < radius { 1.0 } else { 0.0 };
            let light = HemisphereLight::new(Vec3::Y, lamp);
            let count = 2_000_000;
            let expected = (0..count)
                .map(|i| spiral_direction(i, count))
                .map(|wi| f64::from(lamp(wi) * wi.y.max(0.0)))
                .sum::<f64>()
                * 4.0
                * std::f64::consts::PI
                / f64::from(count);
            let found = f64::from(light.irradiance());
            assert!((found / expected - 1.0).abs() < 0.15, "{height}: {found} for {expected}");
        }
    }

    #[test]
    fn boxes_that_are_far_above_have_directions() {
        let light = HemisphereLight::new(Vec3::Y, |_| 1.0);
        let far = OccluderBox::new(Aabb { min: Vec3::splat(-1e-4), max: Vec3::splat(1e-4) });
        let range = far.range_from(Vec3::NEG_Y * 10.0, Vec3::Y).unwrap();
        for u in [[0.0; 2], [0.5; 2], [1.0_f32.next_down(); 2]] {
            let wi = light.direction(&light.window(&range), u);
            assert!((wi.length() - 1.0).abs() < 1e-5 && wi.y > 0.999, "{wi}");
        }
    }
}
