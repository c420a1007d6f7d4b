use super::*;
use crate::scene::CubeLevel;

#[test]
fn constant_light_is_exact() {
    let environment = Environment::Constant(Vec3::new(1.0, 2.0, 3.0));
    let direction = Vec3::new(0.6, -0.8, 0.0);
    assert_eq!(environment.radiance(direction), Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(environment.prefiltered(direction, 0.7), Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(environment.irradiance(direction), Vec3::new(PI, 2.0 * PI, 3.0 * PI));
    assert!(environment.is_lit() && environment.key_light().is_none());
}

#[test]
fn an_empty_environment_is_dark() {
    let environment = Environment::default();
    assert_eq!(environment.radiance(Vec3::Y), Vec3::ZERO);
    assert_eq!(environment.irradiance(Vec3::Y), Vec3::ZERO);
    assert_eq!(environment.prefiltered(Vec3::Y, 0.5), Vec3::ZERO);
    assert!(!environment.is_lit() && !Environment::Constant(Vec3::ZERO).is_lit());
}

#[test]
fn built_in_lights_bring_a_key_light() {
    for light in BuiltInLight::ALL {
        let key = Environment::BuiltIn(light).key_light().unwrap();
        assert!((key.direction_to_light.length() - 1.0).abs() < 1e-6);
        assert!(key.direction_to_light.y > 0.5 && key.irradiance.min_element() > 0.0);
    }
}

#[test]
fn camera_rays_see_the_backdrop_without_the_areas() {
    let composed = |light, background| {
        Environment::Composed(Box::new(ComposedEnvironment { light, intensity: 2.0, background }))
    };
    for light in BuiltInLight::ALL.map(Environment::BuiltIn) {
        let zero = [Vec3::ZERO; 2];
        // The backdrop depends on the height alone; the areas do not.
        let around: [Vec3; 24] = std::array::from_fn(|step| {
            let (sin_azimuth, cos_azimuth) = libm::sincosf(step as f32 * PI / 12.0);
            Vec3::new(0.96 * sin_azimuth, 0.28, 0.96 * cos_azimuth)
        });
        let seen = light.background_over(around[0], zero);
        assert!(around.iter().all(|&direction| light.background_over(direction, zero) == seen));
        assert!(around.iter().any(|&direction| light.radiance_over(direction, zero) != seen));
        // As the light, times its intensity, and as a background of its own.
        assert_eq!(composed(light.clone(), None).background_over(around[1], zero), seen * 2.0);
        let constant = Environment::Constant(Vec3::X);
        assert_eq!(composed(constant, Some(light)).background_over(around[2], zero), seen);
    }
}

#[test]
fn intensity_scales_all_light_but_not_the_background() {
    let composed = |background| {
        let light = Environment::BuiltIn(BuiltInLight::Studio);
        Environment::Composed(Box::new(ComposedEnvironment { light, intensity: 0.5, background }))
    };
    let (half, studio) = (composed(None), Environment::BuiltIn(BuiltInLight::Studio));
    let direction = Vec3::new(0.6, 0.0, -0.8);
    assert_eq!(half.radiance(direction) * 2.0, studio.radiance(direction));
    assert_eq!(half.irradiance(direction) * 2.0, studio.irradiance(direction));
    assert_eq!(half.prefiltered(direction, 0.3) * 2.0, studio.prefiltered(direction, 0.3));
    let key = |environment: &Environment| environment.key_light().unwrap().irradiance;
    assert_eq!(key(&half) * 2.0, key(&studio));
    let differentials = [Vec3::ZERO; 2];
    let seen = half.background_over(direction, differentials) * 2.0;
    assert_eq!(seen, studio.background_over(direction, differentials));

    let green = composed(Some(Environment::Constant(Vec3::Y)));
    assert_eq!(green.background_over(direction, differentials), Vec3::Y);
    assert_eq!(green.radiance_over(direction, differentials), half.radiance_over(direction, differentials));
    let dark = ComposedEnvironment { light: studio, intensity: 0.0, background: None };
    assert!(!Environment::Composed(Box::new(dark)).is_lit() && half.is_lit());
}

#[test]
fn a_posed_image_light_equals_one_built_at_that_pose() {
    // Each face has its own colour.
    let face = |face: u8| vec![[f32::from(face), 1.0, 0.5]];
    let level = CubeLevel { size: 1, faces: [0, 1, 2, 3, 4, 5].map(face) };
    let mut light = ImageLight {
        name: None,
        intensity: 1.0,
        rotation: Quat::IDENTITY,
        irradiance: std::array::from_fn(|i| Vec3::splat(if i == 0 { 3.0 } else { 0.02 * i as f32 })),
        levels: vec![level.clone(), level],
    };
    let moving = Environment::of_image_light(&light, ImageLightIndex(3), true);
    assert!(Environment::of_image_light(&light, ImageLightIndex(3), false).posed(&light.pose()).is_none());
    // Rotations by 90° about each axis, at half the intensity.
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        light.rotation = Quat::from_vec4((axis * 0.5_f32.sqrt()).extend(0.5_f32.sqrt()));
        light.intensity = 0.5;
        let still = Environment::of_image_light(&light, ImageLightIndex(3), false);
        let composed = ComposedEnvironment { light: moving.clone(), intensity: 1.0, background: None };
        let composed = Environment::Composed(Box::new(composed));
        for moved in [moving.posed(&light.pose()).unwrap(), composed.posed(&light.pose()).unwrap()] {
            for direction in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.36, -0.48, 0.8)] {
                let close = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 0.02;
                assert!(close(moved.radiance(direction), still.radiance(direction)), "{axis} {direction}");
                assert!(close(moved.irradiance(direction), still.irradiance(direction)));
                assert!(close(moved.prefiltered(direction, 1.0), still.prefiltered(direction, 1.0)));
            }
        }
    }
    light.intensity = 0.0;
    assert!(!moving.posed(&light.pose()).unwrap().is_lit());
    assert_eq!(moving.content_key(), "image light 3");
}

#[test]
fn keys_name_the_content() {
    let constant = Environment::Constant(Vec3::new(1.0, 0.5, 0.0));
    assert_eq!(constant.content_key(), "constant 3f800000 3f000000 00000000");
    let composed = |intensity, background| {
        let light = Environment::BuiltIn(BuiltInLight::Studio);
        Environment::Composed(Box::new(ComposedEnvironment { light, intensity, background }))
    };
    assert_eq!(composed(1.0, Some(Environment::None)).content_key(), "studio before none");
    assert_eq!(composed(0.5, None).content_key(), "studio times 3f000000");
    let both = composed(0.5, Some(constant));
    assert_eq!(both.content_key(), "studio times 3f000000 before constant 3f800000 3f000000 00000000");
    let pixels = vec![[1.0; 3]];
    let image = EnvironmentImage { width: 1, height: 1, pixels, content_hash: [0xab; 32] };
    let map = EnvironmentMap::new(std::path::Path::new("sky.hdr"), image, 1.0).unwrap();
    assert_eq!(Environment::Map(map).content_key(), format!("map {} turned 3f800000", "ab".repeat(32)));
}
