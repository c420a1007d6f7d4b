//! Headers in which long attributes are replaced by their hashes: enough to compare tiles, many of which are planned at a time.

use sha2::{Digest as _, Sha256};

use super::exr_attributes::SAMPLE_RANGE;
use super::exr_header::ExrHeader;

/// Most bytes of an attribute that is kept, with its type. Manifests of Cryptomattes have megabytes.
const MOST_KEPT_BYTES: usize = 1024;
/// What a hash begins with in place of the type, which no other attribute has.
const HASHED: &[u8] = b"rayframe sha256\0";

impl ExrHeader {
    /// The same header with the hash of each long attribute in its place, which is no text anymore. Equal for equal headers only.
    #[must_use]
    pub(super) fn condensed(mut self) -> Self {
        for (name, value) in &mut self.attributes {
            // What tells which samples a file has is read, however long.
            if value.len() > MOST_KEPT_BYTES && name != SAMPLE_RANGE {
                *value = [HASHED, &Sha256::digest(&*value)[..]].concat();
            }
        }
        self
    }

    /// Whether the file of `condensed`, the header of a tile, is of the same image: the same shared attributes and the same channels but for those
    /// of sums.
    pub fn is_same_image(&self, condensed: &Self) -> bool {
        let header = self.clone().condensed();
        let [mut ours, mut theirs] = [header.shared(), condensed.shared()];
        ours.remove("channels");
        theirs.remove("channels");
        ours == theirs && header.channels_without_sums().eq(condensed.channels_without_sums())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Channel, ColorEncoding, Image, PixelWindow, RenderedScene, Samples};
    use crate::image_file::{ExrCompression, FrameAttributes, encode_exr};

    fn header(texts: &[(&str, &str)]) -> ExrHeader {
        let image = Image {
            display_window: PixelWindow::full(1, 1),
            data_window: PixelWindow::full(1, 1),
            encoding: ColorEncoding::Linear,
            scene: RenderedScene::default(),
            channels: vec![Channel { name: "R".to_owned(), samples: Samples::Float(vec![1.0]) }],
        };
        let texts = texts.iter().map(|&(name, text)| (name.to_owned(), text.to_owned())).collect();
        let attributes = FrameAttributes { texts, ..FrameAttributes::unknown() };
        let bytes = encode_exr(image, ExrCompression::None, &attributes).unwrap();
        ExrHeader::parse(&mut bytes.as_slice()).unwrap()
    }

    #[test]
    fn long_attributes_are_compared_by_their_hashes() {
        let long = "n".repeat(1 << 20);
        let other = format!("{}m", &long[1..]);
        let whole = header(&[("names", &long), ("short", "text")]);
        let condensed = whole.clone().condensed();
        assert_eq!(condensed.clone().condensed(), condensed);
        assert_eq!(condensed.text("short").as_deref(), Some("text"));
        assert_eq!(condensed.text("names"), None);
        assert!(condensed.shared().into_values().map(<[u8]>::len).sum::<usize>() < 4096);

        assert!(whole.is_same_image(&condensed));
        assert!(!header(&[("names", &other), ("short", "text")]).is_same_image(&condensed));
        assert!(!header(&[("names", &long), ("short", "texts")]).is_same_image(&condensed));
        assert_ne!(header(&[("names", &other), ("short", "text")]).condensed(), condensed);
    }

    #[test]
    fn sample_ranges_are_kept_however_long() {
        let long = "0".repeat(5000);
        let condensed = header(&[(SAMPLE_RANGE, &long)]).condensed();
        assert_eq!(condensed.text(SAMPLE_RANGE), Some(long));
    }
}
