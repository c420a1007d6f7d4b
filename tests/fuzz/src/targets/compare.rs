//! Comparison of two images: files of any supported format, or channels of any values.

use std::path::Path;

use rayframe::Error;
use rayframe::image::RenderedScene;
use rayframe::image_file::plate_header;
use rayframe::regression::{
    Channel, ColorEncoding, EncodedImage, Image, Limits, Preset, Samples, are_identical, compare,
    heat_map_thumbnail, pixel_hash,
};
use rayframe::settings::PixelWindow;

use crate::input::Input;
use crate::verdict::{LIBRARY_LIMIT, accepted};

/// Largest number of pixels of decoded files, so that a run is short.
const MAX_PIXELS: usize = 64 * 64;

/// Compares two images.
pub(crate) fn diff(input: &[u8]) {
    let mut input = Input::new(input);
    let kind = input.u8();
    let (a, b) = if kind.is_multiple_of(2) {
        (image(&mut input), image(&mut input))
    } else {
        let mut decoded = || decoded(input.part());
        let (Some(a), Some(b)) = (decoded(), decoded()) else { return };
        (a, b)
    };
    if a.data_window.pixel_count() > MAX_PIXELS || b.data_window.pixel_count() > MAX_PIXELS {
        return;
    }
    check(&a, &b, &Preset::ALL[usize::from(kind / 2) % Preset::ALL.len()].limits());
}

/// An image of any format, unless it is large.
fn decoded(bytes: &[u8]) -> Option<Image> {
    let path = Path::new("a");
    let is_large =
        plate_header(path, bytes, LIBRARY_LIMIT).is_err_and(|error| matches!(error, Error::Refused { .. }));
    if is_large { None } else { accepted(Image::decode(path, bytes)) }
}

fn check(a: &Image, b: &Image, limits: &Limits) {
    let comparison = compare(a, b, limits);
    let are_same = are_identical(a, b);
    assert!(!are_same || pixel_hash(a) == pixel_hash(b), "identical images have different hashes");
    assert!(are_identical(a, a), "an image differs from itself");
    // Values that are not finite fail, even where both sides have them.
    if is_finite(a) {
        assert!(compare(a, a, limits).passes(), "an image fails against itself");
        assert!(!are_same || comparison.passes(), "identical images fail: {comparison:?}");
    }
    if let Some(encoded) = EncodedImage::new(a) {
        drop(heat_map_thumbnail(&encoded, 16));
    }
}

fn is_finite(image: &Image) -> bool {
    let mut floats = image.channels.iter().filter_map(|channel| channel.samples.floats());
    floats.all(|values| values.iter().all(|value| value.is_finite()))
}

/// An image of up to 16x16 pixels in a display window of up to 32x32.
fn image(input: &mut Input<'_>) -> Image {
    let mut side = |most: u8| u32::from(input.u8() % most);
    let (x0, y0, width, height) = (side(16), side(16), 1 + side(16), 1 + side(16));
    let data_window = PixelWindow { x0, y0, x1: x0 + width, y1: y0 + height };
    let pixels = data_window.pixel_count();
    let names = ["R", "G", "B", "A", "Z", "normal.X", "node_id", "crypto_object00.R"];
    let chosen = input.u8();
    let is_on_grid = input.u8().is_multiple_of(2);
    let mut channels = Vec::new();
    for (bit, name) in names.iter().enumerate().filter(|(bit, _)| chosen >> bit & 1 == 1) {
        let mut number = || if is_on_grid { input.grid_number() } else { input.f32() };
        let samples = if bit == 6 {
            Samples::Uint((0..pixels).map(|_| number().to_bits()).collect())
        } else {
            Samples::Float((0..pixels).map(|_| number()).collect())
        };
        channels.push(Channel { name: (*name).to_owned(), samples });
    }
    let encoding = if input.u8().is_multiple_of(2) { ColorEncoding::Linear } else { ColorEncoding::Srgb };
    let display_window = PixelWindow::full(32, 32);
    Image { display_window, data_window, encoding, channels, scene: RenderedScene::default() }
}
