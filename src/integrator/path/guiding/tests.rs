use glam::{Vec2, Vec3};

use super::guide_build::LARGEST_SHARE;
use super::photon_sources::PhotonSources;
use super::photons::PhotonTracing;
use super::{PathGuide, Photon, PhotonPath};
use crate::bvh::{Hit, TraversalCounters};
use crate::geometry::Ray;
use crate::integrator::tracing::tests::with_context;
use crate::integrator::tracing::{SampleValue, Tracer};
use crate::integrator::{CameraRays, CameraSamples, Integrator, IntegratorContext, IntegratorSettings};
use crate::scene::{Environment, KeyLight};

/// Calls `check` with a scene for paths. A box with a panel that shines on a mirror and a glass ball is `path/box`.
fn with_paths(scene: &str, check: impl FnOnce(&IntegratorContext<'_>, &CameraRays)) {
    with_context(scene, &Environment::None, |context, camera| {
        let settings = IntegratorSettings { integrator: Integrator::Path, ..context.settings.clone() };
        check(&IntegratorContext::new(context.view, settings), camera);
    });
}

fn photons_of(context: &IntegratorContext<'_>) -> Vec<Photon> {
    let tracing = PhotonTracing::new(context).unwrap();
    [tracing.first().unwrap(), tracing.rest()].concat()
}

#[test]
fn photons_leave_a_lambertian_panel() {
    with_paths("path/box", |context, _| {
        let sources = PhotonSources::new(context).unwrap();
        let (count, mut power, mut cosines) = (10_000, 0.0, 0.0);
        for index in 0..count {
            let photon = sources.emit(index).unwrap();
            power += crate::color::luminance(photon.power);
            cosines += photon.ray.direction.y;
            assert!(photon.ray.direction.y < 0.0, "the panel shines downwards: {}", photon.ray.direction);
        }
        assert!((power / count as f32 - 1.0).abs() < 1e-3);
        // The mean of the cosine, where the density is as the cosine
        assert!((cosines / count as f32 + 2.0 / 3.0).abs() < 0.01);
    });
}

#[test]
fn photons_come_from_where_their_path_says() {
    with_paths("path/box", |context, _| {
        let view = context.view;
        let photons = photons_of(context);
        assert!(photons.len() > 10_000);
        let (mut focused, mut missed) = (0, 0);
        for photon in &photons {
            let ray = Ray::new(photon.position + 1e-4 * photon.normal, photon.direction);
            let hit = view.bvh.closest_hit(&ray, None, |_: &Hit| true, &mut TraversalCounters::default());
            let material =
                hit.map(|hit| &view.frame.materials[view.frame.instance(hit.triangle).material.index()]);
            let Some(material) = material else {
                missed += 1;
                continue;
            };
            assert!(material.emissive.max_element() == 0.0 || photon.path == PhotonPath::Indirect);
            assert!(photon.power > 0.0 && photon.source_luminance > 1.0);
            if photon.path == PhotonPath::Caustic {
                assert_eq!(material.roughness, 0.0);
                focused += 1;
            }
        }
        assert!(missed < photons.len() / 1000, "{missed} come from nowhere");
        assert!(focused > 500 && focused < photons.len() / 2, "{focused} of {}", photons.len());
    });
}

#[test]
fn photons_do_not_depend_on_threads() {
    with_paths("path/box", |context, _| {
        let of = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| photons_of(context))
        };
        let (one, three) = (of(1), of(3));
        assert!(one == three && !one.is_empty());
    });
}

#[test]
fn only_focused_light_needs_a_guide() {
    for (scene, is_guided) in [
        ("path/box", true),
        ("showcase/apartment", false),
        ("material/emissive_strength", false),
        ("material/nested_glass", false),
    ] {
        with_paths(scene, |context, _| assert_eq!(context.path_guide.is_some(), is_guided, "{scene}"));
    }
}

#[test]
fn photons_are_traced_only_where_something_may_focus_them() {
    for (scene, is_traced) in [
        ("path/box", true),
        // A window, which is smooth
        ("showcase/apartment", true),
        ("material/emissive_strength", false),
    ] {
        with_paths(scene, |context, _| {
            assert!(PhotonSources::new(context).is_some(), "{scene}");
            assert_eq!(PhotonTracing::new(context).is_some(), is_traced, "{scene}");
        });
    }
}

#[test]
fn other_lights_take_samples_from_the_guide() {
    let largest_share = |radiance: f32, scale: f32| {
        let mut largest = None;
        with_context("path/box", &Environment::Constant(Vec3::splat(radiance)), |context, _| {
            let settings = IntegratorSettings { integrator: Integrator::Path, ..context.settings.clone() };
            let mut context = IntegratorContext::new(context.view, settings);
            context.peaks.push(KeyLight { direction_to_light: Vec3::Y, irradiance: Vec3::splat(scale) });
            let guide = PathGuide::new(&context);
            let cells = guide.iter().flat_map(|guide| &guide.guided).flatten();
            largest = cells.map(|cell| cell.share).max_by(f32::total_cmp);
        });
        largest
    };
    let [dark, sky, sun] =
        [(0.0, 0.0), (0.3, 0.0), (0.0, 4.0)].map(|(sky, sun)| largest_share(sky, sun).unwrap());
    assert!((dark - LARGEST_SHARE).abs() < 1e-5, "{dark}");
    assert!(sky < dark && sun < dark, "{sky} {sun}");
    assert_eq!(largest_share(1e4, 0.0), None);
    assert_eq!(largest_share(0.0, 1e5), None);
}

/// Mean over an image, its variance, and the mean variance of a sample.
fn moments(context: &IntegratorContext<'_>, camera: &CameraRays) -> [f64; 3] {
    const SAMPLES: u32 = 64;
    let (mut mean, mut of_mean, mut of_sample) = (0.0, 0.0, 0.0);
    let pixels: Vec<(u32, u32)> = (0..12).flat_map(|y| (0..16).map(move |x| (x, y))).collect();
    let mut tracer = Tracer::new(context);
    let offsets: Vec<Vec2> = vec![Vec2::splat(0.5); SAMPLES as usize];
    for pixel in &pixels {
        let one = [*pixel];
        let samples = CameraSamples { pixels: &one, offsets: &offsets, first_index: 0, may_hit: true };
        let values = tracer.trace(camera, &samples);
        let luminance = |value: &SampleValue| f64::from(crate::color::luminance(value.radiance));
        let of_pixel = values.iter().map(luminance).sum::<f64>() / f64::from(SAMPLES);
        let squares = values.iter().map(|value| (luminance(value) - of_pixel).powi(2)).sum::<f64>();
        let variance = squares / f64::from(SAMPLES - 1);
        mean += of_pixel;
        of_mean += variance / f64::from(SAMPLES);
        of_sample += variance;
    }
    let count = pixels.len() as f64;
    [mean / count, of_mean / (count * count), of_sample / count]
}

#[test]
fn guided_paths_have_the_same_mean_and_less_noise() {
    with_paths("path/box", |context, camera| {
        let guided = moments(context, camera);
        let mut without = context.clone();
        without.path_guide = None;
        let unguided = moments(&without, camera);
        // Samples of a pixel are stratified, so that their variance bounds that of the mean.
        let deviation = (guided[1] + unguided[1]).sqrt();
        let difference = guided[0] - unguided[0];
        assert!(difference.abs() < 4.0 * deviation, "{guided:?} {unguided:?}");
        assert!(deviation < 0.02 * guided[0], "{guided:?} {unguided:?}");
        assert!(guided[2] < 0.7 * unguided[2], "{guided:?} {unguided:?}");
    });
}
