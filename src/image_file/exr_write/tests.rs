use exr::image::SpecificChannels;
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::Vec2;

use super::*;
use crate::image::{Channel, ColorEncoding, PixelWindow, RenderedScene, half_from_f32};
use crate::image_file::exr_rgba::read_first_part;
use crate::image_file::{RunStamp, StoredFrame, decode_exr_rgba, inspect_exr};

fn attributes() -> FrameAttributes {
    FrameAttributes {
        software: "rayframe test".to_owned(),
        render_hash: "00ff".to_owned(),
        frame: -3,
        time_seconds: -0.125,
        frames_per_second: (24000, 1001),
        world_to_camera: [0.5; 16],
        world_to_ndc: [0.25; 16],
        time_code: Some([1, 2, 3, 4]),
        texts: vec![("own".to_owned(), "Žlutý".to_owned())],
        stamp: None,
    }
}

/// Every value is a multiple of 1/64 below 32, which a half holds exactly (11 significant bits).
fn gradient(width: u32, height: u32) -> Vec<[f32; 4]> {
    (0..width * height)
        .map(|i| [(i % 1024) as f32 / 64.0, (i / 1024) as f32, -((i % 7) as f32), 1.0])
        .collect()
}

/// An image whose data window begins at (3, 5).
fn image((width, height): (u32, u32), channels: Vec<Channel>) -> Image {
    Image {
        display_window: PixelWindow::full(100, 90),
        data_window: PixelWindow { x0: 3, y0: 5, x1: 3 + width, y1: 5 + height },
        encoding: ColorEncoding::Linear,
        channels,
        scene: RenderedScene::default(),
    }
}

/// RGBA halves with ZIP compression, the default of the program.
fn encode(size: (u32, u32)) -> Vec<u8> {
    encode_by(ExrCompression::Zip, size)
}

/// RGBA halves.
fn encode_by(compression: ExrCompression, size: (u32, u32)) -> Vec<u8> {
    let pixels = gradient(size.0, size.1);
    let channel = |(component, name): (usize, &str)| Channel {
        name: name.to_owned(),
        samples: Samples::Half(pixels.iter().map(|pixel| half_from_f32(pixel[component])).collect()),
    };
    let channels = ["R", "G", "B", "A"].into_iter().enumerate().map(channel).collect();
    encode_exr(image(size, channels), compression, &attributes()).unwrap()
}

#[test]
fn written_pixels_are_read_back() {
    // 37 rows: two whole blocks of 16 scan lines and a part of one.
    let image = decode_exr_rgba("a.exr".as_ref(), &encode((61, 37)), u64::MAX).unwrap();
    assert_eq!(image.size, (61, 37));
    assert_eq!(image.pixels, gradient(61, 37));
}

#[test]
fn bytes_do_not_depend_on_threads_or_on_the_run() {
    // With attributes left in hash-map order, 20 runs agree with probability (1/6)^19.
    let expected = encode((61, 37));
    for threads in [1, 2, 3, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for _ in 0..5 {
            assert!(pool.install(|| encode((61, 37))) == expected);
        }
    }
}

