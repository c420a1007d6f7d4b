//! The likely cause of a difference between two images.
//!
//! Files of Rayframe tell what they were rendered from (`super::changes`): then the cause is what changed, and layers
//! only decide between several changes. For other images it is inferred, by rules in this order: displacement of the whole image, layers
//! of geometry, layers of materials, noise, light. Without enough to tell, the cause is [`Cause::MaterialOrLight`] or
//! [`Cause::Unclear`].

use serde::Serialize;

use super::changes::{Part, changed_parts, has_moved};
use super::shift::best_shift;
use super::{Image, LayerDifference};
use crate::color::luminance;
use crate::count_text::counted;
use crate::image::CameraOrigin;

/// Share of the squared differences that a displacement must explain.
const EXPLAINED_BY_SHIFT: f64 = 0.6;
/// Smallest displacement that counts as a camera move, pixels.
const LEAST_SHIFT: f64 = 0.05;
/// Share of the squared differences that a factor on light must explain.
const EXPLAINED_BY_LIGHT: f64 = 0.6;
/// Largest correlation of adjacent differences in noise.
const LARGEST_CORRELATION: f64 = 0.3;
/// Smallest share of pixels that differ through noise.
const LEAST_NOISE: f64 = 0.1;

/// Layers of geometry, the most telling first.
const GEOMETRY: [&str; 7] =
    ["object_id", "node_id", "depth", "position", "geometric_normal", "crypto_object", "motion"];
/// Layers of materials. Shading normals belong here because of normal maps; geometry is examined first.
const MATERIAL: [&str; 5] = ["material_id", "albedo", "normal", "uv", "crypto_material"];

/// The likely cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Cause {
    /// The camera changed, or the whole image is displaced.
    Camera {
        /// Pixels to the right; `None` where no single displacement explains the difference.
        right: Option<f64>,
        /// Pixels downwards.
        down: Option<f64>,
    },
    /// The camera that frames the scene moved, since a clip changed at other times.
    CameraFollowsClip,
    /// The camera of the file changed, and geometry as well.
    CameraOrGeometry,
    /// Objects moved, appeared, disappeared or changed shape.
    Geometry {
        /// The layer that differs; `None` where only the files tell.
        layer: Option<String>,
        /// Number of pixels that differ.
        pixels: usize,
    },
    /// Materials of surfaces changed.
    Material {
        /// The layer that differs; `None` where only the files tell.
        layer: Option<String>,
        /// Number of pixels that differ.
        pixels: usize,
        /// The materials whose pixels differ, worst first: names in quotes, or numbers. Empty where they are not known.
        materials: Vec<String>,
    },
    /// Colours of vertices changed.
    VertexColors,
    /// Lighting changed, or reflection properties that no layer holds.
    Light {
        /// Factors on red, green and blue, where they explain the difference.
        factors: Option<[f64; 3]>,
    },
    /// Geometry is equal, and materials cannot be told from light, or both changed.
    MaterialOrLight,
    /// The plate behind the scene changed, or whether the environment shows.
    Background,
    /// The near or far plane of the camera changed.
    ClipPlanes,
    /// Geometry, materials, lights and camera are equal: other settings, or another version of the program.
    Settings,
    /// One image holds linear light and the other display values.
    Encoding,
    /// Unstructured differences.
    Noise,
    /// There are no layers from which to infer a cause.
    Unclear {
        /// Share of pixels whose brightness differs.
        share: f64,
    },
}

