//! Colours of display images under the default settings.

use make_scenes::color_chart::{SIZE, color_chart, mean_delta_e, measure};
use rayframe::Renderer;
use rayframe::image_file::{DisplayImage, decode_png};

/// The first frame of a glTF file as a display image of `size`, with further settings.
#[expect(clippy::unwrap_used, reason = "a helper of tests")]
fn display_image(gltf: &str, size: (u32, u32), settings: &[(&str, &str)]) -> DisplayImage {
    let folder = tempfile::tempdir().unwrap();
    let (scene, png) = (folder.path().join("a.gltf"), folder.path().join("a.png"));
    std::fs::write(&scene, gltf).unwrap();
    let mut renderer = Renderer::open(&scene).unwrap().size(size.0, size.1).samples(1);
    for (name, value) in settings {
        renderer = renderer.set(name, value).unwrap();
    }
    renderer.frame(0).unwrap().write_png(&png).unwrap();
    decode_png(&png, &std::fs::read(&png).unwrap()).unwrap()
}

#[test]
fn base_colours_keep_their_values_under_the_bright_built_in_lights() {
    for settings in [&[][..], &[("env", "softbox")], &[("env", "outdoor")]] {
        let image = display_image(&color_chart(), (SIZE.0 * 12, SIZE.1 * 12), settings);
        let patches = measure(image.size.0, &image.pixels);
        let mean = mean_delta_e(&patches);
        assert!(mean <= 8.0, "{settings:?}: mean ΔE2000 {mean:.2} of {patches:#?}");
        // White stays below clipping.
        let mut values = image.pixels.iter().flatten().enumerate();
        assert!(values.all(|(i, &value)| i % 4 == 3 || value < 250), "{settings:?}");
    }
}

#[test]
fn display_backgrounds_are_exact_whatever_exposure_and_curve() {
    for tone in ["neutral", "standard", "agx", "aces", "none"] {
        for exposure in ["auto", "-3", "4"] {
            for (background, expected) in [("white", [255; 4]), ("#0a80ff", [10, 128, 255, 255])] {
                let settings = [("tone", tone), ("exposure", exposure), ("background", background)];
                let image = display_image(&color_chart(), (48, 32), &settings);
                assert_eq!(image.pixels[0], expected, "{settings:?}");
                // The cards are not the background.
                assert_ne!(image.pixels[4 * 48 + 4], expected, "{settings:?}");
                assert!(image.pixels.iter().all(|pixel| pixel[3] == 255));
            }
        }
    }
}
