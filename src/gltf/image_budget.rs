//! Image memory budget: total size of all images and mip maps, estimated from headers before any image is decoded.

use super::context::Context;
use super::encoded_image::{EncodedImage, in_quotes};
use super::texture::TextureTable;
use crate::error::{Result, over_limit, readable_bytes};
use crate::image_file::ImageHeader;
use crate::scene::{Encoding, ImageIndex, mip_bytes, mip_working_bytes};

/// Memory of images with their mip maps in the order of `uses`. An image with unknown alpha is assumed to have none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct ImageMemory {
    /// Texels of all levels, bytes.
    kept: u64,
    /// Most bytes while images are decoded and their mip maps are computed.
    peak: u64,
}

impl ImageMemory {
    /// `decoders` images are decoded at once, each to a copy of the texels. Freed copies do not always return to the system before the
    /// mip maps are computed.
    fn of(
        headers: &[ImageHeader],
        uses: impl IntoIterator<Item = (ImageIndex, Encoding)>,
        decoders: usize,
    ) -> Self {
        let total = |bytes: &[u64]| bytes.iter().fold(0, |sum: u64, bytes| sum.saturating_add(*bytes));
        let mut decoded: Vec<u64> = headers.iter().map(|header| header.decoded_bytes).collect();
        decoded.sort_unstable_by(|a, b| b.cmp(a));
        let copies = total(decoded.get(..decoders).unwrap_or(&decoded));
        let mut kept = total(&decoded);
        let mut peak = kept.saturating_add(copies);
        for (index, encoding) in uses {
            let Some(header) = headers.get(index.index()) else { continue };
            if encoding != Encoding::CoveredSrgb {
                let working = mip_working_bytes(header.width, header.height);
                kept = kept.saturating_add(mip_bytes(header.width, header.height, header.texel_bytes));
                peak = peak.max(kept.saturating_add(working.max(copies)));
            }
        }
        Self { kept, peak }
    }
}

/// Bytes of the image `wanted` with its mip maps.
fn image_bytes(
    headers: &[ImageHeader],
    wanted: usize,
    uses: impl IntoIterator<Item = (ImageIndex, Encoding)>,
) -> u64 {
    let Some(header) = headers.get(wanted) else { return 0 };
    let uses = uses
        .into_iter()
        .filter(|(index, encoding)| index.index() == wanted && *encoding != Encoding::CoveredSrgb);
    let mips = mip_bytes(header.width, header.height, header.texel_bytes);
    uses.fold(header.decoded_bytes, |sum, _| sum.saturating_add(mips))
}

/// Counts the memory of images as the scene's, and returns what stays of it. Refuses images that do not fit; the message gives their total
/// and names the largest.
pub(super) fn count(
    context: &mut Context,
    images: &[EncodedImage<'_>],
    textures: &TextureTable,
) -> Result<u64> {
    let headers: Vec<ImageHeader> = images.iter().map(|image| image.header).collect();
    let uses = || textures.uses.iter().copied();
    let ImageMemory { kept, peak: needed } = ImageMemory::of(&headers, uses(), rayon::current_num_threads());
    if needed <= context.remaining_bytes() {
        let used_before = context.used_bytes();
        context.charge(needed, "")?;
        context.release_temporaries(used_before, 0);
        context.keep(kept);
        return Ok(kept);
    }
    let sizes = (0..images.len()).map(|index| image_bytes(&headers, index, uses()));
    // Of images of equal size the first is named.
    let largest = images.iter().zip(sizes).rev().max_by_key(|(_, bytes)| *bytes);
    let Some((largest, largest_bytes)) = largest else { return Ok(0) };
    let others = match context.used_bytes() {
        0 => String::new(),
        used => format!(" in addition to {} for other data", readable_bytes(used.into())),
    };
    let all = match images.len() {
        1 => "1 image needs".to_owned(),
        count => format!("{count} images need"),
    };
    let total = needed.saturating_add(context.used_bytes());
    let message = format!(
        "{all} {} with mip maps{others}, the largest is {}{} with {} ({}x{} texels); the total is {}",
        readable_bytes(needed.into()),
        largest.pointer,
        in_quotes(largest.name.as_deref()),
        readable_bytes(largest_bytes.into()),
        largest.header.width,
        largest.header.height,
        over_limit(total.into(), context.limit_bytes().into()),
    );
    Err(context.over_memory("", message, Some("use smaller images")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LARGE: ImageHeader =
        ImageHeader { width: 4096, height: 4096, texel_bytes: 4, decoded_bytes: 67_108_864 };

    #[test]
    fn twenty_large_images_have_a_known_size() {
        // 4096² texels of 4 bytes. Mip maps of 4^11 + … + 1 = (4^12 − 1) / 3 texels, with 16 temporary bytes each.
        let levels = 5_592_405_u64;
        let headers = [LARGE; 20];
        let memory = |kept, peak| ImageMemory { kept, peak };
        assert_eq!(ImageMemory::of(&headers, [], 0), memory(20 * 67_108_864, 20 * 67_108_864));
        let uses = || (0..20).map(|index| (ImageIndex(index), Encoding::Linear));
        let kept = 20 * (67_108_864 + levels * 4);
        // The mip maps of an image take 89 MB while they are computed, more than a decoder's copy of 67 MB and less than two.
        assert_eq!(ImageMemory::of(&headers, uses(), 1), memory(kept, kept + levels * 16));
        assert_eq!(ImageMemory::of(&headers, uses(), 2), memory(kept, kept + 2 * 67_108_864));
        assert_eq!(ImageMemory::of(&headers, [], 64), memory(20 * 67_108_864, 40 * 67_108_864));
        assert_eq!(image_bytes(&headers, 3, uses()), 89_478_484);
    }

    #[test]
    fn each_encoding_has_its_own_mip_maps() {
        let uses =
            [Encoding::Srgb, Encoding::CoveredSrgb, Encoding::Normal].map(|use_| (ImageIndex(0), use_));
        let levels = 5_592_405_u64;
        let peak =
            |headers: &[ImageHeader], uses: &[_]| ImageMemory::of(headers, uses.iter().copied(), 1).peak;
        assert_eq!(peak(&[LARGE], &uses), 67_108_864 + 2 * levels * 4 + levels * 16);
        let deep = ImageHeader { width: 2, height: 1, texel_bytes: 8, decoded_bytes: 16 };
        assert_eq!(peak(&[deep], &[(ImageIndex(0), Encoding::Linear)]), 16 + 8 + 16);
        assert_eq!(peak(&[], &uses), 0);
    }
}
