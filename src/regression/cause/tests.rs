use super::*;
use crate::image::{CameraOrigin, PartHashes, RenderedScene, SceneContent};
use crate::regression::changes::scene_changes;
use crate::regression::{ChannelDifference, ColorEncoding};

const SIZE: (u32, u32) = (64, 48);

/// A smooth pattern, changed by a function of light and position.
fn image(change: impl Fn(f32, f32, f32) -> f32) -> Image {
    let pixel = |at: u32| {
        let (x, y) = ((at % SIZE.0) as f32, (at / SIZE.0) as f32);
        let light = 0.5 + 0.3 * libm::sinf(x * 0.3) * libm::cosf(y * 0.2);
        let value = change(light, x, y);
        [value, value * 0.5, value * 0.25, 1.0]
    };
    let pixels: Vec<_> = (0..SIZE.0 * SIZE.1).map(pixel).collect();
    Image::from_rgba(SIZE, ColorEncoding::Linear, &pixels)
}

fn differing(layer: &str, different_pixels: usize) -> LayerDifference {
    let channels = vec![ChannelDifference::default()];
    LayerDifference { layer: layer.to_owned(), different_pixels, channels }
}

#[test]
fn colours_alone_identify_camera_light_noise_and_unclear_causes() {
    let reference = image(|light, _, _| light);
    let cause = |actual: &Image| likely_cause(actual, &reference, &[]);
    let moved = image(|_, x, y| 0.5 + 0.3 * libm::sinf((x - 2.0) * 0.3) * libm::cosf((y + 1.0) * 0.2));
    let found = cause(&moved);
    let Some(Cause::Camera { right: Some(right), down: Some(down) }) = found else { panic!("{found:?}") };
    assert!((right - 2.0).abs() < 0.05 && (down + 1.0).abs() < 0.05);
    let found = cause(&image(|light, _, _| light * 1.1));
    let Some(Cause::Light { factors: Some([red, ..]) }) = found else { panic!("{found:?}") };
    assert!((red - 1.1).abs() < 1e-4);
    // A hash of the position, between −0.01 and 0.01.
    let grain = |x: f32, y: f32| {
        let mixed = (x as u32).wrapping_mul(73_856_093) ^ (y as u32).wrapping_mul(19_349_663);
        let mixed = mixed.wrapping_mul(2_654_435_761);
        ((mixed >> 16) % 1000) as f32 / 50_000.0 - 0.01
    };
    assert_eq!(cause(&image(|light, x, y| light + grain(x, y))), Some(Cause::Noise));
    let part = image(|light, x, y| if x < 8.0 && y < 8.0 { 0.0 } else { light });
    assert_eq!(cause(&part), Some(Cause::Unclear { share: 64.0 / 3072.0 }));
    assert_eq!(cause(&reference), None);
}

#[test]
fn layers_distinguish_geometry_material_and_light() {
    let reference = image(|light, _, _| light);
    let part = image(|light, x, y| if x < 8.0 && y < 8.0 { 0.0 } else { light });
    let cause = |layers: &[LayerDifference]| likely_cause(&part, &reference, layers).unwrap();
    let (depth, albedo) = (differing("depth", 64), differing("albedo", 60));
    assert!(matches!(cause(&[albedo.clone(), depth]), Cause::Geometry { pixels: 64, .. }));
    assert!(matches!(cause(&[differing("depth", 0), albedo]), Cause::Material { pixels: 60, .. }));
    let equal = [differing("depth", 0), differing("albedo", 0)];
    assert_eq!(cause(&equal), Cause::MaterialOrLight);
    // Twice the light, where ids alone cannot tell it from a paler material.
    let brighter = image(|light, _, _| light * 2.0);
    let of = |layers: &[LayerDifference]| likely_cause(&brighter, &reference, layers).unwrap();
    assert!(matches!(of(&equal), Cause::Light { factors: Some(_) }));
    assert_eq!(of(&[differing("object_id", 0), differing("material_id", 0)]), Cause::MaterialOrLight);
}

/// An image that was rendered from a scene of these parts.
fn rendered(pixels: &Image, camera: f32, [geometry, materials, lights]: [&str; 3]) -> Image {
    let [geometry, materials, lights] = [geometry, materials, lights].map(str::to_owned);
    // Assignments follow the geometry; those of "g" are told by the material.
    let assignments = if materials == "swapped" { "other" } else { geometry.as_str() }.to_owned();
    let materials = if materials == "swapped" { "m".to_owned() } else { materials };
    let parts = PartHashes {
        geometry,
        materials,
        assignments,
        lights,
        shape: None,
        background: None,
        camera: None,
        rules: Some(1),
    };
    let parts = Some(parts);
    let scene = RenderedScene { camera: Some([[camera; 16]; 2]), parts, content: None };
    Image { scene, ..pixels.clone() }
}

