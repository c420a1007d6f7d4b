//! Checks of what an observer sees: FLIP and brightness of every layer of light, and FLIP of coverage.
//!
//! The layer that the image shows is the first of light by [`Image::color_layer`]. The others are measured at its
//! exposures with a tone curve and against its brightness, so that a dim layer counts for what it adds. Those that do not differ have no
//! checks.

use std::cell::LazyCell;

use super::common_form::is_light;
use super::comparison::{Check, Comparison};
use super::flip::{
    Exposures, FlipMap, LEAST_LUMINANCE, PIXELS_PER_DEGREE, flip_display, flip_light_at, has_light,
};
use super::pooling::{ObjectError, PooledErrors, pool, pool_objects};
use super::presets::Limits;
use super::root_mean_square::root_mean_square;
use super::{ColorEncoding, Image, Samples};
use crate::color::{linear_to_srgb16, luminance};

/// The layer of the ids of objects.
pub(super) const OBJECT_IDS: &str = "object_id";

/// A measure of colours or coverage, before it has a limit.
pub(super) struct ColorMeasure {
    measure: String,
    measured: f64,
    limit: fn(&Limits) -> f64,
    at: Option<(u32, u32)>,
}

impl ColorMeasure {
    /// The check by its limit of `limits`.
    pub(super) fn check(&self, limits: &Limits) -> Check {
        let limit = (self.limit)(limits);
        let (measure, measured) = (self.measure.clone(), self.measured);
        Check { measure, measured, limit, at: self.at, passes: measured <= limit }
    }
}

/// Measures colours and coverage; sets the measures of the layer that the image shows.
pub(super) fn measure_colors(comparison: &mut Comparison, images: [&Image; 2]) -> Vec<ColorMeasure> {
    let [actual, reference] = images;
    let mut measures = Vec::new();
    let layers: Vec<_> = reference.layers().into_iter().filter(|layer| is_light(layer, reference)).collect();
    let shown = reference.color_layer().filter(|layer| layers.contains(layer));
    let Some(shown) = shown.or(layers.first().copied()) else { return measures };
    let colors_of = |layer: &str| Some([actual.colors_of(layer)?, reference.colors_of(layer)?]);
    let Some([ours, theirs]) = &colors_of(shown) else { return measures };
    let is_display = reference.encoding == ColorEncoding::Srgb;
    let exposures = LazyCell::new(|| (!is_display).then(|| Exposures::of_pair(theirs, ours)));
    let light = LazyCell::new(|| light_of_reference(theirs, is_display));

    // The layer that the image shows
    let map = flip_map(ours, theirs, images, || exposures.clone());
    let pooled = add_flip(&mut measures, &map, (images, ""));
    measures.push(brightness(ours, theirs, (|| *light, "")));
    comparison.root_mean_square = Some(root_mean_square(ours, theirs, is_display.then_some(1.0)));
    comparison.flip = Some(pooled);
    comparison.exposures.clone_from(&map.exposures);
    comparison.flip_map = Some(map);

    // Other layers of light, with the curve alone: without one, light that hardly adds to the image would be seen on black.
    let with_curve = || exposures.clone().map(|exposures| Exposures { linear: Vec::new(), ..exposures });
    for layer in layers.iter().copied().filter(|layer| *layer != shown) {
        let Some([ours, theirs]) = colors_of(layer).filter(|[ours, theirs]| ours != theirs) else { continue };
        let map = flip_map(&ours, &theirs, images, with_curve);
        let of_layer = format!(" of {layer}");
        add_flip(&mut measures, &map, (images, &of_layer));
        measures.push(brightness(&ours, &theirs, (|| *light, &of_layer)));
    }

    // Coverage, which colours over black do not show
    for layer in layers {
        let (Some(ours), Some(theirs)) = (actual.coverage_of(layer), reference.coverage_of(layer)) else {
            continue;
        };
        if ours != theirs {
            let grey = |coverage: &[f32]| coverage.iter().map(|&share| [share; 3]).collect::<Vec<_>>();
            let map = flip_map(&grey(&ours), &grey(&theirs), images, || None);
            let of_layer = if layer == shown { String::new() } else { format!(" of {layer}") };
            add_flip(&mut measures, &map, (images, &format!(" of coverage{of_layer}")));
        }
    }
    measures
}

