//! References from materials to textures, with the transform of the texture coordinates.

use glam::Vec2;

use super::TextureIndex;

/// Texture with its texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// The texture.
    pub texture: TextureIndex,
    /// Index of [`super::Primitive::uvs`].
    pub uv_set: u32,
    /// Applied to the coordinates before wrapping.
    pub transform: UvTransform,
}

/// Transform of texture coordinates, translation · rotation · scale (`KHR_texture_transform`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Added last.
    pub offset: Vec2,
    /// Counter-clockwise in the image.
    pub rotation: UvRotation,
    /// Applied first.
    pub scale: Vec2,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation: UvRotation::default(), scale: Vec2::ONE }
    }
}

impl UvTransform {
    /// Transforms coordinates. v points down, hence the signs.
    pub fn of_point(&self, uv: Vec2) -> Vec2 {
        if *self == Self::default() { uv } else { self.offset + self.of_vector(uv) }
    }

    /// Transforms the difference of two coordinates.
    pub fn of_vector(&self, step: Vec2) -> Vec2 {
        let UvRotation { sin, cos, .. } = self.rotation;
        let scaled = step * self.scale;
        Vec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x)
    }
}

/// Rotation angle with its sine and cosine, precomputed for lookups.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvRotation {
    radians: f32,
    sin: f32,
    cos: f32,
}

impl UvRotation {
    /// A rotation by an angle.
    pub fn from_radians(radians: f32) -> Self {
        let (sin, cos) = libm::sincosf(radians);
        Self { radians, sin, cos }
    }

    /// The angle, radians.
    pub fn radians(self) -> f32 {
        self.radians
    }
}

impl Default for UvRotation {
    fn default() -> Self {
        Self { radians: 0.0, sin: 0.0, cos: 1.0 }
    }
}

/// A tangent-space normal map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalTexture {
    /// Linear; RGB hold the normal as `2c − 1`.
    pub texture: TextureRef,
    /// Factor on the normal's x and y.
    pub scale: f32,
}

/// Ambient occlusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OcclusionTexture {
    /// Linear, in R.
    pub texture: TextureRef,
    /// 0 ignores the texture, 1 applies it fully.
    pub strength: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_by_90_degrees_maps_u_to_minus_v() {
        // Rotation by 90° counter-clockwise: (u, v) → (v, −u), as the extension's sample viewers do.
        let rotation = UvRotation::from_radians(std::f32::consts::FRAC_PI_2);
        let quarter = UvTransform { rotation, ..Default::default() };
        let rotated = quarter.of_point(Vec2::new(0.25, 0.75));
        assert!(rotated.abs_diff_eq(Vec2::new(0.75, -0.25), 1e-6), "{rotated}");
        // Scale precedes the rotation, the offset follows it. Differences have no offset.
        let all = UvTransform { offset: Vec2::new(1.0, 2.0), scale: Vec2::new(2.0, 4.0), ..quarter };
        assert!(all.of_point(Vec2::new(0.25, 0.75)).abs_diff_eq(Vec2::new(4.0, 1.5), 1e-5));
        assert!(all.of_vector(Vec2::new(0.25, 0.75)).abs_diff_eq(Vec2::new(3.0, -0.5), 1e-5));
    }
}
