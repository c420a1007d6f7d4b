//! The limits of a layer: those of its kind, and of lengths as small as the scene.

use half::f16;

use super::channel_difference::{LayerDifference, ValueLimits};
use super::comparison::Check;
use super::presets::Limits;
use super::{Channel, Image};

/// Limits on the values of a layer, and on the share of pixels beyond them.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerLimits {
    pub(super) values: ValueLimits,
    share: f64,
    /// The absolute limit as a share of the range of the layer's values, where it is one.
    of_range: Option<f64>,
}

impl LayerLimits {
    /// Those of a layer of light.
    pub(super) fn of_light(limits: &Limits) -> Self {
        Self { values: limits.light, share: limits.light_share, of_range: None }
    }

    /// Those of channels of data of a layer. Where depths or positions lie within less than one unit, the absolute limit is the same share
    /// of that range: an asset of centimetres has the limits of one of metres.
    pub(super) fn of_data(limits: &Limits, layer: &str, channels: &[&Channel]) -> Self {
        let (values, share) = (limits.data, limits.data_share);
        let range = if are_lengths(layer, channels) { range(channels) } else { 0.0 };
        // Without a range there is none to take a share of.
        if !(range > 0.0 && range < 1.0 && values.absolute.is_finite()) {
            return Self { values, share, of_range: None };
        }
        let scaled = ValueLimits { absolute: values.absolute * range, ..values };
        Self { values: scaled, share, of_range: Some(values.absolute) }
    }

    /// The check of the share of pixels that differ; `None` without a limit.
    pub(super) fn check(&self, what: &str, difference: &LayerDifference, reference: &Image) -> Option<Check> {
        let pixels = reference.data_window.pixel_count();
        let measured = difference.different_pixels as f64 / pixels.max(1) as f64;
        let worst =
            difference.channels.iter().filter(|channel| channel.different > 0 || channel.largest > 0.0);
        let worst = worst.max_by(|a, b| a.largest.total_cmp(&b.largest));
        let absolute = match self.of_range {
            Some(share) => format!("{} % of its range", share * 100.0),
            None => self.values.absolute.to_string(),
        };
        let percent = self.values.relative * 100.0;
        (self.share < f64::INFINITY).then(|| Check {
            measure: format!("share of pixels with {what} off by more than {absolute} and {percent} %"),
            measured,
            limit: self.share,
            at: worst.map(|channel| channel.largest_at),
            passes: measured <= self.share,
        })
    }
}

/// Whether the channels of a layer hold depths or positions, by the names that programs give them.
fn are_lengths(layer: &str, channels: &[&Channel]) -> bool {
    let last = |name: &str| name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase();
    let is_depth = || matches!(channels, [channel] if last(&channel.name) == "z");
    matches!(last(layer).as_str(), "depth" | "position" | "p" | "z") || is_depth()
}

/// The largest range of the values of a channel. Those where no surface is do not count: 0, and what is beyond halves, such as 1e10.
fn range(channels: &[&Channel]) -> f64 {
    let surface = |value: &f32| *value != 0.0 && value.abs() < f16::MAX.to_f32();
    let of_channel = |channel: &&Channel| {
        let values = channel.samples.floats()?;
        let values = values.iter().filter(|value| surface(value)).map(|value| f64::from(*value));
        let (least, most) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (a.min(value), b.max(value)));
        Some(most - least)
    };
    channels.iter().filter_map(of_channel).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::{ColorEncoding, Preset, Samples, compare};
    use super::*;

    const SIZE: (u32, u32) = (20, 20);

    /// An image with these channels of data, by column.
    fn image(channels: &[(&str, &dyn Fn(u32) -> f32)]) -> Image {
        let mut image = Image::from_rgba(SIZE, ColorEncoding::Linear, &[[0.5, 0.5, 0.5, 1.0]; 400]);
        for (name, value) in channels {
            let samples = (0..400).map(|at| value(at % SIZE.0)).collect();
            image.channels.push(Channel { name: (*name).to_owned(), samples: Samples::Float(samples) });
        }
        image
    }

    /// Depths from `near` to `far`, with two columns of background.
    fn depths(near: f32, far: f32) -> impl Fn(u32) -> f32 {
        move |column| if column > 17 { 1e10 } else { near + (far - near) * column as f32 / 17.0 }
    }

    fn failures(actual: &Image, reference: &Image, preset: Preset) -> Vec<String> {
        compare(actual, reference, &preset.limits()).failures()
    }

    #[test]
    fn depths_of_small_assets_fail_as_those_of_large_ones() {
        for name in ["Z", "ViewLayer.Depth.Z", "left.Z"] {
            let with_depth = |near: f32, far: f32| image(&[(name, &depths(near, far))]);
            for unit in [1e-3, 0.02, 1.0, 50.0] {
                let reference = with_depth(5.0 * unit, 6.0 * unit);
                for preset in [Preset::Visual, Preset::Noisy] {
                    let flat = failures(&with_depth(5.5 * unit, 5.5 * unit), &reference, preset);
                    assert_eq!(flat.len(), 1, "{name} {unit}: {flat:?}");
                    assert_eq!(flat[0].contains("% of its range and"), unit < 1.0, "{flat:?}");
                    // By a thousandth of the depth.
                    let near = failures(&with_depth(5.005 * unit, 6.006 * unit), &reference, preset);
                    assert!(near.is_empty(), "{name} {unit}: {near:?}");
                }
            }
        }
    }

    #[test]
    fn positions_have_the_range_of_all_axes_without_the_background() {
        // A chip of 2 cm, 10 m from the origin, whose depth is constant.
        let across = |column: u32| if column > 17 { 0.0 } else { 10.0 + 0.02 * column as f32 / 17.0 };
        let mirrored = |column: u32| if column > 17 { 0.0 } else { 10.02 - 0.02 * column as f32 / 17.0 };
        let flat = |column: u32| if column > 17 { 0.0 } else { 1e-7 * column as f32 };
        let none = |_: u32| 0.0;
        let reference = image(&[("position.X", &across), ("position.Y", &flat), ("position.Z", &none)]);
        // Rounding about 0 is within the range of another axis.
        let rounded = image(&[("position.X", &across), ("position.Y", &none), ("position.Z", &none)]);
        assert!(failures(&rounded, &reference, Preset::Visual).is_empty());
        // Half of the pixels of the middle axis are 2 mm off.
        let moved = |column: u32| if column < 9 { 0.002 } else { flat(column) };
        let moved = image(&[("position.X", &across), ("position.Y", &moved), ("position.Z", &none)]);
        let found = failures(&moved, &reference, Preset::Visual);
        assert!(
            found.len() == 1 && found[0].contains("position off by more than 1 % of its range"),
            "{found:?}"
        );
        // Both limits count: what is 2 cm off at 10 m is within 1 %.
        let mirrored = image(&[("position.X", &mirrored), ("position.Y", &flat), ("position.Z", &none)]);
        assert!(failures(&mirrored, &reference, Preset::Visual).is_empty());
    }

    #[test]
    fn other_data_has_units_of_its_own() {
        let reference = image(&[("roughness.V", &|_| 0.1)]);
        let near = image(&[("roughness.V", &|_| 0.109)]);
        assert!(failures(&near, &reference, Preset::Visual).is_empty());
        assert_eq!(failures(&near, &reference, Preset::Strict).len(), 1);
    }
}