impl std::fmt::Display for Cause {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Camera { right: Some(right), down: Some(down) } => {
                let (x, y) =
                    (if *right < 0.0 { "left" } else { "right" }, if *down < 0.0 { "up" } else { "down" });
                write!(
                    formatter,
                    "camera: the whole image moved {:.2} pixels to the {x} and {:.2} {y}",
                    right.abs(),
                    down.abs()
                )
            }
            Self::Camera { .. } => write!(formatter, "camera: it moved, or its field of view changed"),
            Self::CameraFollowsClip => {
                write!(formatter, "camera: the automatic camera follows a clip that changed")
            }
            Self::CameraOrGeometry => write!(formatter, "camera or geometry: both changed"),
            Self::Geometry { layer: Some(layer), pixels } => {
                write!(formatter, "geometry: {layer} differs in {}", counted(*pixels, "pixel"))
            }
            Self::Geometry { layer: None, .. } => {
                write!(formatter, "geometry: vertices, normals, texture coordinates or the pose changed")
            }
            Self::Material { layer: Some(layer), pixels, materials } => {
                write!(formatter, "material: {layer} differs in {}", counted(*pixels, "pixel"))?;
                if materials.is_empty() { Ok(()) } else { write!(formatter, " of {}", materials.join(", ")) }
            }
            Self::Material { layer: None, materials, .. } => {
                write!(formatter, "material: materials or textures changed")?;
                if materials.is_empty() { Ok(()) } else { write!(formatter, ": {}", materials.join(", ")) }
            }
            Self::VertexColors => write!(formatter, "material: vertex colours changed"),
            Self::Light { factors: Some([r, g, b]) } => {
                write!(formatter, "light: red times {r:.3}, green times {g:.3}, blue times {b:.3}")
            }
            Self::Light { factors: None } => write!(formatter, "light: lights or the environment changed"),
            Self::MaterialOrLight => write!(
                formatter,
                "material or light: geometry is equal; lights, the environment, roughness, metalness, emission or transmission changed"
            ),
            Self::Settings => write!(
                formatter,
                "settings: geometry, materials, lights and camera are equal; render settings, inputs beside the scene or the version of Rayframe changed"
            ),
            Self::Background => write!(
                formatter,
                "background: the plate behind the scene, or whether the environment shows, changed"
            ),
            Self::ClipPlanes => write!(formatter, "camera: its clip planes changed"),
            Self::Encoding => write!(
                formatter,
                "encoding: one image holds linear light, the other display values, which exposure and a tone curve change; compare images of one kind"
            ),
            Self::Noise => write!(formatter, "noise: the differences are unstructured"),
            Self::Unclear { share } => {
                let percent = share * 100.0;
                write!(
                    formatter,
                    "unclear: {percent:.2} % of pixels differ in brightness; layers object_id, material_id and albedo would tell the cause"
                )
            }
        }
    }
}

/// The likely cause of the differences between two images of one size. `layers` are the layers of both images, with the numbers of
/// pixels that differ beyond the limits.
pub fn likely_cause(actual: &Image, reference: &Image, layers: &[LayerDifference]) -> Option<Cause> {
    let evidence = Evidence::of(actual, reference, layers);
    match changed_parts(&actual.scene, &reference.scene) {
        // Only ids have other numbers.
        Some(changes) if changes.is_empty() && evidence.has_equal_colors() => None,
        Some(changes) => Some(known_cause(&changes, &evidence)),
        None => inferred_cause(&evidence),
    }
}

/// What the pixels tell.
struct Evidence<'a> {
    images: [&'a Image; 2],
    /// Tone-mapped luminance of both, where there are colours.
    greys: Option<[Vec<f32>; 2]>,
    layers: &'a [LayerDifference],
}

impl<'a> Evidence<'a> {
    fn of(actual: &'a Image, reference: &'a Image, layers: &'a [LayerDifference]) -> Self {
        let grey = |image: &Image| image.colors().map(|colors| tone_mapped(&colors));
        let greys = grey(actual).zip(grey(reference)).map(|(actual, reference)| [actual, reference]);
        Self { images: [actual, reference], greys, layers }
    }

    /// The first of `names` that is a layer which differs beyond its limits, and the number of pixels.
    fn differing(&self, names: &[&str]) -> Option<(String, usize)> {
        let found =
            |name: &&str| self.layers.iter().find(|layer| layer.layer == *name && layer.different_pixels > 0);
        names.iter().find_map(found).map(|layer| (layer.layer.clone(), layer.different_pixels))
    }

    /// Whether both images have values of one of the layers that can be compared.
    fn has(&self, names: &[&str]) -> bool {
        let mut layers = self.layers.iter().filter(|layer| !layer.channels.is_empty());
        layers.any(|layer| names.contains(&layer.layer.as_str()))
    }

    /// Whether a value of a layer differs at all. Ids that have other numbers alone do not.
    fn differs_at_all(&self, names: &[&str]) -> bool {
        let layers = self.layers.iter().filter(|layer| names.contains(&layer.layer.as_str()));
        layers.flat_map(|layer| &layer.channels).any(|channel| channel.largest > 0.0)
    }

