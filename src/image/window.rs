//! Rectangles of pixels.

/// Rectangle of pixels: columns `x0` up to but not including `x1`, rows `y0` up to but not including `y1`. Rows count downwards.
///
/// Coordinates are `u32` in images of this program, whose display window begins at (0, 0). The windows of EXR files may begin
/// anywhere and are `PixelWindow<i64>`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelWindow<T = u32> {
    /// First column.
    pub x0: T,
    /// First row.
    pub y0: T,
    /// One past the last column.
    pub x1: T,
    /// One past the last row.
    pub y1: T,
}

impl PixelWindow {
    /// The window of `width` columns and `height` rows that begins at (0, 0).
    pub fn full(width: u32, height: u32) -> Self {
        Self { x0: 0, y0: 0, x1: width, y1: height }
    }

    /// Number of columns.
    pub fn width(&self) -> u32 {
        self.x1 - self.x0
    }

    /// Number of rows.
    pub fn height(&self) -> u32 {
        self.y1 - self.y0
    }

    /// Columns and rows.
    pub fn size(&self) -> (u32, u32) {
        (self.width(), self.height())
    }

    /// Number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.width() as usize * self.height() as usize
    }
}

impl PixelWindow<i64> {
    /// Columns and rows.
    pub fn size(&self) -> (u64, u64) {
        ((self.x1 - self.x0) as u64, (self.y1 - self.y0) as u64)
    }

    /// Whether all pixels of `other` lie in this window.
    pub fn contains(&self, other: &Self) -> bool {
        self.x0 <= other.x0 && other.x1 <= self.x1 && self.y0 <= other.y0 && other.y1 <= self.y1
    }

    /// The pixels that both windows have. Corners are crossed where there are none.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }

    /// This window in coordinates that begin at the first pixel of `display`.
    #[must_use]
    pub fn relative_to(&self, display: &Self) -> Self {
        let (x, y) = (display.x0, display.y0);
        Self { x0: self.x0 - x, y0: self.y0 - y, x1: self.x1 - x, y1: self.y1 - y }
    }

    /// The same window with unsigned coordinates; `None` where one is negative or too large.
    pub fn to_unsigned(&self) -> Option<PixelWindow> {
        Some(PixelWindow {
            x0: u32::try_from(self.x0).ok()?,
            y0: u32::try_from(self.y0).ok()?,
            x1: u32::try_from(self.x1).ok()?,
            y1: u32::try_from(self.y1).ok()?,
        })
    }
}

impl From<PixelWindow> for PixelWindow<i64> {
    fn from(window: PixelWindow) -> Self {
        Self { x0: window.x0.into(), y0: window.y0.into(), x1: window.x1.into(), y1: window.y1.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_relative_to_their_display_window_begin_at_zero() {
        let display = PixelWindow { x0: -2_i64, y0: 3, x1: 6, y1: 9 };
        let data = PixelWindow { x0: 0_i64, y0: 4, x1: 6, y1: 9 };
        assert!(display.contains(&data) && !data.contains(&display));
        assert_eq!(display.intersection(&data), data);
        let relative = data.relative_to(&display).to_unsigned().unwrap();
        assert_eq!(relative, PixelWindow { x0: 2, y0: 1, x1: 8, y1: 6 });
        assert_eq!((relative.size(), relative.pixel_count()), ((6, 5), 30));
        assert_eq!(display.to_unsigned(), None);
    }
}
