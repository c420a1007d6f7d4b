//! Keyframe interpolation: step, linear, spherical linear and cubic Hermite (glTF 2.0, appendix C).

use std::ops::RangeInclusive;

use glam::{Quat, Vec3};

use crate::scene::{
    AnimationTarget, ImageLight, ImageLightPose, ImageLightProperty, Interpolation, Keyframes, Light,
    LocalTransform, Material, Projection, Scene, Selection, set_camera, set_light, set_material,
};

/// All animatable properties of a scene at one time.
#[derive(Clone, Debug, Default)]
pub(super) struct ScenePose {
    /// Local transforms, by [`crate::scene::NodeIndex`].
    pub(super) local: Vec<LocalTransform>,
    /// Whether the node itself is hidden, by [`crate::scene::NodeIndex`].
    pub(super) hidden: Vec<bool>,
    /// Animated morph weights of nodes; `None` keeps the node's or mesh's own.
    pub(super) weights: Vec<Option<Vec<f32>>>,
    /// Animated morph weights of meshes; `None` keeps the mesh's own.
    pub(super) mesh_weights: Vec<Option<Vec<f32>>>,
    /// Morph weights that are animated individually.
    single_weights: Vec<(AnimationTarget, f32)>,
    /// By [`crate::scene::ImageLightIndex`].
    pub(super) image_lights: Vec<ImageLightPose>,
    /// By [`crate::scene::LightIndex`].
    pub(super) lights: Vec<Light>,
    /// By [`crate::scene::CameraIndex`].
    pub(super) projections: Vec<Projection>,
}

impl ScenePose {
    /// Resets all properties, then plays the selected clips. Animated materials are written to `materials`.
    pub(super) fn play(
        &mut self,
        scene: &Scene,
        selection: &Selection,
        time_seconds: f64,
        materials: &mut Vec<Material>,
    ) {
        self.local.clear();
        self.local.extend(scene.nodes.iter().map(|node| node.local));
        self.hidden.clear();
        self.hidden.extend(scene.nodes.iter().map(|node| node.is_hidden));
        self.weights.clear();
        self.weights.resize(scene.nodes.len(), None);
        self.mesh_weights.clear();
        self.mesh_weights.resize(scene.meshes.len(), None);
        self.lights.clone_from(&scene.lights);
        self.projections.clear();
        self.projections.extend(scene.cameras.iter().map(|camera| camera.projection));
        self.single_weights.clear();
        self.image_lights.clear();
        self.image_lights.extend(scene.image_lights.iter().map(ImageLight::pose));
        materials.clone_from(&scene.materials);
        for &clip in &selection.clips {
            for channel in &scene.animations[clip.index()].channels {
                self.apply(channel.target, &channel.keyframes, time_seconds, materials);
            }
        }
        self.apply_single_weights(scene);
    }

    /// Applies individually animated weights of meshes, then of nodes, on top of the other weights.
    fn apply_single_weights(&mut self, scene: &Scene) {
        for &(target, value) in &self.single_weights {
            if let AnimationTarget::MeshWeight(mesh, target_index) = target {
                let rest = &scene.meshes[mesh.index()].weights;
                let weights = self.mesh_weights[mesh.index()].get_or_insert_with(|| rest.clone());
                weights[target_index as usize] = value;
            }
        }
        for &(target, value) in &self.single_weights {
            if let AnimationTarget::Weight(node, target_index) = target
                && let Some(mesh) = scene.nodes[node.index()].mesh
            {
                let own = scene.nodes[node.index()].weights.as_ref();
                let rest = own.or(self.mesh_weights[mesh.index()].as_ref());
                let rest = rest.unwrap_or(&scene.meshes[mesh.index()].weights);
                let weights = self.weights[node.index()].get_or_insert_with(|| rest.clone());
                weights[target_index as usize] = value;
            }
        }
    }

