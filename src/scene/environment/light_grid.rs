//! Light of an environment by cells of directions, to choose directions of shadow rays by.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::LuminanceImage;
use super::lookup_lanes::LookupLanes;
use crate::geometry::{ActiveLanes, F32Lanes, LANES, Vec2Lanes, Vec3Lanes, vectorized};

/// Cells along an edge of the square of directions: 4° to 9° each.
const CELLS: usize = 32;
/// Parts along an edge of a cell: those of the grid of luminances.
const PARTS: usize = LuminanceImage::CELLS / CELLS;

/// Intervals between normals along an edge of their square: 8° to 17° each.
const NORMAL_STEPS: usize = 16;

/// Directions by the luminance of an environment, and its irradiance on surfaces.
#[derive(Debug)]
pub(crate) struct LightGrid {
    luminance: LuminanceImage,
    /// For each normal, the cumulative light of the cells times their cosine, row by row.
    cumulative: Vec<f32>,
    /// How the light of each cell lies in it.
    cells: Vec<CellLight>,
    /// The largest luminance.
    brightest: f32,
    /// Irradiance for one of the last sums of `cumulative`: the solid angle that its weights leave out.
    irradiance_scale: f32,
    /// The same as `cumulative` at the end of each row: two cache lines, where a search among all cells touches one for each of its first steps.
    row_ends: Vec<f32>,
}