/// FLIP of light at `exposures`, or of display values without any.
fn flip_map(
    actual: &[[f32; 3]],
    reference: &[[f32; 3]],
    [_, image]: [&Image; 2],
    exposures: impl FnOnce() -> Option<Exposures>,
) -> FlipMap {
    let size = image.size();
    if actual == reference {
        // Equal images have no error; FLIP need not run.
        return FlipMap { size, errors: vec![0.0; actual.len()], exposures: None };
    }
    match exposures() {
        Some(exposures) => flip_light_at(exposures, reference, actual, size, PIXELS_PER_DEGREE),
        None => flip_display(reference, actual, size, PIXELS_PER_DEGREE),
    }
}

/// Adds the measures of a FLIP map, and returns its pooled errors.
fn add_flip(
    measures: &mut Vec<ColorMeasure>,
    map: &FlipMap,
    (images, of_layer): ([&Image; 2], &str),
) -> PooledErrors {
    let mut pooled = pool(map);
    pooled.object = worst_object(map, images);
    let mut add = |measure: &str, measured: f64, limit: fn(&Limits) -> f64, at: Option<(u32, u32)>| {
        let measure = format!("{measure}{of_layer}");
        measures.push(ColorMeasure { measure, measured, limit, at: at.filter(|_| measured > 0.0) });
    };
    add("mean FLIP", pooled.mean, |limits| limits.mean_flip, None);
    add("FLIP of the worst tile", pooled.tile, |limits| limits.tile_flip, Some(pooled.tile_at));
    if let Some(object) = pooled.object {
        add("FLIP of the worst object", object.mean, |limits| limits.object_flip, Some(object.at));
    }
    pooled
}

/// The worst object of either image, where both have ids: an object that vanishes is in the reference alone.
fn worst_object(map: &FlipMap, [actual, reference]: [&Image; 2]) -> Option<ObjectError> {
    let [Samples::Uint(ours), Samples::Uint(theirs)] =
        [&actual.channel(OBJECT_IDS)?.samples, &reference.channel(OBJECT_IDS)?.samples]
    else {
        return None;
    };
    let worst = [pool_objects(map, theirs), pool_objects(map, ours)];
    worst.into_iter().flatten().reduce(|a, b| if b.mean > a.mean { b } else { a })
}

/// The measure of mean luminance: the absolute difference as a share of `whole`, the light of what the reference shows.
fn brightness(
    actual: &[[f32; 3]],
    reference: &[[f32; 3]],
    (whole, of_layer): (impl FnOnce() -> f64, &str),
) -> ColorMeasure {
    let measured = if actual == reference {
        0.0
    } else {
        let difference = total_light(actual) - total_light(reference);
        if difference == 0.0 { 0.0 } else { (difference / whole()).abs() }
    };
    ColorMeasure {
        measure: format!("difference of mean brightness{of_layer}"),
        measured,
        limit: |limits| limits.brightness,
        at: None,
    }
}

/// The light of which differences of brightness are shares: that of the reference, or the least that is shown where it has none.
fn light_of_reference(reference: &[[f32; 3]], is_display: bool) -> f64 {
    if has_light(reference) {
        return total_light(reference);
    }
    let on_display = || f32::from(linear_to_srgb16(LEAST_LUMINANCE)) / 65535.0;
    let least = if is_display { on_display() } else { LEAST_LUMINANCE };
    f64::from(least) * reference.len() as f64
}

