//! Rendering of a frame of 4x4 pixels, with a hierarchy and by brute force.

use rayframe::Renderer;
use rayframe::regression::are_identical;
use rayframe::scene::Mesh;

use crate::input::Input;
use crate::scratch;
use crate::verdict::accepted;

/// Bytes of an input before the document.
pub(crate) const OPTION_BYTES: usize = 4;
/// Lines of the shot file that bits of the input choose. Every input has a small image and a memory limit.
const OPTIONS: [&str; 24] = [
    "integrator = \"path\"",
    "samples = 3",
    "depth = 3",
    "shutter = \"180deg\"\ntime_samples = 3",
    "aperture = 0.1",
    "glossy = 2",
    "glass_shadows = \"opaque\"",
    "filter = \"gaussian\"",
    "env = \"studio\"",
    "env = \"0.5,0.25,1\"",
    "aovs = [\"all\"]",
    "ground = true",
    "camera = \"auto\"",
    "orbit = \"40,20\"",
    "turntable = 8",
    "ortho = true",
    "light_radius = 0.2",
    "light_scale = 0",
    "max_samples = 4",
    "split = \"0.01\"",
    "bvh = \"ploc\"",
    "fov = 170",
    "env_samples = 2",
    "variant = \"#0\"",
];
/// Scenes of more triangles are not rendered by brute force as well.
const MAX_BRUTE_FORCE: usize = 4000;

/// Renders the document behind the options at two frames.
pub(crate) fn render(input: &[u8]) {
    let mut input = Input::new(input);
    let chosen = input.u32();
    scratch::file("scene.gltf", input.rest());
    let mut shot = "scene = \"scene.gltf\"\nresolution = [4, 4]\nmax_memory = \"32M\"\n".to_owned();
    for (bit, line) in OPTIONS.iter().enumerate() {
        if chosen >> bit & 1 == 1 {
            shot.push_str(line);
            shot.push('\n');
        }
    }
    let Some(renderer) = accepted(Renderer::open(scratch::file("shot.toml", shot.as_bytes()))) else {
        return;
    };
    let frame = i64::from(chosen >> 24) % 40;
    let Some(rendered) = accepted(renderer.frame(frame)) else { return };
    assert!(rendered.pixels().iter().flatten().all(|value| value.is_finite()), "a pixel is not finite");

    // The hierarchy never changes the image.
    let triangles: usize = renderer.scene().meshes.iter().map(Mesh::triangle_count).sum();
    if triangles * renderer.scene().nodes.len() > MAX_BRUTE_FORCE {
        return;
    }
    let brute_force =
        accepted(renderer.set("bvh", "brute")).and_then(|renderer| accepted(renderer.frame(frame)));
    if let (Some(brute_force), Some(image)) = (brute_force, accepted(rendered.image())) {
        let is_same =
            accepted(brute_force.image()).is_some_and(|brute_force| are_identical(&image, &brute_force));
        assert!(is_same, "the hierarchy changes the image");
    }
}
