//! Tests on streams of the reference encoder, intact and corrupted.

use std::time::{Duration, Instant};

use base64::Engine;
use serde_json::{Value, json};

use super::super::tests::Document;
use super::*;

/// Stream of `streams.json`, which `tests/oracles/meshopt_streams.mjs` wrote with the reference encoder. `decoded` is
/// the output of the reference decoder.
struct Sample {
    name: String,
    mode: Mode,
    filter: Filter,
    count: usize,
    stride: usize,
    stream: Vec<u8>,
    decoded: Vec<u8>,
}

fn samples() -> Vec<Sample> {
    let list: Vec<Value> = serde_json::from_str(include_str!("streams.json")).unwrap();
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let bytes =
        |value: &Value| base64::engine::general_purpose::STANDARD.decode(value.as_str().unwrap()).unwrap();
    let sample = |value: &Value| Sample {
        name: value["name"].as_str().unwrap().to_owned(),
        mode: match value["mode"].as_str().unwrap() {
            "ATTRIBUTES" => Mode::Attributes,
            "TRIANGLES" => Mode::Triangles,
            _ => Mode::Indices,
        },
        filter: match value["filter"].as_str().unwrap() {
            "OCTAHEDRAL" => Filter::Octahedral,
            "QUATERNION" => Filter::Quaternion,
            "EXPONENTIAL" => Filter::Exponential,
            "COLOR" => Filter::Color,
            _ => Filter::None,
        },
        count: number(&value["count"]),
        stride: number(&value["stride"]),
        stream: bytes(&value["stream"]),
        decoded: bytes(&value["decoded"]),
    };
    list.iter().map(sample).collect()
}

fn decompress(sample: &Sample, stream: &[u8]) -> std::result::Result<Vec<u8>, Malformed> {
    let mut output = Vec::new();
    decode(stream, sample.mode, Layout { count: sample.count, stride: sample.stride }, &mut output)?;
    sample.filter.apply(&mut output, sample.stride);
    Ok(output)
}

/// Largest difference between components of filtered data. One step is within tolerance.
fn max_difference(sample: &Sample, found: &[u8]) -> u32 {
    let components = |bytes: &[u8]| -> Vec<i32> {
        let pairs = bytes.as_chunks::<2>().0.iter();
        match (sample.filter, sample.stride) {
            (Filter::Octahedral, 4) => bytes.iter().map(|byte| i32::from(*byte as i8)).collect(),
            (Filter::Color, 4) => bytes.iter().map(|byte| i32::from(*byte)).collect(),
            (Filter::Color, _) => pairs.map(|pair| i32::from(u16::from_le_bytes(*pair))).collect(),
            _ => pairs.map(|pair| i32::from(i16::from_le_bytes(*pair))).collect(),
        }
    };
    let pairs = components(found).into_iter().zip(components(&sample.decoded));
    pairs.map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}

#[test]
fn streams_of_the_reference_encoder_are_decoded() {
    let samples = samples();
    assert_eq!(samples.len(), 44);
    for sample in &samples {
        let found =
            decompress(sample, &sample.stream).unwrap_or_else(|why| panic!("{}: {why:?}", sample.name));
        assert_eq!(found.len(), sample.decoded.len(), "{}", sample.name);
        if matches!(sample.filter, Filter::None | Filter::Exponential) {
            assert!(found == sample.decoded, "{}", sample.name);
        } else {
            assert!(max_difference(sample, &found) <= 1, "{}", sample.name);
        }
    }
}

#[test]
fn corrupted_streams_end_quickly_and_without_panic() {
    let started = Instant::now();
    let mut refused = 0_u32;
    for sample in &samples() {
        for length in (0..sample.stream.len()).step_by(sample.stream.len() / 24 + 1) {
            assert!(decompress(sample, &sample.stream[..length]).is_err(), "{} cut to {length}", sample.name);
        }
        let mut state = 1_u32;
        for _ in 0..40 {
            let mut stream = sample.stream.clone();
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            let place = state as usize % stream.len();
            stream[place] ^= 1 << (state >> 29);
            match decompress(sample, &stream) {
                Ok(found) => assert_eq!(found.len(), sample.decoded.len()),
                Err(_) => refused += 1,
            }
        }
    }
    assert!(refused > 100, "{refused}");
    assert!(started.elapsed() < Duration::from_secs(30));
}

/// Triangle whose positions are the compressed floats of a sample, without uncompressed data.
fn compressed_triangle() -> Document {
    let sample = samples().into_iter().find(|sample| sample.name == "floats v1").unwrap();
    let mut document = Document::triangle();
    let view = document.view(&sample.stream);
    let mut extension = document.json["bufferViews"][view].clone();
    extension["byteStride"] = json!(sample.stride);
    extension["count"] = json!(sample.count);
    extension["mode"] = json!("ATTRIBUTES");
    document.json["bufferViews"][view] = json!({
        "buffer": 1, "byteLength": sample.decoded.len(), "byteStride": 12,
        "extensions": {"KHR_meshopt_compression": extension}
    });
    let accessor = json!({"bufferView": view, "componentType": 5126, "type": "VEC3", "count": sample.count});
    let accessor = document.push("accessors", accessor);
    document.set_attribute("POSITION", accessor);
    document.json["extensionsRequired"] = json!(["KHR_meshopt_compression"]);
    document.more_buffers = vec![json!({
        "byteLength": sample.decoded.len(), "uri": "not_there.bin",
        "extensions": {"KHR_meshopt_compression": {"fallback": true}}
    })];
    document
}

fn extension(document: &mut Document) -> &mut Value {
    &mut document.json["bufferViews"][1]["extensions"]["KHR_meshopt_compression"]
}

#[test]
fn compressed_views_fill_accessors() {
    let scene = compressed_triangle().import().unwrap();
    assert!(scene.warnings.iter().all(|warning| warning.message.contains("complete a triangle")));
    // 77 consecutive vertices: 25 triangles. Vertex i is cos(3i/9) · 1, cos((3i + 1)/9) · 2, cos((3i + 2)/9) · 3.
    let primitive = &scene.meshes[0].primitives[0];
    assert_eq!(primitive.triangles.len(), 25);
    let vertex = primitive.positions[primitive.triangles[1][0] as usize];
    assert!((vertex.y - 2.0 * libm::cosf(10.0 / 9.0)).abs() < 1e-6, "{vertex}");
}

#[test]
fn invalid_extensions_are_errors_with_a_pointer() {
    for (key, value, expected) in [
        ("byteStride", json!(10), "/byteStride: must be a multiple of 4"),
        ("mode", json!("POINTS"), "/mode: must be"),
        ("filter", json!("GAUSS"), "/filter: must be"),
        ("filter", json!("QUATERNION"), "/filter: does not support"),
        ("count", json!(76), "do not fill"),
        ("count", json!(1_u64 << 62), "do not fill"),
        ("byteLength", json!(1 << 20), "extends past"),
        ("byteLength", json!(20), "the compressed data ends too early"),
        ("buffer", json!(1), "has no data"),
        ("buffer", json!(7), "there is no buffer 7"),
        ("byteOffset", json!(0), "the compressed data does not begin"),
    ] {
        let mut document = compressed_triangle();
        extension(&mut document)[key] = value;
        let text = document.error(65);
        assert!(text.contains(expected), "{key}: {text}");
        assert!(text.contains("/bufferViews/1/extensions/KHR_meshopt_compression"), "{text}");
    }
    let mut document = compressed_triangle();
    document.json["bufferViews"][1]["extensions"]["EXT_meshopt_compression"] = json!({});
    assert!(document.error(65).contains("together"));
}
