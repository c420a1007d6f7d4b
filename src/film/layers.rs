//! What a picture holds besides colour and coverage, where it is asked for.

use glam::{Vec2, Vec3};

/// Which layers are recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayerRequest {
    /// How the light of each pixel came: [`FilmLayers::light`].
    pub light: bool,
    /// What the ray through the middle of each pixel meets: [`FilmLayers::centres`].
    pub centres: bool,
    /// Which surfaces cover each pixel, and by how much: [`FilmLayers::coverage`].
    pub coverage: bool,
}

impl LayerRequest {
    /// Nothing besides colour and coverage.
    pub const NONE: Self = Self { light: false, centres: false, coverage: false };
}

/// How light came to the eye. What the camera sees last decides: each bit of a pixel's light is in exactly one part, so that
/// they sum to its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LightPart {
    /// Given off by the first surface, unlit ones included.
    Emission,
    /// From lamps, scattered by the first surface.
    Direct,
    /// From the environment, scattered by the first surface or seen by itself behind the scene.
    Environment,
    /// By mirror rays of the first surface, whatever they met.
    Reflection,
    /// By rays through the first surface where it is glass, whatever they met.
    Refraction,
    /// By whatever is seen behind a see-through first surface (alpha, not glass).
    PassThrough,
}

impl LightPart {
    /// All parts, in the order of their subscripts.
    pub const ALL: [Self; 6] = [
        Self::Emission,
        Self::Direct,
        Self::Environment,
        Self::Reflection,
        Self::Refraction,
        Self::PassThrough,
    ];

    /// As layers are called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Emission => "emission",
            Self::Direct => "direct",
            Self::Environment => "environment",
            Self::Reflection => "reflection",
            Self::Refraction => "refraction",
            Self::PassThrough => "pass_through",
        }
    }
}

/// Linear Rec.709 radiance of one pixel by [`LightPart`], premultiplied like the pixel itself.
pub type LightParts = [[f32; 3]; LightPart::ALL.len()];

/// What the ray through the middle of a pixel meets first, at the frame's own time and without a lens: the first surface whose
/// coverage is at least one half. Shadow catchers are not met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentreSample {
    /// Subscript of [`crate::frame::Frame::shapes`]; `None` where nothing is met, and then the fields up to `uv` are zero.
    pub shape: Option<u32>,
    /// Distance along the camera's axis, metres.
    pub depth: f32,
    /// World space, metres.
    pub position: Vec3,
    /// World-space unit normal of the triangle on the camera's side.
    pub geometric_normal: Vec3,
    /// World-space unit normal for shading on the camera's side, normal map applied.
    pub shading_normal: Vec3,
    /// Linear base colour; for specular-glossiness and metal, too.
    pub albedo: Vec3,
    /// First set of texture coordinates as the file has them; v grows downwards.
    pub uv: Vec2,
    /// Where the same point of the surface is in the next frame's picture less where it is in this one, pixels; x to the right,
    /// y downwards. Where nothing is met, that of a point infinitely far away. Zero where either lies behind the camera.
    pub motion_forward: Vec2,
    /// The same for the previous frame.
    pub motion_back: Vec2,
}

impl Default for CentreSample {
    /// Nothing is met.
    fn default() -> Self {
        Self {
            shape: None,
            depth: 0.0,
            position: Vec3::ZERO,
            geometric_normal: Vec3::ZERO,
            shading_normal: Vec3::ZERO,
            albedo: Vec3::ZERO,
            uv: Vec2::ZERO,
            motion_forward: Vec2::ZERO,
            motion_back: Vec2::ZERO,
        }
    }
}

/// The surfaces that cover a pixel, filtered like its colour: subscripts of [`crate::frame::Frame::shapes`], increasing, each once, with their
/// shares of the pixel. What is seen in mirrors and through glass is not among them; see-through surfaces and what is behind
/// them have their shares each.
pub type PixelCoverage = Vec<(u32, f32)>;

/// Row-major pixels of the film's window, for each layer that is recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmLayers {
    /// How light came.
    pub light: Option<Vec<LightParts>>,
    /// What the middle of each pixel shows.
    pub centres: Option<Vec<CentreSample>>,
    /// What covers each pixel.
    pub coverage: Option<Vec<PixelCoverage>>,
}

impl FilmLayers {
    /// Empty layers of `count` pixels.
    pub fn new(count: usize, request: LayerRequest) -> Self {
        Self {
            light: request.light.then(|| vec![LightParts::default(); count]),
            centres: request.centres.then(|| vec![CentreSample::default(); count]),
            coverage: request.coverage.then(|| vec![PixelCoverage::new(); count]),
        }
    }

    /// What is recorded.
    pub fn request(&self) -> LayerRequest {
        LayerRequest {
            light: self.light.is_some(),
            centres: self.centres.is_some(),
            coverage: self.coverage.is_some(),
        }
    }
}
