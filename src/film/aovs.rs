//! Values that a film records besides colour and coverage.

use glam::{Vec2, Vec3};

pub use crate::integrator::{GuideSample, LightPass, LightPasses};

/// Which AOVs a film records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a list of its own")]
pub struct AovFlags {
    /// Light passes: [`FilmAovs::light`].
    pub light: bool,
    /// Surface at each pixel's centre: [`FilmAovs::centers`].
    pub centers: bool,
    /// Mesh instances that cover each pixel: [`FilmAovs::coverage`].
    pub coverage: bool,
    /// Noise of each pixel: [`FilmAovs::noise`]. Only the path integrator records it.
    pub noise: bool,
    /// Guides of denoising: [`FilmAovs::guides`]. Only the path integrator records them.
    pub guides: bool,
}

impl AovFlags {
    /// Colour and coverage alone.
    pub const NONE: Self =
        Self { light: false, centers: false, coverage: false, noise: false, guides: false };
}

/// Surface at a pixel's centre, at the frame's own time and without a lens.
///
/// It is the first surface with a coverage of at least one half. Shadow catchers do not count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelCenterSample {
    /// Index into [`crate::frame::Frame::instances`]; `None` where the ray hits nothing, and then the fields up to `albedo` are zero.
    pub instance: Option<u32>,
    /// Distance along the camera's axis, metres.
    pub depth: f32,
    /// World space, metres.
    pub position: Vec3,
    /// World-space unit normal of the triangle, on the camera's side.
    pub geometric_normal: Vec3,
    /// World-space unit shading normal on the camera's side, normal map applied.
    pub shading_normal: Vec3,
    /// Linear base colour, also of metal and of specular-glossiness materials.
    pub albedo: Vec3,
    /// First set of texture coordinates as stored in the file; v grows downwards. `None` where there is none.
    pub uv: Option<Vec2>,
    /// Motion to the next frame, pixels: where the same surface point is in the next frame's image less where it is in this
    /// one; x to the right, y downwards.
    ///
    /// Where the ray hits nothing, it is the motion of a point infinitely far away, which parallel projections do not have.
    /// It is zero where either point lies behind the camera, or the surface is hidden in the other frame.
    pub motion_forward: Vec2,
    /// The same to the previous frame.
    pub motion_back: Vec2,
}

impl Default for PixelCenterSample {
    /// A ray that hits nothing.
    fn default() -> Self {
        Self {
            instance: None,
            depth: 0.0,
            position: Vec3::ZERO,
            geometric_normal: Vec3::ZERO,
            shading_normal: Vec3::ZERO,
            albedo: Vec3::ZERO,
            uv: None,
            motion_forward: Vec2::ZERO,
            motion_back: Vec2::ZERO,
        }
    }
}

/// Noise of a pixel's colour, estimated from its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NoiseSample {
    /// Variance of the mean, by colour channel; 0 for fewer than two samples. Samples that are spread evenly vary less than this.
    pub variance: [f32; 3],
    /// Number of samples.
    pub samples: u32,
}

/// Coverage of a pixel by mesh instances, filtered like its colour: increasing indices into
/// [`crate::frame::Frame::instances`], each once, with their shares of the pixel.
///
/// Only what camera rays hit directly counts, not what mirrors and glass show. A partly transparent surface and those
/// behind it have their shares each.
pub type CoverageSample = Vec<(u32, f32)>;

/// Adds to the share of one instance.
pub fn add_share(coverage: &mut CoverageSample, instance: u32, share: f32) {
    match coverage.binary_search_by_key(&instance, |&(instance, _)| instance) {
        Ok(index) => coverage[index].1 += share,
        Err(index) => coverage.insert(index, (instance, share)),
    }
}

/// AOVs of a film's window, row-major; `None` where one is not recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmAovs {
    /// Light passes.
    pub light: Option<Vec<LightPasses>>,
    /// Surfaces at the pixels' centres.
    pub centers: Option<Vec<PixelCenterSample>>,
    /// Coverage by mesh instances.
    pub coverage: Option<Vec<CoverageSample>>,
    /// Noise of the colours.
    pub noise: Option<Vec<NoiseSample>>,
    /// Guides of denoising.
    pub guides: Option<Vec<GuideSample>>,
}

impl FilmAovs {
    /// Zeroed AOVs of `count` pixels.
    pub fn new(count: usize, flags: AovFlags) -> Self {
        Self {
            light: flags.light.then(|| vec![LightPasses::default(); count]),
            centers: flags.centers.then(|| vec![PixelCenterSample::default(); count]),
            coverage: flags.coverage.then(|| vec![CoverageSample::new(); count]),
            noise: flags.noise.then(|| vec![NoiseSample::default(); count]),
            guides: flags.guides.then(|| vec![GuideSample::default(); count]),
        }
    }

