//! Entries of images: texels, and mip levels of one encoding.

use std::io;

use crate::scene::{Encoding, Image, MipLevel, Texels, mip_sizes};

use super::entry::{BLOCK_BYTES, EntryReader, EntryWriter, file_bytes};
use super::{AssetCache, SourceKey};

/// Images with fewer bytes are decoded faster than a file is opened.
const LEAST_BYTES: u64 = 1 << 18;

/// Size of an image, and whether its channels have sixteen bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ImageShape {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) is_deep: bool,
}

impl ImageShape {
    /// The shape of an image.
    pub(crate) fn of(image: &Image) -> Self {
        let is_deep = matches!(image.texels, Texels::Rgba16(_));
        Self { width: image.width, height: image.height, is_deep }
    }

    /// The key of an encoded image of this shape; `None` where it is too small to be kept.
    pub(crate) fn key_of(self, encoded: &[u8]) -> Option<SourceKey> {
        (self.bytes() >= LEAST_BYTES).then(|| SourceKey::of(encoded))
    }

    /// The same with another size.
    fn with_size(self, (width, height): (u32, u32)) -> Self {
        Self { width, height, ..self }
    }

    fn texels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    fn bytes(self) -> u64 {
        self.texels() * if self.is_deep { 8 } else { 4 }
    }

    fn is_that_of(self, texels: &Texels) -> bool {
        match texels {
            Texels::Rgba8(texels) => !self.is_deep && texels.len() as u64 == self.texels(),
            Texels::Rgba16(texels) => self.is_deep && texels.len() as u64 == self.texels(),
        }
    }
}

impl AssetCache {
    /// The texels of an image, where they are kept.
    pub(crate) fn texels(&self, key: SourceKey, shape: ImageShape) -> Option<Texels> {
        let entry = self.entry(&key.entry("texels"), file_bytes([shape.bytes()]));
        self.counted(entry.and_then(|mut entry| read_texels(&mut entry, shape)))
    }

    /// Keeps the texels of an image.
    pub(crate) fn store_texels(&self, key: SourceKey, shape: ImageShape, texels: &Texels) {
        if shape.is_that_of(texels) {
            let bytes = file_bytes([shape.bytes()]);
            self.store(&key.entry("texels"), bytes, |entry| write_texels(entry, texels));
        }
    }

    /// The mip levels of an image, where they are kept.
    pub(crate) fn mip_levels(
        &self,
        key: SourceKey,
        shape: ImageShape,
        encoding: Encoding,
    ) -> Option<Vec<MipLevel>> {
        let shapes = level_shapes(shape);
        let bytes = file_bytes(shapes.iter().map(|shape| shape.bytes()));
        let levels = self.entry(&key.entry(levels_name(encoding)), bytes).and_then(|mut entry| {
            let level = |shape: ImageShape| {
                let ImageShape { width, height, .. } = shape;
                Some(MipLevel { width, height, texels: read_texels(&mut entry, shape)? })
            };
            shapes.into_iter().map(level).collect()
        });
        self.counted(levels)
    }

    /// Keeps the mip levels of an image.
    pub(crate) fn store_mip_levels(
        &self,
        key: SourceKey,
        shape: ImageShape,
        (encoding, levels): (Encoding, &[MipLevel]),
    ) {
        let shapes = level_shapes(shape);
        let is_whole = shapes.len() == levels.len()
            && shapes.iter().zip(levels).all(|(shape, level)| shape.is_that_of(&level.texels));
        if is_whole {
            let bytes = file_bytes(shapes.iter().map(|shape| shape.bytes()));
            self.store(&key.entry(levels_name(encoding)), bytes, |entry| {
                levels.iter().try_for_each(|level| write_texels(entry, &level.texels))
            });
        }
    }
}

fn level_shapes(shape: ImageShape) -> Vec<ImageShape> {
    mip_sizes((shape.width, shape.height)).map(|size| shape.with_size(size)).collect()
}

fn levels_name(encoding: Encoding) -> &'static str {
    match encoding {
        Encoding::Srgb => "srgb levels",
        Encoding::CoveredSrgb => "covered srgb levels",
        Encoding::Normal => "normal levels",
        Encoding::Linear => "linear levels",
    }
}

fn write_texels(entry: &mut EntryWriter<'_>, texels: &Texels) -> io::Result<()> {
    match texels {
        Texels::Rgba8(texels) => {
            texels.as_flattened().chunks(BLOCK_BYTES).try_for_each(|block| entry.block(block))
        }
        Texels::Rgba16(texels) => texels.as_flattened().chunks(BLOCK_BYTES / 2).try_for_each(|channels| {
            let block: Vec<u8> = channels.iter().flat_map(|channel| channel.to_le_bytes()).collect();
            entry.block(&block)
        }),
    }
}

fn read_texels(entry: &mut EntryReader, shape: ImageShape) -> Option<Texels> {
    let count = usize::try_from(shape.texels()).ok()?;
    if !shape.is_deep {
        let mut texels = vec![[0; 4]; count];
        for block in texels.as_flattened_mut().chunks_mut(BLOCK_BYTES) {
            entry.block(block)?;
        }
        return Some(Texels::Rgba8(texels));
    }
    let mut texels = vec![[0; 4]; count];
    let mut bytes = vec![0; BLOCK_BYTES];
    for channels in texels.as_flattened_mut().chunks_mut(BLOCK_BYTES / 2) {
        let block = &mut bytes[..channels.len() * 2];
        entry.block(block)?;
        for (channel, bytes) in channels.iter_mut().zip(block.as_chunks::<2>().0) {
            *channel = u16::from_le_bytes(*bytes);
        }
    }
    Some(Texels::Rgba16(texels))
}
