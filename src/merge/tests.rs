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
    let tiles = [ExrTile::new("crop.exr".into(), header)];
    // 20 pixels of 10 bytes in six copies are 1200 bytes; the whole image in three is 360 MB.
    assert!(check_memory(&tiles, true, 1200).is_ok());
    let message = |are_sample_ranges| check_memory(&tiles, are_sample_ranges, 1199).unwrap_err().to_string();
    assert!(message(true).contains("merging 5x4 pixels"), "{}", message(true));
    assert!(message(false).contains("merging 4000x3000 pixels"), "{}", message(false));
}

/// Writes 5x4 pixels of halves in the channels `names` and in `further` others, as a sample range if it has one.
fn write_tile(path: &Path, names: &[&str], further: usize, range: Option<&str>) {
    let names = names.iter().map(|&name| name.to_owned());
    let names = names.chain((0..further).map(|index| format!("further.{index:03}")));
    let samples = Samples::Half(vec![half::f16::ONE; 20]);
    let image = Image {
        display_window: PixelWindow::full(5, 4),
        data_window: PixelWindow::full(5, 4),
        encoding: ColorEncoding::Linear,
        scene: RenderedScene::default(),
        channels: names.map(|name| Channel { name, samples: samples.clone() }).collect(),
    };
    let texts = range.map(|range| (SAMPLE_RANGE.to_owned(), range.to_owned())).into_iter().collect();
    let attributes = FrameAttributes { texts, ..FrameAttributes::unknown() };
    std::fs::write(path, encode_exr(image, ExrCompression::Zip, &attributes).unwrap()).unwrap();
}

/// The error of merging `tiles`.
fn refusal(tiles: &[PathBuf]) -> String {
    let output = OutputPattern::parse("whole.exr".as_ref()).unwrap();
    let error = MergePlan::new(tiles, &output, true, 1 << 20).unwrap_err();
    assert_eq!(error.exit_code(), 65);
    error.to_string()
}

#[test]
fn mixtures_of_crops_and_sample_ranges_are_told_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let [crop, other, range] = ["crop.exr", "other.exr", "range.exr"].map(|name| folder.path().join(name));
    write_tile(&crop, &["B", "G", "R"], 0, None);
    write_tile(&other, &["B", "G", "R"], 0, None);
    write_tile(&range, &["B", "G", "R"], 200, Some("0-1/4"));
    let hint = "merge the sample ranges of each crop first, and then the crops";
    let message = refusal(&[crop.clone(), range.clone()]);
    assert!(message.contains("crop.exr: has all samples, but ") && message.ends_with(hint), "{message}");
    let message = refusal(&[crop, range, other]);
    assert!(message.contains("range.exr: holds only some samples, but "), "{message}");
    assert!(message.ends_with(hint), "{message}");
}

#[test]
fn only_channels_that_differ_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let [usual, same, foreign] =
        ["usual.exr", "same.exr", "foreign.exr"].map(|name| folder.path().join(name));
    for path in [&usual, &same] {
        write_tile(path, &["B", "G", "R"], 0, None);
    }
    let message = |names: &[&str], further| {
        write_tile(&foreign, names, further, None);
        refusal(&[usual.clone(), same.clone(), foreign.clone()])
    };
    for (names, further, words) in [
        (&["B", "G", "Y"][..], 0, "foreign.exr: has the channels Y half, not R half as "),
        (&["B", "R"], 0, "foreign.exr: lacks the channels G half of "),
        (&["A", "B", "G", "R"], 0, "foreign.exr: has the channels A half besides those of "),
        (
            &["B", "G", "R"],
            200,
            "foreign.exr: has the channels further.000 half, further.001 half, further.002 half, further.003 half and 196 more \
             besides those of ",
        ),
    ] {
        let message = message(names, further);
        assert!(message.contains(words) && message.ends_with("usual.exr"), "{message}");
    }
}

/// Plans keep no manifest of a tile: there may be thousands of tiles, each with the names of all instances.
#[test]
fn manifests_are_compared_and_kept_without_being_planned() {
    const MANIFEST: &str = "cryptomatte/0123456/manifest";
    let folder = tempfile::tempdir().unwrap();
    let tile = |name: &str, x0: u32, manifest: &str| {
        let image = Image {
            display_window: PixelWindow::full(10, 4),
            data_window: PixelWindow { x0, y0: 0, x1: x0 + 5, y1: 4 },
            encoding: ColorEncoding::Linear,
            scene: RenderedScene::default(),
            channels: vec![Channel {
                name: "R".to_owned(),
                samples: Samples::Half(vec![half::f16::ONE; 20]),
            }],
        };
        let texts = vec![(MANIFEST.to_owned(), manifest.to_owned())];
        let attributes =
            FrameAttributes { render_hash: "00ff".to_owned(), texts, ..FrameAttributes::unknown() };
        let path = folder.path().join(name);
        std::fs::write(&path, encode_exr(image, ExrCompression::Zip, &attributes).unwrap()).unwrap();
        path
    };
    let manifest = format!("{{\"{}a\":\"00000000\"}}", "n".repeat(1 << 20));
    let tiles = [tile("left.exr", 0, &manifest), tile("right.exr", 5, &manifest)];
    let whole = folder.path().join("whole.exr");
    let output = OutputPattern::parse(whole.as_os_str()).unwrap();
    let planned = || MergePlan::new(&tiles, &output, false, 1 << 30);

    let plan = planned().unwrap();
    let attributes = plan.frames[0].tiles.iter().flat_map(|tile| tile.header.shared().into_values());
    assert!(attributes.map(<[u8]>::len).sum::<usize>() < 10_000);
    let joined = join_frame(&plan.frames[0]).unwrap();
    std::fs::write(&whole, joined).unwrap();
    assert_eq!(ExrHeader::read(&whole).unwrap().text(MANIFEST).as_deref(), Some(manifest.as_str()));
    assert!(planned().unwrap().frames[0].is_done);

    tile("right.exr", 5, &manifest.replace("na", "nb"));
    let changed = join_frame(&plan.frames[0]).unwrap_err().to_string();
    assert!(changed.contains("was changed while it was merged"), "{changed}");
    let foreign = planned().unwrap_err().to_string();
    assert!(foreign.contains(&format!("has another attribute \"{MANIFEST}\" than ")), "{foreign}");
}
