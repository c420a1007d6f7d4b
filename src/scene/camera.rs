//! Cameras.

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
