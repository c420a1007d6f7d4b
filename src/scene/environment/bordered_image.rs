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
