//! Punctual lights (`KHR_lights_punctual`).

use glam::Vec3;

/// Punctual light at its node's origin. It shines along the node's −Z.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Linear colour.
    pub color: Vec3,
    /// Lux for directional lights, candela for the others.
    pub intensity: f32,
    /// Distance at which point and spot lights have faded to zero, metres; `None` is unlimited.
    pub range: Option<f32>,
    /// Distribution of the light.
    pub kind: LightKind,
}

/// Kind of a punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light from an infinite distance.
    Directional,
    /// Uniform in all directions.
    Point,
    /// Cone of light.
    Spot {
        /// Angle from the axis at which the light begins to fade. The edge is hard where it is not below the outer one.
        inner_cone_radians: f32,
        /// Angle from the axis at which it has faded to zero.
        outer_cone_radians: f32,
    },
}

impl LightKind {
    /// The name in glTF.
    pub fn name(self) -> &'static str {
        match self {
            Self::Directional => "directional",
            Self::Point => "point",
            Self::Spot { .. } => "spot",
        }
    }
}
