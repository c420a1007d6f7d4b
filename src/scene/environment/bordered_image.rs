//! Small equirectangular images with a border of one texel, for lookups that neither wrap around nor look for poles.

use glam::{Vec2, Vec3, Vec4};

use super::equirect::{EquirectImage, floor};

/// Radiance or irradiance on an equirectangular grid, with a row beyond each pole and a column beyond each edge. 16 bytes a texel, one load.
#[derive(Debug, PartialEq)]
pub(super) struct BorderedImage {
    /// Columns and rows without the border.
    size: [f32; 2],
    /// Texels a row, with the border.
    stride: usize,
    /// RGB and an unused zero, row-major from the row above the upper pole.
    texels: Vec<Vec4>,
}

impl BorderedImage {
    pub(super) fn new(image: &EquirectImage) -> Self {
        let (width, height) = (image.width as i32, image.height as i32);
        let rows = (-1..=height).flat_map(|row| (-1..=width).map(move |column| (column, row)));
        let texel = |(column, row)| Vec3::from_array(*image.texel_beyond(column, row)).extend(0.0);
        Self {
            size: [image.width as f32, image.height as f32],
            stride: image.width + 2,
            texels: rows.map(texel).collect(),
        }
    }

    /// The same with these values at the upper and the lower pole, from which others are interpolated to the rows beside them.
    pub(super) fn with_poles(image: &EquirectImage, [upper, lower]: [Vec3; 2]) -> Self {
        let mut bordered = Self::new(image);
        let (stride, last) = (bordered.stride, (image.height + 1) * bordered.stride);
        // A pole is half way between the row beyond it and the one beside it.
        for column in 0..stride {
            let beside = [stride, last - stride].map(|row| bordered.texels[row + column]);
            bordered.texels[column] = upper.extend(0.0) * 2.0 - beside[0];
            bordered.texels[last + column] = lower.extend(0.0) * 2.0 - beside[1];
        }
        bordered
    }

    /// The value of [`EquirectImage::bilinear`] at a position in the unit square.
    #[inline(always)]
    pub(super) fn bilinear(&self, uv: Vec2) -> Vec3 {
        debug_assert!(
            !(uv.min_element() < 0.0 || uv.max_element() > 1.0),
            "{uv} is outside of the unit square"
        );
        let [x, y] = [uv.x * self.size[0] - 0.5, uv.y * self.size[1] - 0.5];
        let (column, row) = (floor(x), floor(y));
        let (right_share, bottom_share) = (x - column as f32, y - row as f32);
        let [left_share, top_share] = [1.0 - right_share, 1.0 - bottom_share];
        let first = (row + 1) as usize * self.stride + (column + 1) as usize;
        let ([a, b], [c, d]) = (self.pair(first), self.pair(first + self.stride));
        let (top, bottom) = (a * left_share + b * right_share, c * left_share + d * right_share);
        (top * top_share + bottom * bottom_share).truncate()
    }

    /// A texel and the one to its right.
    #[inline(always)]
    fn pair(&self, index: usize) -> [Vec4; 2] {
        let texels = &self.texels[index..][..2];
        [texels[0], texels[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_have_their_values_whatever_the_column() {
        let pixels = (0..32).map(|index| [index as f32 * 0.5, 1.0, 0.25]).collect();
        let image = EquirectImage { width: 8, height: 4, pixels };
        let poles = [Vec3::new(40.0, 2.0, 0.0), Vec3::new(0.5, 0.0, 3.0)];
        let map = BorderedImage::with_poles(&image, poles);
        for column in 0..=20 {
            let x = column as f32 / 20.0;
            for (pole, y, beside) in [(poles[0], 0.0, 0.125), (poles[1], 1.0, 0.875)] {
                assert!((map.bilinear(Vec2::new(x, y)) - pole).abs().max_element() < 1e-4);
                let row = image.bilinear(Vec2::new(x, beside));
                assert!((map.bilinear(Vec2::new(x, beside)) - row).abs().max_element() < 1e-4);
                let between = map.bilinear(Vec2::new(x, (y + beside) * 0.5));
                assert!((between - (pole + row) * 0.5).abs().max_element() < 1e-4);
            }
        }
    }

    #[test]
    fn lookups_have_the_bits_of_those_without_a_border() {
        for (width, height) in [(7, 4), (1, 1), (5, 1), (8, 4)] {
            let pixel =
                |index: usize| [index as f32 * 0.37, (index * index % 11) as f32, 0.1 + index as f32 * 1e-3];
            let image = EquirectImage { width, height, pixels: (0..width * height).map(pixel).collect() };
            let bordered = BorderedImage::new(&image);
            for index in 0..=900 {
                let uv = Vec2::new((index % 31) as f32 / 30.0, (index / 31) as f32 / 29.0);
                assert_eq!(bordered.bilinear(uv), image.bilinear(uv), "{width}x{height}: {uv}");
            }
        }
    }
}
