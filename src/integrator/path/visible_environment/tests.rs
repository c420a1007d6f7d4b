use super::*;
use crate::geometry::spiral_direction;
use crate::integrator::tracing::tests::with_context;
use crate::scene::{BuiltInLight, Environment};

/// Calls `check` with what is seen from inside an apartment.
fn with_apartment(check: impl FnOnce(&VisibleEnvironment<'_>)) {
    with_context("showcase/apartment", &Environment::BuiltIn(BuiltInLight::Outdoor), |context, _| {
        check(&VisibleEnvironment::new(context.view).unwrap());
    });
}

#[test]
fn samples_have_their_directions_density() {
    with_apartment(|visible| {
        assert!(visible.entries.len() > 10);
        for entry in 0..visible.entries.len() as VisibleEntry {
            for index in 0..40 {
                let u = (Vec2::new((index % 8) as f32, (index / 8) as f32) + 0.5) / Vec2::new(8.0, 5.0);
                let DirectionSample { direction, pdf } = visible.sample(entry, u);
                assert!((direction.length() - 1.0).abs() < 1e-6 && pdf > 0.0 && pdf.is_finite());
                assert_eq!(visible.pdf(entry, direction), pdf);
            }
        }
    });
}

#[test]
fn densities_integrate_to_one() {
    with_apartment(|visible| {
        let count = 1 << 15;
        for entry in (0..visible.entries.len() as VisibleEntry).step_by(9) {
            let sum: f64 =
                (0..count).map(|index| f64::from(visible.pdf(entry, spiral_direction(index, count)))).sum();
            let integral = sum * 4.0 * std::f64::consts::PI / f64::from(count);
            assert!((integral - 1.0).abs() < 0.02, "entry {entry}: {integral}");
        }
    });
}

#[test]
fn all_light_can_be_sampled() {
    // From everywhere, each direction has at least the defensive share of its density by radiance alone.
    with_apartment(|visible| {
        for entry in 0..visible.entries.len() as VisibleEntry {
            for index in 0..500 {
                let direction = spiral_direction(index, 500);
                let (sector, density) = visible.sectors.find(direction);
                let by_radiance = visible.sectors.powers()[sector] * density;
                assert!(visible.pdf(entry, direction) >= 0.099 * by_radiance, "{entry} {direction}");
            }
        }
    });
}

#[test]
fn open_and_dark_scenes_need_no_entries() {
    for (scene, environment) in [
        ("material/diffuse", Environment::BuiltIn(BuiltInLight::Studio)),
        ("showcase/apartment", Environment::None),
    ] {
        with_context(scene, &environment, |context, _| {
            assert!(VisibleEnvironment::new(context.view).is_none(), "{scene}");
        });
    }
}
