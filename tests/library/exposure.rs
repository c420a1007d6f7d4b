//! The automatic exposure of moving scenes.

use std::path::Path;

use glam::Vec3;
use rayframe::cancel::CancelFlag;
use rayframe::framing::resolve_camera;
use rayframe::scene::{AnimationTarget, LightIndex, LightKind, LightProperty, SelectedCamera, ViewRequest};
use rayframe::sequence::exposure_ev;

use crate::stage::{Stage, animate_by_keys, lambert, rectangle, select_all, sequence_job};

/// The exposure of a floor below a lamp that pulses once a second for some whole seconds and is dark between them.
#[expect(clippy::unwrap_used, reason = "nothing raises the cancel flag")]
fn exposure_of_pulses(seconds: u16) -> f32 {
    let mut stage = Stage::new();
    stage.add(rectangle(Vec3::ZERO, Vec3::Z, Vec3::X), lambert(Vec3::splat(0.5)));
    stage.add_light(LightKind::Point, 60.0, Vec3::Y, Vec3::NEG_Y);
    let keys: Vec<(f32, [f32; 1])> = (0..=2 * seconds)
        .map(|half| (f32::from(half) * 0.5, [if half % 2 == 0 { 0.1 } else { 60.0 }]))
        .collect();
    let keys: Vec<(f32, &[f32])> = keys.iter().map(|(seconds, value)| (*seconds, value.as_slice())).collect();
    let target = AnimationTarget::Light(LightIndex(0), LightProperty::Intensity);
    animate_by_keys(&mut stage.scene, target, &keys);
    let selection = select_all(&stage.scene, SelectedCamera::Auto);
    let camera =
        resolve_camera(&stage.scene, selection, &ViewRequest::default(), 16.0 / 9.0).selection.camera;
    let job = sequence_job(stage.scene, camera, (16, 9), Path::new("unused.png"));
    exposure_ev(&job, &CancelFlag::new()).unwrap()
}

#[test]
fn the_length_of_a_clip_does_not_decide_about_a_pulsing_lamp() {
    // Three pulses at five even times were one exposure, four another, which saw the dark alone: 5 stops apart.
    let expected = exposure_of_pulses(30);
    for seconds in [2, 3, 4, 8, 12, 16, 32] {
        let exposure = exposure_of_pulses(seconds);
        assert!((exposure - expected).abs() < 0.7, "{seconds} s: {exposure}, 30 s: {expected}");
    }
}
