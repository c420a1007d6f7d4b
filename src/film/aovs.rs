//! What a picture holds besides colour and coverage, where it is asked for.

use glam::{Vec2, Vec3};

pub use crate::integrator::{LightPass, LightPasses};

/// Which layers are recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AovFlags {
    /// How the light of each pixel came: [`FilmAovs::light`].
    pub light: bool,
    /// What the ray through the middle of each pixel meets: [`FilmAovs::centers`].
    pub centers: bool,
    /// Which surfaces cover each pixel, and by how much: [`FilmAovs::coverage`].
    pub coverage: bool,
}

impl AovFlags {
    /// Nothing besides colour and coverage.
    pub const NONE: Self = Self { light: false, centers: false, coverage: false };
}

/// What the ray through the middle of a pixel meets first, at the frame's own time and without a lens: the first surface whose
/// coverage is at least one half. Shadow catchers are not met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelCenterSample {
    /// Subscript of [`crate::frame::Frame::instances`]; `None` where nothing is met, and then the fields up to `uv` are zero.
    pub instance: Option<u32>,
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
    /// y downwards. Where nothing is met, that of a point infinitely far away, and under parallel rays none. Zero where
    /// either lies behind the camera, or the surface is hidden then.
    pub motion_forward: Vec2,
    /// The same for the previous frame.
    pub motion_back: Vec2,
}

impl Default for PixelCenterSample {
    /// Nothing is met.
    fn default() -> Self {
        Self {
            instance: None,
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

/// The surfaces that cover a pixel, filtered like its colour: subscripts of [`crate::frame::Frame::instances`], increasing, each once, with their
/// shares of the pixel. What is seen in mirrors and through glass is not among them; see-through surfaces and what is behind
/// them have their shares each.
pub type CoverageSample = Vec<(u32, f32)>;

/// Adds to the share of one surface.
pub fn add_share(coverage: &mut CoverageSample, instance: u32, share: f32) {
    match coverage.binary_search_by_key(&instance, |&(instance, _)| instance) {
        Ok(place) => coverage[place].1 += share,
        Err(place) => coverage.insert(place, (instance, share)),
    }
}

/// Row-major pixels of the film's window, for each layer that is recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmAovs {
    /// How light came.
    pub light: Option<Vec<LightPasses>>,
    /// What the middle of each pixel shows.
    pub centers: Option<Vec<PixelCenterSample>>,
    /// What covers each pixel.
    pub coverage: Option<Vec<CoverageSample>>,
}

impl FilmAovs {
    /// Empty layers of `count` pixels.
    pub fn new(count: usize, request: AovFlags) -> Self {
        Self {
            light: request.light.then(|| vec![LightPasses::default(); count]),
            centers: request.centers.then(|| vec![PixelCenterSample::default(); count]),
            coverage: request.coverage.then(|| vec![CoverageSample::new(); count]),
        }
    }

    /// Adds another recording of the same pixels. What the middles of pixels show is not a sum and stays.
    pub fn add(&mut self, other: &Self) {
        if let (Some(light), Some(other)) = (&mut self.light, &other.light) {
            let channels = other.as_flattened().as_flattened();
            let sums = light.as_flattened_mut().as_flattened_mut();
            sums.iter_mut().zip(channels).for_each(|(sum, channel)| *sum += channel);
        }
        if let (Some(coverage), Some(other)) = (&mut self.coverage, &other.coverage) {
            for (shares, other) in coverage.iter_mut().zip(other) {
                for &(instance, share) in other {
                    add_share(shares, instance, share);
                }
            }
        }
    }

    /// Multiplies light and coverage.
    pub fn scale(&mut self, factor: f32) {
        for light in self.light.iter_mut().flatten() {
            light.as_flattened_mut().iter_mut().for_each(|channel| *channel *= factor);
        }
        for shares in self.coverage.iter_mut().flatten() {
            for (_, share) in shares {
                *share *= factor;
            }
        }
    }

    /// What is recorded.
    pub fn request(&self) -> AovFlags {
        AovFlags {
            light: self.light.is_some(),
            centers: self.centers.is_some(),
            coverage: self.coverage.is_some(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_summed_by_surface() {
        let all = AovFlags { light: true, centers: true, coverage: true };
        let (mut sum, mut other) = (FilmAovs::new(1, all), FilmAovs::new(1, all));
        sum.coverage = Some(vec![vec![(2, 0.5), (7, 0.25)]]);
        other.coverage = Some(vec![vec![(1, 1.0), (7, 0.5), (9, 0.125)]]);
        sum.light = Some(vec![[[1.0, 2.0, 3.0]; 6]]);
        other.light = Some(vec![[[0.5, 0.0, 1.0]; 6]]);
        sum.add(&other);
        sum.scale(0.5);
        assert_eq!(sum.coverage, Some(vec![vec![(1, 0.5), (2, 0.25), (7, 0.375), (9, 0.0625)]]));
        assert_eq!(sum.light, Some(vec![[[0.75, 1.0, 2.0]; 6]]));
    }

    #[test]
    fn what_is_asked_for_is_recorded() {
        let light = AovFlags { light: true, ..AovFlags::NONE };
        assert_eq!(FilmAovs::new(3, light).request(), light);
        assert_eq!(FilmAovs::new(3, AovFlags::NONE), FilmAovs::default());
    }
}