impl LightGrid {
    /// The grid of an environment that is lit, by its prefiltered radiance; see [`LuminanceImage::new`].
    pub(super) fn new(prefiltered: impl Fn(&LookupLanes<'_>, &F32Lanes, &mut Vec3Lanes) + Sync) -> Self {
        let luminance = LuminanceImage::new(prefiltered);
        let mut solid_angles = 0.0;
        // Light of the parts, and the sum of their directions by their light
        let (cells, lights): (Vec<CellLight>, Vec<Vec3>) = (0..CELLS * CELLS)
            .map(|cell| {
                let (mut parts, mut sum) = ([[0.0; PARTS]; PARTS], Vec3::ZERO);
                for (part, place) in part_centers() {
                    let direction = direction_in(cell as u32, place);
                    // The solid angle of a part, but for a factor: the plane of the octahedron is nearest in the middle of a face.
                    let width = direction.abs().element_sum();
                    let solid_angle = width * width * width;
                    let light = luminance.at(direction) * solid_angle;
                    solid_angles += solid_angle;
                    parts[part / PARTS][part % PARTS] = light;
                    sum += direction * light;
                }
                (CellLight::new(&parts), sum)
            })
            .unzip();
        let side = NORMAL_STEPS + 1;
        let mut cumulative = Vec::with_capacity(side * side * lights.len());
        for node in 0..side * side {
            let uv = Vec2::new((node % side) as f32, (node / side) as f32) / NORMAL_STEPS as f32;
            let normal = LuminanceImage::direction_from_uv(uv);
            let mut sum = 0.0;
            cumulative.extend(lights.iter().map(|light| {
                // The sum of light times cosine, where the horizon does not cut the cell
                let light_by_cosine = normal.dot(*light);
                sum += if light_by_cosine > 0.0 { light_by_cosine } else { 0.0 };
                sum
            }));
        }
        let row_ends = cumulative.iter().skip(CELLS - 1).step_by(CELLS).copied().collect();
        Self {
            brightest: luminance.largest(),
            irradiance_scale: 2.0 * TAU / solid_angles,
            luminance,
            cumulative,
            cells,
            row_ends,
        }
    }

    /// A direction from which light reaches a diffuse surface; `None` where none does. The density is that of the light times the cosine, by
    /// cells, and interpolated between normals; in a cell it is that of the light by its parts. The point `u` of the unit square is mapped to
    /// directions row by row, so that stratified points are stratified directions; `random` selects a normal, which makes less of a difference.
    pub(crate) fn diffuse(&self, normal: Vec3, u: Vec2, random: f32) -> Option<Vec3> {
        let (cell, place) = self.cell_of(node_around(normal, random), u)?;
        Some(mirrored_above(normal, direction_in(cell, place)))
    }

    /// [`LightGrid::diffuse`] for the lanes of `normals`, which are the ones that get directions. Returns those to which light comes; others may get
    /// any direction.
    pub(crate) fn diffuse_lanes(
        &self,
        normals: &LookupLanes<'_>,
        u: &Vec2Lanes,
        randoms: &F32Lanes,
        directions: &mut Vec3Lanes,
    ) -> ActiveLanes {
        let LookupLanes { level, directions: normals, lanes } = *normals;
        let (mut nodes, mut cells) = ([0_u32; LANES], [0_u32; LANES]);
        let mut places = Vec2Lanes::default();
        let mut lit = ActiveLanes::default();
        vectorized!(level, {
            for (lane, node) in nodes.iter_mut().enumerate() {
                *node = node_around(normals.get(lane), randoms[lane]);
            }
            for lane in lanes {
                if let Some((cell, place)) = self.cell_of(nodes[lane], u.get(lane)) {
                    cells[lane] = cell;
                    places.set(lane, place);
                    lit = lit.with(lane);
                }
            }
            for (lane, cell) in cells.iter().enumerate() {
                let direction = direction_in(*cell, places.get(lane));
                directions.set(lane, mirrored_above(normals.get(lane), direction));
            }
        });
        lit
    }

    /// The cell of a point of the unit square by the light on a surface with the normal `node`, and the place in the cell. `None` where no light
    /// arrives.
    #[inline(always)]
    fn cell_of(&self, node: u32, u: Vec2) -> Option<(u32, Vec2)> {
        let node = node as usize;
        let row_ends = self.row_ends.get(node * CELLS..)?.first_chunk::<CELLS>()?;
        let row = part_of(row_ends, 0.0, u.y * row_ends[CELLS - 1])?;
        let first = (node * CELLS + row.index) * CELLS;
        let cells = self.cumulative.get(first..)?.first_chunk::<CELLS>()?;
        let column = part_of(cells, row.start, row.start + u.x * row.sum)?;
        let cell = row.index * CELLS + column.index;
        Some((cell as u32, self.cells.get(cell)?.place(Vec2::new(column.place, row.place))))
    }

    /// The irradiance of a surface by luminance, as the sum of all cells, interpolated between normals.
    pub(crate) fn irradiance(&self, normal: Vec3) -> f32 {
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

    /// Luminance from a direction, blurred by the cells of the grid.
    pub(crate) fn luminance(&self, direction: Vec3) -> f32 {
        self.luminance.at(direction)
    }

    /// The same by the position of the direction in the unit square.
    #[inline(always)]
    pub(crate) fn luminance_at_uv(&self, uv: Vec2) -> f32 {
        self.luminance.at_uv(uv)
    }

    /// The largest luminance from any direction.
    pub(crate) fn brightest(&self) -> f32 {
        self.brightest
    }
}

/// How the light of a cell lies in it: in a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct CellLight {
    columns: CumulativeShares,
    /// Of each column.
    rows: [CumulativeShares; PARTS],
}

/// The shares of the first parts of a whole, up to all but the last.
type CumulativeShares = [f32; PARTS - 1];

impl CellLight {
    /// From the light of the parts, column by column.
    fn new(parts: &[[f32; PARTS]; PARTS]) -> Self {
        let columns = parts.map(|column| column.iter().sum());
        Self { columns: cumulative_shares(&columns), rows: parts.map(|column| cumulative_shares(&column)) }
    }