    fn has_equal_colors(&self) -> bool {
        self.greys.as_ref().is_some_and(|[actual, reference]| actual == reference)
    }

    /// The displacement that explains most of the difference.
    fn displacement(&self) -> Option<(f64, f64)> {
        let [actual, reference] = self.greys.as_ref()?;
        let shift = best_shift(actual, reference, self.images[1].size())?;
        let is_cause =
            shift.explained >= EXPLAINED_BY_SHIFT && shift.right.abs() + shift.down.abs() >= LEAST_SHIFT;
        is_cause.then_some((shift.right, shift.down))
    }

    /// The factors on light that explain most of the difference.
    fn factors(&self) -> Option<[f64; 3]> {
        let [actual, reference] = self.images.map(|image| image.clone().into_linear().colors());
        light_factors(&actual?, &reference?)
    }

    /// Whether both cameras come from there.
    fn has_cameras_of(&self, origin: CameraOrigin) -> bool {
        let is_from =
            |image: &Image| image.scene.parts.as_ref().and_then(|parts| parts.camera) == Some(origin);
        self.images.into_iter().all(is_from)
    }

    /// Whether the files tell that clips of the image changed.
    fn has_other_clips(&self) -> bool {
        let [actual, reference] = self.images.map(|image| image.scene.content.as_ref());
        actual
            .zip(reference)
            .is_some_and(|(actual, reference)| !actual.alterations_since(reference).is_empty())
    }

    /// The cause where the camera changed, and `others` that may as well be the cause.
    fn camera(&self, others: bool) -> Cause {
        match self.displacement().unzip() {
            (None, None) if others => self.unclear(),
            _ if self.has_cameras_of(CameraOrigin::Framed) && self.has_other_clips() => {
                Cause::CameraFollowsClip
            }
            (right, down) => Cause::Camera { right, down },
        }
    }

    /// The cause without any that could be told.
    fn unclear(&self) -> Cause {
        let pixels = self.greys.as_ref().map_or(&[][..], |[actual, _]| actual);
        let others = self.greys.iter().flat_map(|[_, reference]| reference);
        let different = pixels.iter().zip(others).filter(|(actual, reference)| actual != reference).count();
        Cause::Unclear { share: different as f64 / pixels.len().max(1) as f64 }
    }

    fn geometry(&self) -> Cause {
        let (layer, pixels) = self.differing(&GEOMETRY).unzip();
        Cause::Geometry { layer, pixels: pixels.unwrap_or(0) }
    }

    fn material(&self) -> Cause {
        let (layer, pixels) = self.differing(&MATERIAL).unzip();
        Cause::Material { layer, pixels: pixels.unwrap_or(0), materials: Vec::new() }
    }
}

/// The cause where the files tell what changed.
fn known_cause(changes: &[Part], evidence: &Evidence<'_>) -> Cause {
    let [camera, geometry, materials, lights, background] =
        [Part::Camera, Part::Geometry, Part::Materials, Part::Lights, Part::Background]
            .map(|part| changes.contains(&part));
    // Vertex colours count as a material.
    let (vertex_colors, of_materials) = (changes.contains(&Part::VertexColors), materials);
    let materials = materials || vertex_colors;
    let others = materials || lights || background;
    // Of several changes only layers tell which one the pixels show.
    if geometry && !camera && others && !evidence.has(&GEOMETRY) {
        return evidence.unclear();
    }
    // A camera of the file moves by itself, and another export may have another order of vertices.
    if geometry && camera && evidence.has_cameras_of(CameraOrigin::File) {
        return match evidence.displacement() {
            None if !others => Cause::CameraOrGeometry,
            _ => evidence.camera(others),
        };
    }
    // The automatic camera follows the geometry. Of other changes, those of geometry move edges.
    if geometry && (camera || !others || evidence.differs_at_all(&GEOMETRY)) {
        return if camera { Cause::Geometry { layer: None, pixels: 0 } } else { evidence.geometry() };
    }
    if camera {
        return evidence.camera(others);
    }
    match (materials, lights, background) {
        (true, true, false) => Cause::MaterialOrLight,
        (true, false, false) if of_materials => evidence.material(),
        (true, false, false) => Cause::VertexColors,
        (false, true, false) => Cause::Light { factors: evidence.factors() },
        (false, false, true) => Cause::Background,
        (_, _, true) => evidence.unclear(),
        (false, false, false) if changes.contains(&Part::ClipPlanes) => Cause::ClipPlanes,
        (false, false, false) => Cause::Settings,
    }
}

