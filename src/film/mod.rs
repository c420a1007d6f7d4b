//! The picture while it is made: pixels, windows, and the order in which samples become a pixel.

mod aovs;

pub use aovs::{AovFlags, CoverageSample, FilmAovs, LightPass, LightPasses, PixelCenterSample, add_share};

/// Pixels from `x0` up to but not including `x1`, and likewise for rows; origin at the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelWindow {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// One past the last column.
    pub x1: u32,
    /// One past the last row.
    pub y1: u32,
}

impl PixelWindow {
    /// The whole of a picture.
    pub fn full(width: u32, height: u32) -> Self {
        Self { x0: 0, y0: 0, x1: width, y1: height }
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.x1 - self.x0
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.y1 - self.y0
    }
}

/// Linear Rec.709 radiance with premultiplied coverage.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Size of the whole picture (the EXR display window).
    pub resolution: (u32, u32),
    /// The part that is held here (the EXR data window).
    pub window: PixelWindow,
    /// Row-major R, G, B, A of the window, top row first.
    pub pixels: Vec<[f32; 4]>,
    /// What else is recorded of each pixel.
    pub aovs: FilmAovs,
}

impl Film {
    /// A black, empty picture.
    pub fn new(resolution: (u32, u32), window: PixelWindow) -> Self {
        Self::with_aovs(resolution, window, AovFlags::NONE)
    }

    /// A black, empty picture with layers.
    pub fn with_aovs(resolution: (u32, u32), window: PixelWindow, request: AovFlags) -> Self {
        let count = window.width() as usize * window.height() as usize;
        Self { resolution, window, pixels: vec![[0.0; 4]; count], aovs: FilmAovs::new(count, request) }
    }

    /// Writes the pixels of a tile, which lies inside the window.
    pub fn write_tile(&mut self, tile: PixelWindow, pixels: &[[f32; 4]]) {
        place(self.window, &mut self.pixels, tile, pixels);
    }

    /// Writes those layers of a tile that are recorded here and there.
    pub fn write_aov_tile(&mut self, tile: PixelWindow, aovs: &FilmAovs) {
        let window = self.window;
        if let (Some(all), Some(light)) = (&mut self.aovs.light, &aovs.light) {
            place(window, all, tile, light);
        }
        if let (Some(all), Some(centers)) = (&mut self.aovs.centers, &aovs.centers) {
            place(window, all, tile, centers);
        }
        if let (Some(all), Some(coverage)) = (&mut self.aovs.coverage, &aovs.coverage) {
            place(window, all, tile, coverage);
        }
    }

    /// Adds the pixels of a film of the same window, their light by parts and their coverage.
    pub fn add(&mut self, other: &Self) {
        debug_assert_eq!(self.window, other.window);
        for (sum, pixel) in self.pixels.iter_mut().zip(&other.pixels) {
            for (sum, channel) in sum.iter_mut().zip(pixel) {
                *sum += channel;
            }
        }
        self.aovs.add(&other.aovs);
    }

    /// Multiplies all pixels, their light by parts and their coverage.
    pub fn scale(&mut self, factor: f32) {
        self.aovs.scale(factor);
        self.pixels.iter_mut().flatten().for_each(|channel| *channel *= factor);
    }

    /// Sets pixels that are infinite or not a number to transparent black, their light by parts too, and counts them.
    pub fn blacken_non_finite(&mut self) -> u64 {
        let mut count = 0;
        for (subscript, pixel) in self.pixels.iter_mut().enumerate() {
            if !pixel.iter().all(|channel| channel.is_finite()) {
                *pixel = [0.0; 4];
                if let Some(light) = &mut self.aovs.light {
                    light[subscript] = LightPasses::default();
                }
                count += 1;
            }
        }
        count
    }
}

/// Writes the row-major values of a tile among those of a window.
fn place<T: Clone>(window: PixelWindow, all: &mut [T], tile: PixelWindow, values: &[T]) {
    let stride = window.width() as usize;
    let rows = values.chunks_exact(tile.width() as usize);
    for (y, row) in (tile.y0..tile.y1).zip(rows) {
        let start = (y - window.y0) as usize * stride + (tile.x0 - window.x0) as usize;
        all[start..start + row.len()].clone_from_slice(row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_land_where_they_belong() {
        let window = PixelWindow { x0: 2, y0: 1, x1: 5, y1: 3 };
        let mut film = Film::new((8, 8), window);
        film.write_tile(PixelWindow { x0: 4, y0: 1, x1: 5, y1: 3 }, &[[1.0; 4], [2.0; 4]]);
        let reds: Vec<f32> = film.pixels.iter().map(|pixel| pixel[0]).collect();
        assert_eq!(reds, [0.0, 0.0, 1.0, 0.0, 0.0, 2.0]);
    }

    #[test]
    fn non_finite_pixels_become_black_and_are_counted() {
        let request = AovFlags { light: true, ..AovFlags::NONE };
        let mut film = Film::with_aovs((3, 1), PixelWindow::full(3, 1), request);
        film.aovs.light = Some(vec![[[f32::NAN; 3]; 6], [[0.5; 3]; 6], [[1.0; 3]; 6]]);
        film.pixels = vec![[f32::NAN, 1.0, 1.0, 1.0], [1.0; 4], [1.0, f32::INFINITY, 1.0, 1.0]];
        assert_eq!(film.blacken_non_finite(), 2);
        assert_eq!(film.pixels, [[0.0; 4], [1.0; 4], [0.0; 4]]);
        assert_eq!(film.aovs.light, Some(vec![[[0.0; 3]; 6], [[0.5; 3]; 6], [[0.0; 3]; 6]]));
    }
}
