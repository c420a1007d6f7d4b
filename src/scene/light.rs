//! Punctual lights (`KHR_lights_punctual`).

use glam::Vec3;

/// A light without extent; it shines from its node's origin along the node's −Z.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Linear colour.
    pub color: Vec3,
    /// Lux for directional lights, candela for the others.
    pub intensity: f32,
    /// Metres at which point and spot lights have faded to nothing; `None` never fades.
    pub range: Option<f32>,
    /// Its shape.
    pub kind: LightKind,
}

/// The shape of a punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light from infinitely far.
    Directional,
    /// The same in all directions.
    Point,
    /// A cone.
    Spot {
        /// Angle from the axis where the light begins to fade.
        inner_cone_radians: f32,
        /// Angle from the axis where it has faded to nothing.
        outer_cone_radians: f32,
    },
}