/// The cause that the pixels suggest.
fn inferred_cause(evidence: &Evidence<'_>) -> Option<Cause> {
    let [actual, reference] = evidence.images;
    // The same camera displaces nothing.
    let cameras = actual.scene.camera.as_ref().zip(reference.scene.camera.as_ref());
    let may_have_moved = cameras.is_none_or(|(actual, reference)| has_moved(actual, reference));
    if may_have_moved && let Some((right, down)) = evidence.displacement() {
        return Some(Cause::Camera { right: Some(right), down: Some(down) });
    }
    if evidence.differing(&GEOMETRY).is_some() {
        return Some(evidence.geometry());
    }
    if evidence.differing(&MATERIAL).is_some() {
        return Some(evidence.material());
    }
    let [actual_grey, reference_grey] = evidence.greys.as_ref()?;
    let differences: Vec<f64> =
        actual_grey.iter().zip(reference_grey).map(|(a, b)| f64::from(*a) - f64::from(*b)).collect();
    if differences.iter().all(|&difference| difference == 0.0) {
        return None;
    }
    if is_noise(&differences, reference.size().0 as usize) {
        return Some(Cause::Noise);
    }
    let factors = evidence.factors();
    let has_surfaces = evidence.has(&GEOMETRY) || evidence.has(&MATERIAL);
    // Factors may as well be those of a material, unless its colour is known to be equal.
    if has_surfaces && (factors.is_none() || !evidence.has(&["albedo"])) {
        return Some(Cause::MaterialOrLight);
    }
    if factors.is_some() {
        return Some(Cause::Light { factors });
    }
    Some(evidence.unclear())
}

/// Tone-mapped luminance between 0 and 1. Values that are not finite become 0.
fn tone_mapped(colors: &[[f32; 3]]) -> Vec<f32> {
    let grey = |color: &[f32; 3]| {
        let light = luminance(glam::Vec3::from_array(*color));
        if light.is_finite() && light > 0.0 { (light / (1.0 + light)).sqrt() } else { 0.0 }
    };
    colors.iter().map(grey).collect()
}

/// Whether differences spread over the image, centre on zero and do not correlate with their neighbours.
fn is_noise(differences: &[f64], width: usize) -> bool {
    let square: f64 = differences.iter().map(|difference| difference * difference).sum();
    let sum: f64 = differences.iter().sum();
    let different = differences.iter().filter(|difference| **difference != 0.0).count();
    let correlation = |step: usize| {
        let products = differences.iter().zip(differences.iter().skip(step)).map(|(a, b)| a * b);
        products.sum::<f64>() / square
    };
    let is_spread = different as f64 >= LEAST_NOISE * differences.len() as f64;
    let is_centred = sum * sum <= 0.05 * square * differences.len() as f64;
    is_spread
        && is_centred
        && correlation(1).abs() <= LARGEST_CORRELATION
        && correlation(width).abs() <= LARGEST_CORRELATION
}

/// The factor on each colour with the least squared error, if the factors explain most of the difference.
fn light_factors(actual: &[[f32; 3]], reference: &[[f32; 3]]) -> Option<[f64; 3]> {
    let (mut cross, mut square, mut before, mut actual_square) = ([0.0; 3], [0.0; 3], 0.0, [0.0; 3]);
    for (ours, theirs) in actual.iter().zip(reference) {
        for channel in 0..3 {
            let (ours, theirs) = (f64::from(ours[channel]), f64::from(theirs[channel]));
            if ours.is_finite() && theirs.is_finite() {
                cross[channel] += ours * theirs;
                square[channel] += theirs * theirs;
                actual_square[channel] += ours * ours;
                before += (ours - theirs) * (ours - theirs);
            }
        }
    }
    let factors =
        [0, 1, 2].map(|channel| if square[channel] > 0.0 { cross[channel] / square[channel] } else { 1.0 });
    let after: f64 = (0..3).map(|channel| actual_square[channel] - factors[channel] * cross[channel]).sum();
    (before > 0.0 && after <= (1.0 - EXPLAINED_BY_LIGHT) * before).then_some(factors)
}

#[cfg(test)]
mod tests;
