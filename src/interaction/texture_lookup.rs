//! Texture lookups: transform, wrap, filter and decode (glTF 2.0, section 3.8; `KHR_texture_transform`).
//!
//! A lookup covers a parallelogram of the texture: the area between neighbouring samples. The ellipse of the parallelogram has a long
//! and a short axis. The short axis selects the mip level, so that nothing is blurred along it, and up to 16 probes along the long
//! axis cover the rest (McCormack et al., "Feline: Fast Elliptical Lines for Anisotropic Texture Mapping", SIGGRAPH 1999, in its
//! simple form with equal weights). Thinner ellipses are widened. Between two levels the blend is linear in the width, except for
//! a quarter at either end where one level is looked up alone.
//!
//! The sampler selects the filter of a single probe. A sampler without mip maps gets one probe.
//!
//! The textures of a material mostly share their layout on the surface, so a [`TextureProbes`] with the texels and the weights of all
//! probes is computed once and reused.

mod ellipse;
mod level_lookup;
mod texels;

use std::cell::RefCell;

use glam::{Vec2, Vec4};

use super::surface_point::SurfacePoint;
use crate::scene::{
    Encoding, Filter, Image, MAX_PROBES, MipFilter, MipLevel, Sampler, Scene, TextureRef, UvTransform,
    blended, level_of,
};
use crate::scene_view::SceneView;
use ellipse::Ellipse;
pub(super) use ellipse::UvDifferential;
use level_lookup::{LevelLookup, ProbeLine, WeightedTexels};
use texels::Probes;

/// Texture lookups at one point.
#[derive(Debug)]
pub(super) struct Lookups<'l, 'a> {
    view: SceneView<'a>,
    last: &'l RefCell<TextureProbes>,
}

impl<'l, 'a> Lookups<'l, 'a> {
    /// Lookups at another point than the last ones. `probes` holds nothing that counts but its memory.
    pub(super) fn new(view: SceneView<'a>, probes: &'l RefCell<TextureProbes>) -> Self {
        probes.borrow_mut().fine.count = 0;
        Self { view, last: probes }
    }

    pub(super) fn view(&self) -> SceneView<'a> {
        self.view
    }

    /// The value of a texture over the area of a sample at `point`, the same at every call; 1 without a texture.
    #[inline(always)]
    pub(super) fn value(
        &self,
        point: &SurfacePoint<'_>,
        reference: Option<&TextureRef>,
        encoding: Encoding,
    ) -> Vec4 {
        reference.map_or(Vec4::ONE, |reference| self.sample(point, reference, encoding))
    }

    fn sample(&self, point: &SurfacePoint<'_>, reference: &TextureRef, encoding: Encoding) -> Vec4 {
        let coordinate = || point.uv(self.view, reference);
        sample(self.view.scene, reference, encoding, &mut self.last.borrow_mut(), coordinate)
    }
}

/// The value of a texture at `coordinate()`, in the set of `reference`. Reuses `probes`, those of another texture at the same
/// point, if both share their layout.
fn sample(
    scene: &Scene,
    reference: &TextureRef,
    encoding: Encoding,
    probes: &mut TextureProbes,
    coordinate: impl FnOnce() -> (Vec2, UvDifferential),
) -> Vec4 {
    let texture = &scene.textures[reference.texture.index()];
    let image = &scene.images[texture.image.index()];
    let levels = scene.mips.get(texture.image.index()).map_or(&[][..], |mips| mips.levels(encoding));
    let layout = Layout {
        uv_set: reference.uv_set,
        transform: reference.transform,
        sampler: texture.sampler,
        size: [image.width, image.height],
        levels: levels.len(),
    };
    if probes.fine.count == 0 || probes.layout != layout {
        probes.layout = layout;
        let (uv, differential) = coordinate();
        probes.fill(levels, uv, differential);
    }
    probes.value(image, levels, encoding)
}

/// The value of a texture at a point without extent.
pub(super) fn sample_at(scene: &Scene, reference: &TextureRef, encoding: Encoding, uv: Vec2) -> Vec4 {
    sample_in_level(scene, reference, encoding, (uv, 0))
}

/// The value of a texture around a point, in this mip level, where 0 is the full image, or the smallest one that the texture has.
pub(super) fn sample_in_level(
    scene: &Scene,
    reference: &TextureRef,
    encoding: Encoding,
    (uv, level): (Vec2, usize),
) -> Vec4 {
    let texture = &scene.textures[reference.texture.index()];
    let image = &scene.images[texture.image.index()];
    let levels = scene.mips.get(texture.image.index()).map_or(&[][..], |mips| mips.levels(encoding));
    let (size, texels) = match level.min(levels.len()).checked_sub(1).map(|mip| &levels[mip]) {
        Some(mip) => ([mip.width, mip.height], &mip.texels),
        None => ([image.width, image.height], &image.texels),
    };
    let sampler = texture.sampler;
    let line = ProbeLine { center: reference.transform.of_point(uv), along: Vec2::ZERO, count: 1 };
    let lookup = LevelLookup::new(size, &line, sampler, sampler.magnify);
    let mut probes = [WeightedTexels::default()];
    lookup.fill(&mut probes);
    Probes { probes: &probes, is_linear: lookup.is_linear() }.mean(texels, encoding)
}

