//! KTX2 decoding: files with Basis Universal data (`KHR_texture_basisu`) to the texels of the first level, face and layer.
//!
//! Sources: *KTX File Format Specification 2.0* (Khronos Group, 2021), sections 3 and 4; the text of `KHR_texture_basisu`.
//! The crate `basisu` decodes the blocks. Sizes are checked here before it allocates memory.

use super::texture_format::ImageHeader;

const TEXEL_BYTES: u64 = 4;
/// Largest number of texels: the decoder counts bytes in 32 bits.
const MAX_TEXELS: u64 = 1 << 28;
/// Message after a panic of the decoder.
#[cfg(any(test, feature = "basis"))]
const PANICKED: &str = "cannot be decoded";
const LEVEL_INDEX_START: usize = 80;
const LEVEL_INDEX_ENTRY: usize = 24;
/// Supercompression scheme.
const ZSTANDARD: u32 = 2;
/// Colour models of the data format descriptor.
const MODEL_ETC1S: u32 = 163;
const MODEL_UASTC: u32 = 166;

/// Parsed header of a file.
#[derive(Clone, Copy, Debug)]
struct Header {
    size: (u32, u32),
    /// Bytes of the decompressed first level; 0 if the compression scheme does not state them.
    level_bytes: u64,
    /// Whether the colour holds red and alpha holds green.
    is_red_green: bool,
}

/// Reads the size of the first level and the memory that decoding it takes.
pub(super) fn header(bytes: &[u8]) -> Result<ImageHeader, String> {
    let header = parse_header(bytes)?;
    let (width, height) = header.size;
    let texels = u64::from(width).saturating_mul(u64::from(height));
    // A decompressed copy exists at the same time as the texels.
    let decoded_bytes = texels.saturating_mul(TEXEL_BYTES).saturating_add(header.level_bytes);
    Ok(ImageHeader { width, height, texel_bytes: TEXEL_BYTES, decoded_bytes })
}

/// Decodes the first level.
pub(super) fn decode(bytes: &[u8]) -> Result<Vec<[u8; 4]>, String> {
    let header = parse_header(bytes)?;
    let channels = transcode(bytes)?;
    let (texels, _) = channels.as_chunks::<4>();
    let expected = u64::from(header.size.0) * u64::from(header.size.1);
    if texels.len() as u64 != expected {
        return Err(format!("has {} texels, but its header states {expected}", texels.len()));
    }
    let mut texels = texels.to_vec();
    if header.is_red_green {
        for texel in &mut texels {
            *texel = [texel[0], texel[3], 0, u8::MAX];
        }
    }
    Ok(texels)
}

/// Channels of the texels of the first level, as RGBA. A panic of the third-party decoder is an error.
#[cfg(feature = "basis")]
fn transcode(bytes: &[u8]) -> Result<Vec<u8>, String> {
    use basisu::{DecodeFlags, SourceFormat, TargetFormat, Transcoder};
    let decoded = std::panic::catch_unwind(|| {
        let transcoder = Transcoder::new(bytes)?;
        match transcoder.source_format() {
            SourceFormat::Etc1s | SourceFormat::UastcLdr => {}
            source => return Err(basisu::Error::Unsupported { source, target: TargetFormat::Rgba32 }),
        }
        transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE)
    });
    match decoded {
        Ok(Ok(channels)) => Ok(channels),
        Ok(Err(error)) => Err(format!("cannot be decoded: {error:?}")),
        Err(_) => Err(PANICKED.to_owned()),
    }
}

#[cfg(not(feature = "basis"))]
fn transcode(_: &[u8]) -> Result<Vec<u8>, String> {
    Err("is Basis Universal data, which this build of Rayframe does not decode; build it with the feature \"basis\"".to_owned())
}

fn parse_header(bytes: &[u8]) -> Result<Header, String> {
    let field = |start: usize| read_u32(bytes, start);
    let format = field(12)?;
    let (width, height, depth) = (field(20)?, field(24)?, field(28)?);
    let (layers, faces, levels, scheme) = (field(32)?, field(36)?, field(40)?, field(44)?);
    let descriptor = field(48)? as usize;
    let model = field(descriptor.saturating_add(12))? & 0xff;
    let first_channel = field(descriptor.saturating_add(28))? >> 24 & 15;
    let second_channel = field(descriptor.saturating_add(44)).map_or(0, |word| word >> 24 & 15);
    if format != 0 || !matches!(model, MODEL_ETC1S | MODEL_UASTC) {
        return Err(format!(
            "is KTX2 with {}; only Basis Universal data is supported, so convert it to that or to PNG",
            if format == 0 { format!("colour model {model}") } else { format_name(format) }
        ));
    }
    if width == 0 || height == 0 || depth != 0 || layers > 1 || faces != 1 {
        return Err(format!(
            "is KTX2 of {width}x{height}x{depth}, {layers} layers and {faces} faces, not a 2D image"
        ));
    }
    if u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(format!("has {width}x{height} texels, more than the {MAX_TEXELS} that can be decoded"));
    }
    if !(1..=32).contains(&levels) {
        return Err(format!("has {levels} levels, which is out of range"));
    }

    let blocks = u64::from(width.div_ceil(4)).saturating_mul(u64::from(height.div_ceil(4)));
    let max_bytes = if model == MODEL_UASTC { blocks.saturating_mul(16) } else { 0 };
    let level_bytes = check_levels(bytes, levels, scheme, max_bytes)?;
    let is_red_green = match model {
        MODEL_ETC1S => first_channel == 3 && second_channel == 4,
        _ => first_channel == 5,
    };
    Ok(Header { size: (width, height), level_bytes, is_red_green })
}

