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
//! The textures of a material mostly share their layout on the surface, so a [`ProbeLayout`] is computed once and reused.

mod ellipse;
mod level_lookup;
mod texels;

use std::cell::RefCell;

use glam::{Vec2, Vec4};

use super::surface_point::SurfacePoint;
use crate::scene::{Encoding, Image, MipFilter, MipLevel, Sampler, Scene, Texels, TextureRef, UvTransform};
use crate::scene_view::SceneView;
pub(super) use ellipse::UvDifferential;
use ellipse::{Ellipse, blended, level_of};
use level_lookup::{LevelLookup, ProbeLine};

/// Texture lookups at one point.
#[derive(Debug)]
pub(super) struct Lookups<'a> {
    view: SceneView<'a>,
    last: RefCell<Option<ProbeLayout>>,
}

impl<'a> Lookups<'a> {
    pub(super) fn new(view: SceneView<'a>) -> Self {
        Self { view, last: RefCell::new(None) }
    }

    pub(super) fn view(&self) -> SceneView<'a> {
        self.view
    }

    /// The value of a texture over the area of a sample at `point`, the same at every call; 1 without a texture.
    pub(super) fn value(
        &self,
        point: &SurfacePoint<'_>,
        reference: Option<&TextureRef>,
        encoding: Encoding,
    ) -> Vec4 {
        let Some(reference) = reference else {
            return Vec4::ONE;
        };
        let coordinate = || point.uv(self.view, reference);
        sample(self.view.scene, reference, encoding, &mut self.last.borrow_mut(), coordinate)
    }
}

/// The value of a texture at `coordinate()`, in the set of `reference`. Reuses `last`, the probes of another texture at the same
/// point, if both share their layout.
pub(super) fn sample(
    scene: &Scene,
    reference: &TextureRef,
    encoding: Encoding,
    last: &mut Option<ProbeLayout>,
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
    let probes = match last {
        Some(last) if last.layout == layout => last,
        _ => {
            let (uv, differential) = coordinate();
            last.insert(ProbeLayout::new(layout, levels, uv, differential))
        }
    };
    probes.value(image, levels, encoding)
}

/// What decides the probes of a texture besides the point.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layout {
    uv_set: u32,
    transform: UvTransform,
    sampler: Sampler,
    /// Columns and rows of the full image.
    size: [u32; 2],
    /// Levels below the full image.
    levels: usize,
}

/// The probes of all textures that share a layout, at one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProbeLayout {
    layout: Layout,
    /// Mip level; 0 is the full image.
    level: usize,
    lookup: LevelLookup,
    /// The next coarser level and its share, unless that is 0.
    coarser: Option<(LevelLookup, f32)>,
}

impl ProbeLayout {
    fn new(layout: Layout, levels: &[MipLevel], uv: Vec2, differential: UvDifferential) -> Self {
        let Layout { sampler, transform, .. } = layout;
        let uv = transform.of_point(uv);
        let size = Vec2::from(layout.size.map(|side| side as f32));
        let steps = differential.0.map(|step| transform.of_vector(step) * size);
        let single = |filter| {
            let lookup = LevelLookup::new(
                layout.size,
                &ProbeLine { center: uv, along: Vec2::ZERO, count: 1 },
                sampler,
                filter,
            );
            Self { layout, level: 0, lookup, coarser: None }
        };
        // The squared axes have the same sum as the squared steps.
        if steps[0].length_squared() + steps[1].length_squared() <= 1.0 {
            return single(sampler.magnify);
        }
        let ellipse = Ellipse::of_steps(steps);
        if ellipse.long <= 1.0 {
            return single(sampler.magnify);
        }
        if sampler.mip == MipFilter::None || levels.is_empty() {
            return single(sampler.minify);
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
        let lookup = |index: usize, spacing: f32| {
            let size =
                index.checked_sub(1).map_or(layout.size, |mip| [levels[mip].width, levels[mip].height]);
            let line = ProbeLine { center: uv, along, count: ellipse.probes(spacing) };
            LevelLookup::new(size, &line, sampler, sampler.minify)
        };
        // The texels of the coarser level set the spacing there.
        let coarser = (share > 0.0).then(|| (lookup(level + 1, (2_u32 << level.min(30)) as f32), share));
        Self { layout, level, lookup: lookup(level, width), coarser }
    }

    fn value(&self, image: &Image, levels: &[MipLevel], encoding: Encoding) -> Vec4 {
        let texels = |index: usize| -> &Texels {
            index.checked_sub(1).map_or(&image.texels, |mip| &levels[mip].texels)
        };
        let fine = texels::mean(texels(self.level), &self.lookup, encoding);
        match &self.coarser {
            Some((lookup, share)) => {
                let coarse = texels::mean(texels(self.level + 1), lookup, encoding);
                fine + (coarse - fine) * *share
            }
            None => fine,
        }
    }
}

#[cfg(test)]
mod tests;
