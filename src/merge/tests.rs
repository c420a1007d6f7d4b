use super::*;
use crate::image::{Channel, ColorEncoding, Image, RenderedScene, Samples};
use crate::image_file::{ExrCompression, FrameAttributes, encode_exr};

/// An image of 5x4 pixels with samples of each type.
fn whole_image(compression: ExrCompression) -> Vec<u8> {
    crop_of(PixelWindow::full(5, 4), compression)
}

/// The same 5x4 pixels as a crop of an image with the pixels `display_window`.
fn crop_of(display_window: PixelWindow, compression: ExrCompression) -> Vec<u8> {
    let channel = |name: &str, samples| Channel { name: name.to_owned(), samples };
    let image = Image {
        display_window,
        data_window: PixelWindow::full(5, 4),
        encoding: ColorEncoding::Linear,
        scene: RenderedScene::default(),
        channels: vec![
            channel("R", Samples::Half((0..20_u8).map(half::f16::from).collect())),
            channel("Z", Samples::Float((0..20_u8).map(f32::from).collect())),
            channel("id", Samples::Uint((0..20).collect())),
        ],
    };
    let attributes = FrameAttributes {
        software: "rayframe test".to_owned(),
        render_hash: "00ff".to_owned(),
        frame: 3,
        time_seconds: 0.5,
        frames_per_second: (24, 1),
        world_to_camera: [0.5; 16],
        world_to_ndc: [0.25; 16],
        time_code: Some([1, 2, 3, 4]),
        texts: Vec::new(),
        stamp: None,
    };
    encode_exr(image, compression, &attributes).unwrap()
}

/// The merged file of one tile.
fn merged(tile: &Path) -> Result<Vec<u8>> {
    let output = OutputPattern::parse("whole.exr".as_ref()).unwrap();
    let plan = MergePlan::new(&[tile.to_owned()], &output, true, 1 << 20)?;
    join_exr_tiles(&plan.frames[0].tiles)
}

/// Changes bytes of a tile, by one bit and to 255: every third one, and others in each compression. The tile is merged or refused, without
/// an internal error.
#[test]
fn broken_tiles_are_refused_and_never_an_internal_error() {
    let folder = tempfile::tempdir().unwrap();
    let tile = folder.path().join("tile.exr");
    for (first, compression) in
        [ExrCompression::None, ExrCompression::Zip, ExrCompression::Piz].into_iter().enumerate()
    {
        let bytes = whole_image(compression);
        std::fs::write(&tile, &bytes).unwrap();
        assert!(merged(&tile).unwrap() == bytes);

        let mut refused = 0;
        for at in (first..bytes.len()).step_by(3) {
            for value in [bytes[at] ^ 1, 255] {
                let mut broken = bytes.clone();
                broken[at] = value;
                std::fs::write(&tile, &broken).unwrap();
                if let Err(error) = merged(&tile) {
                    assert!(matches!(error.exit_code(), 65 | 77), "byte {at} as {value}: {error}");
                    refused += 1;
                }
            }
        }
        assert!(refused > 30, "{refused}");
        for length in (first..bytes.len()).step_by(3) {
            std::fs::write(&tile, &bytes[..length]).unwrap();
            assert_eq!(merged(&tile).unwrap_err().exit_code(), 65, "{length} bytes");
        }
    }
}

#[test]
fn sample_ranges_of_a_crop_need_the_memory_of_the_crop() {
    let bytes = crop_of(PixelWindow::full(4000, 3000), ExrCompression::None);
    let header = ExrHeader::parse(&mut bytes.as_slice()).unwrap();
    let tiles = [ExrTile { path: "crop.exr".into(), header }];
    // 20 pixels of 10 bytes in six copies are 1200 bytes; the whole image in three is 360 MB.
    assert!(check_memory(&tiles, true, 1200).is_ok());
    let message = |are_sample_ranges| check_memory(&tiles, are_sample_ranges, 1199).unwrap_err().to_string();
    assert!(message(true).contains("merging 5x4 pixels"), "{}", message(true));
    assert!(message(false).contains("merging 4000x3000 pixels"), "{}", message(false));
}