#[test]
fn files_that_tell_their_scene_name_what_changed() {
    let before = image(|light, _, _| light);
    let reference = rendered(&before, 0.5, ["g", "m", "l"]);
    // The same pixels for every cause: half of the light, as a material or a light gives it.
    let darker = image(|light, _, _| light * 0.5);
    let ids = [differing("object_id", 0)];
    let cause = |camera: f32, parts: [&str; 3]| {
        likely_cause(&rendered(&darker, camera, parts), &reference, &ids).unwrap()
    };
    assert!(matches!(cause(0.5, ["G", "m", "l"]), Cause::Geometry { layer: None, .. }));
    assert!(matches!(cause(0.5, ["g", "M", "l"]), Cause::Material { layer: None, .. }));
    assert!(matches!(cause(0.5, ["g", "m", "L"]), Cause::Light { factors: Some(_) }));
    assert_eq!(cause(0.5, ["g", "M", "L"]), Cause::MaterialOrLight);
    assert_eq!(cause(0.5, ["g", "m", "l"]), Cause::Settings);
    // Objects that exchange their materials.
    assert!(matches!(cause(0.5, ["g", "swapped", "l"]), Cause::Material { layer: None, .. }));
    assert!(matches!(cause(0.6, ["g", "m", "L"]), Cause::Unclear { .. }));
    // The same pixels, and objects with other numbers.
    assert_eq!(likely_cause(&reference.clone(), &reference, &ids), None);
    assert!(matches!(cause(0.6, ["g", "m", "l"]), Cause::Camera { .. }));
    // The automatic camera follows a model that grows. Rounding moves no camera.
    assert!(matches!(cause(0.6, ["G", "m", "l"]), Cause::Geometry { .. }));
    assert!(matches!(cause(0.500_000_1, ["g", "M", "l"]), Cause::Material { .. }));
    // Of two changes without a layer either may be the cause.
    let mixed = likely_cause(&rendered(&darker, 0.5, ["G", "M", "l"]), &reference, &[]);
    assert!(matches!(mixed, Some(Cause::Unclear { .. })), "{mixed:?}");
    // Vertices in another order move no edge; a lost object does.
    assert!(matches!(cause(0.5, ["G", "M", "l"]), Cause::Material { .. }));
    let channel = ChannelDifference { different: 9, largest: 1.0, ..ChannelDifference::default() };
    let lost = [LayerDifference { channels: vec![channel], ..differing("object_id", 9) }];
    let found = likely_cause(&rendered(&darker, 0.5, ["G", "M", "l"]), &reference, &lost);
    assert!(matches!(found, Some(Cause::Geometry { pixels: 9, .. })), "{found:?}");
}

#[test]
fn an_object_that_moves_before_the_same_camera_is_no_camera() {
    let reference = image(|light, _, _| light);
    let moved = image(|_, x, y| 0.5 + 0.3 * libm::sinf((x - 2.0) * 0.3) * libm::cosf((y + 1.0) * 0.2));
    let layers = [differing("object_id", 50)];
    let seen = |image: &Image, camera: f32| {
        let scene = RenderedScene { camera: Some([[camera; 16]; 2]), parts: None, content: None };
        Image { scene, ..image.clone() }
    };
    let cause = |camera: f32| likely_cause(&seen(&moved, camera), &seen(&reference, 1.0), &layers);
    assert!(matches!(cause(1.0), Some(Cause::Geometry { pixels: 50, .. })));
    assert!(matches!(cause(2.0), Some(Cause::Camera { .. })));
}

#[test]
fn clip_planes_and_backgrounds_are_told() {
    let before = image(|light, _, _| light);
    let reference = rendered(&before, 0.5, ["g", "m", "l"]);
    let other = |change: &dyn Fn(&mut RenderedScene), parts: [&str; 3]| {
        let mut actual = rendered(&image(|light, _, _| light * 0.5), 0.5, parts);
        change(&mut actual.scene);
        actual
    };
    let cause = |change: &dyn Fn(&mut RenderedScene), parts: [&str; 3]| {
        likely_cause(&other(change, parts), &reference, &[]).unwrap()
    };
    // The third row of the matrix to the display window.
    let far = |scene: &mut RenderedScene| scene.camera.as_mut().unwrap()[1][10] = 0.7;
    assert_eq!(cause(&far, ["g", "m", "l"]), Cause::ClipPlanes);
    assert!(matches!(cause(&far, ["g", "M", "l"]), Cause::Material { .. }));
    // References of earlier versions tell of no plate.
    let plate = |scene: &mut RenderedScene| scene.parts.as_mut().unwrap().background = Some("B".to_owned());
    assert_eq!(cause(&plate, ["g", "m", "l"]), Cause::Settings);
    let mut told = reference.clone();
    told.scene.parts.as_mut().unwrap().background = Some("b".to_owned());
    assert_eq!(likely_cause(&other(&plate, ["g", "m", "l"]), &told, &[]), Some(Cause::Background));
    let found = likely_cause(&other(&plate, ["g", "M", "l"]), &told, &[]);
    assert!(matches!(found, Some(Cause::Unclear { .. })), "{found:?}");
}

