//! Checks of keyframe values by the rules for the values of their properties in the file itself.
//!
//! Source: glTF 2.0 specification, sections 3.10 (cameras) and 3.11 (animations); the texts of `KHR_materials_ior` and
//! `KHR_materials_volume`. `animated_order` checks pairs of properties.

use std::ops::RangeInclusive;

use super::camera::warn_of_negative_magnification;
use super::context::Context;
use super::light::warn_of_negative_intensity;
use super::material::{distance_or_infinite, ior_or_one};
use super::raw::{TOLERANCE, UNIT, check_range, without_rounding_below};
use super::rotation::ZERO_LENGTH;
use crate::error::Result;
use crate::scene::{AnimationTarget, CameraProperty, ImageLightProperty, LightProperty, MaterialProperty};

/// Values of the keyframes of a channel. Tangents of cubic splines may lie outside the range of the property.
#[derive(Debug)]
pub(super) struct KeyValues<'a> {
    pub(super) values: &'a mut [f32],
    /// Components of one value.
    pub(super) components: usize,
    /// Values of one key: 1, or 3 with the tangents of a cubic spline, whose second is the value itself.
    pub(super) values_per_key: usize,
    /// JSON pointer of the sampler's output.
    pub(super) pointer: String,
}

impl KeyValues<'_> {
    /// Checks and repairs the values of `property`, whose components lie in `range`.
    pub(super) fn check(
        mut self,
        context: &mut Context,
        property: AnimationTarget,
        range: &RangeInclusive<f32>,
    ) -> Result<()> {
        if let AnimationTarget::Camera(_, CameraProperty::XMag | CameraProperty::YMag) = property {
            self.make_positive(context);
        }
        // Files have brighter ones.
        let may_be_brighter = matches!(
            property,
            AnimationTarget::Material(_, MaterialProperty::EmissiveFactor)
                | AnimationTarget::Light(_, LightProperty::Color)
        );
        self.check_ranges(context, range, may_be_brighter)?;
        match property {
            AnimationTarget::Material(_, MaterialProperty::Ior) => self.check_ior(context),
            AnimationTarget::Material(_, MaterialProperty::AttenuationDistance) => {
                self.make_zeros_infinite(context);
            }
            AnimationTarget::Light(_, LightProperty::Intensity) => self.check_intensity(context),
            AnimationTarget::Rotation(_) | AnimationTarget::ImageLight(_, ImageLightProperty::Rotation) => {
                self.check_rotations(context)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// The values without tangents, key by key.
    fn of_keys(&mut self) -> impl Iterator<Item = &mut [f32]> {
        let keys = self.values.chunks_mut(self.components.max(1));
        keys.skip(self.values_per_key / 2).step_by(self.values_per_key.max(1))
    }

    /// Checks that values lie in the range. Those of a property from 0 to 1 are clamped to it, with a warning.
    fn check_ranges(
        &mut self,
        context: &mut Context,
        range: &RangeInclusive<f32>,
        may_be_brighter: bool,
    ) -> Result<()> {
        let pointer = self.pointer.clone();
        // The value that is farthest beyond 0 to 1
        let mut farthest = 0.5_f32;
        for key in self.of_keys().flatten() {
            if *range != UNIT {
                check_range(context, *key, range, &pointer)?;
            }
            if (*range == UNIT || may_be_brighter) && (*key - 0.5).abs() > (farthest - 0.5).abs() {
                farthest = *key;
            }
            if *range == UNIT {
                *key = key.clamp(0.0, 1.0);
            }
        }
        if (farthest - 0.5).abs() > 0.5 + TOLERANCE {
            let consequence =
                if may_be_brighter { "they are used as they are" } else { "they are clamped to 0 and 1" };
            let message = format!("has values outside 0 to 1, such as {farthest}; {consequence}");
            context.warn(pointer, message);
        }
        Ok(())
    }

    /// Warns of the first index of refraction between 0 and 1. The pose takes these for 1, between keys as well.
    fn check_ior(&mut self, context: &mut Context) {
        let pointer = self.pointer.clone();
        let is_wrong = |ior: &f32| ior_or_one(context, *ior, &pointer) != *ior;
        self.of_keys().flatten().map(|ior| *ior).find(is_wrong);
    }

    /// Warns of the first negative intensity. The pose takes these for 0.
    fn check_intensity(&mut self, context: &mut Context) {
        let pointer = self.pointer.clone();
        if let Some(&mut intensity) =
            self.of_keys().flatten().find(|intensity| without_rounding_below(**intensity, 0.0) < 0.0)
        {
            warn_of_negative_intensity(context, pointer, intensity);
        }
    }

    /// Takes attenuation distances of 0 for infinite: the largest number, as keys are interpolated.
    fn make_zeros_infinite(&mut self, context: &mut Context) {
        let pointer = self.pointer.clone();
        for distance in self.of_keys().flatten() {
            *distance = distance_or_infinite(context, *distance, &pointer).min(f32::MAX);
        }
    }

    /// Takes negative magnifications as positive, with their tangents.
    fn make_positive(&mut self, context: &mut Context) {
        let value = self.values_per_key / 2;
        for key in self.values.chunks_mut(self.values_per_key.max(1)) {
            if key.get(value).is_some_and(|&magnification| magnification < 0.0) {
                warn_of_negative_magnification(context, &self.pointer);
                for value in key {
                    *value = -*value;
                }
            }
        }
    }

    /// Errors on quaternions of length zero, which cannot be normalized. Tangents of cubic splines may be zero.
    fn check_rotations(&mut self, context: &Context) -> Result<()> {
        let is_zero = |q: &mut [f32]| q.iter().all(|component| component.abs() < ZERO_LENGTH);
        let zero = self.of_keys().position(is_zero);
        match zero {
            None => Ok(()),
            Some(i) => Err(context.invalid(
                &self.pointer,
                format!("keyframe {i} is a quaternion of length zero, which is not a rotation"),
            )),
        }
    }
}