    /// Adds light passes and coverage of the same pixels. Pixel-centre samples stay, and so does what only paths record.
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

    /// Resolves light passes and coverage of one pixel by `mean`. Negative lobes of a filter leave no coverage below zero or above one.
    /// Light may be negative, so that the passes keep their sum.
    pub fn map_pixel(&mut self, index: usize, mean: impl Fn(f32) -> f32) {
        if let Some(light) = &mut self.light {
            light[index].as_flattened_mut().iter_mut().for_each(|channel| *channel = mean(*channel));
        }
        if let Some(coverage) = &mut self.coverage {
            let shares = &mut coverage[index];
            for (_, share) in shares.iter_mut() {
                *share = mean(*share);
            }
            clamp_shares(shares);
        }
    }

    /// Multiplies light passes and coverage.
    pub fn scale(&mut self, factor: f32) {
        for light in self.light.iter_mut().flatten() {
            scale_light(light, factor);
        }
        for shares in self.coverage.iter_mut().flatten() {
            scale_shares(shares, factor);
        }
    }

    /// Multiplies light passes and coverage of one pixel.
    pub fn scale_pixel(&mut self, index: usize, factor: f32) {
        if let Some(light) = &mut self.light {
            scale_light(&mut light[index], factor);
        }
        if let Some(coverage) = &mut self.coverage {
            scale_shares(&mut coverage[index], factor);
        }
    }

    /// Which AOVs are recorded.
    pub fn flags(&self) -> AovFlags {
        AovFlags {
            light: self.light.is_some(),
            centers: self.centers.is_some(),
            coverage: self.coverage.is_some(),
            noise: self.noise.is_some(),
            guides: self.guides.is_some(),
        }
    }
}

/// Drops negative shares, which negative lobes of a filter leave. The others keep the sum of all, which is at most one.
pub(super) fn clamp_shares(shares: &mut CoverageSample) {
    /// Largest excess that is left as it is.
    const ROUNDING_ERROR: f32 = 1e-5;
    let sum = |shares: &CoverageSample| shares.iter().map(|(_, share)| share).sum::<f32>();
    let all = sum(shares).clamp(0.0, 1.0);
    shares.retain_mut(|(_, share)| {
        *share = share.clamp(0.0, 1.0);
        *share > 0.0
    });
    let kept = sum(shares);
    if kept - all > ROUNDING_ERROR {
        scale_shares(shares, all / kept);
        shares.retain(|(_, share)| *share > 0.0);
    }
}

fn scale_light(light: &mut LightPasses, factor: f32) {
    light.as_flattened_mut().iter_mut().for_each(|channel| *channel *= factor);
}

fn scale_shares(shares: &mut CoverageSample, factor: f32) {
    for (_, share) in shares {
        *share *= factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_summed_by_instance() {
        let all = AovFlags { light: true, centers: true, coverage: true, ..AovFlags::NONE };
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
    fn shares_keep_their_sum_where_lobes_are_negative() {
        let clamped = |shares: &[f32]| {
            let mut aovs = FilmAovs::new(1, AovFlags { coverage: true, ..AovFlags::NONE });
            aovs.coverage = Some(vec![(0..).zip(shares.iter().copied()).collect()]);
            aovs.map_pixel(0, |share| share);
            aovs.coverage.unwrap_or_default().concat()
        };
        // The background, or another instance, has what is missing.
        assert_eq!(clamped(&[0.75, 0.5]), [(0, 0.6), (1, 0.4)]);
        assert_eq!(clamped(&[1.25, -0.25]), [(0, 1.0)]);
        assert_eq!(clamped(&[0.75, 0.25, -0.5]), [(0, 0.375), (1, 0.125)]);
        assert_eq!(clamped(&[0.25, -0.5]), []);
        assert_eq!(clamped(&[0.25, 0.5]), [(0, 0.25), (1, 0.5)]);
        assert_eq!(clamped(&[f32::NAN, 0.5]), [(1, 0.5)]);
    }

    #[test]
    fn flags_decide_what_is_recorded() {
        let light = AovFlags { light: true, ..AovFlags::NONE };
        assert_eq!(FilmAovs::new(3, light).flags(), light);
        assert_eq!(FilmAovs::new(3, AovFlags::NONE), FilmAovs::default());
    }
}
