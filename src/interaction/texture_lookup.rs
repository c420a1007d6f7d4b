//! Texture lookups: transform, wrap, filter, decode (glTF 2.0, section 3.8; `KHR_texture_transform`).
//!
//! A lookup stands for a parallelogram of the picture: the area between neighbouring samples. Its ellipse has a long and a
//! short axis. The short one chooses the level of detail, so that nothing is blurred along it, and up to [`MOST_PROBES`]
//! lookups along the long one cover the rest (McCormack et al., "Feline: Fast Elliptical Lines for Anisotropic Texture
//! Mapping", SIGGRAPH 1999, in its simple form with equal weights). Thinner ellipses are widened. Between two levels the
//! share is linear in the width, but for a quarter at either end where one level is looked up alone.
//!
//! The sampler decides what a single lookup is. One that asks for no mip maps gets the one lookup it asks for.

mod texels;

use glam::{Vec2, Vec4};

use crate::scene::{Encoding, Filter, MipFilter, Sampler, Scene, TextureRef};
use texels::{Level, Line};

/// Most lookups along the long axis of a footprint.
const MOST_PROBES: f32 = 16.0;

/// Between lookups along the long axis, in widths of what one covers.
const SPACING: f32 = 1.4;

/// How texture coordinates change by one step along the rows and one along the columns of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvFootprint(pub(super) [Vec2; 2]);

impl UvFootprint {
    /// A lookup that stands for a point.
    pub(super) const POINT: Self = Self([Vec2::ZERO; 2]);
}

/// The value of a texture around `uv`, which is a coordinate of the set that `reference` names.
pub(super) fn sample(
    scene: &Scene,
    reference: &TextureRef,
    uv: Vec2,
    footprint: UvFootprint,
    encoding: Encoding,
) -> Vec4 {
    let texture = &scene.textures[reference.texture.index()];
    let image = &scene.images[texture.image.index()];
    let full = Level::of_image(image);
    let lookup = Lookup { sampler: texture.sampler, encoding };
    let uv = reference.transform.of_point(uv);
    let steps = footprint.0.map(|step| reference.transform.of_vector(step) * full.size());
    // The squares of both axes have the same sum.
    let squared = steps[0].length_squared() + steps[1].length_squared();
    if squared <= 1.0 {
        return lookup.in_level(full, uv, lookup.sampler.magnify);
    }
    let ellipse = Ellipse::of_steps(steps);
    if ellipse.long <= 1.0 {
        return lookup.in_level(full, uv, lookup.sampler.magnify);
    }
    let mips = scene.mips.get(texture.image.index()).map_or(&[][..], |mips| mips.levels(encoding));
    if lookup.sampler.mip == MipFilter::None || mips.is_empty() {
        return lookup.in_level(full, uv, lookup.sampler.minify);
    }

    // In which levels
    let width = ellipse.width();
    let (level, share) = level_of(width, mips.len());
    let (level, share) = match lookup.sampler.mip {
        MipFilter::Nearest => (if share < 0.5 { level } else { level + 1 }, 0.0),
        MipFilter::None | MipFilter::Linear => blended(level, share),
    };

    // Along the long axis
    let along = ellipse.direction * ellipse.long / full.size();
    let mean = |index: usize, spacing: f32| {
        let level = if index == 0 { full } else { Level::of_mip(&mips[index - 1]) };
        let line = Line { middle: uv, along, count: ellipse.probes(spacing) };
        level.mean_along(&line, lookup.sampler, lookup.sampler.minify, encoding)
    };
    let fine = mean(level, width);
    if share == 0.0 {
        return fine;
    }
    // Texels of the coarse level are at least as wide.
    mix(fine, mean(level + 1, (2_u32 << level.min(30)) as f32), share)
}

/// The blend of two levels: in the outer quarters of the way from one to the next it is one of them alone.
fn blended(level: usize, share: f32) -> (usize, f32) {
    let share = (share - 0.25) * 2.0;
    if share <= 0.0 {
        (level, 0.0)
    } else if share >= 1.0 {
        (level + 1, 0.0)
    } else {
        (level, share)
    }
}