    fn apply(
        &mut self,
        target: AnimationTarget,
        keyframes: &Keyframes,
        time_seconds: f64,
        materials: &mut [Material],
    ) {
        let values = || -> Vec<f32> {
            (0..keyframes.width).map(|i| component_at(keyframes, time_seconds, i)).collect()
        };
        match target {
            AnimationTarget::Translation(node) => {
                if let LocalTransform::Trs { translation, .. } = &mut self.local[node.index()] {
                    *translation = vec3_at(keyframes, time_seconds);
                }
            }
            AnimationTarget::Rotation(node) => {
                if let LocalTransform::Trs { rotation, .. } = &mut self.local[node.index()] {
                    *rotation = rotation_at(keyframes, time_seconds);
                }
            }
            AnimationTarget::Scale(node) => {
                if let LocalTransform::Trs { scale, .. } = &mut self.local[node.index()] {
                    *scale = vec3_at(keyframes, time_seconds);
                }
            }
            AnimationTarget::Weights(node) => self.weights[node.index()] = Some(values()),
            AnimationTarget::MeshWeights(mesh) => self.mesh_weights[mesh.index()] = Some(values()),
            AnimationTarget::Weight(..) | AnimationTarget::MeshWeight(..) => {
                self.single_weights.push((target, component_at(keyframes, time_seconds, 0)));
            }
            AnimationTarget::ImageLight(light, ImageLightProperty::Intensity) => {
                let intensity = component_at(keyframes, time_seconds, 0);
                self.image_lights[light.index()].intensity = if intensity > 0.0 { intensity } else { 0.0 };
            }
            AnimationTarget::ImageLight(light, ImageLightProperty::Rotation) => {
                self.image_lights[light.index()].rotation = rotation_at(keyframes, time_seconds);
            }
            AnimationTarget::Visibility(node) => {
                self.hidden[node.index()] = component_at(keyframes, time_seconds, 0) == 0.0;
            }
            AnimationTarget::Material(material, property) => {
                let values = clamped(values(), &property.range());
                set_material(&mut materials[material.index()], property, &values);
            }
            AnimationTarget::Light(light, property) => {
                let values = clamped(values(), &property.range());
                set_light(&mut self.lights[light.index()], property, &values);
            }
            AnimationTarget::Camera(camera, property) => {
                let values = clamped(values(), &property.range());
                set_camera(&mut self.projections[camera.index()], property, values[0]);
            }
        }
    }
}

/// Clamps values to the range of a property. Keys lie in the range, but splines between them may leave it.
fn clamped(mut values: Vec<f32>, range: &RangeInclusive<f32>) -> Vec<f32> {
    for value in &mut values {
        *value = value.clamp(*range.start(), *range.end());
    }
    values
}

/// Time by which a step takes effect before its key, over the time: rounding errors of some hundred frames.
const STEP_TOLERANCE: f64 = 32.0 * f32::EPSILON as f64;
/// The most of it, seconds: a small part of a frame.
const MAX_STEP_TOLERANCE: f64 = 1e-3;

/// The interval between two keys that contains a time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct KeySpan {
    /// Index of the key before the time.
    key: usize,
    /// Duration up to the next key.
    seconds: f32,
    /// Fraction of the duration that has passed.
    share: f32,
}

/// The span of a time. Times before the first key and after the last one clamp to those keys.
///
/// The time is rounded to `f32` as the keys are, so that a frame at the time of a key matches it exactly.
///
/// Exporters also round key times more than once, or add up the durations of frames. So a step takes effect up to [`STEP_TOLERANCE`] early.
fn span_at(keyframes: &Keyframes, time_seconds: f64) -> KeySpan {
    let times_seconds = &keyframes.times_seconds;
    let rounded = f64::from(time_seconds as f32);
    let time_seconds = match keyframes.interpolation {
        Interpolation::Step => rounded + (rounded * STEP_TOLERANCE).clamp(0.0, MAX_STEP_TOLERANCE),
        Interpolation::Linear | Interpolation::CubicSpline => rounded,
    };
    let after = times_seconds.partition_point(|&key_time| f64::from(key_time) <= time_seconds);
    if after == 0 {
        return KeySpan { key: 0, seconds: 0.0, share: 0.0 };
    }
    let key = after - 1;
    if after == times_seconds.len() {
        return KeySpan { key, seconds: 0.0, share: 0.0 };
    }
    let seconds = f64::from(times_seconds[after]) - f64::from(times_seconds[key]);
    let share = (time_seconds - f64::from(times_seconds[key])) / seconds;
    KeySpan { key, seconds: seconds as f32, share: share as f32 }
}

