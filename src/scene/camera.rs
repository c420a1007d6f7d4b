//! Cameras and projections.

use glam::Vec2;

/// Camera that looks along its node's −Z with +Y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// The projection.
    pub projection: Projection,
}

/// Camera projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole camera.
    Perspective {
        /// Vertical field of view.
        fov_y_radians: f32,
        /// Authored aspect ratio, width over height.
        aspect_ratio: Option<f32>,
        /// Near plane, metres.
        z_near: f32,
        /// Far plane, metres; `None` is infinite.
        z_far: Option<f32>,
    },
    /// Parallel projection.
    Orthographic {
        /// Half the width, metres.
        x_mag: f32,
        /// Half the height, metres.
        y_mag: f32,
        /// Near plane, metres.
        z_near: f32,
        /// Far plane, metres.
        z_far: f32,
    },
}

impl Projection {
    /// The name in glTF.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Perspective { .. } => "perspective",
            Self::Orthographic { .. } => "orthographic",
        }
    }

    /// The same projection with the near and far plane of another one.
    #[must_use]
    pub(crate) fn with_planes_of(self, other: &Self) -> Self {
        let (near, far) = match *other {
            Self::Perspective { z_near, z_far, .. } => (z_near, z_far),
            Self::Orthographic { z_near, z_far, .. } => (z_near, Some(z_far)),
        };
        match self {
            Self::Perspective { fov_y_radians, aspect_ratio, .. } => {
                Self::Perspective { fov_y_radians, aspect_ratio, z_near: near, z_far: far }
            }
            Self::Orthographic { x_mag, y_mag, .. } => {
                Self::Orthographic { x_mag, y_mag, z_near: near, z_far: far.unwrap_or(f32::MAX) }
            }
        }
    }

    /// Half the visible width and height for an image of `aspect_ratio` (width over height): at distance one for a perspective
    /// camera, in metres for an orthographic one.
    ///
    /// Images wider than authored keep the vertical field of view. In narrower ones it grows until the authored horizontal field
    /// of view fits, so that the whole authored view remains visible.
    pub fn half_size(&self, aspect_ratio: f32) -> Vec2 {
        let (half_height, authored_aspect) = match *self {
            Self::Perspective { fov_y_radians, aspect_ratio, .. } => {
                (libm::tanf(fov_y_radians * 0.5), aspect_ratio)
            }
            Self::Orthographic { x_mag, y_mag, .. } => (y_mag, Some(x_mag / y_mag)),
        };
        let half_height = match authored_aspect {
            Some(authored) if aspect_ratio < authored => half_height * authored / aspect_ratio,
            _ => half_height,
        };
        Vec2::new(half_height * aspect_ratio, half_height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wider_images_keep_the_height_and_narrower_ones_the_width() {
        // tan(45°) = 1: the authored half height is one.
        let perspective = |aspect_ratio| {
            let fov_y_radians = std::f32::consts::FRAC_PI_2;
            Projection::Perspective { fov_y_radians, aspect_ratio, z_near: 0.1, z_far: None }
        };
        assert!(perspective(Some(1.5)).half_size(2.0).abs_diff_eq(Vec2::new(2.0, 1.0), 1e-6));
        assert!(perspective(Some(1.5)).half_size(0.5).abs_diff_eq(Vec2::new(1.5, 3.0), 1e-6));
        assert!(perspective(None).half_size(0.5).abs_diff_eq(Vec2::new(0.5, 1.0), 1e-6));
        let orthographic = Projection::Orthographic { x_mag: 3.0, y_mag: 1.0, z_near: 0.0, z_far: 9.0 };
        assert!(orthographic.half_size(1.0).abs_diff_eq(Vec2::new(3.0, 3.0), 1e-6));
    }
}