/// The area that a lookup stands for, in texels of the full image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ellipse {
    /// Length of the long axis; infinite where the footprint is no number.
    long: f32,
    /// Length of the short axis.
    short: f32,
    /// Unit vector along the long axis.
    direction: Vec2,
}

impl Ellipse {
    /// The singular values of the matrix of both steps, and its first left singular vector.
    fn of_steps([a, b]: [Vec2; 2]) -> Self {
        let (xx, yy, xy) = (a.x * a.x + b.x * b.x, a.y * a.y + b.y * b.y, a.x * a.y + b.x * b.y);
        let half_difference = (xx - yy) * 0.5;
        let root = (half_difference * half_difference + xy * xy).sqrt();
        let long = ((xx + yy) * 0.5 + root).sqrt();
        if !long.is_finite() {
            return Self { long: f32::INFINITY, short: f32::INFINITY, direction: Vec2::X };
        }
        // Of two forms of the eigenvector, the one that does not cancel.
        let direction = if half_difference >= 0.0 {
            Vec2::new(half_difference + root, xy)
        } else {
            Vec2::new(xy, root - half_difference)
        };
        Self { long, short: a.perp_dot(b).abs() / long, direction: direction.normalize_or(Vec2::X) }
    }

    /// The width of what one lookup covers: the short axis, but at least a texel, and wide enough for the lookups to reach
    /// from end to end.
    fn width(&self) -> f32 {
        let needed = self.long / (MOST_PROBES * SPACING);
        let width = if self.short > needed { self.short } else { needed };
        if width > 1.0 { width } else { 1.0 }
    }

    /// Lookups that reach over the long axis. Each is a tent twice as wide as its texels, so that they may lie apart by more
    /// than their width without a gap.
    fn probes(&self, width: f32) -> u32 {
        if !self.long.is_finite() {
            return 1;
        }
        let needed = self.long / (width * SPACING) - 0.1;
        let whole = needed as u32;
        if whole as f32 == needed && whole > 0 { whole } else { whole + 1 }
    }
}

/// The level whose texels are at most `width` wide, and the share of the next one; 0 is the full image and `last` the
/// coarsest. `width` is at least one.
fn level_of(width: f32, last: usize) -> (usize, f32) {
    let bits = width.to_bits();
    let level = (bits >> 23).saturating_sub(127) as usize;
    if level >= last {
        return (last, 0.0);
    }
    // The mantissa runs from one to two between two levels.
    (level, f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000) - 1.0)
}

/// How single lookups are made.
#[derive(Clone, Copy, Debug)]
struct Lookup {
    sampler: Sampler,
    encoding: Encoding,
}

impl Lookup {
    fn in_level(self, level: Level<'_>, uv: Vec2, filter: Filter) -> Vec4 {
        match filter {
            Filter::Nearest => level.nearest(self.sampler, uv, self.encoding),
            Filter::Linear => level.bilinear(self.sampler, uv, self.encoding),
        }
    }
}

