use super::*;

const POINTS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 1.0, 0.0], [4.0, 1.0, 9.0]];

fn times(period: Option<f64>) -> KeyTimes {
    KeyTimes { seconds: vec![1.0, 2.0, 4.0, 4.5], period }
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    distance(a, b) < 1e-9
}

#[test]
fn every_curve_passes_its_keys_at_their_times() {
    for kind in [CurveKind::Smooth, CurveKind::Linear] {
        for period in [None, Some(5.0)] {
            let point = KeyedPoint::new(times(period), kind, POINTS.to_vec());
            let value = KeyedValue::new(times(period), kind, vec![3.0, 1.0, 2.0, 2.0]);
            for (seconds, (expected, number)) in
                times(None).seconds.iter().zip(POINTS.iter().zip([3.0, 1.0, 2.0, 2.0]))
            {
                assert!(near(point.at(*seconds), *expected), "{kind:?} {period:?} at {seconds}");
                assert!((value.at(*seconds) - number).abs() < 1e-9, "{kind:?} {period:?} at {seconds}");
            }
        }
    }
}

#[test]
fn linear_midpoints_lie_in_the_middle_and_ends_are_held() {
    let point = KeyedPoint::new(times(None), CurveKind::Linear, POINTS.to_vec());
    assert_eq!(point.at(1.5), [2.0, 0.0, 0.0]);
    assert_eq!(point.at(3.0), [4.0, 0.5, 0.0]);
    assert_eq!((point.at(0.0), point.at(99.0)), (POINTS[0], POINTS[3]));
}

#[test]
fn a_smooth_midpoint_by_hand() {
    // Keys 0, 1 and 2 on a line, a second and a metre apart: knots 0, 1, 2; all slopes are 1, and so is the velocity.
    let line = |last: f64| vec![[0.0; 3], [1.0, 0.0, 0.0], [last, 0.0, 0.0]];
    let even = KeyTimes { seconds: vec![0.0, 1.0, 2.0], period: None };
    let point = KeyedPoint::new(even.clone(), CurveKind::Smooth, line(2.0));
    assert!(near(point.at(0.25), [0.25, 0.0, 0.0]) && near(point.at(1.5), [1.5, 0.0, 0.0]));
    // Key 2 at 5: gaps 1 and 2, so knots 0, 1, 3. Secants along the knots are 1 and 2; the tangent of key 1 is
    // (1 * 2 + 2 * 1) / 3 = 4/3. The parameter's secants in time are 1 and 2; its slope at key 1 is (3 + 3) / (3/1 + 3/2) = 4/3.
    // Half a second: parameter 1/2 + 1/4 * (1/2 - 4/3 / 2) = 11/24. The point there: with share s = 11/24,
    // s²(3 − 2s) + s(1 − s)((1 − s) − 4/3 s).
    let point = KeyedPoint::new(even, CurveKind::Smooth, line(5.0));
    let s = 11.0 / 24.0_f64;
    let expected = s * s * (3.0 - 2.0 * s) + s * (1.0 - s) * ((1.0 - s) - 4.0 / 3.0 * s);
    assert!(near(point.at(0.5), [expected, 0.0, 0.0]));
}

#[test]
fn a_loop_closes_with_continuous_velocity() {
    let point = KeyedPoint::new(times(Some(5.0)), CurveKind::Smooth, POINTS.to_vec());
    for seconds in [0.0, 1.0, 3.3, 5.9] {
        assert!(
            near(point.at(seconds), point.at(seconds + 5.0))
                && near(point.at(seconds), point.at(seconds - 10.0))
        );
    }
    // Velocities on both sides of every key, that of the first key included.
    let step = 1e-5;
    for key in [1.0, 2.0, 4.0, 4.5, 6.0] {
        let [before, at, after] = [key - step, key, key + step].map(|seconds| point.at(seconds));
        for axis in 0..3 {
            let change = (after[axis] - at[axis]) - (at[axis] - before[axis]);
            assert!(change.abs() < 1e-2 * step, "{key} {axis}: {change}");
        }
    }
    // A quarter of a circle's square is symmetric: half-way between two corners it is as far from both.
    let square = vec![[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]];
    let even = KeyTimes { seconds: vec![0.0, 1.0, 2.0, 3.0], period: Some(4.0) };
    let point = KeyedPoint::new(even, CurveKind::Smooth, square);
    let middle = point.at(3.5);
    assert!(middle[1].abs() < 1e-9 && middle[0] > 1.0, "{middle:?}");
}

#[test]
fn a_resting_camera_rests_and_values_do_not_overshoot() {
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let point = KeyedPoint::new(times(None), CurveKind::Smooth, points);
    for seconds in [2.0, 2.1, 3.0, 4.0] {
        assert!(near(point.at(seconds), [1.0, 0.0, 0.0]));
    }
    let value = KeyedValue::new(times(None), CurveKind::Smooth, vec![0.0, 10.0, 10.0, 11.0]);
    let all = (0..=100).map(|i| value.at(1.0 + 0.035 * f64::from(i)));
    let all: Vec<f64> = all.collect();
    assert!(all.windows(2).all(|pair| pair[1] >= pair[0] - 1e-12) && all[100] <= 11.0);
    let single = KeyTimes { seconds: vec![3.0], period: None };
    assert_eq!(KeyedValue::new(single, CurveKind::Smooth, vec![7.0]).at(0.0), 7.0);
}