/// Checks that every level lies inside the file and that the first decompresses to at most `max_bytes`. Returns the
/// bytes of the decompressed first level, or 0 if the compression scheme does not state them.
fn check_levels(bytes: &[u8], levels: u32, scheme: u32, max_bytes: u64) -> Result<u64, String> {
    let mut level_bytes = 0;
    for level in 0..levels as usize {
        let entry = LEVEL_INDEX_START + level * LEVEL_INDEX_ENTRY;
        let (start, length) = (read_u64(bytes, entry)?, read_u64(bytes, entry + 8)?);
        let decompressed = read_u64(bytes, entry + 16)?;
        if start.checked_add(length).is_none_or(|end| end > bytes.len() as u64) {
            return Err(format!("ends before level {level}; the file is truncated"));
        }
        if level == 0 && scheme == ZSTANDARD {
            level_bytes = decompressed;
        }
    }
    if level_bytes > max_bytes {
        return Err(format!(
            "decompresses its first level to {level_bytes} bytes, more than the {max_bytes} of its texels"
        ));
    }
    Ok(level_bytes)
}

fn read_u32(bytes: &[u8], start: usize) -> Result<u32, String> {
    let field = bytes.get(start..).and_then(|rest| rest.first_chunk::<4>());
    field.map(|field| u32::from_le_bytes(*field)).ok_or_else(|| "ends inside its header".to_owned())
}

fn read_u64(bytes: &[u8], start: usize) -> Result<u64, String> {
    Ok(u64::from(read_u32(bytes, start)?) | u64::from(read_u32(bytes, start + 4)?) << 32)
}

/// Vulkan name of a texture format.
fn format_name(format: u32) -> String {
    let name = match format {
        9 => "R8_UNORM",
        16 => "R8G8_UNORM",
        23 => "R8G8B8_UNORM",
        29 => "R8G8B8_SRGB",
        37 => "R8G8B8A8_UNORM",
        43 => "R8G8B8A8_SRGB",
        97 => "R16G16B16A16_SFLOAT",
        131..=134 => "BC1 blocks",
        135 | 136 => "BC2 blocks",
        137 | 138 => "BC3 blocks",
        139..=142 => "BC4 or BC5 blocks",
        143 | 144 => "BC6H blocks",
        145 | 146 => "BC7 blocks",
        147..=156 => "ETC2 or EAC blocks",
        157..=184 => "ASTC blocks",
        _ => "",
    };
    if name.is_empty() { format!("VkFormat {format}") } else { format!("{name} (VkFormat {format})") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UASTC: &[u8] = include_bytes!("../../tests/streams/chequer_uastc.ktx2");
    const ETC1S: &[u8] = include_bytes!("../../tests/streams/chequer_etc1s.ktx2");

    #[test]
    fn both_block_formats_are_decoded() {
        for file in [UASTC, ETC1S] {
            let header = header(file).unwrap();
            assert_eq!((header.width, header.height), (32, 16));
            let texels = decode(file).unwrap();
            assert_eq!((texels.len(), texels[0], texels[4]), (512, [233, 200, 125, 255], [59, 92, 142, 255]));
        }
        // Zstandard decompresses 8 x 4 blocks of 16 bytes in addition to the 512 texels.
        assert_eq!(header(UASTC).unwrap().decoded_bytes, 512 * 4 + 32 * 16);
        assert_eq!(header(ETC1S).unwrap().decoded_bytes, 512 * 4);
    }

    #[test]
    fn red_and_green_are_restored_from_colour_and_alpha() {
        // Channel type of the first sample: 3 is RGB, 5 is red and green.
        let mut file = UASTC.to_vec();
        let descriptor = u32::from_le_bytes(file[48..52].try_into().unwrap()) as usize;
        file[descriptor + 31] = (file[descriptor + 31] & 0xf0) | 5;
        assert_eq!(decode(&file).unwrap()[0], [233, 255, 0, 255]);
    }

    #[test]
    fn invalid_headers_are_errors() {
        let header_error = |offset: usize, value: u32| {
            let mut file = UASTC.to_vec();
            file[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
            header(&file).unwrap_err()
        };
        assert!(header_error(12, 37).contains("only Basis Universal"), "R8G8B8A8");
        assert!(header_error(20, 0).contains("not a 2D image"));
        assert!(header_error(36, 6).contains("6 faces"));
        assert!(header_error(40, 0).contains("0 levels"));
        // The first level decompresses to more than its blocks, or lies past the end.
        assert!(header_error(80 + 16, 1 << 30).contains("decompresses its first level"));
        assert!(header_error(80 + 8, 1 << 20).contains("truncated"));
        for length in 0..UASTC.len() {
            assert!(decode(&UASTC[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn corrupted_files_are_errors_without_panics() {
        // A fixed pseudo-random sequence decides which bytes are corrupted.
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize
        };
        for file in [UASTC, ETC1S] {
            for _ in 0..2000 {
                let mut bytes = file.to_vec();
                for _ in 0..=next() % 4 {
                    let index = next() % bytes.len();
                    bytes[index] = next() as u8;
                }
                if let Err(why) = decode(&bytes) {
                    assert!(why != PANICKED, "{:?}", &bytes[..80]);
                }
            }
        }
    }

    #[test]
    fn other_formats_are_refused_by_name() {
        for (format, name) in
            [(43, "R8G8B8A8_SRGB"), (145, "BC7"), (97, "R16G16B16A16_SFLOAT"), (999, "VkFormat 999")]
        {
            let mut file = UASTC.to_vec();
            file[12..16].copy_from_slice(&u32::to_le_bytes(format));
            let why = header(&file).unwrap_err();
            assert!(why.contains(name) && why.contains("PNG"), "{why}");
        }
    }
}