    /// The place in the unit square where light comes from, by a point that is uniform there.
    #[inline(always)]
    fn place(&self, u: Vec2) -> Vec2 {
        let (column, x) = part_at(&self.columns, u.x);
        let (row, y) = part_at(&self.rows[column], u.y);
        Vec2::new(column as f32 + x, row as f32 + y) / PARTS as f32
    }
}

/// The sums of the first values over that of all; those of equal values where there is no light or too much for numbers.
fn cumulative_shares(values: &[f32; PARTS]) -> CumulativeShares {
    let mut sum = 0.0;
    let sums = values.map(|value| {
        sum += value;
        sum
    });
    let is_lit = sum > 0.0 && sum < f32::INFINITY;
    std::array::from_fn(|part| if is_lit { sums[part] / sum } else { (part + 1) as f32 / PARTS as f32 })
}

/// The part in which a number of the unit interval lies, and where in it, both ends included.
#[inline(always)]
fn part_at(shares: &CumulativeShares, u: f32) -> (usize, f32) {
    let part = shares.iter().map(|&share| u32::from(share <= u)).sum::<u32>() as usize;
    let before = part.checked_sub(1).map_or(0.0, |before| shares[before]);
    let end = shares.get(part).copied().unwrap_or(1.0);
    (part, (u - before) / (end - before))
}

/// The parts of a cell with their centres, column by column.
fn part_centers() -> impl Iterator<Item = (usize, Vec2)> {
    let center = |part: usize| (Vec2::new((part / PARTS) as f32, (part % PARTS) as f32) + 0.5) / PARTS as f32;
    (0..PARTS * PARTS).map(move |part| (part, center(part)))
}

/// A part of a whole that was chosen by its share.
struct ChosenPart {
    index: usize,
    /// The sum of all parts before it.
    start: f32,
    /// What it adds to the sum.
    sum: f32,
    /// The place of the chosen number in it, in [0, 1).
    place: f32,
}

/// The part of a whole in which the number `chosen` lies, by the sums up to the end of each part. They begin at `start`. `None` where the whole is nothing,
/// or too much for numbers.
#[inline(always)]
fn part_of(ends: &[f32; CELLS], start: f32, chosen: f32) -> Option<ChosenPart> {
    let end_of_all = ends[CELLS - 1];
    // Rounding may reach it.
    let chosen = if chosen < end_of_all { chosen } else { end_of_all.next_down() };
    let index = count_up_to(ends, chosen);
    let end = *ends.get(index)?;
    let start = if index == 0 { start } else { ends[index - 1] };
    let sum = end - start;
    let place = ((chosen - start) / sum).clamp(0.0, 1.0_f32.next_down());
    (sum > 0.0 && end_of_all < f32::INFINITY).then_some(ChosenPart { index, start, sum, place })
}

/// How many of the sums are at most `chosen`. They never decrease, so that this is a search; counting all takes no branch and is done in lanes.
#[inline(always)]
fn count_up_to(sums: &[f32; CELLS], chosen: f32) -> usize {
    debug_assert!(sums.is_sorted() || sums[CELLS - 1].is_nan());
    sums.iter().map(|&sum| u32::from(sum <= chosen)).sum::<u32>() as usize
}

/// One of the four normals of the grid around a normal, by its share in a bilinear interpolation.
#[inline(always)]
fn node_around(normal: Vec3, random: f32) -> u32 {
    let low_bits = random * 256.0 - (random * 256.0) as i32 as f32;
    let position = LuminanceImage::uv_from_direction(normal) * NORMAL_STEPS as f32;
    let [x, y] =
        [position.x + random, position.y + low_bits].map(|x| (x as i32 as u32).min(NORMAL_STEPS as u32));
    y * (NORMAL_STEPS as u32 + 1) + x
}

/// The direction at `u` in a cell.
#[inline(always)]
fn direction_in(cell: u32, u: Vec2) -> Vec3 {
    let corner = Vec2::new((cell % CELLS as u32) as f32, (cell / CELLS as u32) as f32);
    LuminanceImage::direction_from_uv((corner + u) / CELLS as f32)
}

/// A direction on the side of a normal: a cell, or a normal of the grid, may reach a little beyond the horizon.
#[inline(always)]
fn mirrored_above(normal: Vec3, direction: Vec3) -> Vec3 {
    let height = direction.dot(normal);
    if height < 0.0 { direction - normal * (2.0 * height) } else { direction }
}

#[cfg(test)]
mod tests;