/// What decides the probes of a texture besides the point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Layout {
    uv_set: u32,
    transform: UvTransform,
    sampler: Sampler,
    /// Columns and rows of the full image.
    size: [u32; 2],
    /// Levels below the full image.
    levels: usize,
}

/// The probes of all textures that share a layout, at one point. Keeps its memory from point to point.
#[derive(Debug, Default)]
pub struct TextureProbes {
    layout: Layout,
    /// None before the first lookup.
    fine: LevelProbes,
    /// Probes of the next coarser level; none if its share is 0.
    coarse: LevelProbes,
    coarse_share: f32,
}

/// The probes of one level.
#[derive(Debug, Default)]
struct LevelProbes {
    /// Mip level; 0 is the full image.
    level: usize,
    count: usize,
    is_linear: bool,
    probes: [WeightedTexels; MAX_PROBES],
}

impl LevelProbes {
    /// Replaces the probes by those of a line.
    fn fill(&mut self, size: [u32; 2], level: usize, line: &ProbeLine, (sampler, filter): (Sampler, Filter)) {
        let lookup = LevelLookup::new(size, line, sampler, filter);
        (self.level, self.count, self.is_linear) = (level, line.count as usize, lookup.is_linear());
        lookup.fill(&mut self.probes[..self.count]);
    }

    fn mean(&self, image: &Image, levels: &[MipLevel], encoding: Encoding) -> Vec4 {
        let texels = self.level.checked_sub(1).map_or(&image.texels, |mip| &levels[mip].texels);
        Probes { probes: &self.probes[..self.count], is_linear: self.is_linear }.mean(texels, encoding)
    }
}

impl TextureProbes {
    fn fill(&mut self, levels: &[MipLevel], uv: Vec2, differential: UvDifferential) {
        let Layout { sampler, transform, size: full_size, .. } = self.layout;
        let uv = transform.of_point(uv);
        let size = Vec2::from(full_size.map(|side| side as f32));
        let steps = differential.0.map(|step| transform.of_vector(step) * size);
        let point = ProbeLine { center: uv, along: Vec2::ZERO, count: 1 };
        self.coarse.count = 0;
        // The squared axes have the same sum as the squared steps.
        if steps[0].length_squared() + steps[1].length_squared() <= 1.0 {
            return self.fine.fill(full_size, 0, &point, (sampler, sampler.magnify));
        }
        let ellipse = Ellipse::of_steps(steps);
        if ellipse.long <= 1.0 {
            return self.fine.fill(full_size, 0, &point, (sampler, sampler.magnify));
        }
        if sampler.mip == MipFilter::None || levels.is_empty() {
            return self.fine.fill(full_size, 0, &point, (sampler, sampler.minify));
        }

        // Levels
        let width = ellipse.width();
        let (level, share) = level_of(width, levels.len());
        let (level, share) = match sampler.mip {
            MipFilter::Nearest => (if share < 0.5 { level } else { level + 1 }, 0.0),
            MipFilter::None | MipFilter::Linear => blended(level, share),
        };

        // Probes along the long axis
        let along = ellipse.direction * ellipse.long / size;
        let fill = |probes: &mut LevelProbes, level: usize, spacing: f32| {
            let size = level.checked_sub(1).map_or(full_size, |mip| [levels[mip].width, levels[mip].height]);
            let line = ProbeLine { center: uv, along, count: ellipse.probes(spacing).min(MAX_PROBES as u32) };
            probes.fill(size, level, &line, (sampler, sampler.minify));
        };
        fill(&mut self.fine, level, width);
        if share > 0.0 {
            // The texels of the coarser level set the spacing there.
            fill(&mut self.coarse, level + 1, (2_u32 << level.min(30)) as f32);
            self.coarse_share = share;
        }
    }

    fn value(&self, image: &Image, levels: &[MipLevel], encoding: Encoding) -> Vec4 {
        let fine = self.fine.mean(image, levels, encoding);
        if self.coarse.count == 0 {
            return fine;
        }
        let coarse = self.coarse.mean(image, levels, encoding);
        fine + (coarse - fine) * self.coarse_share
    }
}

#[cfg(test)]
mod tests;
