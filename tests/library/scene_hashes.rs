//! Hashes of the parts of scenes, which references hold and later versions compare.

use std::path::Path;

use rayframe::Renderer;
use rayframe::image::{CameraOrigin, PartHashes};

/// Scenes and the values of the attribute `sceneParts`. Where one changes, raise `PartHashes::RULES`, so that no reference of an earlier version
/// is told as changed.
const SCENES: [(&str, &str); 4] = [
    (
        "light/point.gltf",
        "geometry=a9fd24d5443f4011 materials=0683672224f2b869 assignments=dd4ea8a3e9588064 lights=59d3891b6dd355f7 shape=a9fd24d5443f4011 background=b1a6a88f45c93c69 camera=file rules=1",
    ),
    (
        "texture/vertex_color.gltf",
        "geometry=68f51e81962ccfd8 materials=dd263ecce930de19 assignments=b7183f1bc5bfc506 lights=f1d8bce2fe0a409e shape=57392674ba9228d0 background=b1a6a88f45c93c69 camera=file rules=1",
    ),
    (
        "morph/morph_then_skin.gltf",
        "geometry=4977c8fdc0926a3c materials=b369e5afbfbcff80 assignments=d45d884a8bda656d lights=5639deddd79b85ec shape=4977c8fdc0926a3c background=b1a6a88f45c93c69 camera=file rules=1",
    ),
    (
        "texture/base_color_srgb.gltf",
        "geometry=5ec6681faa4258cf materials=8207fecf9f7fccb2 assignments=8a5d0f3498921e1a lights=f1d8bce2fe0a409e shape=5ec6681faa4258cf background=b1a6a88f45c93c69 camera=file rules=1",
    ),
];

#[test]
fn hashes_of_equal_rules_are_those_of_earlier_versions() {
    let mut different = Vec::new();
    for (scene, expected) in SCENES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let image = Renderer::open(path).unwrap().size(8, 8).frame(0).unwrap().image().unwrap();
        let found = image.scene.parts.map(|parts| parts.text()).unwrap();
        assert!(found.ends_with(&format!(" rules={}", PartHashes::RULES)), "{found}");
        if found != expected {
            different.push(format!("{scene}: {found}"));
        }
    }
    assert!(different.is_empty(), "{}", different.join("\n"));
}

#[test]
fn cameras_that_no_clip_moves_are_told_apart() {
    let origin = |scene: &str, settings: &[(&str, &str)]| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let mut renderer = Renderer::open(path).unwrap().size(8, 8);
        for (name, value) in settings {
            renderer = renderer.set(name, value).unwrap();
        }
        let image = renderer.frame(0).unwrap().image().unwrap();
        image.scene.parts.and_then(|parts| parts.camera).unwrap()
    };
    let (moving, still) = ("animation/hierarchy.gltf", "texture/vertex_color.gltf");
    let position = ("camera_position", "1,2,8");
    assert_eq!(origin(moving, &[("camera", "auto")]), CameraOrigin::Framed);
    assert_eq!(origin(moving, &[("orbit", "30,20")]), CameraOrigin::Framed);
    // It looks at the centre of what moves.
    assert_eq!(origin(moving, &[position]), CameraOrigin::Framed);
    assert_eq!(origin(moving, &[position, ("look_at", "0,0,0")]), CameraOrigin::Other);
    assert_eq!(origin(moving, &[("camera", "auto"), ("animation", "none")]), CameraOrigin::Other);
    assert_eq!(origin(still, &[("camera", "auto")]), CameraOrigin::Other);
}
