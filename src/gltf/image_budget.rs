//! Image memory budget: total size of all images and mip maps, estimated from headers before any image is decoded.

use super::context::Context;
use super::encoded_image::{EncodedImage, in_quotes};
use super::texture::TextureTable;
use crate::error::{Result, over_limit, readable_bytes};
use crate::image_file::ImageHeader;
use crate::scene::{Encoding, ImageIndex, mip_bytes, mip_working_bytes};

/// Peak memory while images are decoded and their mip maps are computed, in the order of `uses`, bytes. An image with
/// unknown alpha is assumed to have none.
fn peak_bytes(headers: &[ImageHeader], uses: impl IntoIterator<Item = (ImageIndex, Encoding)>) -> u64 {
    let mut kept: u64 = headers.iter().fold(0, |sum, header| sum.saturating_add(header.decoded_bytes));
    let mut peak = kept;
    for (index, encoding) in uses {
        let Some(header) = headers.get(index.index()) else { continue };
        if encoding != Encoding::CoveredSrgb {
            let working = mip_working_bytes(header.width, header.height);
            kept = kept.saturating_add(mip_bytes(header.width, header.height, header.texel_bytes));
            peak = peak.max(kept.saturating_add(working));
        }
    }
    peak
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

/// Refuses images that do not fit into memory. The message gives their total and names the largest.
pub(super) fn check(context: &Context, images: &[EncodedImage<'_>], textures: &TextureTable) -> Result<()> {
    let headers: Vec<ImageHeader> = images.iter().map(|image| image.header).collect();
    let uses = || textures.uses.iter().copied();
    let needed = peak_bytes(&headers, uses());
    if needed <= context.remaining_bytes() {
        return Ok(());
    }
    let sizes = (0..images.len()).map(|index| image_bytes(&headers, index, uses()));
    // Of images of equal size the first is named.
    let largest = images.iter().zip(sizes).rev().max_by_key(|(_, bytes)| *bytes);
    let Some((largest, largest_bytes)) = largest else { return Ok(()) };
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
        "{all} {} with mip maps{others}, the largest is {}{} with {} ({}x{} texels); the total is {}; use smaller images or \
         raise `max_memory`",
        readable_bytes(needed.into()),
        largest.pointer,
        in_quotes(largest.name.as_deref()),
        readable_bytes(largest_bytes.into()),
        largest.header.width,
        largest.header.height,
        over_limit(total.into(), context.limit_bytes().into()),
    );
    Err(context.refused("", message))
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
        assert_eq!(peak_bytes(&headers, []), 20 * 67_108_864);
        let uses = || (0..20).map(|index| (ImageIndex(index), Encoding::Linear));
        assert_eq!(peak_bytes(&headers, uses()), 20 * (67_108_864 + levels * 4) + levels * 16);
        assert_eq!(image_bytes(&headers, 3, uses()), 89_478_484);
    }

    #[test]
    fn each_encoding_has_its_own_mip_maps() {
        let uses =
            [Encoding::Srgb, Encoding::CoveredSrgb, Encoding::Normal].map(|use_| (ImageIndex(0), use_));
        let levels = 5_592_405_u64;
        assert_eq!(peak_bytes(&[LARGE], uses), 67_108_864 + 2 * levels * 4 + levels * 16);
        let deep = ImageHeader { width: 2, height: 1, texel_bytes: 8, decoded_bytes: 16 };
        assert_eq!(peak_bytes(&[deep], [(ImageIndex(0), Encoding::Linear)]), 16 + 8 + 16);
        assert_eq!(peak_bytes(&[], uses), 0);
    }
}