#[test]
fn vertex_colors_are_a_material() {
    let before = image(|light, _, _| light);
    let with = |pixels: &Image, shape: &str, colors: &str, materials: &str| {
        let mut image = rendered(pixels, 0.5, [&format!("{shape}{colors}"), materials, "l"]);
        image.scene.parts.as_mut().unwrap().shape = Some(shape.to_owned());
        image
    };
    let reference = with(&before, "s", "c", "m");
    let darker = image(|light, _, _| light * 0.5);
    let cause = |shape: &str, colors: &str, materials: &str| {
        likely_cause(&with(&darker, shape, colors, materials), &reference, &[]).unwrap()
    };
    assert_eq!(cause("s", "C", "m"), Cause::VertexColors);
    assert!(matches!(cause("s", "C", "M"), Cause::Material { .. }));
    // Vertices in another order have their colours in another order, too.
    assert!(matches!(cause("S", "C", "m"), Cause::Geometry { .. }));
}

#[test]
fn hashes_of_other_rules_are_not_compared() {
    let before = image(|light, _, _| light);
    let by = |rules: Option<u32>, geometry: &str| {
        let mut image = rendered(&before, 0.5, [geometry, "m", "l"]);
        image.scene.parts.as_mut().unwrap().rules = rules;
        image.scene
    };
    let changes = |ours, theirs| changed_parts(&by(ours, "G"), &by(theirs, "g"));
    // The first rules have no number in files of earlier versions.
    for (ours, theirs) in [(Some(1), Some(1)), (Some(1), None), (None, Some(1)), (Some(2), Some(2))] {
        assert_eq!(changes(ours, theirs), Some(vec![Part::Geometry]));
    }
    for (ours, theirs) in [(Some(2), Some(1)), (Some(2), None), (None, Some(2))] {
        assert_eq!(changes(ours, theirs), None);
    }
}

#[test]
fn motions_of_other_rules_are_not_compared() {
    let by = |rules: Option<u32>, motion: &str| {
        let mut scene = rendered(&image(|light, _, _| light), 0.5, ["g", "m", "l"]).scene;
        scene.parts.as_mut().unwrap().rules = rules;
        let motions = [("walk".to_owned(), motion.to_owned())].into();
        scene.content = Some(SceneContent { motions: Some(motions), ..SceneContent::default() });
        scene
    };
    let told = |ours, theirs| scene_changes(&by(ours, "b"), &by(theirs, "a"), true);
    assert_eq!(told(Some(2), Some(2)), ["motion of clip \"walk\" changed"]);
    for (ours, theirs) in [(Some(2), Some(1)), (None, Some(1)), (None, None)] {
        assert_eq!(told(ours, theirs), [""; 0]);
    }
}

#[test]
fn cameras_of_files_and_framing_cameras_are_told_apart() {
    let pattern = |right: f32| image(move |_, x, _| 0.5 + 0.3 * libm::sinf((x - right) * 0.3));
    let (before, moved, darker) = (pattern(0.0), pattern(2.0), image(|light, x, _| light * x / 64.0));
    let with = |pixels: &Image, origin: CameraOrigin, camera: f32, geometry: &str, motion: &str| {
        let mut image = rendered(pixels, camera, [geometry, "m", "l"]);
        image.scene.parts.as_mut().unwrap().camera = Some(origin);
        let motions = [("walk".to_owned(), motion.to_owned())].into();
        image.scene.content = Some(SceneContent { motions: Some(motions), ..SceneContent::default() });
        image
    };
    let cause = |pixels: &Image, origin: CameraOrigin, geometry: &str, motion: &str| {
        let reference = with(&before, origin, 0.5, "g", "a");
        likely_cause(&with(pixels, origin, 0.6, geometry, motion), &reference, &[]).unwrap()
    };
    let (file, framed) = (CameraOrigin::File, CameraOrigin::Framed);
    // Another order of vertices beside a camera that moved
    let found = cause(&moved, file, "G", "a");
    assert!(matches!(found, Cause::Camera { right: Some(_), .. }), "{found:?}");
    assert_eq!(cause(&darker, file, "G", "a"), Cause::CameraOrGeometry);
    assert!(matches!(cause(&darker, framed, "G", "a"), Cause::Geometry { .. }));
    // The pose is the same, and other times of the clip are not
    assert_eq!(cause(&moved, framed, "g", "b"), Cause::CameraFollowsClip);
    assert!(matches!(cause(&darker, framed, "g", "a"), Cause::Camera { right: None, .. }));
    assert!(matches!(cause(&moved, file, "g", "b"), Cause::Camera { right: Some(_), .. }));
}