/// Sum of the finite luminances.
fn total_light(colors: &[[f32; 3]]) -> f64 {
    let light = colors.iter().map(|color| f64::from(luminance(glam::Vec3::from_array(*color))));
    light.filter(|light| light.is_finite()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::srgb_to_linear;
    use crate::regression::{Channel, Preset, compare};

    const SIZE: (u32, u32) = (32, 32);

    /// An image with the layer `name` of this grey, beside colours of `beauty` where it has some.
    fn with_layer(name: &str, grey: f32, beauty: Option<f32>) -> Image {
        let beauty_grey = beauty.unwrap_or(0.0);
        let pixels = vec![[beauty_grey, beauty_grey, beauty_grey, 1.0]; (SIZE.0 * SIZE.1) as usize];
        let mut image = Image::from_rgba(SIZE, ColorEncoding::Linear, &pixels);
        if beauty.is_none() {
            image.channels.clear();
        }
        for channel in ["R", "G", "B"] {
            let samples = Samples::Float(vec![grey; pixels.len()]);
            image.channels.push(Channel { name: format!("{name}.{channel}"), samples });
        }
        image
    }

    fn failures(actual: &Image, reference: &Image) -> String {
        compare(actual, reference, &Preset::Visual.limits()).failures().join("\n")
    }

    #[test]
    fn colours_under_any_name_are_compared() {
        for name in ["direct", "ViewLayer.Combined", "diffuse"] {
            let failures = failures(&with_layer(name, 0.8, None), &with_layer(name, 0.1, None));
            assert!(failures.contains("mean FLIP: ") && failures.contains("mean brightness: "), "{failures}");
        }
    }

    #[test]
    fn what_fails_on_a_display_fails_as_light() {
        // A patch on a flat wall, a soft shadow, and a grid of lines, each beside a black corner
        let display = |wall: f32, depth: f32, darkens: fn(usize, usize) -> f32| {
            let value = |at: usize| {
                let (x, y) = (at % 64, at / 64);
                let is_corner = x < 4 && y < 4;
                if is_corner { 0.0 } else { wall - depth * darkens(x, y) }
            };
            (0..64 * 64).map(|at| [value(at), value(at), value(at), 1.0]).collect::<Vec<_>>()
        };
        let patch = |x: usize, y: usize| f32::from((20..50).contains(&x) && (20..50).contains(&y));
        let shadow =
            |x: usize, y: usize| 1.0 - (libm::hypotf(x as f32 - 32.0, y as f32 - 32.0) / 20.0).min(1.0);
        let lines = |x: usize, y: usize| f32::from(x.is_multiple_of(8) || y.is_multiple_of(8));
        let mut failed_on_display = 0;
        for darkening in [patch as fn(usize, usize) -> f32, shadow, lines] {
            for wall in [0.95, 0.8, 0.25] {
                for depth in [0.06, 0.2] {
                    let found = |to_encoding: fn(f32) -> f32, encoding: ColorEncoding| {
                        let [actual, reference] = [depth, 0.0].map(|depth| {
                            let pixels = display(wall, depth, darkening).into_iter();
                            let pixels: Vec<_> = pixels
                                .map(|[r, g, b, a]| [to_encoding(r), to_encoding(g), to_encoding(b), a])
                                .collect();
                            Image::from_rgba((64, 64), encoding, &pixels)
                        });
                        failures(&actual, &reference)
                    };
                    let on_display = found(|value| value, ColorEncoding::Srgb);
                    let as_light = found(srgb_to_linear, ColorEncoding::Linear);
                    failed_on_display += u32::from(!on_display.is_empty());
                    assert!(
                        on_display.is_empty() || !as_light.is_empty(),
                        "wall {wall}, depth {depth}: {on_display}"
                    );
                }
            }
        }
        assert!(failed_on_display > 6, "{failed_on_display}");
    }

    #[test]
    fn invisible_light_is_no_change_of_a_black_image() {
        let image = |encoding: ColorEncoding, grey: f32, patch: f32| {
            let value = |at: usize| if at % 32 < 8 && at / 32 < 8 { patch } else { grey };
            let pixels: Vec<_> = (0..32 * 32).map(|at| [value(at), value(at), value(at), 1.0]).collect();
            Image::from_rgba(SIZE, encoding, &pixels)
        };
        let light = |grey, patch| image(ColorEncoding::Linear, grey, patch);
        let (black, residue, mut pixel) = (light(0.0, 0.0), light(1e-6, 1e-6), light(0.0, 0.0));
        for channel in pixel.channels.iter_mut().filter(|channel| channel.name != "A") {
            if let Samples::Float(values) = &mut channel.samples {
                values[40] = 1e-5;
            }
        }
        for preset in [Preset::Strict, Preset::Visual] {
            for (actual, reference) in
                [(&residue, &black), (&pixel, &black), (&black, &residue), (&pixel, &residue)]
            {
                let failures = compare(actual, reference, &preset.limits()).failures();
                assert!(failures.is_empty(), "{failures:?}");
            }
        }
        for visible in [light(0.0, 0.02), light(0.02, 0.02), light(0.002, 0.002)] {
            assert!(failures(&visible, &black).contains("FLIP of the worst tile: "));
        }
        // One step of eight bits on a display
        let step = |steps: f32| image(ColorEncoding::Srgb, steps / 255.0, steps / 255.0);
        assert_eq!(failures(&step(1.0), &step(0.0)), "");
        assert!(failures(&step(20.0), &step(0.0)).contains("difference of mean brightness: "));
        // A dim layer under a black image
        let [bright, dim] = [0.5, 0.1].map(|grey| with_layer("direct", grey, Some(0.0)));
        assert!(failures(&bright, &dim).contains("mean brightness of direct: "));
    }

    #[test]
    fn layers_of_light_are_compared_beside_equal_colours() {
        let [bright, dim] = [0.8, 0.1].map(|grey| with_layer("direct", grey, Some(0.9)));
        let failures = failures(&bright, &dim);
        assert!(failures.contains("mean FLIP of direct: "), "{failures}");
        assert!(failures.contains("difference of mean brightness of direct: 0.7778 > 0.03"), "{failures}");
        // What hardly adds to the image hardly counts.
        let [bright, dim] = [0.003, 0.001].map(|grey| with_layer("direct", grey, Some(0.9)));
        let comparison = compare(&bright, &dim, &Preset::Visual.limits());
        assert!(comparison.passes(), "{:?}", comparison.failures());
        assert_eq!(comparison.checks.iter().filter(|check| check.measure.ends_with(" of direct")).count(), 3);
        // Equal layers have no checks.
        let comparison = compare(&dim, &dim, &Preset::Visual.limits());
        assert!(comparison.checks.iter().all(|check| !check.measure.ends_with(" of direct")));
    }

    #[test]
    fn the_whole_image_goes_before_its_passes_whatever_their_names() {
        // An occlusion pass, first by name, is white in both.
        let both = |grey: f32| {
            let mut image = with_layer("v.AO", 1.0, None);
            image.channels.extend(with_layer("v.Combined", grey, None).channels);
            image
        };
        assert_eq!(both(0.5).color_layer(), Some("v.Combined"));
        let failures = failures(&both(0.006), &both(0.002));
        assert!(failures.contains("difference of mean brightness: 2 > 0.03"), "{failures}");
        // Data with colours is shown where there is nothing else, and is no light.
        let albedo = |grey: f32| with_layer("albedo", grey, None);
        assert_eq!(albedo(0.5).color_layer(), Some("albedo"));
        assert!(
            super::tests::failures(&albedo(0.5), &albedo(0.2)).starts_with("share of pixels with albedo")
        );
    }

    #[test]
    fn cryptomattes_are_data_whatever_their_channels() {
        let ids = |id: f32| {
            let mut image = with_layer("ViewLayer.CryptoObject00", id, Some(0.5));
            for channel in image.channels.iter_mut().filter(|channel| channel.name.starts_with("View")) {
                // One pixel of a thousand is of another thing.
                if let Samples::Float(values) = &mut channel.samples {
                    values[1..].fill(1.0);
                }
            }
            image
        };
        assert!(compare(&ids(1e34), &ids(1.0), &Preset::Visual.limits()).passes());
    }

    #[test]
    fn coverage_and_data_of_every_layer_of_light_are_limited() {
        let layer = |name: &str, value: f32| {
            let mut image = with_layer("fg", 0.0, Some(0.5));
            let samples = Samples::Float(vec![value; (SIZE.0 * SIZE.1) as usize]);
            image.channels.push(Channel { name: name.to_owned(), samples });
            image
        };
        let failures = |name| failures(&layer(name, 9.0), &layer(name, 0.0));
        assert!(failures("fg.A").contains("mean FLIP of coverage of fg: "), "{}", failures("fg.A"));
        assert!(
            failures("fg.Z").starts_with("share of pixels with data of fg off by"),
            "{}",
            failures("fg.Z")
        );
    }

    #[test]
    fn a_single_channel_without_the_other_two_is_data() {
        let single = |value: f32| {
            let samples = Samples::Float(vec![value; (SIZE.0 * SIZE.1) as usize]);
            let mut image = with_layer("direct", 0.5, Some(0.5));
            image.channels.push(Channel { name: "shadow.R".to_owned(), samples });
            image
        };
        let failures = failures(&single(0.5), &single(0.4));
        assert!(failures.starts_with("share of pixels with shadow off by more than "), "{failures}");
    }

    #[test]
    fn lost_coverage_fails_where_the_colour_is_black() {
        let black = |alpha: f32| {
            Image::from_rgba(
                SIZE,
                ColorEncoding::Linear,
                &vec![[0.0, 0.0, 0.0, alpha]; (SIZE.0 * SIZE.1) as usize],
            )
        };
        let failures = failures(&black(1.0), &black(0.0));
        assert!(failures.contains("mean FLIP of coverage: "), "{failures}");
        assert_eq!(super::tests::failures(&black(0.99), &black(1.0)), "");
    }
}
