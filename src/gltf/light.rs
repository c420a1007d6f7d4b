//! Punctual lights.
//!
//! Source: the text of `KHR_lights_punctual`.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::Vec3;

use super::context::Context;
use super::document::Document;
use super::extension_names::LIGHTS;
use super::raw::{ANY, NOT_NEGATIVE, POSITIVE, Raw, TOLERANCE, without_rounding_below};
use crate::error::Result;
use crate::scene::{Light, LightIndex, LightKind};

/// Imports all lights.
pub(super) fn import(context: &mut Context, document: &Document) -> Result<Vec<Light>> {
    let Some(extension) = Raw::at(&document.value, format!("/extensions/{LIGHTS}")) else {
        return Ok(Vec::new());
    };
    extension.expect_object(context)?;
    let Some(lights) = extension.field("lights") else {
        return Err(context.invalid(format!("{}/lights", extension.pointer), "is missing"));
    };
    let lights = lights.elements(context)?;
    lights.iter().map(|light| import_light(context, light)).collect()
}

fn import_light(context: &mut Context, raw: &Raw) -> Result<Light> {
    raw.expect_object(context)?;
    let kind = match raw.string(context, "type")? {
        Some("directional") => LightKind::Directional,
        Some("point") => LightKind::Point,
        Some("spot") => spot(context, raw)?,
        _ => {
            let pointer = format!("{}/type", raw.pointer);
            return Err(context.invalid(pointer, "must be directional, point or spot"));
        }
    };
    let (color, intensity) = color_and_intensity(context, raw)?;
    let name = raw.string(context, "name")?.map(str::to_owned);
    Ok(Light { name, color, intensity, range: range(context, raw, kind)?, kind })
}

/// Warns of an intensity below 0.
pub(super) fn warn_of_negative_intensity(context: &mut Context, pointer: String, intensity: f32) {
    context.warn(pointer, format!("is {intensity}, and light cannot be negative; the lamp is off"));
}

/// Linear colour and intensity. Authoring tools write colours beyond 1 for brighter lamps, and negative intensities for lamps that take light away.
fn color_and_intensity(context: &mut Context, raw: &Raw) -> Result<(Vec3, f32)> {
    let color = Vec3::from_array(raw.numbers(context, "color", [1.0; 3], NOT_NEGATIVE)?);
    let intensity = without_rounding_below(raw.number(context, "intensity", 1.0, ANY)?, 0.0);
    if intensity < 0.0 {
        warn_of_negative_intensity(context, format!("{}/intensity", raw.pointer), intensity);
    }
    let (brightest, intensity) = (color.max_element(), intensity.max(0.0));
    if brightest <= 1.0 + TOLERANCE {
        return Ok((color.min(Vec3::ONE), intensity));
    }
    let message =
        format!("has a component of {brightest}, but must lie between 0 and 1; it is used as it is");
    context.warn(format!("{}/color", raw.pointer), message);
    Ok((color, intensity))
}

/// Range of a light, `None` where it is infinite. Directional lights have none; a value in the file is ignored.
fn range(context: &Context, raw: &Raw, kind: LightKind) -> Result<Option<f32>> {
    if kind == LightKind::Directional {
        return Ok(None);
    }
    Ok(raw.distance(context, "range", POSITIVE)?.filter(|range| range.is_finite()))
}

fn spot(context: &mut Context, raw: &Raw) -> Result<LightKind> {
    let Some(cone) = raw.field("spot") else {
        return Err(context.invalid(format!("{}/spot", raw.pointer), "is missing"));
    };
    cone.expect_object(context)?;
    let inner_cone_radians = cone.number(context, "innerConeAngle", 0.0, 0.0..=FRAC_PI_2)?;
    let outer_cone_radians = cone.number(context, "outerConeAngle", FRAC_PI_4, 0.0..=FRAC_PI_2)?;
    check_cones(context, inner_cone_radians, outer_cone_radians, &cone.pointer);
    // As read, since clips may animate the other one.
    Ok(LightKind::Spot { inner_cone_radians, outer_cone_radians })
}

/// Warns of an inner cone that is wider than the outer. Blender and three.js write equal cones for a spot without a soft edge. `pointer` names
/// the spot or the values of an animation.
pub(super) fn check_cones(context: &mut Context, inner_radians: f32, outer_radians: f32, pointer: &str) {
    if inner_radians > outer_radians {
        let message = format!(
            "the inner cone, {inner_radians}, must not be wider than the outer, {outer_radians}; the edge of the light is hard"
        );
        context.warn(pointer, message);
    }
}

/// The light of the node `raw`; the file has `light_count` lights.
pub(super) fn of_node(context: &Context, raw: &Raw, light_count: usize) -> Result<Option<LightIndex>> {
    Ok(raw.extension_light(context, LIGHTS, light_count, "light")?.map(LightIndex::of))
}