/// One component of a value, interpolated independently of the others.
fn component_at(keyframes: &Keyframes, time_seconds: f64, component: usize) -> f32 {
    let span = span_at(keyframes, time_seconds);
    let width = keyframes.width;
    match keyframes.interpolation {
        Interpolation::Step => keyframes.values[span.key * width + component],
        Interpolation::Linear => {
            let a = keyframes.values[span.key * width + component];
            if span.share == 0.0 {
                return a;
            }
            let b = keyframes.values[(span.key + 1) * width + component];
            a + (b - a) * span.share
        }
        Interpolation::CubicSpline => {
            // Each key stores in-tangent, value and out-tangent.
            let stored = |key: usize, part: usize| keyframes.values[(key * 3 + part) * width + component];
            let v0 = stored(span.key, 1);
            if span.share == 0.0 {
                return v0;
            }
            let v1 = stored(span.key + 1, 1);
            let out0 = stored(span.key, 2) * span.seconds;
            let in1 = stored(span.key + 1, 0) * span.seconds;
            hermite(span.share, [v0, out0, v1, in1])
        }
    }
}

/// Cubic Hermite spline from `v0` with slope `m0` at s = 0 to `v1` with slope `m1` at s = 1.
fn hermite(s: f32, [v0, m0, v1, m1]: [f32; 4]) -> f32 {
    let s2 = s * s;
    let s3 = s2 * s;
    (2.0 * s3 - 3.0 * s2 + 1.0) * v0 + (s3 - 2.0 * s2 + s) * m0 + (3.0 * s2 - 2.0 * s3) * v1 + (s3 - s2) * m1
}

fn vec3_at(keyframes: &Keyframes, time_seconds: f64) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|i| component_at(keyframes, time_seconds, i)))
}

/// A rotation. Linear interpolation follows the shorter arc; splines are normalised and never flipped.
fn rotation_at(keyframes: &Keyframes, time_seconds: f64) -> Quat {
    let span = span_at(keyframes, time_seconds);
    if keyframes.interpolation == Interpolation::Linear && span.share > 0.0 {
        let key = |k: usize| Quat::from_slice(&keyframes.values[k * 4..k * 4 + 4]);
        return slerp(normalized(key(span.key)), normalized(key(span.key + 1)), span.share);
    }
    normalized(Quat::from_array([0, 1, 2, 3].map(|i| component_at(keyframes, time_seconds, i))))
}

fn normalized(q: Quat) -> Quat {
    // The squares of long ones overflow.
    let q = if q.length().is_infinite() { q * 1e-20 } else { q };
    let length = q.length();
    if length > 0.0 { q * (1.0 / length) } else { Quat::IDENTITY }
}

