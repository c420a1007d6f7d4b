//! Order of animated values: the cones of spots, and the near and far planes of cameras.
//!
//! Source: the text of `KHR_lights_punctual`; glTF 2.0 specification, section 3.10 (cameras). The values are compared at the keyframes of
//! each animation, and just before them, where values jump; a property that no animation animates has its value in the file. Two animations of one
//! light or camera, which may play together or alone, are not compared.

use std::collections::{BTreeMap, BTreeSet};

use super::camera::check_planes;
use super::context::Context;
use super::light::check_cones;
use crate::error::Result;
use crate::scene::{
    Animation, AnimationTarget, Camera, CameraProperty, Interpolation, Keyframes, Light, LightKind,
    LightProperty, Projection,
};

/// Rounding errors of interpolated values, over the value.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// The channels of one animation.
#[derive(Debug)]
pub(super) struct ImportedChannels<'a> {
    pub(super) animation: &'a Animation,
    /// The properties of [`compared_properties`] of all animations.
    pub(super) animated: &'a BTreeSet<AnimationTarget>,
    /// JSON pointers of the outputs of the samplers of its channels.
    pub(super) outputs: &'a [String],
}

/// The properties that may be compared and that any of `animations` animates.
pub(super) fn compared_properties(animations: &[Animation]) -> BTreeSet<AnimationTarget> {
    let channels = animations.iter().flat_map(|animation| &animation.channels);
    channels.map(|channel| channel.target).filter(|target| is_compared(*target)).collect()
}

fn is_compared(target: AnimationTarget) -> bool {
    matches!(target, AnimationTarget::Light(..) | AnimationTarget::Camera(..))
}

/// A property during an animation.
#[derive(Clone, Copy, Debug)]
enum Values<'a> {
    Animated(&'a Keyframes),
    Static(f32),
}

impl ImportedChannels<'_> {
    /// Warns of inner cones that are wider than the outer ones. Errors on far planes that are not beyond the near ones.
    pub(super) fn check_order(
        &self,
        context: &mut Context,
        lights: &[Light],
        cameras: &[Camera],
    ) -> Result<()> {
        let channels = self.animation.channels.iter().zip(self.outputs);
        let compared = channels.filter(|pair| is_compared(pair.0.target));
        let keyframes: BTreeMap<_, _> =
            compared.clone().map(|(channel, _)| (channel.target, &channel.keyframes)).collect();
        // What another animation alone animates has no value of its own here.
        let values = |target, at_rest| match keyframes.get(&target) {
            Some(keyframes) => Some(Values::Animated(keyframes)),
            None => (!self.animated.contains(&target)).then_some(Values::Static(at_rest)),
        };
        for (channel, output) in compared {
            match channel.target {
                AnimationTarget::Light(light, LightProperty::InnerCone | LightProperty::OuterCone) => {
                    let kind = lights.get(light.index()).map(|light| light.kind);
                    if let Some(LightKind::Spot { inner_cone_radians, outer_cone_radians }) = kind {
                        let of = |property, value| values(AnimationTarget::Light(light, property), value);
                        let inner = of(LightProperty::InnerCone, inner_cone_radians);
                        let outer = of(LightProperty::OuterCone, outer_cone_radians);
                        let is_wider = |inner: f32, outer: f32| inner > outer * (1.0 + ROUNDING);
                        let both = inner.zip(outer);
                        if let Some((inner, outer)) = both.and_then(|both| first_where(both, is_wider)) {
                            check_cones(context, inner, outer, output);
                        }
                    }
                }
                AnimationTarget::Camera(camera, CameraProperty::ZNear | CameraProperty::ZFar) => {
                    let projection = cameras.get(camera.index()).map(|camera| camera.projection);
                    let Some(
                        Projection::Perspective { z_near, z_far: Some(z_far), .. }
                        | Projection::Orthographic { z_near, z_far, .. },
                    ) = projection
                    else {
                        continue;
                    };
                    let of = |property, value| values(AnimationTarget::Camera(camera, property), value);
                    let (near, far) = (of(CameraProperty::ZNear, z_near), of(CameraProperty::ZFar, z_far));
                    let is_wrong = |near, far| far <= near;
                    let both = near.zip(far);
                    if let Some((near, far)) = both.and_then(|both| first_where(both, is_wrong)) {
                        check_planes(context, near, far, output)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl<'a> Values<'a> {
    fn times_seconds(self) -> &'a [f32] {
        match self {
            Self::Animated(keyframes) => &keyframes.times_seconds,
            Self::Static(_) => &[],
        }
    }

    /// The value at a time. A spline between keys counts as a line.
    fn at(self, time_seconds: f32) -> Option<f32> {
        let keyframes = match self {
            Self::Animated(keyframes) => keyframes,
            Self::Static(value) => return Some(value),
        };
        let Keyframes { times_seconds, values, interpolation, .. } = keyframes;
        let stored = |key: usize| match interpolation {
            Interpolation::CubicSpline => values.get(key.saturating_mul(3).saturating_add(1)).copied(),
            Interpolation::Step | Interpolation::Linear => values.get(key).copied(),
        };
        let next = times_seconds.partition_point(|&time| time <= time_seconds);
        let Some(key) = next.checked_sub(1) else { return stored(0) };
        let (a, start) = (stored(key)?, *times_seconds.get(key)?);
        match (times_seconds.get(next), stored(next)) {
            (Some(end), Some(b)) if *interpolation != Interpolation::Step => {
                Some(a + (b - a) * ((time_seconds - start) / (end - start)))
            }
            _ => Some(a),
        }
    }
}

/// The values of both at the first keyframe of either, or just before it, where `is_wrong`.
fn first_where((a, b): (Values, Values), is_wrong: impl Fn(f32, f32) -> bool) -> Option<(f32, f32)> {
    let keys = || a.times_seconds().iter().chain(b.times_seconds()).copied();
    let mut times = keys().chain(keys().map(f32::next_down));
    times.find_map(|time| a.at(time).zip(b.at(time)).filter(|&(a, b)| is_wrong(a, b)))
}