/// Compares a file with that of the `exr` crate's own writer in one thread.
#[test]
fn an_uncompressed_file_equals_that_of_the_plain_writer() {
    let (size, attributes) = ((61, 37), attributes());
    let pixels = gradient(size.0, size.1);
    let channels = SpecificChannels::rgba(|Vec2(x, y): Vec2<usize>| {
        let [r, g, b, a] = pixels[y * 61 + x].map(half_from_f32);
        (r, g, b, a)
    });
    let encoding = Encoding {
        compression: Compression::Uncompressed,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((61, 37), attributes.of_layer((3, 5)), encoding, channels);
    let image = ExrImage::new(attributes.of_image((100, 90)), layer);
    let mut plain = Vec::new();
    image.write().non_parallel().to_buffered(Cursor::new(&mut plain)).unwrap();
    sort_attributes(&mut plain).unwrap();
    seal(&mut plain).unwrap();
    assert!(encode_by(ExrCompression::None, size) == plain);
}

#[test]
fn blocks_compressed_in_parallel_equal_those_of_the_plain_writer() {
    for compression in ExrCompression::ALL {
        let channels =
            || SpecificChannels::rgba(|Vec2(x, y): Vec2<usize>| (x as f32, y as f32, 0.5_f32, 1.0_f32));
        let encoding = Encoding {
            compression: compression.for_exr(),
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        let layer = Layer::new((33, 50), LayerAttributes::default(), encoding, channels());
        let image = ExrImage::from_layer(layer);
        let (mut parallel, mut plain) = (Vec::new(), Vec::new());
        write_compressing_in_parallel(&image, &mut parallel).unwrap();
        image.write().non_parallel().to_buffered(Cursor::new(&mut plain)).unwrap();
        if matches!(compression, ExrCompression::Zip | ExrCompression::Zips) {
            // Another library deflates.
            let [parallel, plain] = [parallel, plain].map(|file| {
                let image = decode_exr_rgba("a.exr".as_ref(), &file, u64::MAX).unwrap();
                (image.size, image.pixels)
            });
            assert!(parallel == plain, "{}", compression.name());
        } else {
            assert!(parallel == plain, "{}", compression.name());
        }
    }
}

/// Channels of each type with values that differ from pixel to pixel, with ids beyond the integers that a float holds.
fn mixed(size: (u32, u32)) -> Image {
    let count = size.0 * size.1;
    let channel = |name: &str, samples| Channel { name: name.to_owned(), samples };
    let floats = |scale: f32| (0..count).map(|i| i as f32 * scale).collect::<Vec<f32>>();
    let channels = vec![
        channel("node_id", Samples::Uint((0..count).map(|i| i.wrapping_mul(0x9e37_79b9)).collect())),
        channel("R", Samples::Half(floats(0.001).into_iter().map(half_from_f32).collect())),
        channel("G", Samples::Half(floats(0.002).into_iter().map(half_from_f32).collect())),
        channel("B", Samples::Half(floats(0.003).into_iter().map(half_from_f32).collect())),
        channel("normal.X", Samples::Float(floats(-1.1))),
        channel("Z", Samples::Float(floats(1e7))),
    ];
    image(size, channels)
}

#[test]
fn lossless_compressions_keep_samples_of_all_types() {
    for compression in ExrCompression::ALL {
        let image = mixed((61, 37));
        let bytes = encode_exr(image.clone(), compression, &attributes()).unwrap();
        let part = read_first_part(&bytes).unwrap();
        let read: Vec<_> = part.layer_data.channel_data.list.iter().collect();
        let names: Vec<_> = read.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R", "Z", "node_id", "normal.X"]);
        for Channel { name, samples } in image.channels {
            let read = read.iter().find(|channel| channel.name.to_string() == name).unwrap();
            if !compression.is_lossy() {
                assert!(read.sample_data == flat_samples(samples), "{name} {}", compression.name());
            }
        }
    }
}

#[test]
fn frames_of_any_compression_are_inspected_and_decoded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for compression in ExrCompression::ALL {
        let bytes = encode_exr(mixed((61, 37)), compression, &attributes()).unwrap();
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(inspect_exr(&path).unwrap().render_hash.as_deref(), Some("00ff"));
        let shown = decode_exr_rgba(&path, &bytes, u64::MAX).unwrap();
        // The cosine transform at its default level errs by less than a hundredth here.
        for (i, pixel) in shown.pixels.iter().enumerate() {
            let expected = [0.001, 0.002, 0.003].map(|scale| half_from_f32(i as f32 * scale).to_f32());
            let most = if compression.is_lossy() { 0.02 * (1.0 + pixel[2]) } else { 0.0 };
            let is_near = (0..3).all(|c| (pixel[c] - expected[c]).abs() <= most);
            assert!(is_near, "{}: {pixel:?} is not {expected:?}", compression.name());
            assert_eq!(pixel[3], 1.0);
        }
        for length in [100, bytes.len() / 2, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(inspect_exr(&path).is_err());
        }
    }
}

#[test]
fn inconsistent_images_are_refused() {
    let whole = mixed((4, 4));
    let refused = |image| encode_exr(image, ExrCompression::Zip, &attributes()).is_err();
    assert!(refused(Image { channels: Vec::new(), ..whole.clone() }));
    assert!(refused(Image { data_window: PixelWindow::full(4, 5), ..whole.clone() }));
    let twice = [whole.channels.clone(), whole.channels[..1].to_vec()].concat();
    assert!(refused(Image { channels: twice, ..whole }));
}

#[test]
fn a_stamp_is_stored_in_attributes() {
    let stamp = RunStamp {
        capture_date: "2026:11:21 18:57:00".to_owned(),
        host: Some("farm7".to_owned()),
        render_seconds: 1.5,
    };
    let stamped = FrameAttributes { stamp: Some(stamp), ..attributes() };
    let bytes = encode_exr(mixed((4, 4)), ExrCompression::None, &stamped).unwrap();
    let header = exr::block::read(Cursor::new(bytes), true).unwrap().headers()[0].clone();
    let own = &header.own_attributes;
    assert_eq!(own.capture_date, Some(Text::from("2026:11:21 18:57:00")));
    assert_eq!(own.utc_offset, Some(0.0));
    assert_eq!(own.other.get(&Text::from("renderSeconds")), Some(&AttributeValue::F32(1.5)));
    assert_eq!(own.other.get(&Text::from("hostComputer")), Some(&AttributeValue::Text("farm7".into())));
    let utf8 = AttributeValue::Text(byte_text("Žlutý"));
    assert_eq!(own.other.get(&Text::from("own")), Some(&utf8));
}

#[test]
fn attributes_are_sorted_by_name() {
    let bytes = encode((2, 2));
    let mut names = Vec::new();
    let mut start = 8;
    while bytes[start] != 0 {
        let length = bytes[start..].iter().position(|&byte| byte == 0).unwrap();
        names.push(String::from_utf8(bytes[start..start + length].to_vec()).unwrap());
        start = attribute_end(&bytes, start).unwrap();
    }
    assert!(names.is_sorted(), "{names:?}");
    for name in [
        "chromaticities",
        "frame",
        "framesPerSecond",
        "renderHash",
        "software",
        "timeCode",
        "timeSeconds",
        "worldToNDC",
    ] {
        assert!(names.iter().any(|n| n == name), "{name} is missing");
    }
}

#[test]
fn truncated_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let bytes = encode((61, 37));
    std::fs::write(&path, &bytes).unwrap();
    let expected = StoredFrame {
        sample_range: None,
        render_hash: Some("00ff".to_owned()),
        preview_hash: None,
        size: (100, 90),
        data_window: PixelWindow { x0: 3, y0: 5, x1: 64, y1: 42 },
    };
    assert_eq!(inspect_exr(&path).unwrap(), expected);
    for length in [0, 3, 8, 100, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..length]).unwrap();
        assert!(inspect_exr(&path).is_err(), "{length} of {} bytes", bytes.len());
    }
}
