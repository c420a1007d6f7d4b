//! Cameras.

use glam::Vec2;

/// A camera; it looks down its node's −Z with +Y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Its projection.
    pub projection: Projection,
}

/// How points are projected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// Vertical field of view.
        fov_y_radians: f32,
        /// Width over height that the author had in mind.
        aspect_ratio: Option<f32>,
        /// Metres; nothing nearer is seen.
        z_near: f32,
        /// Metres; nothing farther is seen. `None` is infinite.
        z_far: Option<f32>,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the width, metres.
        x_mag: f32,
        /// Half the height, metres.
        y_mag: f32,
        /// Metres.
        z_near: f32,
        /// Metres.
        z_far: f32,
    },
}

impl Projection {
    /// Half the width and height of what a picture of `aspect_ratio` (width over height) shows: at distance one for a
    /// pinhole, else in metres.
    ///
    /// The authored vertical field is kept in wider pictures; in narrower ones it grows until the authored horizontal
    /// field fits, so that nothing the author framed is lost.
    pub fn half_size(&self, aspect_ratio: f32) -> Vec2 {
        let (half_height, authored_aspect) = match *self {
            Self::Perspective {
                fov_y_radians,
                aspect_ratio,
                ..
            } => (libm::tanf(fov_y_radians * 0.5), aspect_ratio),
            Self::Orthographic { x_mag, y_mag, .. } => (y_mag, Some(x_mag / y_mag)),
        };
        let half_height = match authored_aspect {
            Some(authored) if aspect_ratio < authored => half_height * authored / aspect_ratio,
            _ => half_height,
        };
        Vec2::new(half_height * aspect_ratio, half_height)
    }
}
