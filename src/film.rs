//! The picture while it is made: pixels, windows, and the order in which samples become a pixel.

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
}

impl Film {
    /// A black, empty picture.
    pub fn new(resolution: (u32, u32), window: PixelWindow) -> Self {
        let count = window.width() as usize * window.height() as usize;
        Self { resolution, window, pixels: vec![[0.0; 4]; count] }
    }
}
