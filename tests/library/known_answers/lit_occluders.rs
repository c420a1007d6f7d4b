//! Light that occluders reflect by what they are made of and by how much of it reaches them.

use glam::Vec3;
use rayframe::error::Result;
use rayframe::render::{EnvSamples, Integrator};
use rayframe::scene::{Environment, EnvironmentImage, EnvironmentMap, Material};

use super::environment_shadows::stage;
use super::path::{floor, middle};
use crate::stage::{Stage, lambert, rectangle};

/// Light of these radiances from above and from below the horizon.
fn halves(above: f32, below: f32) -> Result<Environment> {
    let (width, height) = (256, 128);
    let pixel = |index: u32| if index / width < height / 2 { [above; 3] } else { [below; 3] };
    let image = EnvironmentImage {
        width,
        height,
        pixels: (0..width * height).map(pixel).collect(),
        content_hash: [0; 32],
    };
    Ok(Environment::Map(EnvironmentMap::new("halves.hdr".as_ref(), image, 0.0)?))
}

fn stage_in(environment: Environment) -> Stage {
    let mut stage = stage(4096);
    stage.environment = environment;
    stage.settings.env_samples = EnvSamples::Fixed(1);
    stage
}

#[test]
fn hollows_that_face_the_dark_are_hardly_brighter_than_what_is_beside_them() {
    // White walls around the seen point would see the light from below, but the floor hides it.
    let seen = |has_walls: bool| {
        let mut stage = stage_in(halves(0.1, 1.0).unwrap());
        stage.add(floor(500.0), lambert(Vec3::splat(0.5)));
        for (out, along) in
            [(Vec3::X, Vec3::NEG_Z), (Vec3::NEG_X, Vec3::Z), (Vec3::Z, Vec3::X), (Vec3::NEG_Z, Vec3::NEG_X)]
        {
            if has_walls {
                stage.add(rectangle(out + Vec3::Y, Vec3::Y, along), lambert(Vec3::ONE));
            }
        }
        middle(&stage).x
    };
    let (open, hollow) = (seen(false), seen(true));
    assert!((open - 0.05).abs() < 1e-3, "{open}");
    assert!(hollow < 1.2 * open && hollow > 0.2 * open, "{hollow} beside {open}");
}

#[test]
fn metals_light_what_they_hide_by_what_they_mirror() {
    // A wall beside the floor mirrors the sky to it; paper would scatter half of that light. Of roughness 1, it loses more between its facets.
    let light = |integrator: Integrator, color: f32, roughness: f32, metallic: f32| {
        let mut stage = stage_in(halves(1.0, 0.0).unwrap());
        stage.settings.integrator = integrator;
        // A dark floor reflects nothing to the wall.
        stage.add(floor(500.0), lambert(Vec3::splat(0.02)));
        let wall = rectangle(Vec3::new(0.0, 200.0, -0.5), Vec3::X * 500.0, Vec3::Y * 200.0);
        stage.add(wall, Material { metallic, roughness, ..lambert(Vec3::splat(color)) });
        middle(&stage).x
    };
    let reflected = |integrator, roughness, metallic| {
        light(integrator, 0.6, roughness, metallic) - light(integrator, 0.0, roughness, metallic)
    };
    let paper = reflected(Integrator::Whitted, 1.0, 0.0);
    for (roughness, over_paper) in [(0.5, 1.5), (0.7, 1.2), (1.0, 0.75)] {
        let [whitted, path] =
            [Integrator::Whitted, Integrator::Path].map(|integrator| reflected(integrator, roughness, 1.0));
        assert!((whitted / path - 1.0).abs() < 0.15, "{roughness}: {whitted} of {path}");
        assert!((path / paper / over_paper - 1.0).abs() < 0.1, "{roughness}: {path} and {paper}");
    }
}
