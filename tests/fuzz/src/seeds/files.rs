//! Image files and archives.

use std::io::Cursor;

use image::codecs::webp::WebPEncoder;
use image::{DynamicImage, ImageBuffer, ImageFormat};
use rayframe::Renderer;
use rayframe::image_file::encode_png;

use super::{Seed, seed};
use crate::input::joined;
use crate::scratch;
use crate::verdict::must;

/// A scene that takes little time.
const SCENE: &[u8] = include_bytes!("../../../../scenes/scene/default_material.gltf");

/// An image with gradients, edges and transparency.
fn gradient() -> DynamicImage {
    DynamicImage::ImageRgba16(ImageBuffer::from_fn(13, 9, |x, y| {
        let edge = if (x / 3 + y / 2) % 2 == 0 { 60000 } else { 900 };
        image::Rgba([(x * 5000) as u16, (y * 7000) as u16, edge, 65535 - (x * y * 400) as u16])
    }))
}

fn encoded(gradient: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    must(gradient.write_to(&mut bytes, format));
    bytes.into_inner()
}

/// All colour types, and one with a text chunk.
pub(crate) fn pngs() -> Vec<Seed> {
    let gradient = gradient();
    let own = must(encode_png((2, 2), &[[1, 2, 3, 4], [5, 6, 7, 255], [0; 4], [255; 4]], "0123"));
    let kinds = [
        ("rgba16", gradient.clone()),
        ("rgb16", gradient.to_rgb16().into()),
        ("rgba8", gradient.to_rgba8().into()),
        ("rgb8", gradient.to_rgb8().into()),
        ("grey16", gradient.to_luma16().into()),
        ("grey8", gradient.to_luma8().into()),
        ("grey_alpha8", gradient.to_luma_alpha8().into()),
    ];
    let mut seeds: Vec<Seed> =
        kinds.iter().map(|(name, image)| seed(*name, encoded(image, ImageFormat::Png))).collect();
    seeds.push(seed("frame", own));
    seeds
}

/// In colour and grey.
pub(crate) fn jpegs() -> Vec<Seed> {
    let gradient = gradient();
    vec![
        seed("rgb", encoded(&gradient.to_rgb8().into(), ImageFormat::Jpeg)),
        seed("grey", encoded(&gradient.to_luma8().into(), ImageFormat::Jpeg)),
    ]
}

/// With and without loss, and with alpha.
pub(crate) fn webps() -> Vec<Seed> {
    let mut alpha = Vec::new();
    must(DynamicImage::from(gradient().to_rgba8()).write_with_encoder(WebPEncoder::new_lossless(&mut alpha)));
    vec![
        seed("chequer", include_bytes!("../../../streams/chequer.webp")),
        seed("lossy", include_bytes!("../../../streams/lossy.webp")),
        seed("alpha", alpha),
    ]
}

/// Both codecs.
pub(crate) fn ktx2s() -> Vec<Seed> {
    vec![
        seed("etc1s", include_bytes!("../../../streams/chequer_etc1s.ktx2")),
        seed("uastc", include_bytes!("../../../streams/chequer_uastc.ktx2")),
    ]
}

/// With and without run lengths.
pub(crate) fn hdrs() -> Vec<Seed> {
    let plain = encoded(&gradient().to_rgb32f().into(), ImageFormat::Hdr);
    vec![
        seed("quarters", include_bytes!("../../../../scenes/environment/quarters.hdr")),
        seed("lines", plain),
    ]
}

/// A frame of 9x6 pixels with settings, as a file.
fn frame(settings: &[(&str, &str)]) -> Vec<u8> {
    let mut renderer = must(Renderer::open(scratch::file("seed.gltf", SCENE))).size(9, 6).samples(2);
    for (name, value) in settings {
        renderer = must(renderer.set(name, value));
    }
    let path = scratch::path("seed.exr");
    must(must(renderer.frame(0)).write_exr(&path));
    must(std::fs::read(path))
}

/// Every compression with all AOVs, halves and floats, and a crop.
pub(crate) fn exrs() -> Vec<Seed> {
    let compressions = ["none", "rle", "zips", "zip", "piz", "dwaa", "dwab"];
    let mut seeds = Vec::new();
    for name in compressions {
        seeds.push(seed(format!("half_{name}"), frame(&[("exr", &format!("half,{name}"))])));
        seeds.push(seed(
            format!("float_{name}"),
            frame(&[("exr", &format!("float,{name}")), ("aovs", "all")]),
        ));
    }
    seeds.push(seed("crop", frame(&[("crop", "2,1,7,5")])));
    seeds
}

/// Two halves of a frame, and two ranges of samples.
pub(crate) fn tiles() -> Vec<Seed> {
    let halves = [frame(&[("crop", "0,0,9,3")]), frame(&[("crop", "0,3,9,6")])];
    let range = |samples| frame(&[("integrator", "path"), ("samples", "4"), ("sample_range", samples)]);
    let ranges = [range("0-1"), range("2-3")];
    let seed_of = |name, [first, second]: [Vec<u8>; 2]| seed(name, joined(&[&first, &second]));
    vec![seed_of("halves", halves), seed_of("ranges", ranges)]
}

/// Channels of random numbers, and pairs of files.
pub(crate) fn image_pairs() -> Vec<Seed> {
    let mut seeds = super::triangles();
    let exr = frame(&[("aovs", "object_id,crypto_object")]);
    let png = encoded(&gradient().to_rgba8().into(), ImageFormat::Png);
    let hdr = encoded(&gradient().to_rgb32f().into(), ImageFormat::Hdr);
    for (name, a, b) in
        [("exrs", &exr, &frame(&[("fov", "40")])), ("pngs", &png, &png), ("png_and_hdr", &png, &hdr)]
    {
        seeds.push(seed(name, [&[1][..], &joined(&[a, b])].concat()));
    }
    seeds
}

/// The list of images, stored, at the top and in a folder.
pub(crate) fn archives() -> Vec<Seed> {
    let lists = super::rendered();
    let list = lists.first().map(|list| list.bytes.clone()).unwrap_or_default();
    vec![seed("top", archive("images.json", &list)), seed("folder", archive("report/images.json", &list))]
}

/// A zip archive of one stored file.
fn archive(name: &str, content: &[u8]) -> Vec<u8> {
    let (length, checksum) = (content.len() as u32, crc32fast::hash(content));
    let mut entry = Vec::new();
    entry.extend([20, 0, 0, 0, 0, 0, 0, 0, 33, 0]);
    for number in [checksum, length, length, name.len() as u32] {
        entry.extend(number.to_le_bytes());
    }
    let local = [b"PK\x03\x04", entry.as_slice(), name.as_bytes(), content].concat();
    let directory = [b"PK\x01\x02\x14\0", entry.as_slice(), &[0; 14], name.as_bytes()].concat();
    let mut end = b"PK\x05\x06\0\0\0\0\x01\0\x01\0".to_vec();
    end.extend((directory.len() as u32).to_le_bytes());
    end.extend((local.len() as u32).to_le_bytes());
    end.extend([0, 0]);
    [local, directory, end].concat()
}
