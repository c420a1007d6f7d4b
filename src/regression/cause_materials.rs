//! The materials whose pixels differ, worst first, where the likely cause of a difference is a material.

use std::collections::BTreeMap;

use super::cause::Cause;
use super::comparison::Comparison;
use super::{Channel, Image, Samples};

/// Largest number of materials that a cause names.
const MAX_NAMED: usize = 3;
/// Smallest mean difference of a named material, as a share of the worst one. Other materials reflect those that changed.
const LEAST_SHARE: f64 = 0.1;
/// The layer of the ids of materials.
const MATERIAL_IDS: &str = "material_id";
/// Layers whose differences belong to the material of the pixel. Ids tell no measure, and may have other numbers.
const MEASURED: [&str; 3] = ["albedo", "normal", "uv"];

impl Comparison {
    /// Names up to three materials whose pixels differ, worst first, where the likely cause is a material and the actual image has the layer
    /// `material_id`. `name` returns the name for an id of that layer.
    pub fn name_materials(
        &mut self,
        actual: &Image,
        reference: &Image,
        name: &dyn Fn(u32) -> Option<String>,
    ) {
        if let Some(Cause::Material { layer, materials, .. }) = &mut self.cause {
            let ids = differing_materials(layer.as_deref(), actual, reference);
            *materials = ids.into_iter().filter_map(name).take(MAX_NAMED).collect();
        }
    }
}

/// The ids of materials whose pixels differ in `layer`, or in colour, worst mean first.
fn differing_materials(layer: Option<&str>, actual: &Image, reference: &Image) -> Vec<u32> {
    let Some(Samples::Uint(ids)) = actual.channel(MATERIAL_IDS).map(|channel| &channel.samples) else {
        return Vec::new();
    };
    let differences = match layer {
        Some(layer) if MEASURED.contains(&layer) => layer_differences(layer, actual, reference),
        _ => color_differences(actual, reference),
    };
    let mut sums = BTreeMap::<u32, (f64, f64)>::new();
    for (&id, difference) in ids.iter().zip(differences).filter(|(id, _)| **id != 0) {
        let (sum, pixels) = sums.entry(id).or_default();
        *sum += difference;
        *pixels += 1.0;
    }
    let mut means: Vec<_> = sums.into_iter().map(|(id, (sum, pixels))| (id, sum / pixels)).collect();
    means.sort_by(|a, b| b.1.total_cmp(&a.1));
    let worst = means.first().map_or(0.0, |(_, worst)| *worst);
    means.retain(|(_, mean)| *mean > 0.0 && *mean >= LEAST_SHARE * worst);
    means.into_iter().map(|(id, _)| id).collect()
}

/// The absolute difference of each pixel in the channels of a layer.
fn layer_differences(layer: &str, actual: &Image, reference: &Image) -> Vec<f64> {
    let mut differences = vec![0.0; reference.data_window.pixel_count()];
    for theirs in reference.channels_of(layer) {
        if let Some(ours) = actual.channel(&theirs.name) {
            for (at, difference) in differences.iter_mut().enumerate() {
                *difference += value_difference(ours, theirs, at);
            }
        }
    }
    differences
}

fn value_difference(ours: &Channel, theirs: &Channel, at: usize) -> f64 {
    let difference = match (&ours.samples, &theirs.samples) {
        (Samples::Half(ours), Samples::Half(theirs)) => f64::from(ours[at]) - f64::from(theirs[at]),
        (Samples::Float(ours), Samples::Float(theirs)) => f64::from(ours[at]) - f64::from(theirs[at]),
        _ => 0.0,
    };
    if difference.is_finite() { difference.abs() } else { 0.0 }
}

/// The difference of each pixel in colour, of which bright light counts no more than white.
fn color_differences(actual: &Image, reference: &Image) -> Vec<f64> {
    let shown = |value: f32| if value.is_finite() { f64::from(value.clamp(0.0, 1.0)) } else { 0.0 };
    let difference = |(ours, theirs): (&[f32; 3], &[f32; 3])| {
        ours.iter().zip(theirs).map(|(a, b)| (shown(*a) - shown(*b)).abs()).sum()
    };
    let colors = actual.colors().zip(reference.colors());
    colors.map_or_else(Vec::new, |(ours, theirs)| ours.iter().zip(&theirs).map(difference).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::ColorEncoding;

    /// Four pixels with the materials 1, 2, 2 and none, and these values of grey.
    fn image(values: [f32; 4]) -> Image {
        let pixels = values.map(|value| [value, value, value, 1.0]);
        let mut image = Image::from_rgba((4, 1), ColorEncoding::Linear, &pixels);
        let ids = Samples::Uint(vec![1, 2, 2, 0]);
        image.channels.push(Channel { name: MATERIAL_IDS.to_owned(), samples: ids });
        image
    }

    fn named(actual: [f32; 4], reference: [f32; 4], layer: Option<&str>) -> Vec<String> {
        let cause = Cause::Material { layer: layer.map(str::to_owned), pixels: 0, materials: Vec::new() };
        let mut comparison = Comparison { cause: Some(cause), ..Comparison::default() };
        let name = |id: u32| Some(["none", "hull", "glass"][id as usize].to_owned());
        comparison.name_materials(&image(actual), &image(reference), &name);
        match comparison.cause {
            Some(Cause::Material { materials, .. }) => materials,
            _ => Vec::new(),
        }
    }

    #[test]
    fn materials_are_named_worst_first_without_those_that_reflect_them() {
        let before = [0.5; 4];
        assert_eq!(named([0.4, 0.8, 0.8, 0.0], before, None), ["glass", "hull"]);
        assert_eq!(named([0.4, 0.51, 0.5, 0.0], before, None), ["hull"]);
        // Light that shows as white in both.
        assert_eq!(named([9.0, 0.6, 0.5, 0.0], [2.0, 0.5, 0.5, 0.0], None), ["glass"]);
        assert_eq!(named(before, before, None), [] as [&str; 0]);
        // Ids and mattes have no measure of their own.
        assert_eq!(named([0.4, 0.8, 0.8, 0.0], before, Some(MATERIAL_IDS)), ["glass", "hull"]);
        assert_eq!(named([0.4, 0.8, 0.8, 0.0], before, Some("albedo")), [] as [&str; 0]);
    }
}
