//! Pooling of the errors of all pixels into single numbers.
//!
//! Means and weighted percentiles follow section 5 of the paper on [FLIP](super::FlipMap). The worst tile is our addition: a small object
//! that vanishes hardly changes the mean of an image, but it changes the mean of its tile. So is the [worst object](pool_objects): a
//! slight change of a whole object changes the mean of its pixels, whatever its share of the image.

use std::collections::HashMap;

use rayon::prelude::*;
use serde::Serialize;

use super::FlipMap;

/// Pixels on the side of a tile.
const TILE: usize = 8;
/// Pixels from one tile to the next. Every square of six pixels lies within a tile.
const STEP: usize = 2;
/// Objects of fewer pixels than a tile count as having that many, so that a few pixels of an edge are no changed object.
const LEAST_OBJECT_PIXELS: usize = TILE * TILE;

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
    /// The object with the largest mean. `None` without ids, and where no pixel has an object.
    pub object: Option<ObjectError>,
}

/// The error of one object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ObjectError {
    /// The mean error of the object's pixels, of which it has at least 64.
    pub mean: f64,
    /// The object's id.
    pub id: u32,
    /// Number of its pixels.
    pub pixels: usize,
    /// Column and row of its largest error.
    pub at: (u32, u32),
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
        object: None,
    }
}

/// The object with the largest mean error, in one pass. `ids` has the id of every pixel; 0 is none. Of equal means the object that
/// comes first in row-major order counts.
pub fn pool_objects(map: &FlipMap, ids: &[u32]) -> Option<ObjectError> {
    /// Sums over the pixels of one object.
    struct Sums {
        id: u32,
        sum: f64,
        pixels: usize,
        largest: (f32, usize),
    }
    let mut objects: Vec<Sums> = Vec::new();
    let mut indices = HashMap::new();
    // Adjacent pixels mostly show the same object.
    let mut last = (0, 0);
    for (at, (&id, &error)) in ids.iter().zip(&map.errors).enumerate().filter(|(_, (id, _))| **id != 0) {
        if id != last.0 {
            last = (id, *indices.entry(id).or_insert(objects.len()));
            if last.1 == objects.len() {
                objects.push(Sums { id, sum: 0.0, pixels: 0, largest: (-1.0, at) });
            }
        }
        let object = &mut objects[last.1];
        object.sum += f64::from(error);
        object.pixels += 1;
        if error > object.largest.0 {
            object.largest = (error, at);
        }
    }
    let errors = objects.into_iter().map(|Sums { id, sum, pixels, largest: (_, at) }| {
        let at = (at as u32 % map.size.0, at as u32 / map.size.0);
        ObjectError { mean: sum / pixels.max(LEAST_OBJECT_PIXELS) as f64, id, pixels, at }
    });
    errors.reduce(|worst, object| if object.mean > worst.mean { object } else { worst })
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
    fn a_small_object_that_changes_fully_is_found_in_a_large_image() {
        // 12x12 pixels of error 0.8 in 1920x1080: the mean of the image is 0.00006.
        let is_inside = |x: u32, y: u32| (1001..1013).contains(&x) && (501..513).contains(&y);
        let full = map((1920, 1080), |x, y| if is_inside(x, y) { 0.8 } else { 0.0 });
        let ids: Vec<u32> = (0..1920 * 1080)
            .map(|at| match (at % 1920, at / 1920) {
                (x, y) if is_inside(x, y) => 7,
                (_, 0..540) => 3,
                _ => 0,
            })
            .collect();
        let worst = pool_objects(&full, &ids).unwrap();
        assert!((worst.mean - 0.8).abs() < 1e-6 && pool(&full).mean < 1e-4, "{worst:?}");
        assert_eq!((worst.id, worst.pixels, worst.at), (7, 144, (1001, 501)));
        // Three pixels of its edge: 3 · 0.8 / 144.
        let edge = map((1920, 1080), |x, y| if x == 1001 && (501..504).contains(&y) { 0.8 } else { 0.0 });
        assert!((pool_objects(&edge, &ids).unwrap().mean - 2.4 / 144.0).abs() < 1e-6);
    }

    #[test]
    fn objects_of_a_few_pixels_count_as_a_tile() {
        let row = map((100, 1), |x, _| if x < 4 { 0.64 } else { 0.0 });
        let ids: Vec<u32> = (0..100).map(|x| if x < 4 { 9 } else { 4 }).collect();
        let worst = pool_objects(&row, &ids).unwrap();
        assert!((worst.mean - 0.04).abs() < 1e-6 && worst.id == 9 && worst.pixels == 4, "{worst:?}");
        assert_eq!(pool_objects(&row, &[0; 100]), None);
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