/// Spherical interpolation of unit quaternions along the shorter arc.
fn slerp(q0: Quat, q1: Quat, share: f32) -> Quat {
    /// Above this cosine the sine in the divisor loses precision, and the chord is as accurate as the arc.
    const NEARLY_PARALLEL: f32 = 0.9999;
    let dot = q0.dot(q1);
    let cosine = dot.abs();
    let q1 = if dot < 0.0 { -q1 } else { q1 };
    if cosine > NEARLY_PARALLEL {
        return normalized(q0 * (1.0 - share) + q1 * share);
    }
    let angle = libm::acosf(cosine);
    let w0 = libm::sinf(angle * (1.0 - share));
    let w1 = libm::sinf(angle * share);
    normalized(q0 * w0 + q1 * w1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keyframes(width: usize, values: Vec<f32>, interpolation: Interpolation) -> Keyframes {
        Keyframes { times_seconds: vec![1.0, 3.0], values, width, interpolation }
    }

    #[test]
    fn times_outside_the_keys_clamp() {
        let linear = keyframes(1, vec![2.0, 6.0], Interpolation::Linear);
        assert_eq!(component_at(&linear, 0.0, 0), 2.0);
        assert_eq!(component_at(&linear, 9.0, 0), 6.0);
        assert_eq!(component_at(&linear, 1.5, 0), 3.0);
    }

    #[test]
    fn a_step_holds_until_the_next_key() {
        let step = keyframes(1, vec![2.0, 6.0], Interpolation::Step);
        assert_eq!(component_at(&step, 2.999, 0), 2.0);
        assert_eq!(component_at(&step, 3.0, 0), 6.0);
    }

    #[test]
    fn two_keys_of_one_time_are_a_sudden_change() {
        let keys = |interpolation| Keyframes {
            times_seconds: vec![0.0, 1.0, 1.0, 2.0],
            values: vec![0.0, 1.0, 5.0, 6.0],
            width: 1,
            interpolation,
        };
        let linear = keys(Interpolation::Linear);
        let values = [0.5, 1.0, 1.5].map(|seconds| component_at(&linear, seconds, 0));
        assert_eq!(values, [0.5, 5.0, 5.5]);
        assert_eq!(component_at(&keys(Interpolation::Step), 1.0, 0), 5.0);
    }

    #[test]
    fn time_0_is_among_keys_before_and_after_it() {
        let start = |times_seconds: [f32; 2], values: &[f32], interpolation| {
            let (times_seconds, values) = (times_seconds.to_vec(), values.to_vec());
            component_at(&Keyframes { times_seconds, values, width: 1, interpolation }, 0.0, 0)
        };
        assert_eq!(start([-1.0, 3.0], &[2.0, 6.0], Interpolation::Step), 2.0);
        assert_eq!(start([-1.0, 3.0], &[2.0, 6.0], Interpolation::Linear), 3.0);
        // In the middle of two seconds an out-tangent of 1 adds (1/8 − 1/2 + 1/2) · 2 · 1 = 1/4.
        assert_eq!(start([-1.0, 1.0], &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], Interpolation::CubicSpline), 0.25);
        // All keys are over.
        assert_eq!(start([-3.0, -1.0], &[2.0, 6.0], Interpolation::Step), 6.0);
        assert_eq!(start([-3.0, -1.0], &[2.0, 6.0], Interpolation::Linear), 6.0);
        assert_eq!(start([-3.0, -1.0], &[0.0, 2.0, 0.0, 0.0, 6.0, 0.0], Interpolation::CubicSpline), 6.0);
    }

    #[test]
    fn a_frame_on_a_key_matches_it_though_the_key_was_rounded_up() {
        let times_seconds: Vec<f32> = (0..100).map(|frame| frame as f32 / 24.0).collect();
        let values = (0..100).map(|frame| frame as f32).collect();
        let step = Keyframes { times_seconds, values, width: 1, interpolation: Interpolation::Step };
        for frame in 0..100 {
            assert_eq!(component_at(&step, f64::from(frame) / 24.0, 0), frame as f32);
        }
    }

    #[test]
    fn steps_follow_key_times_that_were_rounded_more_than_once() {
        let by_product: Vec<f32> = (0..1000).map(|frame| frame as f32 * (1.0 / 30.0)).collect();
        let by_sum = std::iter::successors(Some(0.0_f32), |time| Some(time + 1.0 / 24.0)).take(300).collect();
        for (rate, times_seconds) in [(30.0, by_product), (24.0, by_sum)] {
            let values = (0..times_seconds.len()).map(|frame| frame as f32).collect();
            let step = Keyframes { times_seconds, values, width: 1, interpolation: Interpolation::Step };
            for frame in 0..step.times_seconds.len() {
                assert_eq!(component_at(&step, frame as f64 / rate, 0), frame as f32);
                // Not before a tenth of a frame is left.
                let before = (frame as f64 - 0.1).max(0.0) / rate;
                assert_eq!(component_at(&step, before, 0), frame.saturating_sub(1) as f32);
            }
        }
        // An hour is no reason to be early.
        let late = Keyframes {
            times_seconds: vec![0.0, 4500.0],
            values: vec![0.0, 1.0],
            width: 1,
            interpolation: Interpolation::Step,
        };
        let values = [269_999.0, 270_000.0].map(|frame| component_at(&late, frame / 60.0, 0));
        assert_eq!(values, [0.0, 1.0]);
    }

    #[test]
    fn the_cubic_spline_scales_its_tangents_by_the_key_distance() {
        // v0 = 0 with out-tangent 1/s, v1 = 0 with in-tangent 0, two seconds apart. At s = 1/2:
        // (s³ − 2s² + s) · td · out0 = (1/8 − 1/2 + 1/2) · 2 · 1 = 1/4.
        let cubic = keyframes(1, vec![0.0, 0.0, 1.0, 0.0, 0.0, 0.0], Interpolation::CubicSpline);
        assert_eq!(component_at(&cubic, 2.0, 0), 0.25);
        // The in-tangent of the second key: (s³ − s²) · td · in1 = −1/8 · 2 · 4 = −1.
        let cubic = keyframes(1, vec![0.0, 0.0, 0.0, 4.0, 0.0, 0.0], Interpolation::CubicSpline);
        assert_eq!(component_at(&cubic, 2.0, 0), -1.0);
        // Equal values with zero tangents are constant: 2s³ − 3s² + 1 + 3s² − 2s³ = 1.
        let cubic = keyframes(1, vec![0.0, 5.0, 0.0, 0.0, 5.0, 0.0], Interpolation::CubicSpline);
        assert_eq!(component_at(&cubic, 1.7, 0), 5.0);
    }

    #[test]
    fn linear_rotations_take_the_shorter_arc() {
        // From no rotation to −90° about Y, stored with the opposite sign: half way is 45°, not 45° + 180°.
        let half = std::f32::consts::FRAC_PI_4;
        let q1 = [0.0, -libm::sinf(half), 0.0, -libm::cosf(half)];
        let values = [[0.0, 0.0, 0.0, 1.0], q1].concat();
        let rotation = rotation_at(&keyframes(4, values, Interpolation::Linear), 2.0);
        let expected = Quat::from_xyzw(0.0, libm::sinf(half / 2.0), 0.0, libm::cosf(half / 2.0));
        assert!(rotation.dot(expected).abs() > 1.0 - 1e-6, "{rotation} is not {expected}");
    }

    #[test]
    fn cubic_rotations_are_normalised_and_not_flipped() {
        // Values q and −q with zero tangents cancel half way; a quarter of the way
        // 2s³ − 3s² + 1 = 27/32, so the sum is (27/32 − 5/32) q, which normalises to q.
        let q = [0.0, 0.6, 0.0, 0.8];
        let zero = [0.0; 4];
        let values = [zero, q, zero, zero, q.map(|c| -c), zero].concat();
        let rotation = rotation_at(&keyframes(4, values, Interpolation::CubicSpline), 1.5);
        assert!(rotation.abs_diff_eq(Quat::from_array(q), 1e-6), "{rotation}");
        assert!(normalized(Quat::from_array(q.map(|c| c * 3e38))).abs_diff_eq(Quat::from_array(q), 1e-6));
    }

    #[test]
    fn slerp_moves_at_constant_speed() {
        let q0 = Quat::IDENTITY;
        let q1 = Quat::from_xyzw(0.0, 0.0, 1.0, 0.0); // 180° about Z
        let third = slerp(q0, q1, 1.0 / 3.0); // 60°: half angle 30°
        assert!((third.w - libm::cosf(std::f32::consts::FRAC_PI_6)).abs() < 1e-6);
        assert!((third.z - 0.5).abs() < 1e-6);
    }
}
