//! Texture lookups: transform, wrap, filter, decode (glTF 2.0, section 3.8; `KHR_texture_transform`).
//!
//! A lookup stands for a parallelogram of the picture: the area between neighbouring samples. Its ellipse has a long and a
//! short axis. The short one chooses the level of detail, so that nothing is blurred along it, and up to 16 lookups along
//! the long one cover the rest (McCormack et al., "Feline: Fast Elliptical Lines for Anisotropic Texture Mapping", SIGGRAPH
//! 1999, in its simple form with equal weights). Thinner ellipses are widened. Between two levels the share is linear in the
//! width, but for a quarter at either end where one level is looked up alone.
//!
//! The sampler decides what a single lookup is. One that asks for no mip maps gets the one lookup it asks for.
//!
//! Textures of a material mostly lie alike on the surface: where they are looked up ([`Placement`]) is found once.

mod ellipse;
mod texels;
mod walk;

use std::cell::RefCell;

use glam::{Vec2, Vec4};

use super::SurfacePoint;
use crate::scene::{Encoding, Image, MipFilter, MipLevel, Sampler, Scene, Texels, TextureRef, UvTransform};
use crate::scene_view::SceneView;
pub(super) use ellipse::UvDifferential;
use ellipse::{Ellipse, blended, level_of};
use walk::{Line, Walk};

/// The lookups at one point.
#[derive(Debug)]
pub(super) struct Lookups<'a> {
    view: SceneView<'a>,
    last: RefCell<Option<Placement>>,
}

impl<'a> Lookups<'a> {
    pub(super) fn new(view: SceneView<'a>) -> Self {
        Self { view, last: RefCell::new(None) }
    }

    pub(super) fn view(&self) -> SceneView<'a> {
        self.view
    }

    /// The value of a texture over the footprint of `point`, the same at every call; ones without a texture.
    pub(super) fn value(
        &self,
        point: &SurfacePoint<'_>,
        reference: Option<&TextureRef>,
        encoding: Encoding,
    ) -> Vec4 {
        let Some(reference) = reference else {
            return Vec4::ONE;
        };
        let place = || point.uv(self.view, reference);
        sample(self.view.scene, reference, encoding, &mut self.last.borrow_mut(), place)
    }
}

/// The value of a texture around `place()`, a coordinate of the set that `reference` names. It is looked up as at `last`, a
/// placement at the same point, when that suits.
pub(super) fn sample(
    scene: &Scene,
    reference: &TextureRef,
    encoding: Encoding,
    last: &mut Option<Placement>,
    place: impl FnOnce() -> (Vec2, UvDifferential),
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
    let placement = match last {
        Some(last) if last.layout == layout => last,
        _ => {
            let (uv, differential) = place();
            last.insert(Placement::new(layout, levels, uv, differential))
        }
    };
    placement.value(image, levels, encoding)
}

/// What decides, beside the point, where a texture is looked up.
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

/// Where textures that share a layout are looked up at one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    layout: Layout,
    /// 0 is the full image.
    level: usize,
    walk: Walk,
    /// The next level and its share, unless that is zero.
    coarser: Option<(Walk, f32)>,
}

impl Placement {
    fn new(layout: Layout, levels: &[MipLevel], uv: Vec2, differential: UvDifferential) -> Self {
        let Layout { sampler, transform, .. } = layout;
        let uv = transform.of_point(uv);
        let size = Vec2::from(layout.size.map(|side| side as f32));
        let steps = differential.0.map(|step| transform.of_vector(step) * size);
        let single = |filter| {
            let walk =
                Walk::new(layout.size, &Line { middle: uv, along: Vec2::ZERO, count: 1 }, sampler, filter);
            Self { layout, level: 0, walk, coarser: None }
        };
        // The squares of both axes have the same sum.
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

        // In which levels
        let width = ellipse.width();
        let (level, share) = level_of(width, levels.len());
        let (level, share) = match sampler.mip {
            MipFilter::Nearest => (if share < 0.5 { level } else { level + 1 }, 0.0),
            MipFilter::None | MipFilter::Linear => blended(level, share),
        };

        // Along the long axis
        let along = ellipse.direction * ellipse.long / size;
        let walk = |index: usize, spacing: f32| {
            let size =
                index.checked_sub(1).map_or(layout.size, |mip| [levels[mip].width, levels[mip].height]);
            let line = Line { middle: uv, along, count: ellipse.probes(spacing) };
            Walk::new(size, &line, sampler, sampler.minify)
        };
        // Texels of the coarse level are at least as wide.
        let coarser = (share > 0.0).then(|| (walk(level + 1, (2_u32 << level.min(30)) as f32), share));
        Self { layout, level, walk: walk(level, width), coarser }
    }

    fn value(&self, image: &Image, levels: &[MipLevel], encoding: Encoding) -> Vec4 {
        let texels = |index: usize| -> &Texels {
            index.checked_sub(1).map_or(&image.texels, |mip| &levels[mip].texels)
        };
        let fine = texels::mean(texels(self.level), &self.walk, encoding);
        match &self.coarser {
            Some((walk, share)) => {
                let coarse = texels::mean(texels(self.level + 1), walk, encoding);
                fine + (coarse - fine) * *share
            }
            None => fine,
        }
    }
}

#[cfg(test)]
mod tests;
