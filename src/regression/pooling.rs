//! Pooling of the errors of all pixels into single numbers.
//!
//! Means and weighted percentiles follow section 5 of the paper on [FLIP](super::FlipMap). The worst tile is our addition: a small object
//! that vanishes hardly changes the mean of an image, but it changes the mean of its tile.

use rayon::prelude::*;
use serde::Serialize;

use super::FlipMap;

/// Pixels on the side of a tile.
const TILE: usize = 8;
/// Pixels from one tile to the next. Every square of six pixels lies within a tile.
const STEP: usize = 2;

/// Pooled errors of a FLIP map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PooledErrors {
    /// The mean error.
    pub mean: f64,
    /// Quartiles weighted by error: the errors at which the sum over the sorted errors reaches a quarter, a half and three quarters.
    pub weighted_quartiles: [f64; 3],
    /// The largest error.
    pub largest: f64,
    /// Column and row of the largest error.
    pub largest_at: (u32, u32),
    /// The largest mean of a tile of 8x8 pixels.
    pub tile: f64,
    /// Column and row of the first pixel of that tile.
    pub tile_at: (u32, u32),
}

/// Pools the errors of a map.
pub fn pool(map: &FlipMap) -> PooledErrors {
    let (width, errors) = (map.size.0, &map.errors);
    if errors.is_empty() {
        return PooledErrors::default();
    }
    let (mut largest, mut largest_at) = (0.0, 0);
    let mut sum = 0.0;
    for (at, &error) in errors.iter().enumerate() {
        sum += f64::from(error);
        if error > largest {
            (largest, largest_at) = (error, at as u32);
        }
    }
    let (tile, tile_at) = worst_tile(map);
    PooledErrors {
        mean: sum / errors.len() as f64,
        weighted_quartiles: weighted_percentiles(errors, sum, [0.25, 0.5, 0.75]),
        largest: f64::from(largest),
        largest_at: (largest_at % width, largest_at / width),
        tile,
        tile_at,
    }
}

fn weighted_percentiles(errors: &[f32], sum: f64, shares: [f64; 3]) -> [f64; 3] {
    let mut sorted = errors.to_vec();
    sorted.par_sort_unstable_by(f32::total_cmp);
    shares.map(|share| {
        let mut reached = 0.0;
        let at = sorted.iter().position(|&error| {
            reached += f64::from(error);
            reached >= share * sum
        });
        at.map_or(0.0, |at| f64::from(sorted[at]))
    })
}

/// The largest mean of a tile and its first pixel. Of equal means the first counts, in row-major order.
fn worst_tile(map: &FlipMap) -> (f64, (u32, u32)) {
    let (width, height) = (map.size.0 as usize, map.size.1 as usize);
    let (tile_width, tile_height) = (TILE.min(width), TILE.min(height));
    let mean = |x: usize, y: usize| {
        let rows = (y..y + tile_height).map(|row| &map.errors[row * width + x..][..tile_width]);
        let sum: f64 = rows.flatten().map(|&error| f64::from(error)).sum();
        sum / (tile_width * tile_height) as f64
    };
    let rows: Vec<_> = starts(height, tile_height)
        .into_par_iter()
        .map(|y| {
            let tiles = starts(width, tile_width).into_iter().map(|x| (mean(x, y), (x as u32, y as u32)));
            tiles.fold((-1.0, (0, 0)), later_if_larger)
        })
        .collect();
    rows.into_iter().fold((-1.0, (0, 0)), later_if_larger)
}

fn later_if_larger(a: (f64, (u32, u32)), b: (f64, (u32, u32))) -> (f64, (u32, u32)) {
    if b.0 > a.0 { b } else { a }
}

/// First columns or rows of tiles. The last tile ends at the edge of the image.
fn starts(length: usize, tile: usize) -> Vec<usize> {
    let mut starts: Vec<usize> = (0..=length - tile).step_by(STEP).collect();
    if starts.last() != Some(&(length - tile)) {
        starts.push(length - tile);
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(size: (u32, u32), error: impl Fn(u32, u32) -> f32) -> FlipMap {
        let errors = (0..size.0 * size.1).map(|at| error(at % size.0, at / size.0)).collect();
        FlipMap { size, errors, exposures: None }
    }

    #[test]
    fn a_small_error_changes_its_tile_and_not_the_mean() {
        // 6x6 pixels of error 0.5 in 320x180: the mean is 18 / 57600, that of a tile 18 / 64.
        let pooled = pool(&map((320, 180), |x, y| {
            if (101..107).contains(&x) && (173..179).contains(&y) { 0.5 } else { 0.0 }
        }));
        assert_eq!((pooled.mean, pooled.tile), (18.0 / 57600.0, 18.0 / 64.0));
        // Tiles start at even columns and rows, the last at 172; the first that holds it all starts at (100, 172).
        assert_eq!((pooled.tile_at, pooled.largest_at), ((100, 172), (101, 173)));
    }

    #[test]
    fn percentiles_are_weighted_by_the_errors() {
        // Errors 0 (90 times), 0.25 (4 times), 0.5 (2) and 1 (2); their sums are 1, 1 and 2 of 4.
        let pooled = pool(&map((98, 1), |x, _| match x {
            0..90 => 0.0,
            90..94 => 0.25,
            94..96 => 0.5,
            _ => 1.0,
        }));
        assert_eq!(pooled.weighted_quartiles, [0.25, 0.5, 1.0]);
        assert_eq!(pooled.largest_at, (96, 0));
    }

    #[test]
    fn pictures_smaller_than_a_tile_are_one() {
        let pooled = pool(&map((3, 2), |x, _| x as f32 * 0.5));
        assert_eq!((pooled.mean, pooled.tile, pooled.tile_at), (0.5, 0.5, (0, 0)));
        assert_eq!(pool(&map((0, 0), |_, _| 0.0)), PooledErrors::default());
        assert_eq!(pool(&map((9, 9), |_, _| 0.0)).weighted_quartiles, [0.0; 3]);
    }
}