fn mix(a: Vec4, b: Vec4, share: f32) -> Vec4 {
    a + (b - a) * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{
        Image, ImageIndex, ImageMips, Texels, Texture, TextureIndex, UvTransform, WrapMode, mip_levels,
    };
    use texels::wrap;

    /// Four texels in a row with red 0, 1, 2, 3 (times 1/255).
    fn ramp(sampler: Sampler) -> Scene {
        let texels = Texels::Rgba8((0..4).map(|red| [red, 0, 0, 255]).collect());
        Scene {
            images: vec![Image { name: None, width: 4, height: 1, texels }],
            textures: vec![Texture { name: None, image: ImageIndex(0), sampler }],
            ..Default::default()
        }
    }

    /// Looked up over a square of the picture.
    fn red(sampler: Sampler, u: f32, side: f32) -> f32 {
        let footprint = UvFootprint([Vec2::X * side, Vec2::Y * side]);
        let reference = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
        let value = sample(&ramp(sampler), &reference, Vec2::new(u, 0.5), footprint, Encoding::Linear);
        // Decoding and interpolating round the last bits away.
        (value.x * 255_000.0).round() / 1000.0
    }

    fn nearest_with(wrap_u: WrapMode) -> Sampler {
        Sampler { wrap_u, magnify: Filter::Nearest, ..Default::default() }
    }

    #[test]
    fn wrap_modes_continue_the_image() {
        let at = |mode, texel: f32| red(nearest_with(mode), (texel + 0.5) / 4.0, 0.0);
        for (texel, repeat, mirrored, clamped) in [
            (-5.0, 3.0, 3.0, 0.0),
            (-1.0, 3.0, 0.0, 0.0),
            (2.0, 2.0, 2.0, 2.0),
            (4.0, 0.0, 3.0, 3.0),
            (9.0, 1.0, 1.0, 3.0),
        ] {
            assert_eq!(at(WrapMode::Repeat, texel), repeat, "repeat {texel}");
            assert_eq!(at(WrapMode::MirroredRepeat, texel), mirrored, "mirrored {texel}");
            assert_eq!(at(WrapMode::ClampToEdge, texel), clamped, "clamped {texel}");
        }
    }

    #[test]
    fn linear_filtering_meets_texel_centres_and_wraps_between_the_ends() {
        let linear = Sampler::default();
        let at = |u| red(linear, u, 0.0);
        assert_eq!(at(1.5 / 4.0), 1.0);
        assert_eq!(at(2.0 / 4.0), 1.5);
        // Half way between texel 3 and texel 0 of the next repetition.
        assert_eq!(at(0.0), 1.5);
    }

    #[test]
    fn a_wide_footprint_uses_the_minifying_filter() {
        let sampler = Sampler { magnify: Filter::Nearest, minify: Filter::Linear, ..Default::default() };
        assert_eq!(red(sampler, 0.5, 0.01), 2.0);
        assert_eq!(red(sampler, 0.5, 1.0), 1.5);
    }

    #[test]
    fn far_and_infinite_coordinates_stay_inside() {
        for mode in [WrapMode::Repeat, WrapMode::MirroredRepeat, WrapMode::ClampToEdge] {
            for position in [i64::MIN, i64::MIN + 1, -4, 4, 1 << 52, i64::MAX - 1, i64::MAX] {
                assert!(
                    wrap(mode, position, 4) < 4 && wrap(mode, position, 5) < 5 && wrap(mode, position, 1) < 1
                );
            }
            let sampler = Sampler { wrap_u: mode, ..Default::default() };
            for u in [1e30, -1e30, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
                assert!((0.0..=3.0).contains(&red(sampler, u, 0.0)), "{mode:?} {u}");
            }
        }
    }

    /// A picture with mip maps for one use.
    fn mapped(
        size: (u32, u32),
        sampler: Sampler,
        encoding: Encoding,
        texel: impl Fn(u32, u32) -> [u8; 4],
    ) -> Scene {
        let (width, height) = size;
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y));
        let image = Image { name: None, width, height, texels: Texels::Rgba8(texels.collect()) };
        let mut mips = ImageMips::default();
        mips.set(encoding, mip_levels(&image, encoding).into());
        Scene {
            images: vec![image],
            mips: vec![mips],
            textures: vec![Texture { name: None, image: ImageIndex(0), sampler }],
            ..Default::default()
        }
    }

    fn look(scene: &Scene, uv: Vec2, steps: [Vec2; 2], encoding: Encoding) -> Vec4 {
        let reference = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
        sample(scene, &reference, uv, UvFootprint(steps), encoding)
    }

    #[test]
    fn ellipses_have_known_axes() {
        // Steps that are perpendicular are the axes themselves.
        let plain = Ellipse::of_steps([Vec2::new(0.0, 3.0), Vec2::new(2.0, 0.0)]);
        assert!((plain.long - 3.0).abs() < 1e-6 && (plain.short - 2.0).abs() < 1e-6);
        assert!(plain.direction.x.abs() < 1e-6);
        // (3, 3) and (1, −1): long 3√2 along the diagonal, short √2.
        let turned = Ellipse::of_steps([Vec2::new(3.0, 3.0), Vec2::new(1.0, -1.0)]);
        assert!((turned.long - 18_f32.sqrt()).abs() < 1e-5 && (turned.short - 2_f32.sqrt()).abs() < 1e-5);
        assert!((turned.direction.x - turned.direction.y).abs() < 1e-6);
        // A shear: the singular values of ((1, 4), (0, 1)) are √5 ± 2.
        let sheared = Ellipse::of_steps([Vec2::new(1.0, 0.0), Vec2::new(4.0, 1.0)]);
        assert!((sheared.long - (5_f32.sqrt() + 2.0)).abs() < 1e-5);
        assert!((sheared.short - (5_f32.sqrt() - 2.0)).abs() < 1e-5);
        // A line and a point have no second axis.
        let line = Ellipse::of_steps([Vec2::new(3.0, 4.0), Vec2::new(-3.0, -4.0)]);
        assert!((line.long - 50_f32.sqrt()).abs() < 1e-5 && line.short == 0.0);
        assert_eq!((line.width(), line.probes(line.width())), (1.0, 5));
        for broken in [f32::NAN, f32::INFINITY, 1e30] {
            let ellipse = Ellipse::of_steps([Vec2::splat(broken), Vec2::X]);
            assert_eq!((ellipse.width(), ellipse.probes(ellipse.width())), (f32::INFINITY, 1));
        }
    }

    #[test]
    fn levels_follow_the_width() {
        for (width, expected) in [
            (1.0, (0, 0.0)),
            (1.5, (0, 0.5)),
            (2.0, (1, 0.0)),
            (3.0, (1, 0.5)),
            (5.0, (2, 0.25)),
            (1e9, (3, 0.0)),
        ] {
            assert_eq!(level_of(width, 3), expected, "{width}");
        }
        assert_eq!(level_of(f32::INFINITY, 3), (3, 0.0));
        assert_eq!(level_of(2.5, 0), (0, 0.0));
    }

    #[test]
    fn a_chequer_becomes_its_mean_towards_the_horizon() {
        // Black and white squares of one texel, half of the light. The farther, the longer the footprint; from where it covers
        // two texels nothing but the mean is left, without a jump on the way.
        let scene = mapped((64, 64), Sampler::default(), Encoding::Srgb, |x, y| {
            if (x + y) % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] }
        });
        for stretch in [1.0, 3.0, 10.0, 40.0] {
            let mut last = 1.0;
            for step in 0..400 {
                let width = libm::exp2f(step as f32 * 0.03 - 2.0) / 64.0;
                let steps = [Vec2::new(width, 0.0), Vec2::new(0.0, width * stretch)];
                // The middle of a white texel.
                let seen = look(&scene, Vec2::new(33.5, 20.5) / 64.0, steps, Encoding::Srgb).x;
                if width * 64.0 >= 2.0 {
                    assert!((seen - 0.5).abs() < 0.01, "{stretch} {width}: {seen}");
                }
                assert!((seen - last).abs() < 0.2 || stretch > 1.0, "{stretch} {width}: {last} {seen}");
                last = seen;
            }
        }
    }

    #[test]
    fn lookups_agree_with_the_mean_of_many() {
        // The slow twin: 64 times 64 lookups of the full image over the parallelogram. A level's texels are as wide as the short
        // axis and interpolation widens them once more, so what is compared is smooth on that scale.
        let wave = |x: u32, y: u32| {
            let at = |frequency: f32, place: u32| {
                libm::sinf(place as f32 / 256.0 * frequency * std::f32::consts::TAU)
            };
            let byte = |value: f32| (127.5 + 127.5 * value) as u8;
            [byte(at(3.0, x)), byte(at(2.0, y)), byte(at(5.0, x) * at(1.0, y)), 255]
        };
        let scene = mapped((256, 256), Sampler::default(), Encoding::Linear, wave);
        let plain = mapped(
            (256, 256),
            Sampler { mip: MipFilter::None, ..Default::default() },
            Encoding::Linear,
            wave,
        );
        for index in 0..60 {
            let at = |factor: f32| (index as f32 * factor).fract();
            let (uv, angle) = (Vec2::new(at(0.618_034), at(0.324_717)), at(0.754_878) * 6.0);
            let (sin, cos) = libm::sincosf(angle);
            let (short, long) = (0.004 + at(0.43) * 0.03, 0.01 + at(0.27) * 0.2);
            let steps = [Vec2::new(cos, sin) * long, Vec2::new(-sin, cos + 0.5) * short];
            let mut mean = Vec4::ZERO;
            for sub in 0..4096 {
                let place = |index: i32| (index as f32 + 0.5) / 64.0 - 0.5;
                let uv = uv + steps[0] * place(sub % 64) + steps[1] * place(sub / 64);
                mean += look(&plain, uv, [Vec2::ZERO; 2], Encoding::Linear) / 4096.0;
            }
            let found = look(&scene, uv, steps, Encoding::Linear);
            assert!((found - mean).abs().max_element() < 0.08, "{index}: {found} {mean}");
        }
    }

    #[test]
    fn samplers_get_what_they_ask_for() {
        // Columns 0 and 255; a footprint of eight texels by eight.
        let stripes = |x: u32, _: u32| [if x.is_multiple_of(2) { 0 } else { 255 }, 0, 0, 255];
        let red = |minify, mip, side: f32| {
            let sampler = Sampler { minify, mip, ..Default::default() };
            let scene = mapped((16, 16), sampler, Encoding::Linear, stripes);
            let steps = [Vec2::X * side / 16.0, Vec2::Y * side / 16.0];
            look(&scene, Vec2::new(5.4, 5.4) / 16.0, steps, Encoding::Linear).x
        };
        // Texel 5 is white; 0.1 left of its middle lies nine tenths of it.
        assert_eq!(red(Filter::Nearest, MipFilter::None, 8.0), 1.0);
        assert!((red(Filter::Linear, MipFilter::None, 8.0) - 0.9).abs() < 1e-5);
        for minify in [Filter::Nearest, Filter::Linear] {
            for mip in [MipFilter::Nearest, MipFilter::Linear] {
                assert!((red(minify, mip, 8.0) - 0.5).abs() < 0.01, "{minify:?} {mip:?}");
            }
        }
        // Between the full image and the first level, the nearer one.
        assert_eq!(red(Filter::Nearest, MipFilter::Nearest, 1.4), 1.0);
        assert!((red(Filter::Nearest, MipFilter::Nearest, 1.6) - 0.5).abs() < 0.01);
        assert!((red(Filter::Nearest, MipFilter::Linear, 1.5) - 0.75).abs() < 0.01);
    }

    #[test]
    fn transparent_texels_lend_no_colour() {
        // A green leaf beside transparent black: half way between, the leaf is half there and as green.
        let leaf = |x: u32, _: u32| if x == 0 { [0, 255, 0, 255] } else { [0; 4] };
        for steps in [[Vec2::ZERO; 2], [Vec2::X, Vec2::Y]] {
            let scene = mapped((2, 2), Sampler::default(), Encoding::CoveredSrgb, leaf);
            let seen = look(&scene, Vec2::new(0.5, 0.5), steps, Encoding::CoveredSrgb);
            assert!(seen.abs_diff_eq(Vec4::new(0.0, 1.0, 0.0, 0.5), 0.005), "{seen}");
        }
    }
}
