//! Texture lookups against known values and against the mean of many lookups.

use super::level_lookup::wrap;
use super::*;
use crate::scene::{
    Filter, Image, ImageIndex, ImageMips, Texels, Texture, TextureIndex, UvTransform, WrapMode, mip_levels,
};

fn look_up(
    scene: &Scene,
    reference: &TextureRef,
    uv: Vec2,
    differential: UvDifferential,
    encoding: Encoding,
) -> Vec4 {
    sample(scene, reference, encoding, &mut TextureProbes::default(), || (uv, differential))
}

/// Four texels in a row with red 0, 1, 2, 3 (times 1/255).
fn ramp(sampler: Sampler) -> Scene {
    let texels = Texels::Rgba8((0..4).map(|red| [red, 0, 0, 255]).collect());
    Scene {
        images: vec![Image { name: None, width: 4, height: 1, texels }],
        textures: vec![Texture { name: None, image: ImageIndex(0), sampler }],
        ..Default::default()
    }
}

/// Red of the ramp, looked up over a square of the texture.
fn red(sampler: Sampler, u: f32, side: f32) -> f32 {
    let differential = UvDifferential([Vec2::X * side, Vec2::Y * side]);
    let reference = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
    let value = look_up(&ramp(sampler), &reference, Vec2::new(u, 0.5), differential, Encoding::Linear);
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
fn linear_filtering_is_exact_at_texel_centres_and_wraps_between_the_ends() {
    let linear = Sampler::default();
    let at = |u| red(linear, u, 0.0);
    assert_eq!(at(1.5 / 4.0), 1.0);
    assert_eq!(at(2.0 / 4.0), 1.5);
    // Half way between texel 3 and texel 0 of the next repetition.
    assert_eq!(at(0.0), 1.5);
}

#[test]
fn wide_lookups_use_the_minifying_filter() {
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

/// An image with mip maps for one encoding.
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
    look_up(scene, &reference, uv, UvDifferential(steps), encoding)
}

#[test]
fn a_checkerboard_becomes_its_mean_towards_the_horizon() {
    // Black and white squares of one texel. From a width of two texels on, lookups return the mean. Round ones have no jump on the
    // way; along an axis one more probe is a jump, the largest where a second one joins the first.
    let scene = mapped((64, 64), Sampler::default(), Encoding::Srgb, |x, y| {
        if (x + y) % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] }
    });
    for (aspect, most) in [(1.0, 0.04), (3.0, 0.4), (10.0, 0.15), (40.0, 0.15)] {
        let mut last = None;
        for step in 0..400 {
            let width = libm::exp2f(step as f32 * 0.03 - 2.0) / 64.0;
            let steps = [Vec2::new(width, 0.0), Vec2::new(0.0, width * aspect)];
            // The centre of a white texel
            let seen = look(&scene, Vec2::new(33.5, 20.5) / 64.0, steps, Encoding::Srgb).x;
            if width * 64.0 >= 2.0 {
                assert!((seen - 0.5).abs() < 0.01, "{aspect} {width}: {seen}");
            }
            let jump = (seen - last.unwrap_or(seen)).abs();
            assert!(jump < most, "{aspect} {width}: {last:?} {seen}");
            last = Some(seen);
        }
    }
}

#[test]
fn lookups_agree_with_the_mean_of_many() {
    // Reference: 64 × 64 lookups of the full image over the parallelogram. A level's texels are as wide as the short axis and
    // interpolation widens them once more, so the image is smooth on that scale.
    let wave = |x: u32, y: u32| {
        let at = |frequency: f32, column: u32| {
            libm::sinf(column as f32 / 256.0 * frequency * std::f32::consts::TAU)
        };
        let byte = |value: f32| (127.5 + 127.5 * value) as u8;
        [byte(at(3.0, x)), byte(at(2.0, y)), byte(at(5.0, x) * at(1.0, y)), 255]
    };
    let scene = mapped((256, 256), Sampler::default(), Encoding::Linear, wave);
    let plain =
        mapped((256, 256), Sampler { mip: MipFilter::None, ..Default::default() }, Encoding::Linear, wave);
    for index in 0..60 {
        let at = |factor: f32| (index as f32 * factor).fract();
        let (uv, angle) = (Vec2::new(at(0.618_034), at(0.324_717)), at(0.754_878) * 6.0);
        let (sin, cos) = libm::sincosf(angle);
        let (short, long) = (0.004 + at(0.43) * 0.03, 0.01 + at(0.27) * 0.2);
        let steps = [Vec2::new(cos, sin) * long, Vec2::new(-sin, cos + 0.5) * short];
        let mut mean = Vec4::ZERO;
        for sub in 0..4096 {
            let offset = |index: i32| (index as f32 + 0.5) / 64.0 - 0.5;
            let uv = uv + steps[0] * offset(sub % 64) + steps[1] * offset(sub / 64);
            mean += look(&plain, uv, [Vec2::ZERO; 2], Encoding::Linear) / 4096.0;
        }
        let found = look(&scene, uv, steps, Encoding::Linear);
        assert!((found - mean).abs().max_element() < 0.08, "{index}: {found} {mean}");
    }
}

#[test]
fn sampler_filters_are_respected() {
    // Columns alternate between 0 and 255; lookups cover up to eight by eight texels.
    let stripes = |x: u32, _: u32| [if x.is_multiple_of(2) { 0 } else { 255 }, 0, 0, 255];
    let red = |minify, mip, side: f32| {
        let sampler = Sampler { minify, mip, ..Default::default() };
        let scene = mapped((16, 16), sampler, Encoding::Linear, stripes);
        let steps = [Vec2::X * side / 16.0, Vec2::Y * side / 16.0];
        look(&scene, Vec2::new(5.4, 5.4) / 16.0, steps, Encoding::Linear).x
    };
    // Texel 5 is white; 0.1 left of its centre its weight is nine tenths.
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
fn transparent_texels_contribute_no_colour() {
    // A green leaf next to transparent black: half way between, alpha is a half and the colour as green.
    let leaf = |x: u32, _: u32| if x == 0 { [0, 255, 0, 255] } else { [0; 4] };
    for steps in [[Vec2::ZERO; 2], [Vec2::X, Vec2::Y]] {
        let scene = mapped((2, 2), Sampler::default(), Encoding::CoveredSrgb, leaf);
        let seen = look(&scene, Vec2::new(0.5, 0.5), steps, Encoding::CoveredSrgb);
        assert!(seen.abs_diff_eq(Vec4::new(0.0, 1.0, 0.0, 0.5), 0.005), "{seen}");
    }
}

#[test]
fn a_level_is_looked_up_alone() {
    let mut scene = ramp(Sampler::default());
    let mut mips = ImageMips::default();
    mips.set(Encoding::Linear, mip_levels(&scene.images[0], Encoding::Linear).into());
    scene.mips = vec![mips];
    let reference = TextureRef { texture: TextureIndex(0), uv_set: 0, transform: UvTransform::default() };
    let red = |level: usize| {
        let at = (Vec2::new(0.375, 0.5), level);
        sample_in_level(&scene, &reference, Encoding::Linear, at).x * 255.0
    };
    // The second of four texels; between the means of two, rounded to whole codes; and the mean of all.
    let levels = [0, 1, 2, 9].map(red);
    for (level, expected) in levels.into_iter().zip([1.0, 1.0 + 0.25 * 2.0, 2.0, 2.0]) {
        assert!((level - expected).abs() < 1e-3, "{levels:?}");
    }
}
